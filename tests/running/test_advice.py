import pytest

from fretwear.running.resources import cores, machine_warnings, warnings
from fretwear.study.file import load_study
from fretwear.study.plan import plan_study

STUDY = """
base:
  radius: 10 mm
  youngs_modulus: 208 GPa
  poisson_ratio: 0.3
  load: 50 N
  tangential_ratio: 0.8
  friction: 0.5
  wear_coefficient: 7e-13 / Pa
  plastic_limit: none
  roughness: none
  cycles: 1000
  cell: 5 um
"""


@pytest.fixture
def plan(tmp_path):
    def make(vary="", capped=False):
        file = tmp_path / "study.yaml"
        text = STUDY
        if capped:
            text = text.replace("  cell: 5 um\n", "").replace(": none", ": 4500 MPa", 1)
        file.write_text(text + (f"vary: {{{vary}}}\n" if vary else ""))
        return plan_study(load_study(file))

    return make


def test_a_study_that_fits_and_sees_what_it_computes_has_no_warning(plan):
    assert not list(machine_warnings(plan()))
    assert not list(warnings(plan(), None))


def test_cases_larger_than_the_memory_are_named_with_what_they_need(plan):
    planned = plan("cell: [5 um, 0.002 um, 0.001 um]")
    (warning,) = machine_warnings(planned)
    assert warning.startswith("2 cases will not fit in the memory of this machine:\n")
    for large in planned.points[1:]:
        assert f"{large.id} needs about " in warning
    assert planned.points[0].id not in warning


def test_jobs_that_fit_alone_but_not_together_are_told_how_to_share(plan):
    planned = plan("load: [50 N, 60 N, 70 N]")
    at_once = min(cores(), 3)
    (warning,) = warnings(planned, int(0.9 * at_once * planned.memory_bytes))
    assert "--resources mem_mb=" in warning
    assert not list(warnings(planned, at_once * planned.memory_bytes))


def test_contacts_that_yield_in_an_unseen_ring_are_named_with_both_widths(plan):
    planned = plan("tangential_ratio: [0.2, 0.3, 0.4, 0.5, 0.95]", capped=True)
    (warning,) = warnings(planned, None)
    assert warning.startswith("4 cases will yield in a ring")
    assert f"{planned.points[0].id}: ring " in warning
    assert "cell 1.1 um" in warning
    assert "and 1 more" in warning
