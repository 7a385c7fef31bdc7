"""Passes over the cells of a window: the arithmetic between two transforms.

Each function goes over its fields once, where NumPy goes over them once for each operation. They
are compiled from ``compiled.cpp`` when the package is installed where there is a C++ compiler;
elsewhere `fretwear.mechanics.passes.in_numpy` does the same to rounding, in more time, and says
what each of them is. `COMPILED` tells which.
"""

from typing import TYPE_CHECKING

from fretwear.mechanics.passes.in_numpy import *  # noqa: F403 - the module lists what it offers

COMPILED: bool = False
if not TYPE_CHECKING:
    try:
        from fretwear.mechanics.passes.compiled import *  # noqa: F403

        COMPILED = True
    except ImportError:
        pass
