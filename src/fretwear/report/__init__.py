"""The report of a study: one self-contained HTML file, and its claims in numbers."""

from fretwear.report.answer import answer_text, answers
from fretwear.report.build import build_report
from fretwear.report.page import Section, macros

__all__ = ["Section", "answer_text", "answers", "build_report", "macros"]
