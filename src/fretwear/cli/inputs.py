"""Whether a file may hold results: found out before anything heavy is imported."""

from __future__ import annotations

import difflib
from pathlib import Path

from fretwear.cli.status import refuse

_STUDY_FILES = (".yaml", ".yml")
_LISTED = 5
_WHERE = "the cases of a study lie in results/STUDY/cases/; fretwear run computes one"


def check_results(file: Path) -> None:
    """Leave with a hint where a file is not there or is something else than results."""
    if file.is_dir():
        found = sorted([*file.glob("*.nc"), *file.glob("cases/*.nc")])
        more = f" and {len(found) - _LISTED} more" if len(found) > _LISTED else ""
        names = "".join(f"\n    {name}" for name in found[:_LISTED])
        hint = f"; give one of its files, such as{names}{more}" if found else " without results"
        raise refuse(f"{file}: is a folder{hint}")
    if file.suffix in _STUDY_FILES and file.exists():
        raise refuse(
            f"{file}: is a study file, and no results\n"
            f"    fretwear plan {file} lists its cases, fretwear run computes them"
        )
    if not file.exists():
        near = difflib.get_close_matches(file.name, _names(file.parent), n=1, cutoff=0.7)
        hint = f"did you mean {str(file.with_name(near[0]))!r}?" if near else ""
        raise refuse(f"{file}: there is no such file\n    {hint or _WHERE}")


def _names(folder: Path) -> list[str]:
    try:
        return [path.name for path in folder.iterdir()]
    except OSError:
        return []
