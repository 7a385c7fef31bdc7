"""Closed forms against quadrature, tabulated values, limits and one another."""

import math

import numpy as np
import pytest
from scipy.integrate import quad
from scipy.special import ellipk

from fretwear import theory
from fretwear.theory import FlatPunchContact, LineContact, LineLimitingState, LinePartialSlip

STEEL = (208e9, 0.3)
RADIUS, LOAD, FRICTION = 10e-3, 50.0, 0.5
RATIOS = (0.001, 0.2, 0.5, 0.8, 0.9, 0.99)


@pytest.fixture
def hertz():
    return theory.HertzContact(RADIUS, LOAD, theory.composite_modulus(*STEEL, *STEEL))


def partial_slip(hertz, ratio):
    coupling = theory.coupling_ratio(*STEEL, *STEEL)
    return theory.CattaneoMindlin(hertz, FRICTION, ratio * FRICTION * hertz.load, coupling)


@pytest.fixture(params=RATIOS)
def slip(hertz, request):
    return partial_slip(hertz, request.param)


@pytest.fixture(params=RATIOS)
def limit(hertz, request):
    return theory.LimitingState(hertz, request.param)


def integral(function, start, end):
    return quad(function, start, end, epsabs=0.0, epsrel=1e-11, limit=200)[0]


def area_integral(function, start, end):
    """∫ f 2πr dr; the substitution r = m - h·cos t removes square roots at both ends."""
    middle, half = (start + end) / 2, (end - start) / 2

    def integrand(t):
        r = middle - half * math.cos(t)
        return 2 * math.pi * r * float(function(r)) * half * math.sin(t)

    return integral(integrand, 0.0, math.pi)


def test_composites_of_two_materials_are_symmetric_and_reach_the_rigid_limit():
    brass, rigid = (100e9, 0.35), (1e30, 0.2)
    for combine in (theory.composite_modulus, theory.coupling_ratio):
        assert combine(*STEEL, *brass) == pytest.approx(combine(*brass, *STEEL), rel=1e-14, abs=0)
    normal, shear = 100e9 / (1 - 0.35**2), 4 * 100e9 / (2 * 1.35) / (2 - 0.35)
    assert theory.composite_modulus(*brass, *rigid) == pytest.approx(normal)
    assert theory.coupling_ratio(*brass, *rigid) == pytest.approx(normal / shear)


def test_hertz_pressure_carries_the_load_and_the_approach_follows_from_the_radius(hertz):
    carried = area_integral(hertz.pressure, 0.0, hertz.contact_radius)
    assert carried == pytest.approx(LOAD, rel=1e-9, abs=0)
    expected = 2 * hertz.composite_modulus * hertz.contact_radius / (math.pi * RADIUS)
    assert hertz.peak_pressure == pytest.approx(expected, rel=1e-14, abs=0)
    # the stiffness of a circular contact is dP/dδ = 2 E* a, whatever the profile
    approach = integral(
        lambda load: 1 / (2 * hertz.composite_modulus * hertz.with_load(load).contact_radius),
        0.0,
        LOAD,
    )
    assert hertz.approach == pytest.approx(approach, rel=1e-8, abs=0)


def displacement(pressure, outer, modulus, r):
    """Surface displacement at r ≥ outer by quadrature of ring loads (Johnson 1985, section 3.8)."""

    def integrand(angle):
        t = outer * math.sin(angle)
        load = float(pressure(t)) * t * outer * math.cos(angle)
        return load * ellipk(4 * r * t / (r + t) ** 2) / (r + t)

    # just short of the rim, where the pressure may be infinite but the load is not
    return 4 / (math.pi * modulus) * integral(integrand, 0.0, math.pi / 2 - 1e-9)


def test_hertz_gap_is_the_superposition_of_flat_punches_and_its_series_joins_it(hertz):
    for r in hertz.contact_radius * np.array([1.0, 1.001, 1.1, 3.0]):
        lifted = integral(lambda b, r=r: 2 * b * math.acos(b / r), 0.0, hertz.contact_radius)
        gap = r**2 / (2 * RADIUS) - 2 / (math.pi * RADIUS) * lifted
        assert float(hertz.gap(r)) == pytest.approx(gap, rel=1e-9, abs=1e-13 * hertz.approach)
    # the switch lies at √(r²/a² - 1) = 0.01; the slope of log g must not jump there
    edge = hertz.contact_radius * math.sqrt(1 + 0.01**2)
    r = edge * (1 + np.array([-2e-9, -1e-9, 1e-9, 2e-9]))
    below, across, above = np.diff(hertz.gap(r)) / np.diff(r)
    assert across == pytest.approx((below + above) / 2, rel=1e-3, abs=0)


def test_shear_traction_carries_the_load_obeys_coulomb_and_dissipates_the_work_of_friction(
    hertz, slip
):
    c, a = slip.stick_radius, hertz.contact_radius
    carried = area_integral(slip.shear_traction, 0.0, c) + area_integral(slip.shear_traction, c, a)
    assert carried == pytest.approx(slip.tangential_load, rel=1e-7, abs=0)
    annulus, disc = np.linspace(c, a, 20), np.linspace(0.0, 0.999 * c, 20)
    np.testing.assert_allclose(
        slip.shear_traction(annulus), FRICTION * hertz.pressure(annulus), rtol=1e-14
    )
    assert np.all(slip.shear_traction(disc) < FRICTION * hertz.pressure(disc))
    assert np.all(slip.slip(disc) == 0.0)
    assert np.all(slip.slip(annulus[1:]) > 0.0)
    stuck = area_integral(hertz.pressure, 0.0, c)
    assert slip.stick_load_share * LOAD == pytest.approx(stuck, rel=1e-7, abs=0)
    work = area_integral(lambda r: 4 * FRICTION * hertz.pressure(r) * slip.slip(r), c, a)
    assert slip.dissipated_energy == pytest.approx(work, rel=1e-6, abs=0)


def test_dissipated_energy_is_the_loop_of_force_and_displacement_and_its_series_joins_it(hertz):
    below, above = (partial_slip(hertz, 0.01 + step).dissipated_energy for step in (-1e-9, 1e-9))
    assert above / below == pytest.approx(1 + 3 * 2e-9 / 0.01, abs=3e-8)
    # unloading from +Q follows the virgin curve doubled: δ = δ(Q) - 2 δ((Q - q)/2), and the loop
    # is symmetric about the origin
    slip = partial_slip(hertz, 0.8)

    def virgin(force):
        return theory.CattaneoMindlin(hertz, FRICTION, force, slip.coupling).tangential_displacement

    def unloading(force):
        return virgin(slip.tangential_load) - 2 * virgin((slip.tangential_load - force) / 2)

    area = 2 * integral(unloading, -slip.tangential_load, slip.tangential_load)
    assert slip.dissipated_energy == pytest.approx(area, rel=1e-8, abs=0)


def test_no_tangential_load_sticks_everywhere(hertz):
    slip = partial_slip(hertz, 0.0)
    assert slip.stick_radius == pytest.approx(hertz.contact_radius, rel=1e-14, abs=0)
    assert slip.dissipated_energy == 0.0
    assert slip.tangential_displacement == 0.0
    limit = theory.LimitingState(hertz, 0.0)
    assert limit.contact_radius == pytest.approx(hertz.contact_radius, rel=1e-14, abs=0)
    assert limit.central_pressure == pytest.approx(hertz.peak_pressure, rel=1e-12, abs=0)
    assert theory.LimitingState(hertz, 0.0).width_above(4 * hertz.peak_pressure) < 1e-16


def test_what_is_not_positive_and_gross_sliding_are_refused(hertz):
    for named in ("radius", "load", "composite_modulus"):
        valid = {"radius": 1.0, "load": 1.0, "composite_modulus": 1.0}
        for value in (0.0, -1.0, math.nan, math.inf):
            with pytest.raises(ValueError, match=named):
                theory.HertzContact(**(valid | {named: value}))
    for materials, named in (
        ((0.0, 0.3, 1.0, 0.3), "youngs_modulus_1"),
        ((1.0, 0.3, math.inf, 0.3), "youngs_modulus_2"),
        ((1.0, 0.51, 1.0, 0.3), "poisson_ratio_1"),
        ((1.0, 0.3, 1.0, -1.0), "poisson_ratio_2"),
    ):
        with pytest.raises(ValueError, match=named):
            theory.composite_modulus(*materials)
    for force in (-1.0, FRICTION * LOAD, 26.0, math.nan):
        with pytest.raises(ValueError, match="tangential_load"):
            theory.CattaneoMindlin(hertz, FRICTION, force, 1.2)
        with pytest.raises(ValueError, match="load_ratio"):
            theory.LimitingState(hertz, force / (FRICTION * LOAD))


@pytest.mark.parametrize(
    ("ratio", "stick", "approach", "central", "contact", "deepest", "volume"),
    [
        (0.2, 0.9283, 1.0054, 1.0057, 1.0395, 0.0172, 0.0081),
        (0.5, 0.7937, 1.0499, 1.0583, 1.1361, 0.0945, 0.1322),
        (0.9, 0.4642, 1.5081, 1.8566, 1.5710, 0.6237, 2.7791),
    ],
)
def test_limiting_state_to_four_digits(
    hertz, ratio, stick, approach, central, contact, deepest, volume
):
    limit = theory.LimitingState(hertz, ratio)
    a = hertz.contact_radius
    found = (
        limit.stick_radius / a,
        limit.approach / hertz.approach,
        limit.central_pressure / hertz.peak_pressure,
        limit.contact_radius / a,
        limit.deepest_wear / hertz.approach,
        limit.wear_volume / (a**4 / RADIUS),
    )
    expected = (stick, approach, central, contact, deepest, volume)
    np.testing.assert_allclose(found, expected, atol=0.51e-4)


def test_limiting_pressure_carries_the_load_and_exceeds_a_limit_in_a_band(limit):
    c = limit.stick_radius
    # √(1 - r²/c²) as the variable takes the infinite pressure at the rim out of the integrand
    carried = integral(
        lambda w: 2 * math.pi * c**2 * w * float(limit.pressure(c * math.sqrt(1 - w * w))), 0.0, 1.0
    )
    assert carried == pytest.approx(LOAD, rel=1e-8, abs=0)
    assert np.all(limit.pressure(np.linspace(1.0001 * c, 2 * c, 9)) == 0.0)
    assert float(limit.pressure(0.0)) == pytest.approx(limit.central_pressure, rel=1e-12, abs=0)
    allowed = 1.05 * limit.central_pressure
    width = limit.width_above(allowed)
    assert 0.0 < width < limit.stick_radius
    found = limit.pressure(limit.stick_radius - width * np.array([1.001, 1.0, 0.999]))
    assert found[0] < allowed < found[2]
    assert found[1] == pytest.approx(allowed, rel=1e-9, abs=0)
    assert limit.width_above(1e-3 * limit.central_pressure) == limit.stick_radius


def test_limiting_worn_shape_is_the_deformed_half_space_and_its_depth_the_wear(hertz, limit):
    c, edge = limit.stick_radius, limit.contact_radius
    for r in c + (edge - c) * np.array([0.05, 0.5, 0.95]):
        moved = displacement(limit.pressure, c, hertz.composite_modulus, r)
        shape = r**2 / (2 * RADIUS) + float(limit.wear_depth(r))
        assert shape == pytest.approx(limit.approach - moved, abs=3e-7 * hertz.approach)
    volume = area_integral(limit.wear_depth, c, edge)
    assert limit.wear_volume == pytest.approx(volume, rel=1e-6, abs=0)
    depth = limit.wear_depth(np.linspace(c, edge, 20001))
    assert depth.max() <= limit.deepest_wear * (1 + 1e-12)
    assert depth.max() == pytest.approx(limit.deepest_wear, rel=1e-4, abs=0)
    assert depth[0] == 0.0
    assert depth[-1] == pytest.approx(0.0, abs=1e-10 * limit.deepest_wear)
    assert np.all(limit.wear_depth(np.array([0.0, 0.5 * c, 1.001 * edge, 3 * edge])) == 0.0)


# E* = R = a = 1.
UNIT = LineContact(1.0, math.pi / 4.0, 1.0)
# X: s(a)/µκ, p(0)/p0, maximum wear depth, worn area, b/a.
TABLE = {
    0.2: (0.0311221, 1.00623, 0.0232868, 0.00520698, 1.05543),
    0.5: (0.133210, 1.06066, 0.112733, 0.0726252, 1.16919),
    0.9: (0.383419, 1.73925, 0.499559, 0.841107, 1.51674),
}


def test_hertz_carries_its_load_and_deforms_into_its_gap():
    x = np.linspace(-1.0, 1.0, 400_001)
    assert np.trapezoid(UNIT.pressure(x), x) == pytest.approx(UNIT.load, rel=1e-6)
    assert UNIT.load_at(UNIT.contact_radius) == pytest.approx(UNIT.load)
    assert UNIT.spread_pressure(UNIT.spread_radius(0.3)) == pytest.approx(0.3)
    # Midpoints of even intervals keep away from the pole of the logarithm.
    middle = 0.5 * (x[1:] + x[:-1])
    pressure = UNIT.pressure(middle) * np.diff(x)
    for at in (0.0, 0.4, 1.3):
        moved = -2.0 / math.pi * float(pressure @ np.log(np.abs(at - middle)))
        assert moved + at**2 / 2 - UNIT.approach == pytest.approx(float(UNIT.gap(at)), abs=2e-5)


def test_series_of_gap_and_energy_join_their_closed_forms():
    edge = math.sqrt(1.0 + 0.01**2)
    below, above = UNIT.gap([edge * (1 - 1e-12), edge * (1 + 1e-12)])
    assert above == pytest.approx(below, rel=1e-6)
    low, high = (LinePartialSlip(UNIT, 0.5, x * 0.5 * UNIT.load) for x in (0.00999999, 0.01))
    assert high.dissipated_energy == pytest.approx(low.dissipated_energy, rel=1e-5)
    with pytest.raises(ValueError, match="partial slip needs"):
        LinePartialSlip(UNIT, 0.5, 0.5 * UNIT.load)


@pytest.mark.parametrize("ratio", TABLE)
def test_partial_slip_and_limit_of_many_cycles(ratio):
    slip, central, depth, area, edge = TABLE[ratio]
    sliding = LinePartialSlip(UNIT, 0.4, ratio * 0.4 * UNIT.load)
    assert float(sliding.slip(1.0)) / 0.4 == pytest.approx(slip, rel=1e-5)
    x = np.linspace(0.0, 1.0, 200_001)
    share = 2.0 * np.trapezoid(UNIT.pressure(x) * (x < sliding.stick_radius), x) / UNIT.load
    assert sliding.stick_load_share == pytest.approx(share, rel=1e-5)
    energy = 8.0 * 0.4 * np.trapezoid(UNIT.pressure(x) * sliding.slip(x), x)
    assert sliding.dissipated_energy == pytest.approx(energy, rel=1e-6)
    limiting = LineLimitingState(UNIT, ratio)
    found = (
        limiting.central_pressure / UNIT.peak_pressure,
        limiting.deepest_wear,
        limiting.wear_volume,
        limiting.contact_radius,
    )
    assert found == pytest.approx((central, depth, area, edge), rel=1e-5)
    width = limiting.width_above(3.0 * UNIT.peak_pressure)
    if width < limiting.stick_radius:
        at = limiting.stick_radius - width
        assert float(limiting.pressure(at)) == pytest.approx(3.0 * UNIT.peak_pressure)


@pytest.mark.parametrize(
    ("flat", "load", "central", "peak"),
    [(0.8, 0.0817506, 0.0283243, 0.0783417), (0.4, 0.396337, 0.169519, 0.252451)],
)
def test_a_punch_with_rounded_edges(flat, load, central, peak):
    """Ciavarella, Hills and Monno (1998) at E* = R = a = 1; approach and gap by the log kernel."""
    punch = FlatPunchContact(1.0, load, 1.0, flat_half_width=flat)
    found = punch.contact_radius, float(punch.pressure(0.0)), punch.peak_pressure
    assert found == pytest.approx((1.0, central, peak), rel=3e-6)
    x = np.linspace(-1.0, 1.0, 200_001)
    middle = 0.5 * (x[1:] + x[:-1])
    pressure = punch.pressure(middle) * np.diff(x)
    assert pressure.sum() == pytest.approx(load, rel=1e-6)
    for at in (0.0, 0.5 * flat, 1.3):
        moved = -2.0 / math.pi * float(pressure @ np.log(np.abs(at - middle) / punch.reference))
        gap = moved + max(at - flat, 0.0) ** 2 / 2.0 - punch.approach
        assert gap == pytest.approx(float(punch.gap(at)), abs=3e-6)
    softer = punch.with_load(1.001 * load).approach - punch.with_load(0.999 * load).approach
    assert softer / (0.002 * load) == pytest.approx(punch.compliance, rel=1e-5)
