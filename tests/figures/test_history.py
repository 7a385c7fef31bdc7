"""Results over the cycles, axes of cycles and parameters, and the cases that stand for a study."""

import numpy as np
import pytest
import xarray as xr
from matplotlib.figure import Figure

from fretwear import figures, open_history
from fretwear.figures.axes import ValueAxis, set_cycle_axis
from fretwear.figures.history import representative_cases, study_curves
from fretwear.figures.style import JournalFigure
from fretwear.results import RESULTS
from fretwear.run.simulate import run

from ..studies import steel


def axes_of_cycles(cycles):
    axes = JournalFigure(1, 60.0).subplots()
    set_cycle_axis(axes, cycles)
    axes.figure.draw_without_rendering()
    return axes


def place(axes, cycle):
    """Where a cycle lies along the axis, from 0 to 1."""
    return float(axes.transAxes.inverted().transform(axes.transData.transform((cycle, 0.0)))[0])


def test_decades_are_equally_long_after_a_linear_part_from_zero():
    axes = axes_of_cycles([0, 10, 100, 1000, 30000])
    zero, *decades = (place(axes, cycle) for cycle in (0, 10, 100, 1000, 10000))
    np.testing.assert_allclose(np.diff(decades), decades[1] - decades[0], rtol=1e-9)
    assert 0.0 <= zero < decades[0] < decades[1] < place(axes, 30000) <= 1.0
    assert axes_of_cycles([0, 2000, 7000]).get_xscale() == "linear"
    assert axes_of_cycles([10, 100, 1000]).get_xscale() == "log"


def test_values_over_decades_have_a_logarithmic_axis_and_steady_ones_begin_at_zero():
    assert ValueAxis(RESULTS["wear_volume"], np.array([0.0, 1e-15, 1e-12])).is_logarithmic
    axis = ValueAxis(RESULTS["peak_pressure"], np.array([1.0e9, 1.01e9]))
    axes = Figure().subplots()
    axis.apply(axes)
    assert not axis.is_logarithmic
    assert axes.get_ylim()[0] == 0.0
    assert axis.label == "Peak pressure (MPa)"


def curves(figure):
    return [line for axes in figure.axes for line in axes.get_lines()]


@pytest.mark.slow
def test_a_figure_from_the_file_alone_goes_through_every_step(small_study):
    summary = xr.open_dataset(small_study.cases.parent / "summary.nc")
    part = summary.sel(normal_load=30, roughness_amplitude=0, plastic_limit=np.inf)
    (curve,) = curves(figures.scalar_history(part, "wear_volume"))
    with open_history(small_study.cases / f"{part['case_id'].item()}.nc") as history:
        kept = history["cycle"].values
        np.testing.assert_array_equal(curve.get_xdata(), kept)
        drawn = curve.get_ydata()
        volumes = history["wear_volume"].values
        np.testing.assert_allclose(drawn / drawn[-1], volumes / volumes[-1], rtol=1e-6)
    snapshots = part.load()
    snapshots.encoding.clear()
    (curve,) = curves(figures.scalar_history(snapshots, "wear_volume"))
    assert curve.get_xdata().tolist() == part["cycle"].values.tolist()


@pytest.mark.slow
def test_panels_colours_and_lines_stand_for_the_varied_parameters(small_study, check_texts):
    summary = small_study.summary
    figure = figures.scalar_history(summary, "contact_half_width_x")
    assert len(curves(figure)) == 8
    titles = [axes.get_title(loc="left") for axes in figure.axes]
    assert titles[0].startswith(r"$\bf{a}$")
    assert titles[1].endswith("elastic")  # infinity is the highest level
    (key,) = figure.legends
    assert [text.get_text() for text in key.get_texts()] == [
        "$P$ = 30 N",
        "$P$ = 40 N",
        "smooth",
        "$h_\\mathrm{a}$ = 0.3 µm",
    ]
    check_texts(figure)
    with pytest.raises(ValueError, match=r"takes 2 panels.*dataset\.isel"):
        figures.scalar_history(summary, "wear_volume", ax=Figure().subplots())


@pytest.mark.slow
def test_points_that_are_not_done_are_left_out(small_study):
    summary = small_study.summary.copy(deep=True)
    summary.encoding.clear()
    summary["wear_volume"][0, 0, 0] = np.nan
    summary["contact_half_width_x"][0, 0, 0] = np.nan
    assert len(curves(figures.scalar_history(summary, "wear_volume"))) == 7


def test_seeds_are_drawn_by_their_mean_and_deviation():
    values = np.array([[1.0, 2.0], [2.0, 4.0], [6.0, 9.0]])
    seeds = xr.Dataset(
        {"peak_pressure": (("roughness_seed", "cycle"), 1e9 * values)},
        {"roughness_seed": [1, 2, 3], "cycle": [0, 5]},
    )
    (axes,) = figures.scalar_history(seeds, "peak_pressure").axes
    (line,) = axes.get_lines()
    np.testing.assert_allclose(line.get_ydata(), [3000.0, 5000.0], rtol=1e-12)
    (band,) = axes.collections
    ends, deviation = band.get_paths()[0].vertices[:, 1], 1000.0 * values.std(axis=0, ddof=1)
    assert ends.min() == pytest.approx(3000.0 - deviation[0])
    assert ends.max() == pytest.approx(5000.0 + deviation[1])


def points(**attributes):
    """Wear depths of twenty points, from 1 nm to friction³ nm."""
    rng = np.random.default_rng(1)
    load, friction = rng.uniform(1.0, 20.0, (2, 20))
    depth = 1e-9 * np.stack([np.ones(20), friction**3], axis=1)
    coordinates = {"friction": ("point", friction, attributes), "radius": ("point", load)}
    variables = {"maximum_wear_depth": (("point", "cycle"), depth)}
    return xr.Dataset(variables, {"cycle": [0, 10], **coordinates})


def test_many_listed_points_have_a_colour_bar_of_the_first_parameter_with_numbers():
    panel, bar = figures.scalar_history(points(), "maximum_wear_depth").axes
    assert len(panel.get_lines()) == 20
    assert "friction" in bar.get_ylabel().lower()
    low, high = bar.get_ylim()
    assert sum(low <= tick <= high for tick in bar.get_yticks()) >= 3


def test_a_sample_is_drawn_by_its_median_and_two_bands():
    sample = points(drawn_from=1.0)
    figure = figures.scalar_history(sample, "maximum_wear_depth")
    (panel,) = figure.axes
    (median,) = panel.get_lines()
    last = 1e-3 * np.quantile(sample["friction"].values ** 3, [0.1, 0.25, 0.5, 0.75, 0.9])
    np.testing.assert_allclose(median.get_ydata(), [1e-3, last[2]])  # µm
    for band, ends in zip(panel.collections, (last[[0, 4]], last[[1, 3]]), strict=True):
        at_end = [y for x, y in band.get_paths()[0].vertices if x == 10.0]
        np.testing.assert_allclose([min(at_end), max(at_end)], ends)
    assert figure.caption.startswith("Maximum wear depth against the number of cycles, median of")


@pytest.mark.slow
def test_the_corners_of_roughness_and_plastic_limit_stand_for_a_study(small_study):
    summary = small_study.summary
    chosen = representative_cases(summary)
    assert chosen.contrasts == ("roughness_amplitude", "plastic_limit")
    assert len(chosen.ids) == 4
    assert chosen.common == "normal load 40 N, 4 of 8 cases"
    point = summary.sel(normal_load=40, roughness_amplitude=3e-7, plastic_limit=4.5e9)
    assert point["case_id"].item() in chosen.ids.values()
    summary = summary.copy(deep=True)
    summary["status"][1] = 1
    assert "30 N" in representative_cases(summary).common


@pytest.fixture(scope="module")
def smooth():
    """The steps of a smooth contact, short ones before each snapshot and long ones after it."""
    loads = {"load": "45 N", "friction": 0.2, "tangential_ratio": 0.7, "slip_model": "jaeger"}
    cycles = {"cycles": 500, "output_cycles": [1, 10, 100, 250]}
    return run(steel(**loads, **cycles, error_estimate=False)).history


@pytest.mark.parametrize("zone", ["contact", "stick"])
def test_widths_of_smooth_bodies_change_without_a_step(smooth, zone):
    (curve,) = study_curves(smooth, f"{zone}_radius")
    np.testing.assert_array_equal(curve.cycles, smooth["cycle"])
    assert (np.diff(curve.cycles) > 0.0).all()


def test_a_width_steps_by_what_exceeds_its_growth_where_a_spot_has_joined_and_an_area_never():
    widths = [1.0, 1.25, 2.5, 3.0, 3.25]
    spots, cycles = ("step", [0, 0, 1, 1, 1]), ("step", [0, 10, 30, 40, 50])
    history = xr.Dataset(dict.fromkeys(("contact_radius", "contact_area"), ("step", widths)))
    history = history.assign(contact_spots=spots).assign_coords(cycle=cycles)
    (curve,) = study_curves(history, "contact_radius")
    assert curve.cycles.tolist() == [0, 10, 30, 30, 40, 40, 50, 50]
    # The widths grow by 0.025 a cycle before the spots join: 1.25 + 20·0.025.
    np.testing.assert_allclose(curve.values, [1.0, 1.25, 1.75, 2.5, 2.75, 3.0, 3.25, 3.25])
    (area,) = study_curves(history, "contact_area")
    assert area.values.tolist() == widths
    fast = history.assign(contact_radius=("step", [1.0, 2.0, 2.5, 3.0, 3.25]))
    assert study_curves(fast, "contact_radius")[0].values[2:4].tolist() == [2.5, 2.5]


def test_a_wear_volume_begins_at_the_first_cycle_in_proportion_to_the_energy(smooth):
    """A run that has a step of one cycle says how much the first cycle wears."""
    (curve,) = study_curves(smooth, "wear_volume")
    assert curve.cycles[:2].tolist() == [0.0, 1.0]
    (later,) = study_curves(
        smooth.isel(step=smooth["cycle"].isin([0, 10, 100, 500])), "wear_volume"
    )
    assert later.cycles[:3].tolist() == [0.0, 1.0, 10.0]
    np.testing.assert_allclose(later.values[1], curve.values[1], rtol=1e-3)


def test_lives_of_coatings_stand_over_their_thickness_with_errors():
    dims, thickness = ("coating_thickness", "friction", "cycle"), np.array([2e-6, 1e-6, 4e-6])
    # A thick coating may hold.
    lives = np.array([[60.0, 30.0], [20.0, 10.0], [np.nan, 80.0]])
    table = np.stack([np.full((3, 2), np.nan), lives], axis=-1)
    study = xr.Dataset(
        {
            "worn_through_cycle": (dims, table),
            "worn_through_cycle_error": (dims, 0.1 * table),
            "wear_volume": (dims, np.ones((3, 2, 2))),
            "status": (dims[:2], np.zeros((3, 2), int)),
        },
        {
            "coating_thickness": ("coating_thickness", thickness, {"units": "m"}),
            "friction": ("friction", [0.3, 0.6], {"units": "1"}),
            "cycle": [0, 100],
        },
    )
    figure = figures.coating_life(study)
    (axes,) = figure.axes
    slippery, rough = (container[0] for container in axes.containers)
    np.testing.assert_allclose(slippery.get_xydata(), [[1.0, 20.0], [2.0, 60.0]])
    np.testing.assert_allclose(rough.get_xydata(), [[1.0, 10.0], [2.0, 30.0], [4.0, 80.0]])
    (bars,) = axes.containers[0][2]
    np.testing.assert_allclose(bars.get_segments()[0][:, 1], [18.0, 22.0])
    sample = study.isel(friction=0, drop=True).rename_dims(coating_thickness="point")
    (points,) = figures.coating_life(sample).axes[0].containers
    assert points[0].get_linestyle() == "None"
    with pytest.raises(ValueError, match="No coating is worn through"):
        figures.coating_life(study.isel(cycle=[0]))


@pytest.mark.parametrize("dims", [("coating", "friction"), ("friction", "coating")])
def test_lives_of_coatings_that_are_varied_as_a_whole_leave_out_bare_bodies(dims):
    lives = xr.DataArray(
        [[np.nan, np.nan], [20.0, 10.0], [60.0, 30.0]], dims=("coating", "friction")
    )
    thickness = xr.full_like(lives, 1e-6) * xr.DataArray([np.nan, 1.0, 2.0], dims="coating")
    study = xr.Dataset(
        {"worn_through_cycle": lives.expand_dims(cycle=[100]), "status": xr.zeros_like(lives)},
        {"coating_thickness": thickness.assign_attrs(units="m"), "friction": [0.3, 0.6]},
    ).transpose(*dims, "cycle")
    study["friction"].attrs["units"] = "1"
    (axes,) = figures.coating_life(study).axes
    slippery, rough = (container[0] for container in axes.containers)
    np.testing.assert_allclose(slippery.get_xydata(), [[1.0, 20.0], [2.0, 60.0]])
    np.testing.assert_allclose(rough.get_xydata(), [[1.0, 10.0], [2.0, 30.0]])
    assert axes.get_xticks().tolist() == [1.0, 2.0]
