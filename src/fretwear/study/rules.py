"""Rules on several parameters of a case at once, by subject; each yields what breaks it.

Each parameter is valid by itself when they are checked; all broken rules are reported at once.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from contextlib import suppress

from fretwear.mechanics.slip.models import Jaeger
from fretwear.mechanics.surfaces.loading import (
    Displacement,
    DisplacementRatio,
    SlidingDistance,
    TangentialLoad,
    TangentialRatio,
)
from fretwear.study.contact import FrettingContact, UnknownValueError
from fretwear.study.mistakes import Mistake
from fretwear.units import (
    BY_SI_UNIT,
    FORCE,
    LENGTH,
    PRESSURE,
    FloatWithUnit,
    format_quantity,
)

# Largest contact radius over R. At its edge the paraboloid r²/2R, which stands for the sphere in
# half-space theory, is 1 % off the sphere, as much as the default tolerance allows.
GREATEST_CONTACT = 0.2
# Smallest Q/(µP). Its slip annulus is a 30 000th of the contact radius wide; in one a tenth as
# wide, slip is lost in the rounding of the displacements.
LEAST_LOAD_RATIO = 1e-4
MOST_STROKE = 20.0  # largest sliding amplitude computed, over the Hertz half-width

Rules = Callable[[FrettingContact], Iterator[Mistake]]


def _length(value: float, digits: int = 3) -> str:
    return format_quantity(value, LENGTH, digits)


def _units_of_loads(case: FrettingContact) -> Iterator[Mistake]:
    """Line contacts carry forces per length."""
    load = BY_SI_UNIT[case.frame.unit(FORCE.si_unit)]
    for part in (case.normal, case.loading):
        for name, about in part.parameters().items():
            value, unit = vars(part)[name], about.in_frame(case.frame).si_unit
            if isinstance(value, FloatWithUnit) and value.si_unit != unit:
                given = BY_SI_UNIT[value.si_unit].name
                rule = f"is {given}, but the load of this {case.indenter.kind} is {load.name}"
                yield Mistake(name, about.text(value), rule, f"such as {name}: {load.example}")


def _of_theory(case: FrettingContact) -> Iterator[Mistake]:
    """What closed forms of the unworn contact do not know cannot be given."""
    normal, loading, kind, model = case.normal, case.loading, case.indenter.kind, case.slip_model
    is_closed, is_line = case.indenter.has_closed_form, not case.frame.has_depth
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
    if model.kind == "cattaneo_mindlin" and kind not in ("sphere", "cylinder"):
        rule = f"is the closed form for a sphere or cylinder and does not describe this {kind}"
        yield Mistake("slip_model", model.kind, rule)


def _of_stroke(case: FrettingContact) -> Iterator[Mistake]:
    indenter, loading, law = case.indenter, case.loading, case.wear_law
    travel, is_line = loading.travel, "y" not in case.frame.axes
    if loading.stroke and not case.normal.holds_load and case.frame.has_depth:
        rule = "cannot be combined with sliding_amplitude, over which the load is held"
        yield Mistake(case.normal.kind, None, rule)
    if loading.stroke and not all(indenter.even):
        rule = f"needs an indenter symmetric along x and y, which this {indenter.kind} is not"
        yield Mistake(loading.kind, None, rule)
    # Over a stroke, the wear of each body moves with the body.
    if travel > case.small_stroke and not law.is_of_each:
        name = next(iter(law.parameters()))
        rule = "is for both bodies together, but over a stroke each wears in a different place"
        yield Mistake(name, None, rule, "write pairs [value of the indenter, value of the flat]")
    if law.is_in_zones and not loading.stroke:
        rule = "has a rim and a core, which only a contact that slides as a whole has"
        yield Mistake(next(iter(law.parameters())), None, rule)
    if loading.stroke:
        reach, radius = case.scar_half_width + travel, indenter.curvature_radius
        if travel > MOST_STROKE * case.hertz_radius:
            rule = f"is more than {MOST_STROKE:g} times the {case.frame.extent} of the contact"
            yield Mistake(loading.kind, _length(travel, 6), rule)
        elif reach > GREATEST_CONTACT * radius and math.isinf(indenter.end):
            rule = f"reaches to {_length(reach)} with the scar, beyond half-space theory"
            yield Mistake(loading.kind, _length(travel, 6), rule)
    for name, part in [*case.surfaces.items()][1:] if loading.stroke or is_line else ():
        if not is_line:
            yield Mistake(name, part.kind, "cannot be combined with sliding_amplitude here")
        elif loading.stroke and name == "counterface" and case.roughness is None:
            yield Mistake(name, part.kind, "is of the indenter, given only beside a rough flat")
        elif not (part.even[0] and math.isinf(part.finest[1])):
            rule = "cannot be on a line contact, which is even along x and uniform along y"
            yield Mistake(name, part.kind, rule)


def _of_local_energy(case: FrettingContact) -> Iterator[Mistake]:
    """Friction that follows slip and a threshold of wear need the slip of each place."""
    keys = [case.friction_law.follows_slip and "friction", case.wear_threshold and "wear_threshold"]
    for key in filter(None, keys):
        if case.loading.stroke or case.normal.pulsating_load < 1.0:
            rule = "follows the energy of each place, which strokes and pulsating loads do not have"
            yield Mistake(str(key), None, rule)
    if not case.friction_law.follows_slip:
        return
    if case.slip_model.couples or not case.slip_model.follows_shape:
        rule = f"cannot follow the dissipated energy with slip_model: {case.slip_model.kind}"
        yield Mistake("friction", None, rule, "write slip_model: cerruti")
    if case.junction_growth:
        yield Mistake("friction", None, "cannot follow the dissipated energy with junction_growth")


def _of_pulsating_load(case: FrettingContact) -> Iterator[Mistake]:
    """Under a force Q in phase, P falls to r P: µ(P − rP)/2 < Q < µrP, or all sticks, or slides."""
    least, ratio = case.normal.pulsating_load, case.tangential_ratio
    slides = case.loading.is_force and ratio >= 1.0
    if least == 1.0 or case.wears_unevenly or slides:
        return
    varies = case.friction_law.kinks or case.wear_law.follows_contact
    is_smooth = case.is_graded and isinstance(case.slip_model, Jaeger)
    if varies or not (case.loading.is_force and is_smooth) or math.isfinite(case.plastic_limit):
        rule = (
            "works with strokes, and under a force for smooth elastic spheres, round punches and "
            "line contacts of constant friction and wear, with slip_model: jaeger"
        )
        yield Mistake("pulsating_load", f"{least:g}", rule)
    elif (lowest := max(ratio, 1.0 - 2.0 * ratio)) >= least:
        rule = f"must exceed {lowest:.3g}, Q/(µP) and 1 − 2Q/(µP), or all slides, or all sticks"
        yield Mistake("pulsating_load", f"{least:g}", rule)


def _of_bulk_stress(case: FrettingContact) -> Iterator[Mistake]:
    """It moves the stick zone by e, R times the tilt; where e exceeds a − c, slip reverses."""
    if not case.bulk_stress:
        return
    given, hertz = format_quantity(case.bulk_stress, PRESSURE), case.hertz
    if not case.slip_model.follows_shape:
        rule = f"cannot be with slip_model: {case.slip_model.kind}"
        yield Mistake("bulk_stress", given, rule)
    elif case.normal.pulsating_load < 1.0:
        yield Mistake("bulk_stress", given, "cannot be with pulsating_load")
    elif case.stick_load > 0.0 and hertz.peak_pressure:
        most, moved = hertz.contact_radius - case.stick_radius, case.tilt * hertz.radius
        if moved > most:
            rule = "moves the stick zone beyond the contact, where slip reverses"
            yield Mistake("bulk_stress", given, rule)


def _of_pairs_of_keys(case: FrettingContact) -> Iterator[Mistake]:
    if not case.error_estimate and math.isfinite(case.accuracy):
        yield Mistake("error_estimate", False, "leaves out the error estimates of an accuracy")
    if case.frequency is None and case.wear_law.needs_frequency:
        rule = f"is missing, on which the {case.wear_law.kind} law of wear depends"
        yield Mistake("frequency", None, rule, "such as frequency: 5 Hz")
    for name, part in case.surfaces.items():
        if part.mistake is not None:
            yield Mistake(name, None, *part.mistake)
    first, second = (getattr(part, "body", "") for part in (case.roughness, case.counterface))
    if first and first == second:
        yield Mistake("counterface.body", second, "is also the body of roughness")


def _of_partial_slip(case: FrettingContact) -> Iterator[Mistake]:
    """Under a force Q ≥ µP all slides, without a stick zone; too small a Q slips nowhere."""
    loading, law, hint = case.loading, case.friction_law, "for gross slip write sliding_amplitude"
    if isinstance(loading, TangentialRatio):
        ratio = loading.tangential_ratio
        # Q stays as it is where friction follows slip.
        if ratio >= (law.least / law.coefficient if law.follows_slip else 1.0):
            rule = "is gross sliding: Q/(µP) must be less than 1, also with the least friction"
            yield Mistake(loading.kind, f"{ratio:.6g}", rule, hint)
    elif isinstance(loading, TangentialLoad):
        load = case.normal.given[0] or case.hertz.load
        ratio = loading.load_ratio(law.coefficient, load)
        if loading.tangential_load >= (limit := law.least * load):
            of_given = getattr(loading.tangential_load, "si_unit", "")
            unit = BY_SI_UNIT[of_given or case.frame.unit(FORCE.si_unit)]
            rule = f"is gross sliding: Q must be less than µP = {format_quantity(limit, unit)}"
            given = format_quantity(loading.tangential_load, unit)
            yield Mistake(loading.kind, given, rule, hint)
    else:
        ratio = case.tangential_ratio
    if ratio < LEAST_LOAD_RATIO:
        rule = f"leaves no slip to compute: Q/(µP) is {ratio:.3g} and must be at least"
        yield Mistake(loading.kind, None, f"{rule} {LEAST_LOAD_RATIO:g}")


def _of_size(case: FrettingContact) -> Iterator[Mistake]:
    """The capped pressure must carry P on a contact that half-space theory can describe.

    A contact of radius r carries at most p_lim·πr², so carrying P takes a radius of at least
    √(P/(π p_lim)), which must not exceed `GREATEST_CONTACT`·R; where all slides, by the limit that
    friction lowers. Wear without plastic flow stays far below.
    """
    indenter, is_finite = case.indenter, math.isfinite(case.indenter.end)
    largest = indenter.end if is_finite else GREATEST_CONTACT * indenter.curvature_radius
    where = "where the punch ends" if is_finite else "the most in half-space theory"
    beyond = f"a contact of more than {_length(largest)}, {where}"
    if case.hertz_radius > largest:
        load, approach = case.normal.given
        unit = BY_SI_UNIT[case.frame.unit(FORCE.si_unit)]
        given = _length(approach or 0.0, 6) if load is None else format_quantity(load, unit)
        yield Mistake(case.normal.kind, given, f"is too much for this {indenter.kind}: {beyond}")
    limit = case.slip_limit if case.tangential_ratio >= 1.0 else case.plastic_limit
    if limit < case.hertz.spread_pressure(largest):
        given = format_quantity(case.plastic_limit, PRESSURE)
        yield Mistake("plastic_limit", given, f"is too low to carry the load without {beyond}")


def _of_cell(case: FrettingContact) -> Iterator[Mistake]:
    """Waves and edges of the surfaces need enough cells."""
    if case.cell is None:
        return
    given = f"[{', '.join(format_quantity(spacing, LENGTH) for spacing in case.cell)}]"
    for name, part in case.surfaces.items():
        least = part.cells // 2
        for axis, length, cell in zip("xy", part.finest, case.cell, strict=True):
            if cell > length / least * (1.0 + 1e-9):
                rule = (
                    f"is too coarse for the {name}: the {part.detail} along {axis} is "
                    f"{_length(length)} long and needs at least {least} cells"
                )
                yield Mistake("cell", given, rule, "or leave cell out")


# Rules of every case without blocks, and of each block of a case.
_RULES: tuple[Rules, ...] = (
    _of_theory,
    _of_pairs_of_keys,
    _of_stroke,
    _of_local_energy,
    _of_pulsating_load,
    _of_bulk_stress,
    _of_partial_slip,
    _of_size,
    _of_cell,
)


def _of_blocks(case: FrettingContact) -> Iterator[Mistake]:
    """The mistakes of the blocks that the base has not too."""
    if not case.blocks:
        return
    blocks = [block for _, block in case.in_blocks() if block is not None]
    if len(blocks) < len(case.blocks):
        yield Mistake("blocks", None, "has a block that lacks a parameter of its loading")
    for name, given in (
        ("sliding_amplitude", {bool(block.loading.stroke) for block in blocks}),
        ("pulsating_load", {block.normal.pulsating_load < 1.0 for block in blocks}),
        ("friction that follows slip", {block.friction_law.follows_slip for block in blocks}),
    ):
        if len(given) > 1:
            rule = f"has blocks with {name} and blocks without: give it in all or in none"
            yield Mistake("blocks", None, rule)
    if any(isinstance(block.loading, SlidingDistance) for block in blocks):
        rule = "cannot be combined with sliding_distance, which is for the whole run"
        yield Mistake("blocks", None, rule)
    of_base = _broken(case)
    for number, block in enumerate(blocks, start=1):
        for mistake in _broken(block):
            if mistake not in of_base:
                value = f" = {mistake.value}" if mistake.value else ""
                rule = f"{mistake.key}{value} in block {number} {mistake.rule}"
                yield Mistake("blocks", None, rule, mistake.remedy)


def _broken(case: FrettingContact) -> list[Mistake]:
    """The rules that a case breaks, without those whose values could not be read or are refused."""
    broken: list[Mistake] = []
    with suppress(UnknownValueError):
        broken += _units_of_loads(case)
    case = case.without({mistake.key for mistake in broken})
    for rules in _RULES:
        with suppress(UnknownValueError):
            for mistake in rules(case):
                broken.append(mistake)
    return broken


def findings(case: FrettingContact) -> list[Mistake]:
    """Return the mistakes of a case, each of whose values is valid by itself."""
    broken = _broken(case)
    with suppress(UnknownValueError):
        broken += [*_of_snapshots(case), *_of_blocks(case)]
    return broken


def _of_snapshots(case: FrettingContact) -> Iterator[Mistake]:
    last = case.cycles
    if beyond := [str(cycle) for cycle in case.output_cycles if cycle > last]:
        rule = f"is beyond the last cycle, {last}"
        yield Mistake("output_cycles", ", ".join(beyond), rule)
