"""The rules between parameters, tried at the points of a study."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import replace
from itertools import product

from fretwear.parts import required
from fretwear.problems import Problem, Problems
from fretwear.study.case import Case
from fretwear.study.members import Block
from fretwear.study.parameters import member_of, value_text
from fretwear.study.points import Combinations, Sampled
from fretwear.study.rules import RULES, Rule
from fretwear.study.setup import IN_BLOCKS, members
from fretwear.study.study import ALL_POINTS, Point, Study

_LISTED_PER_RULE = 8


def try_rules(
    study: Study,
    problems: Problems,
    *,
    skip: bool,
    points: tuple[int, int | None] = ALL_POINTS,
    visit: Callable[[Point], None] | None = None,
) -> None:
    """Check the rules between parameters; with `skip`, mark points that break one as invalid.

    A rule is tried once for each combination of the valid values that it needs, at `points` from a
    first to a last number. On the way, `visit`
    is called with each point that breaks none, in order, while its case exists; without `skip`, no
    longer than all points are valid.
    """
    defaulted = {*members(), "output_cycles"} - required(Case) - {a.member for a in study.axes}
    blocks = {"cycles"} if "blocks" in study.members else set()
    # Each rule with the axes that matter to it, and its problems by positions along these.
    trials: list[tuple[Rule, tuple[int, ...], dict[tuple[int, ...], Problem]]] = []
    for rule in RULES:
        needed = {member_of(name) for name in rule.needs}
        if needed <= {*study.members} | defaulted | blocks:
            by_blocks = needed & IN_BLOCKS.keys()
            of_blocks = {i for name in by_blocks for i in study.members[name][0]}
            relevant = tuple(
                i
                for i, axis in enumerate(study.axes)
                if {axis.member, axis.name} & rule.needs
                or (axis.name == "blocks" and i in of_blocks)
            )
            trials.append((rule, relevant, {}))
    every = tuple(range(len(study.axes)))
    some = {_tried_along(study, relevant): None for _, relevant, _ in trials}
    for axes in [*(axes for axes in some if axes != every), every]:
        together = [trial for trial in trials if _tried_along(study, trial[1]) == axes]
        before = [(relevant, broken) for _, relevant, broken in trials if broken]
        visited = (
            study.points(*points) if axes == every and visit and not (before and not skip) else ()
        )
        if not (together or visited):
            continue
        for number, index in enumerate(_combinations(study, axes, points)):
            # One case serves all of these rules, and is not kept.
            case, is_valid = study.case(index), True
            for rule, relevant, broken in together:
                if (problem := rule.find(case)) is not None:
                    broken[tuple([index[i] for i in relevant])] = problem
                    is_valid = False
            for relevant, broken in before if visited else ():
                is_valid = is_valid and tuple([index[i] for i in relevant]) not in broken
            if visited and visit and is_valid:
                visit(visited[number])
            elif not skip:
                visited = ()
    skipping = [
        (relevant, broken) for _, relevant, broken in trials if skip and relevant and broken
    ]
    for index in study.indices if skipping else ():
        for relevant, broken in skipping:
            if problem := broken.get(tuple([index[i] for i in relevant])):
                study.invalid.setdefault(index, problem.sentence)
    listed = not isinstance(study.design, Sampled)

    def gives(blocks: Sequence[Block] | None, name: str) -> bool:
        """Whether the first block gives the value, and nothing fixed does."""
        return name in dict(blocks[0].values if blocks else ()) and name not in study.fixed

    # By subject, then by rule and key: the problem at each combination of the other values.
    broken_rules: dict[str, dict[tuple[int, str], list[tuple[Problem, str]]]] = {}
    for trial, (_, relevant, broken) in enumerate(trials):
        for positions, problem in broken.items() if not (skip and relevant) else ():
            # The place in the file to mend, and the values at which the rule breaks.
            key = "output.cycles" if problem.key == "output_cycles" else f"base.{problem.key}"
            if gives(study.fixed.get("blocks"), problem.key):
                key = f"base.blocks[0].{problem.key}"
            others = []
            for axis, position in zip((study.axes[i] for i in relevant), positions, strict=True):
                at = f"[{position}]" if listed else ""
                if axis.key == problem.key:
                    key = f"vary.{axis.name}{at}"
                elif axis.name == "blocks" and gives(axis.values[position], problem.key):
                    key = f"vary.blocks{at}[0].{problem.key}"
                else:
                    drawn = value_text(axis.name, axis.values[position])
                    others.append(f"{axis.name} = {axis.labels[position] if listed else drawn}")
            placed = replace(problem, key=key), ", ".join(others)
            broken_rules.setdefault(problem.key, {}).setdefault((trial, key), []).append(placed)
    for subject, by_key in broken_rules.items():
        for (problem, at), *more in [*by_key.values()][:_LISTED_PER_RULE]:
            also = f", and at {len(more)} more combinations" if more[1:] else ""
            also = f", and at {more[0][1]}" if more and not more[1:] else also
            where = f" (at {at}{also})" if at else ""
            problems.append(replace(problem, rule=f"{problem.rule}{where}"))
        if (left := len(by_key) - _LISTED_PER_RULE) > 0:
            alike = f"is wrong in the same way for {left} more of the varied values"
            problems.add(f"vary ({subject})", None, alike)


def _tried_along(study: Study, relevant: tuple[int, ...]) -> tuple[int, ...]:
    """The axes along which a rule is tried, to which some of them matter."""
    is_grid = isinstance(study.design, Combinations)
    # Other designs hardly have two points alike along some axes.
    return relevant if is_grid or not relevant else tuple(range(len(study.axes)))


def _combinations(
    study: Study, axes: tuple[int, ...], points: tuple[int, int | None]
) -> Iterable[tuple[int, ...]]:
    """One point for each combination of positions along some axes, from a first to a last point."""
    first, last = points
    indices = study.indices[first - 1 : last]
    if not axes:
        return indices[:1]
    if len(axes) == len(study.axes):
        return indices
    if points != ALL_POINTS:
        tried = (tuple([p if i in axes else 0 for i, p in enumerate(at)]) for at in indices)
        return dict.fromkeys(tried)
    lengths = [len(axis.values) if i in axes else 1 for i, axis in enumerate(study.axes)]
    return product(*map(range, lengths))
