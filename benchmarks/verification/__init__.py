"""The comparisons behind ``docs/verification.md``; run ``python -m benchmarks.verification``.

Each module is one section of the page: it measures, judges, tabulates and draws. What was
measured is kept in ``docs/verification.json``, from which the page is written.
"""
