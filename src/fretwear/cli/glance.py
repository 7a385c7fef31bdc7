"""What ``fretwear show`` tells: of one case, or of a merged study."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any, Protocol

import netCDF4

from fretwear.cli.study_summary import StudySummary
from fretwear.cli.summary import CaseSummary
from fretwear.data.files import damage, open_case, open_history, open_summary


class Glance(Protocol):
    """What is to be told of a file."""

    def lines(self) -> Iterator[str]:
        """Yield lines for people."""

    def content(self) -> dict[str, Any]:
        """Return what JSON can hold, in SI units."""


@contextmanager
def glance_at(file: Path) -> Iterator[Glance]:
    """Open a file and see what is to be told of it.

    Raises
    ------
    fretwear.data.safe.DataFileError
        When it is neither a case file nor a merged study, or not whole.
    """
    if _is_merged_study(file):
        with open_summary(file) as summary:
            yield StudySummary(summary)
    else:
        with open_case(file) as case, open_history(file) as history:
            yield CaseSummary(case, history)


def _is_merged_study(file: Path) -> bool:
    # The library may crash on a file that is not whole: the checksum comes first.
    if damage(file, "file"):
        return False
    with netCDF4.Dataset(file) as content:
        return "study" in content.ncattrs()
