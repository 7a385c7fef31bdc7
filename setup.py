"""The compiled kernels and the workspace; all else about the package stands in pyproject.toml."""

import shutil
from hashlib import sha256
from pathlib import Path

from pybind11.setup_helpers import Pybind11Extension
from setuptools import setup
from setuptools.command.bdist_wheel import bdist_wheel
from setuptools.command.build_ext import build_ext
from setuptools.command.build_py import build_py
from setuptools.errors import CompileError

# Vector instructions for the loops marked for them. No option that assumes finite values, because
# sums have to show those that are not.
FLAGS = ["-O3", "-fopenmp-simd", "-fno-math-errno", "-fno-trapping-math", "-fno-signed-zeros"]
# Two builds give the same bytes: the folder leaves no trace, nor do the rights of files, see below.
FLAGS += ["-g0", f"-ffile-prefix-map={Path.cwd()}=."]
FLAGS_OF_VISUAL = ["/O2", "/fp:precise"]


class BuildKernels(build_ext):
    """Compiles, or says what that takes."""

    def build_extension(self, ext: Pybind11Extension) -> None:
        """Build an extension."""
        if self.compiler.compiler_type == "msvc":
            ext.extra_compile_args = [*FLAGS_OF_VISUAL, *set(ext.extra_compile_args) - {*FLAGS}]
        try:
            super().build_extension(ext)
        except CompileError as error:
            raise CompileError(
                f"{error}\n\nfretwear needs a C++17 compiler (GCC, Clang, Visual C++) and "
                "Python's headers (on Debian and Ubuntu: apt install g++ python3-dev); its first "
                "message is above."
            ) from error


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


class ReproducibleWheel(bdist_wheel):
    """Packs files with the same rights, whatever those of the checkout."""

    def write_wheelfile(self, *given: str) -> None:
        """Write the last file before all are packed."""
        super().write_wheelfile(*given)
        for path in Path(self.bdist_dir).rglob("*"):
            if path.is_file():
                path.chmod(0o755 if path.suffix == ".so" else 0o644)


MECHANICS = Path("src/fretwear/mechanics")
SOURCES = sorted([*MECHANICS.glob("*.cpp"), *MECHANICS.glob("*.h")])
DIGEST = sha256(b"".join(source.read_bytes() for source in SOURCES)).hexdigest()

setup(
    cmdclass={
        "bdist_wheel": ReproducibleWheel,
        "build_ext": BuildKernels,
        "build_py": BuildWithWorkspace,
    },
    ext_modules=[
        Pybind11Extension(
            "fretwear.mechanics.kernels",
            [source.as_posix() for source in SOURCES if source.suffix == ".cpp"],
            depends=[source.as_posix() for source in SOURCES],
            cxx_std=17,
            # A library left from other sources tells itself by this.
            define_macros=[("SOURCE_SHA256", f'"{DIGEST}"')],
            extra_compile_args=FLAGS,
        )
    ],
)
