"""A run that dies loses little, and its rerun gives the same bits."""

import random
from dataclasses import dataclass, fields, is_dataclass

import numpy as np
import pytest
import xarray as xr

from fretwear.data.safe import _LENGTH, _host, add_checksum
from fretwear.run import simulate
from fretwear.run.batch import (
    Checkpoint,
    identity_of,
    read_checkpoint,
    write_checkpoint,
)
from fretwear.run.simulate import RunRecord

from ..studies import HandClock, flip
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
    "indenter": {"kind": "cylinder", "radius": "10 mm"},
    "radius": None,
    "load": "20 N/mm",
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

    for after in (0, 3) if "error_estimate" in changes else (0, 1, 5, 15):
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
    @dataclass
    class Other(RunRecord):
        debris: float = 0.0

    write_checkpoint(path, Other(), identity_of(case))
    damaged = path.read_bytes()[:-_LENGTH]
    for content in (b"", b"[1]", b"[\n[", b"{}\n[[3]]", b'{}\n[["a"]]', b"{}\n[[-1]]", damaged):
        path.write_bytes(content)
        add_checksum(path)
        assert "not a checkpoint" in refusal(path, case)
    path.unlink()
    interrupted(case, Checkpoint(path, case, print), 3)
    assert "another parameters" in refusal(path, make_case(**{**CHANGES, "friction": 0.6}))
    assert "another output cycles" in refusal(path, make_case(**{**CHANGES, "output_cycles": (7,)}))
    monkeypatch.setattr("fretwear.run.batch.code_digest", lambda: "other")
    assert "another code" in refusal(path, case)
    flip(path)
    assert "its checksum does not match" in refusal(path, case)
    path.write_bytes(path.read_bytes()[:-100])
    assert "not a complete checkpoint" in refusal(path, case)


def test_a_checkpoint_goes_with_what_killed_writers_left_or_is_told_and_spoils_nothing(case, path):
    left = path.with_name(f".{path.name}.{_host()}.999999999.deadbeef.tmp")
    left.write_text("half")
    Checkpoint(path, case, print).discard()
    assert not left.exists()
    path.mkdir()
    told = []
    Checkpoint(path, case, told.append).discard()
    assert "not a file" in told[0]
    assert "not removed" in told[1]


def assert_same(one, other):
    """Compare all fields of two values, whatever fields there are, with their types."""
    assert type(one) is type(other)
    if is_dataclass(one):
        for each in fields(one):
            assert_same(getattr(one, each.name), getattr(other, each.name))
    elif isinstance(one, list | tuple):
        for pair in zip(one, other, strict=True):
            assert_same(*pair)
    elif isinstance(one, np.ndarray):
        assert one.dtype == other.dtype
        np.testing.assert_array_equal(one, other)
    else:
        assert one == other


def test_every_field_of_a_run_record_comes_back_from_the_file(case, path):
    record = RunRecord()
    simulate.run(case, record=record)
    assert [state.cycle for state in record.snapshots] == [0, 10, 1000, 3000]
    write_checkpoint(path, record, {})
    assert_same(read_checkpoint(path, {}), record)


@pytest.mark.parametrize("pauses", [[0.5, 5.0, 29.0], [7.0]])
def test_a_kill_at_any_moment_costs_at_most_half_a_minute_and_a_step(case, path, pauses):
    generator, clock = random.Random(3), HandClock()
    checkpoint = Checkpoint(path, case, print, clock=clock)
    written, costs = 0.0, []

    def pass_time(step):
        nonlocal written
        costs.append(clock.now - written)
        stored = Checkpoint(path, case, [].append).record.last if path.exists() else None
        if stored and stored.step == step.state.step:
            written = clock.now
        elif step.state.cycle in case.output_cycles[1:]:
            assert pauses != [7.0], "snapshots are on the disk soon"
        clock.now += generator.choice(pauses)

    simulate.run(case, [checkpoint, pass_time], record=checkpoint.record)
    assert written > 0
    assert max(costs) <= 30.0 + max(pauses)
