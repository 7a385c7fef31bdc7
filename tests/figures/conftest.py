"""Small real runs, and a way to see every text that a figure draws."""

from itertools import combinations
from pathlib import Path
from typing import NamedTuple

import matplotlib
import pytest
import xarray as xr
from matplotlib.backends.backend_agg import RendererAgg
from matplotlib.transforms import Bbox

from fretwear.run.simulate import run
from fretwear.study.reading import load_study
from fretwear.study.study import Study

from ..studies import base, run_study, steel, write_study

WAVES = {"kind": "wavy", "amplitude": "0.3 um", "slope_x": "1.8 deg", "slope_y": "1 deg"}

STUDY = {
    "title": "A small grid",
    "base": base(
        load=None,
        friction=0.6,
        plastic_limit=None,
        roughness={"kind": "wavy", "slope_x": "1.8 deg", "slope_y": "1 deg"},
        cell=["3.9 um", "4 um"],
        error_estimate=False,
    ),
    "vary": {
        "load": ["30 N", "40 N"],
        "roughness.amplitude": ["0 um", "0.3 um"],
        "plastic_limit": ["none", "4500 MPa"],
    },
    "output": {"cycles": [1, 10, 100]},
}


class SmallStudy(NamedTuple):
    study: Study
    summary: xr.Dataset
    cases: Path


class _Recorder(RendererAgg):
    """A renderer that notes the texts that pass through it, with their boxes."""

    def __init__(self, figure):
        super().__init__(figure.bbox.width, figure.bbox.height, figure.dpi)
        self.drawn: dict[int, tuple[str, Bbox]] = {}

    def draw_text(self, gc, x, y, s, prop, angle, ismath=False, mtext=None):  # type: ignore[no-untyped-def]
        super().draw_text(gc, x, y, s, prop, angle, ismath, mtext)
        if mtext is not None:
            self.drawn.setdefault(id(mtext), (mtext.get_text(), mtext.get_window_extent(self)))


@pytest.fixture
def check_texts():
    """Check that no two texts of a figure overlap and none is cut off; return the texts."""

    def check(figure):
        figure.draw_without_rendering()
        recorder, inside = _Recorder(figure), figure.bbox.padded(0.6)
        figure.draw(recorder)
        found = list(recorder.drawn.values())
        assert found
        for words, box in found:
            assert all(inside.contains(*corner) for corner in box.corners()), f"{words} is cut off"
        for (words, box), (others, neighbour) in combinations(found, 2):
            common = Bbox.intersection(box, neighbour)
            touching = common is not None and min(common.width, common.height) > 0.5
            assert not touching, f"{words!r} overlaps {others!r}"
        return [words for words, _ in found]

    return check


SMALL = {"load": "40 N", "friction": 0.6, "output_cycles": (1, 10, 100), "cell": ("4 um", "4 um")}
SMALL["error_estimate"] = False  # no figure shows errors


@pytest.fixture(scope="session")
def smooth_run():
    return run(steel(**SMALL))


@pytest.fixture(scope="session")
def smooth(smooth_run):
    return smooth_run.dataset


@pytest.fixture(scope="session")
def rough():
    return run(steel(**SMALL, roughness=WAVES, plastic_limit="4500 MPa")).dataset


@pytest.fixture(scope="session")
def small_study(made_once):
    def make(folder):
        run_study(load_study(write_study(folder / "small.yaml", STUDY)), folder)

    folder = made_once("small-study", make)
    study = load_study(folder / "small.yaml")
    return SmallStudy(study, xr.load_dataset(folder / "summary.nc"), folder / "cases")


@pytest.fixture(autouse=True)
def _odd_settings():
    """Draw under settings of the user's own that would spoil a figure that followed them."""
    with matplotlib.rc_context({"font.size": 30, "axes.titlesize": 40, "lines.linewidth": 9}):
        yield
