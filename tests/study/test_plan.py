import csv

import pytest

from fretwear.study.plan import Plan, write_points


@pytest.fixture
def table(tmp_path):
    def written(study):
        write_points(study, tmp_path / "points.csv")
        with (tmp_path / "points.csv").open(newline="", encoding="utf-8") as stream:
            return list(csv.DictReader(stream))

    return written


def test_the_table_of_points_is_in_si_units_to_the_last_bit(table, studies, content):
    content["vary"]["plastic_limit"] = ["none", "4500 MPa"]
    study = studies.load(content)
    rows = table(study)
    assert [float(row["load"]) for row in rows] == [25.0, 25.0, 50.0, 50.0]
    assert [float(row["plastic_limit"]) for row in rows] == [float("inf"), 4.5e9] * 2
    assert all(float(row["estimated_seconds"]) > 0 for row in rows)
    assert all(int(row["cells"]) > 0 for row in rows)
    assert all(row["problem"] == "" for row in rows)
    for row, point in zip(rows, study.points(), strict=True):
        assert float(row["hertz_radius"]) == point.case.hertz_radius
        assert float(row["cell_x"]) == point.case.grid_spacing[0]


def test_what_is_varied_as_a_whole_has_a_column_in_the_words_of_the_file(table, studies, content):
    waves = {"kind": "wavy", "amplitude": "0.2 um", "slope_x": "0.2 deg", "slope_y": "1 deg"}
    content["vary"] = {"roughness": ["none", waves], "youngs_modulus": [["208 GPa", "70 GPa"]]}
    smooth, rough = table(studies.load(content))
    assert smooth["roughness"] == "none"
    assert rough["roughness"] == (
        "{kind: wavy, amplitude: 0.2 um, slope_x: 0.2 deg, slope_y: 1 deg}"
    )
    assert float(rough["roughness_amplitude"]) == 2e-7
    assert rough["youngs_modulus"] == "[208 GPa, 70 GPa]"
    assert float(rough["youngs_modulus_2"]) == 70e9


def test_invalid_points_are_in_the_table_with_the_reason(table, studies, content):
    content["invalid"] = "skip"
    content["vary"] = {"tangential_ratio": [0.8, 1.5]}
    good, bad = table(studies.load(content))
    assert (bad["id"], bad["cells"], bad["tangential_ratio"]) == ("", "", "1.5")
    assert "gross sliding" in bad["problem"]
    assert good["id"]
    assert list(Plan(studies.load(content)).rows())[1][0] == "(invalid)"


def test_cases_of_one_doubt_are_found_once_each(studies, content):
    content["vary"] = {"plastic_limit": ["500 MPa", "4500 MPa"]}
    plan = Plan(studies.load(content))
    ((doubt, cases),) = plan.doubts.items()
    assert doubt.what.startswith("yields all over")
    assert list(cases) == [plan.points[0].id]
