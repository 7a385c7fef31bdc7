"""Snakemake in a process that has it imported, but no fretwear yet: tests may give it another."""

import os
import sys

SAID = "said.txt"


def snakemake(folder, arguments, environment):
    """Call Snakemake in a process of its own that has it imported."""
    os.chdir(folder)
    os.environ.update(environment)
    sys.path[:0] = filter(None, environment.get("PYTHONPATH", "").split(os.pathsep))
    log = os.open(SAID, os.O_WRONLY | os.O_CREAT | os.O_TRUNC)
    for stream in (1, 2):
        os.dup2(log, stream)
    from snakemake.cli import main

    main(arguments)
