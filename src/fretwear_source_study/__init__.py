"""The study "Wear investigation of rough bodies in contact under partial slip conditions".

This package finds its cases in a merged study, judges its claims by numbers, draws its figures
under their original numbers, and writes its sections of the report.
"""
