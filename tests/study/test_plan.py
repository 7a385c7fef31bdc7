import csv

import pytest

from fretwear.study.plan import Plan, write_points

from ..studies import WAVES


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
    for row, point in zip(rows, study.points(), strict=True):
        assert float(row["hertz_radius"]) == point.case.hertz_radius
        assert float(row["cell_x"]) == point.case.grid_spacing[0]
        assert float(row["estimated_seconds"]) > 0
        assert int(row["cells"]) > 0
        assert row["problem"] == ""
    # What is varied as a whole has a column in the words of the file.
    content["vary"] = {"roughness": ["none", WAVES], "youngs_modulus": [["208 GPa", "70 GPa"]]}
    smooth, rough = table(studies.load(content))
    words = "{kind: wavy, amplitude: 0.2 um, slope_x: 5.7 deg, slope_y: 1 deg}"
    assert (smooth["roughness"], rough["roughness"]) == ("none", words)
    assert float(rough["roughness_amplitude"]) == 2e-7
    assert rough["youngs_modulus"] == "[208 GPa, 70 GPa]"
    assert float(rough["youngs_modulus_2"]) == 70e9


def test_invalid_points_are_in_the_table_with_the_reason_and_doubts_once_each(
    table, studies, content
):
    content["invalid"] = "skip"
    content["vary"] = {"tangential_ratio": [0.8, 1.5]}
    good, bad = table(studies.load(content))
    assert (bad["id"], bad["cells"], bad["tangential_ratio"]) == ("", "", "1.5")
    assert "gross sliding" in bad["problem"]
    assert good["id"]
    assert list(Plan(studies.load(content)).rows())[1][0] == "(invalid)"
    content["vary"] = {"plastic_limit": ["500 MPa", "4500 MPa"]}
    plan = Plan(studies.load(content))
    ((doubt, cases),) = plan.doubts.items()
    assert doubt.what.startswith("yields all over")
    assert list(cases) == [plan.points[0].id]
