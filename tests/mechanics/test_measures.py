"""Numbers that describe a contact, against closed forms and synthetic fields."""

from dataclasses import fields, replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from fretwear.mechanics.geometry.grid import Grid
from fretwear.mechanics.integrator import first_loading
from fretwear.mechanics.measures import Measures, half_width, measure, stick_half_width
from fretwear.mechanics.roughness import WavyRoughness
from fretwear.mechanics.state import CONTACT_GAP, in_contact
from fretwear.theory import CattaneoMindlin

from .problems import COUPLING, EVEN, FRICTION, HERTZ, LOAD, P0, A, fretting, near

PROBLEM = fretting()


@pytest.fixture(scope="module")
def unworn():
    return first_loading(fretting(64, load_ratio=0.5))


def test_measures_of_the_unworn_sphere_are_those_of_hertz_and_cattaneo(unworn):
    theory = CattaneoMindlin(HERTZ, FRICTION, 0.5 * FRICTION * LOAD, COUPLING)
    found = measure(PROBLEM, unworn)
    # What Hertz's pressure carries inside the stick radius.
    share = 1.0 - (1.0 - (theory.stick_radius / A) ** 2) ** 1.5
    expected = {
        "approach": HERTZ.approach,
        "tangential_displacement": theory.tangential_displacement,
        "normal_force": LOAD,
        "tangential_force": theory.tangential_load,
        "regime": 0.0,
        "sliding_ratio": theory.dissipated_energy
        / (4.0 * theory.tangential_load * theory.tangential_displacement),
        "contact_half_width_x": A,
        "contact_half_width_y": A,
        "stick_half_width_x": theory.stick_radius,
        "stick_half_width_y": theory.stick_radius,
        "contact_area": np.pi * A**2,
        "stick_area": np.pi * theory.stick_radius**2,
        "mean_stick_pressure": share * LOAD / (np.pi * theory.stick_radius**2),
        "stick_load_share": share,
        "peak_pressure": P0,
        "central_pressure": P0,
        "wear_volume": 0.0,
        "maximum_wear_depth": 0.0,
        "plastic_volume": 0.0,
        "dissipated_energy": theory.dissipated_energy,
    }
    assert expected.keys() == {field.name for field in fields(Measures)}
    # Areas count cells: at 64 cells per radius a disc is known to some 0.5 %.
    for name, value in expected.items():
        assert getattr(found, name) == near(
            value, rel=1e-2 if "area" in name or "stick" in name else 4e-3
        )


@given(
    edge=st.floats(2.0, 15.0),
    axis=st.sampled_from([0, 1]),
    even=st.sampled_from(EVEN),
    power=st.sampled_from([1.5, 1.0]),
)
def test_half_width_finds_the_edge_inside_a_cell_unworn_and_worn_in(edge, axis, even, power):
    spacing = (1e-6, 1.7e-6)
    cells = Grid(tuple(20 if one else 40 for one in even), spacing, even)
    position = np.abs(cells.x[:, None] if axis == 0 else cells.y[None, :])
    distance = np.broadcast_to(position, cells.shape) / spacing[axis]
    gap = 1e-9 * np.maximum(distance - edge, 0.0) ** power
    # Both power laws are met exactly, so only rounding is left.
    found = half_width(cells, gap == 0, gap, axis)
    assert found == near(edge * spacing[axis], rel=1e-9)


def test_half_widths_of_odd_contacts():
    """Cells outside with equal gaps put the edge in the middle between cell centers."""
    uneven = Grid((20, 8), (1e-6, 1e-6), (False, True))
    inside = np.zeros(uneven.shape, dtype=bool)
    inside[4:13, 0] = True
    # From -6 µm to 3 µm: the mean of both sides.
    assert half_width(uneven, inside, np.where(inside, 0.0, 1e-9), 0) == near(4.5e-6)
    assert stick_half_width(uneven, inside * 1e9, 0) == near(4.5e-6)
    cells = Grid((8, 6), (1e-6, 2e-6))
    nothing, off_axis, spots = (np.zeros(cells.shape, dtype=bool) for _ in range(3))
    off_axis[3, 4] = spots[[0, 1, 5, 6], 0] = True
    # Zero where the axis is open, up to the outermost spot, and the window at most.
    for inside, expected in ((nothing, 0.0), (off_axis, 0.0), (spots, 7e-6)):
        assert half_width(cells, inside, np.where(inside, 0.0, 1e-9), 0) == near(expected)
    assert half_width(cells, ~nothing, np.zeros(cells.shape), 1) == near(cells.extent[1])


def test_areas_and_mean_pressures_of_rough_contacts_converge_with_few_cells_on_a_tip():
    """Counts of cells fall linearly with the spacing, to where corrected areas are at once."""
    rough = WavyRoughness(amplitude=0.2e-6, slope_x=np.radians(2), slope_y=np.radians(1))

    def areas(cells):
        problem = fretting(2 * cells, roughness=rough, spacing=(A / cells, 2 * A / cells))
        state = first_loading(problem)
        found = measure(problem, state)
        zones = in_contact(state), state.reduced.stick
        counted = [state.geometry.unit_area * zone.sum() for zone in zones]
        means.append((state.pressure[zones[1]].mean(), found.mean_stick_pressure))
        return np.array([counted, [found.contact_area, found.stick_area]])

    means: list[tuple[float, float]] = []

    coarse, fine = areas(128), areas(256)
    converged = 2 * fine[0] - coarse[0]
    assert (coarse[0] > 1.03 * converged).all()
    np.testing.assert_allclose(coarse[1], converged, rtol=0.025)
    np.testing.assert_allclose(fine[1], converged, rtol=0.01)
    # What cells cover beyond the edge carries less than they do in the mean.
    mean = 2 * means[1][0] - means[0][0]
    assert means[0][1] == near(mean, rel=0.025)
    assert means[1][1] == near(mean, rel=0.01)
    # Where a few cells on each tip are all at the limit, their corrected area is smaller.
    rough = WavyRoughness(amplitude=0.2e-6, slope_x=np.radians(5.7), slope_y=np.radians(1))
    problem = fretting(100, roughness=rough, limit=4.5e9 / P0)
    found = measure(problem, first_loading(problem))
    assert 0.9 * 4.5e9 < found.mean_stick_pressure <= 4.5e9


def test_contact_is_read_off_the_gap_wherever_the_approach_counts_from(unworn):
    # Worn surfaces conform: no pressure, and no gap either.
    conforming = replace(
        unworn,
        pressure=np.where(unworn.reduced.stick, unworn.pressure, 0.0),
        gap=np.where(in_contact(unworn), 0.9 * CONTACT_GAP * unworn.approach, unworn.gap),
    )
    np.testing.assert_array_equal(in_contact(conforming), in_contact(unworn))
    assert measure(PROBLEM, conforming).contact_area == measure(PROBLEM, unworn).contact_area
    raised = unworn.gap + 1.1 * CONTACT_GAP * unworn.approach
    opened = replace(unworn, pressure=np.zeros_like(raised), gap=raised)
    assert measure(PROBLEM, opened).contact_area == 0
    # Waves that only touch in their valleys bring the approach down to zero and below.
    for height in (1.0, 2.0):
        lowered = replace(unworn, approach=unworn.approach * (1.0 - height))
        area = measure(PROBLEM, unworn).contact_area
        assert measure(PROBLEM, lowered).contact_area == near(area, rel=1e-12)
