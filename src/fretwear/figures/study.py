"""All figures of a merged study: names, captions, drawing, an index of the folder."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterable, Iterator, Mapping
from concurrent.futures import ProcessPoolExecutor
from contextlib import ExitStack
from functools import partial
from itertools import islice, zip_longest
from pathlib import Path
from typing import NamedTuple

import xarray as xr
from matplotlib.figure import Figure

from fretwear.data.atomic import write_text
from fretwear.data.files import open_case, open_loops
from fretwear.figures.datasets import history_of, width_names
from fretwear.figures.history import coating_life, is_constant, representative_cases, scalar_history
from fretwear.figures.maps import WAYS, fretting_map, wear_map
from fretwear.figures.profiles import field_profiles, fretting_loops
from fretwear.figures.style import JournalFigure, save_as
from fretwear.results import PointStatus

_AREAS = ("contact_area", "stick_area", "exposed_area")
_OF_DISPLACEMENT = ("tangential_force", "sliding_ratio", "sliding_criterion")
# Profiles of every study, and of one with a surface that is measured or random, by file names.
_ALWAYS = {"pressure": "pressure", "shear": "shear_traction", "wear": "wear_depth"}
_OF_SURFACES = {"gap": "gap", "wear_rate": "wear_rate"}
_WITHOUT_PATTERN = ("measured", "self_affine")


LARGE = 1_000_000
"""Bytes of a vector figure beyond which a report embeds its bitmap."""


class StudyFigure(NamedTuple):
    """A figure of a study: file name without ending, caption, figure."""

    name: str
    caption: str
    figure: Figure


def study_figures(
    summary: xr.Dataset, cases: Path, first: int = 0, step: int = 1
) -> Iterator[StudyFigure]:
    """Yield the figures of a merged study, whose case files are in the folder `cases`.

    They show the regimes of slip over load and displacement; results at every step; profiles and
    maps of a few representative cases and, of measured and random surfaces, gap and wear rate. A
    study without finished points has no figures. Only the `first` and every `step`-th figure after
    it are drawn.
    """
    for name, draw, common in islice(_drawings(summary, cases), first, None, step):
        figure, where = draw(), f" ({common})" if common else ""
        start, *others = figure.sentences if isinstance(figure, JournalFigure) else [""]
        caption = " ".join([f"{start.removesuffix('.')}{where}.", *others])
        yield StudyFigure(name, caption, figure)


def _drawings(summary: xr.Dataset, cases: Path) -> Iterator[tuple[str, Callable[[], Figure], str]]:
    """Yield name, drawing and what the cases have in common, of every figure of a study."""
    if not (summary["status"] == PointStatus.DONE).any():
        return
    dims = summary["status"].dims
    if "normal_load" in dims and any(name in dims for name in WAYS):
        yield "fretting_map", partial(fretting_map, summary), ""
    # The tangential force is a result if a displacement is given.
    is_moved = "tangential_load" not in summary.coords and "tangential_load" not in summary
    results = [*width_names(summary), *_AREAS, "wear_volume", "dissipated_energy"]
    history = history_of(summary).load()
    for result in (*results, *(_OF_DISPLACEMENT if is_moved else ())):
        if result in summary and not is_constant(summary, result):
            draw = partial(scalar_history, summary, result, history)
            yield result.removesuffix("_x"), draw, ""
    lives = summary.get("worn_through_cycle")
    if lives is not None and lives.notnull().any() and summary["coating_thickness"].size > 1:
        yield "coating_life", partial(coating_life, summary), ""
    chosen = representative_cases(summary)
    paths = {title: cases / f"{case_id}.nc" for title, case_id in chosen.ids.items()}
    suffix = f"_by_{'_and_'.join(chosen.contrasts)}" if chosen.contrasts else ""
    for name, draw_cases in _drawings_of_cases(paths, is_moved=is_moved):
        yield f"{name}{suffix}", draw_cases, chosen.common


def _drawings_of_cases(
    paths: Mapping[str, Path], *, is_moved: bool
) -> Iterator[tuple[str, Callable[[], Figure]]]:
    """Yield names and drawings of figures that show several cases, by their titles."""
    with ExitStack() as stack:
        opened = {title: stack.enter_context(open_case(path)) for title, path in paths.items()}
        roughnesses = [
            json.loads(case.attrs["parameters"]).get("roughness") for case in opened.values()
        ]
        is_surface = any(rough and rough.get("kind") in _WITHOUT_PATTERN for rough in roughnesses)
        for name, field in {**_ALWAYS, **(_OF_SURFACES if is_surface else {})}.items():
            yield f"{name}_profiles", partial(field_profiles, opened, field)
        if is_moved:
            loops = {title: stack.enter_context(open_loops(path)) for title, path in paths.items()}
            yield "fretting_loops", partial(fretting_loops, loops)
        if all("y" in case.dims for case in opened.values()):  # a line contact is uniform along y
            yield "wear_map", partial(wear_map, opened)


def write_study_figures(
    summary: xr.Dataset,
    cases: Path,
    folder: Path,
    extra: Iterable[StudyFigure] = (),
    processes: int = 1,
) -> list[dict[str, str]]:
    """Write every figure of `study_figures`, then `extra` ones, as SVG, and an index.

    A figure of more than 1 MB is also written as PNG, which the report shows in its place.

    Each of several processes draws its share of them. Returns the entries of the index,
    ``index.json``, which is written last: name and caption.
    """
    write = partial(_write_share, summary.load(), cases, folder, processes)
    with ProcessPoolExecutor(processes) as pool:
        others = [pool.submit(write, first) for first in range(1, processes)]
        added = [_write(folder, drawn) for drawn in extra]
        shares = [write(0), *(share.result() for share in others)]
    entries = [entry for turn in zip_longest(*shares) for entry in turn if entry] + added
    write_text(folder / "index.json", f"{json.dumps(entries, indent=1, ensure_ascii=False)}\n")
    return entries


def _write_share(
    summary: xr.Dataset, cases: Path, folder: Path, processes: int, first: int
) -> list[dict[str, str]]:
    return [_write(folder, drawn) for drawn in study_figures(summary, cases, first, processes)]


def _write(folder: Path, drawn: StudyFigure) -> dict[str, str]:
    path = folder / f"{drawn.name}.svg"
    save_as(drawn.figure, path)
    bitmap = path.with_suffix(".png")
    bitmap.unlink(missing_ok=True)
    if path.stat().st_size > LARGE:
        save_as(drawn.figure, bitmap)
    return {"name": drawn.name, "caption": drawn.caption}
