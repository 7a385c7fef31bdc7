"""The compiled kernels; what else there is to say about the package stands in pyproject.toml.

Without a C++ compiler the package is installed without them, and NumPy does the same.
"""

import sys

from pybind11.setup_helpers import Pybind11Extension
from setuptools import setup

# Vector instructions for the loops marked for them. No option that assumes finite values, because
# sums have to show those that are not.
FLAGS = ["-O3", "-fopenmp-simd", "-fno-math-errno", "-fno-trapping-math", "-fno-signed-zeros"]

setup(
    ext_modules=[
        Pybind11Extension(
            "fretwear.mechanics.compiled_kernels",
            ["src/fretwear/mechanics/kernels.cpp"],
            cxx_std=17,
            extra_compile_args=[] if sys.platform == "win32" else FLAGS,
            optional=True,
        )
    ]
)
