"""A case from end to end: what the dataset says must agree with itself and with closed forms."""

from dataclasses import dataclass

import numpy as np
import pytest
import xarray as xr

from fretwear.mechanics.contact.problem import Accuracy, ContactError
from fretwear.mechanics.slip.models import Jaeger
from fretwear.mechanics.surfaces.roughness import WavyRoughness
from fretwear.run import progress
from fretwear.run.errors import MARGINS, cell_errors, wear_in_errors
from fretwear.run.progress import progress_bar
from fretwear.run.simulate import ResultWarning, Step, run, simulate, steps
from fretwear.study.case import Case
from fretwear.theory import HertzContact, PartialSlip
from fretwear.variable import ContactState

from ..studies import near, steel
from .conftest import make_case

ROUGH = {"amplitude": "0.2 um", "slope_x": "0.4 deg", "slope_y": "0.3 deg"}

# Fields are stored in single precision.
SINGLE = 2e-7


CASE = {"cycles": 1000, "cell": ("7 um", "9 um"), "output_cycles": (0, 1, 10, 300, 1000)}


def make(**changes):
    return make_case(**(CASE | changes))


KINDS = {
    "smooth": {},
    "rough": {"roughness": ROUGH},
    "smooth capped": {"plastic_limit": "1500 MPa"},
    "rough capped": {"roughness": ROUGH, "plastic_limit": "2000 MPa"},
    "simple slip": {"slip_model": "cattaneo_mindlin", "roughness": ROUGH},
}


@pytest.fixture(scope="module")
def datasets():
    return {name: simulate(make(**changes), quarter=True) for name, changes in KINDS.items()}


def integral(ds, field):
    """Integral of a field over the whole contact, one value a snapshot."""
    cell = float(ds.cell_x) * float(ds.cell_y)
    return 4 * cell * ds[field].astype(float).sum(("x", "y")).to_numpy()


@pytest.mark.parametrize("name", KINDS)
def test_tractions_carry_the_loads_and_wear_grows_at_its_rate(datasets, name):
    ds = datasets[name]
    np.testing.assert_allclose(integral(ds, "pressure"), float(ds["normal_load"]), rtol=1e-6)
    # The Hertz pressure of the simple model is sampled at cell centers: 1 % on this grid.
    rel = 0.02 if name == "simple slip" else 1e-6
    np.testing.assert_allclose(integral(ds, "shear_traction"), float(ds.tangential_load), rtol=rel)
    depth = ds.wear_depth.to_numpy()
    assert not depth[0].any()
    assert (np.diff(depth, axis=0) >= 0).all()
    # One cycle, the first, wears what the rate at cycle 0 says, as long as little changes in it.
    first = ds.wear_rate.to_numpy()[0]
    assert np.abs(depth[1] - first).max() <= 0.02 * first.max()


@pytest.mark.parametrize("name", KINDS)
def test_fields_obey_the_laws_of_coulomb_and_archard(datasets, name):
    ds = datasets[name]
    worn = 4 * float(ds.wear_coefficient) * ds.pressure.astype(float) * ds.slip
    assert np.abs(ds.wear_rate - worn).max() <= SINGLE * worn.max()
    if "smooth" in name:
        # Cells that the edge of stick cuts have the means of both zones.
        r, edge = np.hypot(ds.x, ds.y), ds.stick_half_width_x
        ds = ds.where(np.abs(r - edge) > 0.5 * np.hypot(ds.cell_x, ds.cell_y), 0)
    slipping = (ds.contact_state == ContactState.SLIP) & (ds.pressure > 0)
    shear, bound = ds.shear_traction, float(ds.friction) * ds.pressure
    assert np.abs(shear - bound).where(slipping).max() <= SINGLE * bound.max()
    assert (np.abs(shear) <= bound * (1 + 1e-6)).all()
    assert not ds.slip.where(ds.contact_state == ContactState.STICK, 0).any()
    assert (ds.slip.where(ds.contact_state == ContactState.SLIP, 1) > 0).all()
    assert not ds.pressure.where(ds.contact_state == ContactState.OPEN, 0).any()
    assert (ds.pressure.max() <= float(ds.plastic_limit) * (1 + 1e-6)).all()


@pytest.mark.parametrize(
    "surface", [{"roughness": {**ROUGH, "slope_x": "2 deg"}}, {"plastic_limit": "300 MPa"}]
)
def test_shear_of_the_smooth_contact_is_cut_to_what_friction_bears(surface):
    """And whoever runs it is told, but not where the smooth contact is elastic."""
    simple = {"slip_model": "cattaneo_mindlin", "cycles": 10, "output_cycles": (), "cell": "2 um"}
    with pytest.warns(ResultWarning, match=r"is cut to it \(in [\d.]+ % of the stick zone\)"):
        ds = simulate(make_case(**simple, **surface), quarter=True)
    shear, bound = ds.shear_traction.astype(float), float(ds.friction) * ds.pressure.astype(float)
    assert (np.abs(shear) <= bound * (1 + 1e-6)).all()
    assert (shear == -bound).where(bound > 0).sum() > 0
    assert integral(ds, "shear_traction").min() > float(ds.tangential_load)
    smooth = simulate(make_case(**simple), quarter=True)
    assert "is cut to it" not in smooth.attrs["warnings"]


@pytest.mark.parametrize("name", KINDS)
def test_scalars_are_the_integrals_and_extremes_of_the_fields(datasets, name):
    ds = datasets[name]
    expected = {
        "wear_volume": integral(ds, "wear_depth"),
        "plastic_volume": integral(ds, "plastic_depth"),
        "maximum_wear_depth": ds.wear_depth.max(("x", "y")),
        "peak_pressure": ds.pressure.max(("x", "y")),
        "central_pressure": ds.pressure.isel(x=0, y=0),
        "contact_area": integral(ds, "contact_fraction"),
        "stick_area": integral(ds, "stick_fraction"),
        # Worn volume over K_w is the work of the pressure on the path of slip.
        "dissipated_energy": float(ds.friction)
        * integral(ds, "wear_rate")
        / float(ds.wear_coefficient),
    }
    for key, value in expected.items():
        # Rings have their own extremes and edges.
        on_cells = any(word in key for word in ("area", "maximum", "pressure"))
        rel = 0.08 if "smooth" in name and on_cells else 1e-6
        np.testing.assert_allclose(ds[key], value, rtol=rel, err_msg=key)


@pytest.mark.slow
@pytest.mark.parametrize("beside", [-1e-3, -1e-7, 1.7e-5])
@pytest.mark.parametrize("kind", ["sphere", "cylinder"])
def test_shear_never_exceeds_what_the_pressure_bears_about_the_onset_of_gross_slip(kind, beside):
    """Zones of slip and of stick are narrower there than the cells on which fields are written."""
    keys = {"radius": None, "indenter": {"kind": kind, "radius": "10 mm"}, "load": "50 N"}
    if kind == "cylinder":
        keys |= {"load": "50 N/mm", "tangential_compliance": "0.1 um/(N/mm)"}
    case = make_case(
        **keys, tangential_ratio=None, displacement_ratio=1.0 + beside, cycles=389, cell=None
    )
    ds = simulate(case.replace(error_estimate=False, output_cycles=[38, 194]), quarter=True)
    excess = np.abs(ds.shear_traction.values) - case.friction * ds.pressure.values
    assert excess.max() <= 1e-6 * case.hertz_pressure
    if kind == "cylinder":
        carried = 2 * float(ds.cell_x) * ds.shear_traction.astype(float).sum("x")
        # The written row ends at the last whole cell within the strips.
        np.testing.assert_allclose(carried, ds.tangential_force, rtol=1e-5)


@pytest.mark.slow
def test_gap_outside_an_earlier_window_is_evaluated_not_made_up():
    case = make(tangential_ratio=0.9, cycles=3000, output_cycles=())
    ds = simulate(case, quarter=True)
    first = ds.isel(cycle=0)
    hertz = HertzContact(case.radius, case.load, case.composite_modulus)
    r = np.hypot(first.x, first.y)
    window = 1.3 * hertz.contact_radius
    assert float(ds.x[-1]) > window, "the run should outgrow its first window"
    outer = r > window
    error = np.abs(first.gap - hertz.gap(r)).where(outer).max()
    assert float(error) < 2e-3 * hertz.approach


class Uneven(WavyRoughness):
    """Waves that claim to be even along y alone."""

    even = (False, True)


@pytest.mark.slow
def test_half_domain_and_quarter_give_the_same_dataset(monkeypatch):
    contacts = ("contact", "contact_between", "first_stage")
    reduced = ("first_reduced", "reduced", "reduced_between")
    exact = Accuracy(**dict.fromkeys((*contacts, *reduced), 1e-9))
    monkeypatch.setattr("fretwear.run.states.Accuracy", lambda: exact)
    case = make(**KINDS["rough capped"])
    quarter = simulate(case, quarter=True)
    half = simulate(case.replace(roughness=Uneven(**vars(case.roughness))), quarter=True)
    assert half.symmetry == "even_y"
    assert quarter.symmetry == "even_xy"
    np.testing.assert_allclose(half.x, -half.x[::-1])
    corner = half.sel(x=half.x > 0)
    for key, values in quarter.data_vars.items():
        scale = float(np.abs(values).max())
        if key.endswith("_error"):
            scale = float(np.abs(quarter[key.removesuffix("_error")]).max())
        # Gaps open by about a hundredth of the displacement in the cell that a fraction divides;
        # contacts of a loop have a tolerance of their own.
        rough = key.endswith("_fraction") or key.startswith("sliding_criterion")
        atol = (1e-5 if rough else 1e-7) * scale
        np.testing.assert_allclose(corner[key], values, atol=atol, err_msg=key)


@pytest.mark.slow
def test_history_holds_every_step_and_observers_see_each():
    case, seen = make(roughness=ROUGH), list[Step]()
    result = run(case, [seen.append])
    history, ds = result.history, result.dataset
    np.testing.assert_array_equal(history.cycle, [step.state.cycle for step in seen])
    assert tuple(ds.cycle.to_numpy()) == case.output_cycles
    at_snapshots = np.isin(history.cycle, ds.cycle)
    for key in ("wear_volume", "peak_pressure", "contact_half_width_x"):
        np.testing.assert_array_equal(history[key][at_snapshots], ds[key])
    assert int(history.convolutions.sum()) == seen[-1].state.convolutions
    assert {step.last_cycle for step in seen} == {1000}


@pytest.mark.parametrize(("seconds", "told"), [(0.0, [0, 10, 100]), (3600.0, [0, 100])])
def test_without_a_terminal_lines_tell_the_first_step_the_last_and_some_between(
    seconds, told, monkeypatch
):
    monkeypatch.setattr(progress, "SECONDS_BETWEEN_LINES", seconds)
    case, lines = make(cycles=100, cell="20 um", output_cycles=[10]), []
    every = {step.state.cycle: step for step in steps(case)}
    with progress_bar(case, lines.append) as show:
        for cycle in (0, 10, 100):
            show(every[cycle])
    assert [line.split(":")[1].split(",")[0] for line in lines] == [
        f" cycle {c} of 100" for c in told
    ]


@pytest.mark.slow
def test_materials_matter_through_their_composite_modulus_and_coupling_alone():
    pair = {"youngs_modulus": (208e9, 110e9), "poisson_ratio": (0.3, 0.2)}
    swapped = {key: value[::-1] for key, value in pair.items()}
    jaeger = {"slip_model": "jaeger"}
    first = make(**pair)
    # Equal bodies with the composite modulus E* and the coupling κ of the pair.
    poisson = (2 * first.coupling - 2) / (2 * first.coupling - 1)
    modulus = 2 * first.composite_modulus * (1 - poisson**2)
    equal = {"poisson_ratio": poisson, "youngs_modulus": modulus}
    results = [simulate(make(**changes, **jaeger)) for changes in (pair, swapped, equal)]
    assert make(**equal).composite_modulus == near(first.composite_modulus, rel=1e-14)
    for result in results[1:]:
        for key, values in results[0].data_vars.items():
            # Rounding of E* and κ, as long as it flips no decision of the contact solver.
            scale = float(np.abs(values).max())
            np.testing.assert_allclose(result[key], values, atol=1e-6 * scale, err_msg=key)
    hertz = HertzContact(first.radius, first.load, first.composite_modulus)
    theory = PartialSlip(hertz, first.friction, first.tangential_load, first.coupling)
    moved = float(results[0].tangential_displacement[0])
    assert moved == near(theory.tangential_displacement, rel=2e-3)
    assert first.coupling != near(make().coupling, rel=0.02)
    volumes = [float(ds.wear_volume[-1]) for ds in (results[0], simulate(make(**jaeger)))]
    assert volumes[0] > 1.1 * volumes[1]


@dataclass(frozen=True)
class SlipOnNarrowCells(Jaeger):
    """The slip model of the tests, except that cells wider than usual break it."""

    def reduced(self, problem, *others, **options):
        if problem.coarseness > 1.0:
            raise ContactError("no reduced contact: residual 1.0e+00")
        return super().reduced(problem, *others, **options)


def test_a_twin_that_fails_is_told_and_leaves_the_run_as_it_is():
    alone = simulate(make(error_estimate=False, slip_model="jaeger"))
    with pytest.warns(ResultWarning, match="no estimated errors.*no reduced"):
        dataset = simulate(make(slip_model=SlipOnNarrowCells()))
    assert "no reduced contact: residual 1.0e+00" in dataset.attrs["warnings"]
    assert "wear_volume_error" not in dataset
    np.testing.assert_array_equal(dataset.wear_depth, alone.wear_depth)


def estimates(deviations, times=2.0, values=None, name="approach", unresolved=0.0, **changes):
    """Estimates of a scalar, 1 by default, whose twin deviates at the snapshots as given."""
    values = np.array(values or [1.0] * len(deviations))
    runs = {name: values}, {name: values - deviations}
    return cell_errors(make(**changes), *runs, times, np.full(values.size, unresolved))[name]


def test_an_estimate_takes_what_two_runs_differ_by_at_a_snapshot_and_usually():
    apart, usual, *_ = MARGINS["whole"]
    assert estimates([1e-3]) == near(np.hypot(apart, usual) * 1e-3 / np.sqrt(3.0))
    # Runs that agree by chance err as they usually do, and a hard snapshot counts most.
    *easy, hard = estimates([0.0, 0.0, 0.1], tolerance=1e-5)
    assert easy == near([usual * 0.1 / 3.0] * 2, rel=1e-4)
    assert hard == near(0.1 * np.hypot(apart, usual / np.sqrt(3.0)) / np.sqrt(3.0), rel=1e-4)
    # What has just begun says nothing of the errors of the end.
    _, large = estimates([1e-3, 1e-3], values=[1e-2, 1.0], tolerance=1e-5)
    assert large == near(np.hypot(apart, usual * np.sqrt(2.0)) * 1e-3 / np.sqrt(3.0), rel=1e-3)
    # The wider the cells of the twin, the less of the difference counts.
    assert estimates([1e-3], 3.0)[0] == near(estimates([1e-3])[0] * np.sqrt(3.0 / 8.0))
    # What is missing has no error.
    assert np.isnan(estimates([0.0, 1e-3], values=[np.nan, 1.0])[0])


def test_edges_steps_and_peaks_are_uncertain_even_where_runs_agree():
    case, _, _, cells, steps, _ = make(), *MARGINS["edge"]
    cell = case.width_at_edges / case.hertz_radius
    at_first, later = estimates([0.0, 0.0], name="stick_area")
    assert at_first == near(cells * cell)
    # Cells and steps may err in opposite directions, so that run and twin agree.
    assert later == near(np.hypot(at_first, steps * case.tolerance))
    life = estimates([0.0, 0.0], values=[np.nan, 7.0], name="worn_through_cycle")[1]
    assert life == near(7.0 * MARGINS["life"].steps * case.tolerance)
    np.testing.assert_allclose(estimates([0.0], name="peak_pressure", unresolved=0.5), 0.5, 1e-5)
    assert estimates([0.0], name="peak_pressure", unresolved=np.inf)[0] == np.inf


def test_edges_of_rough_contacts_are_uncertain_by_cells_over_a_quarter_of_a_wave():
    case = make(roughness=ROUGH)
    wave = min(case.roughness.finest)
    expected = MARGINS["edge"].cells * 4.0 * case.width_at_edges / wave
    assert estimates([0.0], name="stick_area", roughness=ROUGH)[0] == near(expected)


def test_wear_usually_errs_as_the_energies_that_it_adds_up():
    one, names = np.ones(2), ("dissipated_energy", "wear_volume")
    runs = dict.fromkeys(names, one), {"dissipated_energy": 1.1 * one, "wear_volume": one}
    found = cell_errors(make(), *runs, 2.0, 0.0 * one)["wear_volume"]
    np.testing.assert_allclose(found, MARGINS["volume"].usual * (0.1 / 1.1) / np.sqrt(3.0))


def test_wear_through_a_coating_usually_errs_by_itself_too():
    """The energy of a stroke has no error, but where the substrate is bare it wears more."""
    one, names = np.ones(2), ("dissipated_energy", "wear_volume")
    twin = {"dissipated_energy": one, "wear_volume": np.array([1.0, 1.1])}
    runs = dict.fromkeys(names, one), twin
    layer = {"thickness": "1 um", "youngs_modulus": "300 GPa", "poisson_ratio": 0.2}
    worn = {"wear_coefficient": "1e-16 / Pa"}
    size, margins = 0.1 / np.hypot(1.0, 1.1) / np.sqrt(3.0), MARGINS["volume"]
    for more, usual, bare in (({}, 0.0, 0.0), (worn, margins.usual * size, 6e-4)):
        case = make(coating={**layer, **more})
        found = cell_errors(case, *runs, 2.0, 0.0 * one)["wear_volume"]
        np.testing.assert_allclose(found[0], usual)
        # Places become bare between two steps, of which there are none before cycle 0.
        apart = margins.apart * 0.1 / np.sqrt(3.0)
        np.testing.assert_allclose(found[1], np.linalg.norm([apart, 1.1 * usual, bare]))


def test_what_is_left_of_a_coating_errs_as_the_depth_that_is_worn():
    depth = np.array([0.2, 0.9, 1.1])
    runs = ({"maximum_wear_depth": d, "dissipated_energy": d} for d in (depth, 1.01 * depth))
    runs = [
        run | {"coating_left": np.maximum(1.0 - run["maximum_wear_depth"], 0.0)} for run in runs
    ]
    errors = cell_errors(make(), *runs, 2.0, 0.0 * depth)
    np.testing.assert_allclose(errors["coating_left"], errors["maximum_wear_depth"] * [1, 1, 0])


def test_late_results_follow_the_time_in_which_load_leaves_the_slip_zone():
    """The load outside the stick zone falls to 1/e² of the whole, on cells of a/100."""
    case = make_case(roughness=None)
    case = case.replace(cell=case.hertz_radius / 100.0, slip_model="coupled")
    share = np.array([0.2, 0.0, 1.0 - np.exp(-2.0)])
    names = ("dissipated_energy", "contact_area")
    scalars = dict.fromkeys(names, np.full(3, 3.0)) | {"stick_load_share": share}
    exact = dict.fromkeys(names, np.zeros(3))
    found = wear_in_errors(case, scalars, exact)
    late = 3.0 * MARGINS["cycle"].worn * 0.1 * (1.0 - np.exp(-2.0)) ** 2 * 2.0
    np.testing.assert_allclose(found["dissipated_energy"], [0.0, 0.0, late])
    assert not found["contact_area"].any()
    falling = case.replace(friction={"cycles": [0, 100], "values": [0.6, 0.3]})
    assert not wear_in_errors(falling, scalars, exact)["dissipated_energy"].any()


def test_errors_of_the_slip_model_are_told_with_those_of_cells_and_apart():
    found = run(make(slip_model="cerruti", cycles=10, output_cycles=[0]))
    for name in ("dissipated_energy", "wear_volume", "approach"):
        of_model = (1.0 - 1.0 / make().coupling) ** 2 / 8.0 * found.dataset[name]
        of_model = 0.0 * of_model if name == "approach" else of_model
        written = found.dataset[f"{name}_error"]
        np.testing.assert_allclose(written, np.hypot(found.errors[name], of_model), rtol=0.05)


@pytest.mark.slow
def test_late_wear_at_the_edge_of_stick_is_within_its_error():
    """Two runs differ by much less than both miss, as both cannot see the edge."""
    case = make_case(tangential_ratio=0.8, slip_model="cerruti", cycles=30_000)
    case = case.replace(output_cycles=(0, 1000, 7000, 15_000, 30_000), cell="6 um")
    ds = simulate(case, quarter=True)
    finer = simulate(case.replace(cell="2 um", error_estimate=False), quarter=True)
    for name in ("wear_volume", "maximum_wear_depth"):
        apart, error = (ds[name] - finer[name])[1:], ds[f"{name}_error"][1:]
        assert (np.abs(apart) <= error).all(), name
        assert error[-1] < 0.2 * ds[name][-1], name


@pytest.mark.slow
def test_smooth_results_are_within_errors_that_are_small_at_first_loading():
    snapshots = (10, 100, 1000, 3000)
    keys = {"cell": None, "accuracy": "none", "output_cycles": snapshots, "slip_model": "jaeger"}
    case = make_case(load="40 N", friction=0.6, cycles=6000, **keys)
    dataset = run(case).dataset
    finer = run(case.replace(tolerance=0.1 * case.tolerance, error_estimate=False)).dataset
    for name in ("approach", "wear_volume", "dissipated_energy", "stick_area"):
        found, error = (np.asarray(dataset[each]) for each in (name, f"{name}_error"))
        assert (np.abs(found - finer[name]) <= error + 1e-4 * np.abs(found)).all()
        assert error[0] <= 1e-3 * np.abs(found[0])
    # The energy falls to a tenth of a percent, and its error grows from snapshot to snapshot.
    energy = dataset.dissipated_energy_error / dataset.dissipated_energy
    assert float(energy[-1]) < 0.05
    assert dataset.attrs["warnings"] == ""


@pytest.mark.slow
def test_the_whole_contact_carries_the_load_and_is_the_quarter_mirrored(
    datasets, capsys, monkeypatch
):
    monkeypatch.setenv("FORCE_COLOR", "1")  # rich takes it for a terminal
    case = make(**KINDS["rough"])
    whole = simulate(case, progress=True)
    assert "cycle 1000 of 1000" in capsys.readouterr().err
    load = whole.pressure.sum(("x", "y")) * float(whole["cell_x"] * whole["cell_y"])
    np.testing.assert_allclose(load, case.load, rtol=SINGLE * 10)
    xr.testing.assert_identical(whole.drop_attrs(), datasets["rough"].fretwear.full().drop_attrs())


@pytest.mark.slow
@pytest.mark.parametrize("ratio", [0.15, 0.3, 0.42, 0.5])
def test_errors_hold_what_friction_along_x_leaves_out(ratio):
    """Energy against friction as a vector on the same cells, which leave nothing else out."""
    asked = {"cell": "8 um", "poisson_ratio": ratio, "cycles": 1, "accuracy": "none"}
    energies = {
        model: simulate(steel(**asked, slip_model=model, error_estimate=False)).dissipated_energy
        for model in ("cerruti", "coupled")
    }
    apart = float(energies["cerruti"][0] / energies["coupled"][0]) - 1.0
    case = steel(**asked, slip_model="cerruti")
    assert 0.85 * case.cells.error_of_slip_model < apart < case.cells.error_of_slip_model
    told = simulate(case)
    for name in ("dissipated_energy", "wear_volume", "maximum_wear_depth"):
        assert (told[f"{name}_error"][-1] > apart * told[name][-1]).item()


@pytest.mark.parametrize(
    ("value", "remedy"),
    [
        ("x.yaml", "load_study('x.yaml').cases()"),
        (None, "load_study(file).cases()"),
        ({"radius": 0.01}, "Case(**parameters)"),
        (["x"], "simulate(case) for case in cases"),
    ],
)
def test_what_is_no_case_is_refused_with_what_makes_one(value, remedy):
    with pytest.raises(TypeError) as caught:
        simulate(value)
    assert remedy in str(caught.value)


def test_parameters_in_a_mapping_are_told_to_be_keywords():
    with pytest.raises(TypeError, match=r"Case\(\*\*parameters\)"):
        Case({"load": "50 N"})
