"""Rules on several parameters of a case at once, by subject; each yields the mistakes.

Rules are checked once each parameter is valid by itself, and all broken ones are reported at once.
A rule declares the members of a case that it reads; it is not tried if one of them is unread or
invalid by itself.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence, Set
from dataclasses import dataclass
from inspect import signature

from fretwear.mechanics.slip.models import Jaeger, SlipModel
from fretwear.mechanics.surfaces.loading import (
    Displacement,
    DisplacementRatio,
    Loading,
    SlidingDistance,
    TangentialLoad,
    TangentialRatio,
)
from fretwear.mechanics.surfaces.materials import Friction
from fretwear.mechanics.surfaces.pressing import Imposed
from fretwear.mechanics.surfaces.setup import Setup
from fretwear.study.discretisation import Discretisation, rounded_down
from fretwear.study.mistakes import Mistake
from fretwear.units import BY_SI_UNIT, FORCE, LENGTH, PRESSURE, FloatWithUnit, format_quantity

# Largest contact radius over R. At its edge the paraboloid r²/2R, which stands for the sphere in
# half-space theory, is 1 % off the sphere, as much as the default tolerance allows.
GREATEST_CONTACT = 0.2
# Smallest Q/(µP). Its slip annulus is a 30 000th of the contact radius wide; in a tenth of that
# width slip is lost in the rounding of the displacements.
LEAST_LOAD_RATIO = 1e-4
LEAST_CELLS = 4.0  # across half of the contact; the energy of a sphere then errs by 20 %
MOST_STROKE = 20.0  # largest sliding amplitude computed, over the Hertz half-width
_GROSS_SLIP = "for gross slip write sliding_amplitude"

_Check = Callable[..., Iterator[Mistake]]


@dataclass(frozen=True)
class Rule:
    """A rule for every contact, and for each of its blocks."""

    check: _Check  #: yields the mistakes
    arguments: tuple[str, ...]  #: attributes of the case, or ``setup`` for the case itself
    members: frozenset[str]  #: members that it reads

    def broken_by(self, case: Setup) -> Iterator[Mistake]:
        """Yield the mistakes of a case."""
        values = (case if name == "setup" else getattr(case, name) for name in self.arguments)
        yield from self.check(*values)


RULES: list[Rule] = []


def rule(*members: str) -> Callable[[_Check], _Check]:
    """Register a rule on members of a setup; arguments besides ``setup`` are members too."""

    def registered(check: _Check) -> _Check:
        arguments = tuple(signature(check).parameters)
        RULES.append(Rule(check, arguments, frozenset({*members, *arguments} - {"setup", "cells"})))
        return check

    return registered


_HERTZ = "indenter", "bodies", "normal"
_UNWORN = *_HERTZ, "loading", "friction_law"
# What the cells of a case follow.
_CELLS = (
    *_UNWORN,
    "wear_law",
    "slip_model",
    "cycles",
    "blocks",
    "frequency",
    "debris_fraction",
    "coating",
)
_SURFACES = "indenter", "roughness", "counterface"


def _length(value: float, digits: int = 3) -> str:
    return format_quantity(value, LENGTH, digits)


def _of_other_units(setup: Setup, part: Imposed) -> Iterator[Mistake]:
    """Line contacts carry forces per length."""
    load = BY_SI_UNIT[setup.frame.unit(FORCE.si_unit)]
    for name, parameter in part.parameters().items():
        value, unit = vars(part)[name], parameter.in_frame(setup.frame).si_unit
        if isinstance(value, FloatWithUnit) and value.si_unit != unit:
            dimension = BY_SI_UNIT[value.si_unit].name
            rule = f"is {dimension}, but the load of this {setup.indenter.kind} is {load.name}"
            yield Mistake(name, parameter.text(value), rule, f"such as {name}: {load.example}")


@rule("indenter", "normal", "loading")
def _of_theory(setup: Setup, slip_model: SlipModel) -> Iterator[Mistake]:
    """Results must not be given if closed forms of the unworn contact do not know them."""
    normal, loading, kind = setup.normal, setup.loading, setup.indenter.kind
    is_closed, is_line = setup.indenter.has_closed_form, not setup.frame.has_depth
    if not normal.holds_load and (is_line or not is_closed):
        # The approach of a line contact depends on the choice of a reference.
        yield Mistake(normal.kind, None, f"cannot be given for a {kind}", "write load")
    if isinstance(loading, DisplacementRatio) and not is_closed:
        rule = f"is over the amplitude that slides the smooth contact, unknown for this {kind}"
        yield Mistake(loading.kind, None, rule, "write displacement_amplitude")
    elif isinstance(loading, Displacement):
        # The tangential compliance of a line contact depends on the size of the body.
        if not is_line and loading.tangential_compliance:
            yield Mistake("tangential_compliance", None, "is for line contacts")
        elif is_line and math.isfinite(loading.rig_stiffness):
            yield Mistake("rig_stiffness", None, "is part of tangential_compliance on a line")
        elif is_line and not loading.tangential_compliance:
            rule = f"needs tangential_compliance for a {kind}: it depends on the size of the body"
            yield Mistake(loading.kind, None, rule)
    if slip_model.kind == "cattaneo_mindlin" and kind not in ("sphere", "cylinder"):
        rule = f"is the closed form for a sphere or cylinder and does not describe this {kind}"
        yield Mistake("slip_model", slip_model.kind, rule)


@rule(*_HERTZ, "loading", "wear_law")
def _of_stroke(setup: Setup) -> Iterator[Mistake]:
    indenter, loading, law = setup.indenter, setup.loading, setup.wear_law
    name = next(iter(law.parameters()))
    if loading.stroke and not setup.normal.holds_load and setup.frame.has_depth:
        rule = "cannot be combined with sliding_amplitude, over which the load is held"
        yield Mistake(setup.normal.kind, None, rule)
    if loading.stroke and not all(indenter.even):
        rule = f"needs an indenter symmetric along x and y, which this {indenter.kind} is not"
        yield Mistake(loading.kind, None, rule)
    # Over a stroke, the wear of each body moves with the body.
    if loading.travel > setup.small_stroke and not law.is_of_each:
        rule = "is for both bodies together, but over a stroke each wears in a different place"
        yield Mistake(name, None, rule, "write pairs [value of the indenter, value of the flat]")
    if law.is_in_zones and not loading.stroke:
        rule = "has a rim and a core, which only a contact that slides as a whole has"
        yield Mistake(name, None, rule)


@rule(*_CELLS)
def _of_length_of_stroke(setup: Setup, cells: Discretisation) -> Iterator[Mistake]:
    loading, radius = setup.loading, setup.indenter.curvature_radius
    if not loading.stroke:
        return
    travel, length = loading.travel, _length(vars(loading)[loading.kind], 6)
    if travel > MOST_STROKE * setup.hertz_radius:
        rule = f"is more than {MOST_STROKE:g} times the {setup.frame.extent} of the contact"
        yield Mistake(loading.kind, length, rule)
    elif math.isinf(setup.indenter.end):
        reach = cells.scar_half_width + travel
        if reach > GREATEST_CONTACT * radius:
            rule = f"reaches to {_length(reach)} with the scar, beyond half-space theory"
            yield Mistake(loading.kind, length, rule)


@rule(*_SURFACES, "loading")
def _of_rough_strokes(setup: Setup) -> Iterator[Mistake]:
    loading, is_line = setup.loading, "y" not in setup.frame.axes
    for name, part in [*setup.surfaces.items()][1:] if loading.stroke or is_line else ():
        if not is_line:
            yield Mistake(name, part.kind, "cannot be combined with sliding_amplitude here")
        elif loading.stroke and name == "counterface" and setup.roughness is None:
            yield Mistake(name, part.kind, "is of the indenter, given only beside a rough flat")
        elif not (part.even[0] and math.isinf(part.finest[1])):
            rule = "cannot be on a line contact, which is even along x and uniform along y"
            yield Mistake(name, part.kind, rule)


@rule("normal", "loading", "friction_law", "wear_threshold", "junction_growth")
def _of_local_energy(setup: Setup, slip_model: SlipModel) -> Iterator[Mistake]:
    """Friction that follows slip, and a threshold of wear, need the slip of each place."""
    follows = setup.friction_law.follows_slip
    if setup.loading.stroke or setup.normal.pulsating_load < 1.0:
        rule = "follows the energy of each place, which strokes and pulsating loads do not have"
        keys = [follows and "friction", setup.wear_threshold and "wear_threshold"]
        yield from (Mistake(str(key), None, rule) for key in keys if key)
    if follows and (slip_model.couples or not slip_model.follows_shape):
        rule = f"cannot follow the dissipated energy with slip_model: {slip_model.kind}"
        yield Mistake("friction", None, rule, "write slip_model: cerruti")
    if follows and setup.junction_growth:
        yield Mistake("friction", None, "cannot follow the dissipated energy with junction_growth")


@rule("coating", "wear_law", "wear_threshold", "debris_fraction")
def _of_worn_coating(setup: Setup) -> Iterator[Mistake]:
    """Below the interface the wear coefficient is another constant times the same exposure."""
    if setup.coating is None or setup.coating.wear_coefficient is None:
        return
    key = "coating.wear_coefficient"
    if setup.wear_law.follows_contact or setup.wear_law.needs_frequency:
        rule = "cannot be combined with a wear coefficient that follows the contact"
        yield Mistake(key, None, rule, "give the case's as a number or a pair")
    if setup.wear_threshold:
        yield Mistake(key, None, "cannot be combined with wear_threshold", "leave one out")
    if setup.debris_fraction == 1.0:
        rule = "cannot be combined with debris_fraction: 1"
        yield Mistake(key, None, rule, "write debris_fraction: 0.999")


@rule("indenter", "normal", "loading", "coating", "wear_law", "friction_law")
def _of_coating(setup: Setup, slip_model: SlipModel) -> Iterator[Mistake]:
    """Coatings exclude closed forms of uncoated bodies and equal operators for p and q."""
    if setup.coating is None:
        return
    loading = setup.loading
    if setup.coating.plastic_limit is not None and (loading.stroke or setup.interface is None):
        what = (
            "sliding_amplitude" if loading.stroke else "wear coefficients that follow the contact"
        )
        rule = f"cannot be combined with {what}"
        yield Mistake("coating.plastic_limit", None, rule, "give plastic_limit for both")
    if slip_model.couples or not slip_model.follows_shape:
        rule = f"cannot be combined with slip_model: {slip_model.kind}"
        yield Mistake("coating", None, rule, "write slip_model: cerruti")
    if setup.normal.pulsating_load < 1.0 and not loading.stroke:
        rule = "cannot be combined with pulsating_load in partial slip"
        yield Mistake("coating", None, rule, "write sliding_amplitude for gross slip")
    if isinstance(loading, DisplacementRatio):
        rule = "is over the amplitude that slides the smooth contact, unknown with a coating"
        yield Mistake(loading.kind, None, rule, "write displacement_amplitude")
    elif isinstance(loading, Displacement) and not setup.frame.has_depth:
        rule = "cannot be given for a coated line contact, whose compliance is unknown"
        yield Mistake(loading.kind, None, rule, "write tangential_ratio")


@rule(*_CELLS, *_SURFACES, "plastic_limit", "junction_growth", "bulk_stress")
def _of_pulsating_load(
    setup: Setup, slip_model: SlipModel, cells: Discretisation
) -> Iterator[Mistake]:
    """Under a force Q in phase P falls to r P: µ(P − rP)/2 < Q < µrP, or all sticks, or slides."""
    least, ratio = setup.normal.pulsating_load, setup.tangential_ratio
    slides = setup.loading.is_force and ratio >= 1.0
    if least == 1.0 or setup.wears_unevenly or slides:
        return
    varies = setup.friction_law.kinks or setup.wear_law.follows_contact
    is_smooth = cells.is_graded and isinstance(slip_model, Jaeger)
    if varies or not (setup.loading.is_force and is_smooth) or math.isfinite(setup.plastic_limit):
        rule = (
            "works with strokes, and under a force for smooth elastic spheres, round punches and "
            "line contacts of constant friction and wear, with slip_model: jaeger"
        )
        yield Mistake("pulsating_load", f"{least:g}", rule)
    elif (lowest := max(ratio, 1.0 - 2.0 * ratio)) >= least:
        rule = f"must exceed {lowest:.3g}, Q/(µP) and 1 − 2Q/(µP), or all slides, or all sticks"
        yield Mistake("pulsating_load", f"{least:g}", rule)


@rule(*_UNWORN, "bulk_stress")
def _of_bulk_stress(setup: Setup, slip_model: SlipModel) -> Iterator[Mistake]:
    """A bulk stress moves the stick zone by e, R times the tilt; for e > a − c slip reverses."""
    if not setup.bulk_stress:
        return
    stress, hertz = format_quantity(setup.bulk_stress, PRESSURE), setup.hertz
    if not slip_model.follows_shape:
        rule = f"cannot be with slip_model: {slip_model.kind}"
        yield Mistake("bulk_stress", stress, rule)
    elif setup.normal.pulsating_load < 1.0:
        yield Mistake("bulk_stress", stress, "cannot be with pulsating_load")
    elif setup.stick_load > 0.0 and hertz.peak_pressure:
        most, moved = hertz.contact_radius - setup.stick_radius, setup.tilt * hertz.radius
        if moved > most:
            rule = "moves the stick zone beyond the contact, where slip reverses"
            yield Mistake("bulk_stress", stress, rule)


@rule(*_SURFACES, "frequency", "wear_law")
def _of_pairs_of_keys(
    setup: Setup, error_estimate: bool, accuracy: float, cell: object
) -> Iterator[Mistake]:
    # Files of earlier versions have the default accuracy beside each cell.
    if not error_estimate and math.isfinite(accuracy) and cell is None:
        yield Mistake("error_estimate", False, "leaves out the error estimates of an accuracy")
    if setup.frequency is None and setup.wear_law.needs_frequency:
        rule = f"is missing, on which the {setup.wear_law.kind} law of wear depends"
        yield Mistake("frequency", None, rule, "such as frequency: 5 Hz")
    for name, part in setup.surfaces.items():
        if part.mistake is not None:
            yield Mistake(name, None, *part.mistake)
    first, second = (getattr(part, "body", "") for part in (setup.roughness, setup.counterface))
    if first and first == second:
        yield Mistake("counterface.body", second, "is also the body of roughness")


@rule("loading", "friction_law")
def _of_load_ratio(setup: Setup) -> Iterator[Mistake]:
    """Under a force Q ≥ µP all slides, without a stick zone; too small a Q causes no slip."""
    loading, law = setup.loading, setup.friction_law
    if isinstance(loading, TangentialRatio):
        ratio = loading.tangential_ratio
        # If friction follows slip, Q does not change with it.
        if ratio >= (law.least / law.coefficient if law.follows_slip else 1.0):
            rule = "is gross sliding: Q/(µP) must be less than 1, also with the least friction"
            yield Mistake(loading.kind, f"{ratio:.6g}", rule, _GROSS_SLIP)
        yield from _of_least_ratio(loading, ratio)


@rule("normal", "loading", "friction_law")
def _of_force(setup: Setup) -> Iterator[Mistake]:
    """Like the ratio, with load and force given: reports the force with its unit."""
    loading, load = setup.loading, setup.normal.held[0]
    unit = getattr(vars(loading).get("tangential_load"), "si_unit", "")
    if isinstance(loading, TangentialLoad) and load is not None and unit:
        yield from _of_force_under(loading, setup.friction_law, load, unit)


@rule(*_UNWORN)
def _of_unworn_ratio(setup: Setup) -> Iterator[Mistake]:
    """Like the ratio, which follows from an approach, a displacement or plain numbers."""
    loading = setup.loading
    unit = getattr(vars(loading).get("tangential_load"), "si_unit", "")
    if not isinstance(loading, TangentialRatio | TangentialLoad):
        yield from _of_least_ratio(loading, setup.tangential_ratio)
    elif isinstance(loading, TangentialLoad) and not (unit and setup.normal.held[0]):
        unit = unit or setup.frame.unit(FORCE.si_unit)
        yield from _of_force_under(loading, setup.friction_law, setup.hertz.load, unit)


def _of_force_under(
    loading: TangentialLoad, law: Friction, load: float, unit: str
) -> Iterator[Mistake]:
    force, limit = loading.tangential_load, law.least * load
    if force >= limit:
        force_text, most = (format_quantity(each, BY_SI_UNIT[unit]) for each in (force, limit))
        rule = f"is gross sliding: Q must be less than µP = {most}"
        yield Mistake(loading.kind, force_text, rule, _GROSS_SLIP)
    yield from _of_least_ratio(loading, loading.load_ratio(law.coefficient, load))


def _of_least_ratio(loading: Loading, ratio: float) -> Iterator[Mistake]:
    if ratio < LEAST_LOAD_RATIO:
        rule = f"leaves no slip to compute: Q/(µP) is {ratio:.3g} and must be at least"
        yield Mistake(loading.kind, None, f"{rule} {LEAST_LOAD_RATIO:g}")


@rule(*_HERTZ)
def _of_size(setup: Setup) -> Iterator[Mistake]:
    largest, excess = _largest_contact(setup)
    if setup.hertz_radius > largest:
        load, approach = setup.normal.held
        unit = BY_SI_UNIT[setup.frame.unit(FORCE.si_unit)]
        amount = _length(approach or 0.0, 6) if load is None else format_quantity(load, unit)
        rule = f"is too much for this {setup.indenter.kind}: {excess}"
        yield Mistake(setup.normal.kind, amount, rule)


@rule(*_UNWORN, "plastic_limit", "junction_growth", "coating")
def _of_limit(setup: Setup) -> Iterator[Mistake]:
    """The capped pressure must carry P on a contact that half-space theory can describe.

    A contact of radius r carries at most p_lim·πr², so carrying P takes a radius of at least √(P/(π
    p_lim)). This must not exceed `GREATEST_CONTACT`·R; in gross sliding, with the limit reduced by
    friction. Wear without plastic flow stays far below.
    """
    largest, excess = _largest_contact(setup)
    shear = setup.shear_on_limit if setup.tangential_ratio >= 1.0 else 1.0
    limits = dict(
        zip(("coating.plastic_limit", "plastic_limit"), setup.plastic_limits, strict=True)
    )
    if limits["coating.plastic_limit"] == limits["plastic_limit"]:
        del limits["coating.plastic_limit"]
    for key, limit in limits.items():
        if shear * limit < setup.hertz.spread_pressure(largest):
            limit_text = format_quantity(limit, PRESSURE)
            yield Mistake(key, limit_text, f"is too low to carry the load without {excess}")


def _largest_contact(setup: Setup) -> tuple[float, str]:
    """The radius of the largest contact, m, and in words what a larger contact would exceed."""
    end = setup.indenter.end
    if math.isfinite(end):
        return end, f"a contact of more than {_length(end)}, where the punch ends"
    largest = GREATEST_CONTACT * setup.indenter.curvature_radius
    return largest, f"a contact of more than {_length(largest)}, the most in half-space theory"


@rule(*_SURFACES)
def _of_cell(setup: Setup, cell: tuple[float, float] | None) -> Iterator[Mistake]:
    """Waves and edges of the surfaces need enough cells."""
    if cell is None:
        return
    spacings = f"[{', '.join(format_quantity(spacing, LENGTH) for spacing in cell)}]"
    for name, part in setup.surfaces.items():
        least = part.cells // 2
        for axis, length, spacing in zip("xy", part.finest, cell, strict=True):
            if spacing > length / least * (1.0 + 1e-9):
                rule = (
                    f"is too coarse for the {name}: the {part.detail} along {axis} is "
                    f"{_length(length)} long and needs at least {least} cells"
                )
                yield Mistake("cell", spacings, rule, "or leave cell out")


@rule(*_HERTZ, "loading")
def _of_cell_under_the_contact(setup: Setup, cell: tuple[float, float] | None) -> Iterator[Mistake]:
    """The contact of the smooth bodies needs some cells: with fewer, results err by tens of %.

    Over a stroke the scar soon is much wider than this contact, and tells how coarse cells may be.
    """
    widths = setup.indenter.half_widths(setup.hertz) if cell and not setup.loading.stroke else ()
    for axis, half_width, spacing in zip("xy", widths, cell or (), strict=False):
        if spacing > half_width / LEAST_CELLS:
            rule = f"is too coarse for the contact, whose half-width along {axis} is"
            most = _length(rounded_down(half_width / LEAST_CELLS, 3))
            yield Mistake(
                "cell",
                _length(spacing),
                f"{rule} {_length(half_width)}",
                f"at most {most}, or leave cell out",
            )
            return


@rule()
def _of_snapshots(cycles: int, output_cycles: tuple[int, ...]) -> Iterator[Mistake]:
    if late := [str(cycle) for cycle in output_cycles if cycle > cycles]:
        rule = f"is beyond the last cycle, {cycles}"
        yield Mistake("output_cycles", ", ".join(late), rule)


def findings(
    case: Setup, unread: Set[str] = frozenset(), blocks: Sequence[Setup | None] = ()
) -> list[Mistake]:
    """Return the mistakes of a case whose values are each valid by themselves.

    ``unread`` are its members that could not be read. ``blocks`` are the case in each of its
    blocks, None if that is invalid.
    """
    broken = _broken(case, unread)
    return [*broken, *_of_blocks(blocks, broken, unread)]


def _broken(case: Setup, unread: Set[str]) -> list[Mistake]:
    """The mistakes of a case; rules that read an unread member are not tried."""
    broken: list[Mistake] = []
    for name in ("normal", "loading"):
        if not unread & {"indenter", name}:
            broken += (refused := [*_of_other_units(case, getattr(case, name))])
            unread = {*unread, name} if refused else unread
    known = (rule for rule in RULES if not rule.members & unread)
    return broken + [mistake for rule in known for mistake in rule.broken_by(case)]


def _of_blocks(
    blocks: Sequence[Setup | None], of_base: Sequence[Mistake], unread: Set[str]
) -> Iterator[Mistake]:
    """The mistakes of the blocks that the base does not have."""
    valid = [block for block in blocks if block is not None]
    if len(valid) < len(blocks):
        yield Mistake("blocks", None, "has a block that lacks a parameter of its loading")
    for name, mistakes in (
        ("sliding_amplitude", {bool(block.loading.stroke) for block in valid}),
        ("pulsating_load", {block.normal.pulsating_load < 1.0 for block in valid}),
        ("friction that follows slip", {block.friction_law.follows_slip for block in valid}),
    ):
        if len(mistakes) > 1:
            rule = f"has blocks with {name} and blocks without: give it in all or in none"
            yield Mistake("blocks", None, rule)
    if any(isinstance(block.loading, SlidingDistance) for block in valid):
        rule = "cannot be combined with sliding_distance, which is for the whole run"
        yield Mistake("blocks", None, rule)
    for number, block in enumerate(valid, start=1):
        for mistake in _broken(block, unread):
            if mistake not in of_base:
                value = f" = {mistake.value}" if mistake.value else ""
                rule = f"{mistake.key}{value} in block {number} {mistake.rule}"
                yield Mistake("blocks", None, rule, mistake.remedy)
