"""The independent reference on rings: closed forms, another scheme, laws of contact, its table."""

import csv
import math
from pathlib import Path

import numpy as np
import pytest
from benchmarks.verification.reference_rings import (
    UNIT_HERTZ,
    Resolution,
    RingContact,
    Rings,
    dimensionless_history,
    graded_rings,
    solve_contact,
)

P0 = UNIT_HERTZ.peak_pressure
LIMIT = 4.1622421
APPROACH, CENTRAL, DEEPEST, VOLUME, PLASTIC, CONTACT, STICK = range(7)
TABLE = Path(__file__).parents[1] / "mechanics/reference/smooth_wear.csv"


def press(rings, shape):
    r, rigid = rings.radii, np.zeros_like(shape)
    hertz = UNIT_HERTZ.pressure(r), UNIT_HERTZ.gap(r), UNIT_HERTZ.approach, r < 1.0, r < 0.0
    start = RingContact(*hertz)
    return solve_contact(rings, lambda _: (shape, rigid), UNIT_HERTZ.load, math.inf, start)


def test_hertz_converges_with_the_rings_and_a_flat_punch_has_its_approach():
    errors = []
    for width in (0.04, 0.02, 0.01):
        rings = Rings(np.arange(round(1.6 / width) + 1) * width)
        contact = press(rings, 0.5 * rings.radii**2)
        error = np.abs(contact.pressure - UNIT_HERTZ.pressure(rings.radii)).mean() / P0
        errors.append([abs(contact.approach - 1.0), error])
    assert np.all(np.array(errors[-1]) < [3e-5, 5e-4])
    # Square-root edges allow order 3/2 in the mean; ring edges fall where they fall.
    assert np.all(np.divide(errors[0], errors[-1]) > 4**1.2)
    outside = rings.radii > 1.02
    gap = UNIT_HERTZ.gap(rings.radii[outside])
    np.testing.assert_allclose(contact.gap[outside], gap, atol=5e-5)
    rings = graded_rings(1.0, 1.0, 1.5, narrowest=1e-5, narrow=0.02, widest=0.02)
    contact = press(rings, np.where(rings.radii < 1.0, 0.0, 10.0))
    assert contact.approach == pytest.approx(UNIT_HERTZ.load / 2.0, rel=1e-4)
    r = rings.radii[rings.radii < 0.9]
    punch = UNIT_HERTZ.load / (2 * math.pi * np.sqrt(1 - r**2))
    np.testing.assert_allclose(contact.pressure[: r.size], punch, rtol=1e-3)


@pytest.mark.slow
@pytest.mark.parametrize(("load_ratio", "limit"), [(0.8, LIMIT), (0.9, math.inf)])
def test_the_table_that_mechanics_is_compared_with_is_that_of_the_solver(load_ratio, limit):
    """Rows are load and limit ratio, growth, τ, the seven values and their uncertainties."""
    with TABLE.open(newline="", encoding="utf-8") as file:
        rows = [[float(value) for value in row] for row in list(csv.reader(file))[1:]]
    rows = np.array([r[3:] for r in rows if r[:3] == [load_ratio, limit, 0.0] and r[3] <= 10.0])
    resolution = Resolution(swept_width=1 / 120, edge_width=1e-4, widest=0.015, step=0.4)
    values, _ = dimensionless_history(load_ratio, limit, list(rows[:, 0]), resolution)
    values[CENTRAL] /= P0
    expected, uncertainty = rows[:, 1:8].T, rows[:, 8:].T
    error, allowed = np.abs(values - expected), 0.01 * np.abs(expected) + uncertainty + 1e-12
    smooth = [APPROACH, CENTRAL, DEEPEST, VOLUME]
    assert np.all(error[smooth] <= allowed[smooth])
    # Edges are found to a ring; what yields lies within a few rings of the stick edge.
    assert np.all(error[[CONTACT, STICK]] <= 0.02)
    assert np.all(error[PLASTIC] <= 10 * allowed[PLASTIC] + 1e-5)
