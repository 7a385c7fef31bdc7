"""All figures of a study by file name, with their captions and an index."""

from __future__ import annotations

import json
import math
import re
from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import ExitStack
from dataclasses import asdict, dataclass
from itertools import chain
from pathlib import Path
from typing import NamedTuple

import xarray as xr
from matplotlib.colors import PowerNorm
from matplotlib.figure import Figure

from fretwear.data.files import open_case
from fretwear.data.safe import DataFileError, read_data, write_text
from fretwear.figures.axes import ValueAxis
from fretwear.figures.datasets import envelope_of, field_of, peak_envelope, variable_of
from fretwear.figures.history import history
from fretwear.figures.lines import (
    MOST_KEYED_COLORS,
    Array,
    Layout,
    choose_layout,
    joined,
    representative_cases,
    shown_lines,
    study_lines,
)
from fretwear.figures.maps import compare_wear_maps, depth_scale
from fretwear.figures.profiles import at_edge, compare_profiles, is_traction
from fretwear.figures.style import save_figure
from fretwear.study.parameters import parameter
from fretwear.vocabulary import Field, Variable

INDEX_NAME = "index.json"
HISTORY_CATEGORY = "Over the cycles"
PROFILE_CATEGORY = "Along the direction of slip"
MAP_CATEGORY = "Over the contact"

HISTORIES = {
    "contact_half_width": "contact_half_width_x",
    "stick_half_width": "stick_half_width_x",
    "wear_volume": "wear_volume",
    "dissipated_energy": "dissipated_energy",
}
"""Quantities over the cycles by file name."""

PROFILES = {
    "pressure_profiles": "pressure",
    "shear_profiles": "shear_traction",
    "gap_profiles": "gap",
    "wear_rate_profiles": "wear_rate",
    "wear_profiles": "wear_depth",
}
"""Fields along x by the beginning of their file name."""

_NAME = re.compile(r"\w[\w.-]*", re.ASCII)
_MOST_BYTES = 10_000_000
_MEAN_WORDS = "mean over one wavelength"


class StudyFigure(NamedTuple):
    """A figure of a study: file name without ending, caption, category, and the figure."""

    name: str
    caption: str
    category: str
    figure: Figure


@dataclass(frozen=True)
class FigureEntry:
    """What the index of a folder of figures tells of each."""

    name: str
    caption: str
    category: str


def study_figures(summary: xr.Dataset, cases: Path) -> Iterator[StudyFigure]:
    """Yield the figures of a merged study, whose case files are in the folder `cases`.

    First come the quantities of all cases over the cycles, then profiles and wear maps of a few
    representative cases. A study of which no point is done has no figures.
    """
    if not study_lines(summary, "wear_volume"):
        return
    for name, quantity in HISTORIES.items():
        caption = _history_caption(summary, variable_of(summary, quantity))
        yield StudyFigure(name, caption, HISTORY_CATEGORY, history(summary, quantity))
    cases_of = representative_cases(summary)
    suffix = f"_by_{'_and_'.join(cases_of.contrasts)}" if cases_of.contrasts else ""
    where = f" ({cases_of.common})" if cases_of.common else ""
    with ExitStack() as stack:
        opened = {
            title: stack.enter_context(open_case(cases / f"{case_id}.nc"))
            for title, case_id in cases_of.ids.items()
        }
        for name, quantity in PROFILES.items():
            caption = _profile_caption(field_of(quantity), where, opened)
            figure = compare_profiles(opened, quantity)
            yield StudyFigure(f"{name}{suffix}", caption, PROFILE_CATEGORY, figure)
        # A line contact has no map: it is the same all along y.
        if all("y" in case.dims for case in opened.values()):
            caption, figure = _map_caption(where, opened), compare_wear_maps(opened)
            yield StudyFigure(f"wear_map{suffix}", caption, MAP_CATEGORY, figure)


def write_study_figures(
    summary: xr.Dataset, cases: Path, folder: Path, extra: Iterable[StudyFigure] = ()
) -> list[FigureEntry]:
    """Write every figure of `study_figures` as SVG and PNG to a folder, and an index of them.

    `extra` figures come after those; each is drawn only when it is written. The entries returned
    are those of ``index.json``, which appears last.
    """
    entries = []
    for name, caption, category, figure in chain(study_figures(summary, cases), extra):
        save_figure(figure, folder / name)
        entries.append(FigureEntry(name, caption, category))
    text = json.dumps([asdict(entry) for entry in entries], indent=1, ensure_ascii=False)
    write_text(folder / INDEX_NAME, f"{text}\n")
    return entries


def read_figure_index(folder: Path) -> list[FigureEntry]:
    """Return what `write_study_figures` has written to a folder, in the same order.

    It raises a `DataFileError` when the index is not there or is none.
    """
    index = folder / INDEX_NAME
    try:
        entries = [FigureEntry(**entry) for entry in json.loads(read_data(index, _MOST_BYTES))]
        # A name with a path would fetch any file into the report.
        if not all(_NAME.fullmatch(each.name) and _is_text(each) for each in entries):
            raise ValueError
    except (OSError, ValueError, TypeError, RecursionError) as cause:
        problem = "there is no such file" if not index.exists() else "it is no list of figures"
        raise DataFileError(index, problem, "Draw the figures again") from cause
    return entries


def _is_text(entry: FigureEntry) -> bool:
    return isinstance(entry.caption, str) and isinstance(entry.category, str)


def captions(folder: Path) -> dict[str, str]:
    """Return the captions of finished figures as reStructuredText, for Snakemake's report.

    The template that puts them in place comes with the package: one that lay among the results
    could come from anywhere, and a template can run whatever it likes.
    """
    return {
        # Text in which reStructuredText finds no markup.
        entry.name: re.sub(r"([^\w\s]|_)", r"\\\1", " ".join(entry.caption.split()))
        for entry in read_figure_index(folder)
    }


def figure_category(folder: Path, name: str) -> str:
    """Return the category of a figure by its name."""
    return next(entry.category for entry in read_figure_index(folder) if entry.name == name)


def figure_labels(folder: Path, name: str) -> dict[str, str]:
    """Return what tells a figure in a list: its name and the first sentence of its caption."""
    caption = next(entry.caption for entry in read_figure_index(folder) if entry.name == name)
    return {"figure": name, "shows": caption.partition(". ")[0].removesuffix(".")}


def _history_caption(summary: xr.Dataset, variable: Variable) -> str:
    lines = study_lines(summary, variable.name)
    layout = choose_layout(lines)
    points = summary["status"].size if "status" in summary else len(lines)
    sentences = [
        f"{variable.label} against the number of cycles, {_cases(len(lines), points)}.",
        *_encoding(layout),
        *(
            f"Of {total} values of {parameter(name).words}, {len(layout.levels[name])} are shown."
            for name, total in layout.thinned.items()
        ),
        f"Marks are snapshots; {_axes_words(variable, *joined(shown_lines(lines, layout)))}.",
    ]
    return " ".join(sentences)


def _axes_words(variable: Variable, cycles: Array, values: Array) -> str:
    if not ValueAxis.of(variable, values).is_logarithmic:
        return "the axis of cycles is logarithmic to the right of the break"
    if (values[cycles == 0.0] > 0.0).any():
        return "both axes are logarithmic, that of cycles to the right of the break"
    return "both axes are logarithmic"


def _cases(done: int, points: int) -> str:
    if points == 1:
        return "one case"
    return f"all {done} cases" if done == points else f"{done} of {points} cases, those done"


def _encoding(layout: Layout) -> Iterator[str]:
    if layout.rows or layout.across:
        yield f"Panels: {_names([*layout.rows, *layout.across])}."
    if layout.color:
        named = len(layout.levels[layout.color]) <= MOST_KEYED_COLORS
        together = f", with {_names(layout.paired)}" if layout.paired and named else ""
        yield f"Colour: {parameter(layout.color).words}{together}."
        if layout.paired and not named:
            yield f"From line to line, {_names(layout.paired)} changes too."
    if layout.style:
        yield f"Line and filling of marks: {parameter(layout.style).words}."


def _names(names: Sequence[str]) -> str:
    *before, last = (parameter(name).words for name in names)
    return f"{', '.join(before)} and {last}" if before else last


def _profile_caption(field: Field, where: str, cases: Mapping[str, xr.Dataset]) -> str:
    sentences = [
        f"{field.label} along the direction of slip on the line nearest y = 0 at several cycles"
        f"{where}.",
        "Around the edge of the contact; grey, where it shows: stick zone at the last cycle."
        if at_edge(field)
        else "Grey: stick zone at the last cycle.",
    ]
    limits = [float(case.coords.get("plastic_limit", math.inf)) for case in cases.values()]
    if is_traction(field) and any(math.isinf(limit) for limit in limits):
        sentences.append(
            "Triangles: peaks of elastic bodies that continue above; they grow with a finer grid, "
            "without end."
        )
    if _any_rough(cases):
        has_peaks = envelope_of(field) is peak_envelope
        envelope = "envelope through the peak of every wave" if has_peaks else _MEAN_WORDS
        sentences.append(
            "Where waves crowd a profile, the thin line is the profile and the thick one its "
            f"{envelope}."
        )
    return " ".join(sentences)


def _map_caption(where: str, cases: Mapping[str, xr.Dataset]) -> str:
    sentences = [f"Wear depth of both bodies over the contact after the last cycle{where}."]
    if _any_rough(cases):
        sentences.append(
            "On a rough surface the outlines of contact and stick zone go around its asperities."
        )
    deepest = [float(case["wear_depth"].isel(cycle=-1).max()) for case in cases.values()]
    if isinstance(depth_scale(deepest), PowerNorm):
        sentences.append("Colours vary as the square root of the depth.")
    return " ".join(sentences)


def _any_rough(cases: Mapping[str, xr.Dataset]) -> bool:
    return any(float(case.coords.get("roughness_amplitude", 0.0)) > 0.0 for case in cases.values())
