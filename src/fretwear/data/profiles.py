"""Profiles along x on the line nearest y = 0, brought to positions that all cases share."""

from __future__ import annotations

import math
import tempfile
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Self

import numpy as np
from numpy.typing import NDArray

from fretwear.data.casefile import CaseFile
from fretwear.data.resampling import Resampling
from fretwear.data.variables import FIELDS, Field, X, Y

MOST_POSITIONS = 4096

_INTERPOLATED = (
    "on the line of cells nearest y = 0; between the cells of the case interpolated linearly"
)
_ZERO_OUTSIDE = "zero outside the window of the case, where the surfaces do not touch"
_UNKNOWN_OUTSIDE = "NaN outside the window of the case"


@dataclass(frozen=True)
class Profile:
    """A field along x on the line nearest y = 0.

    Attributes
    ----------
    name : str
        Name in a merged study.
    field : Field
        The field of the cases.
    """

    name: str
    field: Field

    @property
    def attributes(self) -> dict[str, str]:
        """CF attributes."""
        outside = _UNKNOWN_OUTSIDE if math.isnan(self.field.outside) else _ZERO_OUTSIDE
        comments = (self.field.comment, _INTERPOLATED, outside)
        return {
            "long_name": self.field.long_name,
            "units": self.field.units,
            "comment": "; ".join(comment for comment in comments if comment),
        }


_BY_NAME = {field.name: field for field in FIELDS}

PROFILES: tuple[Profile, ...] = (
    Profile("pressure_profile", _BY_NAME["pressure"]),
    Profile("shear_profile", _BY_NAME["shear_traction"]),
    Profile("gap_profile", _BY_NAME["gap"]),
    Profile("wear_profile", _BY_NAME["wear_depth"]),
    Profile("wear_rate_profile", _BY_NAME["wear_rate"]),
)


@dataclass(frozen=True)
class Reach:
    """How far and how finely cases are resolved along x.

    Attributes
    ----------
    spacing : float
        Finest grid spacing, m.
    length : float
        Distance in m from the middle to the end of the largest window.
    is_whole : bool
        Whether some case has x < 0 too.
    """

    spacing: float
    length: float
    is_whole: bool

    @classmethod
    def of_case(cls, x: NDArray[np.float64], is_whole: bool) -> Reach:
        """Reach of one case with cell centres `x` in m."""
        spacing = float(2.0 * x[0]) if not is_whole else float((x[-1] - x[0]) / (x.size - 1))
        return cls(spacing, float(x[-1]) + 0.5 * spacing, is_whole)

    def joined(self, other: Reach) -> Reach:
        """Reach of both."""
        return Reach(
            min(self.spacing, other.spacing),
            max(self.length, other.length),
            self.is_whole or other.is_whole,
        )

    def positions(self) -> NDArray[np.float64]:
        """Return positions in m that serve all cases.

        They are centres of cells as fine as the finest case's, to the end of the largest window:
        where all cases have one spacing, these are their own cells and nothing is interpolated.
        Above `MOST_POSITIONS` on a side the spacing is as fine as that many allow.
        """
        # The margin keeps a division's last bit from adding a cell.
        number = math.ceil(self.length / self.spacing * (1.0 - 1e-9))
        spacing = self.spacing
        if number > MOST_POSITIONS:
            number, spacing = MOST_POSITIONS, self.length / MOST_POSITIONS
        x = (np.arange(number, dtype=np.float64) + 0.5) * spacing
        return np.concatenate([-x[::-1], x]) if self.is_whole else x


@dataclass(frozen=True)
class CaseProfiles:
    """The profiles of a case in its own cells.

    Attributes
    ----------
    x : numpy.ndarray, shape (n,)
        Cell centres in m.
    values : numpy.ndarray, shape (nprofiles, ncycles, n)
        The profiles, float32, in the order of `PROFILES`.
    """

    x: NDArray[np.float64]
    values: NDArray[np.float32]

    @classmethod
    def read(cls, case_file: CaseFile, snapshots: NDArray[np.intp]) -> CaseProfiles:
        """Take the profiles of a case at some of its snapshots."""
        row = int(np.abs(case_file.read(Y.name)).argmin())
        fields = [case_file.read(each.field.name, np.s_[:, :, row])[snapshots] for each in PROFILES]
        return cls(case_file.read(X.name), np.stack(fields))

    def at(self, positions: NDArray[np.float64]) -> dict[str, NDArray[np.float32]]:
        """Bring the profiles to positions in m; by name, shape (ncycles, npositions)."""
        along_x = Resampling(self.x, positions)
        profiles = {}
        for profile, own in zip(PROFILES, self.values, strict=True):
            values = along_x.linear(own, axis=1)
            values[:, along_x.is_outside] = profile.field.outside
            profiles[profile.name] = values
        return profiles


class ProfileSpool:
    """Profiles of many cases, kept on disk until it is known which positions serve them all.

    Used as a context: opening a case file once more would take longer than anything else.

    Parameters
    ----------
    folder : path-like
        Where the profiles are kept meanwhile, in a file without a name.
    """

    def __init__(self, folder: Path) -> None:
        self._file = tempfile.TemporaryFile(dir=folder)  # noqa: SIM115 -- closed by __exit__

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *error: object) -> None:
        self._file.close()

    def add(self, profiles: CaseProfiles) -> None:
        """Keep the profiles of one more case."""
        np.save(self._file, profiles.x, allow_pickle=False)
        np.save(self._file, profiles.values, allow_pickle=False)

    def __iter__(self) -> Iterator[CaseProfiles]:
        """Iterate over the profiles in the order in which they were added."""
        end = self._file.tell()
        self._file.seek(0)
        while self._file.tell() < end:
            x = np.load(self._file, allow_pickle=False)
            yield CaseProfiles(x, np.load(self._file, allow_pickle=False))
