"""Draw valid cases of all kinds at random, and see that the laws they obey hold in the results.

``python -m benchmarks.invariants`` runs 500 cases of few cycles on coarse cells, each again in
other units of length and of load, and sweeps parameters in small steps; it prints a table of what
was violated, and ends with 1 if anything was. ``--seed 7 --only 12`` runs one of the cases again
and prints its parameters.

What is drawn are the ratios that matter, from where they are harmless to where the rules of a case
draw the line: each indenter, loading, surface, law of wear and slip model, on grids as coarse as
the rules allow, of bodies of any size and stiffness.
"""

from __future__ import annotations

import argparse
import hashlib
import math
import signal
import sys
import tempfile
import time
import traceback
import warnings
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np

from fretwear.arrays import Array
from fretwear.mechanics.contact import ContactError
from fretwear.mechanics.geometry import Workspace
from fretwear.mechanics.integrator import WearError
from fretwear.mechanics.loading import SMALL_STROKE
from fretwear.mechanics.roughness import WavyRoughness
from fretwear.mechanics.stroke import StrokeState
from fretwear.mechanics.wear_laws import FallingCoefficient
from fretwear.parts import declared
from fretwear.running.simulate import Result, Step, run, wear_problem
from fretwear.study import rules
from fretwear.study.case import Case, CaseError
from fretwear.study.members import PartOf
from fretwear.study.parameters import parameter_of
from fretwear.study.plan import estimate
from fretwear.units import LINE_CONTACT, POINT_CONTACT
from fretwear.vocabulary import RESULTS, SCALARS

Given = dict[str, Any]

CASES, SWEEPS, MOST_CELLS, MOST_STEPS = 500, 30, 12_000, 400
OUTSIDE = "slides the contact as a whole"  # a sentence for what the model does not describe
# Processor time, s, of a case and its twin, or so many times what the plan says of the case.
LONGEST, SLOWER = 60.0, 5.0
INDENTERS = ("sphere", "cylinder", "ellipsoid", "crossed_cylinders", "round_punch", "flat_punch",
             "profile", "height_map")  # fmt: skip
LINES = ("cylinder", "flat_punch")

# The tolerance of the normal contact allows this much of a load; storing in single precision too.
LOAD = 1e-6
# Single precision of the stored fields, at the largest value.
STORED = 3e-6
# Gaps that are no contact, of the largest displacement.
NO_GAP = 2e-5
# In other units all is the same to rounding, which a solver may amplify to its tolerance. The
# factors are powers of two whose roots are too, so that hardly anything is rounded otherwise.
UNITS, LENGTHS, MODULI = 1e-6, 64.0, 4096.0
# Differences of nearly equal numbers, and results with a tolerance of their own.
DIFFERENCES = ("error_estimate", "sliding_criterion", "convolutions")
# The steps of a sweep, the part of the parameter they cover, and the part of a value that may
# jump although no error is stated.
STEPS, WIDTH, LEAST_JUMP = 12, 0.02, 3e-3

# How a value scales with the units of length and pressure.
UNIT_POWERS = {
    "m": (1, 0), "m2": (2, 0), "m3": (3, 0), "N": (2, 1), "N m-1": (1, 1), "J": (3, 1),
    "J m-1": (2, 1), "Pa": (0, 1), "Pa-1": (0, -1), "m2 W-1": (-1, -1), "s-1": (0, 0),
    "rad": (0, 0), "1": (0, 0), "": (0, 0),
}  # fmt: skip


@dataclass(frozen=True)
class Surface:
    """Content of a file: heights, m, over the distance from an axis or over x and y, m."""

    axes: tuple[Array, ...]
    heights: Array

    def file(self, folder: Path, scale: float) -> str:
        """Write it with all lengths multiplied by a factor; its file."""
        axes, heights = [scale * each for each in self.axes], scale * self.heights
        if len(axes) == 1:
            rows = zip(axes[0].tolist(), heights.tolist(), strict=True)
            content = "\n".join(["r (m), z (m)", *(f"{r!r}, {z!r}" for r, z in rows)])
            (path := folder / f"{_digest(content.encode())}.csv").write_text(content)
            return str(path)
        from SurfaceTopography import Topography

        path = folder / f"{_digest(heights.tobytes() + axes[0].tobytes())}.nc"
        sides = tuple(each.size * float(each[1] - each[0]) for each in axes)
        if not path.exists():
            Topography(heights, sides, unit="m").to_netcdf(str(path))
        return str(path)


def _digest(content: bytes) -> str:
    return hashlib.sha256(content).hexdigest()[:12]


def case_of(given: Given, folder: Path, lengths: float = 1.0, moduli: float = 1.0) -> Case:
    """The case of some parameters in SI units, all lengths and moduli multiplied by factors.

    Forces are moduli times squares of lengths, and wear coefficients inverse moduli.
    """
    is_line = given["indenter"]["kind"] in LINES

    def changed(about: Any, value: Any) -> Any:
        if isinstance(value, Surface):
            return value.file(folder, lengths)
        if isinstance(value, list):
            return [changed(about, each) for each in value]
        if not isinstance(value, float):
            return value
        unit = (LINE_CONTACT if is_line else POINT_CONTACT).unit(about.si_unit)
        of_length, of_modulus = UNIT_POWERS[unit]
        return value * lengths**of_length * moduli**of_modulus

    def of_parts(values: Given) -> Given:
        found: Given = {}
        for name, value in values.items():
            about: Any = None if name == "blocks" else parameter_of(name)
            if name == "blocks":
                found[name] = [of_parts(each) for each in value]
            elif isinstance(about, PartOf) and isinstance(value, dict):
                fields = about.kinds[value["kind"]].parameters()
                found[name] = {n: changed(fields.get(n), v) for n, v in value.items()}
            elif name == "energy_wear_coefficient" and isinstance(value, dict):
                fields = declared(FallingCoefficient)
                found[name] = {n: changed(fields[n], v) for n, v in value.items()}
            else:
                found[name] = changed(about, value)
        return found

    own = {name: value for name, value in given.items() if name not in ("output_cycles",)}
    return Case(**of_parts(own), output_cycles=given["output_cycles"])


class Draw:
    """Draws valid cases, each from a generator of its own; files of surfaces go to a folder."""

    def __init__(self, seed: int, number: int, folder: Path) -> None:
        self.rng = np.random.default_rng([seed, number])
        self.number, self.folder = number, folder

    def power(self, low: float, high: float) -> float:
        """A number from 10^low to 10^high, evenly by its logarithm."""
        return float(10.0 ** self.rng.uniform(low, high))

    def between(self, low: float, high: float) -> float:
        return float(self.rng.uniform(low, high))

    def chance(self, part: float) -> bool:
        return bool(self.rng.random() < part)

    def one_of(self, *values: Any) -> Any:
        return values[self.rng.integers(len(values))]

    def one_or_two(self, draw: Callable[[], float], part: float = 0.2) -> Any:
        return [draw(), draw()] if self.chance(part) else draw()

    def case(self) -> tuple[Given, Case]:
        """Parameters in SI units, and the case; cases that the rules refuse are drawn again."""
        while True:
            try:
                given = self.given()
                case = case_of(given, self.folder)
            except CaseError:
                continue
            if estimate(case).cells <= MOST_CELLS:
                return given, case

    def given(self) -> Given:
        """Parameters in SI units, which the rules may refuse."""
        kind = INDENTERS[self.number % len(INDENTERS)]
        is_line = kind in LINES
        radius, modulus = self.power(-5, 1), lambda: self.power(4, 13)
        size = self.power(-4, math.log10(0.19)) * radius
        given: Given = {
            "indenter": self.indenter(kind, radius, size),
            "youngs_modulus": self.one_or_two(modulus),
            "poisson_ratio": self.one_or_two(lambda: self.between(-0.99, 0.5), 0.1),
            "friction": self.power(-3, 1),
            "wear_coefficient": 1.0,
            "cycles": round(self.power(0, 4)),
            "tolerance": self.power(-3, -1),
            "error_estimate": False,
        }
        given["output_cycles"] = sorted({0, self.rng.integers(given["cycles"] + 1).item()})
        # The load of a contact of the size that is wanted.
        probe = case_of({**given, "load": 1e-12 * size**2, "tangential_ratio": 0.5}, self.folder)
        hertz = probe.hertz.with_load(probe.hertz.load_at(size))
        given["load"] = float(hertz.load)
        smooth = case_of({**given, "tangential_ratio": 0.5}, self.folder)
        approach = abs(smooth.hertz.approach)
        if self.chance(0.15) and not is_line and smooth.indenter.has_closed_form:
            del given["load"]
            given["indentation"] = approach
        given |= self.loading(smooth)
        if self.chance(0.6):
            limit = self.one_of((-0.5, 0.1), (-0.1, 0.1), (0, 1), (1, 9))
            given["plastic_limit"] = self.power(*limit) * smooth.hertz_pressure
        if self.chance(0.5):
            given["roughness"] = self.roughness(size, size**2 / radius, kind, "flat")
            if self.chance(0.3):
                given["counterface"] = self.roughness(size, size**2 / radius, kind, "indenter")
        if self.chance(0.1) and kind in ("sphere", "cylinder"):
            given["slip_model"] = "cattaneo_mindlin"
        if self.chance(0.2):
            given["debris_fraction"] = self.one_of(
                1.0, self.between(0, 1), 1.0 - self.power(-6, -1)
            )
        if self.chance(0.2):
            times = [0, *sorted({1 + self.rng.integers(given["cycles"]).item() for _ in range(2)})]
            values = [given["friction"] * self.power(-0.3, 0.3) for _ in times]
            given["friction"] = {"cycles": times, "values": values}
        given |= self.wear(smooth, given)
        if self.chance(0.15):
            given |= self.blocks(given)
        given["cell"] = self.cell(case_of(given, self.folder))
        return given

    def indenter(self, kind: str, radius: float, size: float) -> Given:
        """An indenter about as curved as a radius, m, for a contact of a size, m."""
        shape: Given = {"kind": kind}
        if kind in ("sphere", "cylinder"):
            shape["radius"] = radius
        elif kind == "ellipsoid":
            shape |= {"radius_x": radius, "radius_y": radius * self.one_of(1.0, self.power(-1, 1))}
        elif kind == "crossed_cylinders":
            angle = self.one_of(90.0, self.between(89.9, 90.0), self.between(20.0, 90.0))
            shape |= {"radii": self.one_or_two(lambda: radius * self.power(-0.3, 0.3), 0.5),
                      "angle": math.radians(angle)}  # fmt: skip
        elif kind in ("round_punch", "flat_punch"):
            name = "flat_radius" if kind == "round_punch" else "flat_half_width"
            shape |= {name: size * self.one_of(self.between(0.02, 0.98), self.power(-4, -1)),
                      "edge_radius": radius}  # fmt: skip
        elif kind == "profile":
            r = np.linspace(0.0, 3.0 * size, 40)
            power = self.between(2.0, 4.0)
            z = size**2 / (2.0 * radius) * (r / size) ** power
            shape["file"] = Surface((r,), z)
        else:
            x, y = (np.linspace(-2.5 * size, 2.5 * size, n) for n in (41, 37))
            z = (x[:, None] ** 2 * self.power(-0.2, 0.2) + y**2) / (2.0 * radius)
            z += 0.02 * size**2 / radius * np.sin(x[:, None] / size * 3.0) * np.cos(y / size * 2.0)
            shape["file"] = Surface((x, y), -z)
        return shape

    def loading(self, smooth: Case) -> Given:
        """The loading along x."""
        what = self.one_of("ratio", "ratio", "load", "displacement", "displacement", "stroke")
        friction, is_line = smooth.friction_law.coefficient, smooth.frame is LINE_CONTACT
        near_one = self.one_of(-1, 1) * self.power(-12, -1)
        if what == "ratio":
            return {
                "tangential_ratio": self.one_of(
                    self.between(0.05, 0.95), 1.0 - max(abs(near_one), 1e-4)
                )
            }
        if what == "load":
            return {"tangential_load": self.between(0.05, 0.95) * friction * smooth.load}
        if what == "stroke":
            limits = self.one_of((-3, 0.7), (math.log10(SMALL_STROKE) - 0.05,) * 2)
            return {"sliding_amplitude": self.power(*limits) * smooth.hertz_radius}
        ratio = self.one_of(self.between(0.1, 1.5), 1.0 + near_one)
        found: Given = {}
        compliant = smooth.coupling * abs(smooth.hertz.approach)
        if is_line:
            compliance = smooth.hertz.compliance * self.power(0.0, 1.0)  # type: ignore[attr-defined]
            found["tangential_compliance"] = compliance
            compliant = compliance * smooth.load
        elif self.chance(0.4):
            found["rig_stiffness"] = smooth.load / compliant * self.power(-1, 1)
        if smooth.indenter.has_closed_form and self.chance(0.4):
            return found | {"displacement_ratio": ratio}
        return found | {"displacement_amplitude": ratio * friction * compliant}

    def roughness(self, size: float, height: float, kind: str, body: str) -> Given:
        """A roughness on a contact of a size and a height, m."""
        amplitude = height * self.power(-3, 0.5)
        which = "wavy" if kind in LINES else self.one_of("wavy", "wavy", "self_affine", "measured")
        length = size * self.power(-0.4, 0.6)
        if which == "wavy":
            slope_x, slope_y = (math.atan(4.0 * amplitude / length) for _ in range(2))
            zero = "y" if kind in LINES else self.one_of("", "", "x", "y")
            return {
                "kind": "wavy",
                "amplitude": amplitude,
                "slope_x": 0.0 if zero == "x" else slope_x,
                "slope_y": 0.0 if zero == "y" else slope_y * self.between(0.3, 1.0),
            }
        if which == "self_affine":
            return {
                "kind": "self_affine",
                "rms_height": amplitude,
                "hurst": self.between(0.3, 1.0),
                "rolloff_wavelength": length,
                "shortest_wavelength": length / self.between(1, 4),
                "seed": self.rng.integers(1000).item(),
                "anisotropy": self.one_of(1.0, 2.0),
            }
        x, y = (np.linspace(-3.0 * size, 3.0 * size, n) for n in (31, 27))
        z = amplitude * self.rng.normal(size=(x.size, y.size))
        return {"kind": "measured", "file": Surface((x, y), z), "body": body,
                "tilt": self.one_of("keep", "remove")}  # fmt: skip

    def wear(self, smooth: Case, given: Given) -> Given:
        """A law of wear: from nothing to where little more happens in the course of the run."""
        path = smooth.friction_law.coefficient * smooth.coupling  # of slip per gap
        if "sliding_amplitude" in given:
            path = given["sliding_amplitude"] / abs(smooth.hertz.approach)
        growth = self.power(-4, 2)
        value = growth / (4.0 * path * given["cycles"] * smooth.hertz_pressure)
        if self.chance(0.5 if "sliding_amplitude" not in given else 1.0):
            share = self.between(0.05, 0.95)
            value = [share * value, (1.0 - share) * value]
        which = self.one_of("archard", "archard", "energy", "falling")
        if which == "archard":
            return {"wear_coefficient": value}
        per_energy = np.divide(value, smooth.friction_law.coefficient)
        if which == "falling":
            density = 4.0 * smooth.friction_law.coefficient * smooth.hertz_pressure * path
            density *= abs(smooth.hertz.approach)
            fast = self.power(-2, 0)
            per_energy = {
                "slow": per_energy.tolist(), "fast": (fast * per_energy).tolist(),
                "decay": self.power(-1, 1) / density, "frequency": 1.0,
            }  # fmt: skip
        else:
            per_energy = per_energy.tolist()
        return {"wear_coefficient": None, "energy_wear_coefficient": per_energy}

    def blocks(self, given: Given) -> Given:
        """Blocks of loading that change the given parameters."""
        count = max(1, given["cycles"] // 2)
        numbers = (
            "load",
            "indentation",
            "tangential_ratio",
            "tangential_load",
            "sliding_amplitude",
            "displacement_amplitude",
            "displacement_ratio",
        )
        name = self.one_of(*(each for each in numbers if each in given))
        changed = given[name] * self.between(0.6, 1.0)
        blocks = [{"cycles": count}, {"cycles": count, name: changed}, {"cycles": count}]
        return {"cycles": None, "blocks": blocks, "output_cycles": [0, count]}

    def cell(self, case: Case) -> list[float]:
        """A spacing as coarse as the rules allow, or down to half of it; seldom the default."""
        if self.chance(0.1):
            return list(case.grid_spacing)
        radius, stick = case.hertz_radius, case.stick_radius
        coarsest = min(
            radius / rules.LEAST_CELLS_PER_CONTACT_RADIUS,
            stick / rules.LEAST_CELLS_PER_STICK_RADIUS if case.force_is_held else radius,
            (radius - stick) / rules.LEAST_CELLS_PER_SLIP_ANNULUS,
        )
        widths = case.indenter.half_widths(case.hertz)
        along = [coarsest * min(1.0, each / radius) for each in widths]
        for part in case.surfaces.values():
            few = WavyRoughness.cells // 2
            along = [min(a, f / few) for a, f in zip(along, part.finest, strict=True)]
        part = self.between(0.5, 1.0)
        return (
            [part * min(along)] * 2
            if case.frame is LINE_CONTACT
            else [part * each for each in along]
        )


class LongError(Exception):
    """The run has shown enough."""


class Laws:
    """The laws for each step of a run and for its results; it observes the run.

    ``worst`` has by law the largest violation, in units of the allowed one.
    """

    def __init__(self, case: Case) -> None:
        self.case, self.problem = case, wear_problem(case)
        self.worst: dict[str, float] = {}
        self.before: Any = None
        self.rates: list[tuple[float, float, float]] = []  # cycle, worn volume of it and so far

    def law(self, words: str, violation: Any, allowed: float) -> None:
        """Note by how much a law is violated: the largest of some numbers."""
        most = float(np.max(violation, initial=0.0)) / (allowed or 1e-300)
        most = math.inf if math.isnan(most) else most
        self.worst[words] = max(self.worst.get(words, 0.0), most)

    def __call__(self, step: Step) -> None:
        state, measures, problem = step.state, vars(step.measures), self.problem.of(step.state)
        integral, reduced = state.geometry.integral, state.reduced
        pressure, friction = state.pressure, problem.friction_law.coefficient
        fields = (pressure, state.gap, state.wear, state.plastic, reduced.gap, reduced.pressure)
        self.law("fields are finite", not all(np.isfinite(each).all() for each in fields), 0.5)
        infinite = [n for n, v in measures.items() if not math.isfinite(v)]
        nothing_sticks = measures["stick_area"] == 0.0
        unknown = {"mean_stick_pressure", "stick_load_share"} if nothing_sticks else set()
        unknown |= set() if measures["tangential_force"] else {"sliding_ratio"}
        self.law("scalars are finite", len({*infinite} - unknown), 0.5)
        peak, load = float(pressure.max()), measures["normal_force"]
        self.law("p >= 0", -pressure.min(), 1e-12 * peak)
        if math.isfinite(problem.plastic_limit):
            self.law("p <= limit", pressure / problem.plastic_limit - 1.0, 1e-9)
        self.law("the pressure carries P", abs(integral(pressure) / load - 1.0), LOAD)
        given, approach = problem.normal.given
        if given is not None:
            self.law("P is as imposed", abs(load / given - 1.0), LOAD)
        else:
            self.law("d is as imposed", abs(state.approach / approach - 1.0), LOAD)
        height = max(abs(state.approach), abs(problem.hertz.approach))
        self.law("g >= 0", -state.gap.min(), 1e-9 * height)
        free = (pressure > 0.0) & (pressure < problem.plastic_limit)
        self.law("g p = 0", state.gap[free], NO_GAP * height)
        force = measures["tangential_force"]
        shear = problem.shear_traction(pressure, reduced)
        beyond = np.abs(shear) - friction * pressure
        self.law("|q| <= mu p", beyond, LOAD * friction * peak)
        if problem.slip_model.follows_shape or problem.loading.stroke:
            uncut = friction * (pressure - reduced.pressure)
            self.law("shear is not cut", np.abs(shear - uncut), LOAD * friction * peak)
            carried = abs(integral(shear) - force)
            self.law("the shear traction carries Q", carried, 10 * LOAD * friction * load)
            self.law("g* >= 0", -reduced.gap.min(), 1e-12 * height)
            self._imposed(problem, measures)
        if self.before is not None:
            self.law("cycles pass", self.before.cycle >= state.cycle, 0.5)
            before = self.before.on(Workspace(self.problem), state.geometry)
            for now, then in ((state.wear, before.wear), (state.plastic, before.plastic)):
                self.law("bodies do not heal", then - now, 1e-12 * now.max() + 1e-300)
        rate = problem.combined_wear_coefficient / friction * measures["dissipated_energy"]
        if isinstance(state, StrokeState):
            rate = integral(state.rates.sum(axis=0))
        self.rates.append((state.cycle, rate, measures["wear_volume"]))
        self.before = state
        if state.step >= MOST_STEPS:
            raise LongError

    def _imposed(self, problem: Any, measures: Given) -> None:
        """Q or U equals the imposed value."""
        loading, friction = problem.loading, problem.friction_law.coefficient
        load, force = measures["normal_force"], measures["tangential_force"]
        if loading.is_force:
            imposed = friction * load * loading.load_ratio(friction, load)
            self.law("Q is as imposed", abs(force - imposed), LOAD * friction * load)
        elif not loading.stroke:
            imposed = loading.displacement(friction, problem.coupling, problem.hertz)
            moved = measures["tangential_displacement"] + problem.flexibility * force
            scale = friction * problem.coupling * abs(measures["approach"]) + imposed
            self.law("U is as imposed", abs(moved - imposed), 1e-5 * scale)

    def of_result(self, result: Result) -> None:
        """Stored results obey the same laws."""
        case, dataset = self.case, result.dataset
        stored = {
            each.name: each
            for result in RESULTS.values()
            for each in (result, result.error, result.coupling_error)
        }
        for name in dataset.data_vars:
            values = dataset[name].to_numpy()
            self.law("stored values are finite", not stored[name].allows(values), 0.5)
        of = {name: dataset[name].to_numpy().astype(float) for name in dataset.data_vars}
        even = 2 if dataset.symmetry == "even_xy" else int(dataset.symmetry != "none")
        area = 2.0**even * float(dataset.x[1] - dataset.x[0])
        area *= float(dataset.y[1] - dataset.y[0]) if "y" in dataset.dims else 1.0
        across = tuple(range(1, of["pressure"].ndim))
        total = {name: area * values.sum(axis=across) for name, values in of.items()
                 if values.ndim == 1 + len(across)}  # fmt: skip
        wear, load, pressure = of["wear_volume"], of["normal_force"], of["pressure"]
        peak, volume = pressure.max(), wear.max() + 1e-300
        self.law("stored pressures sum up to P", abs(total["pressure"] / load - 1.0), STORED)
        self.law("stored wear sums up to V", abs(total["wear_depth"] - wear), STORED * volume)
        for each in ("plastic_depth",):
            sunk = of["plastic_volume"]
            self.law("stored plastic depths sum up", abs(total[each] - sunk), STORED * sunk.max())
        self.law("stored p, w >= 0", -min(pressure.min(), of["wear_depth"].min()), 1e-30)
        self.law("stored p <= limit", pressure / case.plastic_limit - 1.0, STORED)
        self.law("wear volume does not fall", -np.diff(wear), 1e-12 * volume)
        open_cells = of["contact_state"] == 0
        self.law("open cells carry nothing", pressure[open_cells], STORED * peak)
        if "wear_volume_flat" in of:
            for kind, both in (("volume", wear), ("depth", of["wear_depth"])):
                parts = of[f"wear_{kind}_indenter"] + of[f"wear_{kind}_flat"]
                if kind == "volume" or not case.loading.stroke:
                    apart = abs(parts - both)
                    self.law(f"wear {kind} is that of both bodies", apart, STORED * both.max())
        frictions = [self.problem.at(n).friction_law.coefficient for n in dataset.cycle.to_numpy()]
        friction = np.reshape(frictions, (-1,) + (1,) * len(across))
        energy = of["dissipated_energy"]
        beyond = np.abs(of["shear_traction"]) - friction * pressure
        self.law("stored |q| <= mu p", beyond, STORED * friction.max() * peak)
        if case.slip_model.follows_shape or case.loading.stroke:
            forces = abs(total["shear_traction"] - of["tangential_force"])
            self.law(
                "stored shear sums up to Q", forces, 10 * STORED * (friction[:, 0].T * load).max()
            )
            spent = area * (4.0 * friction * pressure * of["slip"]).sum(axis=across)
            self.law("stored 4 mu p s sums up to E", abs(spent - energy), 1e-3 * energy.max())
            loops = result.loops
            round_it = zip(loops.force.to_numpy(), loops.displacement.to_numpy(), strict=True)
            areas = np.array([abs(np.trapezoid(force, moved)) for force, moved in round_it])
            box = 4.0 * of["tangential_force"] * abs(of["tangential_displacement"])
            allowed = 1e-3 * energy.max() + 1e-9 * box.max()
            self.law("the loop has the area E", abs(areas - energy), allowed)
        rate = self._rate_of(dataset.cycle.to_numpy())
        self.law("stored wear rates sum up", abs(total["wear_rate"] - rate), 1e-5 * rate.max())
        if not case.blocks:
            self._integrated(case)

    def _rate_of(self, cycles: Any) -> Array:
        known = {cycle: rate for cycle, rate, _ in self.rates}
        return np.array([known[cycle] for cycle in cycles])

    def _integrated(self, case: Case) -> None:
        """V = ∫ K/µ dE over the cycles, from each step."""
        from scipy.interpolate import PchipInterpolator

        cycles, rates, volumes = np.array(self.rates).T
        kinks = [k for k in case.friction_law.kinks if 0 < k < case.cycles]
        ends = [0.0, *kinks, float(case.cycles)]
        worn = by_lines = 0.0
        for first, last in pairwise(ends):
            inside = (cycles >= first) & (cycles <= last)
            at = cycles[inside], rates[inside]
            worn += float(PchipInterpolator(*at).integrate(first, last))
            by_lines += float(np.trapezoid(at[1], at[0]))
        # Cubics through the rates of few steps err as well, by less than straight lines do.
        allowed = 2.0 * max(0.001, case.tolerance) * volumes[-1] + abs(worn - by_lines)
        self.law("V = integral of K/mu dE", abs(worn - volumes[-1]), allowed)


def judged(given: Given, folder: Path, *, again: bool = True) -> tuple[dict[str, float], str]:
    """Run a case, and again in other units; violations by law in units of the allowed ones.

    If it did not finish, the reason is returned too.
    """
    case = case_of(given, folder)
    laws = Laws(case)
    signal.signal(signal.SIGVTALRM, _stop)
    signal.setitimer(signal.ITIMER_VIRTUAL, max(LONGEST, SLOWER * estimate(case).seconds))
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("error", RuntimeWarning)
            result = run(case, [laws])
            laws.of_result(result)
            laws.law("it ends", 0.0, 0.5)
            if again:
                other = run(case_of(given, folder, LENGTHS, MODULI))
                laws.law("the same in other units", apart(result, other), UNITS)
    except LongError:
        return laws.worst, "long"
    except (ContactError, WearError) as error:
        # At a held approach the normal force may fall to where Q slides the contact as a whole.
        laws.law("it ends", OUTSIDE not in str(error), 0.5)
        return laws.worst, str(error)
    except Exception:
        laws.law("it ends", 1.0, 0.5)
        return laws.worst, traceback.format_exc()
    finally:
        signal.setitimer(signal.ITIMER_VIRTUAL, 0.0)
    return laws.worst, ""


def _stop(*_: object) -> None:
    raise TimeoutError("much longer than planned")


def apart(one: Result, other: Result) -> float:
    """How far the results of a case differ from those in other units, relative to the largest."""
    if one.history.sizes["step"] != other.history.sizes["step"]:
        return math.inf
    found = [0.0]
    for ours, theirs in ((one.dataset, other.dataset), (one.history, other.history)):
        for name, values in ours.data_vars.items():
            if name in DIFFERENCES:
                continue
            unit = str(values.attrs.get("units", ""))
            of_length, of_modulus = UNIT_POWERS[unit]
            there = theirs[name].to_numpy().astype(float)
            here = values.to_numpy().astype(float) * LENGTHS**of_length * MODULI**of_modulus
            known = np.isfinite(here)
            if not np.array_equal(known, np.isfinite(there)):
                return math.inf
            most = np.abs(here[known]).max(initial=0.0)
            if most > 0.0:
                most *= _of_displacements(name, ours)
                found.append(float(np.abs(here - there)[known].max()) / most)
    return max(found)


def _of_displacements(name: str, values: Any) -> float:
    """Ratio of the approach to the depths of bodies: tolerances of solvers refer to the former.

    Bodies sink at the limit by a difference of displacements, and beside the edge of stick they
    slip by one, which wear there multiplies. Wear volumes are judged by their own size.
    """
    depth = "wear_depth" if name.startswith(("wear_depth", "wear_rate")) else name
    if depth not in ("wear_depth", "plastic_depth", "plastic_volume"):
        return 1.0
    if not (most := float(np.abs(values[depth]).max())):
        return 1.0
    whole = float(np.abs(values["approach"]).max())
    if depth == "plastic_volume":
        whole *= float(values["contact_area"].max())
    return max(1.0, whole / most)


STEEL: Given = {
    "youngs_modulus": 208e9, "poisson_ratio": 0.3, "friction": 0.5, "wear_coefficient": 7e-13,
    "cycles": 300, "output_cycles": [0], "tangential_ratio": 0.6,
}  # fmt: skip
SPHERE: Given = {**STEEL, "indenter": {"kind": "sphere", "radius": 10e-3}, "load": 50.0}
CYLINDER: Given = {**STEEL, "indenter": {"kind": "cylinder", "radius": 6e-3}, "load": 1e5}
ROUND = SPHERE | {"indenter": {"kind": "round_punch", "flat_radius": 60e-6, "edge_radius": 5e-3}}
FLAT = CYLINDER | {
    "indenter": {"kind": "flat_punch", "flat_half_width": 200e-6, "edge_radius": 2e-3}
}
CROSSED = SPHERE | {"indenter": {"kind": "crossed_cylinders", "radii": [10e-3, 8e-3], "angle": 1.0}}
ELLIPSE = SPHERE | {"indenter": {"kind": "ellipsoid", "radius_x": 10e-3, "radius_y": 10e-3}}
WAVES: Given = {"kind": "wavy", "amplitude": 2e-7, "slope_x": 0.03, "slope_y": 0.02}
WAVY = SPHERE | {"roughness": WAVES, "cycles": 30, "cell": [3e-6, 4e-6]}
RIPPLED = CYLINDER | {"roughness": {**WAVES, "slope_y": 0.0}}

Sweep = tuple[str, Given, str, float, float]


def thresholds() -> Iterator[Sweep]:
    """Yield words, a case, a parameter, and the ends of a sweep across a threshold of its rules."""
    bodies = {"sphere": SPHERE, "cylinder": CYLINDER, "crossed cylinders": CROSSED,
              "round punch": ROUND, "flat punch": FLAT, "wavy sphere": WAVY}  # fmt: skip
    for name, given in bodies.items():
        smooth, about = case_of(given, Path()), 0.5 * WIDTH
        yield f"X near 1, {name}", given, "tangential_ratio", 0.9989, 0.9991
        yield f"load, {name}", given, "load", *_around(given["load"])
        moved = {key: value for key, value in given.items() if key != "tangential_ratio"}
        if smooth.frame is LINE_CONTACT:
            moved["tangential_compliance"] = 1e-11
        if smooth.indenter.has_closed_form:
            yield f"U near U_t, {name}", moved, "displacement_ratio", 0.99, 1.01
        pressure = smooth.hertz_pressure
        yield f"limit near p0, {name}", given, "plastic_limit", *_around(pressure)
        yield f"limit well above p0, {name}", given, "plastic_limit", *_around(5.0 * pressure)
        yield f"debris to all, {name}", given, "debris_fraction", 1.0 - 2.0 * about, 1.0
        if all(smooth.indenter.even) and given is not WAVY:
            slid = moved | {"wear_coefficient": [3e-14, 3e-14]}
            slid.pop("tangential_compliance", None)
            yield (
                f"small strokes, {name}",
                slid,
                "sliding_amplitude",
                *_around(SMALL_STROKE * smooth.hertz_radius),
            )
    yield "X near 0, sphere", SPHERE, "tangential_ratio", 0.1, 0.102
    yield "radius of the flat", ROUND, "indenter.flat_radius", *_around(60e-6)
    yield "width of the flat", FLAT, "indenter.flat_half_width", *_around(200e-6)
    yield "angle to 90 degrees", CROSSED, "indenter.angle", math.radians(89.5), math.radians(90.0)
    yield "ellipse through circle", ELLIPSE, "indenter.radius_y", *_around(10e-3)
    yield "amplitude of waves", WAVY, "roughness.amplitude", *_around(2e-7)
    yield "amplitude of ripples", RIPPLED, "roughness.amplitude", *_around(2e-7)
    yield "Poisson's ratio to 0.5", SPHERE, "poisson_ratio", 0.49, 0.5


def _around(value: float) -> tuple[float, float]:
    return (1.0 - 0.5 * WIDTH) * value, (1.0 + 0.5 * WIDTH) * value


def swept(given: Given, name: str, low: float, high: float, folder: Path) -> dict[str, float]:
    """The largest jump of each scalar along a parameter, in units of its stated error.

    A jump is by how much a difference of neighbours is off the mean of those before and after it,
    which is nothing along a curve of constant curvature. It counts if it is larger than the error
    that is stated for the values, and than `LEAST_JUMP`.
    """
    part, _, field = name.partition(".")
    rows = []
    for value in np.linspace(low, high, STEPS).tolist():
        changed = {**given, name: value}
        if field:
            del changed[name]
            changed[part] = {**given[part], field: value}
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            rows.append(run(case_of(changed, folder)).dataset.isel(cycle=-1))
    found = {}
    # The stick zone of a flat end is at least as wide as that, and then none.
    vanishes = "punch" in given["indenter"]["kind"] and len({float(row.regime) for row in rows}) > 1
    for scalar in (each.name for each in SCALARS if each.is_headline):
        if vanishes and scalar.startswith("stick"):
            continue
        if scalar == "regime" or any(scalar not in row for row in rows):
            continue
        values, errors = (np.array([float(row.get(each, 0.0)) for row in rows])
                          for each in (scalar, f"{scalar}_error"))  # fmt: skip
        steps = np.diff(values)
        jumps = np.abs(steps[1:-1] - 0.5 * (steps[:-2] + steps[2:]))
        stated = np.maximum(errors[1:-2], errors[2:-1]) + LEAST_JUMP * np.abs(values).max() + 1e-300
        found[scalar] = float((jumps / stated).max())
    return found


def places(given: Given) -> list[str]:
    """The names of the numbers among the parameters of a case that can be swept."""
    own = [
        name for name, value in given.items() if isinstance(value, float) and name != "tolerance"
    ]
    for part, values in given.items():
        if isinstance(values, dict) and "kind" in values:
            own += [
                f"{part}.{field}" for field, value in values.items() if isinstance(value, float)
            ]
    return [name for name in own if value_at(given, name)]


def value_at(given: Given, name: str) -> float:
    part, _, field = name.partition(".")
    return float(given[part][field] if field else given[part])


def sweeps(seed: int, count: int, folder: Path) -> Iterator[Sweep]:
    """Yield the sweeps: across thresholds, then any parameter of random cases."""
    yield from thresholds()
    for number in range(count):
        draw = Draw(seed, number + 1_000_000, folder)
        given, _ = draw.case()
        name = draw.one_of(*places(given))
        yield (
            f"{number}: {name}",
            given | {"error_estimate": True},
            name,
            *_around(value_at(given, name)),
        )


def main() -> int:
    """Judge cases and sweeps, print the tables."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--cases", type=int, default=CASES)
    parser.add_argument("--sweeps", type=int, default=SWEEPS, help="beside those across thresholds")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--first", type=int, default=0, help="the number of the first case")
    parser.add_argument("--only", type=int, help="the number of one case, which is shown")
    options = parser.parse_args()
    with tempfile.TemporaryDirectory() as place:
        folder = Path(place)
        if options.only is not None:
            given, _ = Draw(options.seed, options.only, folder).case()
            print(given)
            return int(report_of([options.only], options.seed, folder))
        broken = report_of(
            range(options.first, options.first + options.cases), options.seed, folder
        )
        return int(broken | report_of_sweeps(options.seed, options.sweeps, folder))


def report_of(numbers: Iterable[int], seed: int, folder: Path) -> bool:
    """Print the violations of each case, then a table of all laws; whether one was violated."""
    found: dict[str, list[tuple[float, int]]] = {}
    for number in numbers:
        given, case = Draw(seed, number, folder).case()
        began = time.perf_counter()
        worst, trouble = judged(given, folder)
        seconds = time.perf_counter() - began
        for law, violation in worst.items():
            found.setdefault(law, []).append((violation, number))
        broken = [f"{law} ({most:.3g} x)" for law, most in worst.items() if most > 1.0]
        if broken or trouble or seconds > LONGEST:
            last = trouble.strip().splitlines()[-1:]
            print(
                f"{number}: {case.case_id}, {seconds:.0f} s",
                *broken,
                *last,
                sep="\n    ",
                flush=True,
            )
    print(
        "| law | cases | violated | worst, of what is allowed | case |\n|---|---:|---:|---:|---:|"
    )
    for law, violations in sorted(found.items()):
        most, number = max(violations)
        count = sum(each > 1.0 for each, _ in violations)
        print(f"| {law} | {len(violations)} | {count} | {most:.2g} | {number} |")
    return any(max(each)[0] > 1.0 for each in found.values())


def report_of_sweeps(seed: int, count: int, folder: Path) -> bool:
    """Print the largest jump along each swept parameter; whether one is more than is stated."""
    print("| swept | result | jump, of what is stated |\n|---|---|---:|")
    broken = False
    for words, *sweep in sweeps(seed, count, folder):
        try:
            jumps = swept(*sweep, folder)
        except CaseError:
            continue
        name, most = max(jumps.items(), key=lambda each: each[1])
        broken |= most > 1.0
        print(f"| {words} | {name} | {most:.2f} |", flush=True)
    return broken


if __name__ == "__main__":
    sys.exit(main())
