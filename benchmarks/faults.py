"""Fail every operation of a small study, and the power, and judge the remains.

``python -m benchmarks.faults`` writes the table of docs/reliability.md; ``--every N`` tries every
N-th point only. A process, into which ``faults.c`` is preloaded, computes, merges, draws and
reports a study; another, beside it, does so for the faults of memory. At each of its operations on
the files of the results, and at each new place where it takes memory, it forks once for each fault.
The child goes on in a copy of the folder, where this operation fails or a signal arrives, until its
command ends. Each different folder that is left is then given to the same commands again,
undisturbed; one that a command has left before is not followed again. The clock stands still, so
that the same results are the same bytes. As root on Linux: the copy is mounted in the place of the
folder.
"""

from __future__ import annotations

import argparse
import contextlib
import ctypes
import errno
import fcntl
import gc
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
import traceback
import zlib
from collections.abc import Callable, Iterator
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
  cycles: 20
  cell: 14 um
vary:
  load: [25 N, 50 N]
output:
  cycles: [0]
  stress: {depth: 0.3 mm, fatigue_strength: 1000 MPa, strength_exponent: -0.1}
fit:
  free: {wear_coefficient: [1e-13 / Pa, 1e-11 / Pa]}
  data:
    - file: scar.csv
      quantity: wear_depth
      test: 2
      noise: 1 nm
      correlation_length: 0 um
      baseline: none
"""
SCAR = "x (um),depth (nm)\n-160,0\n-140,4\n-120,5\n-100,2\n0,0\n100,1\n120,4\n140,4\n160,0\n"
COMMANDS = ("batch", "merge", "fit", "figures", "report")

_KILLED = "kill −9 of a {} at a random moment"

OPEN, WRITE, FSYNC, RENAME, MKDIR, UNLINK, TRUNCATE, MEMORY, LIBRARY = (
    1 << bit for bit in range(9)
)
KINDS = 9
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
    "no memory for an array or an object": (MEMORY, errno.ENOMEM, 0),
    "no memory inside a library": (LIBRARY, errno.ENOMEM, 0),
    "Ctrl-C at a file operation": (ANY_FILE, 0, signal.SIGINT),
    "SIGTERM at a file operation": (ANY_FILE, 0, signal.SIGTERM),
    "SIGHUP at a file operation": (ANY_FILE, 0, signal.SIGHUP),
    "kill −9 at a file operation": (ANY_FILE, 0, signal.SIGKILL),
}
STARTING = {
    "Ctrl-C": signal.SIGINT, "SIGTERM": signal.SIGTERM, "SIGHUP": signal.SIGHUP,
    "kill −9": signal.SIGKILL,
}  # fmt: skip
# What a shell, Snakemake, or the process that supervises a batch tells of.
CRASHES = (-signal.SIGSEGV, -signal.SIGABRT, -signal.SIGBUS)
_HEAD = struct.Struct("5q")
# FS_IOC_SHUTDOWN of Linux, which ext4 and XFS know, without flushing the journal.
_CUT_OFF, _WITHOUT_WRITING = 0x8004587D, struct.pack("I", 2)
_DISK_BYTES = 400 << 20
DISKS = [
    disk
    for disk in ("ext4", "xfs")
    if shutil.which(f"mkfs.{disk}") and Path("/dev/loop-control").exists()
]
_TEMPORARY = re.compile(r"\.[^.]+\.\d+\.[0-9a-f]{8}\.tmp$")


class Fault(ctypes.Structure):
    """Which operations fail, with which error or signal, and every how many of them."""

    _fields_ = tuple(
        (name, ctypes.c_long) for name in ("kinds", "error", "sent", "every", "chosen")
    )


@dataclass
class Tally:
    """The findings at the points of one fault."""

    name: str
    of: int = 0
    points: int = 0
    changed: list[str] = field(default_factory=list)
    tracebacks: list[str] = field(default_factory=list)
    silent: list[str] = field(default_factory=list)
    hangs: list[str] = field(default_factory=list)
    outside: list[str] = field(default_factory=list)
    left: list[str] = field(default_factory=list)
    defects: list[str] = field(default_factory=list)
    crashes: list[str] = field(default_factory=list)

    @property
    def found(self) -> tuple[list[str], ...]:
        """The points of each kind of harm."""
        return (self.changed, self.tracebacks, self.silent, self.hangs, self.outside, self.left)

    def row(self) -> str:
        """A row of the table."""
        tried = f"{self.points}" if self.points == self.of else f"{self.points} of {self.of}"
        counts = " | ".join(str(len(each)) for each in (*self.found, self.defects, self.crashes))
        return f"| {self.name} | {tried} | {counts} |"

    def note(self, point: str, said: str, status: int, *, hung: bool, outside: int) -> bool:
        """Note how a process ended in which a fault was; say whether that was wrong."""
        self.points += 1
        before = sum(map(len, self.found))
        if "Traceback" in said and "fretwear: " not in said:
            self.tracebacks.append(point)
        if "defect of fretwear" in said:
            self.defects.append(point)
        words = ("fretwear: ", "memory allocation of")  # the latter where a library in Rust ends it
        if status in CRASHES:
            self.crashes.append(point)
        elif status not in (0, -signal.SIGKILL) and not any(each in said for each in words):
            self.silent.append(f"{point} ({status})")
        if hung:
            self.hangs.append(point)
        if outside:
            self.outside.append(point)
        return sum(map(len, self.found)) > before or "defect of fretwear" in said


class Trials:
    """A study with faults, and the same study undisturbed."""

    def __init__(self, folder: Path, library: ctypes.CDLL, commands: int) -> None:
        self.folder, self.home, self.copies = folder, folder / "home", folder / "copies"
        self.copies.mkdir()
        self.library, self.commands = library, COMMANDS[:commands]
        self.fresh()
        for command in self.commands:
            status, said = self.undisturbed(command)
            assert status == 0, said
        self.expected = state_of(self.home)
        # By path: a case and its stresses have files of one name in two folders.
        self.values = {
            str(each.relative_to(self.home)): values_of(each) for each in self.home.rglob("*.nc")
        }
        # What was found wrong in what a state became, by the commands that had run in it.
        self.verdicts: dict[object, set[str]] = {}

    def fresh(self) -> None:
        """Make an empty folder with the study."""
        shutil.rmtree(self.home, ignore_errors=True)
        self.home.mkdir()
        write_study(self.home)

    def undisturbed(self, command: str) -> tuple[int, str]:
        """Run a command in a child; return its exit status and its output."""
        child = os.fork()
        if child == 0:
            self._work((command,), int)
        status = os.waitstatus_to_exitcode(os.waitpid(child, 0)[1])
        return status, (self.folder / "said.txt").read_text(encoding="utf-8", errors="replace")

    def _work(self, commands: tuple[str, ...], arm: Callable[[], object]) -> None:
        from fretwear.cli import main

        os.chdir(self.home)
        log = os.open(self.folder / "said.txt", os.O_WRONLY | os.O_CREAT | os.O_TRUNC)
        for stream in (1, 2):
            os.dup2(log, stream)
        status = 70
        arm()
        try:
            for command in commands:
                sys.argv = ["fretwear", command, "two.yaml"]
                try:
                    main(watched=False)
                except SystemExit as left:
                    status = int(left.code or 0)
                except BaseException:
                    traceback.print_exc()
                    raise
                if status or self.library.faults_is_child():
                    break
        finally:
            self.library.faults_disarm()
            if not self.library.faults_is_child():
                seen = [self.library.faults_operations(1 << bit) for bit in range(KINDS)]
                (self.folder / "operations.json").write_text(json.dumps(seen))
            os._exit(status)

    def sweep(self, faults: dict[str, tuple[int, int, int]], every: int,
              record: Path) -> list[Tally]:  # fmt: skip
        """Let operations fail, each in a process of its own, and judge what each leaves."""
        self.fresh()
        begun = time.monotonic()
        tallies = [Tally(name) for name in faults]
        wanted = (Fault * len(faults))(
            *(Fault(kinds, error, int(sent), every) for kinds, error, sent in faults.values())
        )
        hear, say = os.pipe()
        answered, answer = os.pipe()
        child = os.fork()
        if child == 0:
            os.close(hear)
            os.close(answer)
            settings = (
                os.fsencode(self.home), os.fsencode(self.copies), wanted, len(wanted),
                say, answered, os.fsencode(record),
            )  # fmt: skip
            self._work(self.commands, lambda: self.library.faults_arm(*settings))
        os.close(say)
        os.close(answered)
        states: dict[object, tuple[Path, list[tuple[Tally, str]]]] = {}
        with os.fdopen(hear) as events:
            for line in events:
                fault, kind, number, status, hung, outside = map(int, line.split())
                copy = self.copies / f"{fault}-{kind}-{number}"
                said_file = copy.with_name(f"{copy.name}.said")
                said = said_file.read_text(encoding="utf-8", errors="replace")
                said_file.unlink()
                point = f"{kind}:{number}"
                if tallies[fault].note(point, said, status, hung=bool(hung), outside=outside):
                    print(tallies[fault].name, point, status, said[-3000:], flush=True)
                kept, points = states.setdefault(state_of(copy), (copy, []))
                points.append((tallies[fault], point))
                if kept != copy:
                    shutil.rmtree(copy)
                os.write(answer, b"x")
        os.close(answer)
        status = os.waitstatus_to_exitcode(os.waitpid(child, 0)[1])
        assert status == 0, (self.folder / "said.txt").read_text(encoding="utf-8")
        seen = json.loads((self.folder / "operations.json").read_text())
        for tally, what in zip(tallies, wanted, strict=True):
            tally.of = sum(seen[bit] for bit in range(KINDS) if what.kinds >> bit & 1)
        tried = sum(each.points for each in tallies)
        print(f"{time.monotonic() - begun:.0f} s, {tried} points, {len(states)} states", flush=True)
        for copy, points in states.values():
            shutil.rmtree(self.home)
            copy.rename(self.home)
            self.judge(points)
        print(f"{time.monotonic() - begun:.0f} s, {len(self.verdicts)} commands", flush=True)
        return tallies

    def judge(self, points: list[tuple[Tally, str]]) -> None:
        """Run the study again in the folder that faults have left, and note what is wrong."""
        found = self.verdict()
        if found:
            print(points[0][0].name, points[0][1], found, flush=True)
        for tally, point in points:
            for kind in found:
                getattr(tally, kind).append(f"{point} (again)")

    def verdict(self, done: int = 0) -> set[str]:
        """Run the commands in the folder, those after the first ones; say what is wrong then."""
        state = state_of(self.home)
        if done == len(self.commands):
            more = {name for name, _ in state} - {name for name, _ in self.expected}
            lost = {
                name
                for name, _ in self.expected - state
                if not name.endswith(".nc")
                or not (self.home / name).exists()
                or values_of(self.home / name) != self.values[name]
            }
            if more or lost:
                print(more, lost, flush=True)
            return {*(["left"] if more else []), *(["changed"] if lost else [])}
        key = done, state
        if key not in self.verdicts:
            status, said = self.undisturbed(self.commands[done])
            own = {
                *(["changed"] if status else []),
                *(["tracebacks"] if is_traceback(said) else []),
            }
            if own:
                print(self.commands[done], status, said[-3000:], flush=True)
            self.verdicts[key] = own | self.verdict(done + 1)
        return self.verdicts[key]

    def without_power(self, record: Path, points: int, seed: int = 1) -> Tally:
        """Cut the power at random moments: what was not flushed is there or not, or in part."""
        operations = list(recorded(record, self.home))
        tally = Tally("power failure at any operation", len(operations))
        generator = random.Random(seed)
        for _ in range(points):
            point = generator.randrange(len(operations))
            self.fresh()
            replay(operations[:point], self.home, generator)
            tally.points += 1
            self.judge([(tally, str(point))])
        return tally

    def without_power_on(self, disk: str, points: int, seed: int = 1) -> Tally:
        """Cut a real file system off its disk at random moments, then mount it again.

        What it has not written by then, in the file that is its disk, never is.
        """
        tally = Tally(f"power failure on {disk}", points)
        generator, image = random.Random(seed), self.folder / "disk"
        started = time.monotonic()
        self.fresh()
        for command in self.commands:
            self.undisturbed(command)
        duration = time.monotonic() - started

        # The system may still hold the file system that was cut off, of which this is a copy.
        options = "loop,nouuid" if disk == "xfs" else "loop"

        def mount(disk_file: Path) -> None:
            subprocess.run(["mount", "-o", options, disk_file, self.home], check=True)

        for _ in range(points):
            moment = generator.uniform(0.0, duration)
            self.fresh()
            with image.open("wb") as stream:
                stream.truncate(_DISK_BYTES)
            subprocess.run([f"mkfs.{disk}", "-q", image], check=True)
            mount(image)
            try:
                write_study(self.home)
                os.sync()
                root = os.open(self.home, os.O_RDONLY)
                child = os.fork()
                if child == 0:
                    self._work(self.commands, int)
                time.sleep(moment)
                fcntl.ioctl(root, _CUT_OFF, _WITHOUT_WRITING)
                os.kill(child, signal.SIGKILL)
                os.waitpid(child, 0)
                os.close(root)
                subprocess.run(["umount", self.home], check=True)
                after = image.with_name("after")
                subprocess.run(["cp", "--sparse=always", image, after], check=True)
                mount(after)
                copy = self.copies / disk
                shutil.copytree(self.home, copy, ignore=shutil.ignore_patterns("lost+found"))
            finally:
                subprocess.run(["umount", self.home], check=False)
            shutil.rmtree(self.home)
            copy.rename(self.home)
            tally.points += 1
            self.judge([(tally, f"{moment:.3f} s")])
        return tally

    def killed(self, command: str, kills: int, seed: int = 1) -> Tally:
        """Kill a command at random moments, up to three times before it may end."""
        tally, generator = Tally(_KILLED.format(command), kills), random.Random(seed)
        self.fresh()
        for before in self.commands[: self.commands.index(command)]:
            self.undisturbed(before)
        start = self.folder / "start"
        shutil.copytree(self.home, start)
        begun = time.monotonic()
        self.undisturbed(command)
        duration = time.monotonic() - begun
        while tally.points < kills:
            shutil.rmtree(self.home)
            shutil.copytree(start, self.home)
            moments = [generator.uniform(0.0, duration) for _ in range(generator.randint(1, 3))]
            for moment in moments:
                child = os.fork()
                if child == 0:
                    self._work((command,), int)
                time.sleep(moment)
                os.kill(child, signal.SIGKILL)
                os.waitpid(child, 0)
            tally.points += len(moments)
            tally.of = max(kills, tally.points)
            self.judge([(tally, f"{moments} s")])
        shutil.rmtree(start)
        return tally

    def at_start(self) -> list[Tally]:
        """Send a signal to a process that starts, at each file that it opens."""
        self.fresh()
        environment = {**os.environ, "FAULTS_AT_START": str(self.copies)}
        command = [sys.executable, "-m", "fretwear", "plan", "two.yaml"]
        before = state_of(self.home)
        done = subprocess.run(
            command, cwd=self.home, env=environment, capture_output=True, text=True, check=True
        )
        tallies = {sent: Tally(f"{name} while it starts") for name, sent in STARTING.items()}
        for line in re.findall(r"^\d+ \d+ -?\d+ \d$", done.stderr, re.MULTILINE):
            number, sent, status, hung = map(int, line.split())
            said = (self.copies / f"{number}-{sent}").read_text(encoding="utf-8")
            point = str(number)
            if tallies[sent].note(point, said, status, hung=bool(hung), outside=0):
                print(tallies[sent].name, point, status, said[-1500:], flush=True)
            tallies[sent].of += 1
            if state_of(self.home) != before:
                tallies[sent].changed.append(point)
        return list(tallies.values())


def write_study(folder: Path) -> None:
    """Write the study and the readings to which it is fitted."""
    (folder / "two.yaml").write_text(STUDY)
    (folder / "scar.csv").write_text(SCAR)


def is_traceback(said: str) -> bool:
    """Say whether a command has left people alone with a traceback."""
    return "Traceback" in said or "defect of fretwear" in said


def state_of(home: Path) -> frozenset[tuple[str, int]]:
    """What a folder holds, as far as another run reads it: no log, lock or temporary file."""
    found = []
    for path in home.rglob("*"):
        name = str(path.relative_to(home))
        if path.suffix == ".log":
            continue
        is_read = path.is_file() and path.suffix not in (".lock", ".tmp")
        found.append(
            (_TEMPORARY.sub(".tmp", name), zlib.crc32(path.read_bytes()) if is_read else 0)
        )
    return frozenset(found)


def values_of(path: Path) -> dict[str, object]:
    """All values and attributes of a file, which HDF5 may lay out in more than one way."""
    import netCDF4

    found: dict[str, object] = {}
    with netCDF4.Dataset(path) as file:
        file.set_auto_maskandscale(False)
        for group in (file, *file.groups.values()):
            for name, variable in group.variables.items():
                found[f"{group.name}/{name}"] = variable[...].tobytes()
            # Stresses have the time of the case file among what was asked for.
            for name in {*group.ncattrs()} - {"asked"}:
                found[f"{group.name}.{name}"] = str(group.getncattr(name))
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

    What was flushed is there. Unflushed names are there up to a random moment, as with a journal,
    or any of them; any blocks of 4 kB are there of unflushed content.
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


def warm(folder: Path, commands: tuple[str, ...]) -> None:
    """Run the study once, so that no child imports anything or recomputes cached values."""
    from fretwear.cli import main
    from fretwear.figures import study

    # One figure of each kind.
    study.STUDY_HISTORIES = study.STUDY_HISTORIES[:1]
    study.STUDY_PROFILES = study.STUDY_PROFILES[:1]
    with contextlib.chdir(folder), contextlib.redirect_stderr(io.StringIO()) as said:
        write_study(Path())
        for command in commands:
            sys.argv = ["fretwear", command, "two.yaml"]
            with contextlib.suppress(SystemExit):
                main()
        assert Path("results/two/summary.nc").exists(), said.getvalue()
    gc.collect()
    gc.freeze()


def write_rows(begin: str, head: str, rows: dict[str, str], end: str) -> None:
    """Replace the rows of a table that have the same names, and append the others."""
    text = PAGE.read_text(encoding="utf-8")
    before, between, after = re.split(f"({begin}.*?{end})", text, flags=re.DOTALL)
    known = {row.split(" | ")[0][2:]: row for row in between.splitlines()[3:-1]}
    table = "\n".join((known | rows).values())
    PAGE.write_text(f"{before}{begin}{head}{table}\n{end}{after}", encoding="utf-8")


def in_two(library: Path, options: argparse.Namespace) -> int:
    """Try the faults of memory in one process and the others beside it; write the table of all."""
    build = ["cc", "-shared", "-fPIC", "-O1", "-o", library, HERE / "faults.c", "-ldl"]
    subprocess.run(build, check=True)
    environment = {**os.environ, "LD_PRELOAD": str(library), "OMP_NUM_THREADS": "1"}
    command = [sys.executable, "-m", "benchmarks.faults", *sys.argv[1:]]
    memory = (f"(?=no memory).*({options.only})", "0")
    others = (f"(?!no memory).*({options.only})", str(options.power))
    started = [
        subprocess.Popen(
            [*command, "--only", only, "--power", power],
            env=environment, stdout=subprocess.PIPE, text=True,
        )
        for only, power in (others, memory)
    ]  # fmt: skip
    said = [process.communicate()[0] for process in started]
    print(*said, sep="\n", flush=True)
    lines = "\n".join(said).splitlines()
    rows = {row.split(" | ")[0][2:]: row for row in lines if row.startswith("| ")}
    if options.every == 1 and options.commands == len(COMMANDS):
        head = (
            "| fault | points tried | results lost or changed | tracebacks without a message "
            "| ends without a word | hangs | files touched outside | files left over "
            "| taken for a defect | crashes of a library |\n|---" + "|---:" * 9 + "|\n"
        )
        write_rows(BEGIN, head, rows, END)
    return int(any(process.returncode for process in started))


def main() -> None:
    """Run all faults and write the table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--every", type=int, default=1, help="try every N-th point of each fault")
    parser.add_argument("--only", default="", help="faults whose names this matches")
    parser.add_argument("--commands", type=int, default=len(COMMANDS), help="how many commands")
    parser.add_argument("--power", type=int, default=200, help="failures of the power")
    parser.add_argument("--kills", type=int, default=40, help="kills of a fit")
    parser.add_argument("--cuts", type=int, default=20, help="failures on each real file system")
    options = parser.parse_args()
    # In the background a shell lets its commands ignore Ctrl-C.
    signal.signal(signal.SIGINT, signal.default_int_handler)
    with tempfile.TemporaryDirectory() as place:
        folder = Path(place).resolve()
        if not os.environ.get("LD_PRELOAD", "").endswith("faults.so"):
            sys.exit(in_two(folder / "faults.so", options))
        library = ctypes.CDLL(os.environ["LD_PRELOAD"])
        library.faults_operations.restype = ctypes.c_long
        library.faults_freeze()
        (folder / "warm").mkdir()
        warm(folder / "warm", COMMANDS[: options.commands])
        trials = Trials(folder, library, options.commands)
        chosen = {name: each for name, each in FAULTS.items() if re.match(options.only, name)}
        tallies = trials.sweep(chosen, options.every, folder / "record")
        if options.power:
            tallies.append(trials.without_power(folder / "record", options.power))
        for disk in DISKS:
            if re.match(options.only, f"power failure on {disk}"):
                tallies.append(trials.without_power_on(disk, options.cuts))
        if (
            options.kills
            and re.match(options.only, _KILLED.format("fit"))
            and "fit" in trials.commands
        ):
            tallies.append(trials.killed("fit", options.kills))
        if re.match(options.only, "start"):
            tallies += trials.at_start()
    print("\n".join(tally.row() for tally in tallies), flush=True)
    sys.exit(any(each for tally in tallies for each in tally.found))


if __name__ == "__main__":
    main()
