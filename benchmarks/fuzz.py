"""Change files, and see that every reader takes them or refuses them by a sentence.

``python -m benchmarks.fuzz`` writes the table of docs/reliability.md; ``--share 0.01`` tries a
hundredth. Atheris, that is libFuzzer, changes the files and keeps those that lead to lines of
fretwear and of the YAML reader that none has led to before. Study files are compared, value by
value and type by type, with what another reader, PyYAML with the core schema of YAML 1.2, makes of
the same text. Files with a checksum get one that fits. Each kind of file is read in a process of
its own, because the libraries of netCDF may crash on what they read.
"""

from __future__ import annotations

import argparse
import contextlib
import functools
import json
import math
import os
import random
import re
import sys
import tempfile
import time
import traceback
import warnings
from collections import Counter
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import atheris
import numpy as np
import yaml

with atheris.instrument_imports(include=["fretwear", "ruamel"]):
    from fretwear.data import files
    from fretwear.data.effects import results_table
    from fretwear.data.excerpts import Excerpt, ExcerptError
    from fretwear.data.export import WRITERS, ExportError
    from fretwear.data.files import _LENGTH, add_checksum, open_case, open_history, open_summary
    from fretwear.data.merge import merge_study
    from fretwear.data.safe import DataFileError
    from fretwear.figures.index import FigureEntry, read_figure_index
    from fretwear.running.batch import Checkpoint, identity_of, read_checkpoint, simulate_to_file
    from fretwear.running.simulate import run
    from fretwear.running.workflow import (
        failures,
        is_finished,
        log_end,
        record,
        spent_on_simulations,
        write_finished,
    )
    from fretwear.study.problems import StudyError
    from fretwear.study.reading import load_study
    from fretwear.study.study import Study
    from fretwear.study.yamlfile import read_document
    from fretwear_cracks import fatigue
    from fretwear_cracks.inputs import StressError
    from fretwear_cracks.results import open_stresses, stress, write_stresses
    from fretwear_fit.runs import Runs
    from fretwear_fit.search import fit
    from fretwear_fit.section import fit_figures, fit_sections

from .faults import SCAR, STUDY, write_rows, write_study

REPOSITORY = Path(__file__).parents[1]
BEGIN, END = "<!-- written by python -m benchmarks.fuzz -->\n", "<!-- end of fuzz -->"
LONGEST_SECONDS = 20
UNKNOWN = "a syntax of YAML 1.2 that PyYAML does not know"
ENDINGS = ("accepted", "refused", "traceback", "differs", "unknown", "crash")
REFUSALS = (DataFileError, ExcerptError, StudyError)

# fmt: off
ODD = (
    "010", "0o17", "0x1F", "0b11", "1_000", "0:30.5", "1e3", "1E-3", ".5", "5.", "-.5e+7", "+3",
    "--3", ".inf", "-.Inf", ".NAN", "~", "null", "Null", "nil", "yes", "No", "on", "True", "FALSE",
    "y", "1e400", "1e-400", "-0", "-0.0", "''", '"7"', "'0x7'", "!!str 3", "!!int '3'", "!!float 3",
    "!!bool true", "!!null ''", "2001-12-14", "12:30:45", "１２", "٣", "50 N", "208 GPa", "50N",
    "5 µm", "[]", "{}", "[1, 2", "{a: 1}", "[0, 010, 100]", "&a 3", "*a", "<<", "=", "|", ">",
    "|\n  x", "# no", "'", '"', "@x", "`", "%", "!x y", "9" * 400, "0." + "3" * 400, "1e", "e1",
    "0x", "0o8", "+.inf", ".", "-",
)
SYNTAX = (
    ":", " ", "\n", "\t", "#", "-", "[", "]", "{", "}", ",", "'", '"', "&", "*", "!", "|", ">", "%",
    "?", "\r", "\0", "\x85", "\u2028", "\ufeff", "\x1b", "é", "---\n", "...\n", "  ",
)
# fmt: on


class CoreLoader(yaml.SafeLoader):
    """PyYAML with the core schema of YAML 1.2 (section 10.3.2); anchors may be given again."""

    def compose_node(self, parent: Any, index: Any) -> Any:
        """Forget an anchor that is given again."""
        if not self.check_event(yaml.AliasEvent):
            self.anchors.pop(self.peek_event().anchor, None)
        return super().compose_node(parent, index)


def _integer(loader: Any, node: Any) -> int:
    text = loader.construct_scalar(node)
    return int(text, {"0o": 8, "0x": 16}.get(text[:2], 10)) if text[:1] == "0" else int(text)


CoreLoader.yaml_implicit_resolvers = {}
for _tag, _form, _read in (
    ("null", r"|~|null|Null|NULL", lambda *_: None),
    ("bool", r"true|True|TRUE|false|False|FALSE", lambda _, node: node.value.lower() == "true"),
    ("int", r"[-+]?[0-9]+|0o[0-7]+|0x[0-9a-fA-F]+", _integer),
    (
        "float",
        r"[-+]?(\.[0-9]+|[0-9]+(\.[0-9]*)?)([eE][-+]?[0-9]+)?|[-+]?\.(inf|Inf|INF)|\.(nan|NaN|NAN)",
        lambda _, node: float(re.sub(r"\.(?=[inIN])", "", node.value)),
    ),
):
    CoreLoader.add_implicit_resolver(f"tag:yaml.org,2002:{_tag}", re.compile(f"({_form})$"), None)
    CoreLoader.add_constructor(f"tag:yaml.org,2002:{_tag}", _read)


def changed_text(text: str, chance: random.Random) -> str:
    """A study with one to three changes: a value, a line, a character."""
    for _ in range(chance.randint(1, 3)):
        how, lines = chance.random(), text.split("\n")
        at = chance.randrange(len(lines))
        if how < 0.6:  # another value
            values = list(re.finditer(r"(?<=[:,\[] )[^\n,\[\]{}#]+|(?<=\[)[^\n,\[\]{}#]+", text))
            if values:
                place = chance.choice(values)
                text = text[: place.start()] + chance.choice(ODD) + text[place.end() :]
        elif how < 0.75:  # a digit or a character more
            place = chance.randrange(len(text) + 1)
            text = text[:place] + chance.choice(SYNTAX + tuple("0123456789_.eE+-x")) + text[place:]
        elif how < 0.85:
            place = chance.randrange(len(text))
            text = text[:place] + text[place + chance.randint(1, 4) :]
        elif how < 0.95:
            lines.insert(
                chance.randrange(len(lines) + 1), chance.choice((lines[at], lines[at][1:]))
            )
            text = "\n".join(lines)
        else:
            del lines[at]
            text = "\n".join(lines)
        text = text or "a"
    return text


def same(one: Any, other: Any) -> bool:
    """Whether two plain values are equal and of the same types."""
    if type(one) is not type(other):
        return False
    if isinstance(one, dict):
        return list(one) == list(other) and all(map(same, one.values(), other.values()))
    if isinstance(one, list):
        return len(one) == len(other) and all(map(same, one, other))
    return one == other or (isinstance(one, float) and math.isnan(one) and math.isnan(other))


def expected_of(text: str) -> Any:
    """Read a text by PyYAML; None where its syntax is one of YAML 1.2 that PyYAML does not know."""
    for each in (text, text.replace("\t", " ")):  # tabs separate as well
        try:
            return yaml.load(each, CoreLoader)
        except yaml.YAMLError:
            continue
        except ValueError as refused:
            return refused
    return None


def read_study(file: Path) -> str:
    """Read a study file and compare; return the difference."""
    document = read_document(file)
    if not document.problems:
        text = file.read_bytes().decode("utf-8-sig")
        data, expected = document.data, expected_of(text)
        if expected is None:
            return UNKNOWN
        if not same(data, expected):
            return f"{text!r}\n{data}\n{expected!r}"
    load_study(file)
    return ""


def of_parameters(file: Path, case: Any) -> str:
    """Read a checkpoint."""
    read_checkpoint(file, identity_of(case))
    return ""


def read_case(file: Path) -> str:
    """Read a case file as a user would."""
    with open_case(file, full=True) as case, open_history(file) as history:
        case.load()
        history.load()
    return ""


def read_excerpt(file: Path) -> str:
    """Read the excerpt at the end of a case file, which merging takes."""
    excerpt = Excerpt.from_bytes(file.read_bytes())
    again = Excerpt.from_bytes(excerpt.to_bytes())
    return "" if again.to_bytes() == excerpt.to_bytes() else "another excerpt"


def read_summary(file: Path) -> str:
    """Read a merged study as a user would."""
    with open_summary(file) as summary:
        results_table(summary)
    return ""


def read_records(file: Path) -> str:
    """Read the small files beside the results, each with this content."""
    content, folder = file.read_bytes(), file.parent
    for name in (
        "logs/simulate/a.failed.json",
        "benchmarks/b/a.tsv",
        "batches/b.json",
        "index.json",
    ):
        (folder / name).parent.mkdir(parents=True, exist_ok=True)
        (folder / name).write_bytes(content)
    (folder / "logs/simulate/a.log").write_bytes(content)
    found = failures(folder)
    log_end(folder, "a")
    spent_on_simulations(folder)
    is_finished(folder / "batches/b.json", ["a"], {"a": (1, 1.0)})
    entries = read_figure_index(folder)
    if set(found) - {"a"} or any("/" in entry.name for entry in entries):
        return "a name of another place"
    return ""


def read_readings(file: Path) -> str:
    """Read the study whose measurement has this content."""
    (file.parent / "scar.csv").write_bytes(file.read_bytes())
    load_study(file.parent / "two.yaml")
    return ""


def read_run(file: Path, study: Study) -> str:
    """Read a run that a fit has kept; one that is none is run again."""
    folder = file.parent / "fit.runs"
    folder.mkdir(exist_ok=True)
    (folder / "kept.json").write_bytes(file.read_bytes())
    (case, *_) = study.cases().values()
    runs = Runs([("wear_depth", "x")], folder)
    if runs._known("kept", case) and not np.isfinite(runs.done["kept"].loops[0]).all():
        return "a loop that is not finite"
    return ""


def read_fit(file: Path, name: str, reader: Callable[..., Any]) -> str:
    """Read one of the two files of a fit for the report or for figures; the other is whole."""
    (file.parent / name).write_bytes(file.read_bytes())
    for _ in reader(None, file.parent / "cases"):
        pass
    return ""


def read_stresses(file: Path, case: Path, study: Study) -> str:
    """Merge the fatigue of a case, and export its stresses, as a user would."""
    folder = file.parent / "fatigue"
    folder.mkdir(exist_ok=True)
    (folder / case.name).write_bytes(file.read_bytes())
    assert study.stress is not None
    fatigue.fatigue_of_study(folder, study.stress, str)(case, np.array([0.0, 20.0]))
    with open_stresses(file) as stresses:
        for ending, write in WRITERS.values():
            with contextlib.suppress(ExportError):
                write(stresses, file.with_suffix(ending))
    return ""


def _computed_again(*_: object, **__: object) -> None:
    raise StressError("what is no fatigue of this case is computed again")


def attempt(read: Callable[[Path], str], file: Path) -> tuple[str, str]:
    """Read a file; return whether it was accepted or refused, or else the error."""
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            difference = read(file)
    except REFUSALS as refusal:
        return ("refused", "") if str(refusal).encode() else ("traceback", "nothing said")
    except Exception as error:
        if str(error).startswith("NetCDF: "):  # of fields, which xarray reads when they are used
            return "refused", ""
        return "traceback", traceback.format_exc()[-2000:]
    if difference == UNKNOWN:
        return "unknown", ""
    return ("differs", difference) if difference else ("accepted", "")


def trials(read: Callable[[Path], str], corpus: list[bytes], count: int, *, is_text: bool,
           has_checksum: bool, folder: Path, seed: int) -> Counter[str]:  # fmt: skip
    """Read changed files in a process of their own, another one after a crash; count the ends."""
    found: Counter[str] = Counter()
    start, file = Path(tempfile.mkdtemp(dir=folder)), folder / "changed.yaml"
    for number, content in enumerate(corpus):
        (start / str(number)).write_bytes(content)

    def answer_to(content: bytes) -> tuple[str, str]:
        file.write_bytes(content)
        if has_checksum:
            add_checksum(file)
        return attempt(read, file)

    def change(content: bytes, most: int, number: int) -> bytes:
        chance = random.Random(number)
        if chance.random() < 0.1:
            return bytes(atheris.Mutate(content, most))
        # Half of the files are changed again, the others start from the original.
        again = content if chance.random() < 0.5 else chance.choice(corpus)
        text = changed_text(again.decode(errors="replace"), chance)
        return text.encode("utf-8", "surrogatepass")[:most]

    # The children find everything imported.
    for content in corpus:
        answer_to(content)
    while found.total() < count:
        get, put = os.pipe()
        child = os.fork()
        if child == 0:
            os.close(get)
            os.dup2(os.open(folder / "libfuzzer.log", os.O_WRONLY | os.O_CREAT | os.O_TRUNC), 2)
            say = functools.partial(print, file=os.fdopen(put, "w"), flush=True)
            options = {
                "runs": count - found.total(), "seed": seed + found.total(), "len_control": 0,
                "timeout": LONGEST_SECONDS, "verbosity": 0, "artifact_prefix": f"{folder}/",
            }  # fmt: skip
            atheris.Setup(
                ["fuzz", *(f"-{name}={value}" for name, value in options.items()), str(start)],
                lambda content, say=say: say(json.dumps(answer_to(content))),
                **({"custom_mutator": change} if is_text else {}),
            )
            atheris.Fuzz()
        os.close(put)
        with os.fdopen(get) as answers:
            for line in answers:
                how, told = json.loads(line)
                found[how] += 1
                if told:
                    print(told, flush=True)
        status = os.waitstatus_to_exitcode(os.waitpid(child, 0)[1])
        if status:
            found["crash"] += 1
            said = (folder / "libfuzzer.log").read_text(errors="replace")
            print(f"ended by {status} after {found.total()}: {said[-2000:]}", flush=True)
    return found


def kinds(
    folder: Path,
) -> Iterator[tuple[str, Callable[[Path], str], list[bytes], int, bool, bool]]:
    """Yield the targets: name, reader, files, how many, text or not, sealed or not."""
    write_study(folder)
    study = load_study(folder / "two.yaml")
    results = folder / "results"
    case = None
    for case_id, case in study.cases().items():
        simulate_to_file(case, results / f"cases/{case_id}.nc", tell=lambda _: None, command="")
    merge_study(study, results / "cases", results / "summary.nc")
    assert case is not None
    checkpoint = Checkpoint(results / "a.checkpoint", case, print)
    run(case, [checkpoint], record=checkpoint.record)
    checkpoint.save()
    write_finished(results / "batches/b.json", results / "cases", list(study.cases()))
    record(results, "a", "the wheel came off")
    entries = [vars(FigureEntry("wear", "A caption.", "profiles"))]
    small = [
        (results / "batches/b.json").read_bytes(),
        (results / "logs/simulate/a.failed.json").read_bytes(),
        json.dumps(entries).encode(),
        b"s\th:m:s\tmax_rss\tcpu_time\n1.5\t0:00:01\t100.2\t1.4\n",
    ]
    texts = [STUDY.encode(), *(f.read_bytes() for f in (REPOSITORY / "studies").glob("*.yaml"))]
    fitted = fit(study, folder=folder / "kept")
    fitted.write(folder / "fit.nc")
    fitted.write_json(folder / "fit.json")
    assert study.stress is not None
    (path, *_) = (results / "cases").glob("*.nc")
    fatigue.stored_fatigue(path, results / "below/fatigue.nc", study.stress)
    with open_case(path, full=True) as ds:
        write_stresses(stress(ds, depths=["0.1 mm"], phases=4), results / "below/stresses.nc")
    fatigue.fatigue = _computed_again
    fits = [(folder / "fit.nc").read_bytes()[:-_LENGTH]]
    records = [(folder / "fit.json").read_bytes()]
    excerpts = [files.read_excerpt(path).to_bytes() for path in (results / "cases").glob("*.nc")]
    kept = [path.read_bytes() for path in sorted((folder / "kept").glob("*.json"))[:3]]
    sealed = {
        name: [path.read_bytes()[:-_LENGTH] for path in results.glob(name)]
        for name in ("cases/*.nc", "summary.nc", "*.checkpoint", "below/*.nc")
    }
    of_case = functools.partial(of_parameters, case=case)
    of_stresses = functools.partial(read_stresses, case=path, study=study)
    of_run = functools.partial(read_run, study=study)
    of_report = functools.partial(read_fit, name="fit.json", reader=fit_sections)
    of_figures = functools.partial(read_fit, name="fit.nc", reader=fit_figures)
    yield "study files, values and lines", read_study, texts, 10_000, True, False
    yield "study files, bytes", read_study, texts, 5_000, False, False
    yield "batches, index, records, tables, logs", read_records, small, 50_000, False, False
    yield "checkpoints", of_case, sealed["*.checkpoint"], 20_000, False, True
    yield "case files", read_case, sealed["cases/*.nc"], 10_000, False, True
    yield "excerpts of case files", read_excerpt, excerpts, 20_000, False, False
    yield "summaries", read_summary, sealed["summary.nc"], 5_000, False, True
    yield "readings of a measurement", read_readings, [SCAR.encode()], 3_000, True, False
    yield "fits, record", of_report, records, 5_000, True, False
    yield "fits, kept runs", of_run, kept, 5_000, True, False
    yield "fits, distributions", of_figures, fits, 3_000, False, True
    yield "stresses and fatigue", of_stresses, sealed["below/*.nc"], 1_000, False, True


def main() -> None:
    """Try all readers and write the table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--share", type=float, default=1.0, help="how much of all is tried")
    parser.add_argument("--only", default="", help="files whose name holds these words")
    parser.add_argument("--seed", type=int, default=1)
    options = parser.parse_args()
    rows, harm = {}, 0
    with tempfile.TemporaryDirectory() as place:
        folder = Path(place)
        for name, read, corpus, most, is_text, has_checksum in kinds(folder):
            if options.only not in name:
                continue
            begun, count = time.monotonic(), math.ceil(options.share * most)
            found = trials(
                read, corpus, count,
                is_text=is_text, has_checksum=has_checksum, folder=folder, seed=options.seed,
            )  # fmt: skip
            ended = [found[each] for each in ENDINGS]
            harm += found["traceback"] + found["differs"]
            minutes = (time.monotonic() - begun) / 60.0
            rows[name] = f"| {name} | {count} | {' | '.join(map(str, ended))} | {minutes:.1f} |"
            print(rows[name], flush=True)
    if options.share == 1.0:
        head = (
            "| files | tried | accepted | refused with a message | tracebacks | other values "
            "| not compared | crashes of a library | minutes |\n|---" + "|---:" * 8 + "|\n"
        )
        write_rows(BEGIN, head, rows, END)
    sys.exit(harm > 0)


if __name__ == "__main__":
    main()
