"""Closed forms against quadrature, tabulated values, limits and one another."""

import math

import numpy as np
import pytest
from scipy.integrate import quad
from scipy.special import ellipk

from fretwear import theory
from fretwear.theory import FlatPunchContact, HertzContact, LineContact

from ..studies import near

STEEL = (208e9, 0.3)
FRICTION = 0.5
SPHERE = HertzContact(10e-3, 50.0, theory.composite_modulus(*STEEL, *STEEL))
# E* = R = a = 1.
UNIT = LineContact(1.0, math.pi / 4.0, 1.0)
RATIOS = pytest.mark.parametrize("ratio", [0.001, 0.2, 0.5, 0.8, 0.9, 0.99])
BOTH = pytest.mark.parametrize("hertz", [SPHERE, UNIT], ids=["sphere", "cylinder"])


def partial_slip(hertz, ratio):
    kind, coupling = theory.PartialSlip, theory.coupling_ratio(*STEEL, *STEEL)
    if isinstance(hertz, LineContact):
        kind, coupling = theory.LinePartialSlip, 1.0
    return kind(hertz, FRICTION, ratio * FRICTION * hertz.load, coupling)


def limit_of(hertz, ratio):
    is_line = isinstance(hertz, LineContact)
    return (theory.LineLimitingState if is_line else theory.LimitingState)(hertz, ratio)


def integral(function, start, end):
    return quad(function, start, end, epsabs=0.0, epsrel=1e-11, limit=200)[0]


def over_contact(hertz, function, start, end):
    """∫ f dA; the substitution r = m - h·cos t removes square roots at both ends."""
    middle, half = (start + end) / 2, (end - start) / 2

    def integrand(t):
        r = middle - half * math.cos(t)
        around = 2.0 if isinstance(hertz, LineContact) else 2 * math.pi * r
        return around * float(function(r)) * half * math.sin(t)

    return integral(integrand, 0.0, math.pi)


def test_composites_of_two_materials_are_symmetric_and_reach_the_rigid_limit():
    brass, rigid = (100e9, 0.35), (1e30, 0.2)
    for combine in (theory.composite_modulus, theory.coupling_ratio):
        assert combine(*STEEL, *brass) == near(combine(*brass, *STEEL), 1e-14)
    normal, shear = 100e9 / (1 - 0.35**2), 4 * 100e9 / (2 * 1.35) / (2 - 0.35)
    assert theory.composite_modulus(*brass, *rigid) == pytest.approx(normal)
    assert theory.coupling_ratio(*brass, *rigid) == pytest.approx(normal / shear)


@BOTH
def test_hertz_pressure_carries_the_load_and_series_of_gap_and_energy_join_closed_forms(hertz):
    a = hertz.contact_radius
    assert over_contact(hertz, hertz.pressure, 0.0, a) == near(hertz.load, 1e-9)
    assert hertz.load_at(a) == near(hertz.load, 1e-14)
    half = hertz.with_load(0.5 * hertz.load)
    assert hertz.with_approach(half.approach).load == near(half.load, 1e-9)
    spread = hertz.spread_radius(0.3 * hertz.peak_pressure)
    assert hertz.spread_pressure(spread) == near(0.3 * hertz.peak_pressure, 1e-14)
    # the switch lies at √(r²/a² - 1) = 0.01; the slope of log g must not jump there
    r = a * math.sqrt(1 + 0.01**2) * (1 + np.array([-2e-9, -1e-9, 1e-9, 2e-9]))
    below, across, above = np.diff(hertz.gap(r)) / np.diff(r)
    assert across == near((below + above) / 2, 1e-3)
    below, above = (partial_slip(hertz, 0.01 + step).dissipated_energy for step in (-1e-9, 1e-9))
    assert above / below == pytest.approx(1 + 3 * 2e-9 / 0.01, abs=3e-8)


def test_the_approach_and_the_gap_of_a_sphere_follow_from_flat_punches():
    modulus, a = SPHERE.composite_modulus, SPHERE.contact_radius
    assert SPHERE.peak_pressure == near(2 * modulus * a / (math.pi * SPHERE.radius), 1e-14)

    # the stiffness of a circular contact is dP/dδ = 2 E* a, whatever the profile
    def compliance(load):
        return 1 / (2 * modulus * SPHERE.with_load(load).contact_radius)

    assert SPHERE.approach == near(integral(compliance, 0.0, SPHERE.load), 1e-8)
    for r in a * np.array([1.0, 1.001, 1.1, 3.0]):
        lifted = integral(lambda b, r=r: 2 * b * math.acos(b / r), 0.0, a)
        gap = r**2 / (2 * SPHERE.radius) - 2 / (math.pi * SPHERE.radius) * lifted
        assert float(SPHERE.gap(r)) == pytest.approx(gap, rel=1e-9, abs=1e-13 * SPHERE.approach)


@BOTH
@RATIOS
def test_shear_traction_carries_the_load_obeys_coulomb_and_dissipates_the_work_of_friction(
    hertz, ratio
):
    slip = partial_slip(hertz, ratio)
    c, a = slip.stick_radius, hertz.contact_radius
    carried = sum(over_contact(hertz, slip.shear_traction, *ends) for ends in ((0.0, c), (c, a)))
    assert carried == near(slip.tangential_load, 1e-7)
    annulus, disc = np.linspace(c, a, 20), np.linspace(0.0, 0.999 * c, 20)
    np.testing.assert_allclose(
        slip.shear_traction(annulus), FRICTION * hertz.pressure(annulus), rtol=1e-14
    )
    assert np.all(slip.shear_traction(disc) < FRICTION * hertz.pressure(disc))
    assert np.all(slip.slip(disc) == 0.0)
    assert np.all(slip.slip(annulus[1:]) > 0.0)
    stuck = over_contact(hertz, hertz.pressure, 0.0, c)
    assert slip.stick_load_share * hertz.load == near(stuck, 1e-7)
    work = over_contact(hertz, lambda r: 4 * FRICTION * hertz.pressure(r) * slip.slip(r), c, a)
    assert slip.dissipated_energy == near(work, 1e-6)


@BOTH
def test_dissipated_energy_is_the_loop_of_force_and_displacement(hertz):
    # unloading from +Q follows the virgin curve doubled: δ = δ(Q) - 2 δ((Q - q)/2), and the loop
    # is symmetric about the origin
    slip = partial_slip(hertz, 0.8)

    def virgin(force):
        return partial_slip(hertz, force / (FRICTION * hertz.load)).tangential_displacement

    def unloading(force):
        return virgin(slip.tangential_load) - 2 * virgin((slip.tangential_load - force) / 2)

    area = 2 * integral(unloading, -slip.tangential_load, slip.tangential_load)
    assert slip.dissipated_energy == near(area, 1e-8)


# X: c/a, approach, central pressure, contact radius, deepest wear and volume of a sphere, over
# those of Hertz, δ and a⁴/R; central pressure, half-width, wear, area and s(a)/µ of the cylinder.
LIMITS = [
    (0.2, (0.9283, 1.0054, 1.0057, 1.0395, 0.0172, 0.0081),
     (1.00623, 1.05543, 0.0232868, 0.00520698, 0.0311221)),
    (0.5, (0.7937, 1.0499, 1.0583, 1.1361, 0.0945, 0.1322),
     (1.06066, 1.16919, 0.112733, 0.0726252, 0.133210)),
    (0.9, (0.4642, 1.5081, 1.8566, 1.5710, 0.6237, 2.7791),
     (1.73925, 1.51674, 0.499559, 0.841107, 0.383419)),
]  # fmt: skip


@pytest.mark.parametrize(("ratio", "sphere", "cylinder"), LIMITS)
def test_limiting_state_to_all_digits_of_a_table(ratio, sphere, cylinder):
    limit, a = theory.LimitingState(SPHERE, ratio), SPHERE.contact_radius
    found = (
        limit.stick_radius / a,
        limit.approach / SPHERE.approach,
        limit.central_pressure / SPHERE.peak_pressure,
        limit.contact_radius / a,
        limit.deepest_wear / SPHERE.approach,
        limit.wear_volume / (a**4 / SPHERE.radius),
    )
    np.testing.assert_allclose(found, sphere, atol=0.51e-4)
    limit = theory.LineLimitingState(UNIT, ratio)
    found = (
        limit.central_pressure / UNIT.peak_pressure,
        limit.contact_radius,
        limit.deepest_wear,
        limit.wear_volume,
        float(partial_slip(UNIT, ratio).slip(1.0)) / FRICTION,
    )
    assert found == pytest.approx(cylinder, rel=1e-5)


@BOTH
@RATIOS
def test_limiting_pressure_carries_the_load_and_exceeds_a_limit_in_a_band(hertz, ratio):
    limit = limit_of(hertz, ratio)
    c = limit.stick_radius

    # r = c sin t takes the infinite pressure at the rim out of the integrand
    def carried(t):
        around = 2.0 if hertz is UNIT else 2 * math.pi * c * math.sin(t)
        return around * c * math.cos(t) * float(limit.pressure(c * math.sin(t)))

    assert integral(carried, 0.0, math.pi / 2 - 1e-9) == near(hertz.load, 1e-7)
    assert np.all(limit.pressure(np.linspace(1.0001 * c, 2 * c, 9)) == 0.0)
    allowed = 1.05 * limit.central_pressure
    width = limit.width_above(allowed)
    assert 0.0 < width < c
    found = limit.pressure(c - width * np.array([1.001, 1.0, 0.999]))
    assert found[0] < allowed < found[2]
    assert found[1] == near(allowed, 1e-9)
    assert limit.width_above(1e-3 * limit.central_pressure) == c


def displacement(pressure, outer, modulus, r):
    """Surface displacement at r ≥ outer by quadrature of ring loads (Johnson 1985, section 3.8)."""

    def integrand(angle):
        t = outer * math.sin(angle)
        load = float(pressure(t)) * t * outer * math.cos(angle)
        return load * ellipk(4 * r * t / (r + t) ** 2) / (r + t)

    # just short of the rim, where the pressure may be infinite but the load is not
    return 4 / (math.pi * modulus) * integral(integrand, 0.0, math.pi / 2 - 1e-9)


@BOTH
@RATIOS
def test_limiting_worn_shape_is_the_deformed_half_space_and_its_depth_the_wear(hertz, ratio):
    limit = limit_of(hertz, ratio)
    c, edge = limit.stick_radius, limit.contact_radius
    for r in c + (edge - c) * np.array([0.05, 0.5, 0.95]) if hertz is SPHERE else ():
        moved = displacement(limit.pressure, c, hertz.composite_modulus, r)
        shape = r**2 / (2 * hertz.radius) + float(limit.wear_depth(r))
        assert shape == pytest.approx(limit.approach - moved, abs=3e-7 * hertz.approach)
    volume = over_contact(hertz, limit.wear_depth, c, edge)
    assert limit.wear_volume == near(volume, 1e-6)
    depth = limit.wear_depth(np.linspace(c, edge, 20001))
    assert depth.max() == near(limit.deepest_wear, 1e-8)
    assert depth[0] == 0.0
    assert depth[-1] == pytest.approx(0.0, abs=1e-10 * limit.deepest_wear)
    assert np.all(limit.wear_depth(np.array([0.0, 0.5 * c, 1.001 * edge, 3 * edge])) == 0.0)


@pytest.mark.parametrize(
    ("contact", "central", "peak"),
    [
        (UNIT, 0.5, 0.5),
        (FlatPunchContact(1.0, 0.0817506, 1.0, flat_half_width=0.8), 0.0283243, 0.0783417),
        (FlatPunchContact(1.0, 0.396337, 1.0, flat_half_width=0.4), 0.169519, 0.252451),
    ],
)
def test_cylinders_and_punches_with_rounded_edges_deform_into_their_gap(contact, central, peak):
    """Ciavarella, Hills and Monno (1998) at E* = R = a = 1; approach and gap by the log kernel."""
    found = contact.contact_radius, float(contact.pressure(0.0)), contact.peak_pressure
    assert found == pytest.approx((1.0, central, peak), rel=3e-6)
    # Midpoints of even intervals keep away from the pole of the logarithm.
    x = np.linspace(-1.0, 1.0, 200_001)
    middle = 0.5 * (x[1:] + x[:-1])
    pressure = contact.pressure(middle) * np.diff(x)
    assert pressure.sum() == pytest.approx(contact.load, rel=1e-6)
    flat = getattr(contact, "flat_half_width", 0.0)
    for spot in (0.0, 0.5 * flat, 0.4, 1.3):
        moved = -2.0 / math.pi * float(pressure @ np.log(np.abs(spot - middle) / contact.reference))
        gap = moved + max(spot - flat, 0.0) ** 2 / 2.0 - contact.approach
        assert gap == pytest.approx(float(contact.gap(spot)), abs=2e-5)
    loads = (0.999 * contact.load, 1.001 * contact.load)
    low, high = (contact.with_load(load).approach for load in loads)
    assert (high - low) / (loads[1] - loads[0]) == pytest.approx(contact.compliance, rel=1e-5)


@pytest.mark.parametrize("zero", [-9.0, 0.0, 0.3, 2.0, 9.0])
def test_a_root_outside_its_ends_is_the_nearest_end(zero):
    def convex(x):
        return (zero - x) * (1.0 + (x - zero) ** 2 * (zero > x))

    assert theory.find_root(convex, 0.0, 2.0) == near(min(max(zero, 0.0), 2.0), 1e-14)
