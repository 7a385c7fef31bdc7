"""What ``fretwear init`` writes goes into the wheel; all else stands in pyproject.toml."""

import shutil
import sys
from pathlib import Path

# pip would compare the versions of all dependencies first, and complain of one of these.
if sys.version_info < (3, 11):  # noqa: UP036
    have = ".".join(map(str, sys.version_info[:3]))
    sys.exit(
        f"fretwear needs Python 3.11 or newer, and this is Python {have}: install a newer one with "
        "venv, remove the folder .venv, and repeat the command with it, as python3.11 -m venv .venv"
    )

from setuptools import setup
from setuptools.command.build_py import build_py


class BuildWithWorkspace(build_py):
    """Copies the workspace, which a checkout has at its root, into the package."""

    def run(self) -> None:
        """Build the package, then copy."""
        super().run()
        if not self.editable_mode:
            workspace = Path(self.build_lib, "fretwear", "workspace")
            for folder in ("profiles", "studies"):
                shutil.copytree(folder, workspace / folder, dirs_exist_ok=True)
            shutil.copy("Snakefile", workspace)


setup(cmdclass={"build_py": BuildWithWorkspace})
