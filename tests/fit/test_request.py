"""The section fit of a study: readings and ranges, and what is refused with a sentence."""

import numpy as np
import pytest

from fretwear.study.mistakes import StudyError
from fretwear.study.plan import Plan
from fretwear.study.reading import load_study

from ..studies import base, near, write_study

X = np.linspace(-300.0, 300.0, 61)
SCAR = 0.4 * np.exp(-((X / 100.0) ** 2))
HEAD = "x (um),depth (um)"
SCHEMA_FREE = {"wear_coefficient": ["1e-14 / Pa", "1e-11 / Pa"]}


def text(x=X, depth=SCAR, head=HEAD):
    return "\n".join([head, *(f"{a},{b}" for a, b in zip(x, depth, strict=True))])


def study(folder, scar=None, free=SCHEMA_FREE, **changes):
    data = {"file": "scar.csv", "quantity": "wear_depth"} | changes
    data = {key: value for key, value in data.items() if value is not None}
    (folder / "scar.csv").write_text(text() if scar is None else scar)
    content = {"base": base(wear_coefficient=None), "fit": {"free": free, "data": [data]}}
    return load_study(write_study(folder / "scar.yaml", content))


def refusal(*arguments, **changes):
    with pytest.raises(StudyError) as caught:
        study(*arguments, **changes)
    return str(caught.value)


def test_readings_are_in_si_units_and_heights_count_upwards(tmp_path):
    for scar, keys in (
        (text(), {}),
        (text(X / 1e3, -SCAR * 1e3, "x (mm), height (nm)"), {}),
        (text(X[::-1], SCAR[::-1], "x_um;depth_um").replace(",", ";").replace(".", ","), {}),
        (text(X, np.where(np.arange(X.size) == 7, np.nan, SCAR)), {}),
    ):
        x, depth = study(tmp_path, scar, **keys).added["fit"].data[0].readings
        there = np.isin(np.round(X), np.round(x * 1e6))
        assert there.sum() >= X.size - 1
        assert x == pytest.approx(X[there] * 1e-6, abs=1e-15)
        assert depth == pytest.approx(SCAR[there] * 1e-6, abs=1e-15)


EIGHTH = np.arange(X.size) == 7
VOLUME = {"quantity": "wear_volume", "file": None}
DOUBLED, BACKWARDS = np.where(EIGHTH, X[6], X), np.where(EIGHTH, X[5], X)


@pytest.mark.parametrize(
    ("scar", "part"),
    [
        (text(DOUBLED), "is not sorted: reading 8"),
        (text(BACKWARDS), "is not sorted: reading 8"),
        (text(depth=-SCAR), "has the wrong sign"),
        (text(depth=0.0 * SCAR), "is flat: it shows no wear"),
    ],
)
def test_readings_that_cannot_be_used_are_refused_with_the_reason(tmp_path, scar, part):
    told = refusal(tmp_path, scar)
    assert "fit.data[0].file" in told
    assert part in told
    assert "at least 1 item" not in told


@pytest.mark.parametrize(
    ("changes", "parts"),
    [
        ({"quantity": "wear_depth_flat"}, ["one for both together", "[indenter, flat]"]),
        ({"file": None}, ["fit.data[0].file", "is missing"]),
        ({"file": "none.csv"}, ["none.csv: No such file or directory"]),
        ({"cycle": 2000}, ["fit.data[0].cycle = 2000", "beyond the 1000 cycles"]),
        ({"colums": [0, 1]}, ["fit.data[0].colums", "is not known"]),
        (VOLUME, [".value", ".error", "is missing"]),
        (VOLUME | {"value": "1e-3 mm^2", "error": "5 %"}, ["a point contact", "m3"]),
        (VOLUME | {"value": 1e-3, "error": "5 %"}, ["needs a unit"]),
        ({"free": {"wear_coeficient": [1, 2]}}, ["did you mean 'wear_coefficient'"]),
        ({"free": {"friction": [0.9, 0.2]}}, ["a lower end below its upper end"]),
    ],
)
def test_a_wrong_section_is_told_with_key_value_and_rule(tmp_path, changes, parts):
    told = refusal(tmp_path, **changes)
    for part in parts:
        assert part in told


def test_the_coefficient_of_one_body_needs_a_pair_in_base(tmp_path):
    content = {"base": base(), "fit": {"data": [{"file": "scar.csv", "quantity": "wear_depth"}]}}
    content["fit"]["free"] = {"wear_coefficient.flat": ["1e-14 / Pa", "1e-11 / Pa"]}
    (tmp_path / "scar.csv").write_text(text())
    with pytest.raises(StudyError, match="base has one value for both together"):
        load_study(write_study(tmp_path / "scar.yaml", content))


# A scar of 600 µm by 400 µm, in µm.
ALONG, ACROSS = 10.0 * np.arange(60), 10.0 * np.arange(40)
DEPTHS = 0.4 * np.exp(-(((ALONG[:, None] - 290) / 100) ** 2) - ((ACROSS - 190) / 60) ** 2)


def test_a_map_gives_the_line_asked_for_along_x_or_y(tmp_path):
    """Heights of 600 µm by 400 µm; lines across count from the edge, and default to the middle."""
    library = pytest.importorskip("SurfaceTopography")
    library.Topography(-DEPTHS, (600.0, 400.0), unit="um").to_netcdf(str(tmp_path / "map.nc"))

    def line(**changes):
        keys = {"file": "map.nc", "noise": "20 nm"} | changes
        return study(tmp_path, **keys).added["fit"].data[0].readings

    for expected, changes in (
        (DEPTHS[:, 10], {"line": "100 um"}),
        (DEPTHS[20], {"along": "y", "line": "200 um"}),
    ):
        places, read = line(**changes)
        assert np.diff(places) == near(10e-6)
        assert read - read.mean() == pytest.approx(1e-6 * (expected - expected.mean()), abs=1e-9)
    assert np.ptp(line(along="y")[1]) == near(1e-6 * np.ptp(DEPTHS[30]), rel=0.02)
    assert "no line at" in refusal(tmp_path, file="map.nc", line="900 um")
    scan = library.NonuniformLineScan(ALONG, -DEPTHS[:, 10], unit="um")
    scan.to_netcdf(str(tmp_path / "scan.nc"))
    places, read = line(file="scan.nc")
    assert places == pytest.approx(1e-6 * ALONG, abs=1e-12)
    assert read == pytest.approx(1e-6 * DEPTHS[:, 10], abs=1e-12)


def test_a_scar_as_x_y_z_in_a_table_is_a_map_and_the_plan_says_what_it_holds(tmp_path):
    rows = "".join(f"{a},{b},{-d:.5f}\n" for a, r in zip(ALONG, DEPTHS, strict=True)
                   for b, d in zip(ACROSS, r, strict=True))  # fmt: skip
    for head, keys in (("x (um),y (um),z (um)", {}), ("x,y,z", {"units": ["um", "um", "um"]})):
        read = study(tmp_path, f"{head}\n{rows}", noise="20 nm", line="100 um", **keys)
        _, values = read.added["fit"].data[0].readings
        expected = 1e-6 * DEPTHS[:, 10]
        assert values - values.mean() == pytest.approx(expected - expected.mean(), abs=1e-10)
        (told,) = Plan(read).files
        assert told.startswith("scar.csv: 60 readings, ")


def test_a_loop_is_force_over_displacement_and_needs_the_noise_of_the_force(tmp_path):
    turn = np.linspace(0.0, 2 * np.pi, 20, endpoint=False)
    x, force, head = np.cos(turn), -2 * np.sin(turn), "displacement (um),force (kN)"
    scar, loop = text(x, force, head), {"quantity": "loop", "force_noise": "0.2 N"}
    (measured,) = study(tmp_path, scar, **loop).added["fit"].data
    assert measured.readings[0] == near(1e-6 * x)
    assert measured.readings[1] == near(1e3 * force)
    for order in (np.roll(np.arange(20), 7), np.arange(20)[::-1]):
        (reordered,) = study(tmp_path, text(x[order], force[order], head), **loop).added["fit"].data
        for each, first in zip(reordered.readings, measured.readings, strict=True):
            assert each == pytest.approx(first, abs=1e-9 * np.ptp(first))
    order = np.random.default_rng(1).permutation(20)
    assert "is not one loop" in refusal(tmp_path, text(x[order], force[order], head), **loop)
    assert "fit.data[0].force_noise" in refusal(tmp_path, scar, quantity="loop")
    assert "displacement and depth, not force" in refusal(
        tmp_path, scar.replace("force (kN)", "depth (um)"), **loop
    )


@pytest.mark.parametrize(
    ("head", "keys"),
    [
        ("Position along profile (um),Height before (um),Height after (um)", {}),
        ("Wear track position (um),Unworn (um),Worn (um)", {}),
        ("a (um),b (um),c (um)", {"columns": [0, 1, 2]}),
    ],
)
def test_heights_before_and_after_the_test_give_their_difference(tmp_path, head, keys):
    waves = 2.0 * np.sin(X / 40.0)
    rows = zip(X, waves, waves - SCAR, strict=True)
    scar = "\n".join([head, *(",".join(f"{v:.6f}" for v in row) for row in rows)])
    (datum,) = study(tmp_path, scar, **keys).added["fit"].data
    assert datum.readings[1] == pytest.approx(SCAR * 1e-6, abs=1e-11)
    if not keys:
        assert "less" in datum.origin


@pytest.mark.parametrize(
    "head",
    ["Profile length (um),Height (um)", "Vertical track distance (um),x (um)"],
)
def test_no_column_is_position_and_height_at_once(tmp_path, head):
    turned = head.startswith("Vertical")
    columns = (-SCAR, X) if turned else (X, -SCAR)
    (datum,) = study(tmp_path, text(*columns, head)).added["fit"].data
    assert datum.readings[0] == pytest.approx(X * 1e-6)
    assert datum.readings[1] == pytest.approx(SCAR * 1e-6)


def test_several_columns_of_heights_are_asked(tmp_path):
    rows = "\n".join(f"{a},{b},{b}" for a, b in zip(X, SCAR, strict=True))
    told = refusal(tmp_path, f"x (um),depth left (um),depth right (um)\n{rows}")
    assert "'depth left' and 'depth right'" in told
    assert "columns: [0, 1]" in told


def test_a_hole_in_a_map_of_a_scar_is_no_reading(tmp_path):
    library = pytest.importorskip("SurfaceTopography")
    heights = np.tile(-SCAR[:, None], (1, 9))
    hole = np.zeros(heights.shape, bool)
    hole[26:35, 2:7] = True
    surface = library.Topography(np.ma.array(heights, mask=hole), (610.0, 90.0), unit="um")
    surface.to_netcdf(str(tmp_path / "map.nc"))
    (datum,) = study(tmp_path, file="map.nc", noise="20 nm").added["fit"].data
    assert datum.readings[0].size == X.size - 9
    read, expected = datum.readings[1], SCAR[~hole[:, 4]] * 1e-6
    assert read - read.mean() == pytest.approx(expected - expected.mean(), abs=1e-12)
    assert "9 of 61 readings are missing" in datum.origin
