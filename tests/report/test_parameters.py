"""The tables of parameters and of the computation say what was set and what it took."""

import json

import pytest
import xarray as xr
import yaml

from fretwear.data.files import open_case, open_history
from fretwear.report.build import build_report, parameter_rows, study_text
from fretwear.report.cases import computation_facts, examine, residuals
from fretwear.report.explorer import PROFILES
from fretwear.report.results import point_results
from fretwear.study.plan import Plan
from fretwear.study.study import load_study

from ..studies import base, run_study, write_study


def test_varied_parameters_come_first_in_units_for_people(finished):
    rows = parameter_rows(finished.plan)
    varied = [(row.name, row.values) for row in rows if row.choices]
    assert varied == [
        ("load", "20 N, 40 N"),
        ("friction", "0.2, 0.4"),
        ("roughness_amplitude", "smooth, 0.3 µm"),
        ("plastic_limit", "elastic, 3000 MPa"),
    ]
    values = {row.name: row.values for row in rows}
    assert values["radius"] == "10 mm"
    assert values["wear_coefficient"] == "7·10⁻¹³ Pa⁻¹"
    assert values["roughness_slope_x"] == "1.8°"
    assert values["tangential_load"] == "5 N"
    names = {row.name for row in parameter_rows(finished.plan)}
    case = next(iter(finished.plan.study.cases().values()))
    numerics = {"cell_x", "cell_y", "tolerance", "slip_model", "error_estimate"}
    assert set(case.scalar_coordinates()) - names == numerics


def test_values_drawn_at_random_are_shown_as_a_range(finished, tmp_path):
    text = finished.plan.study.file.read_text(encoding="utf-8")
    text = text.replace("[20 N, 40 N]", "{from: 26 N, to: 40 N}")
    text = text.replace("[0.2, 0.4]", "{from: 0.3, to: 0.4}")
    text = text.replace("[0 um, 0.3 um]", "{from: 0.3 um, to: 0.4 um}")
    text = text.replace("  plastic_limit: [none, 3000 MPa]\n", "")
    text = text.replace("base:\n", "base:\n  plastic_limit: none\n")
    text = text.replace("base:", "design: {kind: sobol, points: 64, seed: 1}\nbase:")
    file = tmp_path / "drawn.yaml"
    file.write_text(text, encoding="utf-8")
    rows = {row.name: row.values for row in parameter_rows(Plan(load_study(file)))}
    low, high = rows["load"].removesuffix(" (64 values)").split(" to ")
    assert 26.0 <= float(low.removesuffix(" N")) < 27.0
    assert 39.0 < float(high.removesuffix(" N")) <= 40.0


def test_numerics_and_residuals_are_those_of_the_files(finished):
    results = point_results(finished.plan, finished.summary, {})
    ids = [result.id for result in results if result.done]
    numerics = [examine(finished.cases / f"{case_id}.nc") for case_id in ids]
    facts = computation_facts(numerics, len(ids) + 1)
    steps, sources = [], set()
    for case_id in ids:
        with open_history(finished.cases / f"{case_id}.nc") as history:
            steps.append(history.sizes["step"] - 1)
        with open_case(finished.cases / f"{case_id}.nc") as case:
            sources.add(case.attrs["source"])
    assert facts["Accepted steps"] == f"{min(steps)} to {max(steps)}"
    assert facts["Simulated with"] == "; ".join(sources)
    assert facts["Grid spacing along x"] == "3.9 µm"
    assert facts["Cases examined"] == f"{len(ids)} of {len(ids) + 1}, evenly spread"
    assert xr.__version__ in facts["Report made with"]
    case_id = next(iter(finished.plan.study.cases()))
    numerics = examine(finished.cases / f"{case_id}.nc")
    assert 0.0 < numerics.residuals.load < 1e-6
    assert 0.0 < numerics.residuals.tangential_load < 1e-6
    assert numerics.residuals.complementarity < 1e-4
    with open_case(finished.cases / f"{case_id}.nc", full=True) as whole:
        fields = {name: whole[name].values[-1] for name in PROFILES}
    found = residuals(fields, numerics.parameters, copies=1)
    assert found.load < 1e-6
    fields["pressure"] = 1.25 * fields["pressure"]
    assert residuals(fields, numerics.parameters, copies=1).load == pytest.approx(0.25, rel=1e-5)


def test_the_study_file_is_shown_as_written_unless_it_was_changed(finished):
    study = finished.plan.study
    assert study_text(study) == study.file.read_text(encoding="utf-8")
    changed = load_study(study.file, ["tolerance=0.02"])
    text = study_text(changed)
    assert yaml.safe_load(text)["base"]["tolerance"] in (0.02, "0.02")
    assert json.dumps(yaml.safe_load(text)) == json.dumps(changed.content)


def test_the_texts_on_a_line_contact_with_debris_are_about_it(tmp_path):
    given = base(debris_fraction=0.5, load="20 N/mm", radius=None, cycles=20)
    given["indenter"] = {"kind": "cylinder", "radius": "6 mm"}
    study = load_study(write_study(tmp_path / "line.yaml", {"title": "Line", "base": given}))
    run_study(study, tmp_path)
    plan = Plan(study)
    words = {row.name: row.words for row in parameter_rows(plan)}
    assert words["hertz_radius"] == "Hertz contact half-width"
    with open_case(next((tmp_path / "cases").glob("*.nc"))) as case:
        assert "cell_y" not in case.coords
        assert case["hertz_radius"].attrs["long_name"] == words["hertz_radius"]
    (tmp_path / "figures").mkdir()
    (tmp_path / "figures" / "index.json").write_text("[]", encoding="utf-8")
    with xr.open_dataset(tmp_path / "summary.nc") as summary:
        page = build_report(plan, summary, tmp_path)
    text = page[page.index("<main") :]
    for wrong in ("sphere", "Fourier", "No third body", "y = 0", "along y", "∬"):
        assert wrong not in text, wrong
    for right in ("plane strain", "Debris stays where it was worn off", "strip of half-width"):
        assert right in text
