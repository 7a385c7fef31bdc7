# From a study file to labelled datasets, figures and a report:
#
#     snakemake --cores 2                          runs studies/demo.yaml
#     snakemake --cores 2 --config study=paper     runs studies/paper.yaml
#
# The study is checked here, before any job; the jobs are calls of the command `fretwear`.
import shlex
import sys
from pathlib import Path

from fretwear.study.problems import StudyError
from fretwear.workflow import StudyJobs
from fretwear.writable import why_not_writable

try:
    JOBS = StudyJobs.of(str(config.get("study", "demo")))
except StudyError as error:
    sys.exit(f"fretwear: error: {error}")

if problem := why_not_writable(Path(JOBS.folder)):
    sys.exit(f"fretwear: error: {problem}")

STUDY = str(JOBS.study.file)
RESULTS = JOBS.folder
# The command of this environment, also where its folder is not on the PATH.
FRETWEAR = f"{shlex.quote(sys.executable)} -m fretwear"


wildcard_constraints:
    case=r"[A-Za-z0-9._-]+",


# What follows the simulation takes seconds, less than a cluster takes to start a job.
localrules:
    all,
    merge,
    figures,
    report,


rule all:
    default_target: True
    input:
        f"{RESULTS}/report.html",


rule simulate:
    output:
        f"{RESULTS}/cases/{{case}}.nc",
    log:
        f"{RESULTS}/logs/simulate/{{case}}.log",
    benchmark:
        f"{RESULTS}/benchmarks/simulate/{{case}}.tsv"
    threads: 1
    resources:
        mem_mb=lambda wildcards: JOBS.memory_mb(wildcards.case),
        runtime=lambda wildcards: JOBS.minutes(wildcards.case),
    params:
        version=JOBS.version,
        parameters=lambda wildcards: JOBS.parameters(wildcards.case),
    message:
        "Simulating {wildcards.case}"
    shell:
        "{FRETWEAR} run {STUDY:q} --case {wildcards.case} --output {output:q} >{log:q} 2>&1"


rule merge:
    input:
        expand(f"{RESULTS}/cases/{{case}}.nc", case=JOBS.cases),
    output:
        summary=f"{RESULTS}/summary.nc",
        points=f"{RESULTS}/points.csv",
    log:
        f"{RESULTS}/logs/merge.log",
    benchmark:
        f"{RESULTS}/benchmarks/merge.tsv"
    params:
        version=JOBS.version,
        study=JOBS.content,
    message:
        "Merging {JOBS.study.name}"
    shell:
        "{FRETWEAR} merge {STUDY:q} >{log:q} 2>&1"


rule figures:
    input:
        f"{RESULTS}/summary.nc",
    output:
        report(
            directory(f"{RESULTS}/figures"),
            patterns=["{figure}.svg"],
            category="Figures",
            labels={"figure": "{figure}"},
        ),
    log:
        f"{RESULTS}/logs/figures.log",
    benchmark:
        f"{RESULTS}/benchmarks/figures.tsv"
    params:
        version=JOBS.version,
    message:
        "Drawing the figures of {JOBS.study.name}"
    shell:
        "{FRETWEAR} figures {STUDY:q} >{log:q} 2>&1"


rule report:
    input:
        f"{RESULTS}/summary.nc",
        f"{RESULTS}/figures",
    output:
        report(f"{RESULTS}/report.html", category="Report"),
    log:
        f"{RESULTS}/logs/report.log",
    benchmark:
        f"{RESULTS}/benchmarks/report.tsv"
    params:
        version=JOBS.version,
    message:
        "Writing the report of {JOBS.study.name}"
    shell:
        "{FRETWEAR} report {STUDY:q} >{log:q} 2>&1"
