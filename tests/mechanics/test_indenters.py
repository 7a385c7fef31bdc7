"""Indenters that are no spheres, against the closed forms of their contacts."""

import math

import numpy as np
import pytest

from fretwear.mechanics.geometry.grid import Grid
from fretwear.mechanics.geometry.rings import Rings
from fretwear.mechanics.integrator import evolve, first_loading
from fretwear.mechanics.measures import measure
from fretwear.running.simulate import wear_problem
from fretwear.study.case import CaseError
from fretwear.study.doubts import doubts
from fretwear.theory import EllipticContact, RoundContact, RoundedPunch

from ..studies import steel
from .problems import MODULUS, near

PUNCH = {"kind": "round_punch", "flat_radius": "100 um", "edge_radius": "10 mm"}
RADIUS = 150e-6


def case(indenter, load=50.0, ratio=0.5, **changes):
    given = {"radius": None, "indenter": indenter, "load": load, "tangential_ratio": ratio}
    return steel(cycles=100, **given | changes)


# Half-axes a along x and b: E*Aa/p₀, E*Ba/p₀ of the gap Ax² + By², E*δ/(p₀a), and κ at ν = 0.3 in
# the centre and by the curvatures along x and y.
ELLIPSES = {
    0.5: (0.630306, 1.79181, 1.07826, (1.2505, 1.1653, 1.3704)),
    0.2: (0.409502, 4.84301, 0.603222, (1.2909, 1.2352, 1.4087)),
}


def ellipsoid(slender):
    along_x, along_y, *_ = ELLIPSES[slender]
    return {"kind": "ellipsoid", "radius_x": 10e-3, "radius_y": 10e-3 * along_x / along_y}


@pytest.mark.parametrize("slender", ELLIPSES)
def test_an_elliptical_contact_is_that_of_hertz(slender):
    along_x, along_y, approach, couplings = ELLIPSES[slender]
    contact = EllipticContact.of(0.5 / along_x, 0.5 / along_y, 1.0, MODULUS)
    half_x, half_y = contact.half_widths
    unit = contact.peak_pressure / MODULUS
    assert half_y / half_x == near(slender, rel=1e-5)
    assert unit / half_x == near(1.0, rel=1e-5)
    assert contact.approach / (unit * half_x) == near(approach, rel=1e-5)
    assert contact.load == near(2 / 3 * math.pi * half_x * half_y * contact.peak_pressure)
    found = case(ellipsoid(slender))
    assert found.coupling == near(couplings[0], rel=1e-4)
    assert found.indenter.couplings(found.bodies) == near(couplings[1:], rel=1e-4)
    # Turned by a right angle, slip is across the ellipse.
    turned = EllipticContact.of(0.5 / along_y, 0.5 / along_x, 1.0, MODULUS)
    assert turned.half_widths == near((half_y, half_x), rel=1e-12)


def test_a_round_ellipsoid_is_a_sphere():
    sphere = steel(cycles=100, tangential_ratio=0.5)
    alike = case({"kind": "ellipsoid", "radius_x": "10 mm", "radius_y": "10 mm"})
    assert alike.coupling == near(sphere.coupling, rel=1e-12)
    for name in ("contact_radius", "approach", "peak_pressure"):
        assert getattr(alike.hertz, name) == near(getattr(sphere.hertz, name), rel=1e-12)
    assert alike.grid_spacing == sphere.grid_spacing


@pytest.mark.parametrize(
    ("angle", "slender"), [(90, 1.0), (60, 0.482628), (45, 0.313439), (30, 0.180565)]
)
def test_crossed_cylinders_touch_in_an_ellipse(angle, slender):
    crossed = case({"kind": "crossed_cylinders", "radii": "5 mm", "angle": f"{angle} deg"})
    assert crossed.hertz.axis_ratio == near(slender, rel=2e-6)
    # The gap is that of its principal radii along axes, the first of which halves the angle.
    indenter = crossed.indenter
    turn = indenter.rotation
    assert turn == near(math.radians(angle) / 2, rel=1e-9) if angle < 90 else turn == 0.0
    x, y = np.meshgrid([1e-4, -2e-4, 3e-5], [2e-4, 5e-5])
    along, across = x * np.cos(turn) + y * np.sin(turn), y * np.cos(turn) - x * np.sin(turn)
    first, second = indenter.radii_of_gap
    expected = along**2 / (2 * first) + across**2 / (2 * second)
    np.testing.assert_allclose(indenter.gap(x, y), expected, rtol=1e-9)
    assert indenter.even == (angle == 90, angle == 90)


# b/a: dR/a², PR/E*a³, c/a at Q/µP = 0.2, 0.5, 0.8.
PUNCHES = {
    0.8: (0.0851991, 0.157199, (0.975806, 0.933204, 0.876029)),
    0.5: (0.342427, 0.558933, (0.950546, 0.859500, 0.725449)),
}


@pytest.mark.parametrize("flat", PUNCHES)
def test_a_round_punch_is_that_of_the_method_of_dimensionality_reduction(flat):
    approach, load, sticks = PUNCHES[flat]
    contact = RoundContact.under(RoundedPunch(flat, 1.0), load, 1.0)
    assert contact.contact_radius == near(1.0, rel=3e-6)
    assert contact.approach == near(approach, rel=3e-6)
    for ratio, stick in zip((0.2, 0.5, 0.8), sticks, strict=True):
        assert contact.with_load((1 - ratio) * load).contact_radius == near(stick, rel=3e-6)
    assert contact.load_within(1.0) == near(load, rel=2e-4)
    at_depth = RoundContact.of_depth(contact.profile, contact.approach, 1.0)
    assert at_depth.load == near(load, rel=1e-9)


@pytest.mark.parametrize("flat", PUNCHES)
def test_a_round_punch_is_moved_and_pressed_by_displacements(flat):
    """P(c) = (1 − X) P and U = µκ (g(a) − g(c)), whichever of them is given."""
    approach, _, sticks = PUNCHES[flat]
    indenter, load = punch(flat)
    deep = approach * RADIUS**2 / 10e-3
    for ratio, stick in zip((0.2, 0.5, 0.8), sticks, strict=True):
        moved = case(indenter, load).indenter.profile.depth(stick * RADIUS)
        way = 0.5 * case(indenter, load).coupling * (deep - moved)
        for pressed in (load, None):
            held = {} if pressed else {"indentation": deep}
            given = case(indenter, pressed, None, displacement_amplitude=way, **held)
            state = first_loading(wear_problem(given, Rings))
            assert 1 - state.reduced.load / state.load == near(ratio, rel=1e-4)
            assert given.tangential_ratio == near(ratio, rel=1e-4)
    begins = 0.5 * given.coupling * deep
    assert given.loading.transition(0.5, given.coupling, given.hertz) == near(begins, rel=1e-5)


def test_a_flat_punch_is_moved_over_the_slope_of_its_loop():
    """U = µ [δ(P) − δ(P*)] + µ F (P − P*), F what C_t has beyond dδ/dP of the contact."""
    indenter = {"kind": "flat_punch", "flat_half_width": "100 um", "edge_radius": "10 mm"}
    given = case(
        indenter,
        20e3,
        None,
        displacement_ratio=0.6,
        tangential_compliance="0.02 um/(N/mm)",
    )
    problem = wear_problem(given)
    state = first_loading(problem)
    stick = given.hertz.with_load(state.reduced.load)
    way = given.hertz.approach - stick.approach
    way += (2e-11 - given.hertz.compliance) * (given.hertz.load - stick.load)
    assert 0.5 * way == near(given.displacement_amplitude, rel=1e-4)
    assert given.displacement_amplitude == near(
        0.3 * (given.hertz.approach + (2e-11 - given.hertz.compliance) * 20e3), rel=1e-9
    )
    found = measure(problem, state)
    assert found.stick_half_width_x == near(stick.contact_radius, rel=1e-3)


def punch(flat):
    """A punch, and the load under which its contact has the radius."""
    indenter = {"kind": "round_punch", "flat_radius": flat * RADIUS, "edge_radius": 10e-3}
    profile = RoundedPunch(flat * RADIUS, 10e-3)
    return indenter, RoundContact.under(profile, 1.0, MODULUS).load_at(RADIUS)


@pytest.mark.parametrize(
    ("indenter", "load", "rings"),
    [
        *((ellipsoid(slender), 50.0, False) for slender in ELLIPSES),
        *((*punch(flat), rings) for flat in PUNCHES for rings in (False, True)),
        ({"kind": "crossed_cylinders", "radii": ["5 mm", "9 mm"]}, 50.0, False),
    ],
)
def test_first_loading_at_the_default_cell_is_that_of_the_closed_form(indenter, load, rings):
    pressed = case(indenter, load)
    contact, stick = pressed.hertz, pressed.hertz.with_load(pressed.stick_load)
    problem = wear_problem(pressed, Rings if rings else Grid)
    state = first_loading(problem)
    found = measure(problem, state)
    area = problem.hertz.load / contact.mean_pressure
    center = getattr(contact, "central_pressure", contact.peak_pressure)
    assert state.geometry.integral(state.pressure) == near(load, rel=1e-9)
    assert found.approach == near(contact.approach, rel=1e-4)
    assert found.central_pressure == near(center, rel=1e-3)
    assert found.peak_pressure == near(contact.peak_pressure, rel=2e-3)
    assert found.contact_area == near(area, rel=1e-2)
    sticks = zip(("x", "y"), pressed.indenter.half_widths(stick), strict=True)
    for axis, half_width in sticks:
        assert getattr(found, f"stick_half_width_{axis}") == near(half_width, rel=3e-3)


def test_a_contact_at_an_angle_wears_alike_on_opposite_sides():
    turned = case(
        {"kind": "crossed_cylinders", "radii": "10 mm", "angle": "60 deg"}, cell="6 um", ratio=0.8
    )
    problem = wear_problem(turned)
    *_, state = evolve(problem, [1000])
    assert state.geometry.even == (False, False)
    wear = state.wear
    np.testing.assert_allclose(wear, wear[::-1, ::-1], atol=1e-5 * wear.max())
    # It is no mirror image of itself.
    assert np.abs(wear - wear[::-1]).max() > 0.3 * wear.max()


def test_a_profile_of_a_paraboloid_is_the_sphere(tmp_path):
    tip = tmp_path / "tip.csv"
    rows = (f"{r}, {r**2 / 20e3}" for r in range(0, 405, 5))
    tip.write_text("r (um), z (um)\n" + "\n".join(rows))
    profile = case({"kind": "profile", "file": str(tip)})
    sphere = steel(cycles=100, tangential_ratio=0.5)
    assert profile.hertz.contact_radius == near(sphere.hertz.contact_radius, rel=1e-4)
    assert profile.hertz.approach == near(sphere.hertz.approach, rel=1e-4)
    problem = wear_problem(profile, Rings)
    found = measure(problem, first_loading(problem))
    assert found.approach == near(sphere.hertz.approach, rel=3e-4)
    assert found.stick_half_width_x == near(sphere.stick_radius, rel=1e-3)
    assert not {"hertz_pressure", "hertz_radius"} & profile.scalar_coordinates().keys()
    with pytest.raises(CaseError, match="is too much for this profile"):
        case({"kind": "profile", "file": str(tip)}, load=2000.0)


def test_what_an_indenter_is_doubtful_for_is_told_and_what_it_cannot_be_asked_refused():
    (doubt,) = doubts(case(ellipsoid(0.2)))
    assert "κ is 1.291 in the centre" in doubt.detail
    assert "1.235 and 1.409" in doubt.detail
    assert "up to 9 %" in doubt.remedy
    assert not doubts(case(PUNCH))
    with pytest.raises(CaseError, match="cylinder"):
        case({"kind": "crossed_cylinders", "radii": "5 mm", "angle": "2 deg"})
    with pytest.raises(CaseError, match="closed form of a sphere"):
        case(PUNCH, slip_model="cattaneo_mindlin")
