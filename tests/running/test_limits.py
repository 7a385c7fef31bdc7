"""Plastic limits from a fraction of the contact pressure to beyond any material."""

import numpy as np
import pytest

from fretwear.mechanics.measures import measure
from fretwear.running.simulate import steps, wear_problem

from ..studies import WAVES, steel

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
    given = {"radius": None, "indenter": {"kind": kind, **INDENTERS[kind]}, "cycles": 300}
    given["load"] = "50 N/mm" if is_line else "50 N"
    if changes.pop("is_rough", False):
        given["roughness"] = SHORT | ({"slope_y": "0 deg"} if is_line else {})
        given |= {"cycles": 30, "cell": "3.5 um"}
    return steel(**given, **changes)


def worn(case):
    """Results at the end, and the number of steps."""
    *_, last = steps(case)
    found = measure(wear_problem(case), last.state)
    assert last.state.cycle == case.cycles
    return np.array([getattr(found, name) for name in NAMES])


@pytest.mark.parametrize("is_rough", [False, True], ids=["smooth", "wavy"])
@pytest.mark.parametrize("kind", INDENTERS)
def test_a_limit_far_above_the_pressure_is_none_and_a_low_one_runs(kind, is_rough):
    """In a wavy contact tips are pressed by more than the smooth contact."""
    elastic = pressed(kind, is_rough=is_rough)
    expected, peak = worn(elastic), elastic.hertz_pressure
    for limit in (1e3 * peak, 1e16):
        found = worn(pressed(kind, is_rough=is_rough, plastic_limit=limit))
        np.testing.assert_allclose(found, expected, rtol=1e-6, err_msg=f"{limit:g} Pa")
    for part in (0.2, 0.9):
        found = worn(pressed(kind, is_rough=is_rough, plastic_limit=part * peak))
        assert found[NAMES.index("plastic_volume")] > 0.0
        assert np.isfinite(found).all()


@pytest.mark.parametrize("kind", ["sphere", "cylinder", "ellipsoid", "round_punch"])
def test_results_change_evenly_along_a_sweep_of_the_limit(kind):
    """The less yields the less do they differ, and never by more than by nothing that yields."""
    elastic = worn(pressed(kind))
    sweep = np.geomspace(3.0, 300.0, 9) * pressed(kind).hertz_pressure
    found = np.array([worn(pressed(kind, plastic_limit=limit)) for limit in sweep])
    away = np.abs(found[:, 0] / elastic[0] - 1), np.abs(found[:, 2] / elastic[2] - 1)
    # Wear is known to some parts in 10⁵, the edge of stick on wider cells to one in 10³.
    assert away[0].max() < 2e-4
    assert away[1].max() < 1.5e-3
    assert found[-1] == pytest.approx(elastic, rel=1e-6)


@pytest.mark.parametrize(
    ("flat", "edge", "load", "limit"),
    [
        ("250 um", "2 mm", "5 N", "3 GPa"),
        ("250 um", "2 mm", "5 N", "0.3 GPa"),
        ("250 um", "10 mm", "5 N", "3 GPa"),
        ("500 um", "5 mm", "20 N", "3 GPa"),
        ("60 um", "10 mm", "50 N", "0.28 GPa"),
    ],
)
def test_punches_under_light_and_heavy_loads_run(flat, edge, load, limit):
    punch = {"kind": "round_punch", "flat_radius": flat, "edge_radius": edge}
    given = {"radius": None, "indenter": punch, "load": load, "cycles": 30}
    capped, elastic = worn(steel(**given, plastic_limit=limit)), worn(steel(**given))
    if capped[NAMES.index("plastic_volume")] == 0.0:
        np.testing.assert_allclose(capped, elastic, rtol=1e-4)


@pytest.mark.parametrize("ratio", [0.06, 0.3, 0.9])
@pytest.mark.parametrize("part", [0.21, 0.27, 0.42])
def test_a_contact_that_yields_all_over_runs_however_narrow_its_slip_annulus(ratio, part):
    case = steel(tangential_ratio=ratio, cycles=30)
    found = worn(case.replace(plastic_limit=part * case.hertz_pressure))
    area = case.load / (part * case.hertz_pressure)
    # At the limit nearly everywhere, it is as wide as carries the load, and somewhat more.
    assert 0.999 * area <= found[NAMES.index("contact_area")] < 1.3 * area
