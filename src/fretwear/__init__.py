"""Fretting wear of rough, yielding bodies in partial slip."""

from __future__ import annotations

import os
from importlib import import_module
from typing import TYPE_CHECKING, Any

from fretwear.plugins import plugins
from fretwear.version import __version__

# HDF5 reads this when it is loaded. Otherwise it would refuse to open files on file systems without
# locks. Files are complete or absent, so its locks guard nothing here.
os.environ.setdefault("HDF5_USE_FILE_LOCKING", "FALSE")

if TYPE_CHECKING:
    from fretwear import figures
    from fretwear.data.files import open_case, open_history, open_loops
    from fretwear.data.stack import open_study
    from fretwear.mechanics.surfaces.roughness import WavyRoughness
    from fretwear.run.simulate import ResultWarning, simulate
    from fretwear.study.case import Case
    from fretwear.study.reading import load_study

__all__ = [
    "Case",
    "ResultWarning",
    "WavyRoughness",
    "__version__",
    "figures",
    "load_study",
    "open_case",
    "open_history",
    "open_loops",
    "open_study",
    "simulate",
]

_HOMES = {
    "ResultWarning": "fretwear.run.simulate",
    "Case": "fretwear.study.case",
    "WavyRoughness": "fretwear.mechanics.surfaces.roughness",
    "load_study": "fretwear.study.reading",
    "open_case": "fretwear.data.files",
    "open_history": "fretwear.data.files",
    "open_loops": "fretwear.data.files",
    "open_study": "fretwear.data.stack",
    "simulate": "fretwear.run.simulate",
}


def __getattr__(name: str) -> Any:
    # Numerics and labelled arrays take about a second to import, and are imported on demand.
    if name in _HOMES:
        return getattr(import_module(_HOMES[name]), name)
    if name == "figures":
        return import_module("fretwear.figures")
    if door := plugins("fretwear.doors").get(name):
        return door.load()
    raise AttributeError(f"module 'fretwear' has no attribute {name!r}")


def __dir__() -> list[str]:
    return sorted([*__all__, *plugins("fretwear.doors")])
