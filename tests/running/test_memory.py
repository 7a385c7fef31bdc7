"""The memory that a process can still get, and cases that do not fit in it."""

import re

import pytest

import fretwear
from fretwear.running.resources import available_memory, require_memory, why_too_large
from fretwear.study.cost import estimate

GB = 10**9


def case(**changes):
    parameters = {
        "radius": "10 mm",
        "youngs_modulus": "208 GPa",
        "poisson_ratio": 0.3,
        "load": "50 N",
        "tangential_ratio": 0.8,
        "friction": 0.5,
        "wear_coefficient": "7e-13 / Pa",
        "cycles": 100,
    }
    return fretwear.Case(**{**parameters, **changes})


class Machine:
    """What Linux tells of a machine, as files."""

    def __init__(self, folder):
        self.proc, self.groups = folder / "proc", folder / "cgroup"

    def write(self, name, text):
        path = self.proc.parent / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text)

    def available(self):
        return available_memory(self.proc, self.groups)


@pytest.fixture
def machine(tmp_path):
    machine = Machine(tmp_path)
    machine.write(
        "proc/meminfo",
        "MemTotal: 32000000 kB\nMemAvailable: 16000000 kB\nHugePages_Total: 0\nSwapFree: 500 kB\n",
    )
    return machine


def test_the_machine_says_what_is_available_with_its_swap_space(machine):
    assert machine.available() == 1024 * 16_000_500


def test_a_limit_of_the_jobs_own_control_group_counts(machine):
    machine.write("proc/self/cgroup", "0::/slurm/job_7\n")
    machine.write("cgroup/slurm/job_7/memory.max", f"{4 * GB}\n")
    machine.write("cgroup/slurm/job_7/memory.current", f"{3 * GB}\n")
    machine.write("cgroup/slurm/job_7/memory.stat", f"anon 5\ninactive_file {GB}\n")
    assert machine.available() == 2 * GB, "cached files are given back on demand"


def test_a_limit_of_a_group_around_the_own_counts(machine):
    machine.write("proc/self/cgroup", "0::/slurm/job_7/step_0\n")
    machine.write("cgroup/slurm/job_7/step_0/memory.max", "max\n")
    machine.write("cgroup/slurm/job_7/step_0/memory.current", f"{GB}\n")
    machine.write("cgroup/slurm/memory.max", f"{5 * GB}\n")
    machine.write("cgroup/slurm/memory.current", f"{2 * GB}\n")
    assert machine.available() == 3 * GB


def test_a_container_sees_its_limit_at_the_root(machine):
    machine.write("proc/self/cgroup", "0::/docker/0123\n")
    machine.write("cgroup/memory.max", f"{2 * GB}\n")
    machine.write("cgroup/memory.current", "0\n")
    assert machine.available() == 2 * GB


def test_control_groups_of_version_one(machine):
    machine.write("proc/self/cgroup", "9:name=systemd:/\n4:cpu,memory:/job\n0::/\n")
    machine.write("cgroup/memory/job/memory.limit_in_bytes", f"{6 * GB}\n")
    machine.write("cgroup/memory/job/memory.usage_in_bytes", f"{5 * GB}\n")
    machine.write("cgroup/memory/memory.limit_in_bytes", "9223372036854771712\n")
    machine.write("cgroup/memory/memory.usage_in_bytes", "0\n")
    assert machine.available() == GB


def test_a_group_beyond_its_limit_has_nothing_left(machine):
    machine.write("proc/self/cgroup", "0::/job\n")
    machine.write("cgroup/job/memory.max", "5\n")
    machine.write("cgroup/job/memory.current", "7\n")
    assert machine.available() == 0


def test_without_files_of_linux_the_memory_of_the_machine_is_taken(tmp_path):
    assert available_memory(tmp_path, tmp_path) > GB / 10


def test_this_machine_has_memory():
    assert available_memory() > GB / 10


def test_a_case_is_too_large_only_where_that_is_certain():
    expected = estimate(case())
    assert why_too_large(expected, None) == ""
    assert why_too_large(expected, expected.memory_bytes) == ""
    assert "MB of memory for" in why_too_large(expected, expected.memory_bytes // 2)


def test_a_case_that_does_not_fit_is_told_a_cell_that_does():
    require_memory(case())
    with pytest.raises(MemoryError, match=r"needs about .* GB of memory") as error:
        require_memory(case(cell="1 nm"))
    dx, dy = re.search(r"cell: \[(.*), (.*)\]", str(error.value)).groups()
    require_memory(case(cell=(dx, dy)))
