"""The study "Wear investigation of rough bodies in contact under partial slip conditions".

Its cases among those of a merged study, its claims judged by numbers, its figures under their
numbers, and the sections of the report that tell them.
"""
