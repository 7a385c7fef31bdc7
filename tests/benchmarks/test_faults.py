"""A few points of each fault that docs/reliability.md tells of; all of them take an hour."""

import shutil

import pytest
from benchmarks.faults import FAULTS, Server, Trials, contents

pytestmark = [
    pytest.mark.slow,
    pytest.mark.skipif(not shutil.which("cc"), reason="needs a compiler"),
]


@pytest.fixture(scope="module")
def trials(tmp_path_factory):
    folder = tmp_path_factory.mktemp("faults")
    server = Server(folder)
    yield Trials(folder, server)
    server.close()


SOME = {name: FAULTS[name] for name in FAULTS if "removing" not in name}


@pytest.mark.parametrize("name", SOME)
def test_after_a_fault_the_same_command_gives_the_same_bits(trials, name):
    kinds, error, sent = FAULTS[name]
    count = trials.count(kinds)
    tally = trials.sweep(kinds, error, sent, [count // 3, count - 2])
    assert tally.points == 2
    assert not any((tally.changed, tally.tracebacks, tally.silent, tally.hangs, tally.outside))
    assert not tally.left


def test_after_a_power_failure_the_same_command_gives_the_same_bits(trials):
    tally, operations = trials.without_power(5, seed=3)
    assert operations > 100
    assert not any((tally.changed, tally.tracebacks, tally.hangs))


def test_what_is_compared_is_all_of_the_results(trials):
    assert {name.split("/")[0] for name in trials.expected} >= {"summary.nc"}
    assert len({name.split("/")[0] for name in trials.expected}) == 3
    home = trials.fresh()
    assert contents(home) == {}
