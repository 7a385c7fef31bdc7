"""What a rig can be asked, each as a small study through everything that handles studies."""

import json

import numpy as np
import pytest
import xarray as xr
from tests.studies import base, run_study, write_study

from fretwear.cli.show import case_content, case_lines, comparison_lines
from fretwear.data.files import open_case, open_history
from fretwear.figures.index import INDEX_NAME
from fretwear.report import build_report
from fretwear.running.checkpoint import read_checkpoint, write_checkpoint
from fretwear.running.simulate import RunRecord, run, steps
from fretwear.study.plan import Plan
from fretwear.study.study import load_study

BOTH = ["3e-13 / Pa", "4e-13 / Pa"]
MOVED = {"tangential_ratio": None, "wear_coefficient": BOTH}
CYLINDER = {"radius": None, "indenter": {"kind": "cylinder", "radius": "6 mm"}, "load": "18.5 N/mm"}
PUNCH = {"kind": "round_punch", "flat_radius": "100 um", "edge_radius": "10 mm"}
FALLS = {
    "slow": ["2e-4 mm^3/J", "3e-4 mm^3/J"],
    "fast": ["1e-4 mm^3/J", "1.5e-4 mm^3/J"],
    "decay": "0.1 mm^2/W",
    "frequency": "10 Hz",
}
WAVES = {"kind": "wavy", "amplitude": "0.1 um", "slope_x": "1 deg", "slope_y": "0 deg"}
TABLE = {"cycles": [0, 40], "values": [0.4, 0.7]}
# What a study is about: the base, and what varies in its two points.
STUDIES = {
    "a rig, debris and friction over the cycles": (
        {**MOVED, "cell": "12 um"},
        {
            "displacement_amplitude": ["0.9 um", "1.8 um"],
            "rig_stiffness": ["28 N/um", "60 N/um"],
            "friction": [0.5, TABLE],
            "debris_fraction": [0, 0.5],
        },
    ),
    "a stroke, and wear that falls with the power": (
        {**CYLINDER, "tangential_ratio": None, "wear_coefficient": None, "roughness": WAVES},
        {"sliding_amplitude": ["5 um", "10 um"], "energy_wear_coefficient": [FALLS, FALLS]},
    ),
    "blocks, and a punch": (
        {"radius": None, "indenter": PUNCH, "cell": "12 um", "cycles": None},
        {
            "load": ["50 N", "40 N"],
            "blocks": [
                [{"cycles": 60}],
                [{"cycles": 20}, {"cycles": 40, "displacement_ratio": 1.2}],
            ],
        },
    ),
}


@pytest.mark.parametrize("about", STUDIES)
def test_every_door_is_open_to(about, tmp_path):
    changes, vary = STUDIES[about]
    content = {
        "title": about,
        "base": base(**{"cycles": 60, **changes}),
        "vary": vary,
        "design": "zip",
        "output": {"cycles": [0, 20, 60]},
    }
    study = load_study(write_study(tmp_path / "rig.yaml", content))
    assert all(np.isfinite(each.seconds) for each in Plan(study).estimates.values())
    run_study(study, tmp_path)
    paths = [tmp_path / "cases" / f"{each}.nc" for each in study.cases()]
    for path in paths:
        with open_case(path) as case, open_history(path) as history:
            told = "\n".join(case_lines(case_content(case, history)))
            for name in ("wear_volume", "contact_half_width_x", "tangential_force"):
                error = case[f"{name}_error"]
                assert (error >= 0).all()
                assert (error <= 0.2 * abs(case[name]).max()).all()
            assert "wear volume" in told
            assert list(case.cycle) == [0, 20, 60]
            assert float(case.wear_volume[-1]) > float(case.wear_volume[1]) > 0
    with open_case(paths[0]) as a, open_case(paths[1]) as b:
        compared = "\n".join(comparison_lines(a, b))
    assert "Parameters that differ" in compared
    assert "tangential force amplitude" in compared

    case = study.cases()[paths[1].stem]
    record = RunRecord()
    for step in steps(case):
        record.add(step, keep_fields=step.state.cycle in case.output_cycles)
        if step.state.cycle == 20:
            break
    write_checkpoint(tmp_path / "half", record, {})
    resumed = run(case, record=read_checkpoint(tmp_path / "half", {}))
    with open_case(paths[1]) as whole:
        np.testing.assert_array_equal(resumed.dataset.wear_depth, whole.wear_depth)

    summary = xr.load_dataset(tmp_path / "summary.nc")
    (tmp_path / "figures").mkdir()
    (tmp_path / "figures" / INDEX_NAME).write_text(json.dumps([]))
    page = build_report(Plan(study), summary, tmp_path)
    assert about in page
    assert all(path.stem in page for path in paths)
