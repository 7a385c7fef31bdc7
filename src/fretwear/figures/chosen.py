"""Choose the few cases whose profiles stand for a study."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import xarray as xr

from fretwear.figures.grouping import Line, Value, study_lines
from fretwear.figures.wording import symbol_text, words_text

_PREFERRED = ("roughness_amplitude", "roughness", "plastic_limit", "slip_model")
_MOST_CONTRASTS = 2
# Slip that does not follow the worn shape is for comparison: where there is a choice, not shown.
_SIMPLIFIED = ("slip_model", "cattaneo_mindlin")


@dataclass(frozen=True)
class ChosenCases:
    """Cases that differ in at most two names and agree, where possible, in the others.

    Parameters
    ----------
    contrasts : tuple of str
        The names in which the cases differ.
    ids : mapping of str to str
        Case ids by title, as ``smooth, elastic``.
    common : str
        The values that all of them have of the study's other varied names, in words.
    """

    contrasts: tuple[str, ...]
    ids: dict[str, str]
    common: str


def choose_cases(summary: xr.Dataset) -> ChosenCases:
    """Choose up to four finished cases of a merged study.

    They span the extremes of roughness amplitude and plastic limit, or of the first two other
    names if the study does not vary these. All other names have their last value for which all
    of the cases are done, or as many as possible; the slip model has the one that follows the
    worn shape.

    Parameters
    ----------
    summary : xarray.Dataset
        A merged study, with the case ids in ``case_id``.

    Returns
    -------
    ChosenCases
        The same ones whenever the study is the same.

    Raises
    ------
    ValueError
        When no point is done.
    """
    lines = study_lines(summary, "wear_volume")
    if not lines:
        raise ValueError("No point of the study is done: there is no case to choose.")
    varied = _varied(lines)
    contrasts = tuple(
        [name for name in _PREFERRED if name in varied]
        + [name for name in varied if name not in _PREFERRED]
    )[:_MOST_CONTRASTS]
    others = [name for name in varied if name not in contrasts]
    best = _fullest_group(lines, contrasts, others)
    ids = {
        ", ".join(symbol_text(name, line.values[name]) for name in contrasts) or "the case": str(
            summary["case_id"].isel(line.point).item()
        )
        for line in best
    }
    agreed = [name for name in others if len({line.values[name] for line in best}) == 1]
    common = ", ".join(words_text(name, best[0].values[name]) for name in agreed)
    return ChosenCases(contrasts, ids, common)


def _varied(lines: Sequence[Line]) -> list[str]:
    names = list(lines[0].values)
    return [name for name in names if len({line.values[name] for line in lines}) > 1]


def _fullest_group(
    lines: Sequence[Line], contrasts: Sequence[str], others: Sequence[str]
) -> list[Line]:
    """Return the extreme lines of the group with most of them.

    Of several such groups: one whose slip follows the worn shape, and of these the last.

    Points drawn at random make no group; then those of least and most wear are taken.
    """
    wanted = [_extremes([line.values[name] for line in lines]) for name in contrasts]
    groups: dict[tuple[Value, ...], list[Line]] = {}
    for line in lines:
        if all(line.values[name] in ends for name, ends in zip(contrasts, wanted, strict=True)):
            groups.setdefault(tuple(line.values[name] for name in others), []).append(line)
    best = max(
        reversed(list(groups.values())),
        key=lambda group: (len(group), group[0].values.get(_SIMPLIFIED[0]) != _SIMPLIFIED[1]),
        default=[],
    )
    if len(best) == 1 < len(lines) or not best:
        by_wear = sorted(lines, key=lambda line: float(np.nanmax(line.quantity)))
        return [by_wear[0], by_wear[-1]]
    return best


def _extremes(values: Sequence[Value]) -> tuple[Value, Value]:
    unique = list(dict.fromkeys(values))
    ordered = unique if any(isinstance(value, str) for value in unique) else sorted(unique)
    return ordered[0], ordered[-1]
