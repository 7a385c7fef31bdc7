"""The report of a study: one HTML file that needs nothing else."""

from fretwear.report.build import Section, build_report

__all__ = ["Section", "build_report"]
