import copy
import errno
from pathlib import Path

import pytest

from fretwear.data.safe import CaseFileError, CaseFilesError, write_error


def test_an_error_names_the_file_the_problem_and_the_remedy():
    error = CaseFileError(Path("results/a.nc"), "it is damaged", "Run the case again")
    assert str(error) == "results/a.nc: it is damaged. Run the case again"


def test_several_errors_are_told_line_by_line():
    errors = [CaseFileError(Path(name), "it is damaged", "Run it") for name in ("a.nc", "b.nc")]
    both = CaseFilesError(errors)
    assert str(both) == "a.nc: it is damaged. Run it\nb.nc: it is damaged. Run it"
    assert both.path == Path("a.nc")


def test_errors_can_be_copied():
    one = CaseFileError(Path("a.nc"), "it is damaged", "Run it")
    for error in (one, CaseFilesError([one, one])):
        assert str(copy.copy(error)) == str(error)
        assert type(copy.copy(error)) is type(error)


@pytest.mark.parametrize(
    ("number", "words"),
    [
        (errno.ENOSPC, "the disk (or the quota on it) is full"),
        (errno.EDQUOT, "the disk (or the quota on it) is full"),
        (errno.EROFS, "may not be written to"),
        (errno.EACCES, "may not be written to"),
        (errno.ENOTDIR, "is not a folder"),
        (errno.EIO, "Check the free space, the quota and the disk"),
    ],
)
def test_why_a_file_was_not_written_is_said_in_words(tmp_path, number, words):
    error = write_error(tmp_path / "a.nc", OSError(number, "text of the system"))
    assert str(error).startswith(f"{tmp_path / 'a.nc'}: not written")
    assert words in str(error)
