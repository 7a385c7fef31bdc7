"""All figures of a merged study: names, captions, drawing, an index of the folder."""

from __future__ import annotations

import json
from collections.abc import Iterable, Iterator, Mapping
from contextlib import ExitStack
from pathlib import Path
from typing import NamedTuple

import xarray as xr
from matplotlib.figure import Figure

from fretwear.data.atomic import write_text
from fretwear.data.files import open_case, open_loops
from fretwear.figures.datasets import width_names
from fretwear.figures.history import is_constant, representative_cases, scalar_history
from fretwear.figures.index import HISTORIES, INDEX_NAME, PROFILES, FigureEntry
from fretwear.figures.maps import WAYS, compare_wear_maps, fretting_map
from fretwear.figures.profiles import compare_loops, compare_profiles
from fretwear.figures.style import JournalFigure, save_figure
from fretwear.results import PointStatus

_OF_DISPLACEMENT = ("tangential_force", "sliding_ratio", "sliding_criterion")
# Profiles of every study, and of one with a surface that is measured or random.
_ALWAYS, _OF_SURFACES = ("pressure", "shear", "wear"), ("gap", "wear_rate")
_WITHOUT_PATTERN = ("measured", "self_affine")


class StudyFigure(NamedTuple):
    """A figure of a study: file name without ending, caption, figure."""

    name: str
    caption: str
    figure: Figure


def study_figures(
    summary: xr.Dataset, cases: Path, history: xr.Dataset | None = None
) -> Iterator[StudyFigure]:
    """Yield the figures of a merged study, whose case files are in the folder `cases`.

    They show the regimes of slip over load and displacement; results over the cycles, at every step
    of the `history`; profiles and maps of a few representative cases and, of measured and random
    surfaces, gap and wear rate. A study without finished points has no figures.
    """
    if not (summary["status"] == PointStatus.DONE).any():
        return
    dims = summary["status"].dims
    if "normal_load" in dims and any(name in dims for name in WAYS):
        yield _described("fretting_map", fretting_map(summary))
    # The tangential force is a result if a displacement is given.
    is_moved = "tangential_load" not in summary.coords and "tangential_load" not in summary
    files = {result: name for name, result in HISTORIES.items()}
    results = [*width_names(summary), "wear_volume", "dissipated_energy"]
    for result in (*results, *(_OF_DISPLACEMENT if is_moved else ())):
        if result in summary and not is_constant(summary, result):
            yield _described(files[result], scalar_history(summary, result, history))
    chosen = representative_cases(summary)
    paths = {title: cases / f"{case_id}.nc" for title, case_id in chosen.ids.items()}
    suffix = f"_by_{'_and_'.join(chosen.contrasts)}" if chosen.contrasts else ""
    for name, figure in _figures_of_cases(paths, is_moved=is_moved):
        yield _described(f"{name}{suffix}", figure, chosen.common)


def _figures_of_cases(paths: Mapping[str, Path], *, is_moved: bool) -> Iterator[tuple[str, Figure]]:
    """Yield names and figures that show several cases, by their titles, side by side."""
    with ExitStack() as stack:
        opened = {title: stack.enter_context(open_case(path)) for title, path in paths.items()}
        given = [json.loads(case.attrs["parameters"]).get("roughness") for case in opened.values()]
        is_surface = any(rough and rough.get("kind") in _WITHOUT_PATTERN for rough in given)
        for field in (*_ALWAYS, *(_OF_SURFACES if is_surface else ())):
            name = f"{field}_profiles"
            yield name, compare_profiles(opened, PROFILES[name])
        if is_moved:
            loops = {title: stack.enter_context(open_loops(path)) for title, path in paths.items()}
            yield "fretting_loops", compare_loops(loops)
        if all("y" in case.dims for case in opened.values()):  # a line contact is uniform along y
            yield "wear_map", compare_wear_maps(opened)


def _described(name: str, figure: Figure, common: str = "") -> StudyFigure:
    """Name a figure; `common`, what its cases have in common, follows its first sentence."""
    first, *others = figure.sentences if isinstance(figure, JournalFigure) else [""]
    where = f" ({common})" if common else ""
    return StudyFigure(name, " ".join([f"{first.removesuffix('.')}{where}.", *others]), figure)


def write_study_figures(
    summary: xr.Dataset,
    cases: Path,
    folder: Path,
    extra: Iterable[StudyFigure] = (),
    history: xr.Dataset | None = None,
) -> list[FigureEntry]:
    """Write every figure of `study_figures`, then `extra` ones, as SVG and PNG, and an index.

    Returns the entries of the index, ``index.json``, which is written last.
    """
    entries = []
    for figures in (study_figures(summary.load(), cases, history), extra):
        for name, caption, figure in figures:
            save_figure(figure, folder / name)
            entries.append(FigureEntry(name, caption))
    content = [entry._asdict() for entry in entries]
    write_text(folder / INDEX_NAME, f"{json.dumps(content, indent=1, ensure_ascii=False)}\n")
    return entries
