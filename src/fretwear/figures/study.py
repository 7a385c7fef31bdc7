"""All figures of a study by file name, with their captions and an index."""

from __future__ import annotations

import json
import math
from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import ExitStack
from dataclasses import asdict
from itertools import chain
from pathlib import Path
from typing import NamedTuple

import xarray as xr
from matplotlib.colors import PowerNorm
from matplotlib.figure import Figure

from fretwear.data.effects import Points
from fretwear.data.files import open_case
from fretwear.data.safe import write_text
from fretwear.data.sensitivity import GOOD, is_sampled, result_indices
from fretwear.figures.axes import ValueAxis
from fretwear.figures.bearing import compare_bearing_areas, has_bearing_area
from fretwear.figures.datasets import envelope_of, field_of, peak_envelope, variable_of
from fretwear.figures.effects import effect_map, effects, parallel_coordinates, sensitivity
from fretwear.figures.history import Ensemble, draw_history
from fretwear.figures.index import (
    ANSWER_CATEGORY,
    HISTORY_CATEGORY,
    INDEX_NAME,
    MAP_CATEGORY,
    PROFILE_CATEGORY,
    FigureEntry,
)
from fretwear.figures.lines import (
    MOST_KEYED_COLORS,
    MOST_MARKED_POINTS,
    Array,
    Layout,
    Line,
    choose_layout,
    joined,
    representative_cases,
    shown_lines,
    study_lines,
)
from fretwear.figures.maps import compare_wear_maps, depth_scale
from fretwear.figures.profiles import at_edge, compare_profiles, is_traction
from fretwear.figures.rig import fretting_map, has_fretting_map
from fretwear.figures.style import save_figure
from fretwear.study.case import Case
from fretwear.study.parameters import parameter
from fretwear.vocabulary import Field, Variable

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
    known: Mapping[str, Case] | None = None,
) -> Iterator[StudyFigure]:
    """Yield the figures of a merged study, whose case files are in the folder `cases`.

    First comes what the parameters do, then the quantities of all cases over the cycles, with its
    `history` through every step, then profiles, bearing areas and wear maps of a few representative
    cases; `known` are the cases of the study by id, for the heights of their surfaces. A
    study of which no point is done has no figures.
    """
    if not study_lines(summary, "wear_volume"):
        return
    yield from _answer_figures(summary)
    histories = dict(HISTORIES)
    force = summary["tangential_force"]
    if bool((force.max("cycle") - force.min("cycle") > _STEADY * force.max("cycle")).any()):
        histories["tangential_force"] = "tangential_force"
    for name, quantity in histories.items():
        caption = _history_caption(summary, variable_of(summary, quantity), history)
        figure = draw_history(summary, quantity, history)
        yield StudyFigure(name, caption, HISTORY_CATEGORY, figure)
    cases_of = representative_cases(summary)
    suffix = f"_by_{'_and_'.join(cases_of.contrasts)}" if cases_of.contrasts else ""
    where = f" ({cases_of.common})" if cases_of.common else ""
    with ExitStack() as stack:
        opened = {
            title: stack.enter_context(open_case(cases / f"{case_id}.nc"))
            for title, case_id in cases_of.ids.items()
        }
        for name, quantity in PROFILES.items():
            caption = _profile_caption(field_of(quantity), where, opened) + cases_of.left_out
            figure = compare_profiles(opened, quantity)
            yield StudyFigure(f"{name}{suffix}", caption, PROFILE_CATEGORY, figure)
        known = known or {}
        rough = {
            title: each
            for title, each in opened.items()
            if (case := known.get(each.attrs["case_id"])) and has_bearing_area(case)
        }
        if rough:
            caption = (
                f"Bearing area before and after wear{where}: the share of the contact above each "
                "height of the roughness, less wear and plastic depth; 0 is the mean before."
            )
            figure = compare_bearing_areas(rough, known)
            yield StudyFigure(f"bearing_area{suffix}", caption, MAP_CATEGORY, figure)
        # A line contact has no map: it is the same all along y.
        if all("y" in case.dims for case in opened.values()):
            caption, figure = (
                _map_caption(where, opened) + cases_of.left_out,
                compare_wear_maps(opened),
            )
            yield StudyFigure(f"wear_map{suffix}", caption, MAP_CATEGORY, figure)


def write_study_figures(
    summary: xr.Dataset,
    cases: Path,
    folder: Path,
    extra: Iterable[StudyFigure] = (),
    history: xr.Dataset | None = None,
    known: Mapping[str, Case] | None = None,
) -> list[FigureEntry]:
    """Write every figure of `study_figures` as SVG and PNG to a folder, and an index of them.

    `extra` figures come after those; each is drawn only when it is written. The entries returned
    are those of ``index.json``, which appears last.
    """
    entries = []
    for name, caption, category, figure in chain(
        study_figures(summary, cases, history, known), extra
    ):
        save_figure(figure, folder / name)
        entries.append(FigureEntry(name, caption, category))
    text = json.dumps([asdict(entry) for entry in entries], indent=1, ensure_ascii=False)
    write_text(folder / INDEX_NAME, f"{text}\n")
    return entries


def _answer_figures(summary: xr.Dataset) -> Iterator[StudyFigure]:
    """Yield what shows the effects of the parameters, as far as the design of the study can."""
    points = Points.of(summary)
    if not points.levels:
        return
    paired = any(points.lines.values())
    caption = (
        "Final results against each parameter. A line joins cases that differ in this parameter "
        "alone; colours are those of the other parameter on which the change depends most."
        if paired
        else "Final results of all points against each parameter: scatter plots."
    )
    yield StudyFigure("effects", caption, ANSWER_CATEGORY, effects(summary))
    if has_fretting_map(summary):
        caption = (
            "Fretting map: partial, mixed and gross slip over load and displacement. Mixed slip is "
            "partial in some snapshots and gross in others; dots grow with the wear volume."
        )
        yield StudyFigure("fretting_map", caption, ANSWER_CATEGORY, fretting_map(summary))
    mapped = [name for name, levels in points.levels.items() if len(levels) > 2]
    if len(mapped) > 1 and all(points.lines[name] for name in mapped):
        caption = (
            f"{points.variables['wear_volume'].label} after the last cycle over the two "
            "parameters with most values."
        )
        yield StudyFigure("wear_volume_map", caption, ANSWER_CATEGORY, effect_map(summary))
    if not is_sampled(summary):
        return
    if any(each.quality >= GOOD for each in result_indices(summary).values()):
        caption = (
            "Sobol indices of final results. Left: each parameter alone (full marks) and with its "
            "interactions (open), with 95 % intervals from the covariance of the emulator's "
            "coefficients. Right: the latter against the number of points."
        )
        yield StudyFigure("sobol_indices", caption, ANSWER_CATEGORY, sensitivity(summary))
    caption = (
        "Every point as a line over its parameters; its colour is the final "
        f"{points.variables['wear_volume'].words}."
    )
    figure = parallel_coordinates(summary)
    yield StudyFigure("parallel_coordinates", caption, ANSWER_CATEGORY, figure)


def _history_caption(
    summary: xr.Dataset, variable: Variable, history: xr.Dataset | None = None
) -> str:
    cases = study_lines(summary, variable.name, history)
    points = summary["status"].size if "status" in summary else len(cases)
    ensemble = Ensemble.of(summary, variable.name)
    if ensemble is not None:
        summary, history = ensemble.mean, None
    lines = study_lines(summary, variable.name, history)
    layout = choose_layout(lines)
    chance = f"Mean and standard deviation over {ensemble.count} seeds." if ensemble else ""
    sentences = [
        f"{variable.label} against the number of cycles, {_cases(len(cases), points)}.",
        *([chance] if chance else []),
        *_encoding(layout),
        *(
            f"Of {total} values of {parameter(name).words}, {len(layout.levels[name])} are shown."
            for name, total in layout.thinned.items()
        ),
        *_drawn(lines, layout, is_dense=history is not None),
        f"{_axes_words(variable, *joined(shown_lines(lines, layout)))}.",
    ]
    return " ".join(sentences)


def _drawn(lines: Sequence[Line], layout: Layout, *, is_dense: bool) -> Iterator[str]:
    keyed = not layout.color or len(layout.levels[layout.color]) <= MOST_KEYED_COLORS
    marked = keyed and any(0 < line.marks.shape[1] <= MOST_MARKED_POINTS for line in lines)
    if is_dense:
        yield f"Lines go through every step{'; marks are snapshots' if marked else ''}."
    elif marked:
        yield "Marks are snapshots, joined by straight lines."


def _axes_words(variable: Variable, cycles: Array, values: Array) -> str:
    shown = (cycles == 0.0) | (cycles >= 1.0)
    positive = cycles[shown & (values > 0.0)]
    is_wide = cycles.max() >= 10.0 * positive[positive > 0.0].min(initial=math.inf)
    if not ValueAxis.of(variable, values[shown]).is_logarithmic:
        broken = "The axis of cycles is logarithmic to the right of the break"
        return broken if is_wide else "The axes are linear"
    if not is_wide:
        return "The vertical axis is logarithmic"
    if (positive == 0.0).any():
        return "Both axes are logarithmic, that of cycles to the right of the break"
    return "Both axes are logarithmic"


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
    on_line = (
        " on the line nearest y = 0" if all("y" in each.dims for each in cases.values()) else ""
    )
    sentences = [
        f"{field.label} along the direction of slip{on_line} at several cycles{where}.",
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
    if _any_rough(cases, "roughness_rms_height"):
        sentences.append("On a rough surface each spot of contact and of stick has its outline.")
    deepest = [float(case["wear_depth"].isel(cycle=-1).max()) for case in cases.values()]
    if isinstance(depth_scale(deepest), PowerNorm):
        sentences.append("Colours vary as the square root of the depth.")
    return " ".join(sentences)


def _any_rough(cases: Mapping[str, xr.Dataset], *more: str) -> bool:
    names = ("roughness_amplitude", *more)
    return any(float(case.coords.get(n, 0.0)) > 0.0 for case in cases.values() for n in names)
