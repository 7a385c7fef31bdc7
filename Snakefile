# From a study file to labelled datasets, figures and a report:
#
#     snakemake --cores 2                          runs studies/demo.yaml
#     snakemake --cores 2 --config study=paper     runs studies/paper.yaml
#     snakemake --cores 2 --config keep_older=true
#                                  keeps cases computed by another version of the solver
#
# The study is checked here, before any job; the jobs call the command `fretwear`.
import logging
import shlex
import signal
import sys
from functools import partial
from pathlib import Path

from fretwear.data.safe import why_leading_out, why_not_writable
from fretwear.figures.index import captions, figure_category, figure_labels
from fretwear.platform import STOPPING
from fretwear.study.problems import StudyError
from fretwear.version import __version__

try:
    from fretwear.run.workflow import (
        BATCHES,
        CAPTION,
        Progress,
        StudyJobs,
        is_news,
        step_of,
    )

    JOBS = StudyJobs.of(config)
except (ImportError, StudyError) as error:
    print(f"fretwear: error: {error}", file=sys.stderr)
    sys.exit(2)

FOLDER = Path(JOBS.folder)
if problem := why_leading_out(FOLDER, FOLDER.parent) or why_not_writable(FOLDER):
    print(f"fretwear: error: {problem}", file=sys.stderr)
    sys.exit(2)

# A closed terminal stops Snakemake as Ctrl-C does, so that it waits for its jobs and leaves no lock;
# one started by nohup ignores it.
if workflow.is_main_process:
    for number in STOPPING[2:]:
        if signal.getsignal(number) is signal.SIG_DFL:
            signal.signal(number, signal.default_int_handler)

# Snakemake reports a locked folder, but not the command that unlocks it.
if workflow.is_main_process and any(Path(".snakemake/locks").glob("*")):
    print(
        "fretwear: this folder is locked, by a running Snakemake or by one that was killed; "
        "if none is running: snakemake --unlock, then the same command again",
        file=sys.stderr,
    )

# No setting of Snakemake silences its scheduler alone. Its log file keeps every line, and a dry run and
# --quiet none show them.
PROGRESS = []
tell = partial(print, file=sys.stderr, flush=True)


def is_shown(record):
    shown = workflow.dryrun or is_news(record)
    # Cases that are done are reported before the step that follows them.
    for progress in PROGRESS if shown else []:
        progress.look()
    if shown and PROGRESS and (step := step_of(record)):
        tell(step)
        return False
    return shown


if workflow.output_settings.quiet:
    for handler in logger.handlers:
        if not isinstance(handler, logging.FileHandler):
            handler.addFilter(is_shown)

STUDY = str(JOBS.study.file)
RESULTS = JOBS.folder
FIGURES = FOLDER / "figures"
BATCHES_DONE = [f"{RESULTS}/{BATCHES}/{batch}.json" for batch in JOBS.targets]
FITTED = [
    local(f"{RESULTS}/fit.{kind}") for kind in ("nc", "json") if JOBS.measurements
]
KEEP_OLDER = "--keep-older" if JOBS.keep_older else ""
# The command of this environment, whose folder may not be on the PATH.
FRETWEAR = f"{shlex.quote(sys.executable)} -m fretwear"


wildcard_constraints:
    batch=r"[0-9a-f]+-[0-9]+",


# The steps after the simulation take seconds, less than a cluster takes to start a job. Their
# outputs are marked as local, so that they stay in the folder of the results even if Snakemake
# passes the files of jobs through remote storage.
localrules:
    all,
    merge,
    figures,
    report,


# A line per finished case, and at the end the doubts, which the report has too.
onstart:
    for sentence in JOBS.study.remarks:
        tell(f"fretwear: warning: {sentence}")
    # A cluster has a number of jobs instead of cores.
    given = workflow.resource_settings
    at_once = given.nodes or given.cores or 1
    PROGRESS.append(Progress(JOBS, at_once, tell))
    PROGRESS[0].start()


onsuccess:
    PROGRESS[0].stop()
    # There is none if a target before the report was asked for.
    if (log := Path(f"{RESULTS}/logs/report.log")).exists():
        print(log.read_text(encoding="utf-8"), end="", file=sys.stderr)


# With --keep-going the finished cases are merged, drawn and reported although others have failed;
# the next run tries those again.
onerror:
    for progress in PROGRESS:
        progress.stop()
    if workflow.execution_settings.keep_going and (verdict := JOBS.verdict()):
        for step in ("merge", "figures", "report"):
            log_file = f"{RESULTS}/logs/{step}.log"
            options = KEEP_OLDER if step == "merge" else ""
            shell(
                "{FRETWEAR} {step} {STUDY:q} {options} >{log_file:q} 2>&1 || (cat {log_file:q} >&2; false)"
            )
        print(verdict, file=sys.stderr)


# A report that leaves out failed cases does not complete the workflow: all batches are required.
rule all:
    default_target: True
    input:
        local(f"{RESULTS}/report.html"),
        BATCHES_DONE,
    message:
        "Done: {input[0]}"


# A batch is a job that runs several cases in one process, each into its file, and keeps finished
# cases. Snakemake tracks the record that a batch leaves at its end, not the case files, which it
# would remove before running a batch again.
rule simulate:
    output:
        f"{RESULTS}/{BATCHES}/{{batch}}.json",
    log:
        f"{RESULTS}/logs/{BATCHES}/{{batch}}.log",
    benchmark:
        f"{RESULTS}/benchmarks/{BATCHES}/{{batch}}.tsv"
    priority: lambda wildcards: JOBS.job(wildcards.batch).priority
    resources:
        mem_mb=lambda wildcards: JOBS.job(wildcards.batch).memory_mb,
        runtime=lambda wildcards: JOBS.job(wildcards.batch).minutes,
    # The name of a batch contains everything that its files depend on. The position of its points
    # in the study is no reason to run it again, so Snakemake derives these parameters from the
    # output.
    params:
        points=lambda wildcards, output: JOBS.job(wildcards.batch).points,
        title=lambda wildcards, output: JOBS.job(wildcards.batch).title,
    message:
        "Simulating {params.title}"
    # `exec` replaces the shell, which would end as soon as the job is asked to stop; the scheduler
    # would then kill the command before it has written its checkpoint.
    shell:
        "exec {FRETWEAR} batch {STUDY:q} --points {params.points} --finished {output:q} --supervise "
        "{KEEP_OLDER} "
        ">{log:q} 2>&1"


rule merge:
    input:
        BATCHES_DONE,
    output:
        summary=local(f"{RESULTS}/summary.nc"),
        points=local(f"{RESULTS}/points.csv"),
        results=local(f"{RESULTS}/results.csv"),
    log:
        f"{RESULTS}/logs/merge.log",
    benchmark:
        f"{RESULTS}/benchmarks/merge.tsv"
    params:
        version=__version__,
        code=JOBS.code,
        # A function, because braces in a title are not wildcards.
        study=lambda wildcards: JOBS.content,
    message:
        "Merging {JOBS.study.name}"
    shell:
        "exec {FRETWEAR} merge {STUDY:q} {KEEP_OLDER} >{log:q} 2>&1"


# Only a study with the section fit has this job. Its runs depend on each other: they share the cores
# of one machine, and are kept, so that a fit that was stopped resumes.
rule fit:
    input:
        JOBS.measurements,
    output:
        local(f"{RESULTS}/fit.nc"),
        local(f"{RESULTS}/fit.json"),
    log:
        f"{RESULTS}/logs/fit.log",
    benchmark:
        f"{RESULTS}/benchmarks/fit.tsv"
    threads: workflow.resource_settings.cores or 1
    params:
        version=__version__,
        code=JOBS.code,
        study=lambda wildcards: JOBS.content,
    message:
        "Fitting {JOBS.study.name}"
    shell:
        "exec {FRETWEAR} fit {STUDY:q} --processes {threads} >{log:q} 2>&1"


rule figures:
    input:
        local(f"{RESULTS}/summary.nc"),
        FITTED,
    output:
        report(
            local(directory(f"{RESULTS}/figures")),
            patterns=["{figure}.svg"],
            caption=CAPTION,
            category=lambda wildcards: figure_category(FIGURES, wildcards.figure),
            labels=lambda wildcards: figure_labels(FIGURES, wildcards.figure),
        ),
    log:
        f"{RESULTS}/logs/figures.log",
    benchmark:
        f"{RESULTS}/benchmarks/figures.tsv"
    params:
        version=__version__,
        # Derived from the output: changed captions are no reason to draw figures again.
        captions=lambda wildcards, output: captions(FIGURES),
    message:
        "Drawing the figures of {JOBS.study.name}"
    shell:
        "{FRETWEAR} figures {STUDY:q} >{log:q} 2>&1"


rule report:
    input:
        local(f"{RESULTS}/summary.nc"),
        local(f"{RESULTS}/figures"),
        FITTED,
    output:
        report(local(f"{RESULTS}/report.html"), category="Report"),
        local(f"{RESULTS}/answer.json"),
    log:
        f"{RESULTS}/logs/report.log",
    benchmark:
        f"{RESULTS}/benchmarks/report.tsv"
    params:
        version=__version__,
    message:
        "Writing the report of {JOBS.study.name}"
    shell:
        "{FRETWEAR} report {STUDY:q} >{log:q} 2>&1"
