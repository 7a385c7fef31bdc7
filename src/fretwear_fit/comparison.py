"""Measurements beside predictions: whitened residuals, with the base line taken out of them."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np
import xarray as xr

from fretwear.arrays import Array
from fretwear.results import CYCLE
from fretwear.units import cycle_text
from fretwear_fit.noise import UNIT, Noise, NoiseEvidence
from fretwear_fit.request import BASELINE, Measurement

# Points of the grid of a signal, over cells: a scar is interpolated twice.
_FINER, _MOST_POINTS, _ROOM = 4, 4001, 0.5
_SHIFTS, _CLOSE = 21, 1e-7
# A profile is unworn where the prediction is shallower than this part of its depth.
_UNWORN, _FEWEST_UNWORN = 0.01, 12
# Displacements of a loop without a noise of their own are known to this part of the amplitude.
_FIRM = 1e-3
_NEAR_ENDS = 4.0  # displacements, in units of noise
_ROUNDING = 1e-6  # numerical error that does not count
_SEEN = 15.0  # fall of χ² by a scar that noise has at some place with a probability of 0.1 %
_SMALL = 1e-4  # change of a loop for derivatives, over its size


@dataclass(frozen=True)
class Comparison:
    """A measurement, its noise, and the numerical error of what is compared with it.

    A *signal* is what a run predicts for it on a fixed grid, shape (g,): depths along the line, the
    points of a loop, or a number. *Nuisances* are what is found beside it without a run: offset,
    tilt and shift of the base line; with Gaussian priors, the relative numerical errors of depth
    and width.
    """

    measurement: Measurement
    cycle: float
    noise: Noise = UNIT  # of a profile
    deviations: tuple[float, float] = (0.0, 0.0)  # of depth and width, relative; of a number, both
    grid: Array = field(default_factory=lambda: np.zeros(0))  # positions of a profile's signal
    evidence: NoiseEvidence | None = None  # what the noise was estimated from
    is_placed: bool = False  # whether the scar lies at x = 0, because the readings do not show it

    @classmethod
    def of(cls, measurement: Measurement, prediction: xr.Dataset) -> Comparison:
        """Begin with a measurement and the first prediction, which tells how fine a grid is."""
        last = float(prediction[CYCLE.name][-1])
        cycle = last if measurement.cycle is None else measurement.cycle
        if not measurement.is_profile:
            return cls(measurement, cycle).with_errors(prediction)
        x, depth = measurement.readings
        cells = prediction[measurement.along].values
        reach = _ROOM * (x[-1] - x[0])
        count = _FINER * (x[-1] - x[0] + 2.0 * reach) / (cells[1] - cells[0])
        points = int(np.clip(count, 401, _MOST_POINTS))
        center = _center(measurement)
        grid = np.linspace(x[0] - center - reach, x[-1] - center + reach, points)
        # A first guess: readings that scatter by a part of the depth.
        size = measurement.noise or 0.05 * float(np.ptp(depth))
        noise = Noise(size, measurement.correlation_length or 0.0)
        return cls(measurement, cycle, noise, grid=grid).with_errors(prediction)

    def with_errors(self, prediction: xr.Dataset) -> Comparison:
        """The comparison with the numerical errors of a prediction: half of what it states."""
        state = prediction.sel({CYCLE.name: self.cycle})

        def deviation(name: str) -> float:
            error = 0.5 * float(state.get(f"{name}_error", 0.0))
            return error if np.isfinite(error) else 0.0

        def relative(name: str) -> float:
            value = float(state.get(name, 0.0))
            return deviation(name) / value if value else 0.0

        of = self.measurement
        if of.is_profile:
            volume = of.quantity.replace("depth", "volume")
            volume = volume if volume in state else "wear_volume"
            deviations = relative(volume), relative(f"contact_half_width_{of.along}")
        elif of.is_loop:
            deviations = relative("tangential_force"), relative("tangential_displacement")
        else:
            deviations = (deviation(of.quantity),) * 2
        return replace(self, deviations=deviations)

    def signal(self, prediction: xr.Dataset) -> Array:
        """What a run predicts for the measurement, shape (g,)."""
        of, state = self.measurement, prediction.sel({CYCLE.name: self.cycle})
        if of.is_profile:
            x, depth = state[of.along].values, state[f"{of.quantity}_{of.along}"].values
            return np.asarray(np.interp(self.grid, x, depth, left=0.0, right=0.0))
        if of.is_loop:
            return _evenly_along(state["displacement"].values, state["force"].values)
        return np.array([float(state[of.quantity])])

    @property
    def title(self) -> str:
        """Quantity, cycle and test."""
        of = self.measurement
        return f"{of.quantity.replace('_', ' ')} at cycle {cycle_text(self.cycle)}, test {of.test}"

    @property
    def names(self) -> tuple[str, ...]:
        """The names of the nuisances: of the base line, then of numerical errors."""
        of = self.measurement
        if of.is_profile:
            free = {*of.baseline} - ({"shift"} if self.is_placed else set())
        elif of.is_loop:
            free = {*of.baseline} & {"offset", "shift"}
        else:
            return ()
        pairs = zip(("depth", "width"), self.deviations, strict=True)
        errors = (name for name, deviation in pairs if deviation > _ROUNDING)
        return (*(name for name in BASELINE if name in free), *errors)

    @property
    def degrees(self) -> int:
        """Degrees of freedom: readings less what is free of the base line."""
        return self.measurement.readings[0].size - len({*self.names} & {*BASELINE})

    def modelled(self, signal: Array, nuisances: Array) -> Array:
        """The readings that a signal and a base line would give, shape (n,).

        A profile is (1 + ε) w((x − s)/(1 + ω)) + offset + tilt (x − x̄), with the shift s and the
        relative numerical errors ε and ω; a loop has forces where it is nearest to the readings.
        """
        of, nuisance = self.measurement, dict(zip(self.names, nuisances, strict=True))
        if of.is_loop:
            return self._nearest_on_the_loop(signal, nuisances)[0]
        if not of.is_profile:
            return signal
        x = of.readings[0]
        places = (x - nuisance.get("shift", 0.0)) / (1.0 + nuisance.get("width", 0.0))
        worn = (1.0 + nuisance.get("depth", 0.0)) * np.interp(places, self.grid, signal)
        offset, tilt = nuisance.get("offset", 0.0), nuisance.get("tilt", 0.0)
        fitted: Array = worn + offset + tilt * (x - x.mean())
        return fitted

    def residuals(self, signal: Array, nuisances: Array) -> Array:
        """Whitened residuals, shape (n + k,); the last k stand for numerical errors."""
        of, priors = self.measurement, dict(zip(("depth", "width"), self.deviations, strict=True))
        pairs = zip(self.names, nuisances, strict=True)
        of_errors = [value / priors[name] for name, value in pairs if name in priors]
        if of.is_profile:
            x, depth = of.readings
            missed = (depth - self.modelled(signal, nuisances))[:, None]
            missed = self.noise.whitened(x, missed)[:, 0]
        elif of.is_loop:
            missed = self._nearest_on_the_loop(signal, nuisances)[1]
        else:
            missed = (of.value - signal) / np.hypot(of.error, self.deviations[0])
        return np.concatenate([missed, of_errors])

    def _nearest_on_the_loop(self, signal: Array, nuisances: Array) -> tuple[Array, Array]:
        """Forces where the loop is nearest to each reading, and distances in units of noise.

        Each reading belongs to the half in which its displacement falls or rises, else noise as
        wide as a loop would be nearer to both halves; near the ends it may belong to either.
        """
        of, nuisance = self.measurement, dict(zip(self.names, nuisances, strict=True))
        where, force = np.split(signal, 2)
        where = (1.0 + nuisance.get("width", 0.0)) * where + nuisance.get("shift", 0.0)
        force = (1.0 + nuisance.get("depth", 0.0)) * force + nuisance.get("offset", 0.0)
        scale = of.noise or _FIRM * float(np.ptp(of.readings[0])), of.force_noise or 1.0
        points = np.column_stack(of.readings) / scale
        corners = np.column_stack([where, force]) / scale
        sides = np.roll(corners, -1, axis=0) - corners
        lengths = np.maximum((sides**2).sum(axis=1), 1e-300)
        # Arrays of readings by sides.
        (x, y), (over, up) = (points.T[:, :, None] - corners.T[:, None]), sides.T
        along = np.clip((x * over + y * up) / lengths, 0.0, 1.0)
        x, y = x - along * over, y - along * up
        squares = x**2 + y**2
        half, (measured, _) = sides.shape[0] // 2, of.readings
        ends = measured.min() + _NEAR_ENDS * scale[0], measured.max() - _NEAR_ENDS * scale[0]
        inside = (measured > ends[0]) & (measured < ends[1])
        falls = np.arange(measured.size) <= measured.argmin()
        squares[inside & falls, half:] = np.inf
        squares[inside & ~falls, :half] = np.inf
        sides_of = squares.argmin(axis=1)
        nearest = np.arange(len(points)), sides_of
        # A normal that turns along each side has one sign around a corner.
        normals = np.column_stack([-up, over]) / np.sqrt(lengths)[:, None]
        normals += np.roll(normals, 1, axis=0)
        share = along[nearest][:, None]
        following = np.roll(normals, -1, axis=0)
        turned = (1.0 - share) * normals[sides_of] + share * following[sides_of]
        sign = np.sign(x[nearest] * turned[:, 0] + y[nearest] * turned[:, 1])
        return (points[:, 1] - y[nearest]) * scale[1], sign * np.sqrt(squares[nearest])

    @cached_property
    def steps(self) -> Array:
        """Steps of the nuisances for their derivatives, and to scale them."""
        x, depth = self.measurement.readings
        wide, deep = float(np.ptp(x)), float(np.ptp(depth)) or self.noise.size
        if self.measurement.is_loop:
            heights = {"offset": deep, "shift": wide}
            return np.array([_SMALL * heights.get(name, 1.0) for name in self.names])
        sizes = {"offset": 0.01 * deep, "tilt": 0.01 * deep / wide, "shift": 2e-3 * wide}
        return np.array([{**sizes, "depth": 1e-3, "width": 1e-3}[name] for name in self.names])

    def slopes(self, signal: Array, nuisances: Array) -> Array:
        """Derivatives of the residuals by the nuisances, shape (n + k, m)."""
        columns = []
        for place, step in enumerate(self.steps if self.names else ()):
            ahead, behind = nuisances.copy(), nuisances.copy()
            ahead[place] += step
            behind[place] -= step
            change = self.residuals(signal, ahead) - self.residuals(signal, behind)
            columns.append(change / (2.0 * step))
        rows = self.residuals(signal, nuisances).size
        return np.column_stack(columns) if columns else np.zeros((rows, 0))

    def settled(self, signal: Array, start: Array | None = None) -> Array:
        """The nuisances with the least sum of squares for a signal.

        Without a start, a loop is searched from its middle on, and a profile from the shift at
        which a scar of this form, however deep, explains most of the readings.
        """
        from scipy.optimize import least_squares

        names, readings = np.array(self.names), self.measurement.readings
        if not names.size:
            return np.zeros(0)
        if start is None and self.measurement.is_loop:
            force, where = (0.5 * (each.min() + each.max()) for each in readings[::-1])
            start = force * (names == "offset") + where * (names == "shift")
        elif start is None and "shift" in names:
            start = self._shift_of(signal) * (names == "shift")
        found = least_squares(
            lambda nuisances: self.residuals(signal, nuisances),
            np.zeros(names.size) if start is None else start,
            lambda nuisances: self.slopes(signal, nuisances),
            method="lm",
            x_scale=self.steps,
            ftol=_CLOSE,
        )
        return np.asarray(found.x)

    def _shift_of(self, signal: Array) -> float:
        """The shift at which a multiple of a scar, besides a base line, fits the readings best.

        At its own depth, a scar that is much too deep would fit best beyond the readings.
        """
        x, depth = self.measurement.readings
        names = np.array(self.names)
        shifts = np.linspace(-1.0, 1.0, _SHIFTS) * _ROOM * (x[-1] - x[0])
        shifts += _center(self.measurement)
        scars = [self.modelled(signal, shift * (names == "shift")) for shift in shifts]
        trend = [c for n, c in (("offset", x**0), ("tilt", x - x.mean())) if n in names]
        rows = self.noise.whitened(x, np.column_stack([*scars, depth, *trend]))
        *scars, depth = without_nuisances(rows, _SHIFTS + 1).T
        falls = [max(scar @ depth, 0.0) / max(np.sqrt(scar @ scar), 1e-300) for scar in scars]
        return float(shifts[int(np.argmax(falls))])

    def misfit(self, signal: Array, nuisances: Array) -> float:
        """Sum of squares of the residuals."""
        rest = self.residuals(signal, nuisances)
        return float(rest @ rest)

    def by_signal(self, signal: Array, nuisances: Array, change: Array) -> Array:
        """Change of the residuals with a small change of the signal, shape (n + k,)."""
        # Residuals of a profile are linear; distances from a loop are, in small changes of it only.
        kinds = 2 if self.measurement.is_loop else 1
        parts = zip(np.split(signal, kinds), np.split(change, kinds), strict=True)
        share = max(float(np.abs(moved).max() / (np.ptp(part) or 1.0)) for part, moved in parts)
        step = _SMALL / (share or 1.0)
        ahead = self.residuals(signal + step * change, nuisances)
        return (ahead - self.residuals(signal - step * change, nuisances)) / (2.0 * step)

    def drawn(self, signal: Array, nuisances: Array, generator: np.random.Generator) -> Array:
        """Readings that a signal would give, with noise, shape (n,)."""
        of, fitted = self.measurement, self.modelled(signal, nuisances)
        if not of.is_profile:
            scale = of.error or of.force_noise or 0.0
            return fitted + generator.normal(scale=scale, size=fitted.size)
        return fitted + self.noise.drawn(of.readings[0], generator)

    def with_place(self, signal: Array) -> Comparison:
        """The comparison with the scar at x = 0 if noise could look like the one that was found.

        Among all places along the line, noise has bumps that a small scar fits.
        """
        if "shift" not in self.names or _center(self.measurement):
            return self
        misfits = (self.misfit(s, self.settled(s)) for s in (0.0 * signal, signal))
        return replace(self, is_placed=next(misfits) - next(misfits) < _SEEN)

    def with_noise_beside(self, signal: Array, nuisances: Array) -> Comparison:
        """The comparison with the noise beside the scar, of all readings if few lie there."""
        of = self.measurement
        has_noise = of.noise is not None and of.correlation_length is not None
        if not of.is_profile or has_noise:
            return self
        x, depth = of.readings
        worn = self.modelled(signal, nuisances * ~np.isin(self.names, ("offset", "tilt")))
        unworn, is_beside = worn < _UNWORN * max(signal.max(), 1e-300), True
        if unworn.sum() < _FEWEST_UNWORN:
            unworn, is_beside = np.ones(x.size, bool), False
        rest, trend = (depth - worn)[unworn], np.vander(x[unworn] - x.mean(), 2)
        known = of.noise, of.correlation_length
        evidence = NoiseEvidence(x[unworn], rest, trend, *known, is_beside)
        return replace(self, noise=evidence.best(), evidence=evidence)

    def derivatives(self, signal: Array, nuisances: Array, changes: Array) -> Array:
        """Derivatives of residuals by changes of the signal, then nuisances, (n + k, p + m)."""
        by_signal = [self.by_signal(signal, nuisances, change) for change in changes]
        return np.column_stack([*by_signal, self.slopes(signal, nuisances)])


def without_nuisances(columns: Array, count: int) -> Array:
    """The first columns without what the others, derivatives by nuisances, take up."""
    moved, of_nuisances = np.split(columns, [count], axis=1)
    q, _ = np.linalg.qr(of_nuisances)
    return np.asarray(moved - q @ (q.T @ moved))


def _evenly_along(displacement: Array, force: Array) -> Array:
    """Points of a loop, evenly along each of its halves: displacements, then forces.

    So each of them moves smoothly with the parameters, wherever the run has solved a contact.
    """
    turn, count = int(displacement.argmin()), displacement.size // 2 + 1
    steps = [np.diff(values) / np.ptp(values) for values in (displacement, force)]
    along = np.append(0.0, np.cumsum(np.hypot(*steps)))
    down, up = np.linspace(0.0, along[turn], count), np.linspace(along[turn], along[-1], count)
    places = np.concatenate([down, up[1:]])
    return np.concatenate([np.interp(places, along, values) for values in (displacement, force)])


def _center(measurement: Measurement) -> float:
    """Where a scar is sought: at 0, or amid readings that are all on one side of it."""
    low, high = float(measurement.readings[0].min()), float(measurement.readings[0].max())
    is_free = measurement.is_profile and "shift" in measurement.baseline
    return 0.5 * (low + high) if is_free and not low <= 0.0 <= high else 0.0
