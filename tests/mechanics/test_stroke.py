"""Line contacts that slide as a whole, over strokes long and short."""

import math
from dataclasses import replace

import numpy as np
import pytest
from scipy.integrate import trapezoid
from scipy.linalg import toeplitz

from fretwear import Case, simulate
from fretwear.mechanics.contact.grid import Grid
from fretwear.mechanics.contact.strips import influence_of_cell
from fretwear.mechanics.slip.models import CattaneoMindlin, Jaeger, ReducedContact, SlipModel
from fretwear.mechanics.surfaces.laws import (
    Archard,
    EnergyWear,
    Means,
    PowerLaw,
    RimAndCore,
)
from fretwear.mechanics.surfaces.loading import SlidingAmplitude
from fretwear.mechanics.surfaces.materials import Coulomb
from fretwear.mechanics.surfaces.pressing import NormalLoad
from fretwear.mechanics.surfaces.roughness import WavyRoughness
from fretwear.mechanics.values import OverCycles
from fretwear.mechanics.wear import rubbing as wear_rubbing
from fretwear.mechanics.wear import stroke as wear_stroke
from fretwear.mechanics.wear.integrator import evolve
from fretwear.mechanics.wear.loops import loop
from fretwear.mechanics.wear.measures import Measures
from fretwear.mechanics.wear.rubbing import Rubbing, positions
from fretwear.mechanics.wear.state import Workspace
from fretwear.mechanics.wear.stroke import slide
from fretwear.run.simulate import steps
from fretwear.run.states import wear_problem
from fretwear.study.case import CaseError

from ..studies import near
from . import oracles
from .problems import (
    CYLINDER,
    CYLINDER_BODIES,
    EDGE,
    LINE,
    P0,
    PER_LENGTH,
    folded,
    fretting,
    on_strips,
    unfolded,
)

pytestmark = pytest.mark.slow

LOAD, STROKE = PER_LENGTH, 24.24e-6
INDENTER, FLAT = 1.9e-14, 2.9e-14


def sliding(stroke=STROKE, coefficients=(INDENTER, FLAT), cells=12, **changes):
    """The cylinder, sliding as a whole."""
    usual = {"loading": SlidingAmplitude(stroke), "wear_law": Archard(coefficients)}
    return on_strips(cells, **{**usual, "friction_law": Coulomb(0.9), **changes})


@pytest.fixture(scope="module")
def worn():
    """At 5000 and at 18000 cycles."""
    stops = (5000.0, 18000.0)
    return {each.cycle: each for each in slide(sliding(), stops) if each.cycle in stops}


def test_a_scar_lies_by_two_finite_element_solutions_whatever_the_cells(worn):
    """Adaptive meshes and level sets, from LevelSetWear, differ by 0.3 to 0.6 %."""
    for cycle, found in ((5000, (1.1311, 1.1249)), (18000, (2.7130, 2.7055))):
        assert 1e6 * worn[cycle].wear_flat.max() == near(np.mean(found), rel=4e-3)
    flat, x = worn[18000].wear_flat[:, 0], worn[18000].geometry.x
    width = 2.0 * np.interp(0.01 * flat.max(), flat[::-1], x[::-1])
    assert width == pytest.approx(0.52e-3, abs=0.02e-3)
    *_, finer = slide(sliding(cells=17), (5000.0,), 0.002)
    assert finer.wear_flat.max() == near(worn[5000].wear_flat.max(), rel=2e-3)
    assert finer.wear_indenter.max() == near(worn[5000].wear_indenter.max(), rel=2e-3)


def test_each_body_loses_what_archard_says(worn):
    for cycle, state in worn.items():
        for wear, coefficient in ((state.wear_indenter, INDENTER), (state.wear_flat, FLAT)):
            volume = state.geometry.integral(wear)
            assert volume == near(coefficient * LOAD * 4.0 * STROKE * cycle, rel=1e-9)
        # No slip model has a part in it.
        for model in (Jaeger(), CattaneoMindlin()):
            found = Measures(sliding(slip_model=model), state)
            assert found.dissipated_energy == near(4.0 * 0.9 * LOAD * STROKE, rel=1e-9)
            assert found.tangential_displacement == near(STROKE, rel=1e-9)


def hold_at_each_position(problem, state, displacement, slack):
    """Whether each position carries the load and nothing penetrates, worn parts interpolated.

    A pressure acts on the flat on the way to the next positions, ever less: so the gap has the mean
    of its wear there.
    """
    nx, ny = state.geometry.shape
    half = Grid((2 * nx, ny), problem.spacing, (False, True))
    places = positions(problem)[0]
    for index, (place, pressure) in enumerate(zip(places, state.pressures, strict=True)):
        reached = [places[abs(index - 1)] * (1 if index else -1), place, *places[index + 1 :][:1]]
        way = np.linspace(reached[0], reached[-1], 401)
        shares = np.interp(way, reached, [0.0, 1.0, 0.0][: len(reached)])
        assert pressure.min() >= 0
        area = problem.spacing[0] if ny == 1 else half.unit_area
        assert area * pressure.sum() == near(problem.hertz.load, rel=1e-9)
        gap = displacement(pressure, half) + problem.indenter.gap(half.x[:, None] - place, half.y)
        for row in range(ny):
            x = half.x[:, None] + way - place
            flat = np.interp(abs(x), half.x[nx:], state.wear_flat[:, row], right=0)
            gap[:, row] += np.average(flat, axis=1, weights=shares)
            moved = abs(half.x - place)
            gap[:, row] += np.interp(moved, half.x[nx:], state.wear_indenter[:, row], right=0)
        gap -= gap[pressure > 0].mean()
        # The end of a step has worn a little more than its last stage.
        assert abs(gap[pressure > 0]).max() < slack
        assert gap.min() > -slack


def test_every_position_carries_the_load_without_penetration(worn):
    def displacement(pressure, half):
        """By a dense matrix."""
        modulus = CYLINDER_BODIES.composite_modulus
        column = influence_of_cell(len(pressure), half.spacing[0], CYLINDER.radius, modulus)
        return toeplitz(column) @ pressure

    hold_at_each_position(sliding(), worn[18000], displacement, 2e-9)


def test_pressures_of_a_worn_stroke_are_those_at_many_more_positions(monkeypatch):
    """Contacts end elsewhere at each position, which shows in the outermost cells at most."""
    cycles, count = (1000.0, 3000.0), 100
    usual = [*slide(sliding(cells=16), cycles)]
    places = np.linspace(0.0, STROKE, count + 1)
    weights = np.full(count + 1, 0.5 / count)
    weights[[0, -1]] *= 0.5
    for module in (wear_rubbing, wear_stroke):
        monkeypatch.setattr(module, "positions", lambda problem: (places, weights))
    many = {state.cycle: state for state in slide(sliding(cells=16), cycles)}
    for state in (state for state in usual if state.cycle in cycles):
        finer = many[state.cycle].pressure
        assert many[state.cycle].pressures.shape[0] == count + 1
        missed = np.abs(state.pressure - finer)[:, 0] / finer.max()
        last = np.flatnonzero(finer)[-1]
        assert missed.max() < 0.015
        assert missed[: last - 2].max() < 0.005


@pytest.mark.parametrize("ratio", [0.3, 3.0])
def test_pressures_at_the_rim_of_a_scar_are_those_of_much_shorter_steps(ratio):
    """Steps of a tenth of the cycles so far; the last cells depend on when they began to touch."""
    problem, cycles = sliding(ratio * EDGE, cells=10), 700.0 * STROKE / (ratio * EDGE)
    *_, found = slide(problem, (cycles,))
    *_, short = slide(problem, tuple(np.geomspace(cycles / 100.0, cycles, 50)), 100.0)
    missed = np.abs(found.pressure - short.pressure)[:, 0] / short.pressure.max()
    last = np.flatnonzero(short.pressure)[-1]
    assert missed.max() < 0.07
    assert missed[: last - 2].max() < 0.01
    assert np.abs(found.worn - short.worn).max() < 0.002 * short.worn.max()


def test_blocks_follow_each_other():
    """Equal blocks are one run, and each body loses the wear of all of them."""
    plain = sliding(cells=8)
    halves = replace(plain, blocks=((1000.0, plain), (math.inf, plain)))
    *_, whole = slide(plain, (1000.0, 2000.0))
    *_, found = slide(halves, (2000.0,))
    assert found.wear_flat.max() == near(whole.wear_flat.max(), rel=2e-4)
    shorter = replace(plain, loading=SlidingAmplitude(0.3 * STROKE), normal=NormalLoad(0.5 * LOAD))
    longer = replace(plain, loading=SlidingAmplitude(4 * STROKE))
    problem = replace(plain, blocks=((1000.0, plain), (1500.0, shorter), (math.inf, longer)))
    path = 4 * STROKE * LOAD * (1000 + 0.3 * 0.5 * 500 + 4 * 500)
    states = {state.cycle: state for state in slide(problem, (1200.0, 2000.0))}
    last = states[2000.0]
    assert last.geometry.integral(last.wear_flat) == near(FLAT * path, rel=1e-9)
    assert last.load == LOAD
    *_, resumed = slide(problem, (1200.0, 2000.0), start=states[1000.0])
    assert np.array_equal(resumed.wear_flat, last.wear_flat)


def test_friction_that_changes_takes_wear_by_energy_along_and_debris_keeps_the_gap():
    """K = αµ, and µ rises linearly from 0.5 to 1 over the first half of the run."""
    friction = Coulomb(OverCycles((0.0, 1000.0), (0.5, 1.0)))
    problem = sliding(wear_law=EnergyWear((INDENTER, FLAT)), friction_law=friction)
    *_, last = slide(problem, (2000.0,))
    expected = FLAT * LOAD * 4 * STROKE * (0.75 * 1000 + 1000)
    assert last.geometry.integral(last.wear_flat) == near(expected, rel=1e-4)
    # With all debris nothing changes; with a half, half as many cycles make the same pressure.
    *_, none = slide(sliding(debris_fraction=1.0), (2000.0,))
    first = next(iter(slide(sliding(), (1.0,))))
    assert np.array_equal(none.pressures, first.pressures)
    volume = none.geometry.integral(none.wear)
    assert volume == near((INDENTER + FLAT) * LOAD * 4.0 * STROKE * 2000.0, rel=1e-9)
    *_, half = slide(sliding(debris_fraction=0.5), (4000.0,), 0.002)
    *_, whole = slide(sliding(), (2000.0,), 0.002)
    assert half.opening.max() == near(whole.opening.max(), rel=1e-4)
    assert half.wear.max() == near(2.0 * whole.wear.max(), rel=1e-4)


def test_what_is_pressed_beyond_the_limit_yields_at_once():
    """Both bodies sink until no position needs more than the limit; then wear goes on."""
    problem = sliding(limit=0.7 * LINE.peak_pressure / P0)
    first, *_, last = slide(problem, (200.0,))
    assert first.pressures.max() == near(problem.plastic_limit, rel=1e-12)
    assert first.plastic.max() > 0
    assert np.array_equal(first.plastic, first.sunk.sum(axis=0))
    # Alike in the first pass over the stroke, and hardly more of either in the next ones.
    assert first.sunk[0].max() == near(first.sunk[1].max(), rel=2e-3)
    for pressure in first.pressures:
        assert problem.spacing[0] * pressure.sum() == near(LOAD)
    assert last.geometry.integral(last.wear_flat) == near(FLAT * LOAD * 4 * STROKE * 200, rel=1e-9)
    assert last.pressures.max() < problem.plastic_limit * (1 + 1e-9)
    assert last.plastic.max() < 2 * first.plastic.max()


class Uniform(SlipModel):
    """The same slip everywhere: a contact that does not see its bodies move."""

    def reduced(self, problem, pressed, start=None):
        del start
        shape = pressed.shape
        gap = problem.loading.stroke / (problem.friction_law.coefficient * problem.coupling)
        return ReducedContact(np.zeros_like(shape), np.full_like(shape, gap), 0.0, 0.0)


def rubbing(stroke, coefficients=(1e-14, 1e-14), cells=8, **changes):
    """A sphere that slides as a whole; the stroke in contact radii."""
    a = fretting().hertz.contact_radius
    loading, law = SlidingAmplitude(stroke * a), Archard(coefficients)
    return fretting(cells, loading=loading, wear_law=law, **changes)


def test_a_short_stroke_is_a_fixed_contact():
    """Against the integrator of contacts that stay where they are, with the same slip."""
    problem = rubbing(0.04, 2e-14)
    assert positions(problem)[0] == [0.0]
    hertz = problem.hertz
    cycles = 3.0 / (problem.wear_growth * hertz.peak_pressure)
    cycles *= problem.friction_law.coefficient * hertz.approach / problem.loading.stroke
    *_, found = slide(problem, (cycles,), 0.003)
    fixed = replace(problem, slip_model=Uniform())
    *_, expected = evolve(fixed, (cycles,), 0.003)
    plane = found.geometry
    depth = np.interp(plane.x, expected.geometry.x, expected.wear[:, 0], right=0)
    assert found.wear[:, 0] == pytest.approx(depth, abs=0.01 * depth.max())
    assert plane.integral(found.wear) == near(expected.geometry.integral(expected.wear), rel=1e-4)


def test_a_sphere_slides_over_a_stroke():
    """Archard's volumes, equal shares of bodies alike and never a penetration."""
    problem, unequal = rubbing(1.0), rubbing(1.0, (3e-14, 1e-14))
    assert 2 * positions(problem)[0].size - 1 >= 8
    cycles = 300.0
    *_, last = slide(problem, (cycles,))
    *_, uneven = slide(unequal, (cycles,))
    path = 4 * problem.loading.stroke * problem.hertz.load * cycles
    for state, shares in ((last, (1e-14, 1e-14)), (uneven, (3e-14, 1e-14))):
        for wear, share in zip((state.wear_indenter, state.wear_flat), shares, strict=True):
            assert state.geometry.integral(wear) == near(share * path, rel=1e-9)
    # The flat wears over the stroke as well; the indenter where it touches all the time.
    assert last.wear_indenter.max() > 1.2 * last.wear_flat.max()

    def displacement(pressure, half):
        whole = unfolded(pressure, half.even)
        moved = oracles.displacement(whole, half.spacing, problem.bodies.composite_modulus)
        return folded(moved, half.even)

    hold_at_each_position(problem, last, displacement, 2e-3 * last.wear.max())


def test_a_power_law_over_a_stroke_wears_by_its_factors():
    """Each body by its own exponents; exponents of zero leave the constant."""
    flat = PowerLaw(
        FLAT,
        pressure_exponent=0.6,
        reference_pressure=100e6,
        sliding_exponent=0.7,
        reference_sliding=100e-6,
        frequency_exponent=-0.3,
        reference_frequency=1.0,
    )
    law = Archard((PowerLaw(INDENTER), flat))
    problem = sliding(wear_law=law, frequency=5.0)
    run, usual = (list(slide(problem, (1500.0,), tolerance)) for tolerance in (3e-4, 0.01))
    path = 4.0 * STROKE * LOAD
    rates, cycles, volumes = [], [], []
    for state in run:
        width = trapezoid((state.pressures > 0).sum(axis=1)[:, 0]) * EDGE / 12
        width /= len(state.pressures) - 1
        factor = (LOAD / width / 100e6) ** 0.6 * (STROKE / 100e-6) ** 0.7 * 5.0**-0.3
        rates.append(FLAT * factor * path)
        cycles.append(state.cycle)
        volumes.append(state.geometry.integral(state.wear_flat))
        indenter = state.geometry.integral(state.wear_indenter)
        assert indenter == pytest.approx(INDENTER * path * state.cycle, rel=0.01, abs=1e-20)
    assert rates[-1] < 0.93 * rates[0]
    assert volumes[-1] == near(trapezoid(rates, cycles), rel=0.01)
    # The mean pressure, which lags by a stage, is extrapolated to the end of a step.
    geometry, wear = usual[-1].geometry, usual[-1].wear_flat
    assert geometry.integral(wear) == near(volumes[-1], rel=0.003)


def oxidised(core=(0.6e-14, 1.2e-14), width=0.5 * EDGE, stroke=5e-6, **changes):
    """A rim and a core, both bodies by ratios of their own."""
    law = EnergyWear(RimAndCore((4e-14, 6e-14), core, width))
    return sliding(stroke, wear_law=law, **changes)


def test_a_rim_wears_faster_than_the_core_as_in_explicit_small_steps():
    """Euler's method on contacts of given shapes; debris keeps the load on the rim: a W."""
    problem, cycles, steps = oxidised(debris_fraction=0.9), 2000.0, 150
    *_, last = slide(problem, (cycles,), 1e-3)
    places, x, h = Rubbing(problem, last.geometry.shape), last.geometry.x, problem.spacing[0]
    wear, start = np.zeros((2, x.size, 1)), last.pressures
    for _ in range(steps):
        start, means, _ = places.solve(0.1 * wear, np.zeros((2, 1, 1)), start)
        inside = places.half_widths(start)[0] - 0.5 * EDGE - x
        core = np.clip(0.5 + inside / h, 0.0, 1.0)[:, None]
        for body, fast, slow in ((0, 6e-14, 1.2e-14), (1, 4e-14, 0.6e-14)):
            coefficient = 0.9 * (fast + (slow - fast) * core)
            wear[body] += cycles / steps * 4.0 * 5e-6 * coefficient * means[body]
    assert np.abs(last.worn - wear).sum() <= 0.005 * wear.sum()
    assert last.wear_flat.max() > 1.5 * last.wear_flat[0, 0]
    assert x[last.wear_flat.argmax()] == pytest.approx(inside[0] + x[0], abs=0.2 * EDGE)


def test_rim_and_core_end_in_the_constant_laws():
    *_, same = slide(oxidised((4e-14, 6e-14)), (500.0,))
    *_, plain = slide(sliding(5e-6, wear_law=EnergyWear((4e-14, 6e-14))), (500.0,))
    assert np.array_equal(same.worn, plain.worn)
    *_, all_rim = slide(oxidised(width=20 * EDGE), (500.0,))
    assert all_rim.worn.sum() == near(plain.worn.sum(), rel=1e-3)
    # A contact that hardly moves is all core but for half a cell at its edge.
    *_, no_rim = slide(oxidised(width=1e-3 * EDGE, stroke=1e-7), (500.0,))
    *_, core = slide(sliding(1e-7, wear_law=EnergyWear((0.6e-14, 1.2e-14))), (500.0,))
    assert no_rim.worn.sum() == near(core.worn.sum(), rel=0.05)
    law = RimAndCore(4e-14, 1e-14, EDGE, width_exponent=-0.7, reference_frequency=1.0)
    assert law.zones(Means(half_width_x=EDGE), 5.0).width == near(EDGE * 5.0**-0.7)


def test_a_distance_wears_a_block_on_a_ring_as_many_short_strokes_do():
    """Block of Cruzado et al. (2010): in the end a segment of the circle, of the area K P L."""
    keys = {
        "indenter": {"kind": "cylinder", "radius": "20 mm"},
        "load": "10.8333 N/mm",
        "youngs_modulus": "210 GPa",
        "poisson_ratio": 0.3,
        "friction": 0.65,
        "wear_coefficient": [0, "2e-15 / Pa"],
        "cell": "6 um",
    }
    case = Case(**keys, sliding_distance="3600 m", output_cycles=[250])
    assert case.cycles == 1000
    strokes = Case(**keys, sliding_amplitude="2 um", cycles=450_000_000)
    states = {step.state.cycle: step.state for step in steps(case)}
    *_, short = steps(strokes)
    depth = states[1000].wear_flat[0, 0]
    assert short.state.wear_flat[0, 0] == near(depth, rel=2e-3)
    # Finite elements: 43.707 µm after 3600 m.
    assert depth == near(43.707e-6, rel=0.01)
    for cycle in (250, 1000):
        area = states[cycle].geometry.integral(states[cycle].wear)
        assert area == near(2e-15 * 10833.3 * 3.6 * cycle, rel=0.003)
    assert not states[1000].wear_indenter.any()


def test_waves_of_the_flat_are_worn_off_over_a_stroke():
    """In the end the smooth scar and the waves are left."""
    waves = WavyRoughness(0.1e-6, math.radians(1.0), 0.0)
    width = 4 * waves.amplitude / math.tan(waves.slope_x)
    fine = {"spacing": (width / 16, width / 16)}
    *_, smooth = slide(sliding(**fine), (2000.0,))
    rough = sliding(roughness=waves, **fine)
    first, *_, last = slide(rough, (2000.0,))
    assert first.pressure.max() > 2 * smooth.pressure.max()
    path = 4.0 * STROKE * LOAD * 2000.0
    assert last.geometry.integral(last.wear) == near((INDENTER + FLAT) * path, rel=1e-9)
    # The flat loses its waves where it wears, and they lie about the smooth scar.
    x = last.geometry.x
    inside = x < 0.6 * x[smooth.wear_flat[:, 0] > 0].max()
    height = waves.height(x, 0.0) + waves.amplitude
    flat = np.interp(x, smooth.geometry.x, smooth.wear_flat[:, 0])
    left = last.wear_flat[:, 0] + height - flat
    assert np.ptp(left[inside]) < 0.25 * np.ptp(height)


def test_a_stroke_below_a_twentieth_of_a_punch_is_not_small_beside_its_sharp_edge():
    """The peak of pressure at the edge is always on the same part of the indenter."""
    punch = {"kind": "flat_punch", "flat_half_width": "1 mm", "edge_radius": "2 mm"}
    keys = {
        "indenter": punch, "load": "200 N/mm", "youngs_modulus": "208 GPa", "poisson_ratio": 0.3,
        "friction": 0.5, "cycles": 100, "cell": "6 um",
    }  # fmt: skip
    pair = {"wear_coefficient": ["1.5e-14 / Pa", "1.5e-14 / Pa"]}
    case = Case(**keys, **pair, sliding_amplitude="40 um")
    assert case.indenter.edge(case.hertz) < case.loading.stroke < 0.05 * case.hertz_radius
    *_, last = slide(wear_problem(case), (100.0,))
    # What cells of 2.9 µm give; were the bodies not seen to move, each would lose 82.5 nm.
    assert last.wear_indenter.max() == near(95.0e-9, rel=0.02)
    assert last.wear_flat.max() == near(59.4e-9, rel=0.02)
    # If the share of each body is unknown, only a stroke that is small beside the edge can be run.
    both = {"wear_coefficient": "3e-14 / Pa"}
    with pytest.raises(CaseError, match=r"each wears in a different place"):
        Case(**keys, **both, sliding_amplitude="5 um")
    assert positions(wear_problem(Case(**keys, **both, sliding_amplitude="1 um")))[0] == [0.0]


def ended(kind, **changes):
    """A punch of half-width 2.1 mm whose flat ends at 2 mm."""
    flat = "flat_radius" if kind == "round_punch" else "flat_half_width"
    punch = {"kind": kind, flat: "2 mm", "edge_radius": "0.4 mm", "half_width": "2.1 mm"}
    keys = {
        "indenter": punch, "load": "400 N/mm", "youngs_modulus": "210 GPa", "poisson_ratio": 0.3,
        "friction": 0.7, "wear_coefficient": ["1e-13 / Pa", "1e-13 / Pa"], "cycles": 20000,
        "error_estimate": False,
    }  # fmt: skip
    return Case(**{**keys, **changes})


def test_no_contact_becomes_wider_than_a_punch_that_ends():
    """Worn all over, it carries the mean pressure of its whole face."""
    end = 2.1e-3
    face = math.pi * end**2 / 1000.0
    case = ended("round_punch", displacement_amplitude="50 um", load="1000 N", cell="30 um")
    problem = wear_problem(case)
    first, *_, last = evolve(problem, [20000.0])
    assert Measures(problem, first).contact_half_width_x < 2.02e-3
    found = Measures(problem, last)
    assert found.contact_half_width_x == near(end, rel=1e-3)
    assert found.peak_pressure * face == near(1.0, rel=0.03)
    assert last.pressure.max() < 1.05 * found.central_pressure
    assert last.geometry.edges[int(np.flatnonzero(last.pressure).max())] < end


def test_beyond_its_end_a_punch_has_neither_gap_nor_slip_over_a_stroke():
    case = ended("flat_punch", sliding_amplitude="0.4 mm", cell="100 um", cycles=12000)
    assert case.grid_spacing[0] == 100e-6
    dataset = simulate(case)
    last = dataset.isel(cycle=-1)
    past_end = abs(dataset.x) > 2.1e-3
    assert np.isnan(last.gap[past_end]).all()
    assert (last.slip[past_end] == 0.0).all()
    assert np.isfinite(last.gap[~past_end]).all()
    assert (last.pressure[past_end] == 0.0).all()
    assert last.contact_half_width_x <= 2.1e-3 * (1.0 + 1e-9)
    # The flat wears where the punch comes, up to half a stroke beyond its end.
    # Its wear is interpolated between cells.
    assert (last.wear_depth_indenter[abs(dataset.x) > 2.2e-3] == 0.0).all()
    worn = dataset.x[last.wear_depth_flat > 0.0].max()
    assert worn == pytest.approx(2.5e-3, abs=110e-6)


def test_a_punch_must_hold_its_flat():
    message = r"ends at 1 mm, on its flat to 2 mm\n.*half_width: 2.4 mm"
    short = {"kind": "flat_punch", "flat_half_width": "2 mm", "edge_radius": "0.4 mm"}
    with pytest.raises(CaseError, match=message):
        ended("flat_punch", sliding_amplitude="50 um", indenter={**short, "half_width": "1 mm"})


@pytest.mark.parametrize(("ball", "ratio"), [(False, 0.3), (True, 0.0)])
def test_a_load_in_phase_with_a_stroke_wears_as_in_explicit_small_steps(ball, ratio):
    """Contacts of given shapes at many positions; at a ratio of zero they open at one end."""
    if ball:
        problem = rubbing(0.7, (1e-14, 3e-14), 6, normal=NormalLoad(50.0, ratio))
        cycles, steps_, places = 200.0, 60, 16
    else:
        problem = sliding(cells=8, normal=NormalLoad(LOAD, ratio))
        cycles, steps_, places = 3000.0, 120, 24
    *_, last = slide(problem, (cycles,))
    window, modulus = last.geometry, problem.composite_modulus
    x, y = (axis.ravel() for axis in np.meshgrid(window.x, window.y, indexing="ij"))
    if ball:
        one, image = (
            oracles.love(x[:, None] - x, y[:, None] - side * y, problem.spacing, modulus)
            for side in (1, -1)
        )
        influence = one + image
    else:
        column = influence_of_cell(x.size, problem.spacing[0], CYLINDER.radius, modulus)
        influence = toeplitz(column)
    worn = oracles.explicit_strokes(problem, window, influence, cycles, steps_, places)
    for found, expected in zip(last.worn, worn, strict=True):
        assert np.abs(found - expected).sum() <= 0.01 * expected.sum()
        assert found.max() == near(expected.max(), rel=0.01)
    # The flat wears more where the load is large, the indenter on its other side.
    right = [field[window.x > 0].sum() / field.sum() for field in last.worn]
    assert right[0] > 0.51
    assert right[1] < 0.495


def test_a_contact_that_opens_once_a_cycle_dissipates_by_its_mean_load():
    problem, cycles = rubbing(0.5), 0.05 / rubbing(0.5).loading.stroke / 50.0
    opening = replace(problem, normal=replace(problem.normal, pulsating_load=0.0))
    *_, last = slide(opening, (cycles,))
    curve, found = loop(Workspace(opening), last), Measures(opening, last)
    # The loop has the area of the energy, and no force where the contact opens.
    assert found.dissipated_energy == near(2 * 0.5 * 50.0 * opening.loading.stroke, rel=1e-9)
    area = abs(trapezoid(curve.force, curve.displacement))
    assert area == near(found.dissipated_energy, rel=1e-9)
    assert curve.force.max() == near(0.5 * 50.0)
    assert abs(curve.force[curve.displacement.argmin()]) < 1e-9
