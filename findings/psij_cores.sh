#!/usr/bin/env bash
# psij-python 0.9.11: the same job asks each scheduler for other resources. `cpu_cores_per_process` reaches
# SLURM alone: PBS Pro, Torque and LSF reserve one core per process, on which a program with threads
# then crowds. `memory`, "the total amount of memory requested for the job" in its documentation, is
# handed to SLURM and PBS Pro per node, so that 4 nodes reserve four times as much. LSF gets 90 s as one
# minute. No error or warning tells. The scripts are only written here, no scheduler is needed.
#
# Seen of 4 nodes with 2 processes of 3 threads (24 cores), 8 GiB, 90 s: cores reserved by SLURM 24, PBS 8,
# Torque 8, LSF 8; memory by SLURM and PBS 32 GiB; time by LSF 60 s.
set -euo pipefail
folder="$(mktemp -d)"
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/env"
"$folder/env/bin/pip" install --quiet psij-python==0.9.11
export HOME="$folder"
cd "$folder"
"$folder/env/bin/python" -W ignore - <<'PYTHON'
import re
from datetime import timedelta
from io import StringIO

from psij import Job, JobAttributes, JobExecutor, JobSpec, ResourceSpecV1

resources = ResourceSpecV1(node_count=4, processes_per_node=2, cpu_cores_per_process=3, memory=8 * 2**30)
spec = JobSpec("/bin/true", resources=resources, attributes=JobAttributes(duration=timedelta(seconds=90)))


def script(name):
    executor, job, text = JobExecutor.get_instance(name), Job(spec), StringIO()
    executor.generate_submit_script(job, executor._create_script_context(job), text)
    lines = [line for line in text.getvalue().splitlines() if re.match("#(SBATCH|PBS -l|BSUB -[nMW])", line)]
    print(name, *lines, sep="\n    ")
    return "\n".join(lines)


def number(pattern, text):
    return int(re.search(pattern + r"(\d+)", text)[1])


slurm, pbs, torque, lsf = map(script, ("slurm", "pbs", "pbs_classic", "lsf"))
cores = {
    "slurm": number("--ntasks=", slurm) * number("--cpus-per-task=", slurm),
    "pbs": number("select=", pbs) * number("ncpus=", pbs),
    "torque": number("nodes=", torque) * number("ppn=", torque),
    "lsf": number("-n ", lsf),
}
memory = {
    "slurm": number("--nodes=", slurm) * number("--mem=", slurm) / 2**20,
    "pbs": number("select=", pbs) * number(":mem=", pbs) / 2**30,
}
minutes = number("-W 0:", lsf)
print("cores:", cores, "GiB:", memory, "minutes of LSF:", minutes)
assert cores == {"slurm": 24, "pbs": 8, "torque": 8, "lsf": 8}
assert memory == {"slurm": 32.0, "pbs": 32.0}
assert minutes == 1
PYTHON
