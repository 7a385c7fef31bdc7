"""The report of a study: one HTML file that needs nothing else."""

from fretwear.report.build import build_report
from fretwear.report.page import Section, environment

__all__ = ["Section", "build_report", "environment"]
