"""Stresses below the surface of the flat, over a cycle, and what they say of cracks.

The flat is the half-space z > 0: z is a depth, counted positive downwards, and x and y are as in
the contact. Tension is positive. At +Q the shear traction pulls the flat along +x, so that its
surface is in tension behind the contact, at x < 0, and σ_xz = −q below it. The indenter has the
same stresses at its own depth, with +Q and −Q exchanged and its own Poisson's ratio.
"""


class StressError(ValueError):
    """Stresses cannot be computed from what was given; the message says why and what to do."""
