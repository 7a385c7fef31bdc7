"""What stands in several files says the same everywhere; the digest of what computes results."""

import ast
import json
import platform
import re
import runpy
import sys
import tomllib
from functools import partial
from importlib import import_module
from pathlib import Path

import pytest
import yaml
from packaging.requirements import Requirement
from packaging.utils import canonicalize_name
from packaging.version import Version

import fretwear
from fretwear import version
from fretwear.version import code_digest

from .studies import printed

REPOSITORY = Path(__file__).parents[1]
PYPROJECT = tomllib.loads((REPOSITORY / "pyproject.toml").read_text(encoding="utf-8"))
PROJECT = PYPROJECT["project"]


def text_of(name):
    return (REPOSITORY / name).read_text(encoding="utf-8")


def test_every_dependency_is_pinned_to_a_version_in_its_range_and_nothing_else():
    pairs = re.findall(r"^([A-Za-z0-9._-]+)==([A-Za-z0-9.]+)\n", text_of("constraints.txt"), re.M)
    assert "".join(f"{name}=={version}\n" for name, version in pairs) == text_of("constraints.txt")
    versions = {canonicalize_name(name): Version(version) for name, version in pairs}
    needed = [*PROJECT["dependencies"], *PROJECT["optional-dependencies"]["test"]]
    needed += PYPROJECT["build-system"]["requires"]
    for requirement in map(Requirement, needed):
        assert versions[canonicalize_name(requirement.name)] in requirement.specifier
    names = [name.lower() for name, _ in pairs]
    assert names == sorted(set(names))


def test_version_and_license_are_the_same_everywhere():
    citation = yaml.safe_load(text_of("CITATION.cff"))
    told = re.search(r"^## (\S+)", text_of("CHANGELOG.md"), re.MULTILINE)[1]
    assert text_of("LICENSE").startswith("BSD 3-Clause License")
    assert citation["license"] == PROJECT["license"] == "BSD-3-Clause"
    meta = json.loads(text_of("codemeta.json"))
    versions = {PROJECT["version"], citation["version"], meta["version"], told}
    assert versions == {fretwear.__version__}
    assert meta["license"].endswith(f"/{citation['license']}")
    names = {author["name"] for author in (*PROJECT["authors"], *meta["author"])}
    assert names == {author["name"] for author in citation["authors"]}


def test_the_conda_recipe_has_the_version_and_the_requirements_of_the_project():
    recipe = yaml.safe_load(text_of(".github/conda/recipe.yaml"))
    assert recipe["context"]["version"] == PROJECT["version"]
    assert recipe["about"]["license"] == PROJECT["license"]
    conda = {"matplotlib": "matplotlib-base", "snakemake": "snakemake-minimal"}
    needed = {f"python {PROJECT['requires-python']}"}
    for requirement in map(Requirement, PROJECT["dependencies"]):
        name = requirement.name.lower()
        needed.add(f"{conda.get(name, name)} {requirement.specifier}")
    assert set(recipe["requirements"]["run"]) == needed


def test_every_python_that_is_named_follows_the_oldest_and_ci_has_both_ends():
    words = "Programming Language :: Python :: 3."
    named = [int(c.removeprefix(words)) for c in PROJECT["classifiers"] if c.startswith(words)]
    assert named == [*range(named[0], named[-1] + 1)]
    oldest, newest = f"3.{named[0]}", f"3.{named[-1]}"
    assert PROJECT["requires-python"] == f">={oldest}"
    assert PYPROJECT["tool"]["mypy"]["python_version"] == oldest
    (step,) = (
        step["with"]["python-version"]
        for step in yaml.safe_load(text_of(".github/workflows/ci.yml"))["jobs"]["run"]["steps"]
        if "python-version" in step.get("with", {})
    )
    assert step.split() == [newest, oldest]  # the last one is `python3`


@pytest.mark.parametrize("older", [(3, 10, 13), (3, 8, 18)])
def test_an_older_python_is_told_what_to_install(older, monkeypatch):
    monkeypatch.setattr("sys.version_info", older)
    with pytest.raises(SystemExit) as end:
        runpy.run_path(str(REPOSITORY / "setup.py"))
    assert f"needs Python 3.11 or newer, and this is Python {'.'.join(map(str, older))}" in str(end)
    assert "apt install python3-venv" in text_of("README.md").split("```")[4]
    requires = [*map(Requirement, PYPROJECT["build-system"]["requires"])]
    # It gets as far as this with any setuptools.
    environment = {"python_version": "{}.{}".format(*older)}
    assert [str(r.specifier) for r in requires if r.marker.evaluate(environment)] == [""]


@pytest.mark.slow
def test_the_machine_tells_its_kernels_and_transforms():
    said = partial(printed, sys.executable, REPOSITORY / ".ci/kernels")
    assert re.fullmatch(
        r"Python \S+; .* with kernels .*; transforms by (ducc0|scipy) \S+\n", said()
    )
    if "openblas" in said() and platform.machine() == "x86_64":
        assert said(OPENBLAS_CORETYPE="Nehalem").count("kernels Nehalem") == 2


# What the sources in the digest take from other modules: it reads parameters, which the file of a
# case names, refuses them, or tells of them; no number follows from it.
TAKEN = {
    "arrays.py": "Array Single Mask Places Even Element Real",
    "plugins.py": "plugins",
    "units.py": "BY_SI_UNIT ContactFrame Dimension FloatWithUnit LINE_CONTACT MEGAPASCAL "
    "MICROMETRE NO_UNIT NUMBER_PATTERN PERCENT POINT_CONTACT QuantityError Unit did_you_mean "
    "format_quantity in_unit nearest number_text parse_quantity with_unit",
    "study/mistakes.py": "LISTED Mistake Mistakes RANGE",
    "study/rules.py": "findings",
    "study/materials.py": "MATERIAL Material PROPERTIES",
    "study/short_forms.py": "long_form",
    "study/case_warnings.py": "CaseWarning case_warnings",
    "run/resources.py": "require_memory",
    "run/progress.py": "Observer Step progress_bar",
    "version.py": "__version__ case_digest",
}


def taken(file):
    """What a source imports of the package: the module and the name in it."""
    package = Path(fretwear.__file__).parent
    for node in ast.walk(ast.parse(file.read_text(encoding="utf-8"))):
        if isinstance(node, ast.Import):
            assert not [n.name for n in node.names if n.name.partition(".")[0] == "fretwear"]
        if isinstance(node, ast.ImportFrom) and (node.module or "").partition(".")[0] == "fretwear":
            assert not node.level
            place = node.module.replace(".", "/").removeprefix("fretwear").lstrip("/")
            for name in (each.name for each in node.names):
                files = f"{place}/{name}.py", f"{place}.py", f"{place}/__init__.py"
                yield next(each for each in files if (package / each).exists()), name


def test_what_decides_numbers_is_in_the_digest():
    package = Path(fretwear.__file__).parent
    sources = version._python_files(package / name for name in version.SOURCES)
    found = {pair for file in sources for pair in taken(file)}
    outside = {(module, name) for module, name in found if package / module not in sources}
    assert len(sources) > 40
    assert outside == {(module, name) for module in TAKEN for name in TAKEN[module].split()}
    for module, name in outside:
        place = import_module(f"fretwear.{module.removesuffix('.py').replace('/', '.')}")
        assert not isinstance(getattr(place, name), int | float), f"{module}: {name} is a number"


def test_comments_docstrings_and_patch_releases_are_not_code(tmp_path, monkeypatch):
    package = tmp_path / "fretwear"
    monkeypatch.setattr("fretwear.version.__file__", str(package / "version.py"))
    monkeypatch.setattr("fretwear.version.SOURCES", ("theory",))

    def digest(body, folder="fretwear/theory", packages=()):
        file = tmp_path / folder / "law.py"
        file.parent.mkdir(parents=True, exist_ok=True)
        file.write_text(body)
        return code_digest.__wrapped__(*packages)

    code = "def law(p):\n    return '# p' + p\n"
    same = '"""Laws."""\n\ndef law(p):  # of wear\n    """A law."""\n    return \'# p\' + p  # Pa\n'
    assert digest(code) == digest(same) != digest(code.replace("# p", "# q"))
    table = 'rows = table(\n    """\n    a | b\n    """\n)\n'
    assert digest(table) != digest(table.replace("b", "c"))
    # Code of another package counts where it is named, and so do versions of libraries.
    core = digest(code)
    cracks = digest(code, "fretwear_cracks", ["fretwear_cracks"])
    assert core == code_digest.__wrapped__() != cracks
    assert digest("law = 1", "fretwear_cracks", ["fretwear_cracks"]) != cracks
    monkeypatch.setattr("fretwear.version.LIBRARIES", ("numpy",))
    assert code_digest.__wrapped__() != core

    def with_libraries(number):
        monkeypatch.setattr(version.metadata, "version", lambda _: number)
        return code_digest.__wrapped__()

    assert with_libraries("2.4.1") == with_libraries("2.4.9") != with_libraries("2.5.1")
