"""The figures of the source study, made from our own datasets, under its numbers."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import xarray as xr
from matplotlib.figure import Figure

from fretwear.figures.datasets import field_of
from fretwear.figures.profiles import at_edge
from fretwear.figures.study import StudyFigure
from fretwear.source_study.half_widths import Look, edge_of_contact, half_widths
from fretwear.source_study.profiles import (
    MEAN_WORDS,
    CaseLine,
    contact_edge,
    middle_of_slip,
    pressure_of_lines,
    rough_profiles,
    smooth_profiles,
    stick_edge,
)
from fretwear.source_study.quartet import Quartet
from fretwear.source_study.slip_models import compare_slip_models
from fretwear.source_study.source import SourceCases, reference_cases, simpler_cases
from fretwear.units import NANOMETRE
from fretwear.vocabulary import Field

CATEGORY = "Figures of the source study"
SHOWN_CYCLES = (0, 100, 1000, 7000, 30000)
RUN_IN = 7000

_PRESSURE, _SHEAR, _GAP = (field_of(name) for name in ("pressure", "shear_traction", "gap"))
_WEAR_RATE = replace(field_of("wear_rate"), unit=NANOMETRE)
_AT_Y = "on the line nearest y = 0"
_SHADE = "Grey: stick zone at the last cycle shown; later curves lie on top of earlier ones."
_EDGE = "Around the edge of the contact, as far as the window of the case goes."
_CUT = (
    "Curves that leave at the top are elastic: their peak at the edge of stick grows with a finer "
    "grid, without end."
)
_LOOKS = {
    "smooth elastic": Look.of(False, False),
    "rough elastic": Look.of(True, False),
    "smooth plastic": Look.of(False, True),
    "rough plastic": Look.of(True, True),
}


def source_figures(summary: xr.Dataset, cases: Path) -> Iterator[StudyFigure]:
    """Yield the figures of the source study, numbered as there.

    Parameters
    ----------
    summary : xarray.Dataset
        A merged study.
    cases : pathlib.Path
        Folder of its case files.

    Yields
    ------
    StudyFigure
        Nothing when the study does not hold the four cases of the source study.
    """
    reference = reference_cases(summary)
    if reference is None:
        return
    quartet = reference.load(cases)
    yield from _pressures(quartet)
    yield from _smooth_and_rough(quartet, _SHEAR, (8, 9), "shear")
    yield from _smooth_and_rough(quartet, _GAP, (10, 11), "gap")
    yield from _smooth_and_rough(quartet, _WEAR_RATE, (13, 14), "wear_rate")
    yield from _widths(quartet)
    yield from _models(quartet, simpler_cases(summary), cases)


def _pressures(quartet: Quartet) -> Iterator[StudyFigure]:
    smooth, rough = quartet.smooth_elastic.dataset, quartet.rough_elastic.dataset
    plastic = {"smooth": quartet.smooth_plastic.dataset, "rough": quartet.rough_plastic.dataset}
    cycles = _shown(quartet)
    yield _named(
        "fig04_pressure_smooth_elastic",
        smooth_profiles({"smooth elastic": smooth}, _PRESSURE, cycles),
        f"Pressure of the smooth elastic contact along x {_AT_Y}.",
        _SHADE,
        _CUT,
    )
    yield _named(
        "fig05_pressure_rough_elastic",
        rough_profiles({"rough elastic": rough}, _PRESSURE, cycles, stick_edge),
        f"Pressure of the rough elastic contact along x {_AT_Y}.",
        _SHADE,
        _averaged("at the first edge of stick"),
        _CUT,
    )
    yield _named(
        "fig06_pressure_rough_elastic_and_plastic",
        rough_profiles(
            {"rough elastic": rough, "rough plastic": plastic["rough"]},
            _PRESSURE,
            _up_to_run_in(cycles),
            stick_edge,
        ),
        f"Pressure of the rough contact along x {_AT_Y}: elastic, and with a plastic limit.",
        _SHADE,
        _averaged("at the first edge of stick"),
        _CUT,
    )
    run_in, last = quartet.smooth_plastic.nearest(RUN_IN), quartet.smooth_plastic.last
    lines = [
        CaseLine("smooth plastic", plastic["smooth"], run_in),
        CaseLine("rough plastic", plastic["rough"], run_in),
        CaseLine("smooth plastic", plastic["smooth"], last),
    ]
    yield _named(
        "fig07_pressure_plastic",
        pressure_of_lines(lines),
        f"Pressure of the contacts with a plastic limit along x {_AT_Y}, smooth and rough after "
        f"{run_in} cycles and smooth after {last}; right: the same, enlarged.",
        f"Of the rough one the thin line is the profile, the thick one its {MEAN_WORDS}.",
    )


def _smooth_and_rough(
    quartet: Quartet, field: Field, numbers: tuple[int, int], name: str
) -> Iterator[StudyFigure]:
    """Two figures of one quantity, smooth and rough, each elastic and with a plastic limit."""
    cycles = _shown(quartet)
    smooth = {
        "smooth elastic": quartet.smooth_elastic.dataset,
        "smooth plastic": quartet.smooth_plastic.dataset,
    }
    rough = {
        "rough elastic": quartet.rough_elastic.dataset,
        "rough plastic": quartet.rough_plastic.dataset,
    }
    center, place = _ZOOMS[name]
    notes = (_EDGE if at_edge(field) else _SHADE, *((_CUT,) if field is _SHEAR else ()))
    yield _named(
        f"fig{numbers[0]:02d}_{name}_smooth",
        smooth_profiles(smooth, field, cycles),
        f"{field.label} of the smooth contact along x {_AT_Y}: elastic, and with a plastic limit.",
        *notes,
    )
    yield _named(
        f"fig{numbers[1]:02d}_{name}_rough",
        rough_profiles(rough, field, cycles, center),
        f"{field.label} of the rough contact along x {_AT_Y}: elastic, and with a plastic limit.",
        _SHADE,
        _averaged(place),
        *notes[1:],
    )


_ZOOMS = {
    "shear": (stick_edge, "at the first edge of stick"),
    "gap": (contact_edge, "at the edge of the contact"),
    "wear_rate": (middle_of_slip, "in the middle of the slip zone"),
}


def _widths(quartet: Quartet) -> Iterator[StudyFigure]:
    histories = {title: case.history for title, case in quartet.each()}
    steps = "A rough contact widens by steps: one more row of tips at a time."
    yield _named(
        "fig15_contact_half_width",
        half_widths(histories, _LOOKS),
        "Half-widths along x of the contact (thick) and of the stick zone (thin) against the "
        "number of cycles.",
        steps,
    )
    yield _named(
        "fig16_contact_half_width_zoom",
        edge_of_contact(histories, _LOOKS, ("smooth elastic", "rough elastic")),
        "The edge of the contact enlarged; the axis of cycles is logarithmic to the right of the "
        "break. With a plastic limit the contact goes on to grow.",
        steps,
    )


def _models(quartet: Quartet, simple: SourceCases | None, cases: Path) -> Iterator[StudyFigure]:
    """The simpler slip model against the other, where the study has both."""
    if simple is None:
        return
    both = list(zip(quartet.each(), simple.load(cases).each(), strict=True))
    yield _named(
        "slip_models",
        compare_slip_models(
            {title: (case.dataset, other.dataset) for (title, case), (_, other) in both},
            {title: (case.history, other.history) for (title, case), (_, other) in both},
            quartet.smooth_elastic.nearest(RUN_IN),
        ),
        "Slip of the worn shape against the constant slip of the unworn smooth sphere: wear "
        f"volume of all four cases, and profiles along x {_AT_Y} of one.",
    )


def _shown(quartet: Quartet) -> list[int]:
    """Snapshots to show, those that all four cases have; all of them when that leaves few."""
    common = set.intersection(*(set(case.cycles) for _, case in quartet.each()))
    chosen = [cycle for cycle in SHOWN_CYCLES if cycle in common]
    return chosen if len(chosen) > 2 else sorted(common)


def _up_to_run_in(cycles: list[int]) -> list[int]:
    return [cycle for cycle in cycles if cycle <= RUN_IN]


def _averaged(place: str) -> str:
    return f"Left: the profile (thin) and its {MEAN_WORDS} (thick). Right: a few waves {place}."


def _named(name: str, figure: Figure, *sentences: str) -> StudyFigure:
    return StudyFigure(name, " ".join(sentences), CATEGORY, figure)
