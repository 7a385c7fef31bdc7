"""Cases to files: one writer to each, a checkpoint beside it, one case or a batch of them.

An interrupted run loses at most a minute, and resumes bit for bit. A checkpoint is the run record:
two lines of JSON, the second with the shapes of the arrays that follow, and a checksum.
"""

from __future__ import annotations

import json
import math
import shlex
import time
import traceback
from collections.abc import Callable, Iterator, Mapping, Sequence
from concurrent.futures import BrokenExecutor
from contextlib import AbstractContextManager, suppress
from dataclasses import fields, is_dataclass
from inspect import isabstract
from pathlib import Path
from typing import (
    TYPE_CHECKING,
    Any,
    NamedTuple,
    Protocol,
    Self,
    cast,
    get_args,
    get_origin,
    get_type_hints,
)

import numpy as np
from numpy.typing import NDArray

from fretwear.data.files import finished_by, open_history, write_case
from fretwear.data.safe import (
    DataFileError,
    Lock,
    Unfailing,
    add_checksum,
    atomic_path,
    damage,
    is_of_memory,
    is_of_netcdf,
    open_log,
    remove_stale_temporaries,
    uninterrupted,
)
from fretwear.mechanics.contact.problem import ContactError
from fretwear.mechanics.wear.integrator import WearError
from fretwear.run.resources import require_memory
from fretwear.run.simulate import Observer, RunRecord, Step, run
from fretwear.run.workflow import failures, forget, log_file, record
from fretwear.version import code_digest
from fretwear.vocabulary import SCALARS

if TYPE_CHECKING:
    from fretwear.study.case import Case
    from fretwear.study.study import Study

SECONDS_BETWEEN = 30.0
_PACKAGE = Path(__file__).parents[1]
_SNAPSHOT_SHARE = 0.2
_ARRAY = "array"
_START_ANEW = "The run starts at cycle 0"


class Checkpoint:
    """The checkpoint of a run: an observer that keeps the run record on disk.

    Used as a context manager: an interrupted run leaves a checkpoint of the last accepted step. The
    caller discards the checkpoint of a finished run once its result is stored. An existing file is
    read at once; a message says why it was not used, or where the run resumes. It is written after
    `SECONDS_BETWEEN`, or a single longer step, and sooner at snapshots.
    """

    def __init__(
        self,
        path: Path,
        case: Case,
        tell: Callable[[str], None],
        clock: Callable[[], float] = time.monotonic,
    ) -> None:
        self.path, self._case, self._tell = path, case, tell
        self._clock, self._saved = clock, clock()
        self.record = RunRecord()
        try:
            self.record = read_checkpoint(path, identity_of(case)) or self.record
        except DataFileError as error:
            tell(str(error))
        self._note_saved()
        if self.record.history:
            tell(f"{path}: resuming after cycle {self._saved_cycle}")

    def __enter__(self) -> Self:
        return self

    def __exit__(self, kind: object, error: object, traceback: object) -> None:
        if error is not None and self._reached > self._saved_at:
            try:
                self.save()
            except DataFileError as failure:
                # The interruption is what matters; a full disk must not hide it.
                if str(failure) != str(error):
                    self._tell(str(failure))
        if error is not None and self._saved_cycle and self.path.exists():
            resumes = f"the same command resumes after cycle {self._saved_cycle}"
            self._tell(f"{self.path}: kept; {resumes}")

    def __call__(self, step: Step) -> None:
        """Observe a step; save it when it is time."""
        is_snapshot = step.state.cycle in self._case.output_cycles
        pause = (_SNAPSHOT_SHARE if is_snapshot else 1.0) * SECONDS_BETWEEN
        if self._clock() - self._saved >= pause:
            self.save()

    def save(self) -> None:
        """Write the run record to the file; see `write_checkpoint`."""
        write_checkpoint(self.path, self.record, identity_of(self._case))
        self._saved = self._clock()
        self._note_saved()

    def discard(self) -> None:
        """Remove the file: the result is stored."""
        self._note_saved()
        try:
            self.path.unlink(missing_ok=True)
            remove_stale_temporaries(self.path.parent, self.path.name)
        except OSError as error:
            # No later run uses a left-over file without a check.
            self._tell(f"{self.path}: not removed: {error.strerror}")

    @property
    def _reached(self) -> tuple[int, int]:
        """Finished runs on wider cells, and steps of the present one."""
        return len(self.record.rounds), len(self.record.history)

    def _note_saved(self) -> None:
        history = self.record.history
        self._saved_at = self._reached
        self._saved_cycle = f"{history[-1]['cycle']:.6g}" if history else ""


def identity_of(case: Case) -> dict[str, object]:
    """The identity of a run, which must equal the one in a checkpoint to resume from it."""
    return {
        "code": code_digest(),
        "parameters": case.canonical_parameters(),
        "output cycles": list(case.output_cycles),
    }


def write_checkpoint(path: Path, record: RunRecord, identity: Mapping[str, object]) -> None:
    """Write a run record; the file appears complete, or not at all with a `DataFileError`.

    An array that occurs several times is stored once.
    """
    arrays: list[NDArray[np.float64]] = []

    def packed(value: Any) -> dict[str, object]:
        if not isinstance(value, np.ndarray):
            return {field.name: getattr(value, field.name) for field in fields(value)}
        place = next((n for n, array in enumerate(arrays) if array is value), len(arrays))
        arrays[place : place + 1] = [value]
        return {_ARRAY: place}

    content = json.dumps({"identity": identity, "record": record}, default=packed)
    shapes = json.dumps([array.shape for array in arrays])
    with atomic_path(path) as temporary:
        with temporary.open("wb") as stream:
            stream.write(f"{content}\n{shapes}\n".encode())
            for array in arrays:
                stream.write(np.ascontiguousarray(array).data)
        add_checksum(temporary)


def read_checkpoint(path: Path, identity: Mapping[str, object]) -> RunRecord | None:
    """Read a file written by `write_checkpoint`; None if there is none.

    `DataFileError` if it is damaged or belongs to another run.
    """
    if not path.exists():
        return None
    if problem := damage(path, "checkpoint"):
        raise DataFileError(path, f"this checkpoint is damaged ({problem})", _START_ANEW)
    expected, arrays = json.loads(json.dumps(identity)), []
    try:
        with path.open("rb") as stream:
            content, shapes = json.loads(stream.readline()), json.loads(stream.readline())
            for shape in shapes:
                if not 0 <= math.prod(shape) <= path.stat().st_size:
                    raise ValueError("the file is smaller than it announces")
                arrays.append(np.fromfile(stream, count=math.prod(shape)).reshape(shape))
        if (written := dict(content["identity"])) == expected:
            restored: RunRecord = unpack(RunRecord, content["record"], arrays)
            _check(restored)
            return restored
    except (LookupError, TypeError, ValueError, RecursionError, OSError) as cause:
        problem = "this is not a checkpoint, or one of another version"
        raise DataFileError(path, problem, _START_ANEW) from cause
    keys = sorted(key for key in {*written, *expected} if written.get(key) != expected.get(key))
    problem = f"this checkpoint is of another run (another {', '.join(keys)})"
    raise DataFileError(path, problem, _START_ANEW)


def _check(record: RunRecord) -> None:
    """Raise a ValueError for a run record that no run could have left."""
    states = [*record.snapshots, *([] if record.last is None else [record.last])]
    if bool(record.history) != bool(states):
        raise ValueError("states and history do not match")
    scalars = {scalar.name: scalar for scalar in SCALARS}
    if not all(
        scalars[name].allows(number) if name in scalars else math.isfinite(number)
        for row in record.history
        for name, number in row.items()
    ):
        raise ValueError("the history has a value that is not finite")
    for state in states:
        reduced = state.reduced
        of_cells = [state.pressure, state.gap, state.wear, state.plastic, reduced.pressure]
        of_cells += [reduced.gap, state.pressure_rate, state.source_rate]
        if (sheared := reduced.sheared) is not None:
            of_cells += [*sheared.traction, *sheared.slip, sheared.bound]
        if {field.shape for field in of_cells} != {tuple(state.geometry.shape)}:
            raise ValueError("the shape of a field does not match its geometry")
        if not state.is_finite:
            raise ValueError("a field is not finite")


def unpack(kind: Any, packed: Any, arrays: Sequence[NDArray[np.float64]]) -> Any:
    """Restore a value of an annotated type from JSON and the arrays beside it.

    If the type is a union of dataclasses or an abstract class, the dataclass with the packed fields
    is chosen from its members or subclasses. A LookupError, TypeError or ValueError says that
    something else was packed.
    """
    parts = tuple(part for part in get_args(kind) if part is not ...)
    if isinstance(packed, list):
        kinds = parts if len(parts) == len(packed) else parts[:1] * len(packed)
        items = (unpack(*pair, arrays) for pair in zip(kinds, packed, strict=True))
        return list(items) if get_origin(kind) is list else tuple(items)
    if get_origin(kind) is dict:
        return {str(name): unpack(parts[1], value, ()) for name, value in packed.items()}
    if not isinstance(packed, dict):
        allowed = {kind, *parts} | ({int} if float in (kind, *parts) else set())
        if type(packed) not in allowed:
            raise TypeError(f"{packed!r} is no {kind}")
        return packed
    if packed.keys() == {_ARRAY}:
        return arrays[packed[_ARRAY]]
    for concrete in (one for stated in (kind, *parts) for one in _concrete(stated)):
        if is_dataclass(concrete) and {field.name for field in fields(concrete)} == packed.keys():
            types = get_type_hints(concrete)
            values = {name: unpack(types[name], packed[name], arrays) for name in packed}
            return cast("type[object]", concrete)(**values)
    raise TypeError(f"{kind} has no fields {', '.join(packed)}")


def _concrete(kind: Any) -> Iterator[object]:
    """Yield a type or, if it is an abstract class, all that derive from it and are not."""
    kinds = [kind]
    for one in kinds:
        if not isabstract(one):
            yield one
        if isabstract(kind):
            kinds += one.__subclasses__()


def reason_of(error: Exception) -> tuple[str, bool]:
    """Say why something failed, and whether that should never happen.

    If it should never happen, the words say whether a library failed or fretwear itself, and whom
    to tell.
    """
    words = str(error) or type(error).__name__
    if isinstance(error, DataFileError) or (isinstance(error, MemoryError) and str(error)):
        return words, False
    if is_of_memory(error):
        return f"there is not enough memory ({words})", False
    if isinstance(error, BrokenExecutor):
        return "a process beside this one was killed or crashed: out of memory?", False
    if is_of_netcdf(error):
        return f"a file cannot be read or written, as if memory had run out ({words})", False
    if isinstance(error, ContactError | WearError | OSError):
        return words, False
    cause = f"{type(error).__name__}: {error}".rstrip(": ")
    frames = [frame for frame, _ in traceback.walk_tb(error.__traceback__)]
    if not frames or Path(frames[-1].f_code.co_filename).is_relative_to(_PACKAGE):
        return f"this is a defect of fretwear, please report it: {cause}", True
    advice = "If memory or the disk was short, run the same command again; otherwise"
    return f"a library failed ({cause}). {advice} please report this", True


class Outcome(NamedTuple):
    """The outcome of a job."""

    steps: int  # accepted steps of the whole run, those before an interruption included
    seconds: float  # time that this job took
    # Whether another process wrote the file while this one waited for it.
    is_taken_over: bool = False


def simulate_to_file(
    case: Case,
    path: Path,
    *,
    observers: Sequence[Observer] = (),
    tell: Callable[[str], None],
    command: str,
) -> Outcome:
    """Simulate a case and write its file; resume from the checkpoint beside it if any.

    Two jobs never compute the same file at once: the later one waits, and keeps the file if it then
    holds the same case, with the same snapshots, from the same version.

    `tell` takes messages: where the run resumes, why a checkpoint was not used, for which process
    the job waits. The command is a call that gives the same results. A ContactError or a
    WearError leaves the checkpoint; it is a DataFileError if the file cannot be written or another
    process has come to compute it, a MemoryError if there is no room for it.
    """
    started = time.monotonic()
    require_memory(case)

    def warn(doubt: str) -> None:
        tell(f"warning: {doubt}")

    with Lock(path, tell) as lock:
        if lock.waited and finished_by(path, case) == code_digest():
            with open_history(path) as earlier:
                steps = earlier.sizes["step"] - 1
            return Outcome(steps, time.monotonic() - started, is_taken_over=True)
        with Checkpoint(checkpoint_of(path), case, tell) as checkpoint:
            seen: list[Observer] = [checkpoint, *observers]
            kept = checkpoint.record
            result = run(case, seen, record=kept, command=command, warn=warn)
            lock.ensure()
            with uninterrupted():
                dataset, history, loops = result
                write_case(dataset, history, path, loops)
                checkpoint.discard()
    return Outcome(len(kept.history) - 1, time.monotonic() - started)


def checkpoint_of(path: Path) -> Path:
    """Return the checkpoint that belongs to a case file."""
    return path.with_suffix(".checkpoint")


class BatchLog(Protocol):
    """What a batch reports to, such as `fretwear.cli.progress.Log`."""

    def note(self, message: str) -> None:
        """Report something worth knowing."""

    def batch(self, cases: Mapping[str, Case]) -> None:
        """Count the cases that will run."""

    def case(self, case: Case, file: Path) -> AbstractContextManager[Observer]:
        """Report the case that runs in a context, and its steps by an observer."""


class BatchOutcome(NamedTuple):
    """The outcome of a batch."""

    case_ids: list[str]  # of all cases
    found: list[str]  # of cases finished before
    failed: dict[str, str]  # why cases failed, by id


def run_batch(
    study: Study,
    results: Path,
    points: tuple[int, int],
    log: BatchLog,
    log_to: Callable[[Unfailing], BatchLog],
    *,
    keep_older: bool = False,
) -> BatchOutcome:
    """Run the cases of neighbouring points, from a first to a last number, except finished ones.

    Those finished by other code are run again unless they are to be kept. A case that fails does
    not stop the others; the reason is recorded beside its log. Messages on the whole go to `log`,
    a `fretwear.cli.progress.Log`; `log_to` makes one that writes to the open log of a case.
    """
    cases = {point.id: point.case for point in study.points(*points) if point.case}
    files = {case_id: results / "cases" / f"{case_id}.nc" for case_id in cases}
    digests = {key: finished_by(files[key], case) for key, case in cases.items()}
    older = [key for key, digest in digests.items() if digest not in (None, code_digest())]
    left = older if not keep_older else []
    finished = [key for key in cases if digests[key] is not None and key not in left]
    for case_id in finished:
        forget(results, case_id)
        # Left by a disk that failed after the file had got its name.
        with suppress(OSError):
            checkpoint_of(files[case_id]).unlink(missing_ok=True)
        Lock(files[case_id]).remove_if_abandoned()
    if finished:
        log.note(f"{len(finished)} of {len(cases)} cases were done before")
    if older:
        what = "kept" if keep_older else "computed again"
        log.note(f"{len(older)} of them by another version of the code: {what}")
    # A case during which an earlier process vanished may end this one too, so it comes last.
    vanished, failed = failures(results), dict[str, str]()
    to_do = {case_id: case for case_id, case in cases.items() if case_id not in finished}
    log.batch(to_do)
    for case_id in sorted(to_do, key=lambda case_id: case_id in vanished):
        # Recorded at the start, because a process that is killed cannot do so.
        record(results, case_id)
        command = shlex.join(["fretwear", "run", str(study.file), "--case", case_id])
        with open_log(log_file(results, case_id)) as stream:
            case_log, case, file = log_to(stream), to_do[case_id], files[case_id]
            try:
                with log.case(case, file) as seen, case_log.case(case, file) as seen_by_log:
                    simulate_to_file(
                        case,
                        file,
                        observers=[seen, seen_by_log],
                        tell=case_log.note,
                        command=command,
                    )
            except Exception as error:
                failed[case_id], is_defect = reason_of(error)
                if is_defect:
                    traceback.print_exc(file=stream)
                print(f"fretwear: error: {failed[case_id]}", file=stream)
            finally:
                # Being stopped is not a failure either: the next run resumes from the checkpoint.
                forget(results, case_id)
        if reason := failed.get(case_id):
            record(results, case_id, reason)
            log.note(f"{case_id} failed: {reason} (log: {log_file(results, case_id)})")
    return BatchOutcome([*cases], finished, failed)
