"""Maps as instruments export them: the same surface, or a sentence that says what to do."""

import io
import re
import zipfile
from pathlib import Path

import numpy as np
import pytest

from fretwear.study.plan import Plan
from fretwear.study.reading import load_study
from fretwear.units import QuantityError
from fretwear_measured.files import SourceFile, read_line, read_topography
from fretwear_measured.maps import without_marks

from ..studies import base, near, two_loads, write_study

FILE = SourceFile("file", "surface", "disc.x3p")
X, Y = np.arange(25) * 6.0, np.arange(19) * 5.0  # µm
SIDES = 150e-6, 95e-6


def wave(x, y):
    """Heights, µm, at places in µm."""
    return 0.3 * np.cos(x / 11.0) + 0.2 * np.sin(y / 9.0) + 0.002 * x


HEIGHTS = wave(X[:, None], Y)


def read(tmp_path, text, name="map.csv", **keys):
    file = tmp_path / name
    file.write_bytes(text if isinstance(text, bytes) else text.encode())
    return read_topography(FILE.read(str(file), Path()), form="none", **keys)


def columns(points, head="x (um);y (um);z (nm)", scales=(1.0, 1.0, 1e3)):
    lines = [";".join(f"{s * v:.6f}" for s, v in zip(scales, p, strict=True)) for p in points]
    return "\n".join([head, *lines, ""])


def on_grid(kept=lambda x, y: True):
    return [(x, y, wave(x, y)) for y in Y for x in X if kept(x, y)]


def assert_is_the_wave(found, tolerance=1e-12, first=(0.0, 0.0)):
    """Heights agree where measured, up to a constant; the first point is at a place in µm."""
    x, y = (
        1e6 * (axis - axis[0]) + one for axis, one in zip((found.x, found.y), first, strict=True)
    )
    away = (found.heights - 1e-6 * wave(x[:, None], y))[found.measured]
    assert np.abs(away - away.mean()).max() < tolerance


def test_lines_left_out_are_missing_points(tmp_path):
    points = on_grid(lambda x, y: not 30.0 < x < 70.0 and y != 45.0)
    for text, name in (
        (columns(points), "map.csv"),
        (columns(points).replace(";", "\t"), "map.txt"),
    ):
        found = read(tmp_path, text, name)
        assert found.sides == near(SIDES, rel=1e-9)
        assert found.missing == 6 * 19 + 25 - 6
        assert_is_the_wave(found)


def test_a_map_as_xyz_is_no_line_scan(tmp_path):
    text = columns(on_grid(lambda x, y: x != 60.0))
    assert read(tmp_path, text, "map.xyz").missing == 19
    assert read_line(FILE.read(str(tmp_path / "map.xyz"), Path())) is None


@pytest.mark.slow
def test_uneven_and_scattered_positions_are_interpolated_and_holes_stay(tmp_path):
    uneven = (
        np.cumsum(np.r_[0.0, np.geomspace(1.0, 4.0, 40)]),
        np.cumsum(np.r_[0.0, np.full(20, 3.0), np.ones(20)]),
    )
    found = read(tmp_path, columns([(x, y, wave(x, y)) for x in uneven[0] for y in uneven[1]]))
    assert (found.missing, found.positions) == (0, 41 * 41)
    half = [5e5 * step for step in found.spacing]
    assert_is_the_wave(found, 0.02e-6, half)  # 2 % of the range
    places = np.random.default_rng(3).uniform(0.0, 100.0, (2000, 2))
    places = places[np.hypot(*(places - 50.0).T) > 20.0]
    places = np.vstack([places, [(0, 0), (0, 100), (100, 0), (100, 100)]])
    found = read(tmp_path, columns([(x, y, wave(x, y)) for x, y in places]))
    assert_is_the_wave(found, 0.02e-6, [5e5 * step for step in found.spacing])
    assert found.missing_within(15e-6) == 1.0
    assert found.measured[np.hypot(found.x[:, None], found.y) > 27e-6].mean() > 0.95
    assert "interpolated between" in found.summary


@pytest.mark.parametrize("corner", ["0", "", "y\\x", None])
@pytest.mark.parametrize("separator", [";", "\t", ",", " "])
def test_a_matrix_may_have_its_axes(tmp_path, corner, separator):
    if separator == " " and corner == "":
        corner = None
    head = ([] if corner is None else [corner]) + [f"{x:g}" for x in X]
    lines = [[f"{y:g}", *(f"{z:.6f}" for z in row)] for y, row in zip(Y, HEIGHTS.T, strict=True)]
    text = "\n".join(separator.join(line) for line in (head, *lines))
    text = text if separator == "," else text.replace(".", ",")
    found = read(tmp_path, text, "map.txt", unit="um")
    assert found.sides == near(SIDES, rel=1e-9)
    assert_is_the_wave(found)
    assert "axes" in found.summary


def matrix(values):
    return "\n".join("\t".join(f"{z:.6f}" for z in line) for line in values)


def test_a_tilted_map_has_no_axes(tmp_path):
    tilted = HEIGHTS.T + 3.0 * np.arange(25) + 2.0 * np.arange(19)[:, None]
    found = read(tmp_path, matrix(tilted), unit="um", size="150 um, 95 um")
    assert found.heights.shape == (25, 19)


NUMBERED = np.vstack([np.arange(26), np.column_stack([np.arange(19) + 1, HEIGHTS.T])])
MICRO = {"unit": "um"}
GRIDDED, NAMELESS = columns(on_grid()), columns(on_grid(), "x;y;z")
COMMAS = columns([(x + 1, y + 1, 0.002) for x, y, _ in on_grid()])
COMMAS = re.sub(r"[.](\d{3})\d*", r",\1", COMMAS)


@pytest.mark.parametrize(
    ("text", "keys", "sentence"),
    [
        (matrix(np.column_stack([Y, HEIGHTS.T])), {**MICRO, "size": "1 mm, 1 mm"}, "first column"),
        (matrix(NUMBERED), MICRO, "count its points; add size"),
        (matrix(HEIGHTS.T), {}, "does not say the lengths of its sides; add size"),
        (matrix(HEIGHTS.T), {"file_format": "x4p"}, "no reader for format: x4p; formats are al3d"),
        (GRIDDED, MICRO, r"says x \(um\), y \(um\) and z \(nm\), which unit: um"),
        (GRIDDED, {"size": "1 mm, 1 mm"}, "has sides of 150 um x 95 um, which size"),
        (GRIDDED + "1;2;deep", {}, "'deep' in line 477, .*; save it .* nan for missing heights"),
        (GRIDDED + "3;4", {}, "has 2 numbers in a line, but 3 in others"),
        (NAMELESS, {}, r"add unit: um, or unit: \[mm, mm, um\] for x, y and z"),
        (NAMELESS, {"unit": "ell"}, "unknown unit 'ell'"),
        (NAMELESS, {"unit": "um, nm"}, "one unit or three"),
        (columns(on_grid(), "x (nm);y (nm);z (mm)"), {}, "differ by more than 10 times its longer"),
        (columns(on_grid(), "x (m);y (m);z (um)"), {}, "sides of 150 m x 95 m; check its units"),
        (columns(on_grid(), "x (um);q (N);z (um)"), {}, "x, q and z, not y; save it .* columns x"),
        (columns(on_grid() * 2), {}, "several heights at one place"),
        (columns([(x, 0.0, 1.0) for x in X]), {}, "points lie on one line"),
        (COMMAS, {}, "which may be .*; save it .* decimal points"),
    ],
)
def test_what_cannot_be_known_is_said(tmp_path, text, keys, sentence):
    pytest.importorskip("SurfaceTopography")
    with pytest.raises(QuantityError, match=sentence):
        read(tmp_path, text, **keys)


def test_units_of_x_y_and_z_fill_what_the_file_lacks(tmp_path):
    wanted = read(tmp_path, columns(on_grid()), "wanted.csv")
    for head, unit in (
        ("x;y;z", "mm, mm, nm"),
        ("x (mm);y (mm);z", "mm, mm, nm"),
        ("x;y;Höhe\n[mm];[mm];[nm]", ""),
        ("Nr;Z;X position/mm;Y_mm\n", "nm"),
    ):
        points = columns(on_grid(), head, (1e-3, 1e-3, 1e3))
        if head.startswith("Nr"):
            lines = [line.split(";") for line in points.splitlines() if line]
            points = "\n".join(";".join(["7", z, x, y]) for x, y, z in lines[1:])
            points = f"{head}{points}".replace(".", ",")
        found = read(tmp_path, points, unit=unit)
        assert found.sides == near(wanted.sides, rel=1e-9)
        np.testing.assert_allclose(found.heights, wanted.heights, atol=1e-15)


def test_keys_beside_a_file_of_an_instrument_are_checked(tmp_path):
    library = pytest.importorskip("SurfaceTopography")
    file = tmp_path / "map.nc"
    library.Topography(HEIGHTS, (150.0, 95.0), unit="um").to_netcdf(str(file))
    copy = tmp_path / "map.dat"  # not a text
    copy.write_bytes(file.read_bytes())
    assert read_topography(FILE.read(str(copy), Path())).sides == near(SIDES, rel=1e-9)
    source = FILE.read(str(file), Path())
    assert read_topography(source, unit="um", size="144 um, 90 um").sides == near(SIDES, rel=1e-9)
    for keys, sentence in (
        ({"unit": "mm"}, "which unit: mm contradicts"),
        ({"size": "1 mm, 1 mm"}, "sides of 150 um x 95 um, which size"),
        ({"channel": "3"}, "has no height channel 3; its height channels are 0: Default"),
    ):
        with pytest.raises(QuantityError, match=sentence):
            read_topography(source, **keys)


@pytest.mark.parametrize(
    "mark", ["-9999", "1e10", "-1.8e308", "3.4E+38", "No Data", "BAD", "-32768", "***"]
)
def test_marks_of_missing_points_are_no_heights(tmp_path, mark):
    hole = (X[:, None] > 60.0) & (Y > 20.0) & (Y < 70.0)  # a fourth of the map
    points = [
        f"{x} {y} {mark if h else z}"
        for (x, y, z), h in zip(on_grid(), hole.T.ravel(), strict=True)
    ]
    lines = [
        [mark if h else f"{z}" for z, h in zip(*row, strict=True)]
        for row in zip(HEIGHTS.T, hole.T, strict=True)
    ]
    for text, keys in (
        ("\n".join(points), {"unit": "um"}),
        ("\n".join(map("\t".join, lines)), {"unit": "um", "size": "150 um, 95 um"}),
    ):
        found = read(tmp_path, text, "map.txt", **keys)
        assert (found.measured == ~hole).all()
        assert_is_the_wave(found)


def test_a_clipped_height_is_no_mark():
    clipped = np.clip(HEIGHTS, -0.2, 0.3)
    np.testing.assert_array_equal(without_marks(clipped, 150.0), clipped)


XML = """<?xml version="1.0" encoding="UTF-8"?>
<p:ISO5436_2 xmlns:p="http://www.opengps.eu/2008/ISO5436_2"><Record1><Revision>{revision}</Revision>
<FeatureType>{feature}</FeatureType><Axes>
<CX><AxisType>I</AxisType><DataType>D</DataType><Increment>6e-6</Increment><Offset>0</Offset></CX>
<CY><AxisType>I</AxisType><DataType>D</DataType><Increment>5e-6</Increment><Offset>0</Offset></CY>
<CZ><AxisType>A</AxisType><DataType>{kind}</DataType><Increment>{step}</Increment><Offset>0</Offset></CZ>
</Axes></Record1><Record2><Date>2026-01-02T03:04:05</Date><Instrument>{instrument}</Instrument>
</Record2><Record3><MatrixDimension><SizeX>25</SizeX><SizeY>{lines}</SizeY><SizeZ>1</SizeZ>
</MatrixDimension>{data}</Record3></p:ISO5436_2>"""
LINK = "<DataLink><PointDataLink>bindata/d.bin</PointDataLink>{valid}</DataLink>"
EMPTY = "<Manufacturer/><Model></Model><Serial> </Serial><Version/>"
NAMED = "".join(f"<{n}>a</{n}>" for n in ("Manufacturer", "Model", "Serial", "Version"))


def x3p(kind, revision, instrument=NAMED, feature="SUR", in_xml=False):
    """A file of the standard with one missing point, at x = 12 µm, y = 15 µm."""
    heights, step = 1e-6 * HEIGHTS.T, 1e-11 if kind == "L" else 1e-10 if kind == "I" else 1.0
    heights = heights[:1] if feature == "PRF" else heights
    raw = heights / step if kind in "FD" else np.rint(heights / step)
    missing = np.zeros(raw.shape, bool)
    missing[3:4, 2] = True
    stored = np.where(missing, 0.0 if kind in "IL" else np.nan, raw)
    members = {
        "bindata/d.bin": stored.astype({"I": "<i2", "L": "<i4", "F": "<f4", "D": "<f8"}[kind])
    }
    valid = ""
    if kind in "IL":
        members["bindata/v.bin"] = np.packbits(~missing.ravel(), bitorder="little")
        valid = "<ValidPointsLink>bindata/v.bin</ValidPointsLink>"
    data = LINK.format(valid=valid)
    if in_xml:
        members = {}
        cells = zip(raw.ravel(), missing.ravel(), strict=True)
        cells = ["<Datum/>" if m else f"<Datum>{z:.17g}</Datum>" for z, m in cells]
        data = f"<DataList>{''.join(cells)}</DataList>"
    text = XML.format(
        revision=revision,
        feature=feature,
        kind=kind,
        step=step,
        instrument=instrument,
        lines=len(raw),
        data=data,
    )
    archive = io.BytesIO()
    with zipfile.ZipFile(archive, "w") as file:
        file.writestr("main.xml", text)
        for name, content in members.items():
            file.writestr(name, content.tobytes())
    return archive.getvalue()


@pytest.mark.parametrize("revision", ["ISO25178-72:2017/DAM1", "ISO5436 - 2000"])
@pytest.mark.parametrize(
    ("kind", "in_xml"),
    [("I", False), ("L", False), ("F", False), ("D", False), ("D", True), ("L", True)],
)
@pytest.mark.parametrize("instrument", [EMPTY, NAMED])
def test_x3p_of_every_kind_is_read(tmp_path, revision, kind, in_xml, instrument):
    pytest.importorskip("SurfaceTopography")
    found = read(tmp_path, x3p(kind, revision, instrument, in_xml=in_xml), "map.x3p")
    assert found.sides == near(SIDES, rel=1e-9)
    assert np.argwhere(~found.measured).tolist() == [[2, 3]]
    assert_is_the_wave(found, {"I": 1e-10, "L": 1e-11}.get(kind, 1e-12))  # steps of integers


def test_a_profile_as_x3p_is_a_line_scan(tmp_path):
    pytest.importorskip("SurfaceTopography")
    with pytest.raises(QuantityError, match="is a line scan, but a map"):
        read(tmp_path, x3p("D", "ISO25178-72:2017/DAM1", feature="PRF"), "map.x3p")
    x, heights = read_line(FILE.read(str(tmp_path / "map.x3p"), Path()))
    np.testing.assert_allclose(x, 1e-6 * X, atol=1e-15)
    np.testing.assert_allclose(heights, 1e-6 * HEIGHTS[:, 0], atol=1e-15)


def test_exports_of_interferometers_and_german_programs_are_read(tmp_path):
    pytest.importorskip("SurfaceTopography")
    quoted = "\n".join(",".join(f'"{z:.6f}"' for z in line) for line in HEIGHTS.T)
    keyence = '"Modell","VK"\n"XY-Justierung","6000","nm"\n"Einheit","um"\n\n"Höhe"\n'
    zygo = 'Zygo XYZ Data File - Format 1\n0 3 0 0 "x"\n0 0 25 19 1 255\n4 2 25 19\n\n\n\n'
    zygo += "0 0.5 6.3e-07 0.5 1 0 6e-06 17\n3 2 0\n0 0 1\n0 1\n0\n1 5 0\n#\n"
    pixels = [
        (i + 4, j + 2, "No Data" if (i, j) == (7, 8) else HEIGHTS[i, j])
        for j in range(19)
        for i in range(25)
    ]
    zygo += "".join(f"{i} {j} {z}\n" for i, j, z in pixels) + "#\n"
    lines = "# Kanal: Höhe\n# Breite: 150,0 µm\n# Höhe: 114,0 µm\n# Einheiten: µm\n"
    gwyddion = lines + matrix(HEIGHTS.T).replace(".", ",")
    for text, name, missing in (
        (keyence + quoted, "a.csv", 0),
        (zygo, "b.xyz", 1),
        (gwyddion, "c.txt", 0),
    ):
        found = read(tmp_path, text.encode("latin-1") if name != "b.xyz" else text, name)
        assert found.sides == near((150e-6, 114e-6), rel=1e-9)
        assert found.missing == missing
        away = (found.heights - 1e-6 * HEIGHTS)[found.measured]
        assert np.ptp(away) < 2e-12
    phase = "# Channel: Phase\n# Width: 1 m\n# Height: 1 m\n# Value units: V\n"
    both = f"{phase}{matrix(HEIGHTS.T)}\n{gwyddion}".replace(",", ".")
    assert read(tmp_path, both, "d.txt").sides == near((150e-6, 114e-6), rel=1e-9)
    with pytest.raises(QuantityError, match="no height channel 1; its height channels are 0: Höhe"):
        read(tmp_path, both, "d.txt", channel="1")
    with pytest.raises(QuantityError, match=r"says x \(m\), y \(m\) and z \(um\), which unit"):
        read(tmp_path, zygo, "b.xyz", unit="nm")


def test_the_plan_says_what_the_files_hold(tmp_path):
    (tmp_path / "map.csv").write_text(columns(on_grid(lambda x, y: x != 60.0)))
    content = two_loads(base=base(roughness={"kind": "measured", "file": "map.csv"}, cycles=1))
    write_study(tmp_path / "study.yaml", content)
    (text,) = Plan(load_study(tmp_path / "study.yaml")).files
    assert text.startswith("map.csv: 25 x 19 points over 150 um x 95 um, 19 missing; heights ")
    assert "columns x (um), y (um), z (nm)" in text
    top = np.unravel_index(HEIGHTS.argmax(), HEIGHTS.shape)
    place = f"x = {X[top[0]] + 3.0:.4g} um, y = {Y[top[1]] + 2.5:.4g} um"
    assert f"to {1e3 * HEIGHTS.max():.4g} nm, highest at {place} from the corner" in text
