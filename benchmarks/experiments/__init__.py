"""Published experiments and what fretwear computes; run ``python -m benchmarks.experiments``.

Each section of the page docs/experiments.md runs the study of one experiment,
``studies/experiments/*.yaml``, and compares it with the measurements beside that file.
"""
