"""Files with surfaces: heights and units as they are, and a sentence for every bad file."""

from pathlib import Path

import numpy as np
import pytest

from fretwear.study.case import Case
from fretwear.study.case_warnings import case_warnings
from fretwear.study.reading import load_study
from fretwear.units import QuantityError
from fretwear_measured.figures import measured_map
from fretwear_measured.files import SourceFile, read_profile, read_topography
from fretwear_measured.surfaces import MeasuredRoughness

from ..studies import near, steel

GROUND = Path(__file__).parents[2] / "studies/surfaces/ground.nc"
FILE = SourceFile("file", "surface", "disc.x3p")


@pytest.fixture
def library():
    return pytest.importorskip("SurfaceTopography")


@pytest.fixture
def written(library, tmp_path):
    """A function that writes heights, m, of a map of 40 µm by 30 µm in µm."""

    def write(heights, name="map.nc", unit="um"):
        scaled = np.ma.masked_invalid(heights * 1e6)
        file = tmp_path / name
        library.Topography(scaled, (40.0, 30.0), unit=unit).to_netcdf(str(file))
        return str(file)

    return write


def wave(x, y):
    return 1e-7 * np.sin(2 * np.pi * x / 40e-6) * np.cos(2 * np.pi * y / 30e-6)


X, Y = (np.arange(40) - 19.5)[:, None] * 1e-6, (np.arange(30) - 14.5)[None, :] * 1e-6


def test_a_map_is_read_in_metres_levelled_and_filled(written):
    missing = np.zeros((40, 30), bool)
    missing[3::7, 2::5] = True
    tilted = np.where(missing, np.nan, wave(X, Y) + 2e-3 * X - 1e-3 * Y + 5e-6)
    found = read_topography(FILE.read(written(tilted), Path()))
    np.testing.assert_allclose(found.x, X[:, 0], atol=1e-12)
    np.testing.assert_allclose(found.y, Y[0], atol=1e-12)
    assert found.missing == missing.sum()
    plane = np.linalg.lstsq(
        np.stack([np.ones(1200), (X + 0 * Y).ravel(), (Y + 0 * X).ravel()], 1), wave(X, Y).ravel()
    )[0]
    level = wave(X, Y) - plane[0] - plane[1] * X - plane[2] * Y
    # The points that are missing move the plane a little, and are filled from their neighbours.
    np.testing.assert_allclose(found.heights[~missing], level[~missing], atol=3e-9)
    np.testing.assert_allclose(found.heights[missing], level[missing], atol=6e-9)
    tilt = read_topography(FILE.read(written(wave(X, Y) + 2e-3 * X), Path()), form="none")
    assert np.polyfit(X[:, 0], tilt.heights.mean(axis=1), 1)[0] == near(2e-3, rel=1e-6)


def test_a_patch_is_a_part_of_the_file_about_its_own_centre(written, tmp_path):
    file = FILE.read(written(wave(X, Y)), Path())
    part = read_topography(file, form="none", patch=(10e-6, 5e-6, 20e-6, 10e-6))
    expected = wave(X[10:30], Y[:, 5:15])
    np.testing.assert_allclose(part.heights, expected - expected.mean(), atol=1e-15)
    assert part.sides == near((20e-6, 10e-6), rel=1e-9)
    assert part.x[0] == -part.x[-1]
    first = Path(written(wave(X, Y)))
    moved = tmp_path / "elsewhere" / first.name
    moved.parent.mkdir()
    moved.write_bytes(first.read_bytes())
    assert FILE.read(str(first), Path()) == FILE.read(str(moved), Path())


def test_what_stands_out_of_either_body_closes_the_gap(written):
    heights = wave(X, Y) + 3e-3 * X
    flat = MeasuredRoughness(written(heights), tilt="keep")
    grid = X[3:37:5], Y[:, 2:28:5]
    expected = -(heights - heights.mean())[3:37:5, 2:28:5]
    np.testing.assert_allclose(flat.height(*grid), expected, atol=1e-15)
    # Turned over about the y axis.
    turned = MeasuredRoughness(written(heights), tilt="keep", body="indenter")
    np.testing.assert_allclose(turned.height(*grid), flat.height(-grid[0], grid[1]), atol=1e-18)


@pytest.mark.usefixtures("library")
def test_the_checksum_of_the_file_is_part_of_the_id():
    study = load_study(GROUND.parents[1] / "measured.yaml")
    case = study.points()[0].case
    assert case.roughness.missing_points == 278
    assert case.roughness.rms_height == near(0.08e-6, rel=0.05)
    again = Case(**case.canonical_parameters())
    assert again.case_id == case.case_id
    parameters = case.canonical_parameters()
    file = parameters["roughness"]["file"]
    parameters["roughness"]["file"] = file[:-1] + ("0" if file[-1] != "0" else "1")
    parameters["cell"] = case.grid_spacing
    assert Case(**parameters).case_id != case.case_id
    assert not case.replace(load="20 N").roughness.mistake


@pytest.mark.parametrize(
    ("heights", "unit", "sentence"),
    [(np.full((40, 30), np.nan), "um", "every point is missing"),
     (np.zeros((40, 30)), None, "does not say the unit of its lengths"),
     (np.zeros((3, 30)), "um", "has 3 x 30 points")],
)  # fmt: skip
def test_a_map_without_a_surface_gets_a_sentence(written, heights, unit, sentence):
    with pytest.raises(QuantityError, match=sentence):
        read_topography(FILE.read(written(heights, unit=unit), Path()))


@pytest.mark.usefixtures("library")
def test_arrays_and_tables_without_places_need_their_unit_and_sides(tmp_path):
    heights = np.arange(60.0).reshape(10, 6) ** 2
    np.save(tmp_path / "map.npy", heights)
    np.savetxt(tmp_path / "map.csv", heights.T, delimiter=";")  # a line for each y
    for name in ("map.npy", "map.csv"):
        file = FILE.read(str(tmp_path / name), Path())
        found = read_topography(file, form="none", unit="nm", size="50 um, 30 um")
        assert found.sides == near((50e-6, 30e-6), rel=1e-9)
        np.testing.assert_allclose(found.heights, 1e-9 * (heights - heights.mean()), atol=1e-15)
        with pytest.raises(QuantityError, match="needs two sides"):
            read_topography(file, unit="nm", size="50 um")
        with pytest.raises(QuantityError, match=r"add size: .* and unit: um"):
            read_topography(file)


@pytest.mark.parametrize("form", ["sphere", "cylinder", "paraboloid"])
def test_the_form_of_a_body_is_removed(written, form):
    shapes = {
        "sphere": 100e-6 - np.sqrt(100e-6**2 - (X - 5e-6) ** 2 - (Y + 3e-6) ** 2),
        "cylinder": 0.0 * X + (Y - 2e-6) ** 2 / 2e-3,
        "paraboloid": X**2 / 3e-3 + X * Y / 4e-3 + Y**2 / 5e-3,
    }
    file = FILE.read(written(-shapes[form]), Path())
    assert np.ptp(read_topography(file).heights) > 1e-7
    assert np.ptp(read_topography(file, form=form).heights) < 1e-11


def test_spikes_are_counted_and_filled(written):
    spiky = wave(X, Y)
    spiky[5::9, 4::9] += 4e-6
    file = FILE.read(written(spiky), Path())
    assert read_topography(file).spikes == spiky[5::9, 4::9].size
    filled = read_topography(file, outliers="fill")
    assert (filled.spikes, filled.missing) == (0, spiky[5::9, 4::9].size)
    assert np.abs(filled.heights).max() < 2e-7


def test_a_picture_shows_contact_holes_and_spikes(written):
    heights = wave(X, Y)
    heights[3, 4], heights[20, 10] = np.nan, 5e-6
    figure = measured_map(MeasuredRoughness(written(heights), body="indenter"), 8e-6)
    texts = [text.get_text() for text in figure.legends[0].get_texts()]
    assert texts == ["contact of smooth bodies", "spikes: 1", "not measured: 1 of 1200 points"]
    (spike,) = figure.axes[0].lines  # turned over about the y axis
    assert (*spike.get_xdata(), *spike.get_ydata()) == near((-0.5, -4.5), rel=1e-6)


def test_unsuitable_maps_have_warnings(library, tmp_path):
    x = (np.arange(120) - 59.5) * 5.0  # µm
    ball = -(x[:, None] ** 2 + x**2) / 20e3 + 0.02 * np.sin(x)
    hole = np.ma.masked_where(np.hypot(x[:, None], x) < 100.0, 0.05 * np.sin(x + x[:, None]))

    def told(heights, **keys):
        file = str(tmp_path / "map.nc")
        library.Topography(heights, (600.0, 600.0), unit="um").to_netcdf(file)
        roughness = {"kind": "measured", "file": file, **keys}
        return " ".join(map(str, case_warnings(steel(cycles=100, roughness=roughness))))

    assert "curvature of its indenter twice" in told(ball, body="indenter")
    assert "curvature" not in told(ball, body="indenter", form="sphere")
    assert "missing points" in told(hole)


def test_a_profile_is_read_with_the_units_of_its_first_line_or_refused(tmp_path):
    file = tmp_path / "tip.csv"
    file.write_text("r (mm), z (um)\n0, 1\n0.1, 1.5\n0.2, 3\n0.3, 5.5\n")
    distance, height = read_profile(FILE.read(str(file), Path()))
    np.testing.assert_allclose(distance, [0, 1e-4, 2e-4, 3e-4])
    np.testing.assert_allclose(height, [0, 0.5e-6, 2e-6, 4.5e-6], atol=1e-18)
    with pytest.raises(QuantityError, match="must be the name of a file"):
        FILE.read(3, Path())
    for text, sentence in (
        ("r (mm), z (um)\n0, 0\n1, 1\n", "at least 4 points"),
        ("r (mm), z (um)\n0, 0\n1, nan\n2, 2\n3, 3\n", "all of them numbers"),
        ("r (mm), z (um)\n1, 0\n2, 1\n3, 2\n4, 3\n", "begin at the axis"),
        ("r (mm), z (um)\n0, 1\n1, 0\n2, 2\n3, 3\n", "a convex tip"),
    ):
        file.write_text(text)
        with pytest.raises(QuantityError, match=sentence):
            read_profile(FILE.read(str(file), Path()))
