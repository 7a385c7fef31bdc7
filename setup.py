"""What ``fretwear init`` writes goes into the wheel; all else stands in pyproject.toml."""

import shutil
from pathlib import Path

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
