"""The first loading: the contact at cycle 0, before any wear."""

from __future__ import annotations

import numpy as np

from fretwear.mechanics.contact import solve_contact
from fretwear.mechanics.contact_problem import ContactProblem
from fretwear.mechanics.outlook import larger_window
from fretwear.mechanics.state import CONTACT_TOLERANCE, State, WearProblem
from fretwear.mechanics.window import Window, fast_shape

_FIRST_STEP = 0.09


def first_window(problem: WearProblem) -> Window:
    """The window that the first loading begins with."""
    shape = fast_shape(problem.extent, problem.spacing, quarter=problem.quarter)
    return Window(shape, problem.spacing, problem.quarter)


def first_loading(problem: WearProblem) -> State:
    """The state at cycle 0: loaded for the first time, yielded where it had to, unworn.

    Parameters
    ----------
    problem
        What to load.

    Raises
    ------
    fretwear.mechanics.contact.ContactError
        If the contact does not converge.
    """
    window, spent = first_window(problem), 0
    while True:
        bodies = problem.half_space(window)
        gap = problem.surface.shape(window)
        contact = solve_contact(
            ContactProblem(bodies, gap, problem.load, problem.limit), tolerance=CONTACT_TOLERANCE
        )
        spent += contact.convolutions
        larger = larger_window(problem, window, contact.pressure, contact.approach)
        if larger.shape == window.shape:
            break
        window = larger
    plastic = contact.penetration
    reduced = problem.slip_model.reduced(bodies, gap + plastic)
    return State(
        cycle=0.0,
        window=window,
        pressure=contact.pressure,
        gap=np.maximum(contact.gap, 0.0),
        wear=np.zeros(window.shape),
        plastic=plastic,
        approach=contact.approach,
        reduced=reduced,
        next_step=_FIRST_STEP / (problem.growth_rate * float(contact.pressure.max())),
        pressure_rate=np.zeros(window.shape),
        source_rate=np.zeros(window.shape),
        residual=contact.residual,
        convolutions=spent + reduced.convolutions,
    )
