"""Recordings of loops: their cycles, with friction, displacement and energy of each."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path

import numpy as np
import pandas as pd

from fretwear.arrays import Array, Places
from fretwear.units import BY_SI_UNIT, Dimension, QuantityError, listed, parse_quantity
from fretwear_fit.readings import LARGEST_FORCE, check_sizes
from fretwear_measured.tables import PLAIN, TABLES, Layout, Sought, Table, open_table

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
_SECONDS = Dimension("a time", "s", "s", "1 s")
_TIME = Sought(_SECONDS, ("time timestamp zeit t clock",), "cycle cycles")
_CYCLE = Sought(BY_SI_UNIT["1"], ("cycle cycles zyklus zyklen n",), "time period total target")
# Reversals of a displacement are looked for from the finest to the coarsest, parts of its range.
_REVERSALS = 0.005 * 1.2 ** np.arange(29)
_SAME = 0.9  # numbers of cycles that count as equal
_FEWEST = 8  # readings of a cycle
_NEAR_END = 0.9  # of the amplitude
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
        raise QuantityError(f"must be a table, with the ending {listed(TABLES, 'or')}")
    table, force_is = open_table(path, layout), BY_SI_UNIT[force_unit]
    example = f"such as displacement (um),force ({force_is.example.split()[-1]})"
    numbers, (x, force) = table.read([_DISPLACEMENT, Sought(force_is, *_FRICTION)], example)
    there = np.isfinite(x) & np.isfinite(force)
    check_sizes(x[there], force[there], LARGEST_FORCE)
    if np.ptp(force[there]) == 0.0:
        rule = f"has the same force everywhere in {table.label(numbers[1])}"
        raise QuantityError(rule, "choose its columns of displacement and force: columns: [0, 1]")
    origin = "displacement from {}, force from {}".format(*map(table.label, numbers))
    beside: list[Array | None] = []
    for words, sought, values_of in (("time", _TIME, _seconds), ("cycles", _CYCLE, _counts)):
        free = [n for n, (misfits, _) in table.ranked(sought).items() if not misfits]
        free = [n for n in free if n not in numbers]
        found = [(n, values[there]) for n in free if (values := values_of(table, n)) is not None]
        beside.append(found[0][1] if found else None)
        origin += f", {words} from {table.label(found[0][0])}" if found else ""
    return Recording(x[there], force[there], origin, int((~there).sum()), *beside)


def _seconds(table: Table, number: int) -> Array | None:
    """Time of a column of numbers or of a clock, s."""
    if (clock := table.words.get(number)) is not None:
        times = pd.to_datetime(clock, errors="coerce", dayfirst="." in clock.iloc[0][:6])
        seconds = (times - times.iloc[0]).dt.total_seconds()
        values = seconds.reindex(range(len(table.values))).to_numpy()
        return values if np.isfinite(values).mean() > _SAME else None
    unit = table.units[number] or "s"
    return table.values[:, number] * parse_quantity(f"1 {unit}", _SECONDS, units_required=True)


def _counts(table: Table, number: int) -> Array | None:
    """Numbers of cycles, if a column counts them."""
    values = table.values[:, number]
    return values if np.isfinite(values).all() and (np.diff(values) >= 0.0).all() else None


def _turns(values: Sequence[float], reach: float) -> list[int]:
    """Places of least and largest values in turn, each a reach or more from the next.

    The first and the last one are where the values begin and end to rise or fall.
    """
    turns, low, high, way = [], 0, 0, 0
    for place, value in enumerate(values):
        if value > values[high]:
            high = place
        if value < values[low]:
            low = place
        if way <= 0 and value - values[low] >= reach:
            turns.append(low)
            way, high = 1, place
        elif way >= 0 and values[high] - value >= reach:
            turns.append(high)
            way, low = -1, place
    return [*turns, high if way > 0 else low] if turns else []


def _extrema(x: Array) -> Places:
    """Places of all local extrema, and both ends."""
    moves = np.flatnonzero(np.diff(x))
    steps = np.sign(np.diff(x)[moves])
    inner = moves[1:][steps[1:] != steps[:-1]]
    return np.unique(np.r_[0, inner, x.size - 1])


def _reversal(x: Array) -> float:
    """The least fall or rise that begins another half of a cycle.

    Cycles remain the same in number while this grows from noise to their own size, whatever their
    means and amplitudes: it lies in the longest range of its logarithm where they do.
    """
    values, counts = x[_extrema(x)].tolist(), []
    for reach in _REVERSALS * np.ptp(x):
        values = [values[n] for n in _turns(values, reach)]
        counts.append(max(len(values) - 2, 0) // 2)
    scores = [
        (sum(later >= _SAME * count for later in counts[n:]) * count / (count + 2.0), n)
        for n, count in enumerate(counts)
    ]
    score, first = max(scores)
    last = first + sum(later >= _SAME * counts[first] for later in counts[first:]) - 1
    # Nearer to the lower end, since small cycles among large ones end the range early.
    return float(np.ptp(x) * _REVERSALS[(2 * first + last) // 3]) if score else np.inf


def cycles_of(x: Array, breaks: Sequence[int] = ()) -> list[slice]:
    """The whole cycles of a displacement: from one rise through its local mean to the next.

    If they are more, from one passage of the displacement with which it begins to the next.
    `breaks` are the readings with which further parts begin; no cycle reaches over these.
    """
    reach, cycles = _reversal(x), []
    for start, stop in pairwise([0, *breaks, x.size]):
        part = x[start:stop]
        found = max(([*pairwise(cuts)] for cuts in _cuts(part, reach)), key=len)
        # The reading that ends a cycle begins the next one.
        found = [(a, b) for a, b in found if b - a >= _FEWEST]
        cycles += [slice(start + a, min(start + b + 1, stop)) for a, b in found]
    return cycles


def _cuts(x: Array, reach: float) -> tuple[list[int], list[int]]:
    """Where cycles may begin and end: in the middle of their rise, and as `x` begins."""
    places = _extrema(x)
    turns = places[_turns(x[places].tolist(), reach)]
    if turns.size < 3:
        return [], []
    ends = x[turns]
    turns[0], turns[-1] = 0, x.size - 1
    # Means and amplitudes of the halves beside each; the first and the last half are not whole.
    halves, whole = np.arange(turns.size - 1), slice(1, -1) if turns.size > 3 else slice(None)
    means, sizes = (
        np.mean([np.interp(halves + n, halves[whole], values[whole]) for n in (-1, 1)], axis=0)
        for values in (0.5 * (ends[1:] + ends[:-1]), 0.5 * np.abs(np.diff(ends)))
    )
    is_rise, steps = np.diff(ends) > 0.0, 1.2 * np.pi * sizes / np.maximum(np.diff(turns), 1)

    def passages(share: float, is_up: bool) -> list[int]:
        """Where halves pass a share of the amplitude; an end may be a step away from it."""
        found, way = [], 1.0 if is_up else -1.0
        for half in halves[is_rise == is_up]:
            first, last = turns[half], turns[half + 1] + 1
            over = way * (x[first:last] - means[half] - share * sizes[half])
            if 0.0 <= over[0] <= steps[half] or over[0] < 0.0 <= over.max():
                found.append(first + int((over >= 0.0).argmax()))
            elif last == x.size and -steps[half] <= over[-1] < 0.0:
                found.append(last)
        return found

    begin = (x[0] - means[0]) / sizes[0]
    if abs(begin) < _NEAR_END:
        return passages(0.0, True), passages(begin, is_rise[0])
    is_end = [abs(x[-1] - means[-1]) >= _NEAR_END * sizes[-1]]
    at_turn = turns[(np.r_[is_rise, ~is_rise[-1:]] == (begin < 0.0)) & np.r_[halves >= 0, is_end]]
    return passages(0.0, True), at_turn.tolist()


def _breaks(recording: Recording) -> list[int]:
    """The readings before which some were not recorded: time or the count of cycles jumps."""
    x, time = recording.displacement, recording.time
    jumps = np.zeros(x.size - 1, bool)
    if recording.counter is not None:
        jumps |= np.diff(np.floor(recording.counter)) > 1.0
    if time is not None and (usual := np.median(steps := np.diff(time))) > 0.0:
        places = _extrema(x)
        halves = np.diff(time[places[_turns(x[places].tolist(), _reversal(x))]])
        longest = np.quantile(halves[halves > 0.0], 0.25) if (halves > 0.0).any() else np.inf
        jumps |= (steps < 0.0) | (steps > max(longest, 3.0 * usual))
    return (np.flatnonzero(jumps) + 1).tolist()


def _numbers(recording: Recording, cycles: Sequence[slice], breaks: Sequence[int]) -> Places:
    """The numbers of cycles, from 0: of a column that counts them, or by the time in between."""
    x, time, count = recording.displacement, recording.time, np.arange(len(cycles))
    if recording.counter is not None:
        counted = [int(np.median(recording.counter[cycle])) for cycle in cycles]
        # Several cycles of one number follow each other.
        return np.maximum.accumulate(np.array(counted) - count) + count
    if time is None or not breaks:
        return count
    parts = np.searchsorted(breaks, [cycle.start for cycle in cycles], side="right")
    edges = [0, *breaks, x.size]
    level = np.median([x[cycle.start] for cycle in cycles])

    def passage(place: int, part: int) -> float:
        """When the displacement passes the level at a reading, s."""
        after = min(max(place, edges[part] + 1), edges[part + 1] - 1)
        rise = x[after] - x[after - 1]
        share = np.clip((level - x[after - 1]) / rise, -1.0, 3.0) if rise else 0.0
        return float(time[after - 1] + share * (time[after] - time[after - 1]))

    starts = [passage(cycle.start, part) for cycle, part in zip(cycles, parts, strict=True)]
    stops = [passage(cycle.stop - 1, part) for cycle, part in zip(cycles, parts, strict=True)]
    period = float(np.median(np.subtract(stops, starts)))
    numbers = [0]
    for n in range(1, len(cycles)):
        gap = max(round((starts[n] - starts[n - 1]) / period), 1) if parts[n] > parts[n - 1] else 1
        numbers.append(numbers[-1] + gap)
        if starts[n] > starts[0] and gap > 1:  # the longer the time, the better the period
            period = (starts[n] - starts[0]) / numbers[-1]
    return np.array(numbers)


@dataclass(frozen=True)
class Loops:
    """A recording that is split into cycles."""

    recording: Recording
    cycles: list[slice]  #: their readings
    table: pd.DataFrame  #: a row for each cycle, see `loop_history`
    notes: tuple[str, ...]  #: the columns that were chosen, and what was left out


def loop_history(path: str | Path, load: float, layout: Layout = PLAIN) -> pd.DataFrame:
    """The cycles of a recording under a normal load, N, or N/m of a line contact.

    Its columns are ``cycle`` from 0, ``displacement_amplitude`` (m), ``force_amplitude`` (N or
    N/m), ``dissipated_energy`` E = ∮ Q dδ (J or J/m), and ``friction`` E/(4 P δ₀), with half the
    width δ₀ of the loop at Q = 0: the coefficient of a contact that slides as a whole, whatever the
    compliance of the rig; NaN where the loop has no width. A column of cycles, or jumps of the
    time, give the number of a cycle. What is not part of a whole cycle is left out.
    """
    return split_recording(path, load, layout).table


def split_recording(path: str | Path, load: float, layout: Layout = PLAIN) -> Loops:
    """The cycles of a recording, as `loop_history` has them, with their readings."""
    recording = recording_of(Path(path), layout, "N")
    breaks = _breaks(recording)
    if not (cycles := cycles_of(recording.displacement, breaks)):
        rule = "has no whole cycle of its displacement"
        raise QuantityError(rule, "check its columns, or record a cycle from its beginning on")
    table = _loops(recording.displacement, recording.force, cycles)
    table.insert(0, "cycle", _numbers(recording, cycles, breaks))
    width = table.pop("width")
    slides = width > _STUCK * table["displacement_amplitude"]
    table["friction"] = (table["dissipated_energy"] / (2.0 * load * width)).where(slides)
    if np.isinf(table["friction"]).any():
        raise QuantityError("has an infinite friction", "check the load and the columns")
    is_outside = np.ones(recording.force.size, bool)
    for cycle in cycles:
        is_outside[cycle] = False
    outside, total = int(is_outside.sum()), is_outside.size + recording.missing
    notes = [recording.origin]
    if outside or recording.missing:
        lacking = f" and {recording.missing} without numbers" if recording.missing else ""
        notes.append(f"left out: {outside} readings outside whole cycles{lacking}, of {total}")
    if breaks and recording.counter is None:
        notes.append(f"{len(breaks)} jumps of the time, in which cycles are taken to have gone on")
    if stuck := int((~slides).sum()):
        notes.append(
            f"friction not known in {stuck} cycles, which stick: their loops have no width"
        )
    return Loops(recording, cycles, table, (*notes,))


def histories(
    paths: Sequence[Path], load: float, layout: Layout = PLAIN
) -> tuple[pd.DataFrame, list[str]]:
    """The cycles of one recording, or of files with a loop or more of the cycle in their names."""
    found, tables = _cycles_in_names(paths), []
    notes: dict[str, list[str]] = {}
    for path in paths:
        try:
            history = split_recording(path, load, layout)
        except QuantityError as error:
            raise QuantityError(f"{path}: {error.rule}", error.hint) from error
        table = history.table
        if found and history.recording.counter is None:
            table["cycle"] += found[path]
        tables.append(table)
        for text in history.notes:
            notes.setdefault(text, []).append(path.name)
    table = pd.concat(tables).sort_values("cycle")
    if (twice := table["cycle"].duplicated()).any():
        rule = f"two files have cycle {table['cycle'][twice].iloc[0]}"
        raise QuantityError(rule, "say the cycle in the name of each file, such as loop_1000.csv")
    said = [t if len(n) == len(paths) else f"{', '.join(n[:3])}: {t}" for t, n in notes.items()]
    return table, said


def _cycles_in_names(paths: Sequence[Path]) -> dict[Path, int]:
    """The last numbers in the names of files that all differ."""
    if len(paths) == 1:
        return {}
    numbers = [[int(one) for one in re.findall(r"\d+", path.stem)] for path in paths]
    places = zip(*numbers, strict=True) if len({*map(len, numbers)}) == 1 else ()
    differing = [place for place in places if len({*place}) == len(paths)]
    if not differing:
        rule = "the files do not say their cycles: their names lack numbers that all differ"
        raise QuantityError(rule, "name them by their cycles, such as loop_0.csv loop_1000.csv")
    return dict(zip(paths, differing[-1], strict=True))


def _loops(x: Array, force: Array, cycles: Sequence[slice]) -> pd.DataFrame:
    """Amplitudes of displacement and force, energy, and width at the middle force of loops."""
    sizes = np.array([cycle.stop - cycle.start for cycle in cycles])
    starts = np.r_[0, np.cumsum(sizes)[:-1]]
    rows = np.concatenate([np.arange(cycle.start, cycle.stop) for cycle in cycles])
    x, force = x[rows], force[rows]

    def ends(values: Array) -> tuple[Array, Array]:
        return np.maximum.reduceat(values, starts), np.minimum.reduceat(values, starts)

    (largest, least), (highest, lowest) = ends(x), ends(force)
    force = force - np.repeat(0.5 * (highest + lowest), sizes)
    following = np.arange(rows.size) + 1
    following[starts + sizes - 1] = starts
    x_after, after = x[following], force[following]
    energy = np.abs(np.add.reduceat(0.5 * (force + after) * (x_after - x), starts))
    crossing = np.sign(force) != np.sign(after)
    share = np.divide(force, force - after, out=np.zeros_like(x), where=crossing)
    places = x + share * (x_after - x)
    right, _ = ends(np.where(crossing, places, -np.inf))
    _, left = ends(np.where(crossing, places, np.inf))
    width = np.where(highest > lowest, right - left, 0.0)
    return pd.DataFrame(
        {
            "displacement_amplitude": 0.5 * (largest - least),
            "force_amplitude": 0.5 * (highest - lowest),
            "dissipated_energy": energy,
            "width": width,
        }
    )


def last_loop(recording: Recording) -> tuple[Array, Array]:
    """The last whole loop of a recording, from its largest displacement on, as it dissipates."""
    x, force = recording.displacement, recording.force
    if len(cycles := cycles_of(x, _breaks(recording))) > 1:
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
    """The friction of `loop_history` as study files have it, at a few cycles."""
    table = table.dropna(subset="friction")
    last = len(table) - 1
    rows = {0, *np.geomspace(1, max(last, 1), _MOST_POINTS - 1).round().astype(int).tolist()}
    few = table.iloc[sorted(row for row in rows if row <= last)]
    values = ", ".join(f"{value:.3g}" for value in few["friction"])
    return f"friction: {{cycles: [{', '.join(map(str, few['cycle']))}], values: [{values}]}}"
