"""Case files as the netCDF library reads them, opened only when they are whole."""

from __future__ import annotations

from collections.abc import Hashable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from os import PathLike
from pathlib import Path
from typing import TYPE_CHECKING, Any

import netCDF4
import numpy as np
from numpy.typing import NDArray

import fretwear
from fretwear.data.errors import CaseFileError
from fretwear.data.seal import damage
from fretwear.data.variables import CASE_DIMS, CYCLE

if TYPE_CHECKING:
    from fretwear.study.case import Case

HISTORY_GROUP = "history"
COMPLETE = "complete"

_CHECK_NAME = "Check the name, or run the case"
_CHECK_KIND = "Check the name: the files of the cases lie in the folder cases/ of a study's results"
_RUN_AGAIN = "Remove the file and run the case again"
# What is no netCDF-4 file may be precious, a study file for example: nothing is to be removed.
_CHECK_FIRST = "Check the name; if it is what is left of a case file, run the case again"
_SIGNATURE = b"\x89HDF\r\n\x1a\n"
_NOT_NETCDF = "it is no netCDF-4 file, which case files are"


@dataclass(frozen=True)
class CaseFile:
    """A case file that is whole, and open.

    Attributes
    ----------
    path : pathlib.Path
        The file.
    file : netCDF4.Dataset
        The open file.
    """

    path: Path
    file: netCDF4.Dataset

    def attribute(self, name: str) -> str:
        """A global attribute."""
        return str(self.file.getncattr(name))

    def read(self, name: str, index: Any = np.s_[...]) -> NDArray[Any]:
        """Read a variable or a part of it.

        Parameters
        ----------
        name : str
            Name of the variable.
        index : slice, int or tuple of these
            The part, along the dimensions of the variable.
        """
        return np.asarray(self.file[name][index])

    def unusable(self, problem: str) -> CaseFileError:
        """Return the error that says why the file cannot be used."""
        return CaseFileError(self.path, problem, _RUN_AGAIN)


@contextmanager
def opened_case(path: str | PathLike[str]) -> Iterator[CaseFile]:
    """Open a case file after checking that it is whole, which reads it once.

    Raises
    ------
    CaseFileError
        When the file is missing, unfinished, cut short, damaged or no case file.
    """
    path = Path(path)
    if problem := damage(path, "case file"):
        remedy = _remedy(path)
        raise CaseFileError(path, _NOT_NETCDF if remedy == _CHECK_FIRST else problem, remedy)
    try:
        file = netCDF4.Dataset(path, "r")
    except (OSError, RuntimeError) as cause:
        raise CaseFileError(path, f"it is no netCDF file ({cause})", _RUN_AGAIN) from cause
    with file:
        file.set_auto_mask(False)
        case_file = CaseFile(path, file)
        if "case_id" not in file.ncattrs():
            raise CaseFileError(path, "it is not the file of one case", _CHECK_KIND)
        if COMPLETE not in file.ncattrs() or file.getncattr(COMPLETE) != 1:
            raise case_file.unusable("the run that wrote it did not finish")
        lacking = missing_variables({name: v.dimensions for name, v in file.variables.items()})
        lacking += [HISTORY_GROUP] if HISTORY_GROUP not in file.groups else []
        if lacking:
            raise case_file.unusable(f"it lacks {', '.join(lacking)}")
        yield case_file


def is_finished_case(path: str | PathLike[str], case: Case) -> bool:
    """Say whether a file is there that a run of this case by this version would write again.

    The file is read once to compare it with its checksum.
    """
    if not Path(path).exists():
        return False
    try:
        with opened_case(path) as file:
            version = file.attribute("source").split(" (")[0]
            same = file.attribute("case_id") == case.case_id
            cycles = file.read(CYCLE.name)
    except CaseFileError:
        return False
    is_of_version = version == f"fretwear {fretwear.__version__}"
    return same and is_of_version and np.array_equal(cycles, case.output_cycles)


def _remedy(path: Path) -> str:
    if not path.is_file():
        return _CHECK_NAME
    try:
        with path.open("rb") as stream:
            begins = stream.read(len(_SIGNATURE))
    except OSError:
        return _CHECK_NAME
    return _RUN_AGAIN if begins == _SIGNATURE else _CHECK_FIRST


def missing_variables(dims: Mapping[Hashable, tuple[Hashable, ...]]) -> list[str]:
    """Name the variables of a case that are not there with the right dimensions.

    Parameters
    ----------
    dims : mapping
        Name and dimensions of the variables that are there.
    """
    return [name for name, expected in CASE_DIMS.items() if dims.get(name) != expected]
