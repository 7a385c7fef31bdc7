import json

import numpy as np
import pytest
import xarray as xr

from fretwear.run.simulate import run
from fretwear.study.case import Case
from fretwear.study.reading import load_study
from fretwear_fit.comparison import Comparison
from fretwear_fit.noise import Noise
from fretwear_fit.runs import predicted
from fretwear_fit.search import fit
from fretwear_fit.section import fit_figures, fit_sections

from ..studies import TITANIUM, VOLUME, base, near, write_study
from .conftest import measured

pytestmark = pytest.mark.slow


def test_a_first_fit_of_the_titanium_scar_is_reproduced(titanium):
    """K of each body 1.09e-13 / Pa within 4.5 %, debris 0.948: a fit by hand, of 20 runs."""
    low, high = titanium.interval("wear_coefficient", 0.9)
    assert low < 2 * 1.09e-13 < high
    assert np.log(high / low) / (2 * 1.645) == pytest.approx(0.045, abs=0.015)
    low, high = titanium.interval("debris_fraction", 0.9)
    assert low < 0.948 < high
    assert titanium.p_value > 0.05


def test_intervals_end_where_chi_square_has_risen_by_their_quantile(titanium):
    """Along a profile; the draws from the posterior have about the same quantiles."""
    emulator = titanium.emulator
    for place, name in enumerate(titanium.names):
        for level, rise in ((0.68, 0.989), (0.95, 3.841)):
            for u in titanium.profiles[place].ends_at(level):
                misfit = float(emulator.misfit(u))
                assert misfit - titanium.misfit == near(rise, rel=0.1)
        draws = titanium.unknowns[place].value(titanium.posterior.draws[..., place])
        ends = np.quantile(draws, (0.16, 0.84))
        low, high = titanium.interval(name, 0.68)
        assert ends == pytest.approx((low, high), abs=0.25 * (high - low))


def test_a_fit_resumes_from_the_runs_that_it_kept(titanium):
    assert titanium.computed == 0
    assert titanium.runs == len([*titanium.study.file.parent.glob("runs/*.nc")]) <= 40


def test_the_files_have_the_conventions_of_arviz(titanium, tmp_path):
    titanium.write(tmp_path / "fit.nc")
    titanium.write_json(tmp_path / "fit.json")
    stored = json.loads((tmp_path / "fit.json").read_text())
    told = stored["parameters"]["debris_fraction"]
    assert {"value", "low", "high", "level", "unit"} <= told.keys()
    assert told["low"] < told["value"] < told["high"]
    assert stored["correlation"]["wear_coefficient"]["wear_coefficient"] == near(1.0)
    for group in ("posterior", "prior"):
        with xr.open_dataset(tmp_path / "fit.nc", group=group) as draws:
            assert dict(draws.sizes) == {"chain": 4, "draw": 1000}
            assert draws["wear_coefficient"].attrs["units"] == "Pa-1"
    with (
        xr.open_dataset(tmp_path / "fit.nc", group="observed_data") as data,
        xr.open_dataset(tmp_path / "fit.nc", group="posterior_predictive") as predicted,
    ):
        inside = np.abs(data["data_1"] - predicted["data_1"].mean(("chain", "draw")))
        assert (inside < 3.0 * predicted["data_1"].std(("chain", "draw"))).all()


def study_of(tmp_path, free, *data, **base):
    # The laws below are exact at any tolerance of the steps.
    content = {"base": TITANIUM | {"tolerance": 0.1} | base, "fit": {"free": free, "data": [*data]}}
    return load_study(write_study(tmp_path / "numbers.yaml", content))


def test_readings_without_a_scar_give_an_upper_limit(tmp_path):
    x, noise = np.linspace(-4.0, 4.0, 161), np.random.default_rng(0).normal(scale=5.0, size=161)
    rows = (f"{a},{b}" for a, b in zip(x, noise, strict=True))
    (tmp_path / "flat.csv").write_text("\n".join(["x (mm),depth (um)", *rows]))
    free = {"wear_coefficient": ["1e-16 / Pa", "1e-12 / Pa"]}
    data = {"file": "flat.csv", "quantity": "wear_depth"}
    found = fit(study_of(tmp_path, free, data, error_estimate=False))
    low, high = found.interval("wear_coefficient")
    assert low == near(1e-16)
    assert 1e-15 < high < 2e-13
    assert found.is_open("wear_coefficient") == (True, False)


def test_tests_share_a_coefficient_and_have_their_own_friction(tmp_path):
    """Forces µP give each friction, both volumes 4 K P δ N one K: 3 %/√2."""
    tests = ((1066e3, 75e-6, 0.6), (500e3, 60e-6, 0.4))
    data = []
    for number, (load, slip, friction) in enumerate(tests, start=1):
        volume, force = 4 * 2e-13 * load * slip * 500, friction * load
        numbers = {"wear_volume": (f"{volume * 1e6} mm^2", "3 %")}
        numbers["tangential_force"] = (f"{force / 1e3} N/mm", "2 %")
        for quantity, (value, error) in numbers.items():
            data.append({"quantity": quantity, "test": number, "value": value, "error": error})
    free = {"wear_coefficient": ["1e-14 / Pa", "1e-12 / Pa"]}
    free["friction"] = {"from": 0.2, "to": 0.9, "each": True}
    base = {
        name: value for name, value in TITANIUM.items() if name not in ("load", "sliding_amplitude")
    }
    vary = {"load": ["1066 N/mm", "500 N/mm"], "sliding_amplitude": ["75 um", "60 um"]}
    fitted = {"free": free, "data": data}
    content = {"base": base, "vary": vary, "design": "zip", "fit": fitted}
    found = fit(write_study(tmp_path / "two.yaml", content))
    assert found.names == ["wear_coefficient", "friction[1]", "friction[2]"]
    assert [*found.values.values()] == near([2e-13, 0.6, 0.4], rel=2e-3)
    low, high = found.interval("wear_coefficient", 0.68)
    assert np.log(high / low) / 2 == near(0.03 / np.sqrt(2), rel=0.1)
    assert found.runs <= 60


def test_a_ridge_of_coefficient_and_slip_is_sampled_along_its_whole_length(tmp_path):
    """Only K δ is known, to 2 %: intervals are those of the draws."""
    free = {
        "wear_coefficient": ["1e-13 / Pa", "4e-13 / Pa"],
        "sliding_amplitude": ["50 um", "100 um"],
    }
    found = fit(study_of(tmp_path, free, VOLUME))
    assert "correlation" in found.posterior.reason
    assert found.posterior.is_checked
    (told,) = (warning for warning in found.warnings if "together only" in warning)
    assert "wear_coefficient · sliding_amplitude^1" in told
    u = found.posterior.draws.reshape(-1, 2)
    coefficient, slip = np.exp(u[:, 0]), found.unknowns[1].value(u[:, 1])
    product = np.log(coefficient * slip)
    assert product.std() == pytest.approx(0.02, rel=0.15)
    assert product.mean() == pytest.approx(np.log(2e-13 * 75e-6), abs=0.005)
    # Along the ridge the prior is uniform in ln δ: from 50 to 100 µm.
    assert np.quantile(np.log(slip / 50e-6), (0.1, 0.5, 0.9)) == pytest.approx(
        np.log(2) * np.array([0.1, 0.5, 0.9]), abs=0.06
    )
    assert found.runs <= 40


SLIDING = {
    **base(tangential_ratio=None, displacement_amplitude="4 um", friction=0.6),
    **{"rig_stiffness": "30 N/um", "cycles": 1},
}


def loop_file(folder, case, noise):
    """A loop of a case at cycle 0, off the center, whose readings scatter."""
    loops, generator = run(case).loops.isel(cycle=0), np.random.default_rng(1)
    force, where = loops["force"].values, loops["displacement"].values * 1e6
    places = np.linspace(0, where.size - 1, 90)
    force, where = (np.interp(places, np.arange(where.size), each) for each in (force, where))
    force += noise * generator.normal(size=90) + 1.0
    where += 0.02 * generator.normal(size=90) - 0.1
    rows = (f"{a},{b}" for a, b in zip(where, force, strict=True))
    (folder / "loop.csv").write_text("\n".join(["displacement (um),force (N)", *rows]))


def test_a_loop_tells_friction_and_the_stiffness_of_the_rig(tmp_path):
    """A sphere slides as a whole; the center of the loop is fitted too."""
    loop_file(tmp_path, Case(**SLIDING, error_estimate=False), 0.3)
    data = {"file": "loop.csv", "quantity": "loop", "cycle": 0, "force_noise": "0.3 N"}
    free = {"friction": [0.3, 1.0], "rig_stiffness": ["5 N/um", "400 N/um"]}
    content = {"base": SLIDING | {"friction": 0.4, "rig_stiffness": "60 N/um"}}
    content |= {"fit": {"free": free, "data": [data | {"noise": "0.02 um"}]}}
    content |= {"output": {"cycles": [0]}}
    found = fit(write_study(tmp_path / "loop.yaml", content))
    for name, true, width in (("friction", 0.6, 0.01), ("rig_stiffness", 30e6, 1e6)):
        low, high = found.interval(name, 0.95)
        assert low < true < high < low + width
    assert found.p_value > 0.05
    ((comparison, _, nuisances),) = found.measurements
    assert dict(zip(comparison.names, nuisances, strict=True)) == {
        "offset": pytest.approx(1.0, abs=0.15),
        "shift": pytest.approx(-1e-7, abs=2e-8),
    }
    found.write(tmp_path / "fit.nc")
    (figure,) = fit_figures(xr.Dataset(), tmp_path / "cases")
    axes, residuals = figure.figure.axes
    assert residuals.get_xlabel() == "Displacement (µm)"
    assert axes.get_ylabel() == "Force (N)"
    readings, curve = axes.get_lines()
    off = curve.get_ydata() - readings.get_ydata()
    x = readings.get_xdata()
    assert np.abs(off[np.abs(x) < 0.9 * x.max()]).max() < 4 * 0.3 + 0.1


FORCE = {"quantity": "tangential_force", "value": "640 N/mm", "error": "2 %"}


def test_estimated_errors_of_runs_enter_the_interval(tmp_path):
    """A shallow depth, as good as linear in K, is known to 0.1 %, less than its own error."""
    depth = {"quantity": "maximum_wear_depth", "value": "0.3 um", "error": "0.1 %"}
    found = fit(study_of(tmp_path, {"wear_coefficient": ["1e-16 / Pa", "1e-12 / Pa"]}, depth))
    low, high = found.interval("wear_coefficient", 0.68)
    ((comparison, signal, _),) = found.measurements
    error = comparison.deviations[0] / signal[0]
    assert error > 1e-4
    assert np.log(high / low) / 2 == pytest.approx(np.hypot(1e-3, error), rel=0.05)


def test_readings_of_a_loop_narrower_than_their_noise_stay_with_its_halves():
    """A loop as wide as the scatter lies nearer to them than the true one does."""
    turn = np.linspace(0.0, 2 * np.pi, 240, endpoint=False)
    x = np.cos(turn)
    force = x - 0.05 * np.sin(turn) + np.random.default_rng(1).normal(scale=0.1, size=240)
    keys = {"noise": 1e-3, "force_noise": 0.1, "baseline": ()}
    comparison = Comparison(measured(x, force, "loop", **keys), 0)
    around = np.linspace(0.0, 2 * np.pi, 257)

    def misfit(width):
        loop = np.concatenate([np.cos(around), np.cos(around) - width * np.sin(around)])
        return comparison.misfit(loop, np.zeros(0))

    widths = np.linspace(0.0, 0.15, 16)
    assert widths[np.argmin([misfit(width) for width in widths])] == pytest.approx(0.05, abs=0.021)
    assert misfit(0.05) == pytest.approx(240, rel=0.2)


def test_a_profile_in_coordinates_of_the_instrument_is_found_amid_its_readings(tmp_path):
    case = study_of(tmp_path, {"friction": [0.1, 0.9]}, FORCE).points()[0].case
    worn = predicted(case.replace(error_estimate=False), {("wear_depth", "x")})
    x = np.linspace(-5e-3, 5e-3, 201)
    line, shift = worn["wear_depth_x"].isel(cycle=-1), 20.4e-3
    depth = np.interp(x + 20e-3 - shift, line["x"].values, line.values, 0.0, 0.0)
    comparison = Comparison.of(measured(x + 20e-3, depth + 1e-6, noise=1e-6), worn)
    settled = comparison.settled(comparison.signal(worn))
    assert settled[2] == pytest.approx(shift, abs=1e-5)
    assert settled[0] == pytest.approx(1e-6, abs=1e-8)


def test_a_scar_is_found_where_it_is_though_the_first_prediction_is_three_times_too_deep():
    """Beyond the readings such a scar would leave less of them unexplained than at its place."""
    x, true = np.linspace(-1e-3, 1e-3, 201), 5e-5
    depth = np.maximum(1e-6 * (1.0 - ((x - true) / 4e-4) ** 2), 0.0)
    scar = measured(x, depth, noise=1e-7)
    grid = np.linspace(-2e-3, 2e-3, 801)
    deep = np.maximum(3e-6 * (1.0 - (grid / 4e-4) ** 2), 0.0)
    settled = Comparison(scar, 0, Noise(1e-7, 0.0), grid=grid).settled(deep)
    assert settled[2] == pytest.approx(true, abs=1e-5)


def test_the_report_shows_the_fit(titanium, tmp_path):
    titanium.write(tmp_path / "fit.nc")
    titanium.write_json(tmp_path / "fit.json")
    (section,) = fit_sections(xr.Dataset(), tmp_path / "cases")
    for text in (*titanium.names, "0.952", *titanium.warnings):
        assert text in section.body
    (figure,) = fit_figures(xr.Dataset(), tmp_path / "cases")
    upper, lower = figure.figure.axes
    ((comparison, signal, nuisances),) = titanium.measurements
    x, depth = comparison.measurement.readings
    fitted = comparison.modelled(signal, nuisances)
    readings, curve = upper.get_lines()
    assert readings.get_xydata() == pytest.approx(np.column_stack([x * 1e3, depth * 1e6]))
    # The line is the best run, not a mean of draws with noise.
    assert curve.get_ydata() == pytest.approx(fitted * 1e6, rel=1e-9)
    residuals = lower.get_lines()[1].get_ydata()
    assert residuals == pytest.approx(depth * 1e6 - curve.get_ydata())
