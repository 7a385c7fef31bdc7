"""Reasons for inaccurate results of a case, or limits of the model, for plan, run and report."""

from __future__ import annotations

import math
import re
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace

from fretwear.mechanics.surfaces.loading import Displacement
from fretwear.study.case import Case
from fretwear.study.mistakes import few_of
from fretwear.units import LENGTH, PRESSURE, format_quantity, number_text

_NAMED = 3  # most results that a warning names
FEW_POINTS = 20  # points measured on a contact radius; fewer barely show a roughness
GREATEST_THINNING = 0.25  # mean wear depth over the thickness of a coating
GREATEST_SLOPE = 0.3  # slope of a roughness; half-space theory assumes small slopes
USUAL_FRICTION = 3.0  # coefficient of friction that few pairs exceed, rubber among them
GREATEST_WIDTH = 0.1  # contact radius over the radius of curvature from which theory errs by some %
# Hardness over E* that few materials exceed, hardened steel among them, and least E*, Pa, of
# materials that yield rather than stretch.
GREATEST_HARDNESS, LEAST_STIFFNESS = 0.07, 1e9

# Relative errors of results from which they are marked, and from which they are named.
SMALL_ERROR, LARGE_ERROR = 0.02, 0.05

_LINE = re.compile(r"The contact (.*?) \((.*)\)(?:: (.*))?")
_INACCURATE = "is computed less accurately than the"

# A sentence whose subject is the contact, its numbers and, if possible, a remedy.
_Words = Iterator[tuple[str, ...]]


@dataclass(frozen=True)
class CaseWarning:
    """A lack of accuracy of a case that can be run, or a limit of the model."""

    what: str  # a sentence whose subject is the contact; the same for all cases of a kind
    detail: str  # the numbers of this case
    remedy: str = ""  # what to do, in the imperative

    @classmethod
    def inaccurate(
        cls, asked: float, errors: Iterable[tuple[float, str, str]], remedy: str
    ) -> CaseWarning:
        """The warning of errors above the requested accuracy: relative error, result, and cycle."""
        largest = sorted(errors, key=lambda each: -each[0])
        limit = number_text(100.0 * asked, 2)
        texts = []
        for error, words, when in largest:
            number = number_text(100.0 * error, 2)
            number = number_text(100.0 * error, 3) if number == limit else number
            texts.append(f"{words} ± {number} %{when}")
        what = f"{_INACCURATE} {limit} % asked for"
        return cls(what, ", ".join(few_of(texts, _NAMED)), remedy)

    @classmethod
    def read(cls, line: str) -> CaseWarning | None:
        """Return the result that a line of the attribute ``warnings`` names, or None."""
        return cls(*found.groups(default="")) if (found := _LINE.fullmatch(line)) else None

    @property
    def is_inaccuracy(self) -> bool:
        """Whether results miss the requested accuracy."""
        return self.what.startswith(_INACCURATE)

    def __str__(self) -> str:
        return f"The contact {self.what} ({self.detail})" + f": {self.remedy}" * bool(self.remedy)


def study_warnings(cases: Mapping[str, Sequence[CaseWarning]], count: int) -> list[str]:
    """Return the warnings of some of the `count` cases of a study, by their words, as sentences.

    Results that miss their accuracy come first, each case with its quantities and a remedy.
    """
    missed, groups = list[tuple[float, str]](), dict[str, list[tuple[str, CaseWarning]]]()
    for words, warnings in cases.items():
        where = f" in {words}" if words else ""
        for warning in warnings:
            if warning.is_inaccuracy and (error := re.search(r"± ([\d.]+) %", warning.detail)):
                label = f"{warning.detail[:1].upper()}{warning.detail[1:]}"
                missed.append((float(error[1]), f"{label}{where}: {warning.remedy}"))
            else:
                groups.setdefault(warning.what, []).append((where, warning))
    sentences = [text for _, text in sorted(missed, key=lambda each: -each[0])]
    for what, alike in groups.items():
        where, first = alike[0]
        if len(alike) == 1:
            sentences.append(f"{replace(first, what=what + where)}")
            continue
        details = {warning.detail for _, warning in alike}
        numbers = first.detail if len(details) == 1 else f"such as {first.detail}{where}"
        remedy = f": {first.remedy}" if first.remedy else ""
        sentences.append(f"{len(alike)} of {count} cases: the contact {what} ({numbers}){remedy}")
    return sentences


def case_warnings(
    case: Case,
    errors: Mapping[str, float] | None = None,
    trouble: str = "",
    beyond_friction: float = 0.0,
    unreached: CaseWarning | None = None,
    thinned: float = 0.0,
    *,
    measured: bool = False,
) -> tuple[CaseWarning, ...]:
    """Return lacks of accuracy and limits of the model in a valid case; usually none.

    Findings of a run are included: the largest estimated relative error of each result, by its
    words, or why errors could not be estimated; the share of the stick zone in which friction
    cannot bear the shear of the slip model; and a missed accuracy. Errors `measured` to choose the
    cells are not repeated. `thinned` is the mean wear depth under the contact over the thickness of
    a coating.
    """
    checks = [_of_band, _of_slip, _of_surfaces, _of_unlike_bodies, _of_materials]
    warnings = [CaseWarning(*words) for check in checks for words in check(case)]
    if trouble:
        what = "has no estimated errors, because the run on wider cells failed"
        warnings.append(CaseWarning(what, trouble))
    if beyond_friction > SMALL_ERROR:
        what = (
            "takes the shear of the smooth unworn contact, which exceeds the friction limit µp of "
            "this contact and is cut to it"
        )
        detail = f"in {number_text(100.0 * beyond_friction, 2)} % of the stick zone"
        warnings.append(CaseWarning(what, detail))
    # A layer that hardly changes the pressure may wear.
    if thinned > GREATEST_THINNING and abs(case.coating_pressure_ratio - 1.0) > SMALL_ERROR:
        what = "wears its coating thin, while the elastic layer keeps its thickness"
        detail = f"mean wear depth under the contact {100.0 * thinned:.0f} % of the thickness"
        warnings.append(CaseWarning(what, detail))
    words, error = max((errors or {}).items(), key=lambda item: item[1], default=("", 0.0))
    if unreached is not None:
        warnings.append(unreached)
    elif error > LARGE_ERROR + case.cells.error_of_directions(0.0) and not (
        measured or case.asked_accuracy
    ):
        what = f"is computed so coarsely that estimated errors exceed {100 * LARGE_ERROR:g} %"
        warnings.append(CaseWarning(what, f"{words}: {100 * error:.0f} %", "choose smaller cells"))
    return tuple(warnings)


def _lengths(**lengths: float) -> str:
    """Lengths, m, by their names."""
    texts = (f"{name} {format_quantity(length, LENGTH, 3)}" for name, length in lengths.items())
    return ", ".join(texts).replace("_", " ")


def _of_band(case: Case) -> _Words:
    """Cells must resolve the band that yields at the stick edge once wear has reached it."""
    cell, cells = case.width_at_edges, case.cells
    follows, ring = case.slip_model.follows_shape, cells.yielding_ring
    if 0.0 < ring < cell and cells.edge_yields and follows and not cells.zones_of_tip:
        what = "yields in a ring narrower than a cell, so plastic volume and wear are less accurate"
        yield what, _lengths(ring=ring, cell=cell)


def _of_slip(case: Case) -> _Words:
    """Each point is assumed to face one point of the other body, and κ to be one number."""
    if error := case.cells.error_of_directions(0.0):
        what = "is computed on rings, where slip is the same in all directions, so that the deepest"
        remedy = "" if case.normal.pulsating_load < 1.0 else "write slip_model: cerruti"
        yield f"{what} wear is too small", f"by up to {100.0 * error:.0f} %, most at first", remedy
    loading, hertz = case.loading, case.hertz
    if isinstance(loading, Displacement):
        compliant = case.coupling * hertz.approach + loading.flexibility(hertz) * hertz.load
        slid = case.displacement_amplitude - case.friction_law.least * compliant
        if slid > case.small_stroke:
            yield (
                "slides so far that each point meets several points of the other body, which the "
                "model neglects",
                _lengths(sliding_amplitude=slid, contact_radius=case.hertz_radius),
            )
    others = case.indenter.couplings(case.bodies)
    if others and case.slip_model.is_isotropic:
        error = max(abs(estimate / case.coupling - 1.0) for estimate in others)
        by_curvatures = " and ".join(f"{estimate:.4g}" for estimate in others)
        yield (
            "is elongated, so that no single κ relates slip to the gap of the reduced contact",
            f"κ is {case.coupling:.4g} in the centre and taken everywhere, but {by_curvatures} by "
            f"the curvatures: slip and wear are uncertain by up to {100.0 * error:.0f} %",
        )


def _of_surfaces(case: Case) -> _Words:
    """A measured map must exceed the contact and be fine; a random one must not repeat."""
    if case.rough is None:
        return
    radius = case.hertz_radius
    for surface in filter(None, (case.roughness, case.counterface)):
        side, distance = min(surface.sides), max(surface.finest) / 2.0
        yield from surface.warnings(radius, 1.0 / case.indenter.curvature_radius)
        if math.isinf(side):
            continue
        if side < 3.0 * radius:
            what = "barely fits on the measured surface, whose border heights continue beyond it"
            yield what, _lengths(side=side, contact_radius=radius)
        if distance > radius / FEW_POINTS:
            what = f"lies on a surface measured at fewer than {FEW_POINTS} points per radius"
            yield what, _lengths(distance=distance, contact_radius=radius)
    if min(case.rough.period) < 3.0 * radius:
        what = "is nearly as wide as the period of the random surface, so that heights repeat in it"
        yield what, _lengths(period=min(case.rough.period), contact_radius=radius)


def _of_unlike_bodies(case: Case) -> _Words:
    """Friction lifts unlike bodies, which changes pressure and wear; the model neglects it.

    Estimates come from `tests/mechanics/test_neglected.py`, rounded up.
    """
    beta, friction = case.bodies.dundurs_beta, case.friction_law.coefficient
    local, in_all = beta * (friction + 2.0 * beta), 2.0 * beta**2
    if local > LARGE_ERROR:
        yield (
            "joins unlike bodies; friction also moves their surfaces apart, which is neglected",
            f"Dundurs' β = {number_text(beta, 2)}: about {100.0 * local:.0f} % of local pressure "
            f"and wear, {number_text(100.0 * in_all, 2)} % of wear volume and dissipated energy",
        )


def _of_materials(case: Case) -> _Words:
    slides = case.tangential_ratio >= 1.0
    limit = case.plastic_limits[0] * (case.shear_on_limit if slides else 1.0)
    pressures = limit, case.hertz.mean_pressure
    if pressures[0] < pressures[1]:
        numbers = (format_quantity(pressure, PRESSURE, 3) for pressure in pressures)
        what = "yields all over at first loading, which a pressure limit does not describe"
        yield what, "plastic limit {}, mean Hertz pressure {}".format(*numbers)
    yield from _of_strains(case)
    if (friction := case.friction_law.greatest) > USUAL_FRICTION:
        what = "has a coefficient of friction that few materials reach"
        yield what, f"µ = {friction:g}, or {friction:g} % if per cent was meant"
    if case.rough is not None and case.rough.steepest > GREATEST_SLOPE:
        steepest = number_text(case.rough.steepest, 2)
        what = "touches on slopes that are too steep for half-space theory"
        yield what, f"steepest slope {steepest}, at most {GREATEST_SLOPE:g}"


def _of_strains(case: Case) -> _Words:
    """Elastic half-spaces describe neither soft bodies nor contacts as wide as the bodies."""
    if not case.indenter.is_hertzian:
        return
    peak, stiffness = case.hertz_pressure, case.composite_modulus
    width = case.hertz_radius / case.indenter.curvature_radius
    is_elastic = math.isinf(case.slip_limit) and stiffness >= LEAST_STIFFNESS
    if is_elastic and peak > GREATEST_HARDNESS * stiffness:
        yield (
            "presses elastic bodies harder than most materials bear",
            f"peak pressure {format_quantity(peak, PRESSURE, 3)}, {peak / stiffness:.2g} E*; "
            f"hardened steel bears about {GREATEST_HARDNESS:g} E*",
            "give plastic_limit",
        )
    elif width > GREATEST_WIDTH:
        what = "is so wide beside the radius of the bodies that half-space theory is inexact"
        lengths = _lengths(contact_radius=case.hertz_radius, radius=case.indenter.curvature_radius)
        yield what, lengths, "check load, radius and youngs_modulus"
