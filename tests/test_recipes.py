"""The recipes of CONTRIBUTING.md, which change a copy of the package."""

import json
import shutil
import sys
from pathlib import Path

import pytest
from examples import blocks, patch

import fretwear

from .studies import printed

REPOSITORY = Path(__file__).parents[1]

# Beside the scalar of the page: one before all others, one that only some contacts have, and one
# after all others.
SCALARS = """\
+++ src/fretwear/mechanics/wear/measures.py
@@
+    @scalar("Pa", "first pressure")
+    def first_pressure(self) -> float:
+        \"""P over the area of contact.\"""
+        return self.normal_force / self.contact_area
+
+    @scalar("Pa", "pressure of strokes", needs=lambda measures: measures.problem.loading.stroke)
+    def stroke_pressure(self) -> float:
+        \"""Of strokes alone.\"""
+        return self.first_pressure
+
     @scalar("m", "approach", symbol="$δ$", unit="µm")
@@
         return law.coefficient * integral(law.ratio * slipping) / integral(slipping)

+    @scalar("J", "last energy", is_at_snapshots=True)
+    def last_energy(self) -> float:
+        \"""Of all cycles at once.\"""
+        return self.dissipated_energy
+
"""
NEW = ("mean_pressure", "first_pressure", "stroke_pressure", "last_energy")

BALL, CYLINDER = ({"kind": kind, "radius": "10 mm"} for kind in ("sphere", "cylinder"))
EACH = {"wear_coefficient": ["3e-13 / Pa", "4e-13 / Pa"], "sliding_amplitude": "50 um"}
BOTH = {"wear_coefficient": "7e-13 / Pa", "tangential_ratio": 0.8}
WAVES = {"amplitude": "0.4 um", "slope_x": "1 deg", "slope_y": "1 deg"}
CONTACTS = {
    "rings": {"indenter": BALL, "load": "50 N", "cell": "20 um", **BOTH},
    "point": {"indenter": BALL, "load": "5 N", "roughness": WAVES, "accuracy": "none", **BOTH},
    "line": {"indenter": CYLINDER, "load": "100 N/mm", **BOTH},
    "stroke": {"indenter": CYLINDER, "load": "100 N/mm", "accuracy": "none", **EACH},
}
SCRIPT = """
import json, sys, fretwear
from fretwear.run.simulate import run

print(fretwear.__file__)
for name, given in json.loads(sys.argv[1]).items():
    case = fretwear.Case(material="52100", friction=0.5, cycles=2, **given)
    dataset, history, *_ = run(case)
    last = dataset.isel(cycle=-1)
    values = {n: float(last[n]) for n in last if last[n].ndim == 0}
    units = {n: dataset[n].attrs["units"] for n in values}
    print(json.dumps([values, units, [*history], dataset["mean_pressure"].attrs]))
"""


@pytest.fixture(scope="module")
def recipes(tmp_path_factory):
    """The folder of a copy of the package that the page has changed."""
    folder = tmp_path_factory.mktemp("recipes")
    compiled = shutil.ignore_patterns("__pycache__", "*.egg-info")
    shutil.copytree(Path(fretwear.__file__).parents[1], folder / "src", ignore=compiled)
    page = (REPOSITORY / "CONTRIBUTING.md").read_text(encoding="utf-8")
    diffs = [block.text for block in blocks(page) if block.language == "diff"]
    assert len(diffs) == 5
    for diff in diffs:
        patch(diff, folder)
    return folder


@pytest.mark.slow
def test_a_scalar_declared_anywhere_is_a_result_of_every_contact(recipes):
    patch(SCALARS, recipes)
    command = [sys.executable, "-W", "ignore", "-c", SCRIPT, json.dumps(CONTACTS)]
    file, *lines = printed(*command, PYTHONPATH=str(recipes / "src")).splitlines()
    assert Path(file).is_relative_to(recipes)
    for name, line in zip(CONTACTS, lines, strict=True):
        values, units, history, attributes = json.loads(line)
        names = [new for new in NEW if new != "stroke_pressure" or name == "stroke"]
        assert [new for new in NEW if new in values] == names
        for new in names:
            assert 0.0 <= values[f"{new}_error"] < 0.1 * values[new]
            assert units[f"{new}_error"] == units[new]
        pressure = values["normal_force"] / values["contact_area"]
        for new in set(names) - {"last_energy"}:
            assert values[new] == pytest.approx(pressure, rel=1e-12)
            assert units[new] == "Pa"
        assert values["last_energy"] == values["dissipated_energy"]
        assert units["last_energy"] == ("J" if name in ("rings", "point") else "J m-1")
        of_stroke = {"stroke_pressure"} if name == "stroke" else set()
        assert {*NEW} & {*history} == {"mean_pressure", "first_pressure"} | of_stroke
        assert attributes["long_name"] == "mean pressure"
        assert attributes["comment"] == "load over area of contact"


@pytest.mark.slow
@pytest.mark.parametrize("tool", ["ruff check", "ruff format --check --diff"])
def test_recipes_are_in_the_style_of_the_package(recipes, tool):
    shutil.copy(REPOSITORY / "pyproject.toml", recipes)
    program = Path(sys.executable).parent / "ruff"
    printed(program, *tool.split()[1:], "src", folder=recipes)


@pytest.mark.slow
def test_recipes_give_no_symbol_a_second_meaning(recipes):
    test = ["tests/docs/test_reference.py", "-k", "two_quantities"]
    command = [sys.executable, "-m", "pytest", "-q", *test]
    printed(*command, folder=REPOSITORY, PYTHONPATH=str(recipes / "src"))
