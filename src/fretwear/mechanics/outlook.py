"""Whether the contact wants to leave its window.

A smooth contact grows at its border, and pressure near the window's border announces it. Between
the contact and the next asperity tip of a rough one lies up to a wavelength without contact: the
surface beyond the window has to be looked at too. There it is unworn, and its gap is the
displacement by the pressure inside, plus the shape, minus the approach.
"""

from __future__ import annotations

import math

from fretwear.mechanics.arrays import Array
from fretwear.mechanics.halfspace import HalfSpace
from fretwear.mechanics.state import WearProblem
from fretwear.mechanics.window import Window, fast_shape

_BORDER = 2
_AHEAD = 0.02
_GROWTH = 1.12


class Outlook:
    """Looks from a window at its border and at what lies beyond.

    Parameters
    ----------
    problem
        What is in contact.
    window
        Where it is computed.
    """

    def __init__(self, problem: WearProblem, window: Window) -> None:
        self._problem = problem
        self._window = window
        self._wide: HalfSpace | None = None
        self._unworn: Array | None = None

    def touched(self, pressure: Array, approach: float) -> tuple[bool, bool]:
        """Whether the contact comes to the window's border, or beyond it, along x and along y.

        Parameters
        ----------
        pressure
            p, Pa, shape of the window.
        approach
            δ, m.
        """
        border = touched_sides(self._window, pressure)
        beyond = self._beyond(pressure, approach)
        return border[0] or beyond[0], border[1] or beyond[1]

    def approached(self, pressure: Array) -> tuple[bool, bool]:
        """Whether the next step may bring the contact to the border, along x and along y.

        A step seldom widens a contact by more than a part in fifty. To grow the window before
        such a step costs less than to make it twice.
        """
        nx, ny = self._window.shape
        ahead_x, ahead_y = (max(_BORDER, math.ceil(_AHEAD * count)) for count in (nx, ny))
        return touched_sides(self._window, pressure, (ahead_x, ahead_y))

    def _beyond(self, pressure: Array, approach: float) -> tuple[bool, bool]:
        wide = self._wide_window(approach)
        if wide.shape == self._window.shape:
            return False, False
        if self._wide is None or self._unworn is None or self._wide.window.shape != wide.shape:
            self._wide = self._problem.half_space(wide)
            self._unworn = self._problem.surface.shape(wide)
        inside = self._window.covered(wide.shape)
        # Displacement only opens the gap: where the surface lies above the approach it stays open.
        if not ((self._unworn < approach) & ~inside).any():
            return False, False
        gap = self._wide.displacement_in_single(self._window.resized(pressure, wide.shape))
        gap += self._unworn
        closed = (gap < approach) & ~inside
        beyond_x = abs(wide.x) > self._window.extent[0]
        beyond_y = abs(wide.y) > self._window.extent[1]
        return bool(closed[beyond_x].any()), bool(closed[:, beyond_y].any())

    def _wide_window(self, approach: float) -> Window:
        """The window and a wavelength more, as far as the surface lies below the approach."""
        window, waves = self._window, self._problem.surface.waves
        if waves is None:
            return window
        reach = math.sqrt(2.0 * self._problem.surface.radius * (approach + waves.amplitude))
        extents = []
        for extent, number in zip(
            window.extent, (waves.wavenumber_x, waves.wavenumber_y), strict=True
        ):
            wavelength = 2.0 * math.pi / number if number > 0 else 0.0
            extents.append(max(extent, min(extent + wavelength, reach)))
        shape = fast_shape((extents[0], extents[1]), window.spacing, quarter=window.quarter)
        grown = (max(shape[0], window.shape[0]), max(shape[1], window.shape[1]))
        return Window(grown, window.spacing, window.quarter)


def larger_window(problem: WearProblem, window: Window, pressure: Array, approach: float) -> Window:
    """The window itself, or the smallest of a row of larger ones that the contact fits into.

    Parameters
    ----------
    problem
        What is in contact.
    window
        Where the contact was computed.
    pressure, approach
        p, Pa, shape of the window, and δ, m.
    """
    grown = window
    while True:
        outlook = Outlook(problem, grown)
        touched = outlook.touched(window.resized(pressure, grown.shape), approach)
        if not any(touched):
            return grown
        grown = next_window(grown, touched)


def next_window(window: Window, sides: tuple[bool, bool]) -> Window:
    """The next larger window along x, along y or both."""
    extent = grown_extent(window.extent, sides)
    shape = fast_shape(extent, window.spacing, quarter=window.quarter)
    larger = (max(shape[0], window.shape[0]), max(shape[1], window.shape[1]))
    return Window(larger, window.spacing, window.quarter)


def touched_sides(
    window: Window, pressure: Array, border: tuple[int, int] = (_BORDER, _BORDER)
) -> tuple[bool, bool]:
    """Whether there is pressure in the outermost cells, so many along x and along y."""
    along_x = bool(pressure[-border[0] :].any())
    along_y = bool(pressure[:, -border[1] :].any())
    if not window.quarter:
        along_x |= bool(pressure[: border[0]].any())
        along_y |= bool(pressure[:, : border[1]].any())
    return along_x, along_y


def grown_extent(extent: tuple[float, float], touched: tuple[bool, bool]) -> tuple[float, float]:
    """The next half-widths, m, of a window whose border was touched."""
    return (
        extent[0] * (_GROWTH if touched[0] else 1.0),
        extent[1] * (_GROWTH if touched[1] else 1.0),
    )
