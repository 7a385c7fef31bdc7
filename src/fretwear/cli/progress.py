"""Output of a command while it works: a bar on a terminal, lines of text, or JSON lines.

A message is a text for people and fields for programs. Every JSON line has ``event`` and ``time``
(UTC, ISO 8601). Lengths are in m and times in s; numbers that are not finite are null. Fields may
be added later; existing ones keep their meaning.
"""

from __future__ import annotations

import json
import math
import os
import sys
import time
import traceback
import warnings
from collections import deque
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager, nullcontext, suppress
from datetime import UTC, datetime
from pathlib import Path
from typing import TYPE_CHECKING, TextIO, cast

import typer

import fretwear
from fretwear.cli.common import CommandError, finite, say
from fretwear.data.safe import Unfailing
from fretwear.study.problems import printable
from fretwear.units import LENGTH, duration_text, number_text, readable_unit, with_unit

if TYPE_CHECKING:
    from rich.console import Console

    from fretwear.run.simulate import Observer, Step
    from fretwear.study.case import Case

_END_STATUS = {0: "done", 1: "failed", 2: "wrong_input"}
_MEASURES = ["contact_half_width_x", "contact_half_width_y", "stick_half_width_x"]
_MEASURES += ["peak_pressure", "wear_volume"]
# Time between two lines, s: a run of a minute prints about thirty lines, a run of a day a thousand.
_SHORTEST_INTERVAL = 2.0
_LONGEST_INTERVAL = 60.0
_INTERVAL_SHARE = 0.02

_RECENT_STEPS = 6
# The plan's estimate still weighs a half when a tenth of the cycles is done.
_TRUST_IN_STEPS = 0.3
_SMALLEST_SHARE = 0.1


class Log:
    """All output of a command: errors and progress to standard error, results to standard output.

    Messages are text or, in the format ``json``, JSON; the format ``auto`` adds a bar on a
    terminal. A quiet log reports errors only. Text may go to another stream, without colours.
    """

    def __init__(
        self,
        log_format: str = "lines",
        *,
        quiet: bool = False,
        stream: TextIO | Unfailing | None = None,
        clock: Callable[[], float] = time.monotonic,
    ) -> None:
        self._is_json, self._is_quiet, self._clock = log_format == "json", quiet, clock
        self._output = Unfailing(stream or sys.stderr)
        # FORCE_COLOR may ask for colours in a log file, which is still not a terminal.
        redraws = os.environ.get("TERM", "").lower() not in ("dumb", "unknown")
        may_have_bar = log_format == "auto" and not quiet and stream is None
        self._has_bar = may_have_bar and redraws and self._output.isatty()
        self._batch: TimeLeft | None = None
        self._command, self._started, self.typed = "", 0.0, ""
        self._file: str | None = None
        self._console: Console | None = None
        if not self._is_json:
            from rich.console import Console

            self._console = Console(
                color_system=None if stream else "auto",
                file=cast("TextIO", self._output),
                stderr=stream is None,
                highlight=False,
            )

    def begin(self, command: str, typed: str = "") -> None:
        """Report the start of a command; in JSON, warnings become events from here on."""
        self._command, self._started, self.typed = command, self._clock(), typed
        if self._is_json:

            def warn(
                message: Warning | str,
                category: type[Warning],
                filename: str,
                lineno: int,
                *_: object,
                **__: object,
            ) -> None:
                about = {"message": str(message), "category": category.__name__}
                self._say("warning", **about, where=f"{filename}:{lineno}")

            warnings.showwarning = warn
        self._say("start", command=command, version=fretwear.__version__)

    def end(self, exit_status: int) -> None:
        """Report the end of the command to programs."""
        if self._command:
            which = {"command": self._command, "status": _END_STATUS.get(exit_status, "stopped")}
            seconds = self._clock() - self._started
            self._say("end", **which, exit_status=exit_status, seconds=seconds, file=self._file)

    def error(
        self, message: str, exit_status: int, event: str = "error", defect: Exception | None = None
    ) -> None:
        """Report what ends the command: an error with a remedy, or the event ``stopped``.

        A defect is reported with its traceback.
        """
        trace = "" if defect is None else "".join(traceback.format_exception(defect)).rstrip()
        if self._is_json:
            details = {"traceback": trace} if trace else {}
            self._write(event, {"message": message, "exit_status": exit_status, **details})
        else:
            self._print(f"{message}\n{trace}".rstrip(), f"fretwear: {event}: ")

    def note(self, message: str) -> None:
        """Report something worth knowing that is neither an error nor a result."""
        self._say("note", message, message=message)

    def result(self, file: Path, message: str, **numbers: float) -> None:
        """Report the file or folder written, with a message for people and numbers for programs."""
        self._file = str(file)
        self._say("result", file=self._file, message=message, **numbers)
        if not self._is_json and not self._is_quiet:
            with suppress(CommandError, typer.Exit):  # The file exists all the same.
                say(f"{file}: {message}")

    def batch(self, cases: Mapping[str, Case]) -> None:
        """Count the cases that will run one after the other, each in the context of `case`."""
        self._batch = _time_left(cases, self._clock)

    @contextmanager
    def case(self, case: Case, file: Path) -> Iterator[Observer]:
        """Report the case that runs in this context; the observer is called at every step."""
        timing = self._batch or _time_left({case.case_id: case}, self._clock)
        timing.begin(case.case_id, case.cycles)
        which: dict[str, object] = {"case_id": case.case_id}
        which |= {"case_number": timing.number, "case_count": timing.count}
        name = f"case {timing.number} of {timing.count}" if timing.count > 1 else ""
        begun = f"{name}: {case.case_id}" if name else f"case {case.case_id}"
        self._say("case_start", begun, **which, cycles=case.cycles, file=str(file))
        last: Step | None = None
        reported = -math.inf

        def observe(step: Step) -> None:
            nonlocal last, reported
            timing.note(step.state.cycle)
            last, now = step, timing.seconds
            if show:
                show(step)
            interval = min(_LONGEST_INTERVAL, max(_SHORTEST_INTERVAL, _INTERVAL_SHARE * now))
            if step.state.cycle < step.last_cycle and now - reported < interval:
                return
            reported = now
            numbers = {"cycle": step.state.cycle, "cycles": step.last_cycle}
            numbers |= {"step": step.state.step, "error_estimate": step.state.error_estimate}
            numbers |= {name: vars(step.measures)[name] for name in _MEASURES}
            left = {
                "seconds_left": timing.seconds_left,
                "batch_seconds_left": timing.batch_seconds_left,
            }
            # A bar shows every step; lines would only repeat it.
            line = "" if show else step_text(step, timing.seconds_left)
            self._say("step", line, **which, **numbers, seconds=now, **left)

        status, text = "done", ""
        try:
            with self._bar(timing) if self._has_bar else nullcontext() as show:
                yield observe
            timing.end()
            if name:
                left = left_text(timing.batch_seconds_left)
                text = f"{name} done in {duration_text(timing.seconds)}, {left}"
        except BaseException as error:
            status = "failed" if isinstance(error, Exception) else "stopped"
            text = step_text(last, timing.seconds_left) if last else ""
            raise
        finally:
            place = {"cycle": last.state.cycle, "step": last.state.step} if last else {}
            ended = {"status": status, **place, "seconds": timing.seconds, "file": str(file)}
            self._say("case_end", text, **which, **ended)

    @contextmanager
    def counting(self, thing: str) -> Iterator[Callable[[int, int], None]]:
        """Yield a function that shows on a terminal how many things, out of a total, are done."""
        from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn

        columns = (TextColumn(thing), MofNCompleteColumn(), BarColumn(bar_width=24))
        hidden = not self._has_bar
        with Progress(*columns, console=self._console, transient=True, disable=hidden) as bar:
            task = bar.add_task("", total=None)
            yield lambda done, total: bar.update(task, completed=done, total=total)

    @contextmanager
    def _bar(self, timing: TimeLeft) -> Iterator[Observer]:
        """Show the progress of a case and its batch on a terminal, until the context ends."""
        from rich.console import Group
        from rich.live import Live
        from rich.progress import BarColumn, Progress, ProgressColumn, Task, TextColumn
        from rich.table import Column
        from rich.text import Text

        class Left(ProgressColumn):
            def render(self, task: Task) -> Text:
                is_batch = task.id != one
                seconds = timing.batch_seconds_left if is_batch else timing.seconds_left
                return Text(left_text(seconds), no_wrap=True)

        bar = BarColumn(None, table_column=Column(ratio=1))
        bars = Progress(TextColumn("{task.description}"), bar, Left(), expand=True)
        one = bars.add_task("first loading", total=1.0)
        if timing.count > 1:
            done = timing.number - 1
            bars.add_task(f"all {timing.count} cases", completed=done, total=timing.count)
        numbers = Text(no_wrap=True, overflow="ellipsis")

        def show(step: Step) -> None:
            # A constant width keeps its neighbours from jumping.
            cycle = f"{step.state.cycle:{len(str(step.last_cycle))}.0f}"
            place = f"cycle {cycle} of {step.last_cycle}"
            bars.update(one, description=place, completed=timing.share)
            numbers.plain = _numbers_text(step)

        shown = Group(bars, numbers)
        with Live(shown, console=self._console, transient=True, redirect_stdout=False):
            yield show

    def _say(self, event: str, text: str = "", /, **fields: object) -> None:
        """Write a message, as text for people or fields for programs, unless the log is quiet."""
        if self._is_quiet:
            return
        if self._is_json:
            self._write(event, fields)
        elif text:
            self._print(text)

    def _write(self, event: str, fields: Mapping[str, object]) -> None:
        now = datetime.now(UTC).isoformat(timespec="milliseconds").replace("+00:00", "Z")
        line = json.dumps(finite({"event": event, "time": now, **fields}), allow_nan=False)
        self._output.write(f"{line}\n")
        self._output.flush()

    def _print(self, text: str, label: str = "") -> None:
        """Print above the bar, if there is one, without markup or line breaks."""
        from rich.text import Text

        message = Text.assemble((label, "bold red"), printable(text))
        assert self._console is not None
        self._console.print(message, soft_wrap=True)


class TimeLeft:
    """The time left for a case, and for all cases of its batch.

    It follows from the plan, which is the estimated time of each case, s, by its id, and from the
    last steps. Steps grow by orders of magnitude over a run, take about equal times, and stop
    growing once the bodies yield. Extrapolating the last steps in cycles per second therefore
    overestimates the time, and extrapolating in the logarithm of cycles underestimates it. The
    geometric mean of both is combined with the plan, whose weight falls as cycles are done.
    """

    def __init__(self, planned: Mapping[str, float], clock: Callable[[], float]) -> None:
        self._clock, self._ahead, self._slowness = clock, dict(planned), 1.0
        self._planned_before = self._taken_before = 0.0
        self.number, self.count = 0, len(planned)  # of cases begun, of all cases

    def begin(self, case_id: str, cycles: int) -> None:
        """Start a case; the time taken by earlier cases corrects its planned time."""
        self.number += 1
        self._planned, self._cycles = self._ahead.pop(case_id), cycles
        self._expected = self._left = max(self._slowness * self._planned, 1e-3)
        self._recent: deque[tuple[float, float]] = deque(maxlen=_RECENT_STEPS)
        self._started = self._noted = self._clock()
        self.share = 0.0  # share of the time of the case that has passed, 0 to 1; never falls

    def note(self, cycle: float) -> None:
        """Record a step that has reached a cycle."""
        self._noted, to_do = self._clock(), self._cycles - cycle
        taken = self._noted - self._started
        if self._recent and cycle <= self._recent[-1][1]:
            self._recent.clear()  # another run of the case begins, on narrower cells
        if not self._recent:  # a run that resumes from a checkpoint has less to do than planned
            self._expected *= to_do / self._cycles
        self._recent.append((self._noted, cycle))
        (then, first), longer = self._recent[0], max(self._expected, taken)
        self._left = max(self._expected - taken, _SMALLEST_SHARE * longer) if to_do > 0.0 else 0.0
        if self._left and self._noted > then:
            linear = to_do / (cycle - first)
            logarithmic = math.log((1.0 + self._cycles) / (1.0 + cycle))
            logarithmic /= math.log((1.0 + cycle) / (1.0 + first))
            by_steps = (self._noted - then) * math.sqrt(linear * logarithmic)
            self._left *= (by_steps / self._left) ** (cycle / self._cycles) ** _TRUST_IN_STEPS
        if taken or not self._left:
            self.share = max(self.share, taken / (taken + self._left) if self._left else 1.0)

    def end(self) -> None:
        """Record the time that a finished case has taken."""
        self._left = 0.0
        self._planned_before += self._planned
        self._taken_before += self.seconds
        if self._planned_before:
            self._slowness = self._taken_before / self._planned_before

    @property
    def seconds(self) -> float:
        """Time since the case began, s."""
        return self._clock() - self._started

    @property
    def seconds_left(self) -> float:
        """Time until the case ends, s: as predicted at the last step, minus the time since."""
        return max(0.0, self._left - (self._clock() - self._noted))

    @property
    def batch_seconds_left(self) -> float:
        """Time until the last case ends, s."""
        return self.seconds_left + self._slowness * sum(self._ahead.values())


def step_text(step: Step, seconds_left: float) -> str:
    """Return the progress of a run: cycle, step, error, contact half-width, time left."""
    cycle = f"cycle {step.state.cycle:.6g} of {step.last_cycle}"
    return f"{cycle}, {_numbers_text(step)}, {left_text(seconds_left)}"


def left_text(seconds: float) -> str:
    """Return the time left in words, rounded up."""
    return f"{duration_text(math.ceil(seconds))} left"


def _numbers_text(step: Step) -> str:
    half_width = step.measures.contact_half_width_x
    unit = readable_unit(half_width, LENGTH.si_unit)
    percent = 100.0 * step.state.error_estimate
    error = "below 0.001 %" if percent < 0.001 else f"{number_text(percent, 2)} %"
    width = with_unit(number_text(unit.of(half_width), 4), unit)
    return f"step {step.state.step}, step error {error}, half-width {width}"


def _time_left(cases: Mapping[str, Case], clock: Callable[[], float]) -> TimeLeft:
    from fretwear.study.plan import SECONDS_TO_START, estimate

    # The time to start Python has passed already.
    planned = {name: estimate(case).seconds - SECONDS_TO_START for name, case in cases.items()}
    return TimeLeft(planned, clock)
