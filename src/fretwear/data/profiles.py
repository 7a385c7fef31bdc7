"""Profiles along x on the line nearest y = 0, brought to positions that all cases share."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fretwear.data.casefile import CaseFile
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
    outside : float
        Value outside the window of a case: 0 for what needs contact, NaN for what is not known.
    """

    name: str
    field: Field
    outside: float

    @property
    def attributes(self) -> dict[str, str]:
        """CF attributes."""
        outside = _ZERO_OUTSIDE if self.outside == 0.0 else _UNKNOWN_OUTSIDE
        comments = (self.field.comment, _INTERPOLATED, outside)
        return {
            "long_name": self.field.long_name,
            "units": self.field.units,
            "comment": "; ".join(comment for comment in comments if comment),
        }


def _profile(name: str, field_name: str, outside: float) -> Profile:
    return Profile(name, next(field for field in FIELDS if field.name == field_name), outside)


PROFILES: tuple[Profile, ...] = (
    _profile("pressure_profile", "pressure", 0.0),
    _profile("shear_profile", "shear_traction", 0.0),
    _profile("gap_profile", "gap", np.nan),
    _profile("wear_profile", "wear_depth", 0.0),
    _profile("wear_rate_profile", "wear_rate", 0.0),
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
class Line:
    """The line of cells nearest y = 0 of one case.

    Attributes
    ----------
    x : numpy.ndarray, shape (nx,)
        Cell centres in m.
    row : int
        Index of the line along y.
    """

    x: NDArray[np.float64]
    row: int

    @classmethod
    def of_case(cls, case_file: CaseFile) -> Line:
        """Find the line of a case."""
        return cls(case_file.read(X.name), int(np.abs(case_file.read(Y.name)).argmin()))

    def profiles(
        self, case_file: CaseFile, positions: NDArray[np.float64]
    ) -> dict[str, NDArray[np.float32]]:
        """Take the profiles of a case.

        Parameters
        ----------
        case_file : CaseFile
            The case.
        positions : numpy.ndarray, shape (n,)
            Positions along x in m.

        Returns
        -------
        dict of str to numpy.ndarray, shape (ncycles, n)
            By name of the profile.
        """
        return {
            profile.name: self._at(
                positions,
                case_file.read(profile.field.name, np.s_[:, :, self.row]),
                profile.outside,
            )
            for profile in PROFILES
        }

    def _at(
        self, positions: NDArray[np.float64], rows: NDArray[Any], outside: float
    ) -> NDArray[np.float32]:
        # A quarter is even in x, so nearer the middle than its first cell the value is that of
        # the first cell: what np.interp does before its first node.
        where = np.abs(positions) if self.x[0] > 0.0 else positions
        beyond = np.abs(positions) > np.abs(self.x).max() * (1.0 + 1e-12)
        values = np.stack([np.interp(where, self.x, row) for row in rows])
        values[:, beyond] = outside
        return values.astype(np.float32)
