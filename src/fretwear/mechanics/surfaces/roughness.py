"""Roughness of the bodies, added to their smooth gap: waves and random surfaces."""

from __future__ import annotations

import dataclasses
import math
import operator
from collections.abc import Callable, Iterable
from functools import cached_property, lru_cache, partial
from typing import Annotated, ClassVar, Literal, TypeVar

import numpy as np
from numpy.typing import NDArray
from pydantic.dataclasses import dataclass

from fretwear.arrays import Array, Even
from fretwear.quantity import Part, Quantity, whole_number

MAX_SLOPE = math.pi / 4.0
_Value = TypeVar("_Value")

# Period of a random surface, in roll-off wavelengths.
_PERIODS = 16
# Largest ratio of its wavelengths; summing the waves of a broader spectrum takes too much time and
# memory.
_BROADEST = 128.0
# Height that it rarely exceeds, height of its tips, and its steepest slope, over the root mean
# square.
_HIGHEST = 6.0
TIPS = 2.5
STEEPEST = 3.0


@dataclasses.dataclass(frozen=True)
class Tip:
    """A tip of a surface: curvatures along x and y, 1/m, and distances of tips in a row, m.

    Rows lie half as far apart and are shifted by half: two tips share the area of both distances.
    """

    curvature_x: float
    curvature_y: float
    apart_x: float
    apart_y: float


class Roughness(Part):
    """Deviations of the surfaces from their smooth shape."""

    detail: ClassVar[str] = "wave"  #: word for the feature whose length is `finest`
    cells: ClassVar[int] = 16  #: cells that resolve it; half as many just suffice

    @property
    def even(self) -> Even:
        """Whether the height is exactly even along x and along y, so that one side suffices."""
        return False, False

    def height(self, x: Array, y: Array) -> Array:
        """Contribution to the gap, m, at coordinates in m that broadcast."""
        raise NotImplementedError

    def warnings(self, radius: float, curvature: float) -> Iterable[tuple[str, str]]:
        """Warnings about heights under a contact of some radius, m: a sentence and its numbers.

        `curvature`, 1/m, belongs to the indenter.
        """
        return ()

    def mean_height(self, x: Array, y: Array, cell: tuple[float, float] | None) -> Array:
        """Mean of the height over each cell of a grid, m, by Simpson's rule.

        A pressure uniform on cells displaces their centres less than a wave of it does, by (kΔ)²/24
        for a wave number k along each axis; the mean of a height is smaller by as much. With
        heights at the centres, tips that hardly yield would yield a tenth more. The centres of the
        cells along x and y, m, have shapes (nx,) and (ny,). Without widths of the cells, m, the
        result is the height of these points.
        """
        if cell is None:
            return self.height(x[:, None], y)
        places = []
        for centres, width in ((x, cell[0]), (y, cell[1])):
            fine = np.empty(2 * centres.size + 1)
            fine[1::2], fine[2:-1:2] = centres, 0.5 * (centres[1:] + centres[:-1])
            fine[0], fine[-1] = centres[0] - 0.5 * width, centres[-1] + 0.5 * width
            places.append(fine)
        heights = self.height(places[0][:, None], places[1][None, :])
        for _ in places:
            heights = ((heights[:-2:2] + 4.0 * heights[1::2] + heights[2::2]) / 6.0).T
        return np.ascontiguousarray(heights)

    @property
    def finest(self) -> tuple[float, float]:
        """Length along x and along y, m, that a grid must resolve; inf if there is none."""
        raise NotImplementedError

    @property
    def highest(self) -> float:
        """Bound of the magnitude of the height, m."""
        raise NotImplementedError

    @property
    def tips(self) -> float:
        """Typical height of tips, m."""
        return self.highest

    @property
    def steepest(self) -> float:
        """Steepest slope, approximately."""
        return 2.0 * math.pi * self.highest / min(self.finest)

    @property
    def period(self) -> tuple[float, float]:
        """Distance along x and along y, m, after which a random surface repeats; inf for others."""
        return math.inf, math.inf

    @property
    def sides(self) -> tuple[float, float]:
        """Lengths along x and y, m, of a measured map; inf for others."""
        return math.inf, math.inf

    @property
    def is_known(self) -> bool:
        """Whether heights are available; they are not if a file is missing."""
        return True

    @property
    def tip(self) -> Tip | None:
        """The tip, if all tips are alike and longer than `finest`."""
        return None

    @property
    def wavelengths(self) -> tuple[float, float]:
        """Distance between neighbouring tips along x and along y, m; inf if there is only one."""
        return self.finest


_Slope = partial(Quantity, ge=0.0, lt=MAX_SLOPE, absent=0.0)


@dataclass(frozen=True)
class WavyRoughness(Roughness):
    """Wavy roughness h_r = h_a cos(k_y y) sin(π/2 + k_x x), with k = (π/2)·tanθ/h_a.

    It is added to the gap, which is largest at the origin: there the body has a valley, and its
    first tips are half a wavelength away. The mean slope of a wave along its direction is tanθ, and
    its length λ = 4h_a/tanθ: k_x follows from θ_x and k_y from θ_y. (Equation (12) of the source
    study, as printed, has θ_y in both.) At zero amplitude the surface is smooth for all slopes.
    """

    amplitude: Annotated[
        float,
        Quantity(
            *("m", r"$h_\mathrm{a}$", "roughness amplitude", "um"),
            ge=0.0,
            zero="smooth",
            absent=0.0,
        ),
        "Amplitude of the waves; 0 um is smooth.",
    ]
    slope_x: Annotated[
        float,
        _Slope("rad", "$θ_x$", "roughness slope along x", "deg"),
        "Mean slope along x, the direction of slip; 0 deg: no wave along x.",
    ]
    slope_y: Annotated[
        float,
        _Slope("rad", "$θ_y$", "roughness slope along y", "deg", like="1 deg"),
        "Mean slope along y; 0 deg: no wave along y.",
    ]
    kind: Literal["wavy"] = "wavy"
    synonyms: ClassVar[tuple[str, ...]] = ("sine", "sinusoidal", "waves")

    @property
    def even(self) -> Even:
        """Both."""
        return True, True

    def height(self, x: Array, y: Array) -> Array:
        """h_a cos(k_x x) cos(k_y y), m."""
        along_x, along_y = self.wavenumbers
        result: Array = self.amplitude * np.cos(along_x * x) * np.cos(along_y * y)
        return result

    @property
    def wavenumbers(self) -> tuple[float, float]:
        """(k_x, k_y) in rad/m; 0 without a wave along the axis."""
        scale = 0.5 * math.pi
        if not self.amplitude:
            return 0.0, 0.0
        x, y = (scale * math.tan(slope) / self.amplitude for slope in (self.slope_x, self.slope_y))
        return x, y

    @property
    def finest(self) -> tuple[float, float]:
        """(λ_x, λ_y) in m; inf without a wave along the axis."""
        x, y = (2.0 * math.pi / number if number else math.inf for number in self.wavenumbers)
        return x, y

    @property
    def highest(self) -> float:
        """A in m."""
        return self.amplitude

    @property
    def tip(self) -> Tip:
        """Curvatures A k_x² and A k_y²."""
        x, y = self.wavenumbers
        return Tip(self.amplitude * x * x, self.amplitude * y * y, *self.finest)

    @property
    def mistake(self) -> tuple[str, str] | None:
        """A wave needs a slope."""
        if self.amplitude > 0.0 and self.slope_x == 0.0 and self.slope_y == 0.0:
            return (
                "needs a slope larger than zero along x or y",
                "for a smooth surface write roughness: none",
            )
        return None

    @property
    def is_trivial(self) -> bool:
        """Whether there is no height."""
        return self.amplitude == 0.0

    @property
    def slug(self) -> str:
        """``A0.2um``."""
        return f"A{self.amplitude * 1e6:.4g}um".replace("+", "")


@dataclass(frozen=True)
class SelfAffineRoughness(Roughness):
    """A random surface with the spectrum of self-affine roughness.

    Its power spectral density is constant for wavelengths above the roll-off one, falls with the
    power −2 − 2H of the wave number down to the shortest wavelength, and ends there. The surface is
    the sum of the waves on a lattice of wave vectors, with amplitudes from the spectrum and random
    phases; it repeats after 16 roll-off wavelengths. Neither depends on a grid. A smaller shortest
    wavelength adds waves and, for the same seed, keeps the others.

    Along the lay of an anisotropic surface all wavelengths are longer: along x by the factor
    ``anisotropy``, or along y by its inverse if it is less than 1.

    References
    ----------
    T. D. B. Jacobs, T. Junge and L. Pastewka (2017), "Quantitative characterization of surface
    topography using spectral analysis", Surf. Topogr.: Metrol. Prop. 5, 013001.
    """

    rms_height: Annotated[
        float,
        Quantity(
            "m", r"$h_\mathrm{rms}$", "rms height of the roughness", "um", like="0.2 um", gt=0.0
        ),
        "Root mean square of the height.",
    ]
    hurst: Annotated[
        float,
        Quantity("1", "$H$", "Hurst exponent", like="0.8", gt=0.0, le=1.0),
        "Hurst exponent H; the density falls with the power -2 - 2H.",
    ]
    rolloff_wavelength: Annotated[
        float,
        Quantity("m", r"$λ_\mathrm{r}$", "roll-off wavelength", "um", like="80 um", gt=0.0),
        "Longer waves have the same density.",
    ]
    shortest_wavelength: Annotated[
        float,
        Quantity("m", r"$λ_\mathrm{s}$", "shortest wavelength", "um", like="8 um", gt=0.0),
        "End of the spectrum; the default grid spacing is an eighth of it.",
    ]
    seed: Annotated[
        int,
        whole_number("seed", "seed of the roughness", 0, 2**31 - 1, 7),
        "Selects one of the random surfaces.",
    ]
    anisotropy: Annotated[
        float,
        Quantity("1", "$λ_x/λ_y$", "anisotropy of the roughness", like="1", ge=1e-2, le=1e2),
        "Wavelengths along x over those along y; given ones are the shorter.",
    ] = 1.0
    kind: Literal["self_affine"] = "self_affine"
    synonyms: ClassVar[tuple[str, ...]] = ("random", "fractal", "gaussian")

    # The shortest waves are the lowest ones.
    detail: ClassVar[str] = "shortest wave"
    cells: ClassVar[int] = 8

    def height(self, x: Array, y: Array) -> Array:
        """Sum of all waves, m; fast if x is a column and y a row."""
        x, y = np.asarray(x, np.float64), np.asarray(y, np.float64)
        if x.shape[1:] == (1,) and y.size == y.shape[-1]:
            return self.mean_height(x[:, 0], y.ravel(), None)
        points = np.vectorize(lambda x, y: self.height(np.array([[x]]), np.array([y]))[0, 0])
        result: Array = points(x, y)
        return result

    def mean_height(self, x: Array, y: Array, cell: tuple[float, float] | None) -> Array:
        """Mean of the height over each cell, m, with a closed form for each wave."""
        unit, count = 2.0 * math.pi / (_PERIODS * self.rolloff_wavelength), len(self._waves) - 1
        across_x, across_y = self._stretched(1.0)
        along_x = np.arange(count + 1) * (unit / across_x)
        along_y = np.arange(-count, count + 1) * (unit / across_y)
        means = (
            np.sinc(k * width / (2.0 * math.pi))
            for k, width in zip((along_x, along_y), cell or (0.0, 0.0), strict=True)
        )
        waves = self._waves * np.outer(*means)
        # If the columns are symmetric about x = 0, one side gives the other.
        half = len(x) // 2 if np.array_equal(x, -x[::-1]) else 0
        phases = np.outer(along_y, y)
        cosines, sines, real, imaginary = np.cos(phases), np.sin(phases), waves.real, waves.imag
        cosine = real @ cosines - imaginary @ sines
        sine = imaginary @ cosines + real @ sines
        phases = np.outer(x[half:], along_x)
        even, odd = np.cos(phases) @ cosine, np.sin(phases) @ sine
        result: Array = np.concatenate([(even + odd)[::-1][:half], even - odd])
        return result

    @property
    def rms_slope(
        self,
    ) -> Annotated[float, Quantity("1", r"$h^\prime_\mathrm{rms}$", "rms slope of the roughness")]:
        """Root mean square of the magnitude of the gradient."""
        power, (across_x, across_y) = self._power, self._stretched(1.0)
        count, period = len(power) - 1, _PERIODS * self.rolloff_wavelength
        along_x, along_y = np.ogrid[: count + 1, -count : count + 1]
        mean = np.average((along_x / across_x) ** 2 + (along_y / across_y) ** 2, weights=power)
        return 2.0 * math.pi / period * math.sqrt(mean) * self.rms_height

    @property
    def finest(self) -> tuple[float, float]:
        """The shortest wavelength along x and y, m."""
        return self._stretched(self.shortest_wavelength)

    @property
    def period(self) -> tuple[float, float]:
        """Sixteen roll-off wavelengths along x and y, m."""
        return _PERIODS * self.wavelengths[0], _PERIODS * self.wavelengths[1]

    @property
    def wavelengths(self) -> tuple[float, float]:
        """The roll-off wavelength along x and y, m: there are tips within it."""
        return self._stretched(self.rolloff_wavelength)

    @property
    def highest(self) -> float:
        """Six times the root mean square, m, which hardly any surface reaches."""
        return _HIGHEST * self.rms_height

    @property
    def tips(self) -> float:
        """Typical height of tips, m."""
        return TIPS * self.rms_height

    @property
    def steepest(self) -> float:
        """Three times the root mean square of the slope."""
        return STEEPEST * self.rms_slope

    @property
    def mistake(self) -> tuple[str, str] | None:
        """The range of wavelengths must be narrow enough to sum the waves."""
        ratio = self.rolloff_wavelength / self.shortest_wavelength
        if ratio < 1.0:
            return (
                "needs a shortest wavelength of at most the roll-off wavelength",
                "lower shortest_wavelength or raise rolloff_wavelength",
            )
        if ratio > _BROADEST:
            return (
                f"has a roll-off wavelength {ratio:.4g} times as long as the shortest, and at most "
                f"{_BROADEST:g} times is supported",
                "raise shortest_wavelength: few grids resolve so many",
            )
        return None

    @property
    def slug(self) -> str:
        """``h0.2um-seed7``."""
        return f"h{self.rms_height * 1e6:.4g}um-seed{self.seed}".replace("+", "")

    def _stretched(self, length: float) -> tuple[float, float]:
        """A length along x and along y."""
        return length * max(1.0, self.anisotropy), length * max(1.0, 1.0 / self.anisotropy)

    @property
    def _power(self) -> Array:
        return _power(self.hurst, _PERIODS * (self.rolloff_wavelength / self.shortest_wavelength))

    @cached_property
    def _waves(self) -> NDArray[np.complex128]:
        """Amplitudes of the waves, m."""
        power = self._power
        amplitude = self.rms_height * np.sqrt(2.0 * power / power.sum())
        waves: NDArray[np.complex128] = amplitude * np.exp(1j * _phases(self.seed, len(power) - 1))
        return waves


def _joined(name: str, join: Callable[[_Value, _Value], _Value]) -> _Value:
    value = operator.attrgetter(name)
    return property(lambda both: join(value(both.first), value(both.second)))  # type: ignore[return-value]


def _nearer(first: tuple[float, float], second: tuple[float, float]) -> tuple[float, float]:
    return min(first[0], second[0]), min(first[1], second[1])


@dataclasses.dataclass(frozen=True)
class BothRough(Roughness):
    """Two rough surfaces, one on each body, whose contributions to the gap add up."""

    first: Roughness
    second: Roughness

    even = _joined("even", lambda one, other: (one[0] and other[0], one[1] and other[1]))
    is_known = _joined("is_known", operator.and_)
    highest = _joined("highest", operator.add)
    # Squares of independent heights add up.
    tips, steepest = _joined("tips", math.hypot), _joined("steepest", math.hypot)
    finest, wavelengths = _joined("finest", _nearer), _joined("wavelengths", _nearer)
    period, sides = _joined("period", _nearer), _joined("sides", _nearer)

    def height(self, x: Array, y: Array) -> Array:
        """Sum of both, m."""
        return self.first.height(x, y) + self.second.height(x, y)

    def mean_height(self, x: Array, y: Array, cell: tuple[float, float] | None) -> Array:
        """Sum of both, m."""
        return self.first.mean_height(x, y, cell) + self.second.mean_height(x, y, cell)

    @property
    def tip(self) -> Tip | None:
        """Two tips that meet."""
        first, second = self.first.tip, self.second.tip
        if first is None or second is None:
            return None
        curvatures = first.curvature_x + second.curvature_x, first.curvature_y + second.curvature_y
        return Tip(*curvatures, *self.finest)


@lru_cache(maxsize=8)
def _power(hurst: float, shortest: float) -> Array:
    """Power of the waves on half the lattice, up to a factor, each wave once.

    Wave numbers, with ``shortest`` the largest, are in units of the lattice: 0 … n along x and
    −n … n along y, shape (n + 1, 2n + 1); the roll-off is at `_PERIODS`.
    """
    count = int(shortest * (1.0 + 1e-12))
    number = np.hypot(*np.ogrid[: count + 1, -count : count + 1])
    power: Array = np.maximum(number / _PERIODS, 1.0) ** (-2.0 - 2.0 * hurst)
    power[number > shortest * (1.0 + 1e-12)] = 0.0
    # A wave vector and its opposite are one wave; no wave is infinitely long.
    power[0, : count + 1] = 0.0
    return power


def _phases(seed: int, count: int) -> Array:
    """Random phases of the waves of `_power`, the same for waves that a smaller lattice shares."""
    x, y = np.mgrid[: count + 1, -count : count + 1]
    order = np.lexsort((y.ravel(), x.ravel(), np.maximum(x, abs(y)).ravel()))
    phases = np.empty(x.size)
    # The raw bits of a generator are the same in every version of NumPy.
    phases[order] = np.random.PCG64(seed).random_raw(x.size) * (2.0 * math.pi / 2.0**64)
    return phases.reshape(x.shape)
