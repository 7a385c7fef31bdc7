"""Plastic limits from a fraction of the contact pressure to beyond any material."""

import numpy as np
import pytest

from fretwear.run.simulate import steps
from fretwear.study.case_warnings import case_warnings

from ..studies import WAVES, near, steel

pytestmark = pytest.mark.slow

INDENTERS = {
    "sphere": {"radius": "10 mm"},
    "cylinder": {"radius": "10 mm"},
    "ellipsoid": {"radius_x": "10 mm", "radius_y": "20 mm"},
    "crossed_cylinders": {"radii": ["10 mm", "20 mm"]},
    "round_punch": {"flat_radius": "60 um", "edge_radius": "10 mm"},
    "flat_punch": {"flat_half_width": "100 um", "edge_radius": "10 mm"},
}
# Waves that these contacts do not press flat, along x only where the contact is a line.
SHORT = {**WAVES, "amplitude": "0.4 um", "slope_x": "3 deg"}
NAMES = ("wear_volume", "plastic_volume", "stick_area", "contact_area", "dissipated_energy")


def pressed(kind, **changes):
    is_line = kind in ("cylinder", "flat_punch")
    keys = {"radius": None, "indenter": {"kind": kind, **INDENTERS[kind]}, "cycles": 30}
    keys["load"] = "50 N/mm" if is_line else "50 N"
    # On rings, whether or not the bodies yield.
    keys["slip_model"] = "jaeger"
    if changes.pop("is_rough", False):
        keys["roughness"] = SHORT | ({"slope_y": "0 deg"} if is_line else {})
        keys["cell"] = "3.5 um"
    return steel(**keys | changes)


def results(step):
    return np.array([getattr(step.measures, name) for name in NAMES])


def worn(case):
    """Results at the end."""
    *_, last = steps(case)
    assert last.state.cycle == case.cycles
    return results(last)


@pytest.mark.parametrize(
    ("kind", "is_rough"),
    [*((kind, False) for kind in INDENTERS), ("sphere", True), ("cylinder", True)],
)
def test_a_limit_far_above_the_pressure_is_none_and_a_low_one_runs(kind, is_rough):
    """In a wavy contact tips are pressed by more than the smooth contact."""
    elastic = pressed(kind, is_rough=is_rough)
    expected, peak = worn(elastic), elastic.hertz_pressure
    found = worn(elastic.replace(plastic_limit=1e3 * peak))
    np.testing.assert_allclose(found, expected, rtol=1e-6)
    found = results(next(steps(elastic.replace(plastic_limit=1e16))))
    # Contacts of tips are known to a part in 10⁶ of their displacements.
    np.testing.assert_allclose(found, results(next(steps(elastic))), rtol=5e-6, atol=1e-30)
    for part in (0.2, 0.9):
        found = worn(elastic.replace(plastic_limit=part * peak, cycles=10))
        assert found[NAMES.index("plastic_volume")] > 0.0
        assert np.isfinite(found).all()


@pytest.mark.parametrize(
    ("kind", "parts", "rtol"),
    [
        ("sphere", (1.2, 2.0, 8.0, 30.0, 45.0), 1e-6),
        ("round_punch", (1.2, 2.0, 8.0, 30.0, 45.0), 1e-6),
        ("cylinder", (1.1, 25.0), 1e-4),
        ("ellipsoid", (1.1, 4.0), 1e-6),
    ],
)
def test_a_limit_that_is_not_reached_changes_nothing(kind, parts, rtol):
    """Rings are those of bodies that yield only where these nearly do; strips are at once."""
    elastic = pressed(kind, cycles=100, cell="4 um" if kind == "ellipsoid" else None)
    expected = worn(elastic)
    for part in parts:
        found = worn(elastic.replace(plastic_limit=part * elastic.hertz_pressure))
        np.testing.assert_allclose(found, expected, rtol=rtol, err_msg=f"{part:g} p0")


def test_the_edge_of_stick_recedes_evenly_the_less_the_higher_the_limit_and_it_is_told_if_unseen():
    """A narrow band that yields at the singular peak costs stick area in inverse proportion."""
    case = pressed("sphere", cycles=3000)
    stick, number = worn(case)[NAMES.index("stick_area")], NAMES.index("stick_area")
    lost = [
        part * (1.0 - worn(case.replace(plastic_limit=part * case.hertz_pressure))[number] / stick)
        for part in (6.0, 12.0, 24.0)
    ]
    assert lost[0] > lost[1] > lost[2] > 0.75 * lost[0]
    unseen = case.replace(plastic_limit=45.0 * case.hertz_pressure)
    assert worn(unseen)[number] == near(stick, rel=1e-3)
    assert any("narrower than a cell" in each.what for each in case_warnings(unseen))


def test_a_peak_that_stays_below_its_limit_is_measured_as_that_of_elastic_bodies():
    """In the mean over a written cell, where the narrowest ring alone would show several times it.

    What is left of it up to the limit is its error where it is singular.
    """
    elastic = steel(cycles=3000, cell="1 um", error_estimate=False, slip_model="jaeger")
    capped = elastic.replace(plastic_limit=300.0 * elastic.hertz_pressure)
    peaks = [list(steps(case))[-1] for case in (elastic, capped)]
    without, below = (each.measures.peak_pressure for each in peaks)
    assert below == near(without, rel=1e-6)
    assert below < 0.4 * peaks[1].state.pressure.max()


@pytest.mark.parametrize(("ratio", "part"), [(0.06, 0.21), (0.3, 0.42), (0.9, 0.27)])
def test_a_contact_that_yields_all_over_runs_however_narrow_its_slip_annulus(ratio, part):
    case = steel(tangential_ratio=ratio, cycles=30)
    found = worn(case.replace(plastic_limit=part * case.hertz_pressure))
    area = case.load / (part * case.hertz_pressure)
    # At the limit nearly everywhere, it is as wide as carries the load, and somewhat more.
    assert 0.999 * area <= found[NAMES.index("contact_area")] < 1.3 * area
