"""What stands in several files of the project says the same everywhere."""

import ast
import re
import tomllib
from pathlib import Path

import yaml
from packaging.requirements import Requirement
from packaging.utils import canonicalize_name
from packaging.version import Version

import fretwear

REPOSITORY = Path(__file__).parents[1]
PROJECT = tomllib.loads((REPOSITORY / "pyproject.toml").read_text(encoding="utf-8"))["project"]


def pinned():
    lines = (REPOSITORY / "constraints.txt").read_text(encoding="utf-8").splitlines()
    pairs = [line.split("==") for line in lines]
    return {canonicalize_name(name): Version(version) for name, version in pairs}


def test_every_dependency_is_pinned_to_a_version_in_its_range_and_nothing_else():
    versions = pinned()
    needed = [*PROJECT["dependencies"], *PROJECT["optional-dependencies"]["test"]]
    for requirement in map(Requirement, needed):
        assert versions[canonicalize_name(requirement.name)] in requirement.specifier
    lines = (REPOSITORY / "constraints.txt").read_text(encoding="utf-8").splitlines()
    assert all(re.fullmatch(r"[A-Za-z0-9._-]+==[A-Za-z0-9.]+", line) for line in lines)
    names = [line.split("==")[0].lower() for line in lines]
    assert names == sorted(set(names))


def test_version_and_license_are_the_same_everywhere():
    citation = yaml.safe_load((REPOSITORY / "CITATION.cff").read_text(encoding="utf-8"))
    changelog = (REPOSITORY / "CHANGELOG.md").read_text(encoding="utf-8")
    assert PROJECT["version"] == fretwear.__version__
    assert citation["version"] == fretwear.__version__
    assert re.search(r"^## (\S+)", changelog, re.MULTILINE)[1] == fretwear.__version__
    text = (REPOSITORY / "LICENSE").read_text(encoding="utf-8")
    assert text.startswith("BSD 3-Clause License")
    assert citation["license"] == "BSD-3-Clause"
    assert PROJECT["license"] == "BSD-3-Clause"


DANGEROUS = {
    "pickle",
    "marshal",
    "shelve",
    "dill",
    "eval",
    "exec",
    "unsafe_load",
    "full_load",
    "system",
}


def test_nothing_that_is_read_can_run():
    sources = [*(REPOSITORY / "src").rglob("*.py")]
    assert len(sources) > 50
    for source in sources:
        for node in ast.walk(ast.parse(source.read_text(encoding="utf-8"))):
            names = {getattr(node, "id", ""), getattr(node, "attr", "")}
            if isinstance(node, ast.Import):
                names = {alias.name for alias in node.names}
            elif isinstance(node, ast.ImportFrom):
                names = {node.module or ""}
            elif isinstance(node, ast.keyword):
                if node.arg == "allow_pickle":
                    assert isinstance(node.value, ast.Constant), source
                    assert node.value.value is False, source
                names = {"system"} if node.arg == "shell" else set()
            assert not names & DANGEROUS, (source, names)
