"""What a case costs, the cells that it gets by default, and what makes its results doubtful."""

import math

import numpy as np
import pytest

from fretwear.mechanics.contact.grid import Grid
from fretwear.mechanics.contact.rings import Rings
from fretwear.mechanics.surfaces.indenters import Sphere
from fretwear.mechanics.wear.integrator import evolve, first_loading
from fretwear.mechanics.wear.measures import Measures
from fretwear.mechanics.wear.window import first_cells
from fretwear.run.simulate import ResultWarning, simulate, steps
from fretwear.run.states import wear_problem
from fretwear.study.case import CaseError
from fretwear.study.case_warnings import CaseWarning, case_warnings, study_warnings
from fretwear.study.memory import affordable_width, memory_of
from fretwear.study.plan import estimate
from fretwear.theory import HertzContact, LimitingState, LineContact, PartialSlip

from .. import studies
from ..studies import WAVES, near

SHALLOW = {"amplitude": 2e-7, "slope_x": 0.035, "slope_y": 0.017}
LINE = studies.line_contact("10 mm", "300 N/mm")


def steel(**changes):
    """A case whose slip is alike in all directions, so that smooth spheres are on rings."""
    return studies.steel(**{"slip_model": "jaeger", **changes})


def test_contact_reaches_out_with_wear_plastic_flow_and_roughness():
    smooth, soft = steel(), steel(plastic_limit=50e6)
    assert soft.cells.greatest_contact_radius == near(math.sqrt(50 / (math.pi * 50e6)))
    rough = steel(roughness={"amplitude": 2e-7, "slope_x": 0.1, "slope_y": 0.02})
    smallest = smooth.cells.greatest_contact_radius
    assert rough.cells.greatest_contact_radius > smallest > smooth.hertz_radius
    short, long = (steel(cycles=cycles).cells.greatest_contact_radius for cycles in (10, 10**6))
    assert short == near(smooth.hertz_radius, rel=0.01)
    limiting = LimitingState(HertzContact(1.0, 4 / 3, 1.0), 0.8)
    assert long == near(limiting.contact_radius * smooth.hertz_radius, rel=1e-6)
    worn, yielding = steel(cycles=30000), steel(cycles=30000, plastic_limit=4.5e9)
    assert yielding.cells.greatest_contact_radius > 1.5 * worn.cells.greatest_contact_radius
    held = yielding.replace(slip_model="cattaneo_mindlin")
    assert held.cells.greatest_contact_radius == worn.cells.greatest_contact_radius
    assert estimate(held).steps < 0.2 * estimate(yielding).steps


@pytest.mark.parametrize("keys", [{}, {"plastic_limit": "4500 MPa"}, LINE], ids=str)
def test_a_finer_cell_narrows_rings_and_strips_in_proportion_and_a_wider_one_does_not(keys):
    case = steel(**keys)
    counts = []
    for part in (1.0, 0.5, 3.0):
        each = case.replace(cell=[part * width for width in case.grid_spacing])
        problem = wear_problem(each)
        counts.append(len(first_cells(problem).edges))
    problem = wear_problem(case)
    assert first_cells(problem).shape[0] + 1 == counts[0] == counts[2]
    # A finer cell counts from the exact default, which is written rounded down to two digits.
    half = case.replace(cell=[0.5 * width for width in case.grid_spacing]).coarseness
    assert 0.45 < half <= 0.5
    assert counts[1] / counts[0] == near(1.0 / half, rel=0.02)


def test_cells_snapshots_cycles_and_tolerance_cost_what_they_take():
    coarse, fine = (estimate(steel(cell=cell, roughness=SHALLOW)) for cell in (2e-6, 1e-6))
    assert fine.cells == near(4 * coarse.cells, rel=0.02)
    # A stroke has a full matrix of the cells that touch, four times as many, and its factors.
    stroke = {"tangential_ratio": None, "sliding_amplitude": 25e-6, "wear_coefficient": [4e-13] * 2}
    coarse, fine = (estimate(steel(**stroke, cell=cell)) for cell in (4e-6, 2e-6))
    assert fine.memory_bytes / coarse.memory_bytes == near(4**2, rel=0.01)
    assert fine.seconds / coarse.seconds == near(4**3, rel=0.01)
    few, many = (estimate(steel(output_cycles=asked)) for asked in ((), range(0, 1000, 100)))
    assert few.seconds < many.seconds < 1.3 * few.seconds
    assert estimate(steel(cell=1e-9)).memory_bytes > 1e12
    less, more = (estimate(steel(tangential_ratio=ratio)) for ratio in (0.2, 0.8))
    assert less.steps == near(0.5 * more.steps)
    tight, usual = (estimate(steel(tolerance=t)) for t in (1e-3, 1e-2))
    assert tight.steps > 1.5 * usual.steps


@pytest.mark.slow
@pytest.mark.parametrize(
    "changes",
    [
        {"cycles": 7000},
        {"cycles": 7000, "plastic_limit": 4.5e9},
        {"cycles": 7000, "roughness": SHALLOW, "cell": 2e-6},
        {"cycles": 1000, "roughness": SHALLOW, "plastic_limit": 4.5e9, "cell": 2e-6},
        {"cycles": 7000, "plastic_limit": 4.5e9, "slip_model": "cattaneo_mindlin", "cell": 3e-6},
    ],
)
def test_the_steps_and_cells_of_a_run_are_about_those_expected(changes):
    case = steel(**changes)
    *others, last = steps(case)
    expected = estimate(case)
    assert expected.steps == near(len(others), rel=0.3)
    cells = last.state.geometry.plane(case.grid_spacing).shape
    assert 0.5 < expected.cells / math.prod(cells) < 2.0


def test_a_slip_annulus_much_narrower_than_a_written_cell_dissipates_as_mindlin_says():
    case = steel(tangential_ratio=1e-4, cycles=10, cell="4 um", error_estimate=False)
    found = simulate(case, quarter=True)
    theory = PartialSlip(case.hertz, case.friction, case.tangential_load, case.coupling)
    np.testing.assert_allclose(found.dissipated_energy, theory.dissipated_energy, rtol=3e-3)


@pytest.mark.slow
@pytest.mark.parametrize("limit", [math.inf, 4.5e9])
@pytest.mark.parametrize("slopes", [(0.1, 0.02), (0.05, 0.05)])
def test_the_tip_in_the_middle_touches_as_wide_as_hertz_says_of_its_share(slopes, limit):
    """The middle is a valley; the tip nearest to it carries nearly as much."""
    waves = {"amplitude": 2e-7, "slope_x": slopes[0], "slope_y": slopes[1]}
    case = steel(roughness=waves, plastic_limit=limit)
    state = first_loading(wear_problem(case))
    window, rough = state.geometry, case.roughness
    row = int(np.argmin(abs(window.y)))
    on_tip = abs(window.x - rough.finest[0] / 2) < rough.finest[0] / 4
    width = np.count_nonzero(state.pressure[on_tip, row]) * window.spacing[0]
    expected = case.cells.zones_of_tip["contact of a tip"][0][0]
    assert width == near(expected, rel=0.15)


@pytest.mark.parametrize("slope", [0.05, 0.2])
def test_a_tip_as_far_from_the_next_as_the_contact_is_wide_carries_the_whole_load(slope):
    case = steel(roughness={"amplitude": 2e-5, "slope_x": slope, "slope_y": slope})
    radius = 1.0 / (case.rough.tip.curvature_x + 1.0 / case.indenter.curvature_radius)
    tip = HertzContact(radius, case.hertz.load, case.composite_modulus)
    width = case.cells.zones_of_tip["contact of a tip"][0]
    assert width == near((2.0 * tip.contact_radius,) * 2)
    line = steel(**WAVY_CYLINDER, roughness={"amplitude": 2e-5, "slope_x": slope, "slope_y": 0.0})
    radius = 1.0 / (line.rough.tip.curvature_x + 1.0 / line.indenter.curvature_radius)
    ridge = LineContact(radius, line.hertz.load, line.composite_modulus)
    (width, _), _ = line.cells.zones_of_tip["contact of a tip"]
    assert width == near(2.0 * ridge.contact_radius)


@pytest.mark.parametrize("ratio", [0.3, 0.8])
def test_the_band_of_a_tip_that_yields_is_within_its_annulus_of_slip(ratio):
    """Soft tips yield on all of it, hard ones on a small part."""
    slipping = 1.0 - (1.0 - ratio) ** (1 / 6)
    shares = []
    for limit in (2e9, 9e9):
        case = steel(roughness=WAVES, plastic_limit=limit, tangential_ratio=ratio)
        zones = case.cells.zones_of_tip
        (band, _), (widths, _) = zones["band that yields"], zones["contact of a tip"]
        along_x, along_y = (part / (0.5 * whole) for part, whole in zip(band, widths, strict=True))
        assert along_x == near(along_y)
        shares.append(along_x)
    assert shares[0] == near(slipping)
    assert 0.0 < shares[1] < 0.1 * slipping


WAVY_CYLINDER = {
    **studies.line_contact("6 mm", "100 N/mm"),
    "wear_coefficient": "3e-14 / Pa",
    "cycles": 1000,
}


@pytest.mark.slow
@pytest.mark.parametrize(
    ("amplitude", "slope", "changes"),
    [
        ("0.2 um", "6 deg", {"tangential_ratio": 0.35, "plastic_limit": "4500 MPa"}),
        ("0.3 um", "3 deg", {"tangential_ratio": 0.15}),
    ],
    ids=["tips yield", "tips hardly slip"],
)
def test_ridges_of_a_wavy_cylinder_are_resolved(amplitude, slope, changes):
    """Against strips three times narrower, or that resolve the half-width 1500 times."""
    waves = {"amplitude": amplitude, "slope_x": slope, "slope_y": "0 deg"}
    case = steel(**{**WAVY_CYLINDER, **changes}, roughness=waves)
    finer = case.replace(cell=max(case.grid_spacing[0] / 3.0, case.hertz_radius / 1500.0))
    problems = [wear_problem(each) for each in (case, finer)]
    found, right = (Measures(each, [*evolve(each, (1000.0,))][-1]) for each in problems)
    names = ["contact_area", "stick_area", "wear_volume", "maximum_wear_depth", "plastic_volume"]
    for name in names:
        assert getattr(found, name) == near(getattr(right, name), rel=0.03), name


LONG = {"amplitude": 1e-7, "slope_x": 1e-3, "slope_y": 1e-3}


def test_the_ring_is_as_wide_as_the_limiting_state_says_from_all_of_the_stick_zone_to_nothing():
    soft, hard, elastic = (steel(plastic_limit=limit) for limit in (0.5e9, 4.5e9, math.inf))
    assert hard.cells.yielding_ring == LimitingState(hard.hertz, 0.8).width_above(4.5e9) > 0.0
    assert soft.cells.yielding_ring == soft.stick_radius
    assert elastic.cells.yielding_ring == 0.0
    assert not case_warnings(elastic)


@pytest.mark.parametrize(
    ("changes", "on_rings"),
    [
        ({"cycles": 30000}, False),
        ({"plastic_limit": "3000 MPa"}, False),
        ({"plastic_limit": "3000 MPa", "cycles": 30000}, True),
        ({"plastic_limit": "6000 MPa", "tangential_ratio": 0.5}, False),
        ({"plastic_limit": "6000 MPa", "tangential_ratio": 0.5, "cycles": 20000}, True),
        ({"tangential_ratio": 0.99999}, True),
        ({"pulsating_load": 0.9}, True),
    ],
    ids=str,
)
def test_rings_carry_a_default_contact_only_where_a_grid_would_miss_its_edges(changes, on_rings):
    case = studies.steel(**changes)
    assert issubclass(case.cells.geometry, Rings) == on_rings
    assert any("on rings" in warning.what for warning in case_warnings(case)) == on_rings


@pytest.mark.parametrize(
    "changes",
    [
        {"tangential_ratio": 0.1},
        {"tangential_ratio": 0.99999},
        {"plastic_limit": "3000 MPa", "cycles": 30000},
        {"tangential_ratio": None, "displacement_ratio": 1.2},
    ],
    ids=str,
)
def test_a_slip_model_that_is_written_is_solved(changes):
    by_default, written = (
        studies.steel(**changes, **model) for model in ({}, {"slip_model": "cerruti"})
    )
    assert (by_default.cells.geometry, written.cells.geometry) == (Rings, Grid)
    solved = (by_default.cells.solved_slip_model.kind, written.cells.solved_slip_model.kind)
    assert solved == ("jaeger", "cerruti")
    for case, kind in zip((by_default, written), solved, strict=True):
        assert case.scalar_coordinates()["slip_model"][0] == kind
    assert by_default.case_id != written.case_id
    # In gross slip it is the same everywhere, and rings leave nothing out.
    slides = by_default.tangential_ratio >= 1.0
    told = ["write slip_model: cerruti" in str(each) for each in case_warnings(by_default)]
    assert told == [True] * (not slides)


def test_a_pulsating_load_refuses_a_slip_model_along_x():
    with pytest.raises(CaseError, match="with slip_model: jaeger"):
        studies.steel(pulsating_load=0.9, slip_model="cerruti")
    assert studies.steel(pulsating_load=0.9, slip_model="jaeger").cells.geometry is Rings


@pytest.mark.slow
@pytest.mark.filterwarnings("ignore:.*on rings")
def test_the_error_of_the_depth_holds_the_direction_that_rings_leave_out():
    """Against a grid, on which the edge of stick has not yielded yet."""
    changes = {"tangential_ratio": 0.5, "output_cycles": (0, 300), "cycles": 300}
    right = simulate(studies.steel(**changes, error_estimate=False, cell="3 um"))
    rings = simulate(
        studies.steel(**changes, pulsating_load=0.999999, cell="3 um", accuracy="none")
    )
    depth, error = (
        float(rings[name][-1]) for name in ("maximum_wear_depth", "maximum_wear_depth_error")
    )
    assert 0.5 * error < float(right.maximum_wear_depth[-1]) - depth < error


@pytest.mark.slow
@pytest.mark.parametrize(("ratio", "times"), [(0.2, 3.0), (0.5, 4.0)])
def test_a_ring_that_the_grid_does_not_see_is_told_once_it_yields(ratio, times, monkeypatch):
    """Rings, which see it, tell when: up to a third later than the doubt has it."""
    capped = {"tangential_ratio": ratio, "plastic_limit": times * steel().hertz_pressure}
    fine = steel(**capped, cycles=20000, tolerance=0.002, error_estimate=False)
    yields = next(each.state.cycle for each in steps(fine) if each.measures.plastic_volume > 0.0)
    monkeypatch.setattr(Sphere, "is_axisymmetric", False)
    assert not case_warnings(steel(**capped, cycles=int(yields / 1.4)))
    (warning,) = case_warnings(steel(**capped, cycles=math.ceil(yields)))
    assert "narrower than a cell" in warning.what


@pytest.mark.parametrize(("times", "yields"), [(2.0, False), (3.6, True)])
def test_the_edge_of_stick_yields_where_wear_has_raised_its_pressure_to_the_limit(times, yields):
    capped = steel(tangential_ratio=0.5, plastic_limit=1.3 * steel().hertz_pressure)
    setup = capped.cells.setup
    edge = float(setup.hertz.pressure(setup.stick_radius))
    cycles = times * (1.0 - edge / setup.slip_limit) / (setup.wear_growth * edge)
    case = capped.replace(cycles=round(cycles), tolerance=0.1, error_estimate=False)
    *_, last = steps(case)
    assert last.state.plastic.any() == case.cells.edge_yields == yields


def test_the_narrowest_cells_take_two_gigabytes():
    case = steel(roughness=WAVES, cell="0.7 um")
    width = affordable_width(case)
    assert memory_of(case, width) <= 2 * 1024**3 < memory_of(case, width / 2**0.25)


def test_a_study_names_quantity_case_and_remedy_of_the_largest_errors_first():
    small, large = (
        CaseWarning.inaccurate(0.02, [(error, "maximum wear depth", "")], "raise `budget`")
        for error in (0.03, 0.12)
    )
    rings = CaseWarning("is computed on rings", "by up to 16 %")
    steep = CaseWarning("touches on slopes", "slope 0.4 (at most 0.3)")
    cases = {"20 N, elastic": [rings, small], "40 N, elastic": [large, rings], "": [steep]}
    assert study_warnings(cases, 27) == [
        "Maximum wear depth ± 12 % in 40 N, elastic: raise `budget`",
        "Maximum wear depth ± 3 % in 20 N, elastic: raise `budget`",
        "2 of 27 cases: the contact is computed on rings (by up to 16 %)",
        "The contact touches on slopes (slope 0.4 (at most 0.3))",
    ]
    for warning in (small, rings, steep):
        assert CaseWarning.read(str(warning)) == warning
    assert CaseWarning.read("Something else (1)") is None


def test_dundurs_constant_is_that_of_the_closed_form():
    """Steel on a rigid body: β = (1 − 2ν)/(2 (1 − ν)); alike or incompressible bodies have none."""
    rigid = {"youngs_modulus": (208e9, 208e18)}
    (warning,) = case_warnings(steel(**rigid))
    assert f"β = {(1 - 2 * 0.3) / (2 * (1 - 0.3)):.2g}:" in warning.detail
    assert not case_warnings(steel(**rigid, poisson_ratio=(0.5, 0.3)))


def test_a_simulation_warns_and_its_dataset_remembers():
    case = steel(cycles=1, cell=18e-6, roughness=LONG)
    with pytest.warns(ResultWarning, match="estimated errors exceed 5 %"):
        dataset = simulate(case)
    (told,) = dataset.attrs["warnings"].splitlines()
    assert "estimated errors exceed 5 %" in told
    fine = simulate(steel(cycles=1))
    assert fine.attrs["warnings"] == ""
