"""Parts declare themselves: nothing of a parameter is named anywhere else."""

import json
import math
from pathlib import Path
from typing import Annotated, Literal

import numpy as np
import pytest
from pydantic.dataclasses import dataclass

from fretwear.mechanics.slip.models import ReducedContact, SlipModel
from fretwear.mechanics.surfaces.laws import PowerLaw, WearLaw
from fretwear.mechanics.surfaces.roughness import Roughness
from fretwear.quantity import Part, Quantity, field_names
from fretwear.run.simulate import simulate
from fretwear.study.case import Case, CaseError
from fretwear.study.parameters import parameter, symbol_text
from fretwear.study.rules import RULES
from fretwear.study.sections import study_schema
from fretwear.units import in_unit

from ..studies import SELF_AFFINE, WAVES, line_contact, near, steel, study_case

jsonschema = pytest.importorskip("jsonschema")


@dataclass(frozen=True)
class Dimple(Roughness):
    """One round dimple in the middle of the contact."""

    depth: Annotated[float, Quantity("m", "$D$", "dimple depth", "um", gt=0.0)]
    width: Annotated[float, Quantity("m", "$B$", "dimple width", "um", gt=0.0)]
    kind: Literal["dimple"] = "dimple"

    def height(self, x, y):
        return self.depth * np.exp(-(x**2 + y**2) / self.width**2)

    @property
    def finest(self):
        return self.width, self.width

    @property
    def highest(self):
        return self.depth

    @property
    def wavelengths(self):
        return math.inf, math.inf


@dataclass(frozen=True)
class WearPerLoad(WearLaw):
    """A wear coefficient that grows with friction."""

    friction_wear: Annotated[
        float, Quantity("Pa-1", "$α$", "wear by friction", "/ Pa", like="5e-14 / Pa", gt=0.0)
    ]
    kind: Literal["by_friction"] = "by_friction"

    def coefficient(self, friction):
        return self.friction_wear * friction.coefficient


@dataclass(frozen=True)
class UniformSlip(SlipModel):
    """All points slip alike, as in reciprocating gross slip; nothing sticks."""

    slip_gap: Annotated[float, Quantity("m", "$g_0$", "gap that stands for slip", "um", gt=0.0)]
    kind: Literal["uniform"] = "uniform"

    def reduced(self, setup, pressed, start=None):
        del setup, start
        nothing = np.zeros_like(pressed.pressure)
        return ReducedContact(nothing, nothing + self.slip_gap, 0.0, 0.0)


MADE_UP = {Dimple: "dimple", WearPerLoad: "by_friction", UniformSlip: "uniform"}


def register(*, there):
    """A kind without a name is none: other tests shall not meet those made up here."""
    for kind, name in MADE_UP.items():
        kind.kind = name if there else ""
    Part.kinds.cache_clear()


register(there=False)


@pytest.fixture(autouse=True)
def made_up_kinds():
    register(there=True)
    yield
    register(there=False)


RANDOM = {**SELF_AFFINE, "shortest_wavelength": "8 um", "seed": 11, "anisotropy": 2}
MEASURED = {
    "kind": "measured",
    # As a dataset has it: the file itself is not needed to know the case again.
    "file": f"disc.x3p sha256:{64 * 'a'}",
    "patch": ["0 mm", "0 mm", "1 mm", "2 mm"],
}
INDENTERS = (
    {"kind": "ellipsoid", "radius_x": "10 mm", "radius_y": "20 mm"},
    {"kind": "crossed_cylinders", "radii": ["10 mm", "8 mm"], "angle": "60 deg"},
    {"kind": "profile", "file": str(Path(__file__).with_name("tip.csv"))},
    {"kind": "round_punch", "flat_radius": "50 um", "edge_radius": "10 mm", "half_width": "1 mm"},
)
COATING = {"thickness": "15 um", "youngs_modulus": "500 GPa", "poisson_ratio": 0.2}
DIMPLE = {"kind": "dimple", "depth": "0.5 um", "width": "20 um"}
PUNCH = {
    "kind": "flat_punch",
    "flat_half_width": "100 um",
    "edge_radius": "6 mm",
    "half_width": "1 mm",
}
LINE = {**line_contact("6 mm", "18.5 N/mm"), "roughness": None, "cell": None}
LAW = {"value": "4e-14 / Pa", "pressure_exponent": 0.6, "reference_pressure": "100 MPa"}


def examples():
    """One case for each kind of part, so that every parameter occurs."""
    no_load = {"tangential_load": None}
    rig = {**no_load, "rig_stiffness": "28 N/um"}
    punched = {**LINE, **no_load, "tangential_ratio": 0.5, "indenter": PUNCH}
    yielding = {**LINE, **no_load, "tangential_compliance": "0.1 um/(N/mm)"}
    sliding = {**LINE, **no_load, "plastic_limit": None, "sliding_amplitude": "25 um"}
    worn_apart = ["1.9e-14 / Pa", "2.9e-14 / Pa"]
    held = {"displacement_amplitude": "1 um", "load": None, "indentation": "2 um"}
    others = {"debris_fraction": 0.85, "frequency": "5 Hz", "bulk_stress": "80 MPa", "budget": 20}
    others["wear_threshold"] = "2 mJ/mm^2"
    changes = [
        {},
        {**no_load, "tangential_ratio": 0.8},
        {**rig, "displacement_ratio": 0.8},
        {**rig, **held},
        {**others, "accuracy": 0.02},
        {"junction_growth": 9.0},
        {"coating": COATING},
        {"coating": {**COATING, "thickness": "9 um", "plastic_limit": "12 GPa"}},
        {"cycles": None, "blocks": [{"cycles": 20, "friction": 0.6}, {"cycles": 30}]},
        {"wear_coefficient": None, "energy_wear_coefficient": "5e-5 mm^3/J"},
        {"wear_coefficient": LAW},
        {"wear_coefficient": ["1e-14 / Pa", LAW]},
        {"wear_coefficient": None, "friction_wear": "5e-14 / Pa"},
        {"friction": {"cycles": [0, 500], "values": [0.5, 0.6]}},
        {"roughness": DIMPLE, "cell": None},
        *({"radius": None, "indenter": each} for each in INDENTERS),
        *({"roughness": each} for each in (RANDOM, MEASURED)),
        *({"counterface": each, "cell": None} for each in (WAVES, DIMPLE, RANDOM, MEASURED)),
        {"slip_model": {"kind": "uniform", "slip_gap": "1 um"}},
        {**LINE, "tangential_load": "5 N/mm"},
        {**yielding, "displacement_amplitude": "1 um"},
        {**yielding, "displacement_ratio": 0.5},
        punched,
        {**sliding, "wear_coefficient": worn_apart},
        {**sliding, "wear_coefficient": worn_apart, "pulsating_load": 0.3},
        {**sliding, "sliding_amplitude": None, "sliding_distance": "3.6 m", "cycles": None},
    ]
    return [study_case(**each) for each in changes]


def test_every_example_is_another_case_with_other_coordinates():
    """No parameter is forgotten in ids, canonical parameters or coordinates."""
    cases = examples()
    for key in (
        lambda case: case.case_id,
        lambda case: json.dumps(case.canonical_parameters(), sort_keys=True),
        lambda case: str(sorted(case.scalar_coordinates().items())),
    ):
        assert len({*map(key, cases)}) == len(cases) - 1  # a force and its ratio are one


@pytest.mark.slow
def test_a_rule_reads_only_members_that_it_declares():
    """It says the same of a contact without the others, though this has members of several."""
    random, names, told = np.random.default_rng(4), sorted(field_names(Case)), 0
    kept = [{name: getattr(case, name) for name in names} for case in examples()]
    for _ in range(60):
        one, *others = random.choice(kept, 8)
        drawn = {
            name: each[name] for each, name in zip(others, random.choice(names, 7), strict=True)
        }
        members = one | drawn
        for rule in RULES:
            declared = {n: member for n, member in members.items() if n in rule.members}
            mistakes = [*rule.broken_by(Case(members))]
            assert mistakes == [*rule.broken_by(Case(declared))], rule.check.__name__
            told += len(mistakes)
    assert told > 10


def test_every_case_is_made_again_from_its_parameters_as_json():
    for case in [*examples(), steel()]:
        parameters = json.loads(json.dumps(case.canonical_parameters(), allow_nan=False))
        again = Case(**parameters)
        assert again.case_id == case.case_id
        assert again.canonical_parameters() == case.canonical_parameters()


def test_every_coordinate_has_words_and_a_symbol():
    for case in examples():
        for name, (value, units, words) in case.scalar_coordinates().items():
            value = in_unit(value, units)
            quantity = parameter(name).in_frame_of(value)
            # A strip has a half-width where a disc has a radius.
            extent = f"contact {case.frame.extent}"
            assert quantity.words.replace("contact radius", extent) == words, name
            assert quantity.si_unit == (units or "1"), name
            assert symbol_text(name, value)


def test_a_new_kind_is_read_varied_and_described(studies, content):
    content["base"]["roughness"] = {"kind": "dimple", "width": "20 um"}
    content["base"]["friction_wear"] = "5e-14 / Pa"
    del content["base"]["wear_coefficient"]
    content["vary"] = {"roughness.depth": ["0.2 um", "0.5 um"]}
    schema = jsonschema.Draft202012Validator(study_schema())
    schema.check_schema(schema.schema)
    schema.validate(content)
    assert not schema.is_valid(content | {"varry": {}})
    study = studies.load(content)
    assert [axis.coordinate for axis in study.axes] == ["roughness_depth"]
    deep = study.points()[1].case
    assert isinstance(deep.roughness, Dimple)
    assert deep.wear_law.coefficient(deep.friction_law) == near(2.5e-14)
    assert deep.scalar_coordinates()["roughness_depth"] == (5e-7, "m", "dimple depth")
    assert deep.grid_spacing[0] <= 20e-6 / 16
    assert len(study.cases()) == 2
    changed = studies.load(content, ["roughness.depth=1 um"]).cases()
    assert [case.roughness.depth for case in changed.values()] == [1e-6]


def test_a_case_can_be_changed_and_have_the_long_form_of_an_indenter():
    heavier = study_case().replace(load="60 N")
    assert (heavier.load, heavier.tangential_load) == (60.0, 20.0)
    assert study_case().replace(tangential_ratio=0.5).tangential_load == near(12.5)
    assert study_case().replace(indenter=INDENTERS[0]).indenter.kind == "ellipsoid"
    assert study_case().replace(blocks=[{"cycles": 5}, {"cycles": 7, "friction": 0.6}]).cycles == 12
    rig = {"displacement_ratio": 0.8, "rig_stiffness": "28 N/um", "tangential_load": None}
    stiff = study_case(**rig).replace(displacement_amplitude="1 um")
    assert stiff.loading.rig_stiffness == near(28e6)
    with pytest.raises(CaseError, match="gross sliding"):
        study_case().replace(load="30 N")
    long = study_case(radius=None, indenter={"kind": "sphere", "radius": "10 mm"})
    assert long == study_case()
    assert long.radius == 0.01


def test_a_pair_may_hold_a_law_for_one_body():
    """One body may not wear at all while the coefficient of the other is a mapping."""
    case = steel(wear_coefficient=[0, {"value": "4e-14 / Pa", "frequency_exponent": 0}])
    value = case.wear_coefficient
    assert value == (0.0, PowerLaw(4e-14))
    assert (float(value), value.shares) == (4e-14, (0.0, 1.0))
    coordinates = case.scalar_coordinates()
    ends = ("", "_indenter", "_flat", "_flat_value")
    found = [coordinates[f"wear_coefficient{end}"][0] for end in ends]
    assert found == [4e-14, 0.0, 4e-14, 4e-14]


@pytest.mark.filterwarnings("ignore::fretwear.ResultWarning")
def test_new_kinds_run_from_a_study_file(studies, content):
    content["base"] |= {
        "plastic_limit": "4500 MPa",
        "roughness": {**DIMPLE, "width": "60 um"},
        "slip_model": {"kind": "uniform", "slip_gap": "1 um"},
        "friction_wear": "5e-14 / Pa",
        "cell": "6 um",
        "cycles": 100,
    }
    del content["base"]["wear_coefficient"]
    content["output"] = {"cycles": [10]}
    case = studies.load(content, ["load=50 N"]).points()[0].case
    dataset = simulate(case, quarter=True)
    assert dataset["slip_model_slip_gap"] == 1e-6
    # Archard for constant slip: the volume is that of the load on the path, by 4 K P µκg per cycle.
    path = 4 * case.friction * case.coupling * 1e-6 * dataset["cycle"]
    expected = case.wear_law.coefficient(case.friction_law) * case.load * path
    np.testing.assert_allclose(dataset["wear_volume"], expected, rtol=1e-3, atol=1e-24)
