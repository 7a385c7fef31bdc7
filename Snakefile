# From a study file to labelled datasets, figures and a report:
#
#     snakemake --cores 2                            runs studies/demo.yaml
#     snakemake --cores 2 --config study=paper       runs studies/paper.yaml
#     snakemake --cores 2 --config keep_older=true   keeps cases that other code has computed
import subprocess
import sys
from pathlib import Path

from fretwear.run.workflow import FIT_THREADS, StudyJobs, mark_start, release_locks
from fretwear.study.mistakes import StudyError
from fretwear.version import __version__

if workflow.storage_settings.default_storage_provider:
    # A job writes case files that are no outputs, which storage would not keep.
    print(
        "fretwear: error: --default-storage-provider does not keep the case files: run in a folder "
        "that all machines share, without it, and copy results/ when the study is done",
        file=sys.stderr,
    )
    sys.exit(2)
try:
    JOBS = StudyJobs.of(config)
except StudyError as error:
    print(f"fretwear: error: {error}", file=sys.stderr)
    sys.exit(2)

STUDY = str(JOBS.plan.study.file)
RESULTS = JOBS.results.as_posix()
FIGURES = JOBS.results / "figures"
FITTED = [f"{RESULTS}/fit.nc", f"{RESULTS}/fit.json"] if JOBS.measurements else []


# A module with a prefix moves the outputs of a rule: what a command writes follows from them.
def in_results():
    """Parameters of a rule whose first output lies in the folder of the results."""
    return dict(
        # The command of this environment, whose folder may not be on the PATH.
        fretwear=[sys.executable, "-m", "fretwear"],
        study_file=STUDY,
        results=lambda wildcards, output: Path(output[0]).parent,
    )


# Where the results are, and the name of the rule of simulations: a module changes both.
MOVED = Path(str(workflow.modifier.path_modifier.replace_prefix(RESULTS, None)))
SIMULATE = workflow.modifier.modify_rulename("simulate")

if workflow.is_main_process:
    release_locks()
    for sentence in JOBS.check(MOVED):
        print(f"fretwear: warning: {sentence}", file=sys.stderr)
    # Snakemake calls only the onstart of the main workflow.
    if not workflow.modifier.is_main_snakefile():
        main = Path(workflow.main_snakefile)
        if main.is_file() and ".onstart()" not in main.read_text("utf-8"):
            print(
                "fretwear: warning: --forcerun keeps finished cases unless the onstart of "
                f"{main.name} calls M.onstart(), where M is the name of this module",
                file=sys.stderr,
            )


def after():
    """Resources of a step after the simulations; of a few cases it takes no job of a cluster."""
    return dict(
        mem_mb=lambda wildcards, attempt: attempt * JOBS.memory_mb_after,
        runtime=lambda wildcards, attempt: attempt * JOBS.minutes_after,
    )


localrules:
    all,


rule all:
    default_target: True
    input:
        f"{RESULTS}/report.html",
        expand(f"{RESULTS}/jobs/{{job}}", job=JOBS.jobs),


# A job runs a few cases, each into its own file, and keeps finished ones. Its marker is its output,
# not the case files, because Snakemake removes the outputs of a job that it starts again.
rule simulate:
    output:
        touch(f"{RESULTS}/jobs/{{job}}"),
    log:
        f"{RESULTS}/logs/jobs/{{job}}.log",
    resources:
        mem_mb=lambda wildcards, attempt: attempt * JOBS.memory_mb(wildcards.job),
        runtime=lambda wildcards, attempt: attempt * JOBS.minutes(wildcards.job),
    params:
        **in_results(),
        cases=lambda wildcards: JOBS.options(wildcards.job),
    # `exec`, so that a scheduler's request to stop reaches the command, which writes a checkpoint.
    shell:
        "exec {params.fretwear:q} run {params.study_file:q} {params.cases} "
        "-o {params.results:q}/../cases 2>{log:q}"


rule merge:
    input:
        expand(f"{RESULTS}/jobs/{{job}}", job=JOBS.jobs),
    output:
        f"{RESULTS}/summary.nc",
        f"{RESULTS}/points.csv",
        f"{RESULTS}/results.csv",
    localrule: JOBS.is_small
    resources:
        **after(),
    params:
        **in_results(),
        code=(__version__, JOBS.code),
        study=lambda wildcards: JOBS.content,
        keep_older=["--keep-older"] * JOBS.keep_older,
    shell:
        "{params.fretwear:q} merge {params.study_file:q} --results {params.results:q} "
        "{params.keep_older}"


# The runs of a fit depend on each other: they share the cores of one machine, and are kept, so that
# a fit that was stopped resumes.
rule fit:
    input:
        JOBS.measurements,
    output:
        f"{RESULTS}/fit.nc",
        f"{RESULTS}/fit.json",
    threads: FIT_THREADS
    resources:
        mem_mb=lambda wildcards, threads, attempt: attempt
        * JOBS.memory_mb_of_fit(threads),
        runtime=lambda wildcards, attempt: attempt * JOBS.minutes_of_fit,
    params:
        **in_results(),
        code=JOBS.code,
        study=lambda wildcards: JOBS.content,
    shell:
        "exec {params.fretwear:q} fit {params.study_file:q} --results {params.results:q} "
        "--processes {threads}"


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
    localrule: JOBS.is_small
    threads: 2
    resources:
        **after(),
    params:
        **in_results(),
        version=__version__,
    shell:
        "{params.fretwear:q} figures {params.study_file:q} --results {params.results:q} "
        "--processes {threads}"


rule report:
    input:
        f"{RESULTS}/summary.nc",
        FIGURES,
        FITTED,
    output:
        report(f"{RESULTS}/report.html", category="Report"),
        f"{RESULTS}/answer.json",
    localrule: JOBS.is_small
    resources:
        **after(),
    params:
        **in_results(),
        version=__version__,
    shell:
        "{params.fretwear:q} report {params.study_file:q} --results {params.results:q}"


# A forced job computes its cases again, although their files are finished.
onstart:
    mark_start()
    JOBS.remove_forced(MOVED, SIMULATE, workflow.dag_settings)


# With --keep-going the finished cases are merged, drawn and reported although others have failed.
onerror:
    if workflow.execution_settings.keep_going:
        for step in (
            ["merge", *["--keep-older"] * JOBS.keep_older],
            ["figures"],
            ["report"],
        ):
            subprocess.run(
                [sys.executable, "-m", "fretwear", *step, STUDY], check=False
            )
