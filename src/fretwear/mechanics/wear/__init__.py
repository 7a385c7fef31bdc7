"""Wear over the cycles: laws, stages, steps, strokes, and scalars of a state."""
