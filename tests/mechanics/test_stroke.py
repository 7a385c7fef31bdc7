"""Line contacts that slide as a whole, over strokes long and short."""

from dataclasses import replace

import numpy as np
import pytest

from fretwear.mechanics.geometry.line import Line, influence_of_cell
from fretwear.mechanics.integrator import WearError, evolve
from fretwear.mechanics.loading import NormalLoad, SlidingAmplitude
from fretwear.mechanics.materials import Coulomb, ElasticBodies
from fretwear.mechanics.measures import measure
from fretwear.mechanics.slip import ReducedContact, SlipModel
from fretwear.mechanics.stroke import positions, slide
from fretwear.mechanics.surfaces import Cylinder
from fretwear.mechanics.wear_laws import Archard

from .problems import fretting

CYLINDER, LOAD, STROKE = Cylinder(6e-3), 18.5e3, 24.24e-6
BODIES = ElasticBodies(200e9, 0.3)
A = CYLINDER.hertz(NormalLoad(LOAD), BODIES.composite_modulus).contact_radius
INDENTER, FLAT = 1.9e-14, 2.9e-14


def sliding(stroke=STROKE, coefficients=(INDENTER, FLAT), cells=12, **changes):
    """The cylinder on a flat of McColl, Ding and Leen (2004)."""
    return fretting(
        **{
            "indenter": CYLINDER,
            "bodies": BODIES,
            "normal": NormalLoad(LOAD),
            "loading": SlidingAmplitude(stroke),
            "friction": Coulomb(0.9),
            "wear_law": Archard(coefficients),
            "spacing": (A / cells, A / cells),
            "extent": (1.15 * A, 1.15 * A),
            "geometry": Line,
            **changes,
        }
    )


@pytest.fixture(scope="module")
def worn():
    """At 5000 and at 18000 cycles."""
    stops = (5000.0, 18000.0)
    return {each.cycle: each for each in slide(sliding(), stops) if each.cycle in stops}


def test_depths_lie_by_two_finite_element_solutions(worn):
    """Adaptive meshes and level sets, from LevelSetWear, differ by 0.3 to 0.6 %."""
    for cycle, found in ((5000, (1.1311, 1.1249)), (18000, (2.7130, 2.7055))):
        assert 1e6 * worn[cycle].wear_flat.max() == pytest.approx(np.mean(found), rel=4e-3)
    flat, x = worn[18000].wear_flat[:, 0], worn[18000].geometry.x
    width = 2.0 * np.interp(0.01 * flat.max(), flat[::-1], x[::-1])
    assert width == pytest.approx(0.52e-3, abs=0.02e-3)


def test_each_body_loses_what_archard_says(worn):
    for cycle, state in worn.items():
        for wear, coefficient in ((state.wear_indenter, INDENTER), (state.wear_flat, FLAT)):
            volume = state.geometry.integral(wear)
            assert volume == pytest.approx(coefficient * LOAD * 4.0 * STROKE * cycle, rel=1e-9)
        found = measure(sliding(), state)
        assert found.dissipated_energy == pytest.approx(4.0 * 0.9 * LOAD * STROKE, rel=1e-9)
        assert found.tangential_displacement == pytest.approx(STROKE, rel=1e-9)


def test_every_position_carries_the_load_without_penetration(worn):
    """Pressure, gap and shape of each position by a dense matrix, worn parts by interpolation."""
    state, problem = worn[18000], sliding()
    h, half = problem.spacing[0], state.geometry.shape[0]
    x = (np.arange(2 * half) - half + 0.5) * h
    column = influence_of_cell(2 * half, h, CYLINDER.radius, BODIES.composite_modulus)
    index = np.arange(2 * half)
    influence = column[abs(index[:, None] - index)]
    places = (np.arange(half) + 0.5) * h
    for place, pressure in zip(positions(problem)[0], state.pressures, strict=True):
        assert h * pressure.sum() == pytest.approx(LOAD, rel=1e-9)
        assert pressure.min() >= 0
        worn_off = np.interp(abs(x), places, state.wear_flat[:, 0], right=0)
        worn_off += np.interp(abs(x - place), places, state.wear_indenter[:, 0], right=0)
        gap = influence @ pressure + (x - place) ** 2 / 2 / CYLINDER.radius + worn_off
        gap -= gap[pressure > 0].mean()
        # The end of a step has worn a little more than its last stage.
        assert abs(gap[pressure > 0]).max() < 2e-9
        assert gap.min() > -2e-9


def test_cells_and_tolerance_do_not_matter(worn):
    *_, finer = slide(sliding(cells=17), (5000.0,), 0.002)
    assert finer.wear_flat.max() == pytest.approx(worn[5000].wear_flat.max(), rel=2e-3)
    assert finer.wear_indenter.max() == pytest.approx(worn[5000].wear_indenter.max(), rel=2e-3)


def test_a_run_resumes_with_the_same_bits(worn):
    *_, resumed = slide(sliding(), (18000.0,), start=worn[5000])
    assert np.array_equal(resumed.wear_flat, worn[18000].wear_flat)


def test_blocks_are_refused():
    with pytest.raises(WearError, match="blocks"):
        next(iter(slide(replace(sliding(), end=5.0, following=sliding()), (10.0,))))


class Uniform(SlipModel):
    """The same slip everywhere: a contact that does not see its bodies move."""

    def reduced(self, problem, half_space, shape, *start, **tolerance):
        del half_space, start, tolerance
        gap = problem.loading.stroke / (problem.friction.coefficient * problem.coupling)
        return ReducedContact(np.zeros_like(shape), np.full_like(shape, gap), 0.0, 0.0)


def test_a_short_stroke_is_a_fixed_contact():
    """Against the integrator of contacts that stay where they are, with the same slip."""
    problem = sliding(0.04 * A, cells=24)
    assert positions(problem)[0] == [0.0]
    cycles = 2e4
    *_, found = slide(problem, (cycles,))
    fixed = replace(problem, slip_model=Uniform())
    *_, expected = evolve(fixed, (cycles,))
    at = np.interp(found.geometry.x, expected.geometry.x, expected.wear[:, 0], right=0)
    assert found.wear[:, 0] == pytest.approx(at, abs=0.01 * at.max())


@pytest.mark.parametrize(
    ("fraction", "depth", "half_width"), [(0.0, 0.48, 1.93), (0.94, 0.97, 0.97)]
)
def test_debris_makes_the_scar_of_a_titanium_alloy(fraction, depth, half_width):
    """Measured by Arnaud, Baydoun and Fouvry (2021): 155 µm deep, ±1.73 mm wide at 10 µm."""
    cylinder, bodies, load = Cylinder(80e-3), ElasticBodies(119e9, 0.287), NormalLoad(1066e3)
    a = cylinder.hertz(load, bodies.composite_modulus).contact_radius
    worn_area, cycles, stroke = 2 * 0.1763e-6, 5000.0, 75e-6
    each = worn_area / (8.0 * load.load * stroke * cycles)
    problem = sliding(
        stroke,
        (each, each),
        indenter=cylinder,
        bodies=bodies,
        normal=load,
        spacing=(a / 16, a / 16),
        extent=(1.15 * a, 1.15 * a),
        debris_fraction=fraction,
    )
    *_, last = slide(problem, (cycles,))
    wear = last.wear[:, 0]
    assert wear.max() == pytest.approx(depth * 155e-6, rel=0.02)
    wide = np.interp(10e-6, wear[::-1], last.geometry.x[::-1])
    assert wide == pytest.approx(half_width * 1.73e-3, rel=0.02)


def test_debris_keeps_the_gap():
    """With all debris nothing changes; with a half, half as many cycles make the same pressure."""
    *_, none = slide(sliding(debris_fraction=1.0), (2000.0,))
    first = next(iter(slide(sliding(), (1.0,))))
    assert np.array_equal(none.pressures, first.pressures)
    volume = none.geometry.integral(none.wear)
    assert volume == pytest.approx((INDENTER + FLAT) * LOAD * 4.0 * STROKE * 2000.0, rel=1e-9)
    *_, half = slide(sliding(debris_fraction=0.5), (4000.0,), 0.002)
    *_, whole = slide(sliding(), (2000.0,), 0.002)
    assert half.opening.max() == pytest.approx(whole.opening.max(), rel=1e-4)
    assert half.wear.max() == pytest.approx(2.0 * whole.wear.max(), rel=1e-4)
