"""Numbers that describe a state of the contact, and the accuracy with which cells locate them.

The edge of a smooth contact lies between the last cell inside and the first one outside. Rough
contacts end at a tip, whose lowest point lies anywhere in its cell.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import cached_property
from math import isfinite, nan, pi, sqrt
from typing import TypeAlias

import numpy as np

from fretwear.arrays import Array, Even, Mask
from fretwear.mechanics.contact.cells import Evidence, Geometry, Region, Way, Zone
from fretwear.mechanics.contact.grid import Grid
from fretwear.mechanics.wear.loops import Loop, loop
from fretwear.mechanics.wear.state import State, WearProblem, Workspace
from fretwear.variable import Properties, SlidingRegime, declared_scalars, scalar

# Fraction of the reduced gap beside a stick zone opened by wear once it has doubled the gap.
_DOUBLED = 0.5
# Cells beside a stick edge, and the largest ratio of the last to their mean if they resolve it.
_ALONG, _RESOLVED = 4, 1.3
# Cells on an axis or a part of it: places, and distances from the origin, m.
Lines: TypeAlias = Sequence[tuple[Way, Array]]
# Gap over that of the first cell outside, above which a cell is not in contact.
_NO_GAP = 1e-2
# Depth of a scar over its maximum at which a profilometer sees its end.
_SHALLOW = 0.01
# Wear that stops at a depth is at most this part of it above.
_ON_LEVEL = 1e-6


# Attributes of zones, of their half-widths on one line of cells, and of volumes.
_OUTLINE: Properties = {"from_zero": False, "across": True, "error_kind": "edge"}
_ALONG_X: Properties = {
    "from_zero": False,
    "is_headline": False,
    "of_line": True,
    "error_kind": "edge",
}
_ALONG_Y: Properties = {"is_headline": False, **_OUTLINE}
_VOLUME: Properties = {"may_be_logarithmic": True, "error_kind": "volume"}


def _is_coated(measures: Measures) -> object:
    return measures.problem.interface


class Measures:
    """The scalars of a state in SI units, of the whole contact, computed on demand.

    A half-width is the distance of the outermost edge on the axis, interpolated within a cell, or
    the mean of both sides if the contact is not even. A radius belongs to the disc with the area
    inside the outline of a zone; in a line contact it is the half-width.
    """

    def __init__(
        self, problem: WearProblem, state: State, workspace: Workspace | None = None
    ) -> None:
        self.problem, self.state = problem, state
        #: of the run, for scalars that need further contact solutions
        self.workspace = workspace or Workspace(problem)

    def scalars(self, known: Mapping[str, float], *, of_steps: bool = False) -> dict[str, float]:
        """All scalars that this contact has, or those of every step, by name; some may be known."""
        return {
            name: known[name] if name in known else getattr(self, name)
            for name, scalar in _SCALARS.items()
            if (not scalar.needs or scalar.needs(self))
            and not (of_steps and scalar.variable.is_at_snapshots)
        }

    @cached_property
    def loop(self) -> Loop:
        """Force and displacement over the cycle."""
        return loop(self.workspace, self.state)

    @cached_property
    def _half_widths(self) -> tuple[tuple[float, float], tuple[float, float]]:
        """Half-widths of contact and stick zone, m, along x and along y."""
        along_x, along_y = (
            half_widths(self.state, self.state.geometry.axis_cells(axis)) for axis in (0, 1)
        )
        return along_x, along_y

    @cached_property
    def _scar(self) -> tuple[float, float]:
        return scar_half_widths(self.state)

    @cached_property
    def _regions(self) -> tuple[Region, Region]:
        """The regions of contact and of stick."""
        return _regions(self.problem, self.state, self._half_widths[0])

    @cached_property
    def _zones(self) -> tuple[Zone, Zone]:
        """The zones of contact and of stick."""
        contact, stick = map(self.state.geometry.zone, self._regions)
        return contact, stick

    @cached_property
    def _wear_of_each(self) -> dict[str, Array]:
        return self.state.wear_of_each(self.problem)

    @cached_property
    def _carried(self) -> float:
        """Integral of the pressure, N; the state's load to the solver's tolerance."""
        return self.state.geometry.integral(self.state.pressure)

    @cached_property
    def _stick_load(self) -> float:
        """Load in the stick zone to its edge within a cell, N.

        The cells beyond the edge bear the harmonic mean of the pressures on both sides: the
        pressure of the zone there while the surface is unworn, and none once slip has worn the
        neighbouring surface.
        """
        (_, zone), pressure, stick = self._zones, self.state.pressure, self.state.reduced.stick
        if zone.area <= 0.0:
            return 0.0
        integral = self.state.geometry.integral
        load = integral(np.where(stick, pressure, 0.0))
        excess = integral(stick.astype(float)) - zone.area
        inner, outer = (pressure.ravel()[cells].sum() for cells in (zone.inside, zone.outside))
        if outer > 0.0:
            load -= excess * 2.0 / zone.inside.size * float(inner * outer / (inner + outer))
        return min(load, max(self.problem.plastic_limits) * zone.area)

    def _volume(self, index: int, body: str) -> float:
        """Wear volume of a body, m³."""
        shares = self.problem.wear_law.shares
        if shares and not self.problem.changes_below:
            return shares[index] * self.wear_volume
        return self.state.geometry.integral(self._wear_of_each[body])

    @scalar("m", "approach", symbol="$δ$", unit="µm")
    def approach(self) -> float:
        """Of the bodies."""
        return self.state.approach

    @scalar("m", "tangential displacement", symbol="$δ_x$")
    def tangential_displacement(self) -> float:
        """Of distant points at +Q."""
        return self.problem.tangential_displacement(self.state.mean_approach, self.state.reduced)

    @scalar("N", "normal force", symbol="$P$")
    def normal_force(self) -> float:
        """Of the whole contact."""
        return self.state.load

    @scalar("N", "tangential force amplitude", symbol="$Q$")
    def tangential_force(self) -> float:
        """Given or computed."""
        load = self.problem.slipping_load(self.state, self.state.geometry)
        return self.problem.tangential_force(load, self.state.reduced)

    @scalar("1", "sliding regime", unit="1", flags=tuple(SlidingRegime))
    def regime(self) -> float:
        """0 partial slip, 1 gross slip."""
        sticks = self.state.reduced.stick.any()
        return float(SlidingRegime.PARTIAL_SLIP if sticks else SlidingRegime.GROSS_SLIP)

    @scalar("1", "sliding ratio", symbol="$A$", unit="1", may_lack=True, error_kind="cycle")
    def sliding_ratio(self) -> float:
        """Dissipated energy over 4 U Q; U is the displacement amplitude (of the rig, if any)."""
        force = self.tangential_force
        work = 4.0 * (self.tangential_displacement + self.problem.flexibility * force) * force
        return self.dissipated_energy / work if work else nan

    @scalar(
        "1",
        "energy sliding criterion",
        symbol="$B$",
        unit="1",
        is_at_snapshots=True,
        may_lack=True,
        error_kind="cycle",
    )
    def sliding_criterion(self) -> float:
        """Dissipated energy over 4 U0 Q, U0 half the loop's width at Q = 0; only at snapshots."""
        work = 4.0 * self.loop.opening * self.tangential_force
        return self.dissipated_energy / work if work else nan

    @scalar("m", "contact outline radius", symbol=r"$a_\mathrm{c}$", unit="µm", **_OUTLINE)
    def contact_radius(self) -> float:
        """Of a disc as large as the convex outline of the contact."""
        return _radius(
            self.state.geometry,
            self._regions[0].cells,
            self.contact_area,
            self.contact_half_width_x,
        )

    @scalar("m", "stick outline radius", symbol="$c$", unit="µm", **_OUTLINE)
    def stick_radius(self) -> float:
        """Of a disc as large as the convex outline of the stick zone."""
        return _radius(
            self.state.geometry, self.state.reduced.stick, self.stick_area, self.stick_half_width_x
        )

    @scalar(
        "m",
        "scar half-width along x",
        symbol="$b_x$",
        unit="µm",
        from_zero=False,
        error_kind="local",
    )
    def scar_half_width_x(self) -> float:
        """Half the extent over all lines, where the scar is deeper than 1 % of its maximum."""
        return self._scar[0]

    @scalar(
        "m",
        "scar half-width along y",
        symbol="$b_y$",
        unit="µm",
        from_zero=False,
        across=True,
        error_kind="local",
    )
    def scar_half_width_y(self) -> float:
        """Half the extent over all lines, where the scar is deeper than 1 % of its maximum."""
        return self._scar[1]

    @scalar("m", "contact half-width along x", symbol="$a_x$", unit="µm", **_ALONG_X)
    def contact_half_width_x(self) -> float:
        """Outermost edge on the line of cells nearest y = 0."""
        return self._half_widths[0][0]

    @scalar("m", "contact half-width along y", symbol="$a_y$", unit="µm", **_ALONG_Y)
    def contact_half_width_y(self) -> float:
        """Outermost edge on the line of cells nearest x = 0."""
        return self._half_widths[1][0]

    @scalar("m", "stick half-width along x", symbol="$c_x$", unit="µm", **_ALONG_X)
    def stick_half_width_x(self) -> float:
        """Outermost edge on the line of cells nearest y = 0."""
        return self._half_widths[0][1]

    @scalar("m", "stick half-width along y", symbol="$c_y$", unit="µm", **_ALONG_Y)
    def stick_half_width_y(self) -> float:
        """Outermost edge on the line of cells nearest x = 0."""
        return self._half_widths[1][1]

    @scalar("m2", "contact area", symbol=r"$A_\mathrm{c}$", error_kind="edge")
    def contact_area(self) -> float:
        """To the edge within cells: the integral of contact_fraction."""
        return self._zones[0].area

    @scalar("m2", "stick area", symbol=r"$A_\mathrm{stick}$", error_kind="edge")
    def stick_area(self) -> float:
        """To the edge within cells: the integral of stick_fraction."""
        return self._zones[1].area

    @scalar(
        "Pa",
        "mean stick pressure",
        symbol=r"$\bar{p}_\mathrm{stick}$",
        unit="MPa",
        may_lack=True,
        error_kind="stick",
    )
    def mean_stick_pressure(self) -> float:
        """Load over area; NaN where nothing sticks."""
        return self._stick_load / self.stick_area if self.stick_area else nan

    @scalar(
        "1",
        "stick share of the load",
        symbol=r"$P_\mathrm{stick}/P$",
        unit="%",
        may_lack=True,
        error_kind="stick",
    )
    def stick_load_share(self) -> float:
        """NaN where nothing sticks."""
        carries = self.stick_area and self._carried
        return self._stick_load / self._carried if carries else nan

    @scalar(
        "Pa",
        "peak pressure",
        symbol=r"$p_\mathrm{max}$",
        unit="MPa",
        is_headline=False,
        error_kind="peak",
    )
    def peak_pressure(self) -> float:
        """Of a single cell; its error is infinite if wear makes it singular at the stick edge."""
        pressure = self.state.pressure
        if self.problem.slip_model.follows_shape and not self.state.plastic.any():
            # The peak at the stick edge grows as rings get narrower, up to the plastic limit where
            # they are narrow enough to yield: take the mean over an annulus as wide as a cell.
            return self.state.geometry.largest_mean(pressure, min(self.problem.spacing))
        return float(pressure.max())

    @scalar(
        "Pa",
        "central pressure",
        symbol="$p(0)$",
        unit="MPa",
        is_headline=False,
        error_kind="local",
    )
    def central_pressure(self) -> float:
        """Of the cell nearest the origin, which may lie open in a valley of waves."""
        lines = self.state.geometry.axis_cells(0)
        return float(np.mean([self.state.pressure[line][0] for line, _ in lines]))

    @scalar("m3", "wear volume", symbol="$V$", **_VOLUME)
    def wear_volume(self) -> float:
        """Of both bodies since cycle 0."""
        return self.state.geometry.integral(self.state.wear)

    @scalar("m", "maximum wear depth", symbol=r"$w_\mathrm{max}$", error_kind="depth")
    def maximum_wear_depth(self) -> float:
        """Of both bodies together since cycle 0."""
        return float(self.state.wear.max())

    @scalar("m3", "plastic volume", error_kind="plastic")
    def plastic_volume(self) -> float:
        """Displaced since cycle 0."""
        return self.state.geometry.integral(self.state.plastic)

    @scalar(
        "J",
        "dissipated energy per cycle",
        symbol=r"$E_\mathrm{d}$",
        may_be_logarithmic=True,
        error_kind="cycle",
    )
    def dissipated_energy(self) -> float:
        """From +Q over -Q back to +Q."""
        return self.problem.dissipated_energy(self.state, self.state.geometry)

    @scalar(
        "m3",
        "wear volume of the indenter",
        symbol="$V_1$",
        needs=lambda measures: measures._wear_of_each,
        **_VOLUME,
    )
    def wear_volume_indenter(self) -> float:
        """Since cycle 0."""
        return self._volume(0, "indenter")

    @scalar(
        "m3",
        "wear volume of the flat",
        symbol="$V_2$",
        needs=lambda measures: measures._wear_of_each,
        **_VOLUME,
    )
    def wear_volume_flat(self) -> float:
        """Since cycle 0."""
        return self._volume(1, "flat")

    @cached_property
    def _flat_wear(self) -> Array:
        """Wear depth of a coated flat, m."""
        assert self.problem.interface is not None
        return self.state.flat_wear(self.problem.interface)

    @scalar(
        "1",
        "cycle of wear through the coating",
        symbol=r"$N_\mathrm{c}$",
        unit="1",
        needs=_is_coated,
        may_lack=True,
        error_kind="life",
    )
    def worn_through_cycle(self) -> float:
        """At its first place; NaN before."""
        return self.state.worn_through

    @scalar(
        "m2",
        "area of the exposed substrate",
        symbol=r"$A_\mathrm{s}$",
        needs=_is_coated,
        error_kind="edge",
    )
    def exposed_area(self) -> float:
        """Where the flat has worn by the thickness of its coating, to the edge within a cell."""
        assert self.problem.coating is not None
        return self.state.geometry.integral(
            deeper_fraction(self._flat_wear, self.problem.coating.thickness)
        )

    @scalar("m", "least thickness of the coating", symbol=r"$h_\mathrm{min}$", needs=_is_coated)
    def coating_left(self) -> float:
        """Zero once it is worn through."""
        assert self.problem.coating is not None
        return max(self.problem.coating.thickness - float(self._flat_wear.max()), 0.0)

    @scalar(
        "1",
        "mean coefficient of friction in the slip zone",
        symbol=r"$\bar{µ}$",
        unit="1",
        needs=lambda measures: measures.problem.friction_law.follows_slip,
        error_kind="edge",
    )
    def mean_slip_friction(self) -> float:
        """Weighted by pressure."""
        law, integral = self.problem.friction_law, self.state.geometry.integral
        slipping = np.where(self.state.reduced.stick, 0.0, self.state.pressure)
        return law.coefficient * integral(law.ratio * slipping) / integral(slipping)


_SCALARS = {scalar.variable.name: scalar for scalar in declared_scalars(Measures)}


def deeper_fraction(depth: Array, level: float) -> Array:
    """Fraction of each cell that is deeper than a level, m, by the change of depth across it."""
    change = np.zeros_like(depth)
    for axis in (axis for axis, count in enumerate(depth.shape) if count > 1):
        change += np.abs(np.gradient(depth, axis=axis))
    below = depth - (1.0 - _ON_LEVEL) * level
    return np.asarray(np.clip(0.5 + below / np.maximum(change, _ON_LEVEL**2 * level), 0.0, 1.0))


def half_widths(state: State, lines: Lines) -> tuple[float, float]:
    """Half-widths of contact and stick zone, m, on the lines of cells of an axis."""
    reduced, plane_strain = state.reduced, state.geometry.plane_strain
    closed = state.in_contact
    contact = half_width(lines, closed, state.gap, tips=True, plane_strain=plane_strain)
    # If the zone recedes because the bodies yield, the surface beside it has not worn yet.
    if state.plastic.any():
        stick = half_width(lines, reduced.stick, reduced.gap, plane_strain=plane_strain)
        return contact, stick
    return contact, stick_half_width(lines, reduced.pressure)


def scar_half_widths(state: State) -> tuple[float, float]:
    """Half the extents of the scar along x and y, m; equal on rings and strips."""
    geometry, depth = state.geometry, state.wear
    along_x = half_extent(geometry.x, depth.max(axis=1), is_even=geometry.even[0])
    if not isinstance(geometry, Grid) or geometry.plane_strain:
        return along_x, along_x
    return along_x, half_extent(geometry.y, depth.max(axis=0), is_even=geometry.even[1])


def _radius(geometry: Geometry, cells: Mask, area: float, half_width: float) -> float:
    """Radius of a zone of an area, m², on cells that are no finer at its edge, or its half-width.

    The area within its outline includes open cells in the zone.
    """
    if not isinstance(geometry, Grid) or geometry.plane_strain:
        return half_width
    open_cells = open_within_outline(cells, geometry.x, geometry.y, geometry.even)
    return sqrt(max(area + open_cells * geometry.unit_area, 0.0) / pi)


def _regions(
    problem: WearProblem, state: State, along_x: tuple[float, float]
) -> tuple[Region, Region]:
    """The regions of contact and of stick, whose half-widths along x are known, m."""
    contact, stick = along_x
    touching = Region(state.in_contact, contact, Evidence(state.pressure, state.gap, state.opening))
    worn = state.opening + state.plastic if problem.slip_model.follows_shape else None
    evidence = Evidence(state.reduced.pressure, state.reduced.gap, worn, by_pressure=True)
    return touching, Region(state.reduced.stick, stick, evidence, touching)


def fractions(problem: WearProblem, state: State, plane: Geometry) -> tuple[Array, Array]:
    """Fractions of each cell of a plane in contact and in stick; they integrate to the areas."""
    regions = _regions(problem, state, half_widths(state, state.geometry.axis_cells(0)))
    contact, stick = (state.geometry.covered(region, plane) for region in regions)
    return contact, stick


def share_beyond_friction(problem: WearProblem, state: State) -> float:
    """Share of the stick zone in which friction cannot bear µ (p − p*) of a slip model: p* > 2p."""
    stick, integral = state.reduced.pressure, state.geometry.integral
    whole = integral((stick > 0.0).astype(np.float64))
    borne = 2.0 * problem.friction_law.ratio * state.pressure
    overloaded = integral((stick > borne).astype(np.float64))
    return overloaded / whole if whole > 0.0 else 0.0


def largest_pressure(problem: WearProblem, state: State) -> float:
    """The largest pressure of a state, Pa, or what bounds it if the cells do not show it.

    Wear beside a stick zone moves pressure to its edge. If slip follows the shape, the pressure of
    elastic bodies there becomes singular after a finite number of cycles: the mean over the last of
    four equal cells is twice the mean over all of them, and likewise at the end of a punch. On a
    grid, whose cells at the edge are no narrower than others, the pressure counts as regular until
    wear has doubled the gap of the reduced contact beside the edge.
    """
    geometry, reduced, pressure = state.geometry, state.reduced, state.pressure
    if problem.rough is None and not isinstance(geometry, Grid):
        zones = (reduced.stick, pressure > 0.0)[: 1 + isfinite(problem.indenter.end)]
        ends = [int(np.flatnonzero(zone)[-1]) for zone in zones if zone.any()]
        last = [pressure[max(end - _ALONG + 1, 0) : end + 1] for end in ends]
        is_singular = any(bool(each[-1, 0] > _RESOLVED * each.mean()) for each in last)
    else:
        neighbours = geometry.zone(Region(reduced.stick, geometry.extent[0])).outside
        opened, gap = (field.ravel()[neighbours] for field in (state.opening, reduced.gap))
        is_singular = bool(problem.slip_model.follows_shape and (opened > _DOUBLED * gap).any())
    if not is_singular:
        return float(pressure.max())
    limit = np.broadcast_to(problem.limit_without_shear(state.wear), pressure.shape)
    return float(limit.flat[pressure.argmax()])


def half_width(
    lines: Lines, cells: Mask, gap: Array, *, tips: bool = False, plane_strain: bool = False
) -> float:
    """Distance of the outermost edge of a zone from the origin on the lines of an axis, m.

    Beyond the edge of a smooth contact the gap g grows with the power 3/2 of the distance, and
    linearly if the contact has worn in. The zero of r = e + b g^(2/3) + c g through three cells
    outside is the edge, kept between the centres of the last cell inside and the first one outside.
    With ``tips``, a tip farther out whose lowest point touches between centres is the edge.

    ``cells`` are the cells of the zone; ``gap``, m, is zero in the zone. The result is 0 if no cell
    on the lines belongs to the zone.
    """
    edges = []
    for line, distance in lines:
        edge = _edge(distance, cells[line], gap[line], plane_strain)
        if tips and edge > 0.0:
            edge = max([edge, *_touching_tips(line, distance, cells, gap)])
        edges.append(edge)
    return sum(edges) / len(edges)


def _edge(distance: Array, cells: Mask, gap: Array, plane_strain: bool) -> float:
    zone = np.flatnonzero(cells)
    if zone.size == 0:
        return 0.0
    last = int(zone[-1])
    x, outside = distance[last + 1 : last + 4], gap[last + 1 : last + 4]
    if outside.size < 2:
        return _border(distance, last)
    if plane_strain and outside.size == 3:
        # The gap of a line contact opens with the power 3/2, or linearly where it has worn. Both
        # laws through two cells predict the gap of the third; its place between the predictions
        # weights the zeros of both laws.
        powers = np.array([1.0, 1.5])
        near, far = outside[:2, None] ** (1.0 / powers)
        slopes = (far - near) / (x[1] - x[0])
        if (slopes > 0.0).all():
            zeros = x[0] - near / slopes
            predicted = (slopes * (x[2] - zeros)) ** powers
            weight = (outside[2] - predicted[0]) / (predicted[1] - predicted[0])
            weight = min(max(weight, 0.0), 1.0)
            # Strips may be so narrow that several outside the edge count as in contact.
            closed = distance[np.flatnonzero(gap[: last + 1] <= _NO_GAP * outside[0])]
            zero = (1.0 - weight) * zeros[0] + weight * zeros[1]
            return float(min(max(zero, closed[-1] if closed.size else 0.0), x[0]))
    center, first = float(distance[last]), float(x[0])
    near, far, *_ = roots = np.cbrt(outside)
    if outside.size == 3 and 0.0 < near < far < roots[2]:
        law = np.stack([np.ones(3), roots**2, outside], axis=1)
        edge = np.linalg.solve(law / law.max(axis=0), x)[0]
    elif far > near:
        near, far = near**2, far**2
        edge = first - near / (far - near) * (float(x[1]) - first)
    else:
        # Equal gaps do not determine the edge.
        edge = 0.5 * (center + first)
    return float(min(max(edge, center), first))


def stick_half_width(lines: Lines, pressure: Array) -> float:
    """Distance of the outermost edge of the stick zone from the origin on the lines of an axis, m.

    Near its edge the squared pressure p*, Pa, at the reduced load falls linearly in the square of
    the coordinate, exactly so for a sphere. The zero of that law through the cells next to the
    outermost one is the edge, kept within a cell of the outermost centre. Wear beside the stick
    zone does not change this pressure, so the edge of an elastic run does not move. The result is 0
    if no cell on the lines sticks.
    """
    edges = []
    for way, distance in lines:
        line = pressure[way]
        zone = np.flatnonzero(line > 0)
        if not zone.size:
            edges.append(0.0)
            continue
        last = int(zone[-1])
        center, edge = float(distance[last]), _border(distance, last)
        most = 2.0 * edge - center
        if last >= 2 and line[last - 1] > 0 and line[last - 2] > line[last - 1]:
            near, far = line[last - 1] ** 2, line[last - 2] ** 2
            inner, innermost = distance[last - 1] ** 2, distance[last - 2] ** 2
            edge = float(np.sqrt(inner + (inner - innermost) * near / (far - near)))
        edges.append(min(max(edge, center), most))
    return sum(edges) / len(edges)


def _touching_tips(line: Way, distance: Array, cells: Mask, gap: Array) -> list[float]:
    """Outer edges, m, of tips on a line that touch beyond the last cell of a zone, between centres.

    Parabolas along the line and across it have their vertices where the tip is lowest. A paraboloid
    of radius R that is pressed in by δ touches within √(Rδ).
    """
    here, last = gap[line], int(np.flatnonzero(cells[line])[-1])
    near, middle, far = here[last:-2], here[last + 1 : -1], here[last + 2 :]
    minima = last + 1 + np.flatnonzero((middle < near) & (middle <= far))
    if not minima.size:
        return []
    axis = 0 if isinstance(line[0], slice) else 1
    across, row = np.moveaxis(gap, axis, 0)[line[axis]], line[1 - axis]
    assert isinstance(row, int)
    rows = [min(max(neighbour, 0), across.shape[1] - 1) for neighbour in (row - 1, row, row + 1)]
    edges = []
    for tip in minima.tolist():
        place, bend, fall = _vertex(here[tip - 1 : tip + 2])
        *_, deeper = _vertex(across[tip, rows])
        lowest = float(here[tip]) - fall - deeper
        if lowest < 0.0:
            reach = place + min(sqrt(-lowest / bend), 0.5)
            edges.append(float(distance[tip] + reach * (distance[tip + 1] - distance[tip])))
    return edges


def _vertex(gaps: Array) -> tuple[float, float, float]:
    """The parabola through three cells: place of its vertex, second difference, fall to the vertex.

    The place is in cells from the middle one; up to rounding, the vertex must lie within that cell.
    """
    near, middle, far = gaps.tolist()
    rise, bend = 0.5 * (far - near), far + near - 2.0 * middle
    if bend <= 0.0 or abs(rise) > 0.501 * bend:
        return 0.0, max(bend, 0.0), 0.0
    return -rise / bend, bend, 0.5 * rise**2 / bend


def _border(distance: Array, last: int) -> float:
    """Outer border of a cell on an axis, halfway to the next one, m."""
    inner, outer = (last, last + 1) if last + 1 < distance.size else (last - 1, last)
    return float(distance[last] + 0.5 * (distance[outer] - distance[inner]))


def open_within_outline(cells: Mask, x: Array, y: Array, even: Even) -> int:
    """Number of cells inside the outline of a zone that do not belong to it, of those kept.

    The outline is the convex hull of the centres of the zone's cells and of their images where the
    zone is ``even``: valleys between tips and the middle of a ring count, and a tip that touches
    outside moves it little. ``x`` and ``y`` are the centres of the cells, m.
    """
    columns = np.flatnonzero(cells.any(axis=1))
    if not columns.size:
        return 0
    position, zone = x[columns], cells[columns]
    top = y[y.size - 1 - zone[:, ::-1].argmax(axis=1)]
    sides = [top] if even[1] else [top, -y[zone.argmax(axis=1)]]
    if even[0]:
        position = np.concatenate([-position[::-1], position])
        sides = [np.concatenate([ends[::-1], ends]) for ends in sides]
    held = x[np.searchsorted(x, position[0]) : columns[-1] + 1]
    slack = 1e-6 * float(position[-1] - position[0])
    highest, *lowest = (np.interp(held, *_highest_chords(position, ends)) for ends in sides)
    counts = np.searchsorted(y, highest + slack, "right")
    for ends in lowest:
        counts -= np.searchsorted(y, -ends - slack, "left")
    return int(counts.sum()) - int(cells.sum())


def outline_spots(first: State, second: State) -> tuple[int, int]:
    """Spots that moved the outline of the contact, and of the stick zone, from a state to another.

    Such a spot joined the zone or left it: it has no cell within a cell of the other state's zone,
    and the outline encloses fewer cells without it. A zone that begins or ends moves no outline.
    """
    geometry, found = second.geometry, []
    for old, new in (
        (first.in_contact, second.in_contact),
        (first.reduced.stick, second.reduced.stick),
    ):
        zones = first.geometry.resized(old, geometry), new
        found.append(sum(_moving_spots(geometry, *each) for each in (zones, zones[::-1])))
    return found[0], found[1]


def _moving_spots(geometry: Geometry, others: Mask, cells: Mask) -> int:
    """Number of spots of a zone that another zone lacks and that lie in no outline of the rest."""
    wide = np.pad(others, 1)
    wide = wide[:-2] | wide[1:-1] | wide[2:]
    near = wide[:, :-2] | wide[:, 1:-1] | wide[:, 2:]
    if not near.any() or not (cells & ~near).any():
        return 0

    from scipy.ndimage import label  # takes long, and smooth bodies do without

    spots, count = label(cells, np.ones((3, 3), np.bool_))
    alone = np.setdiff1d(np.arange(1, count + 1), spots[near])

    def enclosed(zone: Mask) -> int:
        return int(zone.sum()) + open_within_outline(zone, geometry.x, geometry.y, geometry.even)

    return sum(enclosed(cells) > enclosed(cells & (spots != spot)) for spot in alone)


def _highest_chords(x: Array, heights: Array) -> Array:
    """The corners of the upper convex hull of points in ascending x, shape (2, corners)."""
    points = np.array([x, heights])
    while points.shape[1] > 2:
        run, rise = np.diff(points)
        # A point that is not above the chord of its neighbours is no corner.
        above = rise[:-1] * run[1:] > rise[1:] * run[:-1]
        if above.all():
            break
        points = points[:, np.concatenate([[True], above, [True]])]
    return points


def half_extent(x: Array, depth: Array, *, is_even: bool) -> float:
    """Half the extent of a scar along an axis, m: between the outermost places on either side.

    Outside them, the scar is nowhere deeper than `_SHALLOW` of its maximum. ``depth``, m, is the
    largest on each line of cells across the axis at ``x``, m. The result is 0 if nothing is worn.
    """
    if not depth.any():
        return 0.0
    end = _scar_end(x, depth)
    return end if is_even else 0.5 * (end + _scar_end(-x[::-1], depth[::-1]))


def _scar_end(x: Array, depth: Array) -> float:
    """The outermost place at which a scar is as deep as `_SHALLOW` of its maximum, m.

    Beside an unworn cell the linear fall of the depth continues if it is steep enough to end there.
    At the edge of an unworn contact the depth falls more steeply, and ends anywhere in the cell.
    """
    level = _SHALLOW * float(depth.max())
    last = int(np.flatnonzero(depth > level)[-1])
    if last + 1 == x.size:
        return float(x[last])
    near, following, part = float(depth[last]), float(depth[last + 1]), 0.5
    previous = float(depth[last - 1]) if last else near
    if following > 0.0:
        part = (near - level) / (near - following)
    elif near - level < previous - near:
        part = (near - level) / (previous - near)
    return float(x[last] + part * (x[last + 1] - x[last]))
