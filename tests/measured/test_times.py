"""Recordings whose channels have rates or starts of their own."""

from itertools import zip_longest

import numpy as np
import pytest

from fretwear.units import QuantityError
from fretwear_fit.loops import split_recording
from fretwear_measured.tables import open_table

LOAD, FRICTION, AMPLITUDE = 100.0, 30.0, 50.0  # N, N, µm
STAMP = np.datetime64("2026-03-01T10:00:00", "us")
STEP, DELAY = 1 / 400, 0.05  # s; the delay is told by the clock, the rest of a start by an offset


def channel(name, start=0.0, step=STEP):
    """Ten seconds of a contact that slides as a whole at 1 Hz: name, unit, start, step, values."""
    turn = 2 * np.pi * (start + step * np.arange(round(10 / step)))
    if name == "x":
        return name, "um", start, step, AMPLITUDE * np.sin(turn)
    return name, "N", start, step, FRICTION * np.sign(np.cos(turn + 1e-6))


def write_tdms(file, channels, untold=()):
    from nptdms import ChannelObject, TdmsWriter

    with TdmsWriter(file) as writer:
        objects = []
        for name, unit, start, step, values in channels:
            delay = min(start, DELAY)
            stamp = STAMP + np.timedelta64(round(1e6 * delay), "us")
            waveform = {
                "wf_start_time": stamp,
                "wf_start_offset": start - delay,
                "unit_string": unit,
            }
            waveform |= {} if name in untold else {"wf_increment": step}
            objects.append(ChannelObject("run", name, values, waveform))
        writer.write_segment(objects)


def write_lvm(file, channels, kind, segments=1):
    gap = "\t\t" if kind == "Multi" else "\t"
    names, units, starts, steps, _ = zip(*channels, strict=True)
    delays = np.minimum(starts, DELAY)
    text = f"LabVIEW Measurement\t\nSeparator\tTab\nX_Columns\t{kind}\nTime_Pref\tRelative\n"
    text += "***End_of_Header***\t\n\t\n"
    for part in range(segments):
        firsts = np.subtract(starts, delays) + 10.0 * part / segments
        columns = []
        for (*_, step, values), first in zip(channels, firsts, strict=True):
            own = np.split(values, segments)[part]
            has_x = kind == "Multi" or (kind == "One" and not columns)
            columns += [first + step * np.arange(own.size)] * has_x + [own]
        head = {
            "Channels": [2, ""],
            "Date": ["2026/03/01"] * 2,
            "Time": [f"10:00:{delay:.16f}" for delay in delays],
            "Y_Unit_Label": units,
            "X0": firsts,
            "Delta_X": steps,
        }
        text += "".join(f"{key}\t{gap.join(map(str, each))}\t\n" for key, each in head.items())
        x = gap.replace("\t\t", "\tX_Value\t")
        text += f"***End_of_Header***\t\t\nX_Value\t{x.join(names)}\tComment\n"
        for row in zip_longest(*columns, fillvalue=""):
            text += "\t" * (kind == "No") + "\t".join(map(str, row)) + "\n"
        text += "\t\n"
    file.write_text(text)


def write_text(file, channels, step=1):
    columns = [c for *_, s, h, v in channels for c in (s + h * np.arange(v.size), v)]
    rows = [",".join(map(str, row[::step])) for row in zip_longest(*columns, fillvalue="")]
    heads = [h for n, c in enumerate(channels) for h in (f"time{n} (s)", f"{c[0]} ({c[1]})")]
    file.write_text("\n".join([",".join(heads[::step]), *rows]))


def write(folder, kind, *channels):
    file = folder / f"run.{kind.split()[0]}"
    if kind.startswith("lvm"):
        write_lvm(file, channels, kind.split()[1], 1 + kind.endswith("parts"))
    elif kind == "tdms":
        write_tdms(file, channels)
    else:
        write_text(file, channels, -1 if kind.endswith("back") else 1)
    return file


LVM = ("No", "One", "Multi", "No parts", "Multi parts")
KINDS = ("tdms", "csv", "csv back", *(f"lvm {how}" for how in LVM))


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize(
    ("force", "size"),
    [
        ({"step": 2 * STEP}, "'x' interpolated linearly at 2000 times of 'force'"),
        ({"start": 0.1}, "'force' interpolated linearly at 3960 times of 'x'"),
        ({"start": 0.3, "step": STEP / 2}, "'force' interpolated linearly at 3880 times of 'x'"),
    ],
)
def test_channels_of_other_rates_and_starts_dissipate_the_same(tmp_path, kind, force, size):
    """E = 4 µP A, but for the force that rises within a sample: (2 π f Δt)²/2 of it at most."""
    split = split_recording(write(tmp_path, kind, channel("x"), channel("force", **force)), LOAD)
    energy = 4.0 * FRICTION * 1e-6 * AMPLITUDE
    assert split.table["dissipated_energy"].to_numpy() == pytest.approx(energy, rel=5e-4)
    assert split.table["friction"].to_numpy() == pytest.approx(FRICTION / LOAD, rel=5e-4)
    assert len(split.table) == 10 - (force.get("start", 0.0) > 0.0)
    assert f"{size}, since their rates or starts differ" in split.notes


@pytest.mark.parametrize("kind", KINDS)
def test_channels_of_the_same_times_are_left_as_they_are(tmp_path, kind):
    table = open_table(write(tmp_path, kind, channel("x"), channel("force")))
    columns = [n for n, name in enumerate(table.names) if name in ("x", "force")]
    assert table.aligned(columns) is table


def test_channels_without_a_common_time_are_refused(tmp_path):
    file = write(tmp_path, "tdms", channel("x"), channel("force", start=10.1))
    with pytest.raises(QuantityError, match=r"common time: 'x' and 'force'.*one column of time"):
        split_recording(file, LOAD)


@pytest.mark.parametrize("start", [-1e3, 1.7e9])
def test_rows_are_moments_where_two_clocks_have_no_common_time(tmp_path, start):
    """Such as seconds of a test and of an epoch, or a column T of rising temperatures."""
    _, unit, _, step, values = channel("force")
    table = open_table(write(tmp_path, "csv", channel("x"), ("force", unit, start, step, values)))
    assert table.aligned([1, 3]) is table


def test_channels_whose_times_are_not_told_need_as_many_readings(tmp_path):
    """A count of cycles has the times of the channel that it is as long as."""
    count = ("cycle", "", 0.0, STEP, np.floor(STEP * np.arange(4000)) + 3000)
    channels = channel("x"), channel("force", step=2 * STEP), count
    write_tdms(tmp_path / "run.tdms", channels, ("cycle",))
    table = split_recording(tmp_path / "run.tdms", LOAD).table
    assert table["cycle"].tolist() == [*range(3000, 3010)]
    write_tdms(tmp_path / "run.tdms", channels, ("force",))
    with pytest.raises(QuantityError, match="4000 readings of 'x' and 2000 readings of 'force'"):
        split_recording(tmp_path / "run.tdms", LOAD)


@pytest.mark.parametrize("step", ["", "unknown"])
def test_an_increment_that_is_no_number_is_none(tmp_path, step):
    file = write(tmp_path, "tdms", channel("x"), channel("force"))
    plain = split_recording(file, LOAD).table
    write_tdms(file, [(*c[:3], step, c[4]) for c in (channel("x"), channel("force"))])
    assert split_recording(file, LOAD).table.equals(plain)


def test_columns_whose_times_are_told_twice_need_as_many_readings(tmp_path):
    """A clock of few digits tells some times twice, so rows of another rate are no moments."""
    file = write(tmp_path, "csv", channel("x"), channel("force", step=2 * STEP))
    file.write_text(file.read_text().replace("\n0.0075,", "\n0.005,"))
    with pytest.raises(QuantityError, match=r"4000 .* 2000 .*no rising times.*one column of time"):
        split_recording(file, LOAD)


def test_a_force_that_is_read_too_seldom_for_the_cycles_is_refused(tmp_path):
    """Read every 0.9 s, a motion of 1 Hz looks like one of 0.11 Hz with ten readings."""
    file = write(tmp_path, "tdms", channel("x"), channel("force", step=0.9))
    with pytest.raises(QuantityError, match=r"has 1\.1 readings of both .* at least 8 in a cycle"):
        split_recording(file, LOAD)


def test_the_increment_tells_where_readings_are_missing(tmp_path):
    """Three seconds without numbers, in which cycles have gone on."""
    x, force = channel("x"), channel("force")
    x[-1][1300:2500] = np.nan
    table = split_recording(write(tmp_path, "tdms", x, force), LOAD).table
    assert table["cycle"].tolist() == [0, 1, 2, 7, 8, 9]
