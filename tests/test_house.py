"""The code as CONTRIBUTING.md describes it: packages, their imports, one name per quantity."""

import ast
import re
from graphlib import TopologicalSorter
from pathlib import Path

from fretwear.vocabulary import RESULTS

REPOSITORY = Path(__file__).parents[1]
SOURCE = REPOSITORY / "src/fretwear"
GUIDE = (REPOSITORY / "CONTRIBUTING.md").read_text(encoding="utf-8")
MODULES = {
    ".".join(("fretwear", *file.relative_to(SOURCE).with_suffix("").parts)).removesuffix(
        ".__init__"
    ): file
    for file in SOURCE.rglob("*.py")
}
# The package and `python -m fretwear` only pass on what users call.
DOORS = {"fretwear", "fretwear.__main__"}


def parsed(file):
    return ast.parse(file.read_text(encoding="utf-8"))


def imports(tree, *, when_loaded=False):
    """Modules of the package that a module imports, or only those it needs to be loaded."""
    for node in ast.iter_child_nodes(tree):
        if when_loaded and isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef):
            continue
        if when_loaded and isinstance(node, ast.If) and "TYPE_CHECKING" in ast.unparse(node.test):
            continue
        if isinstance(node, ast.Import):
            names = [alias.name for alias in node.names]
        elif isinstance(node, ast.ImportFrom):
            names = [f"{node.module}.{alias.name}" for alias in node.names]
        else:
            yield from imports(node, when_loaded=when_loaded)
            continue
        for name in names:
            found = name if name in MODULES else name.rpartition(".")[0]
            if found in MODULES and found not in DOORS:
                yield found


def package(module):
    return module.split(".")[1]


def test_imports_run_one_way_and_never_in_a_circle():
    """A package imports only packages above it in the table, and only those named in its row."""
    rows = re.findall(r"^\| `(\w+)(?:\.py|/)` \|[^|]*\| ([^|]*) \|$", GUIDE, re.MULTILINE)
    allowed = {name: set(re.findall(r"`(\w+)`", known)) for name, known in rows}
    found = {name: set() for name in allowed}
    for module in MODULES.keys() - DOORS:
        found[package(module)] |= {package(each) for each in imports(parsed(MODULES[module]))}
    for index, (name, known) in enumerate(allowed.items()):
        assert found[name] - {name} <= known <= {*[*allowed][:index]}, name
    assert set(allowed) == {package(module) for module in MODULES.keys() - DOORS}
    loaded = {name: set(imports(parsed(f), when_loaded=True)) for name, f in MODULES.items()}
    graph = {module: needed - {module} for module, needed in loaded.items()}
    assert len(list(TopologicalSorter(graph).static_order())) == len(MODULES)


def test_a_public_name_of_a_module_means_one_thing_in_the_package():
    places = {}
    for file in SOURCE.rglob("*.py"):
        for node in parsed(file).body:
            defined = isinstance(node, ast.FunctionDef | ast.ClassDef)
            names = [node.name] if defined else assigned(node)
            for name in names:
                if not name.startswith("_"):
                    places.setdefault(name, []).append(file.relative_to(SOURCE).as_posix())
    assert len(places) > 400
    assert not {name: files for name, files in places.items() if len(files) > 1}


def test_functions_of_the_mechanics_can_be_read_at_once():
    """At most 70 lines, docstring included."""
    lengths = {
        f"{module}.{node.name}": node.end_lineno - node.lineno + 1
        for module, file in MODULES.items()
        if module.startswith("fretwear.mechanics")
        for node in ast.walk(parsed(file))
        if isinstance(node, ast.FunctionDef)
    }
    assert len(lengths) > 500
    assert not {name: lines for name, lines in lengths.items() if lines > 70}


def assigned(node):
    """Names that a statement of a module gives a value."""
    targets = getattr(node, "targets", [getattr(node, "target", None)])
    return [target.id for target in targets if isinstance(target, ast.Name)]


def test_small_values_in_si_units_are_compared_relative_to_them_alone():
    """`pytest.approx` adds 1e-12 to a tolerance, more than many a wear volume; `near` does not."""
    for folder in ("data", "mechanics", "run", "study", "cracks"):
        for file in (REPOSITORY / "tests" / folder).glob("*.py"):
            for node in ast.walk(parsed(file)):
                if isinstance(node, ast.Call) and ast.unparse(node.func) == "pytest.approx":
                    is_zero = ast.unparse(node.args[0]) == "0.0"
                    assert is_zero or "abs" in {each.arg for each in node.keywords}, file


def labels(file):
    """Texts of a source file that stand by themselves, a unit in brackets behind them aside."""
    text = file.read_text(encoding="utf-8")
    if file.suffix == ".py":
        tree = ast.parse(text)
        docstrings = {id(node.value) for node in ast.walk(tree) if isinstance(node, ast.Expr)}
        texts = (node for node in ast.walk(tree) if isinstance(getattr(node, "value", 0), str))
        found = [node.value for node in texts if id(node) not in docstrings]
    elif file.suffix == ".js":
        found = [each for _, each in re.findall(r"""(["'`])(.*?)\1""", text)]
    else:
        found = re.findall(r">([^<>{}]+)<", text)
    for each in found:
        yield re.sub(r"\s*[,(].*", "", each, flags=re.DOTALL).strip().lower()


SOURCES = [
    file
    for file in sorted(SOURCE.rglob("*"))
    if file.suffix in (".py", ".js", ".j2") and file.name != "vocabulary.py"
]


def test_results_are_called_by_their_words_everywhere():
    assert len({result.words for result in RESULTS.values()}) == len(RESULTS)
    pages = [*REPOSITORY.glob("*.md"), *(REPOSITORY / "docs").rglob("*.md"), *SOURCES]
    pages.append(REPOSITORY / "Snakefile")
    for page in pages:
        if "generated" not in page.parts and page.name != "CONTRIBUTING.md":
            text = " ".join(page.read_text(encoding="utf-8").lower().split())
            assert not [words for words in (*OTHER_WORDS, *TRANSLATED) if words in text], page
    # A label, a long name or the head of a column anywhere else would be a second table.
    words = {result.words for result in RESULTS.values()} - set(RESULTS)
    again = {file.name: words & set(labels(file)) for file in SOURCES}
    assert not {name: found for name, found in again.items() if found}


OTHER_WORDS = ("pressure in the middle", "energy dissipated per cycle", "greatest wear depth")
OTHER_WORDS += ("largest wear depth", "deepest wear depth", "maximum pressure", "half width")

# Phrases translated word by word, which came back before.
TRANSLATED = ("goes on where", "go on where", "is done and sound", "rooms of the code")
TRANSLATED += ("is to end in", "is no whole", "heat. there is none", "the caller's one of them")
TRANSLATED += ("in their order, one",)
