"""Rules on several parameters of a case at once.

Each rule names the parameters it needs, so that rules with valid parameters can be checked while
others are still wrong: all problems of a study file are reported at once.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING

from fretwear.mechanics.slip.loading import (
    Displacement,
    DisplacementRatio,
    SlidingDistance,
    TangentialRatio,
)
from fretwear.mechanics.slip.models import Jaeger
from fretwear.mechanics.wear.laws import FallingCoefficient
from fretwear.study.problems import Problem
from fretwear.study.spacing import cell_text, rounded_down
from fretwear.units import (
    BY_SI_UNIT,
    FORCE,
    LENGTH,
    PRESSURE,
    FloatWithUnit,
    format_quantity,
)

if TYPE_CHECKING:
    from fretwear.study.case import Case

LEAST_CELLS_PER_CONTACT_RADIUS = 8
LEAST_CELLS_PER_STICK_RADIUS = 2
LEAST_CELLS_PER_SLIP_ANNULUS = 1

# Largest contact radius over R. At its edge the paraboloid r²/2R, which stands for the sphere in
# half-space theory, is 1 % off the sphere, as much as the default tolerance allows.
GREATEST_CONTACT = 0.2
# Smallest Q/(µP). Its slip annulus is a 30 000th of the contact radius wide; in one a tenth as
# wide, slip is lost in the rounding of the displacements.
LEAST_LOAD_RATIO = 1e-4
MOST_STROKE = 20.0  # largest sliding amplitude computed, over the Hertz half-width

# The least ratio, refused as a fraction, that is likely to be meant in per cent.
_LEAST_PERCENT = 5.0
_PARTIAL_SLIP = "partial slip needs a ratio between 0 and 1, such as 0.8"
_GROSS_SLIP = "for gross slip write displacement_amplitude or sliding_amplitude instead"
_CONTACT = "indenter bodies normal "


Rule = Callable[["Case"], Iterator[Problem]]
_OF_BLOCKS = list[Rule]()


def _rule(broken: Rule) -> Rule:
    """A rule of every case without blocks, and of each block of a case."""
    _OF_BLOCKS.append(broken)
    return broken


def _first(rule: Rule, case: Case) -> Problem | None:
    """The first problem of a case that breaks a rule; None if it keeps it."""
    return next(rule(case), None)


def _length(value: float, digits: int = 3) -> str:
    return format_quantity(value, LENGTH, digits)


def _force(case: Case, load: float, digits: int = 6) -> str:
    dimension = BY_SI_UNIT[case.frame.unit(FORCE.si_unit)]
    # N/µm suits only the stiffness of a rig.
    usual = tuple(unit for unit in dimension.units if unit.size < 1e6)
    return format_quantity(load, replace(dimension, units=usual), digits)


@_rule
def _loads_suit(case: Case) -> Iterator[Problem]:
    load = BY_SI_UNIT[case.frame.unit(FORCE.si_unit)]
    for part in (case.normal, case.loading):
        for name, about in part.parameters().items():
            value = vars(part)[name]
            if (
                isinstance(value, FloatWithUnit)
                and value.si_unit != about.in_frame(case.frame).si_unit
            ):
                given = BY_SI_UNIT[value.si_unit].name
                rule = f"is {given}, but the load of this {case.indenter.kind} is {load.name}"
                hint = f"such as {name}: {load.example}"
                if not case.frame.has_depth:
                    hint += ", the force over the length of the contact"
                yield Problem(name, about.text(value), rule, hint)


@_rule
def _reference_is_known(case: Case) -> Iterator[Problem]:
    """Approach and displacement of a line contact depend on the choice of a reference.

    Quantities in units of the smooth contact need it to be known before the run.
    """
    kind, loading, has_depth = case.indenter.kind, case.loading, case.frame.has_depth
    if not (case.normal.holds_load or has_depth):
        rule = f"cannot be given for a {kind}: the depth of a line contact has no natural zero"
        yield Problem(case.normal.kind, None, rule, "write load: 18.5 N/mm")
    elif not case.normal.holds_load and not case.indenter.has_closed_form:
        rule = f"cannot be given for a {kind}, whose smooth contact is not known before the run"
        yield Problem(case.normal.kind, None, rule, "write load: 50 N")
    if isinstance(loading, Displacement) and not has_depth and math.isfinite(loading.rig_stiffness):
        rule = f"is not for a {kind}, whose tangential_compliance includes the rig"
        yield Problem("rig_stiffness", None, rule, "leave rig_stiffness out")
    if isinstance(loading, Displacement) and not (has_depth or loading.tangential_compliance):
        rule = f"needs tangential_compliance for a {kind}: it depends on the size of the body"
        hint = (
            "write tangential_compliance: 0.1 um/(N/mm), the slope of the loop after a reversal, "
            "or give sliding_amplitude or tangential_ratio instead"
        )
        yield Problem(loading.kind, None, rule, hint)
    if isinstance(loading, DisplacementRatio) and not case.indenter.has_closed_form:
        rule = "is in units of the amplitude that slides a smooth contact as a whole, unknown for"
        hint = "write displacement_amplitude: 1 um"
        yield Problem(loading.kind, None, f"{rule} this {kind}", hint)


@_rule
def _compliance_is_of_a_line(case: Case) -> Iterator[Problem]:
    given = isinstance(case.loading, Displacement) and case.loading.tangential_compliance
    if given and case.frame.has_depth:
        rule = (
            f"is for line contacts: the load of this {case.indenter.kind} determines its compliance"
        )
        hint = "write rig_stiffness for a compliant rig"
        yield Problem("tangential_compliance", None, rule, hint)


@_rule
def _accuracy_needs_estimates(case: Case) -> Iterator[Problem]:
    if math.isfinite(case.accuracy) and not case.error_estimate:
        rule = "leaves out the error estimates that an accuracy needs"
        yield Problem("error_estimate", False, rule, "give one of the two")


@_rule
def _line_has_one_spacing(case: Case) -> Iterator[Problem]:
    if case.cell is not None and case.cell[0] != case.cell[1] and "y" not in case.frame.axes:
        rule = f"has a spacing along y, along which a {case.indenter.kind} is the same everywhere"
        yield Problem("cell", cell_text(case.cell), rule, f"write cell: {_length(case.cell[0], 6)}")


@_rule
def _stroke_is_even(case: Case) -> Iterator[Problem]:
    indenter, normal = case.indenter, case.normal
    if case.loading.stroke and not normal.holds_load and case.frame.has_depth:
        rule = "cannot be combined with sliding_amplitude, over which the load is held"
        yield Problem(normal.kind, None, rule, f"write load: {_force(case, case.hertz.load, 3)}")
    elif case.loading.stroke and not all(indenter.even):
        rule = f"needs an indenter symmetric along x and y, which this {indenter.kind} is not"
        yield Problem(case.loading.kind, None, rule, "turn its axes into x and y")


@_rule
def _load_pulsates_with_stroke_or_force(case: Case) -> Iterator[Problem]:
    """Under a force Q in phase, P falls to r P: µ(P − rP)/2 < Q < µrP, or all sticks, or slides."""
    least = case.normal.pulsating_load
    if least == 1.0 or case.wears_unevenly:
        return
    ratio = case.tangential_ratio
    if case.loading.is_force and ratio >= 1.0:
        return
    hint = "write sliding_amplitude: 25 um, or leave pulsating_load out"
    constant = case.friction_law.kinks or case.wear_law.follows_contact
    if not case.loading.is_force:
        rule = f"works with strokes and forces only, not with {case.loading.kind}"
    elif constant or not (case.is_graded and isinstance(case.slip_model, Jaeger)):
        rule = (
            "works under a force only for smooth spheres, round punches and line contacts of "
            "constant friction and wear coefficient, with slip_model: cerruti or jaeger"
        )
    elif math.isfinite(case.plastic_limit):
        rule = "works under a force only for elastic bodies"
        hint = "write plastic_limit: none"
    elif ratio >= least:
        rule = (
            "makes the contact slide as a whole at the least load, where µP is less than Q, "
            f"{ratio:.3g} of the largest µP"
        )
        hint = f"raise it above {ratio:.3g}, lower Q, or write sliding_amplitude: 25 um"
    elif 2.0 * ratio <= 1.0 - least:
        rule = (
            "changes the load so fast that nothing slips after the first cycle: Q/(µP) is "
            f"{ratio:.3g} and must be more than {0.5 * (1.0 - least):.3g}"
        )
        hint = f"raise it above {1.0 - 2.0 * ratio:.3g}, or raise Q"
    else:
        return
    yield Problem("pulsating_load", f"{least:g}", rule, hint)


@_rule
def _bulk_stress_keeps_stick_in_the_contact(case: Case) -> Iterator[Problem]:
    """It moves the stick zone by e, R times the tilt; where e exceeds a − c, slip reverses."""
    if not case.bulk_stress:
        return
    given, given_with = format_quantity(case.bulk_stress, PRESSURE), ""
    if not case.slip_model.follows_shape:
        given_with = f"slip_model: {case.slip_model.kind}"
    elif case.normal.pulsating_load < 1.0:
        given_with = "pulsating_load"
    if given_with:
        yield Problem("bulk_stress", given, f"cannot be with {given_with}", "leave one out")
    elif case.stick_load > 0.0 and case.hertz.peak_pressure:
        hertz = case.hertz
        most = hertz.contact_radius - case.stick_radius
        moved = case.tilt * hertz.radius
        if moved > most:
            limit = format_quantity(case.bulk_stress * most / moved, PRESSURE)
            rule = f"moves the stick zone beyond the contact, where slip reverses; at most {limit}"
            yield Problem("bulk_stress", given, rule, "or raise the tangential load")


@_rule
def _bodies_wear_apart(case: Case) -> Iterator[Problem]:
    """Over a stroke, the wear of each body moves with the body."""
    law = case.wear_law
    if case.loading.travel and case.loading.travel > case.small_stroke and not law.is_of_each:
        (name, about), *_ = law.parameters().items()
        rule = "is for both bodies together, but over a stroke each wears in a different place"
        pair = "[value of the indenter, value of the flat]"
        hint = (
            f"slow: {pair}, fast: {pair}"
            if isinstance(vars(law)[name], FallingCoefficient)
            else f"{name}: {pair}"
        )
        yield Problem(name, about.text(float(vars(law)[name])), rule, f"write {hint}")


@_rule
def _zones_slide(case: Case) -> Iterator[Problem]:
    if not case.loading.stroke and case.wear_law.is_in_zones:
        rule = "has a rim and a core, which only a contact that slides as a whole has"
        hint = "write sliding_amplitude: 25 um, or a coefficient without zones"
        yield Problem(next(iter(case.wear_law.parameters())), None, rule, hint)


@_rule
def _frequency_is_known(case: Case) -> Iterator[Problem]:
    if case.wear_law.needs_frequency and case.frequency is None:
        rule = f"is missing, on which the {case.wear_law.kind} law of wear depends"
        yield Problem("frequency", None, rule, "such as frequency: 5 Hz")


@_rule
def _scar_is_small(case: Case) -> Iterator[Problem]:
    if not case.loading.stroke or _first(_loads_suit, case):
        return
    kind, stroke = case.loading.kind, case.loading.travel
    most, radius = MOST_STROKE * case.hertz_radius, case.indenter.curvature_radius
    reach = case.scar_half_width + stroke
    ends = math.isfinite(case.indenter.end)
    if stroke > most:
        what = case.frame.extent
        rule = f"is more than {MOST_STROKE:g} times the {what} of the contact"
        yield Problem(kind, _length(stroke, 6), rule, f"up to {_length(most)} would do")
    elif reach > GREATEST_CONTACT * radius and not ends:
        rule = (
            f"is larger than the half-space allows: with the scar it reaches to {_length(reach)}, "
            f"more than {GREATEST_CONTACT:g} of the radius {_length(radius, 6)}"
        )
        hint = "lower it, the cycles or the wear coefficients"
        given = None if stroke == 0.0 else _length(stroke, 6)
        yield Problem(kind, given, rule, hint)


@_rule
def _line_is_straight(case: Case) -> Iterator[Problem]:
    kind, stroke = case.indenter.kind, case.loading.stroke
    across = "y" in case.frame.axes
    for name, part in [*case.surfaces.items()][1:] if stroke or not across else ():
        if across:
            rule = (
                "cannot be combined with sliding_amplitude: waves passing each other would have to "
                "be resolved all over the scar at every position of the stroke"
            )
            hint = f"write {name}: none, or take a cylinder, for which a strip stands for the whole"
        elif stroke and name == "counterface" and case.roughness is None:
            rule = "is the surface of the indenter, given only beside a rough flat"
            hint = "write it as roughness, which belongs to the flat"
        elif not (part.even[0] and math.isinf(part.finest[1])):
            rule = f"cannot be on a {kind}: a line contact is even along x and uniform along y"
            hint = f"write {name}: none, or waves of slope_y: 0 deg"
        else:
            continue
        yield Problem(name, part.kind, rule, hint)


@_rule
def _sphere_slip_needs_a_sphere(case: Case) -> Iterator[Problem]:
    kind, model = case.indenter.kind, case.slip_model.kind
    if model == "cattaneo_mindlin" and kind not in ("sphere", "cylinder"):
        rule = f"is the closed form for a sphere or cylinder and does not describe this {kind}"
        yield Problem("slip_model", model, rule, "write slip_model: cerruti")


@_rule
def _surfaces_are_sound(case: Case) -> Iterator[Problem]:
    """A surface may have a rule between its parameters, and each body has one surface."""
    for name, part in case.surfaces.items():
        if part.problem is not None:
            yield Problem(name, None, *part.problem)
    bodies = [getattr(part, "body", None) for part in (case.roughness, case.counterface)]
    if bodies[0] and bodies[0] == bodies[1]:
        hint = f"write body: {'indenter' if bodies[0] == 'flat' else 'flat'} for one of them"
        yield Problem("counterface.body", bodies[1], "is also the body of roughness", hint)


@_rule
def _ratio_slides(case: Case) -> Iterator[Problem]:
    """Q ≥ µP slides as a whole, without a stick zone, which the model does not cover."""
    if isinstance(case.loading, TangentialRatio):
        ratio = case.loading.tangential_ratio
        if ratio >= 1.0:
            rule = "is gross sliding: Q/(µP) must be less than 1"
            is_percent = _LEAST_PERCENT <= ratio < 100.0
            hint = f"{_PARTIAL_SLIP}; {_GROSS_SLIP}"
            hint = f"did you mean '{ratio:g} %'?" if is_percent else hint
            yield Problem(case.loading.kind, f"{ratio:.6g}", rule, hint)
        yield from _all_sticks(case, ratio)


@_rule
def _load_slides(case: Case) -> Iterator[Problem]:
    """Q ≥ µP as in `_ratio_slides`, if Q or a displacement is given."""
    loading, friction, hertz = case.loading, case.friction_law.least, case.hertz
    if isinstance(loading, TangentialRatio):
        return
    if loading.is_force and loading.ratio(friction, case.coupling, hertz) >= 1.0:
        sliding = _force(case, friction * hertz.load)
        rule = f"is gross sliding: Q must be less than µP = {sliding}"
        hint = "lower tangential_load, or raise load or friction"
        yield Problem(loading.kind, _force(case, case.tangential_load), rule, hint)
    else:
        yield from _all_sticks(case, case.tangential_ratio)


def _all_sticks(case: Case, ratio: float) -> Iterator[Problem]:
    if ratio < LEAST_LOAD_RATIO:
        rule = f"leaves no slip to compute: Q/(µP) is {ratio:.3g} and must be at least "
        hint = "raise the displacement, or the stiffness of the rig"
        hint = _PARTIAL_SLIP if case.loading.is_force else hint
        yield Problem(case.loading.kind, None, f"{rule}{LEAST_LOAD_RATIO:g}", hint)


def _largest_contact(case: Case) -> float:
    """Half-width, m, up to which a contact can be described."""
    end = case.indenter.end
    return end if math.isfinite(end) else GREATEST_CONTACT * case.indenter.curvature_radius


def _end_of_contact(case: Case) -> str:
    """The reason for `_largest_contact`."""
    radius, end = case.indenter.curvature_radius, case.indenter.end
    if math.isfinite(end):
        return f"{_length(end, 6)}, where the punch ends"
    return f"{GREATEST_CONTACT:g} of the radius {_length(radius, 6)}, beyond half-space theory"


@_rule
def _contact_is_small(case: Case) -> Iterator[Problem]:
    largest = _largest_contact(case)
    if case.hertz_radius <= largest:
        return
    load, approach = case.normal.given
    if load is not None:
        given = _force(case, load)
        greatest = _force(case, 0.99 * case.hertz.load_at(largest), 3)
    elif approach is not None:
        given = _length(approach, 6)
        greatest = _length(0.99 * approach * (largest / case.hertz_radius) ** 2)
    rule = (
        f"is too much for this {case.indenter.kind}: the contact radius "
        f"{_length(case.hertz_radius)} is more than {_end_of_contact(case)}"
    )
    yield Problem(case.normal.kind, given, rule, f"up to {greatest} would do")


@_rule
def _plastic_limit_carries_load(case: Case) -> Iterator[Problem]:
    """The capped pressure must carry P on a contact that half-space theory can describe.

    A contact of radius r carries at most p_lim·πr², so carrying P takes a radius of at least
    √(P/(π p_lim)), which must not exceed `GREATEST_CONTACT`·R. Wear without plastic flow stays far
    below.
    """
    largest = _largest_contact(case)
    least = case.hertz.spread_pressure(largest)
    if case.plastic_limit < least:
        rule = (
            f"is too low to carry the load {_force(case, case.hertz.load)} on any contact the run "
            f"could reach: at most {_length(largest)} in {case.frame.extent} "
            f"({_end_of_contact(case)})"
        )
        enough = format_quantity(1.005 * least, PRESSURE, 3)
        hint = f"it must be at least {enough}; a hardness is some thousand MPa"
        given = format_quantity(case.plastic_limit, PRESSURE)
        yield Problem("plastic_limit", given, rule, hint)


@_rule
def _lowered_limit_carries_load(case: Case) -> Iterator[Problem]:
    """The same where all slides, by the limit that friction lowers."""
    largest, lowered = _largest_contact(case), case.slip_limit
    if lowered == case.plastic_limit:
        return
    least = case.hertz.spread_pressure(largest)
    if case.tangential_ratio >= 1.0 and lowered < least <= case.plastic_limit:
        rule = (
            f"lowers the plastic limit to {format_quantity(lowered, PRESSURE, 3)} where all slides,"
            f" too little to carry the load {_force(case, case.hertz.load)} on any contact the run "
            f"could reach: at most {_length(largest)} in {case.frame.extent}"
        )
        growth = ((case.plastic_limit / least) ** 2 - 1.0) / case.friction_law.coefficient**2
        hint = f"up to {0.99 * growth:.3g} would do, or raise plastic_limit"
        yield Problem("junction_growth", f"{case.junction_growth:.6g}", rule, hint)


@_rule
def _cell_resolves_surfaces(case: Case) -> Iterator[Problem]:
    """A wave or an edge on too few cells would be a different surface."""
    if case.cell is None:
        return
    for name, part in case.surfaces.items():
        least = part.cells // 2
        fine = [length / least for length in part.finest]
        wrong = [
            f"the {part.detail} along {axis} is {_length(length)} long"
            for axis, length, cell, limit in zip("xy", part.finest, case.cell, fine, strict=True)
            if cell > limit * (1.0 + 1e-9)
        ]
        if wrong:
            rule = f"is too coarse for the {name}: {' and '.join(wrong)} and needs at least"
            hint = f"{_finer(case.cell, fine)} or finer would be fine, or leave cell out"
            yield Problem("cell", cell_text(case.cell), f"{rule} {least} cells", hint)


@_rule
def _cell_resolves_contact(case: Case) -> Iterator[Problem]:
    """Contact, stick zone and slip annulus must be wider than the cells."""
    if case.cell is None:
        return
    radius, stick, ratio = case.hertz_radius, case.stick_radius, case.tangential_ratio
    if (case.loading.is_force and ratio >= 1.0) or ratio < LEAST_LOAD_RATIO:
        return
    limit = radius / LEAST_CELLS_PER_CONTACT_RADIUS
    narrower = (
        stick / LEAST_CELLS_PER_STICK_RADIUS if case.force_is_held else radius,
        (radius - stick) / LEAST_CELLS_PER_SLIP_ANNULUS,
    )
    # Graded cells resolve the stick zone and the slip annulus by themselves.
    limit = limit if case.is_graded else min(limit, *narrower)
    if max(case.cell) > limit * (1.0 + 1e-9):
        rule = "is too coarse for the contact: radius"
        rule = f"{rule} {_length(radius)}, stick zone {_length(stick)}"
        hint = f"{_finer(case.cell, (limit, limit))} would just do, or leave cell out"
        yield Problem("cell", cell_text(case.cell), rule, hint)


def _finer(cell: Sequence[float], limits: Sequence[float]) -> str:
    """Return a spacing just below both the given one and its limits."""
    return cell_text([rounded_down(min(pair), 3) for pair in zip(cell, limits, strict=True)])


def _snapshots_are_within_run(case: Case) -> Iterator[Problem]:
    if beyond := ", ".join(str(cycle) for cycle in case.output_cycles if cycle > case.cycles):
        hint = f"give cycles from 0 to {case.cycles}, or raise cycles"
        yield Problem("output_cycles", beyond, f"is beyond the last cycle, {case.cycles}", hint)


def _blocks_are_sound(case: Case) -> Iterator[Problem]:
    """Each block must be a valid case by itself, and all or none slide over a stroke."""
    blocks = [block for _, block in case.in_blocks()] if case.blocks else []
    if len({bool(block.loading.stroke) for block in blocks if block is not None}) > 1:
        rule = "has blocks with sliding_amplitude and blocks without: give it in all or in none"
        yield Problem("blocks", None, rule, "run them as two studies")
    if len({block.normal.pulsating_load < 1.0 for block in blocks if block is not None}) > 1:
        rule = "has blocks with pulsating_load and blocks of constant load"
        yield Problem("blocks", None, rule, "write pulsating_load: 0.999 for the latter")
    if any(isinstance(block.loading, SlidingDistance) for block in blocks if block is not None):
        rule = "cannot be combined with sliding_distance, which is for the whole run"
        yield Problem("blocks", None, rule, "write sliding_amplitude")
    # Problems of the base are reported under its keys.
    of_base = [_first(rule, case) for rule in _OF_BLOCKS] if blocks else []
    for number, block in enumerate(blocks, start=1):
        if block is None:
            yield Problem("blocks", None, f"block {number} lacks a parameter of its loading")
            continue
        broken = next(filter(None, (_first(rule, block) for rule in _OF_BLOCKS)), None)
        if broken is not None and broken not in of_base:
            value = f" = {broken.value}" if broken.value else ""
            rule = f"{broken.key}{value} in block {number} {broken.rule}"
            yield Problem("blocks", None, rule, broken.remedy)


RULES = (*_OF_BLOCKS, _snapshots_are_within_run, _blocks_are_sound)


def findings(case: Case) -> list[Problem]:
    """Return the problems of a case, each of whose values is valid by itself."""
    return [broken for rule in RULES if (broken := _first(rule, case)) is not None]
