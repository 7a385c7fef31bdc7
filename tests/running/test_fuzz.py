"""Whatever valid case is run, its pressure pushes, carries the load, and wear takes away.

The parameters are drawn as the ratios that matter, from where they are harmless to where the
checks of a case draw the line, on grids as coarse as these allow.
"""

import math

import numpy as np
from hypothesis import HealthCheck, assume, event, given, settings
from hypothesis import strategies as st

from fretwear.mechanics.contact import ContactError
from fretwear.mechanics.geometry import Workspace
from fretwear.mechanics.integrator import WearError
from fretwear.mechanics.roughness import WavyRoughness
from fretwear.running import simulate
from fretwear.study import rules
from fretwear.study.case import Case, CaseError
from fretwear.study.plan import estimate

MOST_CELLS, MOST_STEPS = 40_000, 150
# The tolerance of the normal contact allows this much of a load; storing in single precision too.
LOAD_TOLERANCE = 1e-6


def powers(low, high):
    """Numbers from 10^low to 10^high, evenly by their logarithm."""
    return st.floats(low, high).map(lambda exponent: 10.0**exponent)


def valid(given, **changes):
    """The case of the parameters; what the checks refuse is no example."""
    try:
        return Case(**{**given, **changes})
    except CaseError:
        assume(False)


@st.composite
def cases(draw):
    """Valid cases of any size and stiffness that take a few seconds at most."""
    radius, modulus, ratio = (
        draw(powers(-5, 1)),
        powers(4, 13),
        st.floats(-0.99, 0.5) | st.just(0.3),
    )
    given = {
        "radius": radius,
        "youngs_modulus": draw(modulus | st.tuples(modulus, modulus)),
        "poisson_ratio": draw(ratio | st.tuples(ratio, ratio)),
        "tangential_ratio": draw(st.floats(0.07, 0.999) | st.just(0.8)),
        "friction": draw(powers(-3, 1)),
        "tolerance": draw(powers(-5, -1)),
        "slip_model": draw(st.sampled_from(["jaeger", "cattaneo_mindlin"])),
        "cycles": draw(powers(0, 6).map(round)),
        "wear_coefficient": 1.0,
    }
    given["output_cycles"] = draw(st.lists(st.integers(0, given["cycles"]), max_size=3))
    # The load of a contact of the size that is wanted.
    size = draw(powers(-4, math.log10(0.199))) * radius
    modulus = valid(given, load=1e-30, radius=1.0).composite_modulus
    given["load"] = 4.0 * modulus * size**3 / (3.0 * radius)
    pressure = 1.5 * given["load"] / (math.pi * size**2)
    if draw(st.booleans()):
        given["plastic_limit"] = draw(powers(-2, 1)) * pressure
    smooth, lengths = valid(given), (math.inf, math.inf)
    if draw(st.booleans()):
        # Up to three times the Hertz approach high, from half to five contact radii long.
        height = draw(powers(-3, 0.5)) * size**2 / radius
        longest = powers(-0.3, 0.7).map(lambda length: math.atan(4.0 * height / (length * size)))
        slopes = draw(st.tuples(*[st.just(0.0) | longest] * 2).filter(any))
        given["roughness"] = {"amplitude": height, "slope_x": slopes[0], "slope_y": slopes[1]}
        rough = valid(given).roughness
        lengths = rough.wavelength_x, rough.wavelength_y
    # Wear over the whole run from nothing to where little more happens: N 4 K_w µκ p0.
    largest = 2.0 if "plastic_limit" in given else 5.0
    growth = draw(powers(-4, largest)) / (given["cycles"] * pressure)
    given["wear_coefficient"] = growth / (4.0 * given["friction"] * smooth.coupling)
    # A spacing as coarse as the case allows, or up to eight times finer.
    coarsest = min(
        size / rules.LEAST_CELLS_PER_CONTACT_RADIUS,
        smooth.stick_radius / rules.LEAST_CELLS_PER_STICK_RADIUS,
        (size - smooth.stick_radius) / rules.LEAST_CELLS_PER_SLIP_ANNULUS,
    )
    allowed = (min(coarsest, 2.0 * length / WavyRoughness.cells) for length in lengths)
    case = valid(given, cell=tuple(draw(st.floats(0.12, 1.0)) * each for each in allowed))
    assume(estimate(case).cells <= MOST_CELLS)
    return case


class EnoughError(Exception):
    """The run has shown enough."""


class Inspector:
    """An observer that compares each step with what no step may break, and with the one before."""

    def __init__(self, case):
        self.case, self.problem, self.before = case, simulate.wear_problem(case), None

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
        assert self.before or not state.wear.any()
        if self.before:
            assert state.cycle > self.before.cycle
            before = self.before.on(Workspace(self.problem), state.geometry)
            for now, then in ((state.wear, before.wear), (state.plastic, before.plastic)):
                assert (now - then).min() >= -1e-12 * max(now.max(), 1e-300), "bodies heal"
        self.before = state
        if state.step >= MOST_STEPS:
            raise EnoughError


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
    # What the suite can afford out of the examples of the profile.
    max_examples=max(1, settings.default.max_examples // 10),
    suppress_health_check=list(HealthCheck),
)
@given(case=cases())
def test_no_valid_case_pulls_or_drops_the_load_or_heals(case):
    event(f"rough: {case.roughness is not None}, yields: {case.plastic_limit < math.inf}")
    try:
        dataset = simulate.simulate(case, [Inspector(case)], quarter=True)
    except (ContactError, WearError) as error:
        # A run may end with a message where a solution is not found; it never goes on without.
        event(f"ended: {type(error).__name__}")
    except EnoughError:
        event("long")
    else:
        check_dataset(dataset, case)
