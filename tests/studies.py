"""Studies run and merged without the workflow, for tests that share their results."""

from collections.abc import Iterable
from pathlib import Path

from fretwear.data.files import write_case
from fretwear.data.merge import merge_study
from fretwear.running.simulate import run
from fretwear.study.study import Study


def run_study(study: Study, folder: Path, case_ids: Iterable[str] | None = None) -> None:
    """Run the cases of a study, or some of them, and merge them into a folder of results."""
    for case_id in study.cases() if case_ids is None else case_ids:
        result = run(study.cases()[case_id])
        write_case(result.dataset, result.history, folder / "cases" / f"{case_id}.nc")
    merge_study(study, folder / "cases", folder / "summary.nc")
