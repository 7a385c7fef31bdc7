"""What changes over the cycles: parts that say so by `at` and `kinks`, which all else follows."""

from dataclasses import dataclass, replace
from typing import Annotated

import numpy as np
import pytest

from fretwear.mechanics.slip.models import CattaneoMindlin
from fretwear.mechanics.surfaces.laws import Archard, PowerLaw, WearLaw
from fretwear.mechanics.surfaces.loading import Loading, TangentialRatio
from fretwear.mechanics.surfaces.materials import Coulomb
from fretwear.mechanics.surfaces.pressing import NormalLoad
from fretwear.mechanics.values import OverCycles
from fretwear.mechanics.wear.integrator import evolve
from fretwear.mechanics.wear.window import first_cells
from fretwear.quantity import Quantity
from fretwear.theory import PartialSlip

from ..studies import near
from .oracles import extrapolated_wear
from .problems import COUPLING, FRICTION, HERTZ, LOAD, WEAR, A, fretting

CYCLES = 300.0

Number = Annotated[float, Quantity("1", "", "")]


@dataclass(frozen=True)
class Rising(Loading):
    """A tangential load that rises linearly over the run, as a fraction of µP."""

    first: Number
    last: Number

    def at(self, cycle):
        part = cycle / CYCLES
        return TangentialRatio((1 - part) * self.first + part * self.last)

    def load_ratio(self, *_):
        return self.first


@dataclass(frozen=True)
class RunningIn(WearLaw):
    """A coefficient that falls with the cycles, to a half at the end of the run."""

    start: Number

    def at(self, cycle):
        return Archard(self.start / (1 + cycle / CYCLES))

    def coefficient(self, friction):
        return self.start


@dataclass(frozen=True)
class Spectrum(NormalLoad):
    """A load that is raised halfway, within a fifth of the run."""

    def at(self, cycle):
        return NormalLoad(self.load * np.interp(cycle, self.kinks, (1.0, 1.6)))

    @property
    def kinks(self):
        return 0.4 * CYCLES, 0.6 * CYCLES


RAMP = OverCycles((0.0, 0.5 * CYCLES), (FRICTION, 1.6 * FRICTION))
CHANGES = {
    "K follows the contact": {
        "wear_law": Archard(
            PowerLaw(
                40 * WEAR,
                pressure_exponent=0.8,
                reference_pressure=HERTZ.mean_pressure,
                sliding_exponent=0.5,
                reference_sliding=1e-7,
                frequency_exponent=-0.3,
                reference_frequency=5.0,
            )
        ),
        "frequency": 2.0,
    },
    "all else, and the bodies yield": {
        "loading": Rising(0.3, 0.9),
        "wear_law": RunningIn(20 * WEAR),
        "friction_law": Coulomb.unchecked(friction=RAMP),
        "normal": Spectrum(LOAD),
        "limit": 1.3,
    },
}


@pytest.mark.slow
@pytest.mark.parametrize("name", CHANGES)
def test_whatever_changes_over_the_cycles_is_followed(name):
    """Against Euler's method in small steps."""
    usual = {"wear_coefficient": 20 * WEAR, "extent": (2.0 * A, 2.0 * A)}
    problem = fretting(8, **usual | CHANGES[name])
    window = first_cells(problem)
    expected = extrapolated_wear(problem, window, CYCLES, 120)
    *_, last = evolve(problem, [CYCLES], 1e-4)
    assert last.geometry == window
    for name in ("wear", "pressure"):
        field = getattr(expected, name)
        assert np.abs(getattr(last, name) - field).sum() <= 0.0015 * field.sum()
    # Were the change not seen, this would be the wear of the first cycle's conditions.
    first = problem.at(0.0)
    *_, constant = evolve(first.under(first.unworn_means), [CYCLES], 0.001)
    assert abs(constant.wear.sum() / expected.wear.sum() - 1) > 0.03


def test_means_that_a_coefficient_follows_are_extrapolated_to_the_end_of_a_step():
    """They lag by one stage, which alone would make steps of first order."""
    problem = fretting(8, extent=(2.0 * A, 2.0 * A), **CHANGES["K follows the contact"])
    usual, fine = ([*evolve(problem, [CYCLES], each)][-1].wear for each in (0.01, 1e-4))
    assert np.abs(usual - fine).sum() <= 1e-3 * fine.sum()


@dataclass(frozen=True)
class Growing(WearLaw):
    """A coefficient that grows with a power of the cycles, to 31 times its value at the start."""

    start: Number
    power: Number

    def at(self, cycle):
        return Archard(self.start * (1 + 30 * (cycle / CYCLES) ** self.power))

    def coefficient(self, friction):
        return self.start


@pytest.mark.parametrize(("power", "rel", "most"), [(1, 1e-7, 1), (2, 0.01, 50)])
def test_steps_are_exact_for_a_coefficient_that_changes_evenly_and_short_where_it_does_not(
    power, rel, most
):
    """With hardly any wear, V = K/µ times the energy of a cycle; formulas are of second order."""
    first, *states = evolve(fretting(8, wear_law=Growing(1e-9 * WEAR, power)), [CYCLES])
    energy = fretting(8).dissipated_energy(first, first.geometry)
    mean = 1e-9 * WEAR * (1 + 30 / (power + 1))
    found = states[-1].geometry.integral(states[-1].wear)
    assert found == near(mean / FRICTION * energy * CYCLES, rel=rel)
    assert len(states) <= most


def test_slip_in_closed_form_follows_a_load_that_rises():
    """Wear of a cell is K times the integral of 4 p s; with hardly any wear, p is Hertz's."""
    problem = fretting(16, loading=Rising(0.3, 0.9), slip_model=CattaneoMindlin())
    problem = replace(problem, wear_law=Archard(1e-6 * WEAR))
    *_, last = evolve(problem, [CYCLES], 0.001)
    x = last.geometry.x
    ratios = 0.3 + 0.6 * (np.arange(200) + 0.5) / 200
    slips = [PartialSlip(HERTZ, FRICTION, X * FRICTION * LOAD, COUPLING).slip(x) for X in ratios]
    expected = 4e-6 * WEAR * CYCLES * HERTZ.pressure(x) * np.mean(slips, axis=0)
    inside = x < 0.9 * A
    along = last.wear[:, 0]
    np.testing.assert_allclose(along[inside], expected[inside], atol=0.02 * expected.max())
    assert along[inside].sum() == near(expected[inside].sum(), rel=0.01)
