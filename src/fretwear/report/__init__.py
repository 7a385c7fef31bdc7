"""The report of a study: one self-contained HTML file, and the effects of its parameters as JSON.

The first screen is a matrix of results and parameters with the curve of one of its cells; then come
figures, an explorer of profiles, the sections that packages add, and behind folds the cases and how
they were computed.

A package adds sections by an entry point in the group ``fretwear.sections``: a function of the
merged study and of the folder of its case files, which yields a `Section` for each::

    def sections(summary: xr.Dataset, cases: Path) -> Iterator[Section]:
        body = Markup("<p>Best values.</p>") + table_html(frame)
        yield Section("fit", "Fit to measurements", body, figures=("fit_0", "fit_1"))
"""

from fretwear.report.build import Section, answer_text, build_report, table_html

__all__ = ["Section", "answer_text", "build_report", "table_html"]
