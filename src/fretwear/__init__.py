"""Fretting wear of rough, yielding bodies in partial slip."""

__version__ = "0.1.0"
