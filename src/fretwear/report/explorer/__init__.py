"""The explorer of a report: cases to choose, cycles to walk through, profiles to compare."""

from fretwear.report.explorer.build import Explorer, build_explorer

__all__ = ["Explorer", "build_explorer"]
