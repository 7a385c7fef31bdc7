"""Recordings of loops: their cycles, with friction, displacement and energy of each."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from fretwear.arrays import Array, Places
from fretwear.units import BY_SI_UNIT, Dimension, QuantityError, listed, parse_quantity
from fretwear_fit.readings import LARGEST_FORCE, check_sizes
from fretwear_measured.tables import PLAIN, SECONDS, TABLES, TIME, Layout, Sought, Table, open_table
from fretwear_measured.times import usual_step

if TYPE_CHECKING:
    import pandas as pd

_MOST_POINTS = 12  # of a table over cycles
_DISORDER = 0.1  # of the displacement of a loop, by which noise may go back
_KIND = (
    "mean average amplitude min max minimum maximum rms velocity speed setpoint set target command "
    "z normal vertical preload clamp fn fz normalkraft"
)
_DISPLACEMENT = Sought(
    BY_SI_UNIT["m"],
    ("displacement disp position stroke x weg hub verschiebung", "y lvdt piezo travel delta"),
    _KIND,
)
_FRICTION = (
    ("friction tangential q fx lateral reibkraft reibungskraft", "force kraft", "load f ff ft fy"),
    f"{_KIND} coefficient cof mu µ μ energy work",
)
_CYCLE = Sought(
    Dimension("cycles", "1", "", "1"), ("cycle cycles zyklus zyklen n",), "time period total target"
)
# Reversals of a displacement are looked for from the finest to the coarsest, parts of its range.
_REVERSALS = 0.005 * 1.2 ** np.arange(29)
_SAME = 0.9  # numbers of cycles that count as equal
_FEWEST = 8  # readings of a cycle
_NEAR_TURN = 0.05  # of a stroke
_STEP = 2.0  # largest step of a sine over the mean one, with noise
_NAMES_OF_FILES = "name the files by their cycles, such as loop_0.csv loop_1000.csv"
_OPEN = 0.1  # between the first and the last force of a loop, over its amplitude
_STUCK = 0.01  # half the width of a loop over its amplitude of displacement


@dataclass(frozen=True)
class Recording:
    """Displacement and force over time."""

    displacement: Array  #: m, shape (n,)
    force: Array  #: N or N/m
    origin: str  #: the columns that were chosen
    missing: int  #: readings without numbers
    time: Array | None  #: s
    counter: Array | None  #: numbers of the cycles


def recording_of(path: Path, layout: Layout, force_unit: str) -> Recording:
    """Read a recording of loops; `QuantityError` says why a file cannot be used."""
    if path.suffix.lower() not in TABLES:
        rule = f"must be a table, with the ending {listed(TABLES, 'or')}"
        raise QuantityError(rule, "unpack an archive, and save a spreadsheet as .csv")
    recorded, force_is = open_table(path, layout), BY_SI_UNIT[force_unit]
    example = f"such as displacement (um),force ({force_is.example.split()[-1]})"
    sought = [_DISPLACEMENT, Sought(force_is, *_FRICTION)]
    table = recorded.aligned(recorded.choose(sought, example))
    numbers, (x, force) = table.read(sought, example)
    there = np.isfinite(x) & np.isfinite(force)
    check_sizes(x[there], force[there], LARGEST_FORCE)
    if np.ptp(force[there]) == 0.0:
        rule = f"has the same force everywhere in {table.label(numbers[1])}"
        raise QuantityError(rule, "choose its columns of displacement and force: columns: [0, 1]")
    origin = "displacement from {}, force from {}".format(*map(table.label, numbers))
    time = None if (time := table.time_of(numbers[0])) is None else time[there]
    if table.note and time is not None:
        _check_rate(recorded, numbers[0], usual_step(time))
    beside: list[Array | None] = [time if table.note else None, None]
    for place, (wanted, values_of) in enumerate(((TIME, _seconds), (_CYCLE, _counts))):
        for number, (misfits, _) in table.ranked(wanted).items():
            values = None if misfits or number in numbers else values_of(table, number)
            if beside[place] is None and values is not None:
                beside[place] = values[there]
                origin += f", {wanted.dimension.name} from {table.label(number)}"
    if beside[0] is None:
        beside[0] = time
    origin += f"; {table.note}" if table.note else ""
    return Recording(x[there], force[there], origin, int((~there).sum()), *beside)


def _check_rate(recorded: Table, number: int, step: float) -> None:
    """Refuse steps of time, s, that are too long for the cycles of a recorded displacement."""
    x, own = recorded.numbers(number), recorded.time_of(number)
    assert own is not None
    there = np.isfinite(x) & np.isfinite(own)
    ends = np.interp(cycles_of(x[there]), np.arange(there.sum()), own[there])
    count = np.median(np.diff(ends)) / step if ends.size else np.inf
    if count < _FEWEST:
        rule = f"has {count:.2g} readings of both its columns in a cycle"
        raise QuantityError(rule, f"record the slower channel with at least {_FEWEST} in a cycle")


def _seconds(table: Table, number: int) -> Array | None:
    """Time of a column of numbers or of a clock, s."""
    import pandas as pd  # takes half a second

    if (clock := table.words.get(number)) is not None:
        times = pd.to_datetime(clock, errors="coerce", dayfirst="." in clock.iloc[0][:6])
        seconds = (times - times.iloc[0]).dt.total_seconds()
        values = seconds.reindex(range(len(table.values))).to_numpy()
        return values if np.isfinite(values).mean() > _SAME else None
    unit = table.units[number] or "s"
    return table.values[:, number] * parse_quantity(f"1 {unit}", SECONDS, units_required=True)


def _counts(table: Table, number: int) -> Array | None:
    """Numbers of cycles, if a column counts them."""
    values = table.values[:, number]
    return values if (np.diff(values) >= 0.0).all() else None


def _extrema(x: Array) -> tuple[Places, Array]:
    """Places of local extrema and both ends, and the falls or rises up to which each remains one.

    A fall or rise within two larger ones ends with both its extrema, as in rainflow counting.
    """
    moves = np.flatnonzero(np.diff(x))
    steps = np.sign(np.diff(x)[moves])
    places = np.unique(np.r_[0, moves[1:][steps[1:] != steps[:-1]], x.size - 1])
    ranges, left, values = np.empty(places.size), [], x[places].tolist()
    for place in range(places.size):
        left.append(place)
        while len(left) > 3:
            rise, fall, next_rise = (abs(values[m] - values[n]) for m, n in pairwise(left[-4:]))
            if fall > min(rise, next_rise):
                break
            ranges[left[-3:-1]] = fall
            del left[-3:-1]
    falls = np.abs(np.diff(x[places[left]]))
    ranges[left] = np.maximum(np.append(0.0, falls), np.append(falls, 0.0))
    return places, ranges


def _turns(x: Array, reach: float) -> Places:
    """Places of least and largest values in turn, each a reach or more from the next."""
    places, ranges = _extrema(x)
    return places[ranges >= reach]


def _reversal(x: Array) -> float:
    """The least fall or rise that begins another half of a cycle.

    Cycles remain the same in number while this grows from noise to their own size, whatever their
    means and amplitudes: it lies in the longest range of its logarithm where they do.
    """
    ranges = np.sort(_extrema(x)[1])
    turns = ranges.size - np.searchsorted(ranges, _REVERSALS * np.ptp(x))
    counts = np.maximum(turns - 2, 0) // 2
    same = [int((counts[n:] >= _SAME * count).sum()) for n, count in enumerate(counts)]
    scores = same * counts / (counts + 2.0)
    first = scores.size - 1 - int(scores[::-1].argmax())
    # Nearer to the lower end, since small cycles among large ones end the range early.
    middle = first + (same[first] - 1) // 3
    return float(np.ptp(x) * _REVERSALS[middle]) if scores[first] else np.inf


def _whole_cycles(x: Array, turns: Places) -> Array:
    """Where whole cycles between some turns begin and end, in readings, shape (n, 2).

    The first stroke and the last one, which may not be whole, are as long as their neighbours.
    """
    ends = x[turns]
    sizes = np.abs(np.diff(ends))
    n = np.clip(np.searchsorted(turns, np.arange(x.size), "right") - 1, 0, turns.size - 2)
    share = np.clip((x - ends[n]) / (ends[n + 1] - ends[n]), 0.0, 1.0)
    first, last = n == 0, n == turns.size - 2
    share[first] = 1.0 - (1.0 - share[first]) * min(sizes[0] / sizes[1], 1.0)
    share[last] *= min(sizes[-1] / sizes[-2], 1.0)
    for end in (0, -1):  # noise at a turn
        if abs(share[end] - round(share[end])) < _NEAR_TURN:
            share[end] = round(share[end])
    # Where the displacement rests, the first reading counts.
    strokes = np.maximum.accumulate(n + share) + 1e-9 * np.arange(x.size)
    begin, stop = strokes[0], strokes[-1] + _STEP * (strokes[-1] - strokes[0]) / x.size
    middle = 0.5 if ends[1] > ends[0] else 1.5
    starts = middle + 2.0 * (middle < begin), begin
    passages = max((np.arange(start, stop, 2.0) for start in starts), key=len)
    places = np.interp(passages, strokes, np.arange(x.size))
    found = np.stack([places[:-1], places[1:]], axis=1)
    return found[np.diff(found)[:, 0] >= _FEWEST]


def cycles_of(x: Array, breaks: Sequence[int] = ()) -> Array:
    """Where whole cycles of a displacement begin and end, in readings, shape (n, 2).

    They go from one rise through its local mean to the next. If they are more, they go from one
    passage of the displacement with which it begins to the next. `breaks` are the readings with
    which further parts begin; no cycle reaches over these.
    """
    reach, cycles = _reversal(x), [np.empty((0, 2))]
    for start, stop in pairwise([0, *breaks, x.size]):
        if (turns := _turns(x[start:stop], reach)).size > 2:
            cycles.append(start + _whole_cycles(x[start:stop], turns))
    return np.concatenate(cycles)


def _slices(cycles: Array) -> list[slice]:
    """The readings of cycles; the one that ends a cycle begins the next one."""
    return [slice(first, last + 1) for first, last in np.ceil(cycles - 1e-6).astype(int)]


def _breaks(recording: Recording) -> list[int]:
    """The readings before which some were not recorded: time or the count of cycles jumps."""
    x, time = recording.displacement, recording.time
    jumps = np.zeros(x.size - 1, bool)
    if recording.counter is not None:
        jumps |= np.diff(np.floor(recording.counter)) > 1.0
    if (
        time is not None
        and (usual := np.median(steps := np.diff(time))) > 0.0
        and (steps.min() < 0.0 or steps.max() > 3.0 * usual)
    ):
        strokes = np.diff(time[_turns(x, _reversal(x))])
        longest = np.quantile(strokes[strokes > 0.0], 0.25) if (strokes > 0.0).any() else np.inf
        jumps |= (steps < 0.0) | (steps > max(longest, 3.0 * usual))
    return (np.flatnonzero(jumps) + 1).tolist()


def _numbers(recording: Recording, cycles: Array, breaks: Sequence[int]) -> Places:
    """The numbers of cycles, from 0: of a column that counts them, or by the time in between."""
    time, count = recording.time, np.arange(len(cycles))
    if recording.counter is not None:
        counted = recording.counter[cycles.mean(axis=1).astype(int)].astype(int)
        # Several cycles of one number follow each other.
        return np.maximum.accumulate(counted - count) + count
    if time is None or not breaks:
        return count
    starts, stops = np.interp(cycles.T, np.arange(time.size), time)
    period, numbers = np.median(stops - starts), [0]
    is_next = np.diff(np.searchsorted(breaks, cycles[:, 0], "right")) > 0
    for n in count[1:]:
        gap = max(round((starts[n] - starts[n - 1]) / period), 1) if is_next[n - 1] else 1
        numbers.append(numbers[-1] + gap)
        if starts[n] > starts[0] and gap > 1:  # the longer the time, the better the period
            period = (starts[n] - starts[0]) / numbers[-1]
    return np.array(numbers)


@dataclass(frozen=True)
class Loops:
    """A recording that is split into cycles."""

    recording: Recording
    cycles: list[slice]  #: their readings
    table: pd.DataFrame  #: a row for each cycle, see `split_recording`
    notes: tuple[str, ...]  #: the columns that were chosen, and what was left out


def split_recording(path: Path, load: float, layout: Layout = PLAIN) -> Loops:
    """The cycles of a recording under a normal load, N, or N/m of a line contact.

    Columns of the table are ``cycle`` from 0, ``displacement_amplitude`` (m), ``force_amplitude``
    (N or N/m), ``dissipated_energy`` E = ∮ Q dδ (J or J/m), and ``friction`` E/(4 P δ₀), with half
    the width δ₀ of the loop at Q = 0: the coefficient of a contact that slides as a whole, whatever
    the compliance of the rig; NaN where the loop has no width, or does not close because the
    contact was unloaded before or the motion has changed. A column of cycles, or jumps of the time,
    give the number of a cycle. What is not part of a whole cycle is left out.
    """
    import pandas as pd  # takes half a second

    recording = recording_of(path, layout, "N")
    breaks = _breaks(recording)
    places = cycles_of(recording.displacement, breaks)
    if not places.size:
        rule = "has no whole cycle of its displacement"
        raise QuantityError(rule, "check its columns, or record a cycle from its beginning on")
    x, force, cycles = recording.displacement, recording.force, _slices(places)
    table = pd.DataFrame([_loop(x[cycle], force[cycle]) for cycle in cycles])
    table.insert(0, "cycle", _numbers(recording, places, breaks))
    width = table.pop("width")
    slides = width > _STUCK * table["displacement_amplitude"]
    closes = table.pop("opening") < _OPEN * table["force_amplitude"]
    friction = table["dissipated_energy"] / (2.0 * load * width)
    table["friction"] = friction.where(slides & closes)
    if np.isinf(table["friction"]).any():
        raise QuantityError("has an infinite friction", "check the load and the columns")
    inside = np.concatenate([np.arange(cycle.start, cycle.stop) for cycle in cycles])
    outside, total = x.size - np.unique(inside).size, x.size + recording.missing
    notes = recording.origin.split("; ")
    if outside or recording.missing:
        lacking = f" and {recording.missing} without numbers" if recording.missing else ""
        notes.append(f"left out: {outside} readings outside whole cycles{lacking}, of {total}")
    if breaks and recording.counter is None:
        notes.append(f"{len(breaks)} jumps of the time, in which cycles are taken to have gone on")
    stuck, open_ones = (int(one.sum()) for one in (~slides, slides & ~closes))
    if stuck:
        notes.append(
            f"friction not known in {stuck} cycles, which stick: their loops have no width"
        )
    if open_ones:
        notes.append(f"friction not known in {open_ones} cycles, whose loops do not close")
    return Loops(recording, cycles, table, (*notes,))


def histories(
    paths: Sequence[Path], load: float, layout: Layout = PLAIN
) -> tuple[pd.DataFrame, list[str]]:
    """The cycles of one recording, or of files with a loop or more of the cycle in their names."""
    import pandas as pd  # takes half a second

    firsts, tables = _cycles_in_names(paths), []
    notes: dict[str, list[str]] = {}
    for path, first in zip(paths, firsts, strict=True):
        try:
            history = split_recording(path, load, layout)
        except QuantityError as error:
            raise QuantityError(f"{path}: {error.rule}", error.hint) from error
        if history.recording.counter is None:
            history.table["cycle"] += first
        tables.append(history.table)
        for text in history.notes:
            notes.setdefault(text, []).append(path.name)
    table = pd.concat(tables).sort_values("cycle")
    if (twice := table["cycle"].duplicated()).any():
        rule = f"two files have cycle {table['cycle'][twice].iloc[0]}"
        raise QuantityError(rule, _NAMES_OF_FILES)
    said = [t if len(n) == len(paths) else f"{', '.join(n[:3])}: {t}" for t, n in notes.items()]
    return table, said


def _cycles_in_names(paths: Sequence[Path]) -> Sequence[int]:
    """The last numbers in the names of files that all differ."""
    if len(paths) == 1:
        return [0]
    numbers = [[int(one) for one in re.findall(r"\d+", path.stem)] for path in paths]
    same_form = len({*map(len, numbers)}) == 1
    differing = [n for n in zip(*numbers, strict=False) if len({*n}) == len(paths) and same_form]
    if not differing:
        rule = "the files do not say their cycles: their names lack numbers that all differ"
        raise QuantityError(rule, _NAMES_OF_FILES)
    return differing[-1]


def _loop(x: Array, force: Array) -> dict[str, float]:
    """Amplitudes of displacement and force, energy, and width at the middle force of a loop."""
    opening = np.abs(np.subtract.outer(force[-2:], force[:2])).min()
    force = force - 0.5 * (force.max() + force.min())
    x_after, after = np.roll(x, -1), np.roll(force, -1)
    rows = np.flatnonzero(np.sign(force) != np.sign(after))
    share = force[rows] / (force[rows] - after[rows])
    crossings = x[rows] + share * (x_after[rows] - x[rows])
    return {
        "displacement_amplitude": 0.5 * np.ptp(x),
        "force_amplitude": 0.5 * np.ptp(force),
        "dissipated_energy": float(abs(0.5 * (force + after) @ (x_after - x))),
        "width": np.ptp(crossings) if rows.size else 0.0,
        "opening": opening,
    }


def last_loop(recording: Recording) -> tuple[Array, Array]:
    """The last whole loop of a recording, from its largest displacement on, as it dissipates."""
    x, force = recording.displacement, recording.force
    if len(cycles := _slices(cycles_of(x, _breaks(recording)))) > 1:
        x, force = x[cycles[-1]], force[cycles[-1]]
    if float(force @ (np.roll(x, -1) - np.roll(x, 1))) < 0.0:
        x, force = x[::-1], force[::-1]
    begin = int(x.argmax())
    x, force = np.roll(x, -begin), np.roll(force, -begin)
    down, up = np.split(x, [int(x.argmin()) + 1])
    back = (
        (down - np.minimum.accumulate(down)).max(),
        (np.maximum.accumulate(up) - up).max(initial=0),
    )
    if max(back) > _DISORDER * np.ptp(x):
        rule = "is not one loop: its displacement does not fall and rise once"
        raise QuantityError(rule, "give the readings of one cycle, one after the other")
    return x, force


def friction_text(table: pd.DataFrame) -> str:
    """The friction of `split_recording` as study files have it, at a few cycles."""
    table = table.dropna(subset="friction")
    last = len(table) - 1
    rows = {0, *np.geomspace(1, max(last, 1), _MOST_POINTS - 1).round().astype(int).tolist()}
    few = table.iloc[sorted(row for row in rows if row <= last)]
    values = ", ".join(f"{value:.3g}" for value in few["friction"])
    return f"friction: {{cycles: [{', '.join(map(str, few['cycle']))}], values: [{values}]}}"
