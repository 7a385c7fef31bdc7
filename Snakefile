# From a study file to labelled datasets, figures and a report:
#
#     snakemake --cores 2                            runs studies/demo.yaml
#     snakemake --cores 2 --config study=paper       runs studies/paper.yaml
#     snakemake --cores 2 --config keep_older=true   keeps cases that other code has computed
import shlex
import sys

from fretwear.run.workflow import StudyJobs, release_locks
from fretwear.study.problems import StudyError
from fretwear.version import __version__

try:
    JOBS = StudyJobs.of(config)
except StudyError as error:
    print(f"fretwear: error: {error}", file=sys.stderr)
    sys.exit(2)

STUDY = str(JOBS.plan.study.file)
RESULTS = JOBS.results.as_posix()
FIGURES = JOBS.results / "figures"
FITTED = [f"{RESULTS}/fit.nc", f"{RESULTS}/fit.json"] if JOBS.measurements else []
KEEP_OLDER = "--keep-older" if JOBS.keep_older else ""
# The command of this environment, whose folder may not be on the PATH.
FRETWEAR = f"{shlex.quote(sys.executable)} -m fretwear"

if workflow.is_main_process:
    release_locks()
    for sentence in JOBS.check():
        print(f"fretwear: warning: {sentence}", file=sys.stderr)


# Steps that take less time than a cluster takes to start a job.
localrules:
    all,
    merge,
    figures,
    report,


rule all:
    default_target: True
    input:
        f"{RESULTS}/report.html",
        expand(f"{RESULTS}/jobs/{{job}}", job=JOBS.by_name),


# A job runs a few cases, each into its own file, and keeps finished ones. Its marker is its output,
# not the case files, because Snakemake removes the outputs of a job that it starts again.
rule simulate:
    output:
        touch(f"{RESULTS}/jobs/{{job}}"),
    log:
        f"{RESULTS}/logs/jobs/{{job}}.log",
    resources:
        mem_mb=lambda wildcards: JOBS.memory_mb(wildcards.job),
        runtime=lambda wildcards: JOBS.minutes(wildcards.job),
    params:
        cases=lambda wildcards: JOBS.options(wildcards.job),
    # `exec`, so that a scheduler's request to stop reaches the command, which writes a checkpoint.
    shell:
        "exec {FRETWEAR} run {STUDY:q} {params.cases} -o {RESULTS}/cases 2>{log:q}"


rule merge:
    input:
        expand(f"{RESULTS}/jobs/{{job}}", job=JOBS.by_name),
    output:
        f"{RESULTS}/summary.nc",
        f"{RESULTS}/points.csv",
        f"{RESULTS}/results.csv",
    params:
        code=(__version__, JOBS.code),
        study=lambda wildcards: JOBS.content,
    shell:
        "{FRETWEAR} merge {STUDY:q} {KEEP_OLDER}"


# The runs of a fit depend on each other: they share the cores of one machine, and are kept, so that
# a fit that was stopped resumes.
rule fit:
    input:
        JOBS.measurements,
    output:
        f"{RESULTS}/fit.nc",
        f"{RESULTS}/fit.json",
    threads: workflow.resource_settings.cores or 1
    params:
        code=JOBS.code,
        study=lambda wildcards: JOBS.content,
    shell:
        "exec {FRETWEAR} fit {STUDY:q} --processes {threads}"


rule figures:
    input:
        f"{RESULTS}/summary.nc",
        FITTED,
    output:
        report(
            directory(FIGURES),
            patterns=["{figure}.svg"],
            category="Figures",
            labels={"figure": "{figure}"},
        ),
    threads: 2
    params:
        version=__version__,
    shell:
        "{FRETWEAR} figures {STUDY:q} --processes {threads}"


rule report:
    input:
        f"{RESULTS}/summary.nc",
        FIGURES,
        FITTED,
    output:
        report(f"{RESULTS}/report.html", category="Report"),
        f"{RESULTS}/answer.json",
    params:
        version=__version__,
    shell:
        "{FRETWEAR} report {STUDY:q}"


# With --keep-going the finished cases are merged, drawn and reported although others have failed.
onerror:
    if workflow.execution_settings.keep_going:
        for step in (f"merge {KEEP_OLDER}", "figures", "report"):
            shell("{FRETWEAR} {step} {STUDY:q}")
