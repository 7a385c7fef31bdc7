"""Line contact against tabulated values, quadrature and limits."""

import math

import numpy as np
import pytest

from fretwear.theory import FlatPunchContact, LineContact, LineLimitingState, LinePartialSlip

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
    found = punch.contact_radius, punch.central_pressure, punch.peak_pressure
    assert found == pytest.approx((1.0, central, peak), rel=3e-6)
    x = np.linspace(-1.0, 1.0, 200_001)
    middle = 0.5 * (x[1:] + x[:-1])
    pressure = punch.pressure(middle) * np.diff(x)
    assert pressure.sum() == pytest.approx(load, rel=1e-6)
    assert pressure[abs(middle) < 0.5].sum() == pytest.approx(punch.load_within(0.5), rel=2e-4)
    for at in (0.0, 0.5 * flat, 1.3):
        moved = -2.0 / math.pi * float(pressure @ np.log(np.abs(at - middle) / punch.reference))
        gap = moved + max(at - flat, 0.0) ** 2 / 2.0 - punch.approach
        assert gap == pytest.approx(float(punch.gap(at)), abs=3e-6)
    softer = punch.with_load(1.001 * load).approach - punch.with_load(0.999 * load).approach
    assert softer / (0.002 * load) == pytest.approx(punch.compliance, rel=1e-5)
