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
        Id of the case in the study as it stands.  None: the study, with the assignments
        applied, must come to a single case.
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
    chosen = next((point for point in study.points() if point.id == case_id), None)
    if chosen is None or chosen.case is None:
        raise StudyError(study.file, [_no_such_case(case_id, study)])
    if not assignments:
        return chosen.case
    content, problems = override(_content_at(study, chosen), assignments)
    return _only_case(check_content(study.file, content, problems, assignments=assignments))


def _only_case(study: Study) -> Case:
    cases = study.cases()
    if len(cases) == 1:
        return next(iter(cases.values()))
    listed = "\n    ".join(list(cases)[:_LISTED])
    more = f"\n    and {len(cases) - _LISTED} more" if len(cases) > _LISTED else ""
    rule = f"has {len(cases)} cases, and one must be chosen"
    raise StudyError(
        study.file, [Problem("", "", rule, f"give --case ID, one of\n    {listed}{more}")]
    )


def _no_such_case(case_id: str, study: Study) -> Problem:
    ids = list(study.cases())
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
