"""Memory, cores and time of a study, the jobs that it falls into, and what it is warned of."""

from types import SimpleNamespace

import pytest

from fretwear.run.resources import (
    grouped,
    require_memory,
    why_too_large,
)
from fretwear.study.mistakes import StudyError
from fretwear.study.plan import SECONDS_TO_START, Plan, estimate

from ..studies import near
from .conftest import BASE, make_case, without

STUDY = {"base": without(BASE, "load"), "vary": {"load": ["25 N", "50 N"]}}


def test_a_case_that_does_not_fit_is_refused(monkeypatch):
    expected = estimate(make_case())
    assert why_too_large(expected, expected.memory_bytes) == ""
    assert "MB of memory for" in why_too_large(expected, expected.memory_bytes // 2)
    require_memory(make_case())
    with pytest.raises(MemoryError, match=r"needs about .* of memory .*: choose a coarser cell"):
        require_memory(make_case(cell="1 nm"))
    monkeypatch.setattr("fretwear.run.resources.available_memory", lambda: 0)
    with pytest.raises(MemoryError, match="but 0 kB are available"):
        require_memory(make_case())


def ids(jobs):
    return [case_id for job in jobs for case_id in job.case_ids]


@pytest.mark.parametrize(
    ("seconds", "least", "most"),
    [
        # Small cases share jobs, of a few minutes in a large study.
        ([0.1], 1, 1),
        ([0.1] * 1000, 14, 16),
        ([10.0] * 500, 62, 66),
        # No case is left over for a job of its own.
        ([0.1] * 10 + [0.9] * 10 + [0.3] * 5, 2, 2),
        ([2.0] * 10_000, 110, 114),
        # A long case is a job of its own, nearly.
        ([1.0] * 300 + [3600.0] + [1.0] * 300, 3, 12),
    ],
)
def test_jobs_are_neither_too_many_nor_too_long(seconds, least, most):
    costs = {
        f"case{n}": SimpleNamespace(seconds=SECONDS_TO_START + each, memory_bytes=n)
        for n, each in enumerate(seconds)
    }
    plan = SimpleNamespace(estimates=costs, study=SimpleNamespace(batch=None))
    jobs = grouped(plan)
    assert least <= len(jobs) <= most
    assert ids(jobs) == list(costs)
    assert max(job.seconds for job in jobs) < max(seconds) + 200.0
    assert sum(job.seconds for job in jobs) == near(sum(seconds) + len(jobs) * SECONDS_TO_START)
    assert jobs[-1].memory_bytes == len(seconds) - 1


def test_a_study_says_how_it_is_joined(load):
    content = {**STUDY, "vary": {"load": ["25 N", "30 N", "35 N", "40 N", "50 N"]}}
    said = [({}, [5]), ({"batch": 1}, [1] * 5), ({"batch": 2}, [2, 2, 1]), ({"batch": 7}, [5])]
    for each, sizes in (*said, ({"batch": "auto"}, [5])):
        study = load({**content, **each})
        jobs = grouped(Plan(study))
        assert [len(job.case_ids) for job in jobs] == sizes
        assert ids(jobs) == list(study.cases())
    with pytest.raises(StudyError, match="must be"):
        load({**STUDY, "batch": 1.5})
