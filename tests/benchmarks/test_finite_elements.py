"""The page against finite elements is what its data say, and its reference is the closed form."""

from math import sqrt

import numpy as np
import pytest
from benchmarks.finite_elements import COMPOSITE, FRICTION, PAGE, RADIUS, half_width, slip
from benchmarks.pages import ROOT


def test_the_page_is_what_its_data_say():
    assert PAGE.check(ROOT / "docs") == 0


@pytest.mark.parametrize(("share", "table"), [(0.2, 0.0311221), (0.5, 0.133210), (0.9, 0.383419)])
def test_slip_at_the_edge_of_a_cylinder(share, table):
    # Slip over µ a²/R at the edge of contact, computed twice elsewhere (Johnson 1985).
    a = half_width(600.0)
    edge = slip(np.array([a]), a * sqrt(1.0 - share))
    assert edge * RADIUS / (FRICTION * a**2) == pytest.approx(table, rel=1e-5)
    assert np.pi * COMPOSITE * a**2 / (4.0 * RADIUS) == pytest.approx(600.0)
