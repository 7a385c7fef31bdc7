"""The wear map shows the whole scar, to scale, with edges where the zones end."""

import numpy as np
import pytest
from scipy import ndimage

from fretwear import figures
from fretwear.data.dataset import mirrored
from fretwear.data.files import open_case, write_case
from fretwear.figures.maps import take_wear_map


def test_the_map_is_the_last_scar_mirrored_with_circles_for_edges(smooth):
    scar = take_wear_map(smooth, None)
    quarter = smooth["wear_depth"].isel(cycle=-1).values
    half = quarter.shape[0]
    np.testing.assert_array_equal(scar.depth[half:, half:], quarter)
    np.testing.assert_array_equal(scar.depth, scar.depth[::-1])
    np.testing.assert_array_equal(scar.depth, scar.depth[:, ::-1])
    np.testing.assert_array_equal(scar.x, -scar.x[::-1])
    cell = float(smooth["cell_x"])
    last = smooth.isel(cycle=-1)
    for edge, name in ((scar.contact_edge, "contact"), (scar.stick_edge, "stick")):
        radii = np.hypot(*edge.T)
        expected = float(last[f"{name}_half_width_x"])
        # The half-widths along x and y are interpolated inside the cells, each on its own.
        assert np.abs(radii - expected).max() < 0.1 * cell


def test_every_spot_of_a_rough_contact_has_its_own_edge(rough):
    scar = take_wear_map(rough, 0)
    state = rough["contact_state"].isel(cycle=0).values
    _, spots = ndimage.label(mirrored(rough)["contact_state"].isel(cycle=0).values > 0)
    assert spots > 4
    rings = np.split(scar.contact_edge, np.flatnonzero(np.isnan(scar.contact_edge[:, 0])))
    closed = [ring[~np.isnan(ring[:, 0])] for ring in rings]
    assert sum(len(ring) > 0 for ring in closed) >= spots
    # What all contours enclose is the cells in contact, but for their corners.
    area = sum(0.5 * (r[:-1, 0] @ r[1:, 1] - r[1:, 0] @ r[:-1, 1]) for r in closed if len(r))
    cells = 4.0 * (state > 0).sum() * float(rough["cell_x"]) * float(rough["cell_y"])
    assert abs(area) == pytest.approx(cells, rel=0.2)


def test_scars_of_very_different_depths_and_widths_are_all_seen(smooth):
    shallow = smooth.assign(wear_depth=0.1 * smooth["wear_depth"])
    figure = figures.compare_wear_maps({"deep": smooth, "shallow": shallow})
    shades = [axes.get_images()[0].get_array().max() for axes in figure.axes if axes.get_images()]
    norm = figure.axes[0].get_images()[0].norm
    assert norm(shades[1]) == pytest.approx(np.sqrt(0.1), rel=1e-3)
    alike = figures.compare_wear_maps({"one": smooth, "other": smooth})
    scale = alike.axes[0].get_images()[0].norm
    assert scale(0.5 * scale.vmax) == pytest.approx(0.5)
    wide = smooth.assign_coords(y=2.0 * smooth.y)
    wide["contact_half_width_y"] = 2.0 * wide.contact_half_width_y
    figure = figures.compare_wear_maps({"wide": wide, "round": smooth})
    for axes in figure.axes[:2]:
        assert axes.get_ylim()[1] > 1e6 * float(wide.contact_half_width_y[-1])


def test_the_outline_of_a_scar_at_an_angle_is_not_an_ellipse_along_the_axes(smooth):
    whole = mirrored(smooth)
    zone = whole.contact_state.values
    zone[:, whole.x.values > 0.0] *= whole.y.values > 0.0
    turned = whole.assign(contact_state=(whole.contact_state.dims, zone, whole.contact_state.attrs))
    edge = take_wear_map(turned, None).contact_edge
    assert edge[edge[:, 0] > 2e-5, 1].min() > -1e-5


def test_a_mirrored_case_gives_the_same_map_and_profiles(smooth_run, tmp_path):
    write_case(smooth_run.dataset, smooth_run.history, tmp_path / "case.nc")
    with open_case(tmp_path / "case.nc", full=True) as whole:
        map_of_whole = take_wear_map(whole, None)
        profiles = [line.get_xydata() for line in figures.gap_profiles(whole).axes[0].get_lines()]
    quarter = take_wear_map(smooth_run.dataset, None)
    for line, drawn in zip(
        figures.gap_profiles(smooth_run.dataset).axes[0].get_lines(), profiles, strict=True
    ):
        np.testing.assert_allclose(line.get_xydata(), drawn)
    np.testing.assert_array_equal(map_of_whole.depth, quarter.depth)
    np.testing.assert_allclose(map_of_whole.contact_edge, quarter.contact_edge)


def test_the_image_is_to_scale_and_says_its_units(rough, check_texts):
    figure = figures.wear_map(rough)
    axes = figure.axes[0]
    figure.draw_without_rendering()
    (image,) = axes.get_images()
    left, right, bottom, top = image.get_extent()
    assert right == -left == pytest.approx(rough.sizes["x"] * 4.0)
    assert top == -bottom == pytest.approx(rough.sizes["y"] * 4.0)
    assert axes.get_aspect() == 1.0
    words = check_texts(figure)
    assert {"x (µm), direction of slip", "y (µm)", "edge of contact"} <= set(words)
    assert any(text.startswith("Wear depth (") for text in words)


def test_panels_share_one_scale_of_depth_also_with_an_unworn_surface(smooth, rough, check_texts):
    cases = {"smooth": smooth, "rough": rough, "more": rough}
    figure = figures.compare_wear_maps(cases)
    limits = {axes.get_images()[0].get_clim() for axes in figure.axes if axes.get_images()}
    assert len(limits) == 1
    check_texts(figure)
    check_texts(figures.wear_map(smooth, cycle=0))
    with pytest.raises(ValueError, match=r"no snapshot at \[7\].*\[0, 1, 10, 100, 1000\]"):
        figures.wear_map(smooth, cycle=7)
