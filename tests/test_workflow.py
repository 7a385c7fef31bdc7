import json
import re
import shutil
import subprocess
import sys
from pathlib import Path

import pytest
import yaml

import fretwear
from fretwear.data.merge import open_summary
from fretwear.study.file import StudyError
from fretwear.workflow import StudyJobs, study_file

REPOSITORY = Path(__file__).parents[1]

TINY = {
    "title": "Tiny",
    "base": {
        "radius": "10 mm",
        "youngs_modulus": "208 GPa",
        "poisson_ratio": 0.3,
        "tangential_load": "9 N",
        "friction": 0.5,
        "wear_coefficient": "7e-13 / Pa",
        "plastic_limit": "none",
        "roughness": "none",
        "cycles": 100,
        "cell": "10 um",
    },
    "vary": {"load": ["25 N", "50 N"]},
    "output": {"cycles": [0, 20]},
}


class Checkout:
    """A folder with the workflow and studies, as a user has it."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder

    @classmethod
    def make(cls, folder: Path) -> "Checkout":
        shutil.copy(REPOSITORY / "Snakefile", folder)
        shutil.copytree(REPOSITORY / "profiles", folder / "profiles")
        checkout = cls(folder)
        checkout.write(TINY)
        return checkout

    def write(self, content, name="demo") -> None:
        file = self.folder / "studies" / f"{name}.yaml"
        file.parent.mkdir(exist_ok=True)
        file.write_text(yaml.safe_dump(content, sort_keys=False), encoding="utf-8")

    def snakemake(self, *arguments):
        return subprocess.run(
            [sys.executable, "-m", "snakemake", "--cores", "2", *arguments],
            cwd=self.folder,
            capture_output=True,
            text=True,
            check=False,
        )

    def jobs(self, *arguments):
        """What a run would do: slugs of the cases to simulate one by one, and the other rules."""
        done = self.snakemake("--dry-run", *arguments)
        assert done.returncode == 0, done.stderr
        messages = re.findall(r"^Job \d+: (.*)$", done.stdout + done.stderr, re.MULTILINE)
        cases = {
            line.split()[1].split("-mu")[0] for line in messages if line.startswith("Simulating")
        }
        others = {line.split()[0] for line in messages} - {"Simulating"}
        return cases, others

    @property
    def results(self):
        return self.folder / "results/demo"


AFTERWARDS = {"Merging", "Drawing", "Writing"}


@pytest.fixture(scope="module")
def finished(tmp_path_factory):
    checkout = Checkout.make(tmp_path_factory.mktemp("finished"))
    done = checkout.snakemake()
    assert done.returncode == 0, done.stdout + done.stderr
    return checkout


@pytest.fixture
def copy(finished, tmp_path):
    """A copy of the finished study with everything that Snakemake remembers of it."""
    return Checkout(shutil.copytree(finished.folder, tmp_path / "copy"))


@pytest.fixture
def fresh(tmp_path):
    return Checkout.make(tmp_path)


@pytest.mark.slow
def test_a_study_ends_in_datasets_figures_and_a_report(finished):
    cases = sorted(path.stem for path in (finished.results / "cases").iterdir())
    assert [name.split("-mu")[0] for name in cases] == ["P25N-Q9N", "P50N-Q9N"]
    for name in cases:
        with fretwear.open_case(finished.results / "cases" / f"{name}.nc") as case:
            assert list(case["cycle"].values) == [0, 20, 100]
        log = (finished.results / "logs/simulate" / f"{name}.log").read_text()
        assert log.startswith(f"case {name}\n")
    benchmarks = list((finished.results / "benchmarks/batches").glob("*.tsv"))
    assert len(benchmarks) == 2
    assert benchmarks[0].read_text().startswith("s\th:m:s\tmax_rss")
    with open_summary(finished.results / "summary.nc") as summary:
        assert (summary["status"] == 0).all()
        assert (summary["wear_volume"].isel(cycle=-1) > 0).all()
    points = (finished.results / "points.csv").read_text(encoding="utf-8").splitlines()
    assert len(points) == 3
    figures = {path.suffix for path in (finished.results / "figures").glob("contact_half_width*")}
    assert figures == {".svg", ".png"}
    page = (finished.results / "report.html").read_text(encoding="utf-8")
    assert all(name in page for name in cases)


@pytest.mark.slow
def test_an_unchanged_study_has_nothing_to_do(finished):
    done = finished.snakemake("--dry-run")
    assert done.returncode == 0
    assert "Nothing to be done" in done.stdout + done.stderr


@pytest.mark.slow
def test_a_comment_in_the_study_file_changes_nothing(copy):
    file = copy.folder / "studies/demo.yaml"
    file.write_text(f"# measured in spring\n{file.read_text()}")
    assert copy.jobs() == (set(), set())


@pytest.mark.slow
def test_a_changed_value_reruns_the_cases_it_touches(copy):
    copy.write({**TINY, "vary": {"load": ["25 N", "60 N"]}})
    assert copy.jobs() == ({"P60N-Q9N"}, AFTERWARDS)
    copy.write({**TINY, "base": {**TINY["base"], "friction": 0.6}})
    assert copy.jobs() == ({"P25N-Q9N", "P50N-Q9N"}, AFTERWARDS)


@pytest.mark.slow
def test_an_extended_study_computes_the_new_case_only(copy):
    copy.write({**TINY, "vary": {"load": ["25 N", "30 N", "50 N"]}})
    assert copy.jobs() == ({"P30N-Q9N"}, AFTERWARDS)
    kept = sorted((copy.results / "cases").iterdir())
    before = [path.stat().st_mtime_ns for path in kept]
    done = copy.snakemake()
    assert done.returncode == 0, done.stderr
    assert [path.stat().st_mtime_ns for path in kept] == before
    with open_summary(copy.results / "summary.nc") as summary:
        assert list(summary["load"].values) == [25.0, 30.0, 50.0]
        assert (summary["status"] == 0).all()
    assert copy.jobs() == (set(), set())


@pytest.mark.slow
def test_other_snapshots_rerun_the_cases_which_keep_their_ids(copy):
    copy.write({**TINY, "output": {"cycles": [0, 30]}})
    assert copy.jobs() == ({"P25N-Q9N", "P50N-Q9N"}, AFTERWARDS)


@pytest.mark.slow
def test_another_title_reruns_no_case(copy):
    copy.write({**TINY, "title": "Two loads"})
    assert copy.jobs() == (set(), AFTERWARDS)


@pytest.mark.slow
def test_another_version_of_the_package_reruns_everything(copy):
    file = copy.folder / "Snakefile"
    text = file.read_text().replace("try:", "import fretwear\nfretwear.__version__ = '0'\ntry:", 1)
    file.write_text(text)
    assert copy.jobs() == ({"P25N-Q9N", "P50N-Q9N"}, AFTERWARDS)


@pytest.mark.slow
def test_an_invalid_point_stops_the_study_before_any_job(fresh):
    fresh.write({**TINY, "vary": {"load": ["50 N", "15 N"]}})
    done = fresh.snakemake()
    assert done.returncode != 0
    message = done.stdout + done.stderr
    assert "studies/demo.yaml: base.tangential_load = 9 N" in message
    assert "gross sliding" in message
    assert "load = 15 N" in message
    assert "Traceback" not in message
    assert not fresh.results.exists()


@pytest.mark.slow
def test_a_results_folder_that_cannot_be_written_stops_the_study_before_any_job(fresh):
    fresh.write(TINY)
    fresh.results.parent.parent.mkdir(parents=True, exist_ok=True)
    fresh.results.parent.write_text("not a folder")
    done = fresh.snakemake()
    assert done.returncode != 0
    message = done.stdout + done.stderr
    assert "results/demo: cannot be written to, because" in message
    assert "Traceback" not in message


@pytest.mark.slow
def test_another_study_is_chosen_by_name_or_path(fresh):
    fresh.write({**TINY, "vary": {"load": ["40 N"]}}, "other")
    assert fresh.jobs("--config", "study=other")[0] == {"P40N-Q9N"}
    assert fresh.jobs("--config", "study=studies/other.yaml")[0] == {"P40N-Q9N"}
    done = fresh.snakemake("--config", "study=othr")
    assert done.returncode != 0
    assert "studies/othr.yaml: there is no such file" in done.stdout + done.stderr


@pytest.mark.slow
def test_the_report_of_the_workflow_itself_holds_the_figures(copy):
    done = copy.snakemake("--report", "workflow.html")
    assert done.returncode == 0, done.stderr
    page = (copy.folder / "workflow.html").read_text(encoding="utf-8")
    assert "contact_half_width" in page


def test_a_study_is_given_by_name_or_by_path(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    assert study_file("paper") == Path("studies/paper.yaml")
    assert study_file("loads-1.5") == Path("studies/loads-1.5.yaml")
    assert study_file("mine/own.yaml") == Path("mine/own.yaml")
    assert study_file("own.yaml") == Path("studies/own.yaml")
    Path("own.yaml").touch()
    assert study_file("own.yaml") == Path("own.yaml")


@pytest.fixture
def jobs(fresh, monkeypatch):
    """The jobs of a study with this content."""
    monkeypatch.chdir(fresh.folder)

    def of(content, name="demo"):
        fresh.write(content, name)
        return StudyJobs.of(name)

    return of


def test_a_job_depends_on_all_that_its_files_hold(jobs, monkeypatch):
    names = [set(jobs(TINY).batches)]
    base = {**TINY["base"], "friction": 0.6}
    names.append(set(jobs({**TINY, "base": base}).batches))
    names.append(set(jobs({**TINY, "output": {"cycles": [0, 30]}}).batches))
    monkeypatch.setattr(fretwear, "__version__", "0.0.0")
    names.append(set(jobs(TINY).batches))
    assert sum(map(len, names)) == len(set.union(*names)) == 8


def test_what_follows_depends_on_the_study_but_not_on_its_batches(jobs):
    content = json.loads(jobs(TINY).content)
    assert content == TINY
    assert jobs({**TINY, "batch": 2}).content == jobs(TINY).content
    assert jobs({**TINY, "title": "Other"}).content != jobs(TINY).content


def test_a_job_asks_for_more_than_the_plan_expects(jobs):
    small = jobs(TINY)
    large = jobs({**TINY, "base": {**TINY["base"], "cell": "0.5 um", "cycles": 30000}}, "large")
    for first, second in zip(small.targets, large.targets, strict=True):
        assert 100 < small.memory_mb(first) < large.memory_mb(second)
        assert 5 < small.minutes(first) <= large.minutes(second)
        assert small.priority(first) < large.priority(second)


def test_a_job_of_several_cases_asks_for_the_memory_of_the_largest_and_the_time_of_all(jobs):
    single = jobs(TINY)
    (target,) = jobs({**TINY, "batch": 2}).targets
    both = jobs({**TINY, "batch": 2})
    assert both.points(target) == "1-2"
    assert both.memory_mb(target) == max(single.memory_mb(each) for each in single.targets)
    assert both.batch(target).seconds == sum(single.batch(t).seconds for t in single.targets)


def test_an_unsound_study_has_no_jobs(jobs):
    with pytest.raises(StudyError, match="larger than 0"):
        jobs({**TINY, "vary": {"load": ["-1 N"]}})
