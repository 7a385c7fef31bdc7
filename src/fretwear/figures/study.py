"""All figures of a study by file name, with their captions and an index."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import ExitStack
from dataclasses import asdict
from itertools import chain
from pathlib import Path
from typing import NamedTuple

import xarray as xr
from matplotlib.figure import Figure

from fretwear.data.atomic import write_text
from fretwear.data.effects import GOOD, SEED, Points
from fretwear.data.files import open_case, open_loops
from fretwear.figures.effects import (
    WAYS,
    effect_map,
    effects,
    fretting_map,
    is_changing,
    parallel_coordinates,
    scatter_matrix,
    sensitivity,
)
from fretwear.figures.history import CyclePlot, representative_cases, study_curves
from fretwear.figures.index import (
    ANSWER_CATEGORY,
    HISTORIES,
    HISTORY_CATEGORY,
    INDEX_NAME,
    LEAD,
    MAP_CATEGORY,
    NARROW,
    PROFILE_CATEGORY,
    PROFILES,
    FigureEntry,
)
from fretwear.figures.maps import compare_wear_maps
from fretwear.figures.profiles import compare_bearing_areas, compare_loops, compare_profiles
from fretwear.figures.style import JournalFigure, save_figure
from fretwear.study.case import Case
from fretwear.vocabulary import HEADLINES, RESULTS

STUDY_HISTORIES = ("contact_half_width", "stick_half_width", "wear_volume", "dissipated_energy")
_OF_DISPLACEMENT = ("tangential_force", "sliding_ratio", "sliding_criterion")
STUDY_PROFILES = tuple(
    f"{field}_profiles" for field in ("pressure", "shear", "gap", "wear_rate", "wear")
)


class StudyFigure(NamedTuple):
    """A figure of a study: file name without ending, caption, category, and the figure."""

    name: str
    caption: str
    category: str
    figure: Figure | None  # None if it would show nothing; the caption then says what
    narrow: Figure | None = None  # the same for narrow screens


def of_figure(name: str, category: str, figure: Figure, where: str = "") -> StudyFigure:
    """Return a figure with its own caption, and what its cases have in common at its first stop."""
    first, *others = figure.sentences if isinstance(figure, JournalFigure) else [""]
    words = " ".join([f"{first.removesuffix('.')}{where}.", *others])
    return StudyFigure(name, words, category, figure)


def study_figures(
    summary: xr.Dataset,
    cases: Path,
    history: xr.Dataset | None = None,
    cases_by_id: Callable[[], Mapping[str, Case]] = dict,
) -> Iterator[StudyFigure]:
    """Yield the figures of a merged study, whose case files are in the folder `cases`.

    They show the effects of the parameters, results over the cycles, at every step of the
    `history`, and profiles, bearing areas and maps of a few representative cases. `cases_by_id`
    returns the cases of the study, for the heights of rough surfaces. A study without finished
    points has no figures.
    """
    if not study_curves(summary, "wear_volume"):
        return
    yield from _answer_figures(summary)
    names: tuple[str, ...] = STUDY_HISTORIES
    if "tangential_load" not in summary.coords and "tangential_load" not in summary:
        names += _OF_DISPLACEMENT
    for name in names:
        if not summary[HISTORIES[name]].fillna(0.0).any():
            continue
        plot = CyclePlot(summary, HISTORIES[name], history)
        if plot.is_constant:
            label = RESULTS[HISTORIES[name]].label
            text = f"{label} (not drawn): the same over all cycles in every case."
            yield StudyFigure(name, text, HISTORY_CATEGORY, None)
            continue
        yield of_figure(name, HISTORY_CATEGORY, plot.draw())
    chosen = representative_cases(summary)
    suffix = f"_by_{'_and_'.join(chosen.contrasts)}" if chosen.contrasts else ""
    words = "; ".join(filter(None, (chosen.common, chosen.left_out)))
    where = f" ({words})" if words else ""
    with ExitStack() as stack:
        opened = {
            title: stack.enter_context(open_case(cases / f"{case_id}.nc"))
            for title, case_id in chosen.ids.items()
        }
        for name in STUDY_PROFILES:
            figure = compare_profiles(opened, PROFILES[name])
            yield of_figure(f"{name}{suffix}", PROFILE_CATEGORY, figure, where)
        if names != STUDY_HISTORIES:
            loops = {
                title: stack.enter_context(open_loops(cases / f"{case_id}.nc"))
                for title, case_id in chosen.ids.items()
            }
            figure = compare_loops(loops)
            yield of_figure(f"fretting_loops{suffix}", PROFILE_CATEGORY, figure, where)
        is_rough = any(dataset.fretwear.case.rough for dataset in opened.values())
        # The cases of a study, which take a while to make, name the files of surfaces.
        surfaces = cases_by_id() if is_rough else {}
        rough = {
            title: dataset
            for title, dataset in opened.items()
            if (case := surfaces.get(dataset.attrs["case_id"]))
            and case.rough is not None
            and case.rough.is_known
        }
        if rough:
            figure = compare_bearing_areas(rough, surfaces)
            yield of_figure(f"bearing_area{suffix}", MAP_CATEGORY, figure, where)
        # A line contact is uniform along y and has no map.
        if all("y" in case.dims for case in opened.values()):
            figure = compare_wear_maps(opened, columns=1 if len(opened) == 1 else 2)
            yield of_figure(f"wear_map{suffix}", MAP_CATEGORY, figure, where)


def write_study_figures(
    summary: xr.Dataset,
    cases: Path,
    folder: Path,
    extra: Iterable[StudyFigure] = (),
    history: xr.Dataset | None = None,
    cases_by_id: Callable[[], Mapping[str, Case]] = dict,
) -> list[FigureEntry]:
    """Write every figure of `study_figures` as SVG and PNG to a folder, and an index of them.

    A variant for narrow screens is a PNG beside them.

    `extra` figures follow; each is drawn only when it is written. Returns the entries of the index,
    ``index.json``, which is written last.
    """
    entries = []
    for item in chain(study_figures(summary, cases, history, cases_by_id), extra):
        if item.figure is not None:
            save_figure(item.figure, folder / item.name)
        if item.narrow is not None:
            save_figure(item.narrow, folder / f"{item.name}{NARROW}", ("png",))
        entries.append(FigureEntry(item.name, item.caption, item.category, item.figure is not None))
    text = json.dumps([asdict(entry) for entry in entries], indent=1, ensure_ascii=False)
    write_text(folder / INDEX_NAME, f"{text}\n")
    return entries


def _answer_figures(summary: xr.Dataset) -> Iterator[StudyFigure]:
    """Yield the figures of the effects of the parameters that suit the design of the study."""
    points = Points.of(summary)
    if not points.levels:
        return
    differs = any(is_changing(points, name) for name in HEADLINES)
    if set(points.levels) == {SEED} or not differs:
        why = "seeds differ by chance" if differs else "results are equal in all cases"
        text = f"Effects of the parameters (not drawn): {why}."
        yield StudyFigure("effects", text, ANSWER_CATEGORY, None)
    else:
        if is_changing(points, HEADLINES[0]):
            lead = effects(points, HEADLINES[:1], columns=1)
            yield of_figure(LEAD, ANSWER_CATEGORY, lead)
        wide, narrow = effects(points), effects(points, columns=1)
        yield of_figure("effects", ANSWER_CATEGORY, wide)._replace(narrow=narrow)
    if "normal_load" in summary["status"].dims and any(n in summary["status"].dims for n in WAYS):
        yield of_figure("fretting_map", ANSWER_CATEGORY, fretting_map(summary))
    mapped = [name for name, levels in points.levels.items() if len(levels) > 2]
    if len(mapped) > 1 and all(points.lines[name] for name in mapped):
        yield of_figure("wear_volume_map", ANSWER_CATEGORY, effect_map(points))
    if not points.drawn:
        return
    if good := [n for n in HEADLINES if n in points.indices and points.indices[n].quality >= GOOD]:
        yield of_figure("sobol_indices", ANSWER_CATEGORY, sensitivity(points, good))
    if len(points.levels) > 1:
        yield of_figure("scatter_matrix", ANSWER_CATEGORY, scatter_matrix(points))
    yield of_figure("parallel_coordinates", ANSWER_CATEGORY, parallel_coordinates(points))
