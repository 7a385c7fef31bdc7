"""Rules that tie several parameters of a case together.

Each rule names the parameters it needs, so that rules with valid parameters can be checked while
others are still wrong: all problems of a study file are reported at once.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

from fretwear.mechanics.loading import (
    SMALL_STROKE,
    Displacement,
    DisplacementRatio,
    TangentialRatio,
)
from fretwear.study.case import Case, cell_text, members
from fretwear.study.problems import Problem
from fretwear.units import LENGTH, PRESSURE, Force, PerLength, force_text, format_quantity

LEAST_CELLS_PER_CONTACT_RADIUS = 8
LEAST_CELLS_PER_STICK_RADIUS = 2
LEAST_CELLS_PER_SLIP_ANNULUS = 1

GREATEST_CONTACT = 0.2
"""Largest contact radius in units of R: there the paraboloid r²/2R, which stands for the sphere
in a half-space theory, is 1 % off the sphere, as much as the default tolerance allows."""


LEAST_LOAD_RATIO = 1e-6
"""Smallest Q/(µP): there the slip annulus is a 3 000 000th of the contact radius wide, and where
the ratio vanishes against 1 it would have no width at all."""


MOST_STROKE = 20.0
"""Largest sliding amplitude over the Hertz half-width that is computed."""


@dataclass(frozen=True)
class Rule:
    """A rule, and the members or single parameters of a case that it needs."""

    needs: frozenset[str]
    find: Callable[[Case], Problem | None]


def _ratio_slides(case: Case) -> Problem | None:
    """Q ≥ µP slides as a whole: no stick zone, outside of the model."""
    if not isinstance(case.loading, TangentialRatio):
        return None
    if case.tangential_ratio < 1.0:
        return _sticks(case)
    return Problem(
        case.loading.kind,
        f"{case.tangential_ratio:.6g}",
        "is gross sliding: Q/(µP) must be less than 1",
        "partial slip needs a ratio between 0 and 1, such as 0.8",
    )


def _load_slides(case: Case) -> Problem | None:
    """Q ≥ µP as in `_ratio_slides`, where Q itself or a displacement is given."""
    if isinstance(case.loading, TangentialRatio):
        return None
    friction, hertz = case.friction_law.least, case.hertz
    if not case.loading.is_force or case.loading.ratio(friction, case.coupling, hertz) < 1.0:
        return _sticks(case)
    sliding = force_text(type(hertz.load)(friction * hertz.load))
    return Problem(
        case.loading.kind,
        force_text(case.tangential_load),
        f"is gross sliding: Q must be less than µP = {sliding}",
        "lower tangential_load, or raise load or friction",
    )


def _sticks(case: Case) -> Problem | None:
    """Hardly any tangential load sticks as a whole: no slip, no wear."""
    if case.tangential_ratio >= LEAST_LOAD_RATIO:
        return None
    return Problem(
        case.loading.kind,
        None,
        f"leaves no slip to compute: Q/(µP) is {case.tangential_ratio:.3g} and must be at least "
        f"{LEAST_LOAD_RATIO:g}",
        "partial slip needs a ratio between 0 and 1, such as 0.8"
        if case.loading.is_force
        else "raise the displacement, or the stiffness of the rig",
    )


def _contact_small(case: Case) -> Problem | None:
    """The half-space needs a contact much smaller than the sphere (`GREATEST_CONTACT`)."""
    radius = case.indenter.curvature_radius
    if case.hertz_radius <= GREATEST_CONTACT * case.indenter.curvature_radius:
        return None
    load, approach = case.normal.given
    if load is not None:
        given = force_text(load)
        most = type(load)(0.99 * case.hertz.load_at(GREATEST_CONTACT * radius))
        greatest = force_text(most, 3)
    elif approach is not None:
        less = (GREATEST_CONTACT * radius / case.hertz_radius) ** 2
        given = format_quantity(approach, LENGTH)
        greatest = format_quantity(0.99 * approach * less, LENGTH, 3)
    return Problem(
        case.normal.kind,
        given,
        f"is too much for this {case.indenter.kind}: the contact radius "
        f"{format_quantity(case.hertz_radius, LENGTH, 3)} is more than {GREATEST_CONTACT:g} of "
        f"the radius {format_quantity(radius, LENGTH)}, beyond half-space theory",
        f"up to {greatest} would do",
    )


def _plastic_limit_carries_load(case: Case) -> Problem | None:
    """The capped pressure must carry P on a contact that half-space theory can describe.

    Neither elastic wear nor the cap itself bounds the contact: where the pressure is at the
    limit the sphere sinks, and a softer body just ends with a larger contact.  What ends the
    growth is the theory.  A contact of radius r carries at most p_lim·πr², so carrying P takes
    a radius of at least √(P/(π p_lim)), which must not exceed `GREATEST_CONTACT`·R.  Wear
    without plastic flow stays far below: for Q/(µP) up to 0.99 the contact never grows to
    three times the Hertz radius, which has its own rule.
    """
    largest = GREATEST_CONTACT * case.indenter.curvature_radius
    least_limit = case.hertz.spread_pressure(largest)
    if case.plastic_limit >= least_limit:
        return None
    return Problem(
        "plastic_limit",
        format_quantity(case.plastic_limit, PRESSURE),
        f"is too low to carry the load {force_text(case.hertz.load)} on any contact the "
        f"run could reach: at most {format_quantity(largest, LENGTH, 3)} in radius "
        f"({GREATEST_CONTACT:g} of the sphere's, where half-space theory ends)",
        f"it must be at least {format_quantity(1.005 * least_limit, PRESSURE, 3)}; "
        "a hardness is some thousand MPa",
    )


def _cell_resolves_surfaces(case: Case) -> Problem | None:
    """A wave or an edge of too few cells would be another surface."""
    if case.cell is None:
        return None
    for name, part in case.surfaces.items():
        least = part.cells // 2
        fine = [length / least for length in part.finest]
        wrong = [
            f"the {part.detail} along {axis} is {format_quantity(length, LENGTH, 3)} long"
            for axis, length, cell, limit in zip("xy", part.finest, case.cell, fine, strict=True)
            if cell > limit * (1.0 + 1e-9)
        ]
        if wrong:
            limits = zip(case.cell, fine, strict=True)
            pair = ", ".join(_just_below(min(each)) for each in limits)
            return Problem(
                "cell",
                cell_text(case.cell),
                f"is too coarse for the {name}: {' and '.join(wrong)} and needs at least "
                f"{least} cells",
                f"[{pair}] or finer would be fine, or leave cell out",
            )
    return None


def _cell_resolves_contact(case: Case) -> Problem | None:
    """Contact, stick zone and slip annulus must be wider than the cells."""
    if case.cell is None or (
        case.loading.is_force and not LEAST_LOAD_RATIO <= case.tangential_ratio < 1.0
    ):
        return None
    limit = _coarsest_for_contact(case)
    if max(case.cell) <= limit * (1.0 + 1e-9):
        return None
    pair = ", ".join(_just_below(min(cell, limit)) for cell in case.cell)
    return Problem(
        "cell",
        cell_text(case.cell),
        f"is too coarse for the contact: radius {format_quantity(case.hertz_radius, LENGTH, 3)}, "
        f"stick zone {format_quantity(case.stick_radius, LENGTH, 3)}",
        f"[{pair}] would just do, or leave cell out",
    )


def _snapshots_within_run(case: Case) -> Problem | None:
    """Snapshots lie between cycle 0 and the last."""
    beyond = [cycle for cycle in case.output_cycles if cycle > case.cycles]
    if not beyond:
        return None
    return Problem(
        "output_cycles",
        ", ".join(str(cycle) for cycle in beyond),
        f"is beyond the last cycle, {case.cycles}",
        f"give cycles from 0 to {case.cycles}, or raise cycles",
    )


def _just_below(length: float) -> str:
    digits = math.floor(math.log10(length)) - 2
    return format_quantity(math.floor(length / 10.0**digits * (1 + 1e-9)) * 10.0**digits, LENGTH)


def _coarsest_for_contact(case: Case) -> float:
    """Largest spacing, m, that still resolves the contact, its stick and slip zones."""
    radius, stick = case.hertz_radius, case.stick_radius
    return min(
        radius / LEAST_CELLS_PER_CONTACT_RADIUS,
        stick / LEAST_CELLS_PER_STICK_RADIUS if case.force_is_held else radius,
        (radius - stick) / LEAST_CELLS_PER_SLIP_ANNULUS,
    )


def _loads_suit_the_contact(case: Case) -> Problem | None:
    """A line contact is loaded by forces per length, every other by forces."""
    kind = case.indenter.kind
    parts = (case.normal, case.loading)
    for part, name in ((each, name) for each in parts for name in each.parameters()):
        about, value = part.parameters()[name], getattr(part, name)
        if case.indenter.is_line and isinstance(value, Force):
            rule, example = f"is a force, but the load of a {kind} is per length", "18.5 N/mm"
        elif isinstance(value, PerLength) and not case.indenter.is_line:
            rule, example = f"is a force per length, but a {kind} is loaded by a force", "50 N"
        else:
            continue
        return Problem(name, about.text(value), rule, f"write {name}: {example}")
    return None


def _line_has_no_approach(case: Case) -> Problem | None:
    """The approach of a line contact, and its displacement, depend on the choice of a reference."""
    kind = case.indenter.kind
    if not case.indenter.is_line:
        return None
    if not case.normal.holds_load:
        rule = f"cannot be given for a {kind}: the depth of a line contact has no natural zero"
        return Problem(case.normal.kind, None, rule, "write load: 18.5 N/mm")
    if not isinstance(case.loading, Displacement):
        return None
    if math.isfinite(case.loading.rig_stiffness):
        rule = f"is not for a {kind}, whose tangential_compliance is that of the rig too"
        return Problem("rig_stiffness", None, rule, "leave rig_stiffness out")
    if case.loading.tangential_compliance:
        return None
    rule = f"needs tangential_compliance for a {kind}: it depends on the size of the body"
    hint = (
        "write tangential_compliance: 0.1 um/(N/mm), the slope of the loop after a reversal, or "
        "give sliding_amplitude or tangential_ratio instead"
    )
    return Problem(case.loading.kind, None, rule, hint)


def _line_has_one_spacing(case: Case) -> Problem | None:
    if case.cell is None or not case.indenter.is_line or case.cell[0] == case.cell[1]:
        return None
    rule = f"has a spacing along y, along which a {case.indenter.kind} is the same everywhere"
    hint = f"write cell: {format_quantity(case.cell[0], LENGTH)}"
    return Problem("cell", cell_text(case.cell), rule, hint)


def _compliance_is_of_a_line(case: Case) -> Problem | None:
    loading = case.loading
    if case.indenter.is_line or not getattr(loading, "tangential_compliance", 0.0):
        return None
    rule = f"is for line contacts: that of a {case.indenter.kind} follows from its load"
    return Problem("tangential_compliance", None, rule, "write rig_stiffness for that of the rig")


def _stroke_is_even(case: Case) -> Problem | None:
    if not case.loading.stroke:
        return None
    if not (case.normal.holds_load or case.indenter.is_line):
        rule = "cannot be combined with sliding_amplitude, over which the load is held"
        return Problem(
            case.normal.kind, None, rule, f"write load: {force_text(case.hertz.load, 3)}"
        )
    if all(case.indenter.even):
        return None
    rule = f"is for indenters even along x and y, which this {case.indenter.kind} is not"
    return Problem(case.loading.kind, None, rule, "turn its axes into x and y")


def _bodies_wear_apart(case: Case) -> Problem | None:
    """If the bodies move, the wear of each moves with it."""
    law = case.wear_law
    seen = case.loading.stroke > SMALL_STROKE * case.hertz_radius
    if not seen or law.shares is not None:
        return None
    name = next(iter(law.parameters()))
    value = getattr(law, name)
    text = law.parameters()[name].text(value)
    rule = "is that of both bodies, but over a stroke each wears in a place of its own"
    pair = "[value of the indenter, value of the flat]"
    hint = f"write slow: {pair}, fast: {pair}" if law.follows_power else f"write {name}: {pair}"
    return Problem(name, text, rule, hint)


def _scar_is_small(case: Case) -> Problem | None:
    """The half-space needs a scar much smaller than the indenter."""
    if not case.loading.stroke or _loads_suit_the_contact(case):
        return None
    stroke, radius = format_quantity(case.loading.stroke, LENGTH), case.indenter.curvature_radius
    if case.loading.stroke > MOST_STROKE * case.hertz_radius:
        most = format_quantity(MOST_STROKE * case.hertz_radius, LENGTH, 3)
        what = case.indenter.extent_words
        rule = f"is more than {MOST_STROKE:g} times the {what} of the contact"
        return Problem(case.loading.kind, stroke, rule, f"up to {most} would do")
    reach = case.scar_half_width + case.loading.stroke
    if reach <= GREATEST_CONTACT * radius:
        return None
    rule = (
        f"is larger than the half-space allows: with the scar it reaches to "
        f"{format_quantity(reach, LENGTH, 3)}, more than {GREATEST_CONTACT:g} of the radius "
        f"{format_quantity(radius, LENGTH)}"
    )
    return Problem(case.loading.kind, stroke, rule, "lower it, the cycles or the wear coefficients")


def _map_has_no_closed_form(case: Case) -> Problem | None:
    """Quantities in units of the smooth contact need one that is known before the run."""
    if case.indenter.has_closed_form:
        return None
    kind = case.indenter.kind
    if not case.normal.holds_load:
        rule = f"cannot be given for a {kind}, whose smooth contact is not known before the run"
        return Problem(case.normal.kind, None, rule, "write load: 50 N")
    if not isinstance(case.loading, DisplacementRatio):
        return None
    rule = f"is in units of what slides a smooth contact as a whole; of a {kind} that is not known"
    return Problem(case.loading.kind, None, rule, "write displacement_amplitude: 1 um")


def _sphere_slip_needs_a_sphere(case: Case) -> Problem | None:
    kind, model = case.indenter.kind, case.slip_model.kind
    if model != "cattaneo_mindlin" or kind in ("sphere", "cylinder"):
        return None
    rule = f"is the closed form of a sphere or cylinder and cannot stand for a {kind}"
    return Problem("slip_model", model, rule, "write slip_model: jaeger")


def _line_is_straight(case: Case) -> Problem | None:
    """A line contact is constant along y and even along x; other strokes need smooth bodies."""
    for name, part in case.surfaces.items():
        if not (case.indenter.is_line or case.loading.stroke) or name == "indenter":
            continue
        if not case.indenter.is_line:
            rule = (
                "cannot be combined with sliding_amplitude: waves passing each other would have to "
                "be resolved all over the scar at every position of the stroke"
            )
            hint = f"write {name}: none, or take a cylinder, of which a strip stands for the whole"
            return Problem(name, part.kind, rule, hint)
        if case.loading.stroke and name == "counterface" and case.roughness is None:
            rule = "belongs to the indenter where the flat is rough too"
            return Problem(name, part.kind, rule, "write it as roughness, which is of the flat")
        if not (part.even[0] and math.isinf(part.finest[1])):
            kind = case.indenter.kind
            rule = f"cannot be on a {kind}: a line contact is even along x and uniform along y"
            return Problem(name, part.kind, rule, f"write {name}: none, or waves of slope_y: 0 deg")
    return None


def _surfaces_are_sound(case: Case) -> Problem | None:
    """A surface may have a rule between its own parameters, and each body has one."""
    for name, part in case.surfaces.items():
        if part.problem is not None:
            return Problem(name, None, *part.problem)
    bodies = [getattr(part, "body", None) for part in (case.roughness, case.counterface)]
    if bodies[0] and bodies[0] == bodies[1]:
        other = "indenter" if bodies[0] == "flat" else "flat"
        rule, hint = "is that of roughness too", f"write body: {other} for one of them"
        return Problem("counterface.body", bodies[1], rule, hint)
    return None


_CONTACT = frozenset({"indenter", "bodies", "normal"})

RULES: tuple[Rule, ...] = (
    Rule(frozenset({"indenter", "normal", "loading"}), _loads_suit_the_contact),
    Rule(frozenset({"indenter", "normal", "loading"}), _line_has_no_approach),
    Rule(frozenset({"indenter", "loading"}), _compliance_is_of_a_line),
    Rule(frozenset({"indenter", "cell"}), _line_has_one_spacing),
    Rule(_CONTACT | {"loading"}, _stroke_is_even),
    Rule(_CONTACT | {"loading", "wear_law", "friction_law"}, _bodies_wear_apart),
    Rule(
        _CONTACT | {"loading", "wear_law", "friction_law", "cycles", "debris_fraction"},
        _scar_is_small,
    ),
    Rule(frozenset({"indenter", "loading", "roughness", "counterface"}), _line_is_straight),
    Rule(frozenset({"indenter", "normal", "loading"}), _map_has_no_closed_form),
    Rule(frozenset({"indenter", "slip_model"}), _sphere_slip_needs_a_sphere),
    Rule(frozenset({"indenter", "roughness", "counterface"}), _surfaces_are_sound),
    Rule(frozenset({"tangential_ratio"}), _ratio_slides),
    Rule(frozenset({"normal", "loading", "friction_law", "bodies", "indenter"}), _load_slides),
    Rule(_CONTACT, _contact_small),
    Rule(frozenset({"indenter", "bodies", "normal", "plastic_limit"}), _plastic_limit_carries_load),
    Rule(frozenset({"cell", "roughness", "counterface", "indenter"}), _cell_resolves_surfaces),
    Rule(_CONTACT | {"cell", "loading", "friction_law"}, _cell_resolves_contact),
    Rule(frozenset({"cycles", "output_cycles"}), _snapshots_within_run),
)


def _blocks_are_sound(case: Case) -> Problem | None:
    """Each block has to be a case by itself, and either all of them slide over a stroke or none."""
    slides = {bool(block.loading.stroke) for _, block in case.in_blocks() if block is not None}
    if len(slides) > 1:
        rule = "has blocks with sliding_amplitude and blocks without: give it in all or in none"
        return Problem("blocks", None, rule, "run them as two studies")
    for number, (_, block) in enumerate(case.in_blocks() if case.blocks else (), start=1):
        if block is None:
            rule = f"has a block number {number} that lacks a parameter of what it imposes"
            return Problem("blocks", None, rule)
        found = next(filter(None, (rule.find(block) for rule in RULES[:-1])), None)
        # Problems of the base are reported there.
        if found is not None and found not in (rule.find(case) for rule in RULES[:-1]):
            rule = f"has a block number {number} whose {found.key} {found.rule}"
            return Problem("blocks", None, rule, found.remedy)
    return None


RULES = (*RULES, Rule(frozenset({*members()} - {"cell", "tolerance"}), _blocks_are_sound))


def findings(case: Case) -> list[Problem]:
    """Return every rule broken by a case whose single values are valid."""
    return [broken for rule in RULES if (broken := rule.find(case)) is not None]
