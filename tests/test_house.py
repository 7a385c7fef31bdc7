"""The code as a whole: which way imports run, one meaning of a name, a core that stands alone."""

import ast
import re
import sys
from functools import cache
from graphlib import TopologicalSorter
from pathlib import Path

import pytest

from fretwear.mechanics.surfaces.setup import Setup
from fretwear.results import RESULTS

from .studies import base, printed, two_loads, write_study

SOURCE = Path(__file__).parents[1] / "src"
BESIDE = ("fretwear_measured", "fretwear_fit", "fretwear_cracks", "fretwear_source_study")
MODULES = {
    ".".join(file.relative_to(SOURCE).with_suffix("").parts).removesuffix(".__init__"): file
    for package in ("fretwear", *BESIDE)
    for file in (SOURCE / package).rglob("*.py")
}
# The package and `python -m fretwear` only pass on what users call.
DOORS = {"fretwear", "fretwear.__main__"}


@cache
def parsed(file):
    return ast.parse(file.read_text(encoding="utf-8"))


def imported(file, *, for_annotations=True):
    """Modules of ours that a module imports anywhere."""
    waiting = [parsed(file)]
    while waiting:
        node = waiting.pop()
        only_typed = isinstance(node, ast.If) and "TYPE_CHECKING" in ast.unparse(node.test)
        if only_typed and not for_annotations:
            continue
        waiting.extend(ast.iter_child_nodes(node))
        names = [alias.name for alias in getattr(node, "names", []) if hasattr(alias, "name")]
        if isinstance(node, ast.ImportFrom):
            names = [f"{node.module}.{name}" for name in names]
        for name in names:
            found = name if name in MODULES else name.rpartition(".")[0]
            if found in MODULES and found not in DOORS:
                yield found


def test_no_module_is_imported_in_a_circle():
    needed = {module: {*imported(file)} - {module} for module, file in MODULES.items()}
    assert len([*TopologicalSorter(needed).static_order()]) > 50


def test_imports_between_packages_run_one_way():

    def package(module):
        parts = module.split(".")
        return ".".join(parts[:2]) if parts[0] == "fretwear" else parts[0]

    needed = {}
    for module, file in MODULES.items():
        if module not in DOORS:
            own = package(module)
            needed.setdefault(own, set()).update(
                {*map(package, imported(file, for_annotations=False))} - {own}
            )
    assert len([*TopologicalSorter(needed).static_order()]) > 10
    for name in needed.keys() - {*BESIDE}:
        assert not needed[name] & {*BESIDE}, name


def test_the_floors_of_the_mechanics_rest_on_each_other():
    floors = ["contact", "surfaces", "slip", "wear"]
    prefix = "fretwear.mechanics."

    def height(module):
        return floors.index(module.removeprefix(prefix).partition(".")[0])

    above = {
        (module, needed)
        for module in MODULES
        if module.startswith(prefix) and module.count(".") == 3
        for needed in imported(MODULES[module])
        if needed.startswith(prefix) and needed.count(".") == 3
        if height(needed) > height(module)
    }
    assert not above


def test_a_contact_has_three_types_which_are_made_and_read_as_others():
    """The setup, the case of a user and what is solved; what builds or reads them is plain."""
    contacts, waiting = set(), [Setup]
    while waiting:
        contacts.add(contact := waiting.pop())
        waiting += contact.__subclasses__()
    assert {contact.__name__ for contact in contacts} == {"Setup", "Case", "WearProblem"}
    for file in MODULES.values():
        source = file.read_text(encoding="utf-8")
        hidden = re.findall(r"object\.__new__|vars\(\w+\)\.update|__getattribute__", source)
        assert not hidden, f"{file}: {hidden}"


@pytest.mark.slow
def test_the_core_neither_names_nor_needs_the_packages_beside_it(tmp_path):
    for file in (SOURCE / "fretwear").rglob("*.*"):
        if file.suffix in (".py", ".j2", ".js"):
            assert not [n for n in BESIDE if n in file.read_text(encoding="utf-8")], file
    content = two_loads(base=base(cycles=100, cell="10 um"), output={"cycles": [0]})
    file = write_study(tmp_path / "small.yaml", content)
    steps = [[step, str(file), *options] for step, *options in STEPS]
    printed(sys.executable, "-c", ALONE.format(beside=BESIDE, steps=steps), folder=tmp_path)
    assert (tmp_path / "results/small/report.html").stat().st_size > 10_000


STEPS = [["plan"], ["run", "-o", "results/small/cases"], ["merge"], ["figures"], ["report"]]
ALONE = """
import sys
from importlib import metadata

class Blocked:
    def find_spec(self, name, path=None, target=None):
        if name.partition(".")[0] in {beside}:
            raise ModuleNotFoundError(name)

sys.meta_path.insert(0, Blocked())
found = metadata.entry_points
metadata.entry_points = lambda **of: [
    e for e in found(**of) if e.module.partition(".")[0] not in {beside}
]

import fretwear
from fretwear.cli.program import app

for step in {steps}:
    try:
        app(step)
    except SystemExit as end:
        if end.code:
            raise
assert not hasattr(fretwear, "stress")
"""


def test_a_public_name_of_a_module_means_one_thing_in_the_package():
    places = {}
    for module, file in MODULES.items():
        for node in parsed(file).body:
            defined = isinstance(node, ast.FunctionDef | ast.ClassDef)
            targets = getattr(node, "targets", [getattr(node, "target", None)])
            names = [target.id for target in targets if isinstance(target, ast.Name)]
            for name in [node.name] if defined else names:
                if not name.startswith("_") and name != "app":
                    places.setdefault(name, []).append(module)
    assert len(places) > 300
    assert not {name: modules for name, modules in places.items() if len(modules) > 1}


# Names with underscores that their libraries document.
DOCUMENTED = {"_replace", "__metadata__", "__origin__", "__subclasses__", "__mro__", "__dict__"}
DOCUMENTED |= {"__name__", "__module__", "__doc__", "__context__", "__version__", "__file__"}
DOCUMENTED |= {"__init__", "__new__", "__setattr__", "__getattribute__", "__init_subclass__"}
# They are hooks that pydantic and Python call, or names of this package.
DEFINED = {"__version__", "__post_init__", "__pydantic_config__", "__main__", "__all__"}


def names_in(file):
    """Names in a source that may be private: what it defines, and what it takes from elsewhere."""
    own, taken = set(), set()
    for node in ast.walk(parsed(file)):
        if isinstance(node, ast.FunctionDef | ast.ClassDef):
            own.add(node.name)
        elif isinstance(node, ast.Name | ast.Attribute) and isinstance(node.ctx, ast.Store):
            own.add(node.id if isinstance(node, ast.Name) else node.attr)
        elif isinstance(node, ast.Attribute):
            taken.add(node.attr)
        elif isinstance(node, ast.Import | ast.ImportFrom):
            modules = [getattr(node, "module", None) or "", *(each.name for each in node.names)]
            taken.update(
                part for name in modules for part in name.split(".") if name != "__future__"
            )
        elif isinstance(node, ast.Constant) and isinstance(node.value, str):
            # As `getattr` and `vars` take it.
            taken.update(re.findall(r"^__\w+__$", node.value))
    return own, taken


def test_nothing_private_of_python_or_of_a_library_is_used():
    found = {file: names_in(file) for file in MODULES.values()}
    own = {name for defined, _ in found.values() for name in defined}
    private = {
        f"{file.name}: {name}"
        for file, (_, taken) in found.items()
        for name in taken - DOCUMENTED - DEFINED
        if name.startswith("__") or (name.startswith("_") and name not in own)
    }
    assert not private, "private names change without notice: use documented ones"


def test_a_result_has_words_of_its_own():
    assert len({result.words for result in RESULTS.values()}) == len(RESULTS)
