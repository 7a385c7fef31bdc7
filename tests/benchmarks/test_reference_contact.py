"""Contact on rings against closed forms."""

import math

import numpy as np
import pytest
from benchmarks.verification.reference_rings import (
    RingContact,
    Rings,
    disc_displacement,
    graded_rings,
    solve_contact,
)
from scipy.integrate import quad
from scipy.special import ellipk

from fretwear.theory import HertzContact

HERTZ = HertzContact(radius=1.0, load=4.0 / 3.0, composite_modulus=1.0)


def uniform(width: float, outer: float = 1.6) -> Rings:
    return Rings(np.arange(round(outer / width) + 1) * width)


def press(rings: Rings, layer, load: float = HERTZ.load, limit: float = math.inf) -> RingContact:
    r = rings.radii
    start = RingContact(HERTZ.pressure(r), HERTZ.gap(r), HERTZ.approach, r < 1.0, r < 0.0)
    return solve_contact(rings, layer, load, limit, start)


def sphere(rings: Rings):
    shape = 0.5 * rings.radii**2
    return lambda pressure: (shape, np.zeros_like(pressure))


def test_disc_displacement_at_centre_rim_and_afar():
    assert float(disc_displacement(0.0, 3.0)) == pytest.approx(2 * 3.0, rel=1e-14)
    assert float(disc_displacement(3.0, 3.0)) == pytest.approx(4 * 3.0 / math.pi, rel=1e-14)
    # a point load πb² moves the surface by πb² / (π E* r)
    assert float(disc_displacement(3e3, 3.0)) == pytest.approx(3.0**2 / 3e3, rel=1e-6)
    assert float(disc_displacement(2.0, 0.0)) == 0.0


@pytest.mark.parametrize("r", [1.001, 1.3, 5.0])
def test_disc_displacement_outside_is_the_integral_of_ring_loads(r):
    moved = quad(lambda t: 4 / math.pi * t * ellipk(4 * r * t / (r + t) ** 2) / (r + t), 0.0, 1.0)[
        0
    ]
    assert float(disc_displacement(r, 1.0)) == pytest.approx(moved, rel=1e-9)


def test_disc_displacement_is_smooth_across_the_rim():
    # the slope at the rim is logarithmic: a step of 1e-9 moves the value by less than 3e-8
    below, at, above = (float(disc_displacement(1.0 + e, 1.0)) for e in (-1e-9, 0.0, 1e-9))
    assert abs(below - at) < 3e-8
    assert abs(above - at) < 3e-8


def test_graded_rings_cover_the_disc_and_resolve_the_edge():
    rings = graded_rings(0.6, 0.4, 3.0, narrowest=1e-4, narrow=0.01, widest=0.03)
    widths = np.diff(rings.edges)
    assert rings.edges[0] == 0.0
    assert rings.edges[-1] == pytest.approx(3.0)
    assert np.all(widths > 0.0)
    assert np.min(np.abs(rings.edges - 0.6)) < 1e-12
    assert widths[np.searchsorted(rings.radii, 0.6)] < 2e-4
    swept = (rings.radii > 0.41) & (rings.radii < 0.59)
    assert widths[swept].max() < 0.0101
    assert widths[rings.radii < 0.9].max() < 0.0301
    assert float(rings.areas.sum()) == pytest.approx(math.pi * 9.0)


def test_hertz_converges_with_the_rings():
    errors = []
    for width in (0.04, 0.02, 0.01):
        contact = press(uniform(width), sphere(uniform(width)))
        hertz = HERTZ.pressure(uniform(width).radii)
        errors.append([abs(contact.approach - 1.0), np.mean(np.abs(contact.pressure - hertz))])
    errors = np.array(errors) / [1.0, HERTZ.peak_pressure]
    assert np.all(errors[-1] < [3e-5, 5e-4])
    # square-root edges allow order 3/2 in the mean; ring edges fall where they fall
    assert np.all(errors[0] / errors[-1] > 4**1.2)


def test_hertz_gap_outside():
    rings = uniform(0.01)
    contact = press(rings, sphere(rings))
    outside = rings.radii > 1.02
    np.testing.assert_allclose(contact.gap[outside], HERTZ.gap(rings.radii[outside]), atol=5e-5)


def test_flat_punch_has_its_approach():
    rings = graded_rings(1.0, 1.0, 1.5, narrowest=1e-5, narrow=0.02, widest=0.02)
    wall = np.where(rings.radii < 1.0, 0.0, 10.0)
    contact = press(rings, lambda p: (wall, np.zeros_like(p)))
    assert contact.approach == pytest.approx(HERTZ.load / 2.0, rel=1e-4)
    r = rings.radii[rings.radii < 0.9]
    punch = HERTZ.load / (2 * math.pi * np.sqrt(1 - r**2))
    np.testing.assert_allclose(contact.pressure[: r.size], punch, rtol=1e-3)


def test_soft_layer_becomes_a_mattress():
    # with a layer much softer than the half-space, p = (δ - r²/2)/c and P = π δ²/c
    rings, softness = uniform(0.02, outer=30.0), 1e3
    shape = 0.5 * rings.radii**2
    contact = press(rings, lambda p: (shape + softness * p, np.full_like(p, softness)))
    approach = math.sqrt(HERTZ.load * softness / math.pi)
    assert contact.approach == pytest.approx(approach, rel=0.02)
    inside = rings.radii**2 < 2 * approach * 0.9
    expected = (approach - shape[inside]) / softness
    np.testing.assert_allclose(contact.pressure[inside], expected, rtol=0.1)


def test_limited_pressure_is_complementary_and_carries_the_load():
    rings, limit = uniform(0.01), 0.7 * HERTZ.peak_pressure
    contact = press(rings, sphere(rings), limit=limit)
    shape = 0.5 * rings.radii**2
    gap = shape + rings.influence @ contact.pressure - contact.approach
    free = (contact.pressure > 0.0) & (contact.pressure < limit)
    assert rings.areas @ contact.pressure == pytest.approx(HERTZ.load, rel=1e-12)
    assert np.all((contact.pressure >= 0.0) & (contact.pressure <= limit))
    assert np.all(np.abs(gap[free]) < 1e-10)
    assert np.all(gap[contact.pressure == 0.0] > -1e-10)
    assert np.all(gap[contact.pressure == limit] <= 0.0)
    assert contact.yielding.sum() > 20


def test_a_limit_far_above_the_pressure_changes_nothing():
    rings = uniform(0.02)
    free = press(rings, sphere(rings))
    limited = press(rings, sphere(rings), limit=10 * HERTZ.peak_pressure)
    np.testing.assert_array_equal(free.pressure, limited.pressure)
