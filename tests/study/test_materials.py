"""Materials by name, and published coefficients."""

import jsonschema
import pytest
import yaml
from typer.testing import CliRunner

from fretwear.cli.program import app
from fretwear.quantity import QuantityError
from fretwear.study.case import Case, CaseError, case_keys
from fretwear.study.materials import material_table, read_table
from fretwear.study.sections import study_schema

GIVEN = {
    "radius": "10 mm",
    "load": "5 N",
    "tangential_ratio": 0.5,
    "friction": 0.5,
    "wear_coefficient": "1e-14 / Pa",
    "cycles": 10,
}


def test_every_material_is_a_pair_of_elastic_constants_with_a_source():
    assert len(material_table()) > 30
    for name, row in material_table().items():
        case = Case(**GIVEN, material=name if name in ("tin", "TiN") else name.upper())
        assert 10e9 < case.youngs_modulus < 600e9
        assert 0.15 < case.poisson_ratio < 0.5
        assert row["source"]
        assert row["source"].split("(")[0].strip()[-4:].rstrip("ab").isdigit()


def test_titanium_nitride_is_not_tin():
    found = [Case(**GIVEN, material=name).youngs_modulus for name in ("TiN", "tin", "Tin")]
    assert found == [290e9, 49.9e9, 49.9e9]
    with pytest.raises(ValueError, match="did you mean 'tin' or 'TiN'"):
        Case(**GIVEN, material="TIN")


def test_a_material_is_short_for_its_constants_which_given_values_replace():
    written = Case(**GIVEN, youngs_modulus="207 GPa", poisson_ratio=0.3)
    assert Case(**GIVEN, material="52100") == written
    pair = Case(**GIVEN, material=["52100", "alumina"])
    assert (pair.youngs_modulus, pair.plastic_limit) == ((207e9, 416e9), float("inf"))
    hard = Case(**GIVEN, material=["silicon carbide", "alumina"], poisson_ratio=0.2)
    assert (hard.poisson_ratio, hard.plastic_limit) == (0.2, 15e9)
    assert written.replace(material="alumina").youngs_modulus == 416e9
    with pytest.raises(CaseError) as error:
        Case(**GIVEN, material="Ti6Al4V")
    assert str(error.value).splitlines() == [
        "material = Ti6Al4V: must be a material of the table, or a pair of them",
        "    did you mean 'Ti-6Al-4V'?",
    ]


def test_a_study_file_names_its_material(studies, content):
    content["base"] = {"material": "alumina", "roughness": "none", **GIVEN}
    del content["base"]["load"], content["output"]
    content["vary"] = {"load": ["5 N", "6 N"], "youngs_modulus": ["400 GPa"]}
    jsonschema.Draft202012Validator(study_schema()).validate(content)
    (case, _) = studies.load(content).cases().values()
    assert (case.youngs_modulus, case.poisson_ratio, case.plastic_limit) == (400e9, 0.231, 15e9)
    (case, _) = studies.load(content, ["material=52100", "plastic_limit=none"]).cases().values()
    assert (case.youngs_modulus, case.poisson_ratio) == (207e9, 0.3)


def test_published_coefficients_are_values_that_a_study_file_takes():
    for row in read_table("coefficients"):
        name = {"Archard": "wear_coefficient", "energy": "energy_wear_coefficient"}[row["law"]]
        quantity = case_keys()[name].parameter
        try:
            quantity.read(yaml.safe_load(row["coefficient"]), True)
        except QuantityError as error:
            pytest.fail(f"{row['pair']}: {error}")
        assert row["source"].split()[-1].isdigit()
    assert "35NCD16 on itself" in CliRunner().invoke(app, ["coefficients"]).stdout
