"""Choosing one case of a study, and changing it."""

from __future__ import annotations

import difflib
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from fretwear.study.case import Case
from fretwear.study.file import Study, check_content, load_study
from fretwear.study.override import override
from fretwear.study.points import Point
from fretwear.study.problems import Problem, StudyError

_LISTED = 5


def select_case(
    path: str | Path, case_id: str | None = None, assignments: Sequence[str] = ()
) -> Case:
    """Return one case of a study file, changed by assignments if there are any.

    Parameters
    ----------
    path : str or Path
        The study file.
    case_id : str or None
        Id of the case in the study as it stands, or the beginning of just one id.  None: the
        study, with the assignments applied, must come to a single case.
    assignments : sequence of str
        Changes ``name=value``; a case chosen by its id is changed after it was chosen.

    Raises
    ------
    StudyError
        The study or the changed case is not sound, or there is no such case.
    """
    if case_id is None:
        study = load_study(path, assignments)
        return _only_case(study)
    study = load_study(path)
    chosen = _chosen_point(study, case_id)
    if not assignments:
        assert chosen.case is not None
        return chosen.case
    content, problems = override(_content_at(study, chosen), assignments)
    return _only_case(check_content(study.file, content, problems, assignments=assignments))


def _chosen_point(study: Study, case_id: str) -> Point:
    points = {point.id: point for point in study.points() if point.case is not None}
    found = [name for name in points if name.startswith(case_id)]
    if case_id in points:
        return points[case_id]
    if len(found) == 1:
        return points[found[0]]
    problem = _ambiguous(case_id, found) if found else _no_such_case(case_id, list(points))
    raise StudyError(study.file, [problem])


def _only_case(study: Study) -> Case:
    cases = study.cases()
    if len(cases) == 1:
        return next(iter(cases.values()))
    rule = f"has {len(cases)} cases, and one must be chosen"
    hint = f"give --case ID, one of{_listed(list(cases))}"
    raise StudyError(study.file, [Problem("", "", rule, hint)])


def _listed(ids: Sequence[str]) -> str:
    more = [f"and {len(ids) - _LISTED} more"] if len(ids) > _LISTED else []
    return "".join(f"\n    {line}" for line in [*ids[:_LISTED], *more])


def _ambiguous(case_id: str, found: Sequence[str]) -> Problem:
    rule = f"is the beginning of {len(found)} ids"
    return Problem("--case", case_id, rule, f"give more of it, to choose one of{_listed(found)}")


def _no_such_case(case_id: str, ids: Sequence[str]) -> Problem:
    near = difflib.get_close_matches(case_id, ids, n=1, cutoff=0.6)
    hint = f"did you mean {near[0]!r}?" if near else "fretwear plan lists the cases"
    return Problem("--case", case_id, f"is none of the {len(ids)} cases of this study", hint)


def _content_at(study: Study, point: Point) -> dict[str, Any]:
    """Return the content of the file with one value for everything: that of the point."""
    content = {name: part for name, part in study.content.items() if name not in ("vary", "design")}
    base = dict(content.get("base", {}))
    written = [
        (axis.name, axis.written[position])
        for axis, position in zip(study.axes, point.index, strict=True)
    ]
    for name, value in written:
        whole, _, part = name.partition(".")
        base[whole] = {**base.get(whole, {}), part: value} if part else value
    content["base"] = base
    return content
