"""Readings of channels that have rates or starts of their own."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from contextlib import suppress
from typing import Any

import numpy as np

from fretwear.arrays import Array

_SAME = 1e-3  # of a step, within which times are equal
_WIDEST = 3.0  # steps between two readings that are interpolated
_FIRST_STAMP = np.datetime64("1904-01-02", "us")  # LabVIEW writes zero, 1 January 1904, for none
_X = "Delta_X", "X0"


def usual_step(times: Array) -> float:
    """The usual step of times."""
    known = times[np.isfinite(times)]
    return float(np.median(np.diff(known))) if known.size > 1 else 0.0


def count_readings(values: Array) -> int:
    """The number of readings of a channel up to its last one."""
    known = np.isfinite(values)
    return values.size - int(known[::-1].argmax()) if known.any() else 0


def until_last(times: Array, values: Array) -> Array:
    """Times up to the last of some values, NaN behind it."""
    count = count_readings(values)
    return times if count == times.size else np.append(times[:count], times[count:] * np.nan)


def rise(times: Array) -> bool:
    """Whether times rise from each known one to the next."""
    known = times[np.isfinite(times)]
    return known.size > 1 and bool((np.diff(known) > 0.0).all())


def are_same(times: Array, others: Array) -> bool:
    """Whether two channels have the same times, where both have any."""
    if others is times:
        return True
    differences = np.abs(times - others)
    return bool((differences[np.isfinite(differences)] <= _SAME * abs(usual_step(times))).all())


def common_times(times: Array, channels: Sequence[Array]) -> Array:
    """Those of some times that all channels cover."""
    margin = _SAME * usual_step(times)
    first, last = max(map(np.nanmin, channels)), min(map(np.nanmax, channels))
    return times[(times >= first - margin) & (times <= last + margin)]


def values_at(times: Array, own: Array, values: Array) -> Array:
    """Values at other times than their own, which rise: NaN outside these and in their gaps."""
    own, values = own[np.isfinite(own)], values[np.isfinite(own)]
    margin, step = _SAME * usual_step(times), max(usual_step(own), usual_step(times))
    near = np.clip(times, own[0], own[-1])
    after = np.clip(np.searchsorted(own, near), 1, own.size - 1)
    left, right = own[after - 1], own[after]
    is_in_gap = (right - left > _WIDEST * step) & (np.minimum(near - left, right - near) > margin)
    is_outside = np.abs(near - times) > margin
    return np.where(is_in_gap | is_outside, np.nan, np.interp(near, own, values))


def times_of_waveforms(waveforms: Sequence[Mapping[str, Any]], size: int) -> list[Array | None]:
    """Times of the channels of a TDMS file, s; None for those that do not tell their increment.

    A channel without a time stamp starts like the earliest one.
    """
    stamps = [one.get("wf_start_time") for one in waveforms]
    known = [s for s in stamps if isinstance(s, np.datetime64) and s > _FIRST_STAMP]
    steps, shared, times = np.arange(size, dtype=float), dict[tuple[float, float], Array](), []
    for one, stamp in zip(waveforms, stamps, strict=True):
        step, start = (_number(one.get(f"wf_{name}")) for name in ("increment", "start_offset"))
        delay = float((stamp - min(known)) / np.timedelta64(1, "s")) if stamp in known else 0.0
        key = delay + start, step
        times.append(shared.setdefault(key, key[0] + step * steps) if step else None)
    return times


def _number(value: Any) -> float:
    """The number in a property, zero without one."""
    with suppress(TypeError, ValueError):
        return float(np.nan_to_num(float(value)))
    return 0.0


def times_of_segments(content: Mapping[Any, Any], count: int) -> list[Array | None]:
    """Times of the columns of a LabVIEW measurement as `lvm_read` gives it, s.

    Empty if its channels have the same times and its columns tell these, or its segments do not
    follow each other at once.
    """
    kind, is_relative = content.get("X_Columns", "One"), content.get("Time_Pref") != "Absolute"
    segments = [content[n] for n in range(content["Segments"]) if len(content[n]["data"])]
    shift = 0 if kind == "No" else 1
    channels = range(shift, count, 2 if kind == "Multi" else 1)
    starts = [[_stamp(one, n - shift, is_relative) for n in channels] for one in segments]
    base = next((s for one in starts for s in one if np.isfinite(s)), 0.0)
    parts = []
    for segment, stamps in zip(segments, starts, strict=True):
        data, times = segment["data"], []
        steps, firsts = ([_entry(segment, key, n - shift) for n in channels] for key in _X)
        for n, step, first, stamp in zip(channels, steps, firsts, stamps, strict=True):
            x = np.nan_to_num(first) + step * np.arange(len(data))
            if n >= data.shape[1]:
                x = np.full(len(data), np.nan)
            elif kind == "Multi":
                x = data[:, n - 1]
            elif kind == "One" and not abs(step - steps[0]) > _SAME * abs(steps[0]) / len(data):
                x = data[:, 0] + np.nan_to_num(first - firsts[0])
            x = x + np.nan_to_num(stamp - base)
            times.append(until_last(x, data[:, min(n, data.shape[1] - 1)]))
        parts.append(times)
    columns = [np.concatenate(times) for times in zip(*parts, strict=True)]
    found = {n: t for n, t in zip(channels, columns, strict=False) if np.isfinite(t).any()}
    one, *others = found.values() or [np.empty(0)]
    if (kind != "No" or len(segments) > 1) and all(are_same(one, time) for time in others):
        return []
    return [found.get(n) for n in range(count)]


def _entry(segment: Mapping[str, Any], key: str, place: int) -> float:
    """A number of the head of a segment for one of its channels, NaN without one."""
    values = segment.get(key, [])
    return float(values[place]) if place < len(values) else np.nan


def _stamp(segment: Mapping[str, Any], place: int, is_relative: bool) -> float:
    """When the X values of a channel are zero, s since 1970; NaN if that is not told."""
    try:
        day, clock = (segment[key][place].strip().replace(",", ".") for key in ("Date", "Time"))
        hours, minutes, seconds = map(float, clock.split(":"))
        days = np.datetime64(day.replace("/", "-"), "D").astype(float)
    except (KeyError, IndexError, ValueError):
        return np.nan
    return ((24.0 * days + hours) * 60.0 + minutes) * 60.0 + seconds if is_relative else np.nan
