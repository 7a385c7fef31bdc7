"""Where a dataset comes from: version and commit of the package, time and command."""

from __future__ import annotations

import os
import subprocess
from datetime import UTC, datetime
from functools import cache
from pathlib import Path

import fretwear


@cache
def source() -> str:
    """Package name and version, with the commit when the package runs from a checkout."""
    version = f"fretwear {fretwear.__version__}"
    commit = _commit(Path(fretwear.__file__).resolve().parents[2])
    return f"{version} (commit {commit})" if commit else version


def history_line(command: str) -> str:
    """One line of the CF ``history`` attribute: time in UTC, then the command."""
    return f"{datetime.now(UTC).isoformat(timespec='seconds')} {command}"


def _commit(root: Path) -> str | None:
    # An installed package may lie inside a checkout of something else (a virtual environment in
    # a user's project), so only a repository with our own sources at its root counts.
    if not (root / ".git").exists() or not (root / "src" / "fretwear").is_dir():
        return None
    try:
        answer = subprocess.run(
            [
                "git",
                "-C",
                str(root),
                "describe",
                "--always",
                "--dirty",
                "--abbrev=12",
                "--exclude=*",
            ],
            capture_output=True,
            text=True,
            timeout=5,
            check=True,
            env={**os.environ, "GIT_OPTIONAL_LOCKS": "0"},
        )
    except (OSError, subprocess.SubprocessError):
        return None
    return answer.stdout.strip() or None
