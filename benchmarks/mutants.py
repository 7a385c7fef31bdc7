"""Remove the checks of a file one at a time, and print those whose removal no test notices.

    python -m benchmarks.mutants src/fretwear/data/files.py tests/data/test_files.py ...

A check is a `raise`, or a `yield` of a problem. The tests run in a process forked for each.
"""

import ast
import contextlib
import io
import os
import sys
from importlib.machinery import SourceFileLoader
from pathlib import Path

import netCDF4  # noqa: F401 - once, before the processes fork
import pytest
import xarray  # noqa: F401

LIBRARIES = ("scipy.interpolate", "matplotlib.pyplot", "hypothesis", "rich.progress", "typer")


def checks(tree):
    """Yield the statements that refuse something, with the list that contains each."""
    for node in ast.walk(tree):
        for name in ("body", "orelse", "handlers"):
            block = getattr(node, name, None)
            for statement in block if isinstance(block, list) else ():
                is_problem = isinstance(statement, ast.Raise) or (
                    isinstance(statement, ast.Expr)
                    and isinstance(statement.value, ast.Yield | ast.YieldFrom)
                    and statement.value.value is not None
                    and not isinstance(statement.value.value, ast.Name | ast.Tuple)
                )
                if is_problem:
                    yield getattr(node, name), statement


def survives(path, number, tests):
    """Whether the tests pass without a check, or with all checks if the number is None.

    The source on the disk stays as it is.
    """
    module = ".".join(path.with_suffix("").parts[1:])
    child = os.fork()
    if child == 0:
        tree = ast.parse(path.read_text(encoding="utf-8"))
        for body, statement in [] if number is None else [[*checks(tree)][number]]:
            nothing = ast.Pass()
            if not isinstance(statement, ast.Raise):  # the function stays a generator
                nothing = ast.parse("yield from ()").body[0]
            body[body.index(statement)] = ast.copy_location(nothing, statement)
        code = compile(ast.fix_missing_locations(tree), path, "exec")
        load = SourceFileLoader.get_code
        SourceFileLoader.get_code = lambda self, name: code if name == module else load(self, name)
        with contextlib.redirect_stdout(io.StringIO()), contextlib.redirect_stderr(io.StringIO()):
            status = pytest.main(["-x", "-q", "-p", "no:cacheprovider", *tests])
        os._exit(int(status))
    return os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]) == 0


def main():
    path, tests = Path(sys.argv[1]), sys.argv[2:]
    for library in LIBRARIES:
        __import__(library)
    statements = [statement for _, statement in checks(ast.parse(path.read_text(encoding="utf-8")))]
    if not survives(path, None, tests):
        sys.exit("the tests fail as it is")
    lived = []
    for number, statement in enumerate(statements):
        if survives(path, number, tests):
            lived.append(statement)
            print(f"{path}:{statement.lineno}: {ast.unparse(statement)[:80]}", flush=True)
    print(f"{len(statements) - len(lived)} of {len(statements)} checks are noticed by the tests")


if __name__ == "__main__":
    main()
