"""All figures of a merged study: names, captions, drawing, an index of the folder."""

from __future__ import annotations

import json
import os
from collections.abc import Callable, Iterable, Iterator, Mapping
from concurrent.futures import ProcessPoolExecutor
from contextlib import ExitStack
from dataclasses import asdict, dataclass
from functools import partial
from multiprocessing import get_context
from pathlib import Path
from typing import Any, NamedTuple

import xarray as xr
from matplotlib.figure import Figure

from fretwear.data.atomic import write_text
from fretwear.data.effects import GOOD, SEED, Points
from fretwear.data.files import open_case, open_loops
from fretwear.figures.datasets import width_names
from fretwear.figures.effects import (
    WAYS,
    effects,
    fretting_map,
    is_changing,
    sensitivity,
)
from fretwear.figures.history import is_constant, representative_cases, scalar_history
from fretwear.figures.index import (
    ANSWER_CATEGORY,
    HISTORIES,
    HISTORY_CATEGORY,
    INDEX_NAME,
    LEAD,
    MAP_CATEGORY,
    PROFILE_CATEGORY,
    PROFILES,
    FigureEntry,
)
from fretwear.figures.maps import compare_wear_maps
from fretwear.figures.profiles import compare_bearing_areas, compare_loops, compare_profiles
from fretwear.figures.style import JournalFigure, save_figure
from fretwear.results import PointStatus, headlines
from fretwear.study.case import Case

_OF_DISPLACEMENT = ("tangential_force", "sliding_ratio", "sliding_criterion")
# Profiles of every study, and of one with a surface that is measured or random.
_ALWAYS, _OF_SURFACES = ("pressure", "shear", "wear"), ("gap", "wear_rate")
_WITHOUT_PATTERN = ("measured", "self_affine")


class StudyFigure(NamedTuple):
    """A figure of a study that is there: file name without ending, caption, category, figure."""

    name: str
    caption: str
    category: str
    figure: Figure


@dataclass(frozen=True)
class Drawing:
    """A figure of a study that can be drawn in any process."""

    name: str  # of its files, without ending
    category: str
    function: Callable[..., Figure]
    arguments: tuple[Any, ...]
    common: str = ""  # what its cases have in common

    def draw(self) -> StudyFigure:
        """Draw it; its cases are opened from their files."""
        with ExitStack() as stack:
            figure = self.function(*(_opened(argument, stack) for argument in self.arguments))
        first, *others = figure.sentences if isinstance(figure, JournalFigure) else [""]
        where = f" ({self.common})" if self.common else ""
        words = " ".join([f"{first.removesuffix('.')}{where}.", *others])
        return StudyFigure(self.name, words, self.category, figure)


@dataclass(frozen=True)
class Files:
    """Files of cases by the titles of the cases, and the function that opens one."""

    paths: Mapping[str, Path]
    open_file: Callable[[Path], xr.Dataset] = open_case


def _opened(argument: Any, stack: ExitStack) -> Any:
    if not isinstance(argument, Files):
        return argument
    opened = {title: argument.open_file(path) for title, path in argument.paths.items()}
    return {title: stack.enter_context(case) for title, case in opened.items()}


def study_figures(
    summary: xr.Dataset,
    cases: Path,
    history: xr.Dataset | None = None,
    cases_by_id: Callable[[], Mapping[str, Case]] = dict,
) -> list[Drawing]:
    """Return the figures of a merged study, whose case files are in the folder `cases`.

    They show effects of the parameters; results over the cycles, at every step of the `history`;
    profiles and maps of a few representative cases and, of measured and random surfaces, gap, wear
    rate and bearing area. `cases_by_id` returns the cases of the study, which name the files of
    surfaces. A study without finished points has no figures.
    """
    if not (summary["status"] == PointStatus.DONE).any():
        return []
    answers, over_cycles = _effects(summary), _histories(summary, history)
    return [*answers, *over_cycles, *_profiles_and_maps(summary, cases, cases_by_id)]


def _effects(summary: xr.Dataset) -> Iterator[Drawing]:
    points, category = Points.of(summary), ANSWER_CATEGORY
    if set(points.levels) <= {SEED}:
        return
    changing = [name for name in headlines(summary) if is_changing(points, name)]
    for name, results in ((LEAD, changing[:1]), ("effects", changing[1:])):
        if results:
            yield Drawing(name, category, effects, (points, results))
    dims = summary["status"].dims
    if "normal_load" in dims and any(name in dims for name in WAYS):
        yield Drawing("fretting_map", category, fretting_map, (summary,))
    good = [n for n in changing if n in points.indices and points.indices[n].quality >= GOOD]
    if good:
        yield Drawing("sobol_indices", category, sensitivity, (points, good))


def _histories(summary: xr.Dataset, history: xr.Dataset | None) -> Iterator[Drawing]:
    names = [*width_names(summary), "wear_volume", "dissipated_energy"]
    if _is_moved(summary):
        names += _OF_DISPLACEMENT
    files = {result: name for name, result in HISTORIES.items()}
    for name in names:
        if name in summary and not is_constant(summary, name):
            arguments = (summary, name, history)
            yield Drawing(files[name], HISTORY_CATEGORY, scalar_history, arguments)


def _is_moved(summary: xr.Dataset) -> bool:
    """Whether the tangential force is a result, since a displacement is given."""
    return "tangential_load" not in summary.coords and "tangential_load" not in summary


def _profiles_and_maps(
    summary: xr.Dataset, folder: Path, cases_by_id: Callable[[], Mapping[str, Case]]
) -> Iterator[Drawing]:
    chosen = representative_cases(summary)
    paths = {title: folder / f"{case_id}.nc" for title, case_id in chosen.ids.items()}
    suffix = f"_by_{'_and_'.join(chosen.contrasts)}" if chosen.contrasts else ""
    cases, parameters = Files(paths), {}
    for title, path in paths.items():
        with open_case(path) as case:
            parameters[title] = json.loads(case.attrs["parameters"])
            is_point_contact = "y" in case.dims
    kinds = [about["roughness"].get("kind") for about in parameters.values() if about["roughness"]]
    is_surface = any(kind in _WITHOUT_PATTERN for kind in kinds)

    def drawing(
        name: str, category: str, function: Callable[..., Figure], *arguments: Any
    ) -> Drawing:
        return Drawing(f"{name}{suffix}", category, function, arguments, chosen.common)

    for field in (*_ALWAYS, *(_OF_SURFACES if is_surface else ())):
        name = f"{field}_profiles"
        yield drawing(name, PROFILE_CATEGORY, compare_profiles, cases, PROFILES[name])
    if _is_moved(summary):
        loops = Files(paths, open_loops)
        yield drawing("fretting_loops", PROFILE_CATEGORY, compare_loops, loops)
    if is_surface:
        by_id = cases_by_id()
        known = {t: by_id[i] for t, i in chosen.ids.items() if i in by_id}
        known = {t: case for t, case in known.items() if case.rough and case.rough.is_known}
        if known:
            rough = Files({title: paths[title] for title in known})
            yield drawing("bearing_area", MAP_CATEGORY, compare_bearing_areas, rough, known)
    if is_point_contact:  # a line contact is uniform along y
        yield drawing("wear_map", MAP_CATEGORY, compare_wear_maps, cases)


def write_study_figures(
    summary: xr.Dataset,
    cases: Path,
    folder: Path,
    extra: Iterable[StudyFigure] = (),
    history: xr.Dataset | None = None,
    cases_by_id: Callable[[], Mapping[str, Case]] = dict,
) -> list[FigureEntry]:
    """Write every figure of `study_figures`, then `extra` ones, as SVG and PNG, and an index.

    Processes, as many as processor cores, draw them side by side. Returns the entries of the index,
    ``index.json``, which is written last.
    """
    history = None if history is None else history.load()
    drawings = study_figures(summary.load(), cases, history, cases_by_id)
    workers = min(len(os.sched_getaffinity(0)), max(1, len(drawings)))
    with ProcessPoolExecutor(workers, get_context("fork")) as pool:
        entries = [*pool.map(partial(_write, folder=folder), drawings)]
    entries += [_write(item, folder=folder) for item in extra]
    text = json.dumps([asdict(entry) for entry in entries], indent=1, ensure_ascii=False)
    write_text(folder / INDEX_NAME, f"{text}\n")
    return entries


def _write(item: Drawing | StudyFigure, *, folder: Path) -> FigureEntry:
    name, words, category, figure = item.draw() if isinstance(item, Drawing) else item
    save_figure(figure, folder / name)
    return FigureEntry(name, words, category)
