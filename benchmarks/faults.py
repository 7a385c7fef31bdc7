"""Fail every operation of a small study in turn, and the power, and see what is left.

``python -m benchmarks.faults`` writes the table of docs/reliability.md; ``--points N`` tries at
most N points of each fault. A process into which ``faults.c`` is preloaded forks a child for each
point. The child computes and merges a study in an empty folder; its n-th operation fails, or a
signal arrives there. A second child then runs the same commands again, undisturbed.
"""

from __future__ import annotations

import argparse
import contextlib
import ctypes
import errno
import io
import json
import os
import random
import re
import shutil
import signal
import struct
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path

HERE = Path(__file__).parent
PAGE = HERE.parent / "docs/reliability.md"
BEGIN, END = "<!-- written by python -m benchmarks.faults -->\n", "<!-- end -->"

STUDY = """\
title: Two loads
base:
  radius: 10 mm
  youngs_modulus: 208 GPa
  poisson_ratio: 0.3
  tangential_ratio: 0.8
  friction: 0.5
  wear_coefficient: 7e-13 / Pa
  plastic_limit: none
  roughness: none
  cycles: 100
  cell: 14 um
vary:
  load: [25 N, 50 N]
output:
  cycles: [0, 10]
"""
COMMANDS = (("batch", "two.yaml"), ("merge", "two.yaml"))

OPEN, WRITE, FSYNC, RENAME, MKDIR, UNLINK, TRUNCATE, MEMORY = (1 << bit for bit in range(8))
ANY_FILE = MEMORY - 1
FAULTS = {
    "opening a file, no permission": (OPEN, errno.EACCES, 0),
    "opening a file, too many are open": (OPEN, errno.EMFILE, 0),
    "writing, the disk is full": (WRITE, errno.ENOSPC, 0),
    "writing, an input/output error": (WRITE, errno.EIO, 0),
    "flushing, an input/output error": (FSYNC, errno.EIO, 0),
    "renaming, an input/output error": (RENAME, errno.EIO, 0),
    "making a folder, the disk is full": (MKDIR, errno.ENOSPC, 0),
    "removing a file, an input/output error": (UNLINK, errno.EIO, 0),
    "emptying a file, an input/output error": (TRUNCATE, errno.EIO, 0),
    "no memory for an array": (MEMORY, errno.ENOMEM, 0),
    "Ctrl-C at a file operation": (ANY_FILE, 0, signal.SIGINT),
    "SIGTERM at a file operation": (ANY_FILE, 0, signal.SIGTERM),
    "SIGHUP at a file operation": (ANY_FILE, 0, signal.SIGHUP),
    "kill −9 at a file operation": (ANY_FILE, 0, signal.SIGKILL),
}
LONGEST = 120.0
_HEAD = struct.Struct("5q")


def compiled(folder: Path) -> Path:
    """Compile what is preloaded."""
    library = folder / "faults.so"
    command = ["cc", "-shared", "-fPIC", "-O1", "-o", library, HERE / "faults.c"]
    subprocess.run(command, check=True)
    return library


class Server:
    """A process with everything imported that runs the study in children of its own."""

    def __init__(self, folder: Path) -> None:
        library = compiled(folder)
        environment = {**os.environ, "LD_PRELOAD": str(library), "OMP_NUM_THREADS": "1"}
        self.process = subprocess.Popen(
            [sys.executable, "-m", "benchmarks.faults", "--serve", library],
            cwd=HERE.parent,
            env=environment,
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            text=True,
        )

    def run(self, folder: Path, kinds: int = 0, point: int = -1, error: int = 0, sent: int = 0,
            record: str = "") -> Outcome:  # fmt: skip
        """Run the study in a folder."""
        assert self.process.stdin is not None
        assert self.process.stdout is not None
        question = [str(folder), kinds, point, error, int(sent), record]
        self.process.stdin.write(json.dumps(question) + "\n")
        self.process.stdin.flush()
        return Outcome(**json.loads(self.process.stdout.readline()))

    def close(self) -> None:
        """End the process."""
        assert self.process.stdin is not None
        self.process.stdin.close()
        self.process.wait()


@dataclass(frozen=True)
class Outcome:
    """How a run ended, what it said, and how many operations were counted."""

    status: int
    said: str
    seen: int
    outside: int
    hung: bool


def serve(library: str) -> None:
    """Answer each question on standard input by a run in a child."""
    # Once here, so that no child imports anything or computes what is kept.
    with tempfile.TemporaryDirectory() as place, contextlib.chdir(place):
        Path("two.yaml").write_text(STUDY)
        nothing = io.StringIO()
        with contextlib.redirect_stderr(nothing), contextlib.redirect_stdout(nothing):
            assert run_commands() == 0, nothing.getvalue()
    faults = ctypes.CDLL(library)
    faults.faults_seen.restype = faults.faults_outside.restype = ctypes.c_long
    for line in sys.stdin:
        folder, kinds, point, error, sent, record = json.loads(line)
        home = Path(folder)
        said, counts = home.with_name("said.txt"), home.with_name("counts.txt")
        counts.unlink(missing_ok=True)
        child = os.fork()
        if child == 0:
            _in_child(faults, home, said, counts, kinds, point, error, sent, record)
        status, hung = _wait(child)
        seen, outside = map(int, counts.read_text().split()) if counts.exists() else (point + 1, 0)
        text = said.read_text(encoding="utf-8", errors="replace")
        answer = {"status": status, "said": text, "seen": seen, "outside": outside, "hung": hung}
        print(json.dumps(answer), flush=True)


def _wait(child: int) -> tuple[int, bool]:
    deadline = time.monotonic() + LONGEST
    while time.monotonic() < deadline:
        done, status = os.waitpid(child, os.WNOHANG)
        if done:
            return os.waitstatus_to_exitcode(status), False
        time.sleep(0.002)
    os.kill(child, signal.SIGKILL)
    return os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]), True


def run_commands() -> int:
    """Run the study as the command line does; return the exit status of what failed, or 0."""
    from fretwear.cli import main

    for command in COMMANDS:
        sys.argv = ["fretwear", *command]
        try:
            main()
        except SystemExit as left:
            if left.code:
                return int(left.code)
    return 0


def _in_child(faults, home, said, counts, kinds, point, error, sent, record):  # type: ignore[no-untyped-def]
    os.chdir(home)
    log = os.open(said, os.O_WRONLY | os.O_CREAT | os.O_TRUNC)
    for stream in (1, 2):
        os.dup2(log, stream)
    status = 1
    faults.faults_arm(str(home).encode(), kinds, ctypes.c_long(point), error, sent, record.encode())
    try:
        status = run_commands()
    finally:
        faults.faults_disarm()
        counts.write_text(f"{faults.faults_seen()} {faults.faults_outside()}")
        os._exit(status)


@dataclass
class Tally:
    """What was found at the points of one fault."""

    points: int = 0
    changed: list[int] = field(default_factory=list)
    tracebacks: list[int] = field(default_factory=list)
    silent: list[int] = field(default_factory=list)
    hangs: list[int] = field(default_factory=list)
    outside: list[int] = field(default_factory=list)
    left: list[int] = field(default_factory=list)

    def row(self, name: str, of: int) -> str:
        """A row of the table."""
        found = (self.changed, self.tracebacks, self.silent, self.hangs, self.outside, self.left)
        tried = f"{self.points}" if self.points >= of else f"{self.points} of {of}"
        return f"| {name} | {tried} | {' | '.join(str(len(each)) for each in found)} |"


class Trials:
    """Runs of the study with faults, each in a folder of its own beside the undisturbed one."""

    def __init__(self, folder: Path, server: Server) -> None:
        self.folder, self.server = folder, server
        home = self.fresh()
        assert server.run(home).status == 0
        self.expected, self.files = contents(home), names(home)

    def fresh(self) -> Path:
        """An empty folder with the study."""
        home = self.folder / "home"
        shutil.rmtree(home, ignore_errors=True)
        home.mkdir()
        (home / "two.yaml").write_text(STUDY)
        return home

    def count(self, kinds: int) -> int:
        """How many operations of some kinds the undisturbed study has."""
        return self.server.run(self.fresh(), kinds).seen

    def judge(self, tally: Tally, point: int, home: Path, outcome: Outcome | None) -> None:
        """Run the study again after a fault, and note what is not as it should be."""
        tally.points += 1
        again = self.server.run(home)
        is_killed = outcome is None or outcome.status == -signal.SIGKILL
        if again.status != 0 or contents(home) != self.expected:
            tally.changed.append(point)
        said = again.said + (outcome.said if outcome else "")
        if "Traceback" in said or "defect" in said:
            tally.tracebacks.append(point)
        if outcome and outcome.status and not is_killed and "fretwear: " not in outcome.said:
            tally.silent.append(point)
        if again.hung or (outcome and outcome.hung):
            tally.hangs.append(point)
        if again.outside or (outcome and outcome.outside):
            tally.outside.append(point)
        if set(names(home)) - set(self.files):
            tally.left.append(point)

    def sweep(self, kinds: int, error: int, sent: int, points: list[int]) -> Tally:
        """Let the operations with these numbers fail, each in a run of its own."""
        tally = Tally()
        for point in points:
            home = self.fresh()
            outcome = self.server.run(home, kinds, point, error, sent)
            self.judge(tally, point, home, outcome)
        return tally

    def without_power(self, points: int, seed: int = 1) -> tuple[Tally, int]:
        """Cut the power at random moments: what was not flushed is there or not, or in part."""
        record = self.folder / "record"
        home = self.fresh()
        assert self.server.run(home, record=str(record)).status == 0
        operations = list(recorded(record, home))
        tally, generator = Tally(), random.Random(seed)
        for _ in range(points):
            point = generator.randrange(len(operations))
            home = self.fresh()
            replay(operations[:point], home, generator)
            self.judge(tally, point, home, None)
        return tally, len(operations)


def names(home: Path) -> list[str]:
    """Files that a study leaves."""
    return sorted(str(path.relative_to(home)) for path in home.rglob("*"))


def contents(home: Path) -> dict[str, object]:
    """Everything in the case files and the summary but the lines that say when."""
    import netCDF4

    found: dict[str, object] = {}
    for path in sorted(home.rglob("*.nc")):
        with netCDF4.Dataset(path) as file:
            file.set_auto_maskandscale(False)
            for group in (file, *file.groups.values()):
                for name, variable in group.variables.items():
                    found[f"{path.name}/{group.name}/{name}"] = variable[...].tobytes()
                for name in set(group.ncattrs()) - {"history"}:
                    found[f"{path.name}/{group.name}.{name}"] = str(group.getncattr(name))
    return found


def recorded(record: Path, home: Path) -> Iterator[tuple[int, int, int, str, bytes]]:
    """Operations in order: kind, number of the open file, a number, path, data."""
    content, at = record.read_bytes(), 0
    while at < len(content):
        kind, serial, number, *sizes = _HEAD.unpack_from(content, at)
        at += _HEAD.size
        path, data = (content[at : at + sizes[0]], content[at + sizes[0] : at + sum(sizes)])
        at += sum(sizes)
        yield kind, serial, number, os.path.relpath(os.fsdecode(path), home) if path else "", data


def replay(operations, home, generator):  # type: ignore[no-untyped-def]
    """Leave in a folder what a disk may hold when the power fails after some operations.

    What was flushed is there. Of what was not, names are there as far as a random moment, as
    with a journal, or any of them; of the content any blocks of 4 kB.
    """
    root = os.fsencode(os.path.abspath(home))  # noqa: PTH100
    opened: dict[int, int | str] = {}
    volatile: dict[str, int] = {}
    durable: dict[str, int] = {}
    data: dict[int, bytearray] = {}
    kept: dict[int, bytearray] = {}
    folders: set[str] = set()
    pending: list[tuple[str, int | None]] = []

    def settle(changes):  # type: ignore[no-untyped-def]
        for name, inode in changes:
            durable.pop(name, None)
            if inode is not None:
                durable[name] = inode

    def change(name, inode):  # type: ignore[no-untyped-def]
        pending.append((name, inode))
        volatile.pop(name, None)
        if inode is not None:
            volatile[name] = inode

    for kind, serial, number, path, content in operations:
        if kind == MKDIR:
            folders.add(path)
        elif kind == OPEN and number & os.O_TMPFILE == os.O_TMPFILE:
            pass  # a file without a name, gone with the power
        elif kind == OPEN and (path == "." or path in folders):
            opened[serial] = path
        elif kind == OPEN:
            if path not in volatile and number & os.O_CREAT:
                data[len(data)] = bytearray()
                kept[len(kept)] = bytearray()
                change(path, len(data) - 1)
            if path in volatile:
                opened[serial] = volatile[path]
                if number & os.O_TRUNC:
                    data[volatile[path]][:] = b""
        elif kind in (WRITE, TRUNCATE) and (inode := opened.get(serial)) is not None:
            size = number if kind == TRUNCATE else max(len(data[inode]), number + len(content))
            data[inode][:] = data[inode][:size].ljust(size, b"\0")
            data[inode][number : number + len(content)] = content
        elif kind == FSYNC and isinstance(of := opened.get(serial), str):
            within = [each for each in pending if str(Path(each[0]).parent) == of]
            settle(within)
            pending[:] = [each for each in pending if each not in within]
        elif kind == FSYNC and of is not None:
            kept[of][:] = data[of]
        elif kind == RENAME:
            target = os.path.relpath(content, root).decode()
            change(target, volatile[path])
            change(path, None)
        elif kind == UNLINK and path in volatile:
            change(path, None)
    if generator.random() < 0.5:
        settle(pending[: generator.randint(0, len(pending))])
    else:
        settle([each for each in pending if generator.random() < 0.5])
    for name in folders:
        (home / name).mkdir(parents=True, exist_ok=True)
    for name, inode in durable.items():
        new, old = bytes(data[inode]), bytes(kept[inode])
        blocks = []
        for start in range(0, max(len(new), len(old)), 4096):
            source = new if generator.random() < 0.5 else old
            blocks.append(source[start : start + 4096].ljust(4096, b"\0"))
        whole = new == old
        size = len(new) if whole or generator.random() < 0.5 else len(old)
        (home / name).write_bytes(b"".join(blocks)[:size])


def main() -> None:
    """Run all faults and write the table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--serve")
    parser.add_argument("--points", type=int, default=10**9)
    parser.add_argument("--only", default="")
    options = parser.parse_args()
    if options.serve:
        serve(options.serve)
        return
    with tempfile.TemporaryDirectory() as place:
        server = Server(Path(place))
        trials = Trials(Path(place), server)
        rows = []
        for name, (kinds, error, sent) in FAULTS.items():
            if options.only and options.only not in name:
                continue
            count = trials.count(kinds)
            step = max(1, -(-count // options.points))
            tally = trials.sweep(kinds, error, sent, list(range(0, count, step)))
            rows.append(tally.row(name, count))
            print(rows[-1], tally, flush=True)
        if not options.only or options.only in "power":
            tally, count = trials.without_power(min(200, 3 * options.points))
            rows.append(tally.row(f"power failure at one of {count} operations", 0))
            print(rows[-1], tally, flush=True)
        server.close()
    if not options.only:
        head = (
            "| fault | points tried | results lost or changed | tracebacks | ends without a word "
            "| hangs | files touched outside | files left over |\n" + "|---" + "|---:" * 7 + "|\n"
        )
        text = PAGE.read_text(encoding="utf-8")
        table = f"{BEGIN}{head}{chr(10).join(rows)}\n{END}"
        text = re.sub(re.escape(BEGIN) + ".*?" + re.escape(END), lambda _: table, text, flags=re.S)
        PAGE.write_text(text, encoding="utf-8")


if __name__ == "__main__":
    main()
