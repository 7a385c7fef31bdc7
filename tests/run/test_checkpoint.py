"""A run that dies loses little, and its rerun gives the same bits."""

import json

import numpy as np
import pytest
import xarray as xr

from fretwear.run import checkpoint as checkpoints
from fretwear.run import simulate
from fretwear.run.checkpoint import Checkpoint

from ..studies import flip, line_contact
from .conftest import make_case

CHANGES = {"plastic_limit": "3 GPa", "cycles": 3000, "cell": "6 um", "output_cycles": (10, 1000)}


@pytest.fixture
def case():
    return make_case(**CHANGES)


@pytest.fixture
def path(tmp_path):
    return tmp_path / "case.checkpoint"


class InterruptionError(Exception):
    """What stops a run in these tests."""


def interrupted(case, checkpoint, after):
    def stop(step):
        if step.state.step >= after:
            raise InterruptionError

    with pytest.raises(InterruptionError), checkpoint:
        simulate.run(case, [checkpoint, stop], record=checkpoint.record)


ROUGH = {"roughness": {"amplitude": "0.2 um", "slope_x": "0.4 deg", "slope_y": "0.3 deg"}}


SHORT = {"cycles": 300, "output_cycles": (10, 100), "error_estimate": False}
COUPLED = {**SHORT, "slip_model": "coupled"}
PULSATING = {**SHORT, "plastic_limit": None, "pulsating_load": 0.9}
STROKE = {
    **PULSATING,
    **line_contact("10 mm", "20 N/mm"),
    "tangential_load": None,
    "tangential_ratio": None,
    "sliding_amplitude": "40 um",
    "cell": "5 um",
    "wear_coefficient": ["1e-13 / Pa", "2e-13 / Pa"],
}


@pytest.mark.slow
@pytest.mark.parametrize(
    "changes",
    [{}, ROUGH, COUPLED, PULSATING, STROKE],
    ids=["smooth", "rough", "coupled", "pulsating", "stroke"],
)
def test_an_interrupted_run_resumes_to_the_same_bits(path, changes):
    case = make_case(**{**CHANGES, **changes})
    undisturbed = simulate.run(case)

    def assert_resumed(rerun):
        xr.testing.assert_equal(rerun.dataset, undisturbed.dataset)
        xr.testing.assert_equal(rerun.history, undisturbed.history)

    for after in (3,) if "error_estimate" in changes else (0, 5):
        # A rerun that takes long keeps checkpoints of its own.
        path.unlink(missing_ok=True)
        interrupted(case, Checkpoint(path, case, print), after)
        checkpoint = Checkpoint(path, case, print)
        assert checkpoint.record.last.step == after
        assert_resumed(simulate.run(case, [checkpoint], record=checkpoint.record))
    # One that was over is not run again.
    checkpoint.save()
    seen = []
    assert_resumed(simulate.run(case, [seen.append], record=Checkpoint(path, case, print).record))
    assert seen == []


def refusal(path, case):
    """Why a checkpoint is not used, as people are told."""
    told = []
    assert Checkpoint(path, case, told.append).record.last is None
    assert told[0].startswith(f"{path}: ")
    assert told[0].endswith("The run starts at cycle 0")
    return told[0]


def test_a_checkpoint_that_is_damaged_or_of_another_run_or_code_is_refused(case, path, monkeypatch):
    interrupted(case, Checkpoint(path, case, print), 3)
    whole = path.read_bytes()
    assert "of another run" in refusal(path, make_case(**{**CHANGES, "friction": 0.6}))
    assert "of another run" in refusal(path, make_case(**{**CHANGES, "output_cycles": (7,)}))
    for content in (b"", b"[1]", whole[:-100]):
        path.write_bytes(content)
        assert "damaged" in refusal(path, case)
    path.write_bytes(whole)
    flip(path)
    assert "damaged" in refusal(path, case)
    path.write_bytes(whole)
    monkeypatch.setattr(checkpoints, "case_digest", lambda _: "other")
    assert "of other code" in refusal(path, case)


def test_nothing_but_parts_of_a_run_is_made_from_a_checkpoint(case, path):
    for kind in (["subprocess", "Popen"], ["fretwear.run.workflow", "workspace"]):
        content = {"identity": checkpoints._identity(case), "record": {"_type": kind}}
        with path.open("wb") as stream:
            np.savez(stream, np.frombuffer(json.dumps(content).encode(), np.uint8))
        assert "damaged" in refusal(path, case)
