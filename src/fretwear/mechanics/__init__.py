"""Mechanics of the contact: arrays in SI units in, arrays out (numpy and scipy only)."""
