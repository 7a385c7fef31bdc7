"""Files and folders that fail a command: full, read-only, damaged, or somewhere else."""

import re
import shutil
import subprocess
import zlib
from contextlib import suppress
from pathlib import Path

import pytest

from fretwear.cli.program import swallowing_no_lack_of_memory
from fretwear.data.files import _LENGTH, add_checksum

from ..studies import flip

FULL = "not written, because the disk (or the quota on it) is full"


SUMMARY = "its checksum does not match. Merge the study again"


@pytest.fixture
def copied(finished_desk, desk):
    """The same in the folder that the commands are called from, to be spoilt."""
    shutil.copytree(finished_desk.folder / "results", "results/tiny")
    return desk


def fill(disk, leaving):
    """Fill a disk but for so many bytes."""
    free = shutil.disk_usage(disk).free
    (disk / "filler").write_bytes(b"x" * (free - leaving))


def everything(folder):
    return {path.relative_to(folder): path.stat().st_size for path in folder.rglob("*")}


def test_a_run_on_a_full_disk_says_so_and_goes_on_when_there_is_space(desk, mounted):
    disk = mounted()
    call = ("run", "tiny.yaml", "--set", "load=50 N", "-o", disk / "a.nc")
    # Enough for the checkpoint of this small case, too little for its file.
    fill(disk, leaving=100_000)
    result = desk.call(*call)
    assert result.exit_code == 1
    assert f"{disk / 'a.nc'}: {FULL}" in result.stderr
    assert not (disk / "a.nc").exists()
    (disk / "filler").unlink()
    again = desk.call(*call)
    assert again.exit_code == 0
    assert [path.name for path in disk.iterdir()] == ["a.nc"]


@pytest.mark.parametrize(
    ("step", "named"), [("merge", "summary.nc"), ("figures", "figures/"), ("report", "report.html")]
)
def test_a_step_on_a_full_disk_says_so_and_spoils_nothing(
    finished_desk, desk, mounted, step, named
):
    disk = mounted()
    shutil.copytree(finished_desk.folder / "results", disk / "tiny")
    fill(disk, leaving=8_000)
    before = everything(disk)
    result = desk.call(step, "tiny.yaml", "--results", disk / "tiny")
    assert result.exit_code == 1
    assert f"{disk}/tiny/{named}" in result.stderr
    assert FULL in result.stderr
    assert everything(disk) == before


def test_a_folder_that_may_only_be_read_is_refused_before_anything_is_computed(
    finished_desk, desk, mounted
):
    disk = mounted()
    shutil.copytree(finished_desk.folder / "results", disk / "tiny")
    subprocess.run(["mount", "-o", "remount,ro", disk], check=True)
    calls = [
        (step, "tiny.yaml", "--results", disk / "tiny") for step in ("merge", "figures", "report")
    ]
    for call in [*calls, ("run", "tiny.yaml", "--set", "load=50 N", "-o", disk / "new/a.nc")]:
        result = desk.call(*call)
        assert result.exit_code == 2
        assert str(disk) in result.stderr
        assert "Read-only file system; choose another place" in result.stderr
        assert "cycle 0" not in result.stderr


def test_damage_that_shows_only_when_values_are_used_is_told(copied):
    """A checksum that fits keeps nobody from reading on; HDF5 has one more in each chunk."""
    summary = Path("results/tiny/summary.nc")
    content = bytearray(summary.read_bytes()[:-_LENGTH])
    for start in [found.start() for found in re.finditer(rb"x\x01", content)]:
        chunk = zlib.decompressobj()
        with suppress(zlib.error):  # it is none
            if len(chunk.decompress(content[start:])) > 20 and chunk.eof:
                content[start + 6] ^= 0xFF
    summary.write_bytes(content)
    add_checksum(summary)
    result = copied.call("figures", "tiny.yaml")
    assert result.exit_code == 1
    assert "NetCDF: HDF error" in result.stderr
    assert "defect" not in result.stderr


@pytest.mark.parametrize("then", [None, RuntimeError])
def test_memory_that_a_library_lacks_and_does_not_tell_of_ends_a_command(then):
    class Library:
        def __del__(self):
            raise MemoryError

    def work():
        with swallowing_no_lack_of_memory():
            Library()
            if then:
                raise then

    with pytest.raises(MemoryError):
        work()


@pytest.mark.parametrize(
    ("file", "damage", "step", "words"),
    [
        *(("summary.nc", flip, step, SUMMARY) for step in ("figures", "report")),
        *(
            (f"figures/{name}", damage, "report", "raw the figures")
            for name in ("index.json", "contact_half_width.svg")
            for damage in (Path.unlink, lambda path: path.write_bytes(b""))
        ),
    ],
)
def test_a_damaged_file_is_named_by_what_reads_it(copied, file, damage, step, words):
    damage(Path("results/tiny") / file)
    result = copied.call(step, "tiny.yaml")
    assert result.exit_code == 1
    assert f"results/tiny/{file}: " in result.stderr
    assert words in result.stderr
    assert "Traceback" not in result.stderr


@pytest.mark.parametrize(
    ("place", "where"),
    [
        ("results/tiny", "out of results, to"),
        ("results/tiny/figures", "to"),
        ("results/tiny/logs/simulate", "to"),
        ("results/tiny/logs/merge.log", "to"),
    ],
)
def test_a_link_out_of_the_results_is_refused(copied, tmp_path, place, where):
    Path("results/tiny/logs/simulate").mkdir(parents=True, exist_ok=True)
    Path("results/tiny/logs/merge.log").touch()
    elsewhere = tmp_path / "elsewhere"
    shutil.move(place, elsewhere)
    Path(place).symlink_to(elsewhere)
    before = everything(elsewhere)
    for step in ("batch", "merge", "figures", "report"):
        for option in [()] if place == "results/tiny" else [(), ("--results", "results/tiny")]:
            result = copied.call(step, "tiny.yaml", *option)
            assert result.exit_code == 2
            assert f"{place}: is a link that leads {where} {elsewhere}" in result.stderr
    assert everything(elsewhere) == before


def test_a_link_in_the_place_of_a_file_is_replaced_and_not_written_through(copied, tmp_path):
    precious = tmp_path / "precious"
    precious.write_text("mine")
    for name in ("a.nc", "a.checkpoint"):
        Path(name).symlink_to(precious)
    result = copied.call("run", "tiny.yaml", "--set", "load=50 N", "-o", "a.nc")
    assert result.exit_code == 0
    assert precious.read_text() == "mine"
    assert not Path("a.nc").is_symlink()
    # The folder of all results may be a link, and one among them too.
    shutil.move("results", tmp_path / "scratch")
    Path("results").symlink_to(tmp_path / "scratch")
    assert copied.call("merge", "tiny.yaml").exit_code == 0
    Path("results/tiny").rename("results/other")
    Path("results/tiny").symlink_to("other")
    assert copied.call("merge", "tiny.yaml").exit_code == 0
