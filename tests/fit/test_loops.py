"""A recording of many loops with a time column is split into cycles."""

import numpy as np
import pytest
import yaml

from fretwear.study.case import Case
from fretwear.units import QuantityError
from fretwear_fit.loops import histories, split_recording
from fretwear_measured.tables import Layout

from ..studies import base

LOAD, AMPLITUDE, STIFFNESS = 50.0, 40e-6, 2e6  # N, m, N/m of the rig in series


def friction_at(cycle):
    return 0.3 + 0.4 * cycle / 20.0


def pushed(x, friction, first=0.0):
    """Force, N, of a contact that slides as a whole on a rig with a displacement, m."""
    force = np.full(x.size, first)
    limit = np.broadcast_to(friction * LOAD, x.size)
    for n in range(1, x.size):
        trial = force[n - 1] + STIFFNESS * (x[n] - x[n - 1])
        force[n] = np.clip(trial, -limit[n], limit[n])
    return force


def written(file, heads, *columns, separator=",", comma=False, top=""):
    rows = "\n".join(separator.join(f"{v:.5f}" for v in row) for row in zip(*columns, strict=True))
    rows = rows.replace(".", ",") if comma else rows
    file.write_text(f"{top}{separator.join(heads)}\n{rows}\n")
    return file


def recorded(file):
    """Twenty cycles of a contact that slides as a whole, from a part of one before."""
    turn = np.arange(-0.3, 20.4, 1 / 400)
    x = AMPLITUDE * np.sin(2 * np.pi * turn)
    force = pushed(x, friction_at(np.maximum(np.floor(turn), 0.0)))
    written(file, ("time (s)", "displacement (um)", "force (N)"), turn, 1e6 * x, force)


def test_each_cycle_has_its_friction_amplitude_and_energy(tmp_path):
    """E = 4 µP (δ − µP/k), of a parallelogram."""
    recorded(tmp_path / "loops.csv")
    table = split_recording(tmp_path / "loops.csv", LOAD).table
    assert len(table) == 20
    expected = friction_at(table["cycle"].to_numpy())
    # A cycle begins in the middle of the rise, so its first readings have the friction before.
    assert table["friction"][3:].to_numpy() == pytest.approx(expected[3:], rel=0.01)
    assert table["displacement_amplitude"].to_numpy() == pytest.approx(AMPLITUDE, rel=1e-3)
    force = expected * LOAD
    energy = 4.0 * force * (AMPLITUDE - force / STIFFNESS)
    assert table["dissipated_energy"][3:].to_numpy() == pytest.approx(energy[3:], rel=0.03)


def test_the_command_prints_friction_that_a_study_takes(desk, tmp_path):
    recorded(tmp_path / "loops.csv")
    said = desk.call("loops", tmp_path / "loops.csv", "--load", "50 N", "-o", "table.csv").stdout
    written = yaml.safe_load(said.splitlines()[-1])
    case = Case(**base() | written)
    assert case.friction.at(10) == pytest.approx(friction_at(10), rel=0.02)


FRICTION = 0.55


def slid(turn, amplitude=AMPLITUDE, mean=0.0):
    """Displacement, m, and force, N, of a contact in gross slip over the number of turns."""
    x = mean + amplitude * np.sin(2 * np.pi * turn)
    return x, pushed(x, FRICTION, FRICTION * LOAD * np.sign(np.cos(2 * np.pi * turn[0])))


TURN = np.arange(0.0, 4.0001, 1 / 100)
X, FORCE = slid(TURN)
MICRO, NORMAL = 1e6 * X, np.full(X.size, 50.2)


@pytest.mark.parametrize(
    ("heads", "columns", "how"),
    [
        (("Zeit (s)", "Normalkraft (N)", "Reibkraft (N)", "Weg (µm)"), (TURN, NORMAL, FORCE, MICRO),
         {"separator": ";", "comma": True}),
        (("Fz (N)", "Z (mm)", "Fx (N)", "X (mm)"), (NORMAL, NORMAL, FORCE, 1e3 * X), {}),
        (("", "displacement (um)", "force (N)"), (TURN, MICRO, FORCE), {"separator": "\t"}),
        (("s", "Ff", "COF", "F_n", "Set position", "Position"),
         (TURN, FORCE, FORCE, NORMAL, NORMAL, MICRO),
         {"top": "Step 1\n", "separator": "\t"}),
    ],
)  # fmt: skip
def test_no_other_force_or_direction_is_taken_for_friction(tmp_path, heads, columns, how):
    if heads[0] == "s":  # a line of units
        how = how | {"top": "\t".join(heads) + "\n"}
        heads = ("sec", "Newton", "", "N", "mm", "um")
    table = split_recording(written(tmp_path / "run.txt", heads, *columns, **how), LOAD).table
    assert table["cycle"].tolist() == [0, 1, 2, 3]
    assert table["friction"].to_numpy() == pytest.approx(FRICTION, rel=5e-3)
    assert table["displacement_amplitude"].to_numpy() == pytest.approx(AMPLITUDE, rel=1e-3)


@pytest.mark.parametrize(
    ("heads", "layout", "sentence"),
    [
        (("x (um)", "force A (N)", "force B (N)"), {}, "'force a' and 'force b'.*columns: .0, 1"),
        (("stroke (um)", "position (um)", "force (N)"), {}, "'stroke' and 'position'"),
        (("x (um)", "normal force (N)", "time (s)"), {}, "not force, friction or load"),
        (("x (um)", "force (N)", "time (s)"), {"columns": (1, 1)}, "2 different columns"),
        (("0", "0", "0"), {}, "2 different columns, not 3 without names"),
        (("x (um)", "a", "force (N)"), {"columns": (1, 0), "units": ("um", "N")}, "same force"),
    ],
)
def test_what_may_be_several_columns_is_asked(tmp_path, heads, layout, sentence):
    columns = (MICRO, FORCE, FORCE) if layout.get("units") is None else (NORMAL, MICRO, FORCE)
    file = written(tmp_path / "run.csv", heads, *columns)
    with pytest.raises(QuantityError, match=sentence):
        split_recording(file, LOAD, Layout(**layout))


def test_small_cycles_count_beside_large_ones_and_on_a_drift(tmp_path):
    """Sixty cycles whose amplitude grows twelvefold while their mean moves by three of these."""
    turn = np.arange(0.0, 60.0001, 1 / 80)
    amplitude = 1e-6 * (2.0 + np.floor(turn / 10.0) * 4.4)
    x, force = slid(turn, amplitude, mean=75e-6 * turn / 60.0)
    noise = np.random.default_rng(2).normal(0.0, 0.05, turn.size)
    file = written(tmp_path / "run.csv", ("x (um)", "force (N)"), 1e6 * x + noise, force)
    table = split_recording(file, LOAD).table
    assert len(table) == 60
    # The steps of the mean and of the amplitude are within one cycle of ten each.
    measured = table["displacement_amplitude"].to_numpy().reshape(6, 10)[:, 5]
    drift = 0.5 * 75e-6 / 60.0
    assert measured == pytest.approx(1e-6 * (2.0 + 4.4 * np.arange(6)), abs=drift + 0.2e-6)


@pytest.mark.parametrize("begin", [0.0, 0.25, 0.4, 0.75])
def test_the_first_and_the_last_whole_cycle_count_wherever_they_begin(tmp_path, begin):
    x, force = slid(begin + np.arange(0.0, 10.0001, 1 / 120))
    file = written(tmp_path / "run.csv", ("x (um)", "force (N)"), 1e6 * x, force)
    split = split_recording(file, LOAD)
    assert len(split.table) == 10
    assert not [note for note in split.notes if "left out" in note]


def test_jumps_of_the_time_number_the_cycles(tmp_path):
    """Two cycles of every five hundred are stored, at 12.3 Hz, with a clock."""
    turn = (500.0 * np.arange(8)[:, None] + np.arange(0.1, 2.6, 1 / 90)).ravel()
    x, force = slid(turn)
    stamps = np.datetime64("2026-03-05T23:58:00") + (turn / 12.3 * 1e6).astype("timedelta64[us]")
    rows = "".join(f"{t};{a:.4f};{q:.4f}\n" for t, a, q in zip(stamps, 1e6 * x, force, strict=True))
    file = tmp_path / "run.csv"
    file.write_text(f"Timestamp;x (um);force (N)\n{rows}")
    split = split_recording(file, LOAD)
    numbers = split.table["cycle"].to_numpy()
    assert sorted({*numbers // 500 * 500}) == [500 * n for n in range(8)]
    assert (numbers % 500 < 3).all()
    assert [note for note in split.notes if "7 jumps of the time" in note]
    assert [note for note in split.notes if note.startswith("left out: ")]


def test_a_column_or_the_names_of_files_number_the_cycles(tmp_path):
    counter = np.floor(TURN) + 3000 + 900 * (TURN >= 2.0)
    heads = ("Cycle", "x (um)", "force (N)")
    table = split_recording(written(tmp_path / "run.csv", heads, counter, MICRO, FORCE), LOAD).table
    assert table["cycle"].tolist() == [3000, 3001, 3902, 3903]
    for cycle in (20, 5):
        written(tmp_path / f"steel2_{cycle:05d}_50N.csv", heads[1:], MICRO[:101], FORCE[:101])
    table, _ = histories(sorted(tmp_path.glob("steel*")), LOAD)
    assert table["cycle"].tolist() == [5, 20]
    with pytest.raises(QuantityError, match=r"loop_0\.csv loop_1000\.csv"):
        histories([tmp_path / "a.csv", tmp_path / "b.csv"], LOAD)


def test_a_contact_that_sticks_has_no_friction_and_no_infinite_one(tmp_path):
    x = 1e-6 * np.sin(2 * np.pi * TURN)
    file = written(tmp_path / "run.csv", ("x (um)", "force (N)"), 1e6 * x, 2e7 * x)
    split = split_recording(file, LOAD)
    assert split.table["friction"].isna().all()
    assert [note for note in split.notes if "4 cycles, which stick" in note]


@pytest.mark.parametrize("begin", [0.0, 0.15, 0.25, 0.5])
def test_a_first_cycle_of_an_unloaded_contact_has_no_friction(tmp_path, begin):
    """Its force begins at zero and ends at µP: 2 to 7 % off, where no other is off by 0.2 %."""
    x = AMPLITUDE * np.sin(2 * np.pi * (begin + np.arange(0.0, 5.0001, 1 / 100)))
    force = pushed(x, FRICTION)
    split = split_recording(written(tmp_path / "a.csv", ("x (um)", "q (N)"), 1e6 * x, force), LOAD)
    friction = split.table["friction"].to_numpy()
    assert np.isnan(friction).tolist() == [True, False, False, False, False]
    assert friction[1:] == pytest.approx(FRICTION, rel=2e-3)
    assert "friction not known in 1 cycles, whose loops do not close" in split.notes


def test_the_options_of_the_command_say_what_the_file_lacks(desk, tmp_path):
    """Volts, a title with numbers, decimal commas: keys of study files by the same names."""
    volts = written(
        tmp_path / "run.csv", ("a", "b", "c"), NORMAL, 1e6 * X / 20.0, FORCE / -10.0,
        separator=";", comma=True, top="1;2;3\n4;5;6\n",
    )  # fmt: skip
    call = ("loops", volts, "--load", "50 N", "-o", "table.csv")
    layout = ("--skip", "2", "--columns", "b, 2", "--units", "V", "--decimal", ",")
    said = desk.call(*call, *layout, "--scale", "20 um/V, -10 N/V", "--encoding", "utf-8")
    assert "displacement from 'b', force from 'c'" in said.stderr
    assert yaml.safe_load(said.stdout.splitlines()[-1])["friction"]["values"] == [0.55] * 4
    assert "--columns '0, 1'" in desk.call(*call, "--skip", "2", status=2).stderr


def test_the_remedy_for_channels_in_volts_names_them_and_works(desk, tmp_path):
    heads = ("Time (s)", "CH1 (V)", "CH2 (V)")
    scope = written(tmp_path / "scope.csv", heads, TURN, MICRO / 10.0, FORCE / 10.0)
    call = ("loops", scope, "--load", "50 N", "-o", "table.csv")
    remedy = desk.call(*call, status=2).stderr
    keys = ("--columns", "1, 2"), ("--scale", "10 um/V, 10 N/V")
    assert all(f"{key} '{value}'" in " ".join(remedy.split()) for key, value in keys)
    said = desk.call(*call, *keys[0], *keys[1]).stdout
    assert yaml.safe_load(said.splitlines()[-1])["friction"]["values"] == [0.55] * 4


def test_files_of_labview_are_read_by_their_libraries(tmp_path):
    from nptdms import ChannelObject, TdmsWriter

    step = {"wf_increment": 1e-3, "unit_string": "um"}
    with TdmsWriter(tmp_path / "run.tdms") as writer:
        channels = [("x", MICRO, step), ("Ft", FORCE, {"unit_string": "N"}),
                    ("Fn", NORMAL, {"unit_string": "N"})]  # fmt: skip
        writer.write_segment([ChannelObject("run", *channel) for channel in channels])
    rows = "".join(
        f"{t:.4f}\t{x:.4f}\t{f:.4f}\t{p:.1f}\n"
        for t, x, f, p in zip(TURN, MICRO, FORCE, NORMAL, strict=True)
    ).replace(".", ",")
    (tmp_path / "run.lvm").write_text(
        "LabVIEW Measurement\t\nSeparator\tTab\nDecimal_Separator\t,\nX_Columns\tOne\n"
        "***End_of_Header***\t\n\t\nChannels\t3\t\t\nY_Unit_Label\tum\tNewtons\tNewtons\n"
        "***End_of_Header***\t\t\t\nX_Value\tDisplacement\tFriction\tNormal\tComment\n" + rows
    )
    for name in ("run.tdms", "run.lvm"):
        table = split_recording(tmp_path / name, LOAD).table
        assert table["friction"].to_numpy() == pytest.approx(FRICTION, rel=5e-3)


@pytest.mark.slow
def test_a_long_recording_takes_seconds(tmp_path):
    """600,000 readings within 3 s of processor time: a quarter of the time of cell by cell."""
    from time import process_time

    turn = np.arange(600_000) / 200.0
    x = 25.0 * np.sin(2 * np.pi * turn) + np.random.default_rng(1).normal(0.0, 0.05, turn.size)
    force = np.clip(200.0 * np.cos(2 * np.pi * turn), -30.0, 30.0)
    np.savetxt(
        tmp_path / "run.csv", np.c_[turn, x, force], "%.4f", ",",
        header="Time (s),x (um),force (N)", comments="",
    )  # fmt: skip
    begin = process_time()
    assert len(split_recording(tmp_path / "run.csv", LOAD).table) == 3000
    assert process_time() - begin < 3.0
