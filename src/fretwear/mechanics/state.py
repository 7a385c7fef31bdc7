"""The contact after a number of cycles, and the problem that it belongs to."""

from __future__ import annotations

from dataclasses import dataclass, replace

from fretwear.mechanics.arrays import Array
from fretwear.mechanics.halfspace import HalfSpace, half_space
from fretwear.mechanics.slip import Friction, ReducedContact, SlipModel
from fretwear.mechanics.surfaces import Surface
from fretwear.mechanics.window import Window

CONTACT_TOLERANCE = 1e-6


@dataclass(frozen=True)
class WearProblem:
    """Two bodies under constant load and oscillating partial slip.

    Parameters
    ----------
    surface
        The unworn gap.
    composite_modulus
        E*, Pa.
    load
        Normal load P, N.
    friction
        Coulomb friction.
    slip_model
        How slip follows from the contact.
    wear_coefficient
        Archard's K_w, 1/Pa: worn depth per pressure and sliding distance.
    limit
        Largest pressure, Pa; infinite when elastic.
    spacing
        Cell size along x and y, m.
    extent
        Half-widths along x and y, m, of the first window.
    quarter
        Whether to compute the quarter x > 0, y > 0 only.
    workers
        Threads of one transform.
    """

    surface: Surface
    composite_modulus: float
    load: float
    friction: Friction
    slip_model: SlipModel
    wear_coefficient: float
    limit: float
    spacing: tuple[float, float]
    extent: tuple[float, float]
    quarter: bool = True
    workers: int = 1

    @property
    def growth_rate(self) -> float:
        """β = 4 K_w µκ, 1/Pa per cycle: relative growth of g* per unit pressure."""
        return 4.0 * self.wear_coefficient * self.friction.coefficient * self.friction.coupling

    def half_space(self, window: Window) -> HalfSpace:
        """The elastic bodies on a window."""
        return half_space(window, self.composite_modulus, self.workers)


@dataclass(frozen=True)
class State:
    """The contact after a number of cycles; all that a later step needs.

    Attributes
    ----------
    cycle
        Number of cycles N; between the requested ones not an integer.
    window
        Where the fields are given. Outside, nothing has touched yet.
    pressure, gap, wear, plastic
        p, Pa; gap, wear depth and plastic depth, m; shape of the window.
    approach
        δ, m.
    reduced
        The contact at the reduced load, from which slip follows.
    next_step
        Number of cycles that the next step should try.
    pressure_rate, source_rate
        How p, Pa, and G = g* − W, m, changed per cycle in the last step: where the next one
        starts to look.
    yielded
        Whether plastic flow changed the reduced contact in the last step.
    step
        How many steps were accepted so far.
    error_estimate
        Estimated error of the last step's wear relative to the wear volume.
    residual
        Largest violation of the gap conditions relative to the largest displacement.
    convolutions
        Half-space convolutions spent so far, rejected steps included.
    """

    cycle: float
    window: Window
    pressure: Array
    gap: Array
    wear: Array
    plastic: Array
    approach: float
    reduced: ReducedContact
    next_step: float
    pressure_rate: Array
    source_rate: Array
    yielded: bool = False
    step: int = 0
    error_estimate: float = 0.0
    residual: float = 0.0
    convolutions: int = 0

    def on(self, problem: WearProblem, window: Window) -> State:
        """The same state on a larger window; its gaps are computed where they were not known."""
        if window.shape == self.window.shape:
            return self
        old, shape = self.window, window.shape
        bodies, unworn = problem.half_space(window), problem.surface.shape(window)

        def gap(pressure: Array, approach: float, known: Array) -> Array:
            outer = bodies.displacement(old.resized(pressure, shape)) + unworn - approach
            outer[old.covered(shape)] = known.ravel()
            return outer

        if problem.slip_model.follows_shape:
            reduced = replace(
                self.reduced,
                pressure=old.resized(self.reduced.pressure, shape),
                gap=gap(self.reduced.pressure, self.reduced.approach, self.reduced.gap),
            )
        else:
            reduced = problem.slip_model.reduced(bodies, unworn)
        return replace(
            self,
            window=window,
            pressure=old.resized(self.pressure, shape),
            gap=gap(self.pressure, self.approach, self.gap),
            wear=old.resized(self.wear, shape),
            plastic=old.resized(self.plastic, shape),
            reduced=reduced,
            pressure_rate=old.resized(self.pressure_rate, shape),
            source_rate=old.resized(self.source_rate, shape),
            convolutions=self.convolutions + 2,
        )
