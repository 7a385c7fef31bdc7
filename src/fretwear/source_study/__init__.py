"""The study "Wear investigation of rough bodies in contact under partial slip conditions".

Its cases in a merged study, its claims judged by numbers, its figures under their original numbers,
and its sections of the report.
"""
