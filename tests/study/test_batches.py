import pytest

from fretwear.study.batches import (
    JOBS_FOR_MANY_CORES,
    LEAST_JOBS,
    MOST_JOBS,
    SECONDS_PER_JOB,
    Task,
    batches,
)
from fretwear.study.plan import plan_study


def tasks(seconds):
    return [Task(number, f"case{number}", each, 1000) for number, each in enumerate(seconds, 1)]


def ids(found):
    return [case_id for batch in found for case_id in batch.case_ids]


@pytest.mark.parametrize("each", [1, 2, 7, 100])
def test_a_number_of_cases_is_taken_by_its_word(each):
    listed = tasks([1.0] * 20)
    found = batches(listed, each)
    assert ids(found) == [task.case_id for task in listed]
    assert all(len(batch.tasks) == each for batch in found[:-1])


def test_a_job_gets_a_few_minutes_of_work():
    found = batches(tasks([2.0] * 10_000))
    assert len(ids(found)) == 10_000
    times = [batch.seconds for batch in found]
    assert max(times) <= SECONDS_PER_JOB + 2.0
    assert min(times) >= SECONDS_PER_JOB - 4.0


def test_a_small_study_keeps_the_cores_busy():
    assert len(batches(tasks([0.1] * 5))) == 5
    assert len(batches(tasks([0.1] * 1000))) == LEAST_JOBS
    assert len(batches(tasks([10.0] * 500))) == JOBS_FOR_MANY_CORES


def test_a_long_case_is_a_job_of_its_own():
    found = batches(tasks([1.0] * 300 + [3600.0] + [1.0] * 300))
    (long,) = (batch for batch in found if "case301" in batch.case_ids)
    assert long.seconds < 3600.0 + SECONDS_PER_JOB


def test_a_huge_study_gets_longer_jobs_rather_than_more():
    found = batches(tasks([60.0] * 100_000))
    assert 0.9 * MOST_JOBS < len(found) <= MOST_JOBS
    assert len(set(ids(found))) == 100_000


def test_a_batch_knows_its_points_its_time_and_its_memory():
    (batch,) = batches([Task(3, "a", 1.0, 500), Task(5, "b", 2.0, 900)], 2)
    assert (batch.first, batch.last) == (3, 5)
    assert (batch.seconds, batch.memory_bytes) == (3.0, 900)


def test_a_study_says_how_it_is_divided(studies, content):
    content["vary"] = {"load": ["25 N", "30 N", "35 N", "40 N", "50 N"]}
    assert len(plan_study(studies.load(content)).batches) == 5
    content["batch"] = 2
    sizes = [len(batch.tasks) for batch in plan_study(studies.load(content)).batches]
    assert sizes == [2, 2, 1]
    content["batch"] = "auto"
    assert studies.load(content).batch is None


def test_points_that_come_to_one_case_are_run_once(studies, content):
    waves = {"amplitude": "0 um", "slope_x": "5 deg", "slope_y": "1 deg"}
    content["base"]["roughness"] = waves
    content["vary"] = {"roughness.slope_x": ["5 deg", "6 deg"], "load": ["25 N", "50 N"]}
    found = plan_study(studies.load(content)).batches
    assert ids(found) == list(studies.load(content).cases())


@pytest.mark.parametrize("wrong", [0, -3, 1.5, True, None, "many", [2], 10**9])
def test_other_batches_are_refused(studies, content, wrong):
    content["batch"] = wrong
    (problem,) = studies.error(content).problems
    assert problem.key == "batch"
    assert "must be auto, or a whole number of cases" in problem.rule
