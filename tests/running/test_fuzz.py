"""Whatever valid case is run, its pressure pushes, carries the load, and wear takes away.

The parameters are drawn as the ratios that matter, from where they are harmless to where the
checks of a case draw the line, on grids as coarse as these allow.
"""

import math

import numpy as np
from hypothesis import HealthCheck, assume, event, given, settings
from hypothesis import strategies as st

import fretwear
from fretwear.mechanics.contact import ContactError
from fretwear.mechanics.geometry import Workspace
from fretwear.mechanics.integrator import WearError
from fretwear.mechanics.roughness import WavyRoughness
from fretwear.running import simulate
from fretwear.study.case import CaseError
from fretwear.study.cost import estimate
from fretwear.study.rules import (
    LEAST_CELLS_PER_CONTACT_RADIUS,
    LEAST_CELLS_PER_SLIP_ANNULUS,
    LEAST_CELLS_PER_STICK_RADIUS,
)

MOST_CELLS = 40_000
MOST_STEPS = 150
# What the suite can afford out of the examples of the profile.
SHARE = 10

# The tolerance of the normal contact allows this much of a load; storing in single precision too.
LOAD_TOLERANCE = 1e-6


def powers(low, high):
    """Numbers from 10^low to 10^high, evenly by their logarithm."""
    return st.floats(low, high).map(lambda exponent: 10.0**exponent)


@st.composite
def waves(draw, contact_radius, radius):
    """Roughness up to three times the Hertz approach, of waves from half to five contact radii."""
    amplitude = draw(powers(-3, 0.5)) * contact_radius**2 / radius
    slopes = [
        0.0
        if draw(st.integers(0, 5)) == 0
        else math.atan(4.0 * amplitude / (length * contact_radius))
        for length in (draw(powers(-0.3, 0.7)), draw(powers(-0.3, 0.7)))
    ]
    assume(any(slopes))
    return {"amplitude": amplitude, "slope_x": slopes[0], "slope_y": slopes[1]}


@st.composite
def cases(draw):
    """Valid cases of any size and stiffness that take a few seconds at most."""
    radius, modulus = draw(powers(-5, 1)), draw(powers(4, 13))
    ratio = st.one_of(st.just(0.3), st.floats(-0.99, 0.5))
    parameters = {
        "radius": radius,
        "youngs_modulus": draw(
            st.one_of(st.just(modulus), st.tuples(st.just(modulus), powers(4, 13)))
        ),
        "poisson_ratio": draw(st.one_of(ratio, st.tuples(ratio, ratio))),
        "tangential_ratio": draw(st.one_of(st.floats(0.07, 0.999), st.just(0.8))),
        "friction": draw(powers(-3, 1)),
        "tolerance": draw(powers(-5, -1)),
        "slip_model": draw(st.sampled_from(["jaeger", "cattaneo_mindlin"])),
        "cycles": draw(powers(0, 6).map(round)),
    }
    # E* and with it the load that gives a contact of the size that is wanted.
    modulus = composite_modulus(parameters)
    contact_radius = draw(powers(-4, math.log10(0.199))) * radius
    load = 4.0 * modulus * contact_radius**3 / (3.0 * radius)
    pressure = 1.5 * load / (math.pi * contact_radius**2)
    parameters["load"] = load
    if draw(st.booleans()):
        parameters["plastic_limit"] = draw(powers(-2, 1)) * pressure
    if draw(st.booleans()):
        parameters["roughness"] = draw(waves(contact_radius, radius))
    parameters["output_cycles"] = draw(st.lists(st.integers(0, parameters["cycles"]), max_size=3))
    parameters["wear_coefficient"] = 1.0
    smooth = valid({**parameters, "roughness": None})
    # Wear over the whole run from nothing to where little more happens: N 4 K_w µκ p0.
    largest = 2.0 if "plastic_limit" in parameters else 5.0
    growth = draw(powers(-4, largest)) / (parameters["cycles"] * pressure)
    parameters["wear_coefficient"] = growth / (4.0 * parameters["friction"] * smooth.coupling)
    parameters["cell"] = cell(smooth, valid({**parameters, "cell": None}).roughness, draw)
    case = valid(parameters)
    assume(estimate(case).cells <= MOST_CELLS)
    return case


def composite_modulus(parameters):
    """E* of elastic constants, by the case itself."""
    return fretwear.Case(
        **{**parameters, "load": 1e-30, "wear_coefficient": 1.0, "radius": 1.0}
    ).composite_modulus


def valid(parameters):
    """The case of the parameters; what the checks refuse is no example."""
    try:
        return fretwear.Case(**parameters)
    except CaseError:
        assume(False)


def cell(smooth, roughness, draw):
    """A spacing as coarse as the case allows, or up to eight times finer."""
    radius, stick = smooth.hertz_radius, smooth.stick_radius
    coarsest = min(
        radius / LEAST_CELLS_PER_CONTACT_RADIUS,
        stick / LEAST_CELLS_PER_STICK_RADIUS,
        (radius - stick) / LEAST_CELLS_PER_SLIP_ANNULUS,
    )
    lengths = (
        (math.inf,) * 2 if roughness is None else (roughness.wavelength_x, roughness.wavelength_y)
    )
    return tuple(
        draw(st.floats(0.12, 1.0)) * min(coarsest, 2.0 * length / WavyRoughness.cells)
        for length in lengths
    )


class EnoughError(Exception):
    """The run has shown enough."""


class Inspector:
    """An observer that compares each step with what no step may break, and with the one before."""

    def __init__(self, case):
        self.case = case
        self.problem = simulate.wear_problem(case)
        self.before = None

    def __call__(self, step):
        state, case = step.state, self.case
        for name in ("pressure", "gap", "wear", "plastic"):
            assert np.isfinite(getattr(state, name)).all(), name
        assert all(map(math.isfinite, vars(step.measures).values()))
        assert state.pressure.min() >= 0.0, "negative pressure"
        assert state.pressure.max() <= case.plastic_limit * (1.0 + 1e-9)
        carried = state.geometry.integral(state.pressure)
        assert abs(carried - case.load) <= LOAD_TOLERANCE * case.load, "lost load"
        assert state.gap.min() >= -1e-5 * abs(state.approach), "bodies overlap"
        assert step.measures.contact_area > 0.0
        if case.slip_model.kind == "jaeger":
            assert 0.0 < step.measures.stick_area <= step.measures.contact_area
        assert state.reduced.gap.min() >= 0.0, "negative slip"
        self._compare(state)
        self.before = state
        if state.step >= MOST_STEPS:
            raise EnoughError

    def _compare(self, state):
        if self.before is None:
            assert not state.wear.any()
            return
        assert state.cycle > self.before.cycle
        before = self.before.on(Workspace(self.problem), state.geometry)
        for name in ("wear", "plastic"):
            grown = getattr(state, name) - getattr(before, name)
            assert grown.min() >= -1e-12 * max(getattr(state, name).max(), 1e-300), (
                f"{name} shrinks"
            )


def check_dataset(dataset, case):
    """What holds of every step holds of the result."""
    for name in ("pressure", "wear_depth", "wear_rate", "slip", "plastic_depth"):
        values = dataset[name].to_numpy()
        assert np.isfinite(values).all(), name
        assert values.min() >= 0.0, name
    depth = dataset["wear_depth"].to_numpy()
    # Rings that follow the stick edge keep what is worn in all, not on each part of a cell.
    assert np.diff(depth, axis=0).min() >= (-1e-3 * depth.max() if case.is_on_rings else 0.0)
    assert (np.diff(dataset["wear_volume"].to_numpy()) >= 0.0).all()
    area = 4.0 * math.prod(case.grid_spacing)
    carried = dataset["pressure"].sum(("x", "y"), dtype=np.float64).to_numpy() * area
    np.testing.assert_allclose(carried, case.load, rtol=LOAD_TOLERANCE)


@settings(
    max_examples=max(1, settings.default.max_examples // SHARE),
    suppress_health_check=list(HealthCheck),
)
@given(case=cases())
def test_no_valid_case_pulls_or_drops_the_load_or_heals(case):
    inspect = Inspector(case)
    try:
        dataset = simulate.simulate(case, [inspect], quarter=True)
    except (ContactError, WearError) as error:
        # A run may end with a message where a solution is not found; it never goes on without.
        event(f"ended: {type(error).__name__}")
    except EnoughError:
        event("long")
    else:
        event("done")
        check_dataset(dataset, case)
    event("rough" if case.roughness else "smooth")
    event("plastic" if math.isfinite(case.plastic_limit) else "elastic")
    event(case.slip_model)
