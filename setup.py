"""The compiled kernels and the workspace; all else about the package stands in pyproject.toml.

Without a C++ compiler the package is installed without them, and NumPy does the same.
"""

import shutil
import sys
from hashlib import sha256
from pathlib import Path

from pybind11.setup_helpers import Pybind11Extension
from setuptools import setup
from setuptools.command.build_py import build_py

# Vector instructions for the loops marked for them. No option that assumes finite values, because
# sums have to show those that are not.
FLAGS = ["-O3", "-fopenmp-simd", "-fno-math-errno", "-fno-trapping-math", "-fno-signed-zeros"]


class BuildWithWorkspace(build_py):
    """Copies what ``fretwear init`` writes into the package; a checkout has it at its root."""

    def run(self) -> None:
        """Build the package, then copy."""
        super().run()
        if not self.editable_mode:
            workspace = Path(self.build_lib, "fretwear", "workspace")
            for folder in ("profiles", "studies"):
                shutil.copytree(folder, workspace / folder, dirs_exist_ok=True)
            shutil.copy("Snakefile", workspace)


MECHANICS = Path("src/fretwear/mechanics")
SOURCES = [MECHANICS / name for name in ("kernels.cpp", "threads.h", "transforms.h")]
DIGEST = sha256(b"".join(source.read_bytes() for source in SOURCES)).hexdigest()

setup(
    cmdclass={"build_py": BuildWithWorkspace},
    ext_modules=[
        Pybind11Extension(
            "fretwear.mechanics.compiled_kernels",
            [SOURCES[0].as_posix()],
            depends=[source.as_posix() for source in SOURCES],
            cxx_std=17,
            # A library left from other sources tells itself by this.
            define_macros=[("KERNELS_SHA256", f'"{DIGEST}"')],
            extra_compile_args=[] if sys.platform == "win32" else FLAGS,
            optional=True,
        )
    ],
)
