import re
import subprocess
from datetime import UTC, datetime

import fretwear
from fretwear.data import dataset as provenance


def test_source_names_the_version_and_the_commit_of_a_checkout():
    assert re.fullmatch(
        rf"fretwear {re.escape(fretwear.__version__)}( \(commit [0-9a-f]{{7,}}(-dirty)?\))?",
        provenance.source(),
    )


def test_an_unrelated_repository_around_the_package_is_not_taken_for_ours(tmp_path):
    subprocess.run(["git", "init", "-q", tmp_path], check=True)
    assert provenance._commit(tmp_path) is None


def test_history_line_has_the_time_in_utc_and_the_command():
    time, command = provenance.history_line("fretwear run demo.yaml").split(" ", 1)
    assert abs((datetime.now(UTC) - datetime.fromisoformat(time)).total_seconds()) < 60
    assert command == "fretwear run demo.yaml"


def test_a_checkout_gives_its_commit_and_says_when_it_was_changed(tmp_path):
    module = tmp_path / "src" / "fretwear" / "module.py"
    module.parent.mkdir(parents=True)
    module.write_text("a = 1\n")
    git = ["git", "-C", tmp_path, "-c", "user.name=a", "-c", "user.email=a@b.invalid"]
    subprocess.run([*git, "init", "-q"], check=True)
    subprocess.run([*git, "add", "."], check=True)
    subprocess.run([*git, "commit", "-q", "-m", "first"], check=True)
    head = subprocess.run([*git, "rev-parse", "HEAD"], check=True, capture_output=True, text=True)
    assert provenance._commit(tmp_path) == head.stdout[:12]
    module.write_text("a = 2\n")
    assert provenance._commit(tmp_path) == head.stdout[:12] + "-dirty"
