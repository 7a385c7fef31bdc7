"""All figures of a study by file name, with their captions and an index."""

from __future__ import annotations

import json
import math
from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import ExitStack
from dataclasses import asdict
from itertools import chain
from pathlib import Path
from typing import NamedTuple

import xarray as xr
from matplotlib.colors import PowerNorm
from matplotlib.figure import Figure

from fretwear.data.effects import GOOD, SEED, Points
from fretwear.data.files import open_case
from fretwear.data.safe import write_text
from fretwear.figures.cracks import crack_figures
from fretwear.figures.datasets import envelope_of, field_of, peak_envelope
from fretwear.figures.effects import (
    WAYS,
    effect_map,
    effects,
    fretting_map,
    parallel_coordinates,
    scatter_matrix,
    sensitivity,
)
from fretwear.figures.history import HISTORIES, CyclePlot, representative_cases, study_curves
from fretwear.figures.index import (
    ANSWER_CATEGORY,
    CRACK_CATEGORY,
    HISTORY_CATEGORY,
    INDEX_NAME,
    MAP_CATEGORY,
    PROFILE_CATEGORY,
    FigureEntry,
)
from fretwear.figures.maps import compare_wear_maps, depth_scale
from fretwear.figures.profiles import (
    PROFILES,
    at_edge,
    compare_bearing_areas,
    compare_profiles,
    is_traction,
)
from fretwear.figures.style import save_figure
from fretwear.study.case import Case
from fretwear.vocabulary import HEADLINES, Variable

_STEADY = 1e-6
_MEAN_WORDS = "mean over one wavelength"


class StudyFigure(NamedTuple):
    """A figure of a study: file name without ending, caption, category, and the figure."""

    name: str
    caption: str
    category: str
    figure: Figure


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
    histories = dict(HISTORIES)
    force = summary["tangential_force"]
    if bool((force.max("cycle") - force.min("cycle") > _STEADY * force.max("cycle")).any()):
        histories["tangential_force"] = "tangential_force"
    for name, quantity in histories.items():
        if not summary[quantity].fillna(0.0).any():
            continue
        plot = CyclePlot(summary, quantity, history)
        yield StudyFigure(name, plot.caption, HISTORY_CATEGORY, plot.draw())
    chosen = representative_cases(summary)
    for name, caption, figure in crack_figures(summary, cases.parent / "fatigue", chosen.ids):
        yield StudyFigure(name, caption, CRACK_CATEGORY, figure)
    suffix = f"_by_{'_and_'.join(chosen.contrasts)}" if chosen.contrasts else ""
    where = f" ({chosen.common})" if chosen.common else ""
    with ExitStack() as stack:
        opened = {
            title: stack.enter_context(open_case(cases / f"{case_id}.nc"))
            for title, case_id in chosen.ids.items()
        }
        for name, quantity in PROFILES.items():
            caption = _profile_caption(field_of(quantity), where, opened) + chosen.left_out
            figure = compare_profiles(opened, quantity)
            yield StudyFigure(f"{name}{suffix}", caption, PROFILE_CATEGORY, figure)
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
            caption = (
                f"Bearing area before and after wear{where}: the share of the contact above each "
                "height of the roughness, less wear and plastic depth; 0 is the mean before."
            )
            figure = compare_bearing_areas(rough, surfaces)
            yield StudyFigure(f"bearing_area{suffix}", caption, MAP_CATEGORY, figure)
        # A line contact is uniform along y and has no map.
        if all("y" in case.dims for case in opened.values()):
            caption, figure = _map_caption(where, opened), compare_wear_maps(opened)
            yield StudyFigure(f"wear_map{suffix}", caption + chosen.left_out, MAP_CATEGORY, figure)


def write_study_figures(
    summary: xr.Dataset,
    cases: Path,
    folder: Path,
    extra: Iterable[StudyFigure] = (),
    history: xr.Dataset | None = None,
    cases_by_id: Callable[[], Mapping[str, Case]] = dict,
) -> list[FigureEntry]:
    """Write every figure of `study_figures` as SVG and PNG to a folder, and an index of them.

    `extra` figures follow; each is drawn only when it is written. Returns the entries of the index,
    ``index.json``, which is written last.
    """
    entries = []
    for name, caption, category, figure in chain(
        study_figures(summary, cases, history, cases_by_id), extra
    ):
        save_figure(figure, folder / name)
        entries.append(FigureEntry(name, caption, category))
    text = json.dumps([asdict(entry) for entry in entries], indent=1, ensure_ascii=False)
    write_text(folder / INDEX_NAME, f"{text}\n")
    return entries


def _answer_figures(summary: xr.Dataset) -> Iterator[StudyFigure]:
    """Yield the figures of the effects of the parameters that suit the design of the study."""
    points = Points.of(summary)
    if not points.levels:
        return
    volume = points.variables["wear_volume"]
    depends = "; colours show the other parameter on which the change depends most"
    paired = (
        "Final results against each parameter. A line joins cases that differ in this parameter "
        f"alone{depends if len(points.levels) > 1 else ''}."
    )
    if any(isinstance(v[-1], float) and math.isinf(v[-1]) for v in points.levels.values()):
        paired += " A limit that is none stands apart."
    scattered = "Final results of all points against each parameter: scatter plots."
    caption = paired if any(points.lines.values()) else scattered
    if set(points.levels) == {SEED}:
        caption = "Final results of all seeds, which differ by chance."
    yield StudyFigure("effects", caption, ANSWER_CATEGORY, effects(points))
    if "load" in summary["status"].dims and any(n in summary["status"].dims for n in WAYS):
        caption = (
            "Fretting map: partial, mixed and gross slip over load and displacement. Mixed slip is "
            "partial in some snapshots and gross in others; dots grow with the wear volume."
        )
        yield StudyFigure("fretting_map", caption, ANSWER_CATEGORY, fretting_map(summary))
    mapped = [name for name, levels in points.levels.items() if len(levels) > 2]
    if len(mapped) > 1 and all(points.lines[name] for name in mapped):
        caption = f"{volume.label} after the last cycle over the two parameters with most values."
        yield StudyFigure("wear_volume_map", caption, ANSWER_CATEGORY, effect_map(points))
    if not points.drawn:
        return
    if good := [n for n in HEADLINES if n in points.indices and points.indices[n].quality >= GOOD]:
        caption = (
            "Sobol indices of final results. Left: each parameter alone (full marks) and with its "
            "interactions (open), with 95 % intervals from the covariance of the emulator's "
            "coefficients. Right: indices with interactions against the number of points."
        )
        yield StudyFigure("sobol_indices", caption, ANSWER_CATEGORY, sensitivity(points, good))
    if len(points.levels) > 1:
        caption = (
            "Every point over every two parameters, and its result against each of them; colours "
            f"show the final {volume.words}."
        )
        yield StudyFigure("scatter_matrix", caption, ANSWER_CATEGORY, scatter_matrix(points))
    caption = f"Every point as a line over its parameters; its colour is the final {volume.words}."
    figure = parallel_coordinates(points)
    yield StudyFigure("parallel_coordinates", caption, ANSWER_CATEGORY, figure)


def _profile_caption(field: Variable, where: str, cases: Mapping[str, xr.Dataset]) -> str:
    is_map, is_edge = all("y" in case.dims for case in cases.values()), at_edge(field)
    on_line = " on the line nearest y = 0" if is_map else ""
    sentences = [f"{field.label} along the direction of slip{on_line} at several cycles{where}."]
    if is_edge:
        sentences.append("Around the edge of the contact.")
    # A contact that slides as a whole has no stick zone, and its pressure no peak.
    sticks = any(float(case["stick_half_width_x"].max()) > 0.0 for case in cases.values())
    if any(float(case["stick_half_width_x"][-1]) > 0.0 for case in cases.values()):
        sentences.append(
            f"Grey{', where visible' if is_edge else ''}: stick zone at the last cycle."
        )
    limits = [float(case.coords.get("plastic_limit", math.inf)) for case in cases.values()]
    if sticks and is_traction(field) and max(limits) == math.inf:
        sentences.append(
            "Triangles: peaks of elastic bodies that continue above; they grow without bound as "
            "the grid is refined."
        )
    if _any_rough(cases):
        has_peaks = envelope_of(field) is peak_envelope
        sentences.append(
            "Where waves crowd a profile, the thin line is the profile and the thick one its "
            f"{'envelope through the peak of every wave' if has_peaks else _MEAN_WORDS}."
        )
    return " ".join(sentences)


def _map_caption(where: str, cases: Mapping[str, xr.Dataset]) -> str:
    sentences = [f"Wear depth of both bodies over the contact after the last cycle{where}."]
    if _any_rough(cases, "roughness_rms_height"):
        sentences.append("Outlines on rough surfaces surround spots in contact and in stick.")
    deepest = [float(case["wear_depth"].isel(cycle=-1).max()) for case in cases.values()]
    if isinstance(depth_scale(deepest), PowerNorm):
        sentences.append("Colours vary as the square root of the depth.")
    return " ".join(sentences)


def _any_rough(cases: Mapping[str, xr.Dataset], *more: str) -> bool:
    names = ("roughness_amplitude", *more)
    return any(float(case.coords.get(n, 0.0)) > 0.0 for case in cases.values() for n in names)
