"""What the explorer shows from above is what the case files say."""

import base64

import numpy as np
import pytest

from fretwear.data.files import open_case, write_case
from fretwear.data.safe import CaseFileError
from fretwear.figures.bearing import bearing_heights
from fretwear.report.above import MAPS, read_above
from fretwear.running.simulate import run
from fretwear.units import MEGAPASCAL, MICROMETRE

from ..studies import steel

RANDOM = {
    "kind": "self_affine", "rms_height": "0.1 um", "hurst": 0.8, "rolloff_wavelength": "60 um",
    "shortest_wavelength": "30 um", "seed": 3,
}  # fmt: skip


@pytest.fixture(scope="module")
def case():
    return steel(roughness=RANDOM, error_estimate=False, cycles=30)


@pytest.fixture(scope="module")
def file(case, tmp_path_factory):
    path = tmp_path_factory.mktemp("above") / f"{case.case_id}.nc"
    result = run(case)
    write_case(result.dataset, result.history, path, result.loops)
    return path


@pytest.fixture(scope="module")
def above(case, file):
    return read_above(file, case, np.array([0.0, 30.0]))


def test_maps_keep_loads_and_volumes_within_a_255th(file, above):
    assert above.view is not None
    view = above.view
    area = (view.x[1] - view.x[0]) * (view.y[1] - view.y[0])
    assert max(view.x.size, view.y.size) <= 64
    with open_case(file) as stored:
        loads = view.fields["pressure"].sum(axis=(1, 2)) * area
        # Half a square at each end may be dropped, where hardly anything touches.
        assert loads == pytest.approx(stored["normal_force"].values, rel=1e-3)
        volume = view.fields["wear_depth"][-1].sum() * area
        assert volume == pytest.approx(float(stored["wear_volume"][-1]), rel=1e-3)
    assert above.view is not None
    units = {"pressure": MEGAPASCAL, "wear_depth": MICROMETRE}
    packed = above.view.packed(units)
    counts = packed["y"][2], packed["x"][2]
    assert packed["x"][0] + (counts[1] - 1) * packed["x"][1] == pytest.approx(
        1e6 * above.view.x[-1]
    )
    for name in MAPS:
        for each, field in zip(packed["fields"][name], above.view.fields[name], strict=True):
            levels = np.frombuffer(base64.b64decode(each["levels"]), np.uint8).reshape(counts)
            found, wanted = each["scale"] * levels.T, units[name].of(field)
            assert np.abs(found - wanted).max() <= 0.501 / 255 * wanted.max()


def test_bearing_areas_are_those_of_the_figure(file, above):
    with open_case(file) as stored:
        before, after = bearing_heights(stored, [0, 30]).values()
    assert above.heights is not None
    for found, heights in zip(above.heights, (before, after), strict=True):
        share = (np.arange(heights.size) + 0.5) / heights.size
        expected = np.interp(np.linspace(0.0, 1.0, found.size), share, heights)
        assert found == pytest.approx(expected, abs=1e-3 * np.ptp(heights))
    with pytest.raises(CaseFileError, match="no such file"):
        read_above(file.with_name("elsewhere.nc"), steel(roughness=RANDOM), np.array([0.0]))


def test_a_contact_that_is_even_has_no_maps(finished):
    smooth, rough = (
        next(each for each in finished.plan.study.cases().values() if (each.rough is None) == one)
        for one in (True, False)
    )
    for each in (smooth, rough):
        cycles = np.array(each.output_cycles)
        found = read_above(finished.cases / f"{each.case_id}.nc", each, cycles)
        assert found.view is None
        assert (found.heights is None) == (each.rough is None)
