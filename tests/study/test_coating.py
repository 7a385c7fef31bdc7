"""A coating of the flat in a case: what it goes with, its place in plans, ids and files."""

import math

import numpy as np
import pytest

import fretwear
from fretwear.cli.show import case_lines
from fretwear.figures.maps import take_wear_map, wear_map
from fretwear.mechanics.contact.grid import Grid
from fretwear.mechanics.slip.models import Cerruti
from fretwear.run.simulate import run
from fretwear.study.case import Case, CaseError
from fretwear.study.plan import Plan
from fretwear.study.reading import load_study
from fretwear_cracks import StressError
from fretwear_fit.search import fit

from ..studies import base, line_contact, near, steel, two_loads, write_study

HARD = {"thickness": "15 um", "youngs_modulus": "500 GPa", "poisson_ratio": 0.2}


def test_without_a_coating_nothing_changes():
    assert steel(coating="none").case_id == steel().case_id
    assert "coating" not in "".join(steel().scalar_coordinates())
    assert math.isnan(steel().coating_pressure_ratio)


def test_a_thickness_is_also_over_the_contact_radius():
    coated = steel(coating=HARD)
    found = coated.scalar_coordinates()
    assert found["coating_thickness"][0] == near(15e-6)
    assert found["coating_ratio"][0] == near(15e-6 / coated.hertz_radius)


def test_slip_on_a_coating_has_a_direction_whatever_the_materials():
    case = steel(coating=HARD, poisson_ratio=0.0)
    assert case.cells.geometry is Grid
    assert isinstance(case.cells.solved_slip_model, Cerruti)


@pytest.mark.parametrize(
    "indenter",
    [
        {"kind": "sphere", "radius": "10 mm"},
        {"kind": "ellipsoid", "radius_x": "10 mm", "radius_y": "10.001 mm"},
    ],
)
def test_the_pressure_ratio_is_that_of_a_sphere(indenter):
    """By an independent solution on rings of an own program."""
    case = steel(radius=None, indenter=indenter)
    coating = {"thickness": case.hertz_radius, "youngs_modulus": 2 * 208e9, "poisson_ratio": 0.25}
    assert case.replace(coating=coating).coating_pressure_ratio == near(1.1641, rel=5e-4)


WORN = {**HARD, "wear_coefficient": "1e-15 / Pa"}
YIELDS = {**HARD, "plastic_limit": "12 GPa"}
CYLINDER = line_contact("6 mm", "18 N/mm")
HELD = {"tangential_ratio": None, "displacement_amplitude": "1 um"}
FOLLOWS = {"value": "1e-14 / Pa", "pressure_exponent": 0.6, "reference_pressure": "100 MPa"}
SLIDES = {"tangential_ratio": None, "sliding_amplitude": "20 um"}


@pytest.mark.parametrize(
    ("coating", "changes", "key", "rule"),
    [
        (HARD, {"slip_model": "coupled"}, "", "slip_model: coupled"),
        (HARD, {"slip_model": "cattaneo_mindlin"}, "", "slip_model: cattaneo_mindlin"),
        (HARD, {"pulsating_load": 0.9, "slip_model": "jaeger"}, "", "pulsating_load in partial"),
        (HARD, {"tangential_ratio": None, "displacement_ratio": 0.5}, None, "unknown"),
        (HARD, {**CYLINDER, **HELD, "tangential_compliance": "0.1 um/(N/mm)"}, None, "is unknown"),
        (WORN, {"wear_coefficient": FOLLOWS}, "wear_coefficient", "follows the contact"),
        (WORN, {"wear_threshold": "2 mJ/mm^2"}, "wear_coefficient", "wear_threshold"),
        (WORN, {"debris_fraction": 1.0}, "wear_coefficient", "debris_fraction: 1"),
        (YIELDS, {**SLIDES, "wear_coefficient": ["1e-14 / Pa"] * 2}, "plastic_limit", "sliding"),
        ({**HARD, "plastic_limit": "1 MPa"}, {}, "plastic_limit", "low"),
    ],
)
def test_what_a_coating_excludes_is_refused(coating, changes, key, rule):
    """By itself each is fine."""
    with pytest.raises(CaseError) as refused:
        steel(coating=coating, **changes)
    (mistake,) = refused.value.mistakes
    assert key is None or mistake.key == f"coating.{key}".rstrip(".")
    assert rule in mistake.rule
    steel(**changes)
    if coating is not HARD:
        steel(coating=HARD, **changes)


def coated_study(tmp_path, varied):
    """A study of the steel sphere on a hard coating."""
    content = two_loads(base=base(coating=HARD), vary=varied)
    return load_study(write_study(tmp_path / "study.yaml", content))


def test_a_plan_shows_how_thick_and_how_stiff_a_coating_is(tmp_path):
    plan = Plan(coated_study(tmp_path, {"coating.thickness": ["15 um", "30 um"]}))
    header, (thin, thick) = plan.header(), plan.rows()
    ratio, pressure = header.index("h/a0"), header.index("p_max/p0")
    assert float(thick[ratio]) == near(2.0 * float(thin[ratio]), rel=0.01)
    assert float(thin[pressure]) > 1.0


def test_what_varies_of_a_coating_is_not_taken_for_the_substrate(tmp_path):
    varied = {
        "coating.youngs_modulus": ["300 GPa", "400 GPa"],
        "coating.poisson_ratio": [0.1, 0.2],
        "coating.wear_coefficient": ["1e-15 / Pa", "2e-15 / Pa"],
        "coating.plastic_limit": ["10 GPa", "12 GPa"],
    }
    study = coated_study(tmp_path, varied)
    assert [*study.sizes] == [name.replace(".", "_") for name in varied]
    coordinates = next(iter(study.points())).scalar_coordinates()
    assert coordinates["youngs_modulus"][0] == near(208e9)
    assert coordinates["coating_youngs_modulus"][0] == near(300e9)


def test_stresses_below_a_coating_are_refused():
    case = steel(coating=HARD, slip_model="jaeger", cycles=1, error_estimate=False)
    with pytest.raises(StressError, match="the flat has a coating"):
        fretwear.stress(fretwear.simulate(case))


def test_show_begins_with_the_whole_coating():
    case = steel(coating=WORN, cell="16 um", cycles=1, error_estimate=False)
    dataset, history, *_ = run(case)
    lines = [line.split() for line in case_lines(dataset.assign_attrs(title=""), history)]
    rows = {" ".join(row[:-4]): row[-4:] for row in lines}
    assert rows["least thickness of the coating"] == ["15", "15", "15", "µm"]
    assert rows["area of the exposed substrate"][:3] == ["0", "0", "0"]


def test_a_coating_has_a_plastic_limit_of_its_own():
    assert steel(coating=YIELDS).plastic_limits == (near(12e9), math.inf)


@pytest.mark.slow
@pytest.mark.parametrize(("modulus", "warned"), [("1 GPa", 1), ("500 GPa", 0)])
def test_a_map_has_the_edge_of_the_exposed_substrate_and_a_warning_tells_of_thin_coatings(
    modulus, warned
):
    """The hard layer is so thin that its elasticity does not matter, worn or not."""
    thin = {"thickness": "0.1 um", "wear_coefficient": "5e-13 / Pa", "youngs_modulus": modulus}
    case = steel(coating={**HARD, **thin}, cell="16 um", cycles=1500, error_estimate=False)
    told: list[str] = []
    worn, history, *_ = run(case, warn=told.append)
    assert len([text for text in told if "wears its coating thin" in text]) == warned
    assert history["exposed_area"].values[-1] == worn.exposed_area.values[-1]
    assert (np.diff(history["coating_left"]) <= 0.0).all()
    assert float(worn.exposed_area[-1]) > 0.0
    scar = take_wear_map(worn, None)
    bare = (scar.thinned >= 1.0).sum() * float(worn.cell_x * worn.cell_y)
    assert bare == near(float(worn.exposed_area[-1]), rel=0.1)
    figure = wear_map(worn)
    assert "edge of exposed substrate" in {text.get_text() for text in figure.legends[0].texts}


def over_a_stroke(coefficient, coating):
    return steel(
        **{**CYLINDER, **SLIDES, "load": "100 N/mm"},
        wear_coefficient=[1e-16, coefficient],
        coating=coating,
        cycles=20000,
        error_estimate=False,
    )


@pytest.mark.slow
@pytest.mark.parametrize("coefficient", [None, 3e-15])
def test_a_stroke_over_equal_materials_is_that_of_the_uncoated_contact(coefficient):
    equal = {"youngs_modulus": "208 GPa", "poisson_ratio": 0.3, "wear_coefficient": coefficient}
    plain, coated = (
        fretwear.simulate(over_a_stroke(3e-15, coating), quarter=True).isel(cycle=-1)
        for coating in ("none", {"thickness": "0.5 um", **equal})
    )
    assert float(coated.worn_through_cycle) < 20000.0
    depth = plain.wear_depth_flat
    # Fields are stored in single precision.
    np.testing.assert_allclose(coated.wear_depth_flat, depth, atol=1e-7 * float(depth.max()))


@pytest.mark.slow
@pytest.mark.parametrize(("above", "below"), [(1e-15, 3e-15), (3e-15, 1e-15)])
def test_a_stroke_wears_both_materials_by_its_path(above, below):
    case = over_a_stroke(below, {**HARD, "thickness": "0.5 um", "wear_coefficient": above})
    usual, fine = (
        fretwear.simulate(case.replace(tolerance=tolerance), quarter=True).isel(cycle=-1)
        for tolerance in (0.01, 0.001)
    )
    depth, cell = usual.wear_depth_flat.values.astype(float), float(usual.cell_x)
    coated = 2.0 * cell * np.minimum(depth, 0.5e-6).sum() / above
    bare = 2.0 * cell * np.maximum(depth - 0.5e-6, 0.0).sum() / below
    path = 4.0 * case.loading.stroke * case.cycles
    assert bare > 0.1 * coated
    assert coated + bare == near(case.hertz.load * path, rel=1e-3)
    assert float(usual.worn_through_cycle) == near(float(fine.worn_through_cycle), rel=0.002)


@pytest.mark.slow
def test_a_fit_finds_the_thickness_of_a_coating_from_a_scar_that_went_through(tmp_path):
    keys = base(
        **line_contact("10 mm", "100 N/mm"),
        tangential_ratio=None,
        tangential_load="50 N/mm",
        friction=0.6,
        wear_coefficient="4e-13 / Pa",
        cycles=8000,
    )
    layer = {"youngs_modulus": "400 GPa", "poisson_ratio": 0.2, "wear_coefficient": "1e-13 / Pa"}
    thickness = 6.65e-8
    case = Case(**keys, coating={**layer, "thickness": thickness}, error_estimate=False)
    finer = case.replace(cell=case.grid_spacing[0] / 2.0, tolerance=case.tolerance / 10.0)
    worn = fretwear.simulate(finer, quarter=True).isel(cycle=-1)
    assert worn.worn_through_cycle < case.cycles
    x = np.linspace(-3.0, 3.0, 161) * float(worn.scar_half_width_x)
    depth = np.interp(np.abs(x), worn.x, worn.wear_depth, right=0.0)
    depth += np.random.default_rng(3).normal(0.0, 0.04 * depth.max(), x.size)
    rows = (f"{1e6 * place:.6g},{1e6 * each:.6g}" for place, each in zip(x, depth, strict=True))
    (tmp_path / "scar.csv").write_text("\n".join(["x (um),depth (um)", *rows]))
    study = {
        "title": "A coated scar",
        "base": {**keys, "coating": {**layer, "thickness": "0.12 um"}},
        "fit": {
            "free": {"coating.thickness": ["0.02 um", "0.3 um"]},
            "data": [{"file": "scar.csv", "quantity": "wear_depth"}],
        },
    }
    found = fit(write_study(tmp_path / "study.yaml", study), folder=tmp_path / "runs")
    low, high = found.interval("coating.thickness", 0.95)
    assert low < thickness < high < 1.2 * low
