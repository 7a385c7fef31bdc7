"""Stresses of the dataset of a case."""

import json

import numpy as np
import pytest
import xarray as xr

import fretwear
from fretwear_cracks import StressError
from fretwear_cracks.inputs import surface_of
from fretwear_cracks.stresses import place_of_largest

from ..studies import SELF_AFFINE, line_contact, near, steel

pytestmark = pytest.mark.slow

CELL = 5e-6


@pytest.fixture(scope="module")
def worn():
    return fretwear.simulate(steel(cycles=1000, cell=CELL), quarter=True)


def test_the_central_axis_of_an_unworn_sphere(worn):
    a, peak = float(worn.hertz_radius), float(worn.hertz_pressure)
    z = a * np.array([0.3, 0.5, 1.0])
    found = fretwear.stress(worn, points=np.stack([0 * z, 0 * z, z], axis=1), phases=4)
    assert found.stress_zz.dims == ("phase", "point")
    expected = np.broadcast_to(-peak / (1 + (z / a) ** 2), (4, 3))
    np.testing.assert_allclose(found.stress_zz, expected, atol=3e-3 * peak)
    across = found.stress_xz.isel(phase=[0, 2]).values
    np.testing.assert_allclose(across[0], -across[1], rtol=1e-5)
    np.testing.assert_allclose(found.force, [20, 0, -20, 0], atol=1e-2)


def test_planes_and_points_agree(worn):
    depths = ["12 um", "40 um", 150e-6]
    plane = fretwear.stress(worn, 1000, depths=depths, phases=4, crossland=0.2)
    assert plane.stress_xx.dims == ("phase", "x", "y", "z")
    x, peak = plane.x.values[::9], float(worn.hertz_pressure)
    places = [(each, 0.0, z) for z in plane.z.values for each in x]
    points = fretwear.stress(worn, 1000, points=places, phases=4, crossland=0.2)
    for name in ("stress_xx", "stress_yz", "stress_xz", "von_mises"):
        on_line = points[name].values.reshape(4, 3, x.size)
        middle = plane[name].isel(y=0, x=slice(0, None, 9)).values.swapaxes(1, 2)
        np.testing.assert_allclose(on_line, middle, atol=1e-4 * peak)
    on_line = points.crossland.values.reshape(3, x.size)
    np.testing.assert_allclose(on_line, plane.crossland.values[::9, 0].T, atol=1e-4 * peak)


def test_friction_is_that_of_the_block_that_a_snapshot_ends(worn):
    blocks = [{"cycles": 1000, "friction": 0.5}, {"cycles": 500, "friction": 0.7}]
    case = steel(cycles=None, friction=None, cell=CELL, blocks=blocks)
    found = [surface_of(worn.isel(cycle=0), case, cycle)[0].friction for cycle in (0, 1000, 1500)]
    assert found == [0.5, 0.5, 0.7]


def test_the_constants_are_those_of_the_flat(worn):
    """The flat is the second of two materials."""
    place = {"points": [(-1.3e-4, 0.0, 2e-5)], "phases": 4, "fatemi_socie": (1, 1e9)}
    names = ("youngs_modulus", "poisson_ratio")
    pairs = {f"{n}_{body}": worn[n] / (3 - body) for n in names for body in (1, 2)}
    unlike = worn.drop_vars(names).assign_coords(pairs)
    xr.testing.assert_equal(fretwear.stress(unlike, **place), fretwear.stress(worn, **place))


@pytest.mark.filterwarnings("ignore::fretwear.ResultWarning")
def test_a_rough_contact_that_is_not_even():
    rough = {**SELF_AFFINE, "rms_height": "0.03 um", "shortest_wavelength": "40 um", "seed": 7}
    ds = fretwear.simulate(
        steel(cycles=1, cell="8 um", roughness=rough, error_estimate=False), quarter=True
    )
    assert ds.symmetry == "none"
    place = [(30e-6, 0.0, 25e-6)]
    found = fretwear.stress(ds, points=place, phases=2)
    plane = fretwear.stress(ds, depths=[25e-6], phases=2)
    peak = float(ds.peak_pressure[0])
    for name in ("stress_xx", "stress_xy", "stress_xz"):
        nearest = plane[name].isel(y=0, z=0).interp(x=30e-6)
        np.testing.assert_allclose(nearest, found[name][:, 0], atol=0.02 * peak)


def test_a_line_contact_is_in_plane_strain():
    ds = fretwear.simulate(steel(**line_contact("10 mm", "18 N/mm"), cycles=1))
    half, peak = float(ds.contact_half_width_x[0]), float(ds.peak_pressure[0])
    depths = half * np.array([0.3, 0.786, 2.0])
    found = fretwear.stress(ds, depths=depths, phases=4)
    z = depths / half
    x = found.x.values
    axis = found.isel(phase=1, y=0).interp(x=0.0)
    np.testing.assert_allclose(axis.stress_zz, -peak / np.sqrt(1 + z**2), atol=2e-3 * peak)
    sum_ = 0.3 * (found.stress_xx + found.stress_zz)
    np.testing.assert_allclose(found.stress_yy, sum_, atol=1e-4 * peak)
    assert found.force.attrs["units"] == "N m-1"
    # Strips of both sides have the same stresses as those of one and their images.
    uneven = ds.assign(gap=ds.gap + 1e-13 * (ds.x > 0)).assign_attrs(symmetry="none")
    both = fretwear.stress(uneven, depths=depths, phases=4)
    np.testing.assert_allclose(both.stress_xx, found.stress_xx, atol=1e-3 * peak)
    assert abs(x[0]) == x[-1]


def test_the_parameter_of_ruiz_is_tension_times_friction_work(worn):
    """At x < 0 and at x > 0 alike: the one is in tension at +Q, the other at −Q."""
    found = fretwear.stress(worn, phases=4, depths=[1e-5])
    assert found.ruiz.dims == ("x",)
    np.testing.assert_allclose(found.ruiz, found.ruiz[::-1], rtol=1e-6)
    row = worn.isel(cycle=0, y=0)
    # In the slip annulus, just below the surface.
    place = int(abs(worn.x.values - 0.9 * float(worn.hertz_radius)).argmin())
    below = fretwear.stress(worn, phases=2, points=[(-float(worn.x[place]), 0.0, 1e-8)])
    tension = float(below.stress_xx.max())
    assert tension > 0.1 * float(worn.hertz_pressure)
    work = float(row.shear_traction[place] * row.slip[place])
    value = float(found.ruiz[found.sizes["x"] // 2 + place])
    assert value == near(tension * work, rel=0.01)


def test_worn_stresses_converge_with_the_cell_at_a_depth(worn):
    """Above the edge of stick too, where the pressure of worn elastic bodies is singular."""
    a = float(worn.hertz_radius)
    points = [(0.585 * a, 0.0, z * a) for z in (0.1, 0.2, 0.5)]
    found = []
    for cell in ("10 um", CELL, "2.5 um"):
        case = steel(cycles=1000, cell=cell, error_estimate=False)
        last = fretwear.simulate(case, quarter=True)
        found.append(fretwear.stress(last, 1000, points=points, phases=2).stress_xx.values)
    coarse, fine = (abs(each - found[-1]).max(axis=0) for each in found[:2])
    assert (fine < 0.5 * coarse).all()
    assert (fine < 0.01 * float(worn.hertz_pressure)).all()


def test_datasets_without_a_loop_of_stresses_are_refused(worn):
    still = worn.assign(shear_traction=0.0 * worn.shear_traction)
    stroke = {**json.loads(worn.parameters), "sliding_amplitude": 5e-6}
    stroke |= {"tangential_load": None, "wear_coefficient": [1e-14, 1e-14]}
    unworn = {**json.loads(worn.parameters), "slip_model": "cattaneo_mindlin"}
    for wrong, reason in (
        (worn.assign_attrs(parameters=json.dumps(stroke)), "over a stroke moves over the flat"),
        (worn.assign_attrs(parameters=json.dumps(unworn)), "slip of the unworn contact"),
        (still, "no shear traction"),
        (worn.drop_vars("gap"), "lacks gap"),
        (xr.Dataset(), "is not a case"),
    ):
        with pytest.raises(StressError, match=reason):
            fretwear.stress(wrong)
    for phases in (0, 31, 4.5):
        with pytest.raises(StressError, match="must be an even number"):
            fretwear.stress(worn, phases=phases)


def test_friction_in_two_directions_shears_planes_of_equal_depth_along_both():
    """Just below a cell, planes of equal depth bear its tractions; along the loop they reverse."""
    case = steel(cycles=300, cell="5 um", slip_model="coupled", error_estimate=False)
    ds = fretwear.simulate(case, quarter=True)
    last = ds.isel(cycle=-1)
    i, j = np.unravel_index(abs(last.shear_traction_y.values).argmax(), last.pressure.shape)
    below = [(float(ds.x[i]), float(ds.y[j]), 1e-9), (float(ds.x[i]), -float(ds.y[j]), 1e-9)]
    found = fretwear.stress(ds, 300, points=below, phases=8)
    along, across = last.shear_traction.values[i, j], last.shear_traction_y.values[i, j]
    assert abs(across) > 0.03 * along
    np.testing.assert_allclose(found.stress_xz[0], [-along, -along], rtol=1e-3)
    np.testing.assert_allclose(found.stress_yz[0], [-across, across], rtol=1e-3)
    np.testing.assert_allclose(found.stress_yz[4], -found.stress_yz[0], rtol=1e-5)
    turned = np.hypot(found.stress_xz, found.stress_yz)
    bound = float(ds.friction * last.pressure.values[i, j])
    assert (turned <= (1 + 1e-3) * bound).all()
    np.testing.assert_allclose(
        found.force / found.force[0], [1, 0.5, 0, -0.5, -1, -0.5, 0, 0.5], atol=2e-3
    )
    quarter, whole = (
        fretwear.stress(each, 300, depths=[20e-6], phases=4) for each in (ds, ds.fretwear.full())
    )
    xr.testing.assert_allclose(quarter.stress_xx, whole.stress_xx, rtol=1e-4)
    single = fretwear.stress(ds.drop_vars("shear_traction_y"), 300, depths=[20e-6], phases=4)
    assert abs(single.stress_yy - quarter.stress_yy).max() > 0.005 * abs(quarter.stress_yy).max()


def test_equal_values_have_their_first_place_whatever_the_last_bits():
    values = np.array([[1.0, 3.0, 1.0], [2.0, 1.0, 3.0 * (1.0 + 1e-9)], [np.nan, 1.0, 0.0]])
    assert place_of_largest(values) == (0, 1)
    assert place_of_largest(-values) == (2, 2)
