"""Rigs and line contacts from their studies to figures and reports."""

import math

import numpy as np
import pytest

from fretwear.cli.show import case_lines, comparison_lines
from fretwear.data.files import open_case, open_history, open_summary
from fretwear.data.labels import mirrored
from fretwear.data.stack import open_study
from fretwear.figures import overview
from fretwear.figures.study import study_figures
from fretwear.mechanics.contact.problem import ContactError
from fretwear.mechanics.wear.integrator import WearError
from fretwear.run.simulate import run
from fretwear.study.plan import estimate
from fretwear.study.reading import load_study

from ..studies import base, line_contact, near, run_study, steel, write_study

LINE = line_contact("6 mm", "18.5 N/mm")
LOADS = ["10 N/mm", "18.5 N/mm"]


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    content = {"base": base(**line_contact("6 mm"), accuracy="none"), "vary": {"load": LOADS}}
    made = tmp_path_factory.mktemp("line")
    study = load_study(write_study(made / "line.yaml", content))
    run_study(study, made)
    return made


@pytest.fixture
def paths(folder):
    return sorted((folder / "cases").glob("*.nc"))


@pytest.mark.slow
def test_a_dataset_has_no_y_and_its_integrals_are_per_length(paths):
    with open_case(paths[1]) as case:
        assert case.pressure.dims == ("cycle", "x")
        assert case.symmetry == "even_x"
        assert not [name for name in case.variables if str(name).endswith("half_width_y")]
        units = {name: case[name].units for name in ("wear_volume", "contact_area", "normal_load")}
        assert units == {"wear_volume": "m2", "contact_area": "m", "normal_load": "N m-1"}
        assert case.dissipated_energy.units == "J m-1"
        assert case["normal_load"].long_name == "normal load per length"
        whole = mirrored(case)
        assert whole.sizes["x"] == 2 * case.sizes["x"]
        carried = whole.pressure.sum("x") * float(case["cell_x"])
        assert carried.values == near(float(case["normal_load"]), rel=1e-6)
    with open_case(paths[0]) as a, open_case(paths[1]) as b, open_history(paths[0]) as history:
        assert history.wear_volume.units == "m2"
        told = "\n".join(case_lines(a, history))
        for words in ("(half of the contact)", "10 N/mm", "wear volume per length"):
            assert words in told
        assert "18.5 N/mm" in "\n".join(comparison_lines(a, b))


@pytest.mark.slow
def test_a_study_is_merged_and_drawn_without_maps(folder, paths):
    with open_summary(folder / "summary.nc") as summary:
        assert summary.wear_volume.units == "m2"
        drawn = {d.name: d.figure for d in study_figures(summary, folder / "cases")}
    assert drawn
    assert not [name for name in drawn if "map" in name]
    assert "per length" in drawn["wear_volume"].axes[0].get_ylabel()
    with open_study(folder) as study:
        assert study.wear_depth.dims == ("normal_load", "cycle", "x")
        deepest = study.wear_depth.max("x").values[:, -1]
    with open_case(paths[1]) as case:
        assert deepest[1] == near(float(case.wear_depth.max()), rel=1e-3)
        titles = [axes.get_title() for axes in overview(case).axes]
    assert not any("Wear depth" in title for title in titles)


def test_bare_numbers_are_forces_per_length_and_the_plan_counts_strips():
    typed = steel(**LINE)
    assert typed.replace(load=18.5e3).case_id == typed.case_id
    assert typed.case_id.startswith("cylinder-P18.5N_mm-Q7.4N_mm-")
    assert typed.coupling == 1.0
    assert typed.tangential_load == near(0.8 * 0.5 * 18.5e3)
    found = estimate(typed)
    assert found.cells_y == 1
    assert math.isfinite(found.seconds)
    assert np.isfinite(found.memory_bytes)


SLIDING = {
    **LINE,
    "tangential_ratio": None,
    "sliding_amplitude": "24.24 um",
    "wear_coefficient": ["1.9e-14 / Pa", "2.9e-14 / Pa"],
}
ENERGY = {"slow": "5e-4 mm^3/J", "fast": "1e-4 mm^3/J", "decay": "11 mm^2/W", "frequency": "10 Hz"}
FALLING = {"wear_coefficient": None, "energy_wear_coefficient": ENERGY}


@pytest.mark.parametrize("law", [{"wear_coefficient": "4.8e-14 / Pa"}, FALLING])
def test_bodies_whose_wear_is_known_together_slide_over_a_short_stroke(law):
    """Where a twentieth of the half-width bounds the stroke, both wear in one place."""
    found = run(steel(**{**SLIDING, **law, "sliding_amplitude": "1 um", "cycles": 50})).dataset
    assert "wear_depth_flat" not in found
    rate = found.wear_rate[-1] / found.pressure[-1].where(found.pressure[-1] > 0) / 4e-6
    assert float(rate.max()) == near(float(rate.min()), rel=1e-5)
    volume = float(rate.mean()) * 4e-6 * 18.5e3 * 50
    assert float(found.wear_volume[-1]) == near(volume, rel=0.02)
    known = law.get("wear_coefficient")
    assert known is None or float(rate.mean()) == near(4.8e-14, rel=1e-5)


def test_the_frequency_of_a_case_is_that_of_its_law():
    """It may be varied; slow motion has the coefficient of low power, fast motion the other."""
    short = {**FALLING, "sliding_amplitude": "1 um", "cycles": 50, "error_estimate": False}
    own = run(steel(**{**SLIDING, **short})).dataset
    law = {name: value for name, value in ENERGY.items() if name != "frequency"}
    volumes = [
        run(steel(**{**SLIDING, **short, "energy_wear_coefficient": law, "frequency": f})).dataset
        for f in ("10 Hz", "1e-6 Hz", "1e6 Hz")
    ]
    same, slow, fast = (float(each["wear_volume"][-1]) for each in volumes)
    assert same == float(own["wear_volume"][-1])
    assert slow == near(5.0 * fast, rel=2e-3)
    assert fast < same < slow
    assert float(volumes[1]["frequency"]) == 1e-6


@pytest.mark.slow
def test_a_stroke_leaves_the_wear_of_each_body_and_a_rectangular_loop():
    result = run(steel(**SLIDING))
    last = result.dataset.isel(cycle=-1)
    total = float(last.wear_volume)
    assert total == near(4.8e-14 * 18.5e3 * 4 * 24.24e-6 * 1000)
    assert float(last.wear_volume_flat) == near(2.9 / 4.8 * total)
    for body in ("indenter", "flat"):
        area = 2.0 * float(last[f"wear_depth_{body}"].sum() * last.cell_x)
        assert area == near(float(last[f"wear_volume_{body}"]), rel=1e-6)
    both = last.wear_depth_indenter + last.wear_depth_flat
    assert both.values == near(last.wear_depth.values, rel=1e-5)
    assert result.dataset.wear_volume_flat.units == "m2"
    loop = result.loops.isel(cycle=-1)
    assert loop.force.units == "N m-1"
    energy = np.trapezoid(loop.force, loop.displacement)
    assert energy == near(float(last.dissipated_energy), rel=1e-9)
    assert float(last.regime) == 1.0


@pytest.mark.slow
@pytest.mark.parametrize("smooth", [{}, LINE], ids=["sphere", "cylinder"])
def test_the_loop_of_the_simple_slip_model_is_that_of_the_unworn_contact(smooth):
    """Its slip is, whatever has worn: the loop keeps the area of the closed form, and B is 0.68."""
    alike = {**smooth, "tangential_ratio": 0.65, "cycles": 1000, "error_estimate": False}
    case = steel(**alike, slip_model="cattaneo_mindlin")
    found = run(case)
    hertz = case.hertz
    slides = case.indenter.partial_slip(hertz, 0.5, case.tangential_load, case.coupling)
    ends, middle = (hertz.with_load(part * hertz.load).approach for part in (0.35, 0.675))
    largest = 0.5 * case.coupling * (hertz.approach - ends)
    opening = 0.5 * case.coupling * (2.0 * middle - hertz.approach - ends)
    for loop in (found.loops.isel(cycle=each) for each in (0, -1)):
        energy = np.trapezoid(loop.force, loop.displacement)
        assert energy == near(slides.dissipated_energy, rel=1e-9)
        assert float(loop.force.max()) == near(case.tangential_load, rel=1e-12)
        assert float(loop.displacement.max()) == near(largest, rel=1e-9)
    moved = found.dataset.tangential_displacement.values
    assert moved == near(np.full(moved.shape, largest), rel=1e-9)
    criterion = slides.dissipated_energy / (4.0 * opening * case.tangential_load)
    assert criterion == pytest.approx(0.675, abs=0.003)
    worn = run(steel(**alike, slip_model="jaeger")).dataset
    # Energies of both are sums over cells.
    for each in (found.dataset, worn):
        assert float(each.sliding_criterion[0]) == near(criterion, rel=1e-3)


@pytest.mark.slow
@pytest.mark.parametrize("changes", [{}, {"plastic_limit": "500 MPa", "cycles": 1}])
def test_a_tangential_load_that_becomes_too_much_ends_the_run_with_a_remedy(changes):
    # At a held approach the normal force falls, as bodies wear or yield, until Q is µP.
    keys = {"load": None, "indentation": "2.2 um", "cycles": 1000, "error_estimate": False}
    case = steel(**{**keys, "tangential_load": "24 N", **changes})
    with pytest.raises((ContactError, WearError), match=r"µP has fallen.*give tangential_ratio"):
        run(case)
    history = run(steel(**{**keys, "tangential_ratio": 0.8, **changes})).history
    assert (np.diff(history.normal_force) < 0.0).all()
    np.testing.assert_allclose(history.tangential_force, 0.4 * history.normal_force, rtol=1e-9)


@pytest.mark.slow
def test_bodies_may_wear_by_laws_of_their_own():
    """Where a share changes, each body is known over a stroke, and only the sum in partial slip."""
    each = {"slow": ["2e-4 mm^3/J", "3e-4 mm^3/J"], "fast": ["4e-5 mm^3/J", "2e-4 mm^3/J"]}
    falls = {"wear_coefficient": None, "energy_wear_coefficient": {**ENERGY, **each}}
    power = {"value": "2e-14 / Pa", "pressure_exponent": 0.5, "reference_pressure": "100 MPa"}
    bounds = {"falls": (0.4, 4 / 24), "power": (None, None)}
    for name, law in (("falls", falls), ("power", {"wear_coefficient": [power, "2e-14 / Pa"]})):
        short = {"cycles": 400, "error_estimate": False}
        last = run(steel(**{**SLIDING, **law, **short})).dataset.isel(cycle=-1)
        share = float(last.wear_volume_indenter / last.wear_volume)
        slow, fast = bounds[name]
        assert slow is None or fast < share < slow
        whole = last.wear_volume_indenter + last.wear_volume_flat
        assert float(whole) == near(float(last.wear_volume), rel=1e-9)
        stuck = run(steel(**law, cell="8 um", **short)).dataset
        assert "wear_depth_flat" not in stuck
        assert float(stuck.wear_volume[-1]) > 0.0
