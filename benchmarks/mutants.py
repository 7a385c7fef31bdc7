"""Remove the checks of a file one at a time, and print whether a test notices.

    python -m benchmarks.mutants src/fretwear/data/files.py tests/data tests/cli/test_files.py

A check is a `raise`, a `yield` or a returned text of a problem, or one of several conditions of
such a statement that are joined by `or`. The tests run once as they are, which tells which of them
come to each check; without a check only those run, in a forked process, to the first failure.
"""

import ast
import contextlib
import copy
import io
import os
import sys
import types
from importlib import import_module
from pathlib import Path

import pytest
from _pytest.runner import runtestprotocol

REACHED = set()
"""Numbers of the checks that the test at work has come to."""


def is_refusal(statement):
    """Whether a statement tells of a problem."""
    if isinstance(statement, ast.Return):
        told = statement.value
        told = told.body if isinstance(told, ast.IfExp) else told
        return isinstance(told, ast.JoinedStr) or (
            isinstance(told, ast.Constant) and isinstance(told.value, str) and " " in told.value
        )
    told = statement.value if isinstance(statement, ast.Expr) else None
    is_problem = isinstance(told, ast.Yield | ast.YieldFrom) and not isinstance(
        told.value, ast.Name | ast.Tuple | None
    )
    return isinstance(statement, ast.Raise) or is_problem


def checks(tree):
    """Yield for each check the list that contains it, its place, and what stands there without it.

    The order is the same for each copy of a tree.
    """
    for node in ast.walk(tree):
        for name in ("body", "orelse"):
            block = getattr(node, name, None)
            for place, statement in enumerate(block if isinstance(block, list) else ()):
                if is_refusal(statement):
                    # A generator remains one.
                    is_problem = isinstance(statement, ast.Expr)
                    yield block, place, ast.parse("yield from ()" if is_problem else "pass").body[0]
                if isinstance(statement, ast.If) and any(map(is_refusal, statement.body)):
                    test = statement.test
                    joined = isinstance(test, ast.BoolOp) and isinstance(test.op, ast.Or)
                    for number in range(len(test.values)) if joined else ():
                        fewer = copy.deepcopy(statement)
                        fewer.test.values[number] = ast.Constant(value=False)
                        yield block, place, fewer


def functions_of(module):
    """Yield the functions that a module defines, methods and decorated ones too."""
    for found in [*vars(module).values()]:
        if getattr(found, "__module__", "") != module.__name__:
            continue
        for each in vars(found).values() if isinstance(found, type) else (found,):
            each = getattr(each, "fget", None) or getattr(each, "__func__", each)
            each = getattr(each, "__wrapped__", each)
            if isinstance(each, types.FunctionType):
                yield each


def put(tree, path, module):
    """Let the functions of a module do what a changed tree says; its file stays as it is."""

    def codes(code):
        for each in code.co_consts:
            if isinstance(each, types.CodeType):
                yield each.co_qualname, each
                yield from codes(each)

    changed = dict(codes(compile(ast.fix_missing_locations(tree), path, "exec")))
    for function in functions_of(module):
        # A dataclass has functions that no file has.
        if (code := changed.get(function.__code__.co_qualname)) is not None:
            function.__code__ = code


class Trial:
    """Runs the collected tests with each check in turn removed; fixtures of the session stay."""

    def __init__(self, path):
        self.path, self.tree = path, ast.parse(path.read_text(encoding="utf-8"))
        self.module = import_module(".".join(path.with_suffix("").parts[1:]))
        self.unnoticed = self.count = 0

    def pytest_runtestloop(self, session):
        """Run all tests, then for each check those that come to it."""
        marked = copy.deepcopy(self.tree)
        for number, (block, place, _) in reversed([*enumerate(checks(marked))]):
            mark = f"__import__('sys').modules['__main__'].REACHED.add({number})"
            block.insert(place, ast.copy_location(ast.parse(mark).body[0], block[place]))
        put(marked, self.path, self.module)
        reaching = {}
        for item in session.items:
            REACHED.clear()
            if not self.passes(item):
                sys.exit(f"{item.nodeid} fails as it is")
            for number in REACHED:
                reaching.setdefault(number, []).append(item)
        for number, (block, place, _) in enumerate(checks(self.tree)):
            self.count += 1
            noticing = self.noticing(number, reaching.get(number, []))
            self.unnoticed += not noticing
            words = ast.unparse(block[place]).replace("\n", " ")[:70]
            print(
                f"{self.path}:{block[place].lineno}: {words}: {noticing or 'NO TEST'}", flush=True
            )
        print(f"{self.count - self.unnoticed} of {self.count} checks are noticed by the tests")
        return True

    def passes(self, item):
        """Whether a test passes, or is skipped; fixtures of the session stay."""
        with contextlib.redirect_stdout(io.StringIO()):
            reports = runtestprotocol(item, nextitem=item.session, log=False)
        return not any(report.failed for report in reports)

    def noticing(self, number, items):
        """The first of some tests that fails, or crashes, without a check; empty if none does."""
        hear, say = os.pipe()
        if child := os.fork():
            os.close(say)
            with os.fdopen(hear) as answer:
                tried = answer.read().splitlines()
            return tried[-1] if os.waitpid(child, 0)[1] else ""
        tree = copy.deepcopy(self.tree)
        block, place, instead = [*checks(tree)][number]
        block[place] = ast.copy_location(instead, block[place])
        put(tree, self.path, self.module)
        for item in items:
            os.write(say, f"{item.nodeid}\n".encode())
            if not self.passes(item):
                os._exit(1)
        os._exit(0)


def main():
    path, tests = Path(sys.argv[1]), sys.argv[2:]
    trial = Trial(path)
    pytest.main(
        ["-q", "-s", "-p", "no:cacheprovider", "-p", "no:warnings", *tests], plugins=[trial]
    )
    sys.exit(trial.unnoticed > 0 or not trial.count)


if __name__ == "__main__":
    main()
