"""Rules on several parameters of a case at once, each a function that finds the broken one.

Each parameter is valid by itself when they are checked; all broken rules are reported at once.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from dataclasses import replace

from fretwear.mechanics.slip.loading import (
    Displacement,
    DisplacementRatio,
    SlidingDistance,
    TangentialRatio,
)
from fretwear.mechanics.slip.models import Jaeger
from fretwear.study.contact import FrettingContact
from fretwear.study.problems import Problem
from fretwear.units import (
    BY_SI_UNIT,
    FORCE,
    LENGTH,
    PRESSURE,
    FloatWithUnit,
    format_quantity,
)

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

Rule = Callable[[FrettingContact], Problem | None]


def _length(value: float, digits: int = 3) -> str:
    return format_quantity(value, LENGTH, digits)


def _force(case: FrettingContact, load: float) -> str:
    dimension = BY_SI_UNIT[case.frame.unit(FORCE.si_unit)]
    # N/µm suits only the stiffness of a rig.
    usual = tuple(unit for unit in dimension.units if unit.size < 1e6)
    return format_quantity(load, replace(dimension, units=usual))


def cell_text(cell: tuple[float, ...]) -> str:
    """Return a grid spacing as study files have it."""
    return f"[{', '.join(format_quantity(spacing, LENGTH) for spacing in cell)}]"


def _load_suits_contact(case: FrettingContact) -> Problem | None:
    """Line contacts carry forces per length."""
    load = BY_SI_UNIT[case.frame.unit(FORCE.si_unit)]
    for part in (case.normal, case.loading):
        for name, about in part.parameters().items():
            value, unit = vars(part)[name], about.in_frame(case.frame).si_unit
            if isinstance(value, FloatWithUnit) and value.si_unit != unit:
                given = BY_SI_UNIT[value.si_unit].name
                rule = f"is {given}, but the load of this {case.indenter.kind} is {load.name}"
                return Problem(name, about.text(value), rule, f"such as {name}: {load.example}")
    return None


def _approach_is_known(case: FrettingContact) -> Problem | None:
    """The approach of a line contact depends on the choice of a reference."""
    kind = case.indenter.kind
    if case.normal.holds_load or (case.frame.has_depth and case.indenter.has_closed_form):
        return None
    rule = f"cannot be given for a {kind}, whose smooth contact is not known before the run"
    if not case.frame.has_depth:
        rule = f"cannot be given for a {kind}: the depth of a line contact has no natural zero"
    return Problem(case.normal.kind, None, rule, "write load")


def _displacement_is_known(case: FrettingContact) -> Problem | None:
    """The compliance of a line contact depends on the size of the body."""
    loading, kind, rule = case.loading, case.indenter.kind, ""
    if not isinstance(loading, Displacement):
        return None
    if isinstance(loading, DisplacementRatio) and not case.indenter.has_closed_form:
        rule = "is in units of the amplitude that slides a smooth contact as a whole, unknown for"
        return Problem(loading.kind, None, f"{rule} this {kind}", "write displacement_amplitude")
    if case.frame.has_depth:
        rule = f"is for line contacts: the load of this {kind} determines its compliance"
        return (
            Problem("tangential_compliance", None, rule) if loading.tangential_compliance else None
        )
    if math.isfinite(loading.rig_stiffness):
        rule = f"is not for a {kind}, whose tangential_compliance includes the rig"
        return Problem("rig_stiffness", None, rule)
    if not loading.tangential_compliance:
        rule = f"needs tangential_compliance for a {kind}: it depends on the size of the body"
        hint = "such as tangential_compliance: 0.1 um/(N/mm), the slope after a reversal"
        return Problem(loading.kind, None, rule, hint)
    return None


def _accuracy_needs_estimates(case: FrettingContact) -> Problem | None:
    if case.error_estimate or math.isinf(case.accuracy):
        return None
    rule = "leaves out the error estimates that an accuracy needs"
    return Problem("error_estimate", False, rule, "give one of the two")


def _line_has_one_spacing(case: FrettingContact) -> Problem | None:
    if case.cell is None or case.cell[0] == case.cell[1] or "y" in case.frame.axes:
        return None
    rule = f"has a spacing along y, along which a {case.indenter.kind} is the same everywhere"
    return Problem("cell", cell_text(case.cell), rule)


def _stroke_is_even(case: FrettingContact) -> Problem | None:
    indenter, normal = case.indenter, case.normal
    if case.loading.stroke and not normal.holds_load and case.frame.has_depth:
        rule = "cannot be combined with sliding_amplitude, over which the load is held"
        return Problem(normal.kind, None, rule, "write load")
    if case.loading.stroke and not all(indenter.even):
        rule = f"needs an indenter symmetric along x and y, which this {indenter.kind} is not"
        return Problem(case.loading.kind, None, rule)
    return None


def _load_pulsates_with_stroke_or_force(case: FrettingContact) -> Problem | None:
    """Under a force Q in phase, P falls to r P: µ(P − rP)/2 < Q < µrP, or all sticks, or slides."""
    least, ratio = case.normal.pulsating_load, case.tangential_ratio
    slides = case.loading.is_force and ratio >= 1.0
    if least == 1.0 or case.wears_unevenly or slides:
        return None
    varies = case.friction_law.kinks or case.wear_law.follows_contact
    if not case.loading.is_force:
        rule = f"works with strokes and forces only, not with {case.loading.kind}"
    elif varies or not (case.is_graded and isinstance(case.slip_model, Jaeger)):
        rule = (
            "works under a force only for smooth spheres, round punches and line contacts of "
            "constant friction and wear coefficient, with slip_model: cerruti or jaeger"
        )
    elif math.isfinite(case.plastic_limit):
        rule = "works under a force only for elastic bodies"
    elif ratio >= least:
        rule = f"must exceed Q/(µP) = {ratio:.3g}, or the contact slides at the least load"
    elif 2.0 * ratio <= 1.0 - least:
        lowest = 1.0 - 2.0 * ratio
        rule = f"must exceed 1 − 2Q/(µP) = {lowest:.3g}, or nothing slips after the first cycle"
    else:
        return None
    return Problem("pulsating_load", f"{least:g}", rule)


def _bulk_stress_keeps_stick_in_the_contact(case: FrettingContact) -> Problem | None:
    """It moves the stick zone by e, R times the tilt; where e exceeds a − c, slip reverses."""
    if not case.bulk_stress:
        return None
    given, rule = format_quantity(case.bulk_stress, PRESSURE), ""
    if not case.slip_model.follows_shape:
        rule = f"cannot be with slip_model: {case.slip_model.kind}"
    elif case.normal.pulsating_load < 1.0:
        rule = "cannot be with pulsating_load"
    elif case.stick_load > 0.0 and case.hertz.peak_pressure:
        most = case.hertz.contact_radius - case.stick_radius
        moved = case.tilt * case.hertz.radius
        if moved > most:
            limit = format_quantity(case.bulk_stress * most / moved, PRESSURE)
            rule = f"moves the stick zone beyond the contact, where slip reverses; at most {limit}"
    return Problem("bulk_stress", given, rule) if rule else None


def _bodies_wear_apart(case: FrettingContact) -> Problem | None:
    """Over a stroke, the wear of each body moves with the body."""
    law = case.wear_law
    if case.loading.travel <= case.small_stroke or law.is_of_each:
        return None
    (name, about), *_ = law.parameters().items()
    rule = "is for both bodies together, but over a stroke each wears in a different place"
    given = about.text(float(vars(law)[name]))
    return Problem(name, given, rule, "write pairs [value of the indenter, value of the flat]")


def _zones_slide(case: FrettingContact) -> Problem | None:
    if case.loading.stroke or not case.wear_law.is_in_zones:
        return None
    rule = "has a rim and a core, which only a contact that slides as a whole has"
    return Problem(next(iter(case.wear_law.parameters())), None, rule, "write sliding_amplitude")


def _frequency_is_known(case: FrettingContact) -> Problem | None:
    if case.frequency is not None or not case.wear_law.needs_frequency:
        return None
    rule = f"is missing, on which the {case.wear_law.kind} law of wear depends"
    return Problem("frequency", None, rule, "such as frequency: 5 Hz")


def _scar_is_small(case: FrettingContact) -> Problem | None:
    if not case.loading.stroke or _load_suits_contact(case):
        return None
    kind, stroke, rule = case.loading.kind, case.loading.travel, ""
    reach, radius = case.scar_half_width + stroke, case.indenter.curvature_radius
    if stroke > MOST_STROKE * case.hertz_radius:
        rule = f"is more than {MOST_STROKE:g} times the {case.frame.extent} of the contact"
    elif reach > GREATEST_CONTACT * radius and math.isinf(case.indenter.end):
        rule = (
            f"is larger than the half-space allows: with the scar it reaches to {_length(reach)}, "
            f"more than {GREATEST_CONTACT:g} of the radius {_length(radius, 6)}"
        )
    return Problem(kind, _length(stroke, 6) if stroke else None, rule) if rule else None


def _line_is_straight(case: FrettingContact) -> Problem | None:
    kind, stroke = case.indenter.kind, case.loading.stroke
    across = "y" in case.frame.axes
    for name, part in [*case.surfaces.items()][1:] if stroke or not across else ():
        if across:
            rule = "cannot be combined with sliding_amplitude, except on a line contact"
        elif stroke and name == "counterface" and case.roughness is None:
            rule = "is the surface of the indenter, given only beside a rough flat"
        elif not (part.even[0] and math.isinf(part.finest[1])):
            rule = f"cannot be on a {kind}: a line contact is even along x and uniform along y"
        else:
            continue
        return Problem(name, part.kind, rule)
    return None


def _closed_form_fits(case: FrettingContact) -> Problem | None:
    kind, model = case.indenter.kind, case.slip_model.kind
    if model != "cattaneo_mindlin" or kind in ("sphere", "cylinder"):
        return None
    rule = f"is the closed form for a sphere or cylinder and does not describe this {kind}"
    return Problem("slip_model", model, rule, "write slip_model: cerruti")


def _surfaces_are_sound(case: FrettingContact) -> Problem | None:
    """A surface may have a rule between its parameters, and each body has one surface."""
    for name, part in case.surfaces.items():
        if part.problem is not None:
            return Problem(name, None, *part.problem)
    first, second = (getattr(part, "body", "") for part in (case.roughness, case.counterface))
    if first and first == second:
        return Problem("counterface.body", second, "is also the body of roughness")
    return None


def _slips_in_part(case: FrettingContact) -> Problem | None:
    """Under a force Q ≥ µP all slides, without a stick zone; too small a Q slips nowhere."""
    loading, friction, hertz = case.loading, case.friction_law.least, case.hertz
    ratio, hint = case.tangential_ratio, "for gross slip write sliding_amplitude"
    if isinstance(loading, TangentialRatio):
        ratio = loading.tangential_ratio
        if ratio >= 1.0:
            rule = "is gross sliding: Q/(µP) must be less than 1"
            return Problem(loading.kind, f"{ratio:.6g}", rule, hint)
    elif loading.is_force and loading.ratio(friction, case.coupling, hertz) >= 1.0:
        rule = f"is gross sliding: Q must be less than µP = {_force(case, friction * hertz.load)}"
        return Problem(loading.kind, _force(case, case.tangential_load), rule, hint)
    if ratio >= LEAST_LOAD_RATIO:
        return None
    rule = f"leaves no slip to compute: Q/(µP) is {ratio:.3g} and must be at least"
    return Problem(loading.kind, None, f"{rule} {LEAST_LOAD_RATIO:g}")


def _largest_contact(case: FrettingContact) -> tuple[float, str]:
    """Half-width, m, up to which a contact can be described, and the reason."""
    radius, end = case.indenter.curvature_radius, case.indenter.end
    if math.isfinite(end):
        return end, f"{_length(end, 6)}, where the punch ends"
    reason = f"{GREATEST_CONTACT:g} of the radius {_length(radius, 6)}, beyond half-space theory"
    return GREATEST_CONTACT * radius, reason


def _contact_is_small(case: FrettingContact) -> Problem | None:
    largest, reason = _largest_contact(case)
    if case.hertz_radius <= largest:
        return None
    load, approach = case.normal.given
    given = _length(approach or 0.0, 6) if load is None else _force(case, load)
    radius = _length(case.hertz_radius)
    rule = f"is too much for this {case.indenter.kind}: the contact radius {radius} is more than"
    return Problem(case.normal.kind, given, f"{rule} {reason}")


def _limit_carries_load(case: FrettingContact) -> Problem | None:
    """The capped pressure must carry P on a contact that half-space theory can describe.

    A contact of radius r carries at most p_lim·πr², so carrying P takes a radius of at least
    √(P/(π p_lim)), which must not exceed `GREATEST_CONTACT`·R; where all slides, by the limit that
    friction lowers. Wear without plastic flow stays far below.
    """
    largest, reason = _largest_contact(case)
    least, lowered = case.hertz.spread_pressure(largest), case.slip_limit
    carries = f"to carry the load {_force(case, case.hertz.load)} on any contact the run could"
    if case.plastic_limit < least:
        given = format_quantity(case.plastic_limit, PRESSURE)
        rule = f"is too low {carries} reach: at most {_length(largest)} ({reason})"
        hint = f"it must be at least {format_quantity(1.005 * least, PRESSURE, 3)}"
        return Problem("plastic_limit", given, rule, hint)
    if case.tangential_ratio >= 1.0 and lowered < least:
        limit = format_quantity(lowered, PRESSURE, 3)
        rule = f"lowers the plastic limit to {limit} where all slides, too little {carries} reach"
        return Problem("junction_growth", f"{case.junction_growth:.6g}", rule)
    return None


def _cell_resolves_surfaces(case: FrettingContact) -> Problem | None:
    """A wave or an edge on too few cells would be a different surface."""
    for name, part in case.surfaces.items() if case.cell else ():
        least = part.cells // 2
        for axis, length, cell in zip("xy", part.finest, case.cell or (), strict=True):
            if cell > length / least * (1.0 + 1e-9):
                rule = (
                    f"is too coarse for the {name}: the {part.detail} along {axis} is "
                    f"{_length(length)} long and needs at least {least} cells"
                )
                return Problem("cell", cell_text(case.cell or ()), rule, "or leave cell out")
    return None


def _cell_resolves_contact(case: FrettingContact) -> Problem | None:
    """Contact, stick zone and slip annulus must be wider than the cells."""
    radius, stick, ratio = case.hertz_radius, case.stick_radius, case.tangential_ratio
    if case.cell is None or ratio < LEAST_LOAD_RATIO or (case.loading.is_force and ratio >= 1.0):
        return None
    limit = radius / LEAST_CELLS_PER_CONTACT_RADIUS
    if not case.is_graded:  # graded cells resolve the stick zone and the slip annulus themselves
        if case.force_is_held:
            limit = min(limit, stick / LEAST_CELLS_PER_STICK_RADIUS)
        limit = min(limit, (radius - stick) / LEAST_CELLS_PER_SLIP_ANNULUS)
    if max(case.cell) <= limit * (1.0 + 1e-9):
        return None
    rule = (
        f"is too coarse for the contact: radius {_length(radius)}, stick zone {_length(stick)}, "
        f"cells of at most {_length(limit)}"
    )
    return Problem("cell", cell_text(case.cell), rule, "or leave cell out")


def _snapshots_are_within_run(case: FrettingContact) -> Problem | None:
    beyond = ", ".join(str(cycle) for cycle in case.output_cycles if cycle > case.cycles)
    rule = f"is beyond the last cycle, {case.cycles}"
    return Problem("output_cycles", beyond, rule) if beyond else None


def _blocks_are_alike(case: FrettingContact) -> Problem | None:
    """All or none slide over a stroke, or pulsate."""
    blocks = [block for _, block in case.in_blocks() if block is not None] if case.blocks else []
    if len({bool(block.loading.stroke) for block in blocks}) > 1:
        rule = "has blocks with sliding_amplitude and blocks without: give it in all or in none"
    elif len({block.normal.pulsating_load < 1.0 for block in blocks}) > 1:
        rule = "has blocks with pulsating_load and blocks of constant load"
    elif any(isinstance(block.loading, SlidingDistance) for block in blocks):
        rule = "cannot be combined with sliding_distance, which is for the whole run"
    else:
        return None
    return Problem("blocks", None, rule)


# Rules of every case without blocks, and of each block of a case.
_OF_BLOCKS: tuple[Rule, ...] = (
    _load_suits_contact,
    _approach_is_known,
    _displacement_is_known,
    _accuracy_needs_estimates,
    _line_has_one_spacing,
    _stroke_is_even,
    _load_pulsates_with_stroke_or_force,
    _bulk_stress_keeps_stick_in_the_contact,
    _bodies_wear_apart,
    _zones_slide,
    _frequency_is_known,
    _scar_is_small,
    _line_is_straight,
    _closed_form_fits,
    _surfaces_are_sound,
    _slips_in_part,
    _contact_is_small,
    _limit_carries_load,
    _cell_resolves_surfaces,
    _cell_resolves_contact,
)
_OF_RUN: tuple[Rule, ...] = (_snapshots_are_within_run, _blocks_are_alike)


def _of_blocks(case: FrettingContact) -> Iterator[Problem]:
    """The first problem of each block, unless the base has it too, under its own key."""
    of_base = [rule(case) for rule in _OF_BLOCKS] if case.blocks else []
    for number, (_, block) in enumerate(case.in_blocks() if case.blocks else (), start=1):
        if block is None:
            yield Problem("blocks", None, f"block {number} lacks a parameter of its loading")
            continue
        broken = next((found for rule in _OF_BLOCKS if (found := rule(block))), None)
        if broken is not None and broken not in of_base:
            value = f" = {broken.value}" if broken.value else ""
            rule = f"{broken.key}{value} in block {number} {broken.rule}"
            yield Problem("blocks", None, rule, broken.remedy)


def findings(case: FrettingContact) -> list[Problem]:
    """Return the problems of a case, each of whose values is valid by itself."""
    broken = [found for rule in (*_OF_BLOCKS, *_OF_RUN) if (found := rule(case)) is not None]
    return [*broken, *[*_of_blocks(case)][:1]]
