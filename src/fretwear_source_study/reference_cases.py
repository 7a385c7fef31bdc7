"""The cases of the source study: the points of a study that they are, and measures over cycles."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from fretwear.arrays import Array, Mask
from fretwear.data.effects import point_values
from fretwear.data.files import open_case, open_history
from fretwear.mechanics.surfaces.indenters import Ellipsoid
from fretwear.mechanics.surfaces.materials import ElasticBodies
from fretwear.mechanics.surfaces.pressing import NormalLoad
from fretwear.mechanics.surfaces.roughness import WavyRoughness
from fretwear.results import PointStatus
from fretwear.variable import ContactState
from fretwear_source_study.parameters import ROUGH, SHARED, TITLES, title_of

if TYPE_CHECKING:
    import xarray as xr


RUN_IN = 7000
"""Cycles after which, according to the study, rough and smooth contacts are alike."""

_RADIUS = 0.01
_FEWEST_CELLS = 12  # in contact on an asperity
_MOST_NEWTONS = 10.0  # a load above any that a tip carries
MODELS = {
    "cerruti": "slip of the worn shape, along x",
    "jaeger": "slip of the worn shape, alike in all directions",
    "cattaneo_mindlin": "as the study describes it",
}
"""Slip models in words, the best first."""


@dataclass(frozen=True)
class StudyCase:
    """A case over its cycles: SI units, fields of shape (nx, ny)."""

    dataset: xr.Dataset  # of a quarter or of the whole contact
    history: xr.Dataset  # scalars at every accepted step

    @cached_property
    def cycles(self) -> tuple[int, ...]:
        """Snapshots, cycle 0 first."""
        return tuple(int(cycle) for cycle in self.dataset["cycle"].values)

    @property
    def last(self) -> int:
        """The last cycle."""
        return self.cycles[-1]

    def nearest(self, cycle: int) -> int:
        """The snapshot nearest a cycle."""
        return min(self.cycles, key=lambda candidate: abs(candidate - cycle))

    def field(self, name: str, cycle: int) -> Array:
        """One field at a snapshot."""
        snapshot = self.dataset[name].sel(cycle=cycle).transpose("x", "y")
        return snapshot.values.astype(np.float64)

    def largest(self, name: str, cycle: int) -> float:
        """One scalar at a snapshot, or the largest value of a field."""
        return float(self.dataset[name].sel(cycle=cycle).max())

    def parameter(self, name: str) -> float:
        """One parameter of the case."""
        return float(self.dataset[name])

    def at(self, name: str, cycle: float) -> float:
        """One scalar at any cycle, linear between accepted steps."""
        return float(np.interp(cycle, self.history["cycle"].values, self.history[name].values))

    @cached_property
    def places(self) -> tuple[Array, Array]:
        """Positions along x and y, shapes (nx,) and (ny,)."""
        x, y = (self.dataset[name].values.astype(np.float64) for name in ("x", "y"))
        return x, y

    @cached_property
    def sides(self) -> tuple[float, float]:
        """Sides of a cell along x and y."""
        x, y = self.places
        return float(np.diff(x).mean()), float(np.diff(y).mean())

    @cached_property
    def radius(self) -> Array:
        """Distance of every cell from the middle."""
        return np.hypot.outer(*self.places)

    @cached_property
    def roughness(self) -> WavyRoughness:
        """The waves of the case, without amplitude if it is smooth."""
        return WavyRoughness(*[self.parameter(name) for name in ROUGH])  # type: ignore[arg-type]

    @cached_property
    def waves(self) -> Array:
        """The waves of a rough case without their amplitude: -1 on a tip, 1 in a valley."""
        heights = self.roughness.mean_height(*self.places, self.sides)
        return heights / self.roughness.amplitude

    def zones(self, cycle: int) -> DiscAndRing:
        """The stick and slip zones at a snapshot."""
        state, half_cell = self.field("contact_state", cycle), 0.5 * max(self.sides)
        inside = [self.radius[state >= least] for least in (ContactState.STICK, ContactState.SLIP)]
        edges = [float(radii.max()) + half_cell if radii.size else 0.0 for radii in inside]
        return DiscAndRing(self.radius, *edges)

    def rings(self, field: Array, within: Mask) -> tuple[Array, Array, Array]:
        """Average a field over rings around the middle, which averages waves out.

        Rings are two cells wide, or half a wave if that is wider; only cells within the mask
        count.  Returns the mean radius, m, the mean of the field and the number of cells of each
        ring that has cells.
        """
        width = 2.0 * max(self.sides)
        if wavenumber := max(self.roughness.wavenumbers):
            width = max(width, np.pi / wavenumber)
        number = (self.radius[within] / width).astype(np.int64)
        cells = np.bincount(number).astype(np.float64)
        kept = cells > 0
        radius, mean = (
            np.bincount(number, weights=values[within])[kept] / cells[kept]
            for values in (self.radius, field)
        )
        return radius, mean, cells[kept]


Cases = Mapping[str, StudyCase]
"""The four cases of `TITLES`."""


@dataclass(frozen=True)
class DiscAndRing:
    """The stick zone as a disc and the slip zone as the ring around it.

    On a smooth sphere this is exact. On a rough one the disc is the smallest around all cells that
    stick, and the ring ends at the outermost cell in contact, so that both contain valleys.
    """

    radius: Array  # distance of every cell from the middle, m, shape (nx, ny)
    stick_radius: float  # c, m
    contact_radius: float  # b, m

    @property
    def stick(self) -> Mask:
        """Cells of the stick zone."""
        return np.less_equal(self.radius, self.stick_radius)

    def slip(self, start: float = 0.0, end: float = 1.0) -> Mask:
        """Cells of the slip zone from one fraction of its width to another, by default of all."""
        fraction = self.place(self.radius)
        return np.greater(fraction, start) & np.less_equal(fraction, end)

    def place(self, radius: Array) -> Array:
        """Place of a radius, m, in the slip zone: 0 at the edge of stick, 1 at the outer rim."""
        return np.divide(radius - self.stick_radius, self.contact_radius - self.stick_radius)


def reference_cases(summary: xr.Dataset, folder: Path) -> Iterator[tuple[str, float, Cases]]:
    """Yield slip model, sphere radius, m, and cases of a merged study with the source's parameters.

    All four cases of such a group are done. The first group serves for figures: it has the best
    slip model, and the radius nearest 10 mm, which stands for the unknown radius of the
    source study.
    """
    needed = {"status", "case_id", "radius", "slip_model", "plastic_limit", *SHARED, *ROUGH}
    if not needed <= set(summary.variables):
        return
    points = {name: point_values(summary, name) for name in needed}
    files_of: dict[tuple[str, float], dict[str, Path]] = {}
    for index in np.flatnonzero(points["status"] == PointStatus.DONE):
        if title := title_of({name: values[index] for name, values in points.items()}):
            group = str(points["slip_model"][index]), float(points["radius"][index])
            files_of.setdefault(group, {})[title] = folder / f"{points['case_id'][index]}.nc"

    def rank(group: tuple[str, float]) -> tuple[int, float]:
        return [*MODELS, group[0]].index(group[0]), abs(math.log(group[1] / _RADIUS))

    for group in sorted(files_of, key=rank):
        if len(files_of[group]) < len(TITLES):
            continue
        cases = {}
        for title in TITLES:
            file = files_of[group][title]
            with open_case(file) as case, open_history(file) as history:
                cases[title] = StudyCase(case.load(), history.load())
        yield *group, cases


def zone_means(case: StudyCase, name: str) -> tuple[Array, Array]:
    """Means of a field over the first stick disc and over the ring around it, each (ncycles,).

    Every snapshot has the disc of cycle 0; its ring ends with its own contact.
    """
    disc = case.zones(0).stick
    means = []
    for cycle in case.cycles:
        field = case.field(name, cycle)
        ring = ~disc & (case.radius <= case.zones(cycle).contact_radius)
        means.append([float(field[zone].mean()) for zone in (disc, ring)])
    stick, slip = np.array(means).T
    return stick, slip


def differences(
    smooth: StudyCase, rough: StudyCase, field: str, cycle: int
) -> tuple[float, float, float]:
    """Difference between rough and smooth in their common slip zone.

    Returns, in the unit of the field, the mean of |rough − smooth|, and the mean and the largest
    value of the smooth case.
    """
    both = [smooth.zones(cycle), rough.zones(cycle)]
    inner = max(zones.stick_radius for zones in both)
    outer = min(zones.contact_radius for zones in both)
    zone = (rough.radius > inner) & (rough.radius <= outer)
    if not zone.any():
        return math.nan, math.nan, math.nan
    # Linear between the cells of the smooth case, constant nearer the middle.
    coarse = smooth.dataset[field].sel(cycle=cycle).astype(float)
    places = {n: rough.dataset[n].clip(coarse[n].min(), coarse[n].max()) for n in ("x", "y")}
    reference = coarse.interp(places).transpose("x", "y").values[zone]
    apart = np.abs(rough.field(field, cycle)[zone] - reference)
    return float(apart.mean()), float(reference.mean()), float(reference.max())


def place_on_rings(case: StudyCase, name: str, cycle: int) -> float:
    """Place in the slip zone, 0 to 1, where a field, averaged over rings, is largest."""
    zones = case.zones(cycle)
    radius, mean, _ = case.rings(case.field(name, cycle), case.radius <= zones.contact_radius)
    return float(zones.place(radius[mean.argmax()]))


def unevenness(case: StudyCase, cycle: int, start: float = 0.0, end: float = 1.0) -> float:
    """Standard deviation over mean of the wear of one cycle in the slip zone.

    `start` and `end` choose a part of the zone, in fractions of its width.
    """
    part = case.zones(cycle).slip(start, end)
    _, values, cells = case.rings(case.field("wear_rate", cycle), part)
    mean = float(np.average(values, weights=cells))
    variance = float(np.average((values - mean) ** 2, weights=cells))
    return math.sqrt(variance) / mean if mean > 0.0 else math.inf


def amplitude_left(case: StudyCase, cycle: int, zone: Mask) -> float:
    """Amplitude of the waves on the worn and yielded surface in a zone, over the first amplitude.

    Means over rings are subtracted from both, so that the wear scar does not count.
    """
    amplitude = case.parameter("roughness_amplitude")
    changed = case.field("wear_depth", cycle) + case.field("plastic_depth", cycle)

    def waves_of(field: Array) -> Array:
        radius, mean, _ = case.rings(field, zone)
        return np.subtract(field[zone], np.interp(case.radius[zone], radius, mean))

    left, pattern = waves_of(amplitude * case.waves + changed), waves_of(case.waves)
    return float((left * pattern).sum() / (pattern**2).sum()) / amplitude


def asperities(case: StudyCase) -> Iterator[tuple[tuple[Mask, ...], Array]]:
    """Yield the cells of each asperity of a rough case, and their distance from its tip.

    An asperity is half a wave by half a wave around a tip, with enough cells in contact in cycle 0
    to have a profile. The distance is in half-axes of the Hertz contact of the tip under 1 N.
    """
    pressure, whole = case.field("pressure", 0), 1.0 / case.parameter("radius")
    half_axes, _ = tip_contact(case)
    lines, numbers = [], []
    waves = zip(case.places, case.roughness.wavenumbers, half_axes, strict=True)
    for places, wavenumber, half_axis in waves:
        number = np.rint(places * wavenumber / np.pi).astype(np.int64)
        # The slope of the sphere shifts a tip.
        shift = whole / (case.roughness.amplitude * wavenumber**2 + whole)
        lines.append((places - (1.0 - shift) * number * np.pi / wavenumber) / half_axis)
        numbers.append(number)
    for i, j in np.ndindex(int(numbers[0].max()) + 1, int(numbers[1].max()) + 1):
        cells = np.ix_(numbers[0] == i, numbers[1] == j)
        # An even sum belongs to a valley, as in the middle of the contact.
        if (i + j) % 2 and (pressure[cells] > 0.0).sum() >= _FEWEST_CELLS:
            yield cells, np.hypot(lines[0][cells[0]], lines[1][cells[1]])


def tip_contact(case: StudyCase) -> tuple[tuple[float, float], float]:
    """Half-axes along x and y, m, and peak pressure, Pa, of a tip under 1 N by Hertz.

    The curvature of a tip is the sum of the curvatures of wave and sphere.
    """
    amplitude, whole = case.roughness.amplitude, 1.0 / case.parameter("radius")
    x, y = (1.0 / (amplitude * wavenumber**2 + whole) for wavenumber in case.roughness.wavenumbers)
    bodies = ElasticBodies(
        youngs_modulus=case.parameter("youngs_modulus"),
        poisson_ratio=case.parameter("poisson_ratio"),
    )
    tip = Ellipsoid(x, y)
    contact = tip.hertz(NormalLoad(1.0), bodies.composite_modulus)
    return tip.half_widths(contact), contact.peak_pressure


def deviation_from_hertz(case: StudyCase) -> float:
    """Deviation of the pressure of asperities from Hertz in cycle 0, a mean weighted by load.

    For one asperity it is the root mean square of the difference from the smooth contact with its
    curvatures and its load, cut at the plastic limit, over the root mean square of its pressure.
    """
    from scipy.optimize import brentq  # takes a quarter of a second

    pressure, limit = case.field("pressure", 0), case.parameter("plastic_limit")
    _, peak = tip_contact(case)
    deviations, loads = [], []

    def apart(size: float, here: Array, distance: Array) -> Array:
        # Half-axes and peak pressure grow alike, so one number sets the contact under any load.
        smooth = peak * np.sqrt(np.maximum(size**2 - distance**2, 0.0))
        return here - np.minimum(smooth, limit)

    for cells, distance in asperities(case):
        tip = here, _ = pressure[cells], distance
        size = brentq(lambda *of: apart(*of).sum(), 0.0, _MOST_NEWTONS, tip)
        deviations.append(math.sqrt((apart(size, *tip) ** 2).sum() / (here**2).sum()))
        loads.append(here.sum())
    return float(np.average(deviations, weights=loads)) if loads else math.nan


def asperities_like_the_whole(case: StudyCase, cycle: int) -> tuple[float, float]:
    """Share of the load on asperities that both stick and slip, and the part of it that behaves.

    Loads and zones are taken in cycle 0. An asperity behaves as a smooth contact if, up to the
    given cycle, its mean pressure rises where it stuck and falls where it slipped.
    """
    initial, now = case.field("pressure", 0), case.field("pressure", cycle)
    state = case.field("contact_state", 0)
    loads, behave = [], []
    for cells, _ in asperities(case):
        sticks = state[cells] == ContactState.STICK
        slips = (state[cells] == ContactState.SLIP) & (initial[cells] > 0.0)
        if sticks.any() and slips.any():
            change = now[cells] - initial[cells]
            loads.append(initial[cells].sum())
            behave.append(change[sticks].mean() > 0.0 > change[slips].mean())
    if not loads:
        return 0.0, math.nan
    return float(sum(loads) / initial.sum()), float(np.average(behave, weights=loads))


def growth(case: StudyCase, cycle: float) -> float:
    """Growth of the contact half-width since cycle 0, m."""
    return case.at("contact_half_width_x", cycle) - case.at("contact_half_width_x", 0.0)


def late_growth(case: StudyCase) -> float:
    """Share of the whole growth that falls into the second half of the cycles."""
    whole = growth(case, case.last)
    return 1.0 - growth(case, 0.5 * case.last) / whole if whole > 0.0 else 0.0
