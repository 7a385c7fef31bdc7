"""Which points of a study the explorer holds, when it cannot hold them all."""

from __future__ import annotations

import math
from collections.abc import Collection, Sequence
from itertools import product

import numpy as np

from fretwear.study.plan import Plan


def chosen_points(plan: Plan, done: Collection[int], most: int) -> list[int]:
    """Choose points evenly, so that they span the study.

    A grid stays one: its axes are thinned, the longest first, and keep their ends, so that every
    combination of what is left is there.

    Parameters
    ----------
    plan : Plan
        The study's plan.
    done : collection of int
        Positions in ``plan.points`` of those that have results.
    most : int
        How many points at most, at least 1.

    Returns
    -------
    list of int
        Positions in ``plan.points``, increasing. All of them if they are not too many; with at
        least one that is done, if there is such a one.
    """
    count = len(plan.points)
    if count <= most:
        return list(range(count))
    if plan.study.design.kind == "grid":
        lengths = [len(axis.values) for axis in plan.study.axes]
        kept = set(product(*thinned_levels(lengths, most)))
        chosen = [place for place, planned in enumerate(plan.points) if planned.point.index in kept]
    else:
        chosen = evenly(count, most)
    if done and not set(done).intersection(chosen):
        finished = sorted(done)
        return [finished[place] for place in evenly(len(finished), most)]
    return chosen


def thinned_levels(lengths: Sequence[int], most: int) -> list[list[int]]:
    """Choose levels of every axis of a grid so that at most `most` combinations are left."""
    kept = list(lengths)
    while math.prod(kept) > most and max(kept) > 1:
        kept[kept.index(max(kept))] -= 1
    return [evenly(length, number) for length, number in zip(lengths, kept, strict=True)]


def evenly(count: int, most: int) -> list[int]:
    """Return at most `most` of the places 0 to `count` − 1, evenly spread, with both ends."""
    if count <= most:
        return list(range(count))
    return [int(place) for place in np.rint(np.linspace(0, count - 1, most))]
