"""The lists of the reference have every parameter, variable, symbol, command and material."""

import re
from pathlib import Path

import pytest
from typer.main import get_command

from fretwear.cli.program import app
from fretwear.data.files import MERGED_PROFILES
from fretwear.quantity import Quantity, declared
from fretwear.results import (
    CONTACT_SPOTS,
    CONVOLUTIONS,
    CYCLE,
    DEPTH,
    ERROR_ESTIMATE,
    FIELDS,
    LOOP,
    RESULTS,
    SCALARS,
    STEP,
    STICK_SPOTS,
    X,
    Y,
)
from fretwear.study.case import case_keys
from fretwear.study.materials import material_table
from fretwear.study.parameters import parameter
from fretwear.study.sections import study_schema
from fretwear_cracks.section import StressOutput
from fretwear_cracks.variables import CRACKS, EDGE_STRESSES, FATIGUE, STRESSES

DOCS = Path(__file__).resolve().parents[2] / "docs"
STUDY_FILE, DATASET, NOTATION, COMMANDS = (
    (DOCS / "reference" / f"{name}.md").read_text(encoding="utf-8")
    for name in ("study-file", "dataset", "notation", "command-line")
)
VARIABLES = (
    *(CYCLE, X, Y, STEP, ERROR_ESTIMATE, CONVOLUTIONS, CONTACT_SPOTS, STICK_SPOTS),
    *(*FIELDS, *SCALARS),
    *(*STRESSES, *EDGE_STRESSES, *CRACKS, *FATIGUE),
)
# A symbol stands for one quantity: given or found, of one body or the other, in one law or another.
SAME = (
    {"load", "normal_force"},
    {"indentation", "approach"},
    {"tangential_load", "tangential_force", "force"},
    {"sliding_amplitude", "slip"},
    {"cycles", "cycle"},
    {"frequency"},
    {"friction", "values"},
    {"depth", "z"},
    {"tangential_displacement", "displacement"},
    {"radius", "radii"},
    {"flat_half_width", "flat_radius"},
)


ITEM = re.compile(r"^- .*(?:\n  .*)*", re.MULTILINE)


def items(page, name):
    """Items of the lists of a page that name a key or a variable, each on one line."""
    found = re.compile(rf"`{re.escape(name)}(?:`|: )")
    return [" ".join(item.split()) for item in ITEM.findall(page) if found.search(item)]


def has_words(item, words):
    """Whether an item, which may have several variables, has all words of one of them."""
    needed, there = (re.findall(r"[^\W_]{3,}", text.lower()) for text in (words, item))
    return set(needed) <= {*there, "the", "along"}


@pytest.mark.parametrize("name", [n for n in case_keys().all_names if "counterface." not in n])
def test_every_parameter_is_in_its_list(name):
    parameter = case_keys()[name].parameter
    (item,) = (i for i in items(STUDY_FILE, name) if i.startswith(f"- `{name}: "))
    assert f"`{name}: {parameter.example}`" in item or not isinstance(parameter, Quantity)
    assert item.endswith(f": {parameter.description or f'{parameter.words.capitalize()}.'}")
    if isinstance(parameter, Quantity) and not parameter.is_whole:
        words = [("larger than", ">"), ("at least", "≥"), ("less than", "<"), ("at most", "≤")]
        limits = parameter.range_text().replace(" and ", ", ")
        for word, sign in words:
            limits = limits.replace(word, sign)
        # Other numbers are larger than zero, as the page says.
        shown = re.sub(r"([\d.]+) to (\S+?)([,)])", r"≥ \1, ≤ \2\3", item)
        assert limits == "> 0" or limits in shown


@pytest.mark.parametrize("path", [(), ("output", "stress"), ("fit", "data", "items")], ids="/".join)
def test_every_key_of_a_study_is_in_a_list_alone_with_its_meaning(path):
    schema = study_schema()
    for key in path:
        schema = schema[key] if key == "items" else schema["properties"][key]
    for name, part in schema["properties"].items():
        shared = [item for item in items(STUDY_FILE, name) if item.count("`") > 2]
        assert shared or part["description"] in " ".join(items(STUDY_FILE, name)), name


@pytest.mark.parametrize("variable", VARIABLES, ids=lambda variable: variable.name)
def test_every_variable_is_in_its_list(variable):
    symbol = variable.symbol if variable.symbol.startswith("$") else ""
    assert any(
        symbol in item
        and (not variable.si_unit or re.search(rf"[ (]{variable.si_unit}\)", item))
        and has_words(item, variable.words)
        and has_words(item, variable.comment)
        for item in items(DATASET, variable.name)
    )


def test_every_profile_and_material_is_on_its_page():
    assert all(f"`{name}`" in DATASET for name in MERGED_PROFILES)
    page = (DOCS / "how-to" / "materials.md").read_text(encoding="utf-8")
    lists = [" ".join(item.split()) for item in ITEM.findall(page)]
    for name, modulus, ratio, hardness, source in (r.values() for r in material_table().values()):
        authors, _, remark = source.rstrip(")").partition(" (")
        remarks = "; ".join(filter(None, (remark, hardness and f"hardness {hardness}")))
        entry = f"`{name}` {modulus.removesuffix(' GPa')}, {ratio}"
        entry += f" ({remarks})" if remarks else ""
        (listed,) = (item for item in lists if re.search(rf"[:;] {re.escape(entry)}(;|$)", item))
        assert authors.split()[0] in listed


def quantities():
    """Every quantity of files and datasets that has a symbol: its names and its declarations."""
    listed = [(name, case_keys()[name].parameter) for name in case_keys().all_names]
    forms = (form for _, quantity in listed for form in getattr(quantity, "forms", ()))
    listed += [item for form in forms for item in declared(form).items()]
    listed += [(name, parameter(name)) for name in ("hertz_radius", "hertz_pressure")]
    listed += StressOutput.parameters().items()
    variables = (X, Y, CYCLE, DEPTH, *RESULTS.values(), *LOOP, *STRESSES, *CRACKS, *FATIGUE)
    listed += [(one.name, one) for one in variables]
    return [(name, quantity) for name, quantity in listed if quantity.symbol.startswith("$")]


def test_every_symbol_is_in_the_list_of_its_parameter_or_in_the_notation():
    for name, quantity in quantities():
        key = name.replace("counterface.", "roughness.")
        listed = (*items(STUDY_FILE, key), *items(DATASET, key))
        assert any(quantity.symbol in item for item in listed) or is_symbol(quantity.symbol), name
    for symbol in ("$P^*$", "$g^*$", "$κ$", r"$β_\mathrm{D}$", "$τ$"):  # of equations alone
        assert is_symbol(symbol), symbol


def is_symbol(symbol):
    """Whether the notation explains a symbol."""
    return re.search(rf"^- {re.escape(symbol)}[,:]", NOTATION, re.MULTILINE) is not None


def test_no_symbol_stands_for_two_quantities():
    for symbol in {quantity.symbol for _, quantity in quantities()}:
        names = {
            name.rpartition(".")[2] for name, quantity in quantities() if quantity.symbol == symbol
        }
        assert len(names) == 1 or any(names <= same for same in SAME), symbol


def test_every_command_has_its_options_in_the_reference():
    for name, command in get_command(app).commands.items():
        parts = [p.opts[0] if p.param_type_name == "option" else p.metavar for p in command.params]
        words, *_ = command.help.splitlines()
        arguments = sorted(parts, key=lambda part: part.startswith("-"))
        assert f"- `{' '.join([name, *arguments])}`: {words.strip()}\n" in COMMANDS
