"""The best parameters by least squares, and their intervals by the profile likelihood."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from fretwear.arrays import Array
from fretwear_fit.comparison import Comparison, without_nuisances
from fretwear_fit.emulator import NEAR, Emulator
from fretwear_fit.noise import UNIT, Noise
from fretwear_fit.request import Unknown

LEVELS = (0.68, 0.9, 0.95)
"""Probabilities of the intervals."""

_STEP = 0.04  # of a derivative, in logarithms or parts of a range
_MOST_STEPS = 30
_CURVED = 0.3  # part of a change of a signal that its derivatives miss, after which they are anew
_ELSEWHERE = (0.02, 0.04, 0.08)  # steps, likewise, at which another minimum is sought
_FLAT, _SAME = 1e-2, 5e-3  # least relative change of χ², and of parameters
_INVALID = 1e3  # residual of parameters that make no case
_DIGITS = 10  # of the parameters of a run
# Places of the runs that intervals rest on, in standard deviations.
_OUT = 1.645
_NARROWEST = 0.008  # least step of these runs
_LEAST_ROOM = 0.02  # of the range beside the best parameters, in parts of a step
_FAR = 0.4  # standard deviations after which the runs around the best parameters are made anew
_MOST_MOVES = 3
# Logarithm of a ratio of standard deviations with which the runs lie where they should.
_ALIKE = 0.3
# Standard deviations from all runs at which ends of intervals, and the best parameters, are run.
_UNCHECKED, _SETTLED = 0.5, 0.05
# Values of a profile, in standard deviations, up to this part of the highest rise of χ² asked for.
_REACHES, _BEYOND = (0.4, 0.8, 1.2, 1.6, 2.0, 2.6, 3.3, 4.5, 6.0, 9.0, 15.0, 30.0, 100.0), 1.8
_FALLEN = 0.5  # fall of χ² along a profile that is another minimum
_NOISES = 256  # draws of the noise
# Parts of all runs after which each stage ends; the rest checks draws.
SEARCH, MOVES, AROUND, ENDS = 0.4, 0.6, 0.75, 0.9
_RISE = 2.71  # of χ² at the ends of an interval of 90 %
TOLERATED = 0.2  # error of an emulated rise of χ², over the rise or the one above


class _SpentError(Exception):
    """A stage has made all of its runs."""


class Fitter:
    """Least squares of measurements on the parameters of runs."""

    def __init__(
        self,
        unknowns: Sequence[Unknown],
        comparisons: Sequence[Comparison],
        signals: Callable[[Sequence[Array]], list[list[Array] | None]],
        tell: Callable[[str], None] = lambda _: None,
        runs: int = 40,
    ) -> None:
        """Begin; `signals` runs parameters and gives the signal of each measurement or None.

        `tell` takes a line of text about each run, of which at most `runs` are made.
        """
        self.runs, self._most = runs, runs
        self.unknowns, self._signals, self._tell = unknowns, signals, tell
        self.settled: list[Array | None]
        self.compare(comparisons)
        ends = np.array([unknown.ends for unknown in unknowns])
        self.lower, self.upper = ends.T
        self.signals_of: dict[bytes, tuple[Array, Array | None]] = {}
        self.sizes: list[int] = []
        self._tangent: tuple[Array, Array, Array] | None = None

    @property
    def left(self) -> int:
        """Number of runs that are left."""
        return max(self._most - len(self.signals_of), 0)

    def keep(self, share: float) -> None:
        """Make runs up to a share of all of them."""
        self._most = int(share * self.runs)

    def signals_at(self, points: Sequence[Array]) -> list[Array | None]:
        """The signals of all measurements, one after the other, at some parameters.

        None where they make no case, or no run is left.
        """
        points = [np.round(u, _DIGITS) + 0.0 for u in points]
        new = {u.tobytes(): u for u in points if u.tobytes() not in self.signals_of}
        new = dict([*new.items()][: self.left])
        for (key, u), signals in zip(new.items(), self._signals([*new.values()]), strict=True):
            pairs = zip(self.unknowns, u, strict=True)
            values = ", ".join(f"{of.name} = {float(of.value(x)):.4g}" for of, x in pairs)
            if signals is None:
                self.signals_of[key] = u, None
                self._tell(f"{values}: makes no case")
                continue
            self.sizes = [part.size for part in signals]
            self.signals_of[key] = u, np.concatenate(signals)
            parts = zip(self.comparisons, signals, self.settled, strict=True)
            misfit = sum(c.misfit(part, c.settled(part, start)) for c, part, start in parts)
            self._tell(f"{values}: χ² = {misfit:.4g}")
        return [self.signals_of.get(u.tobytes(), (u, None))[1] for u in points]

    def split(self, signal: Array) -> list[Array]:
        """The signal of each measurement, or its changes in several columns."""
        return np.split(signal, np.cumsum(self.sizes)[:-1])

    def parts(self, signal: Array) -> list[tuple[Comparison, Array, Array]]:
        """Each measurement with its signal and the nuisances that suit it best."""
        pairs = [*zip(self.comparisons, self.split(signal), strict=True)]
        starts = zip(pairs, self.settled, strict=True)
        settled = [comparison.settled(part, start) for (comparison, part), start in starts]
        self.settled = [*settled]
        return [(*both, nuisances) for both, nuisances in zip(pairs, settled, strict=True)]

    def compare(self, comparisons: Sequence[Comparison]) -> None:
        """Go on with other noises, places or errors of the measurements."""
        self.comparisons, self.settled = [*comparisons], [None] * len(comparisons)

    def residuals(self, signal: Array) -> Array:
        """Whitened residuals of all measurements at the best nuisances."""
        return np.concatenate([c.residuals(s, n) for c, s, n in self.parts(signal)])

    def misfit(self, signal: Array) -> float:
        """χ²: the sum of squares of the residuals."""
        rest = self.residuals(signal)
        return float(rest @ rest)

    def projected(self, signal: Array, changes: Array) -> Array:
        """Derivatives of the residuals by changes of the signal, without what nuisances take up.

        Kaufman's approximation of variable projection (BIT 15, 1975).
        """
        parts = zip(self.parts(signal), self.split(changes), strict=True)
        slopes = [c.derivatives(s, n, moved.T) for (c, s, n), moved in parts]
        return np.concatenate([without_nuisances(rows, changes.shape[1]) for rows in slopes])

    def derivatives(self, u: Array, signal: Array) -> Array:
        """Derivatives of the signal by finite differences, shape (g, p); one run each."""
        steps = np.where(u + _STEP > self.upper, -_STEP, _STEP)
        points = [u + step * row for step, row in zip(steps, np.eye(u.size), strict=True)]
        columns = [
            (ahead - signal) / step if ahead is not None else np.zeros_like(signal)
            for ahead, step in zip(self.signals_at(points), steps, strict=True)
        ]
        return np.column_stack(columns)

    def best(self, start: Array) -> Array:
        """Return the parameters with the least χ², of the runs that are left.

        Derivatives follow the steps (C. G. Broyden, Math. Comp. 19, 1965), and are anew after steps
        along which signals bend.
        """
        from scipy.optimize import least_squares

        start = np.clip(start, self.lower + 1e-6, self.upper - 1e-6)
        rows = self.residuals(self.signal(start)).size
        # From a place at distance 1 of the origin the first step is at most a factor e.
        origin = start - 1.0 / np.sqrt(start.size)

        def missed(step: Array) -> Array:
            signal = self.signals_at([origin + step])[0]
            if signal is None and not self.left:
                raise _SpentError
            return np.full(rows, _INVALID) if signal is None else self.residuals(signal)

        def slopes(step: Array) -> Array:
            u = origin + step
            signal = self.signal(u)
            return self.projected(signal, self._followed(u, signal))

        ends = self.lower - origin, self.upper - origin
        tolerances = {"ftol": _FLAT, "xtol": _SAME, "max_nfev": _MOST_STEPS}
        try:
            step = least_squares(missed, start - origin, slopes, ends, **tolerances).x
        except _SpentError:
            runs = [(u, s) for u, s in self.signals_of.values() if s is not None]
            return min(runs, key=lambda run: self.misfit(run[1]))[0]
        return np.asarray(origin + step)

    def elsewhere(self, best: Array) -> Array:
        """The parameters with the least χ² once runs at some distances have sought another minimum.

        Where a scar has a steep front, χ² has ripples: one each time that the front passes a cell.
        """
        rows = [row for step in _ELSEWHERE for row in step * np.eye(best.size)]
        points = [best + sign * row for row in rows for sign in (-1.0, 1.0)]
        points = [best, *(np.clip(u, self.lower + 1e-6, self.upper - 1e-6) for u in points)]
        misfits = [
            np.inf if signal is None else self.misfit(signal) for signal in self.signals_at(points)
        ]
        lowest = int(np.argmin(misfits))
        return self.best(points[lowest]) if lowest else best

    def _followed(self, u: Array, signal: Array) -> Array:
        """Derivatives of the signal, updated by the last step where it is nearly straight."""
        derivatives = None
        if self._tangent is not None:
            from_u, from_signal, derivatives = self._tangent
            step, change = u - from_u, signal - from_signal
            missed = change - derivatives @ step
            parts = [*zip(self.split(missed), self.split(change), strict=True)]
            if any(np.linalg.norm(m) > _CURVED * np.linalg.norm(c) for m, c in parts):
                derivatives = None
            elif step.any():
                derivatives = derivatives + np.outer(missed, step) / (step @ step)
        if derivatives is None:
            if self.left < u.size:
                raise _SpentError
            derivatives = self.derivatives(u, signal)
        self._tangent = u, signal, derivatives
        return derivatives

    def signal(self, u: Array) -> Array:
        """The signals of all measurements at parameters that make a case."""
        signal = self.signals_at([u])[0]
        assert signal is not None
        return signal

    def covariance(self, slopes: Array) -> Array:
        """The covariance of the parameters by a linear model; unknown directions are wide.

        `slopes` are derivatives of the residuals without what nuisances take up, shape (n, p).
        """
        # A range is a uniform prior, about as wide as this normal one.
        widths = (self.upper - self.lower) / np.sqrt(12.0)
        prior = np.diag(1.0 / widths)
        both = np.concatenate([slopes, prior])
        return np.asarray(np.linalg.inv(both.T @ both))

    def spread(self, signal: Array, derivatives: Array) -> Array:
        """Variances of the parameters with noises that the readings allow, shape (m, p).

        They are divided by those with the noise that was taken, so that a parameter of which the
        noise tells the variance v has the distribution Σ N(û, v s_j)/m: Student's where the size of
        the noise alone is estimated.
        """
        evidences = [comparison.evidence for comparison in self.comparisons]
        if all(evidence is None for evidence in evidences):
            return np.ones((1, len(self.unknowns)))
        # Not whitened yet: residuals of a profile are in m.
        pairs = zip(self.parts(signal), self.split(derivatives), strict=True)
        parts = [replace(c, noise=UNIT).derivatives(s, n, moved.T) for (c, s, n), moved in pairs]

        def variances(noises: Sequence[Noise]) -> Array:
            slopes = []
            for comparison, columns, noise in zip(self.comparisons, parts, noises, strict=True):
                if comparison.measurement.is_profile:
                    x, _ = comparison.measurement.readings
                    readings = noise.whitened(x, columns[: x.size])
                    columns = np.concatenate([readings, columns[x.size :]])
                slopes.append(without_nuisances(columns, len(self.unknowns)))
            return np.diag(self.covariance(np.concatenate(slopes)))

        taken = [comparison.noise for comparison in self.comparisons]
        # A Latin hypercube: each share of probability once for every length and size.
        generator, places = np.random.default_rng(0), (np.arange(_NOISES) + 0.5) / _NOISES
        columns = [
            [noise] * _NOISES
            if evidence is None
            else evidence.drawn(np.column_stack([generator.permutation(places) for _ in range(2)]))
            for evidence, noise in zip(evidences, taken, strict=True)
        ]
        allowed = [variances(noises) for noises in zip(*columns, strict=True)]
        return np.array(allowed) / variances(taken)

    def emulator(self, u: Array) -> tuple[Emulator, Array]:
        """Return an emulator of the runs around the best parameters, and derivatives there.

        Its runs lie where intervals end. If these turn out to end elsewhere, or the best parameters
        to lie there, the runs are made anew.
        """
        ends = np.array([self.lower, self.upper])
        derivatives = self._followed(u, self.signal(u))
        for _ in range(_MOST_MOVES):
            signal = self.signal(u)
            guess = self.covariance(self.projected(signal, derivatives))
            derivatives = self._along(u, signal, guess, derivatives)
            self._tangent = u, signal, derivatives
            covariance = self.covariance(self.projected(signal, derivatives))
            emulator = Emulator(u, covariance)
            near = [
                (place, moved)
                for place, moved in self.signals_of.values()
                if moved is not None and np.abs(emulator.at(place)).max() < NEAR
            ]
            self.teach(emulator, *zip(*near, strict=True))
            while self.left:
                moved = emulator.minimum(emulator.best, ends)
                if emulator.distance(moved) < _FAR:
                    break
                self.check(emulator, [moved])
            if np.abs(emulator.at(emulator.best)).max() > _FAR:
                u = emulator.best
                continue
            ratios = np.diag(covariance) / np.diag(guess)
            if np.abs(np.log(ratios)).max() < _ALIKE:
                break
        return emulator, derivatives

    def teach(
        self, emulator: Emulator, points: Sequence[Array], signals: Sequence[Array | None]
    ) -> None:
        """Have an emulator take in the runs among these that made a case."""
        runs = [(u, s) for u, s in zip(points, signals, strict=True) if s is not None]
        emulator.learn(
            [u for u, _ in runs], [self.residuals(s) for _, s in runs], [s for _, s in runs]
        )

    def _along(self, u: Array, signal: Array, covariance: Array, derivatives: Array) -> Array:
        """Derivatives from runs on both sides of the best parameters, along its covariance.

        Where no run is made, they stay.
        """
        deviations = np.sqrt(np.diag(covariance))
        directions = covariance / deviations * np.maximum(_OUT, _NARROWEST / deviations)
        places: list[tuple[int, float]] = []
        for place, column in enumerate(directions.T):
            for sign in (1.0, -1.0):
                room = np.where(column * sign > 0.0, self.upper - u, u - self.lower)
                share = 0.98 * float((room / np.maximum(np.abs(column), 1e-300)).min())
                if share > _LEAST_ROOM:
                    places.append((place, sign * min(share, 1.0)))
        points = [u + share * directions[:, place] for place, share in places]
        found: list[dict[float, Array]] = [{0.0: signal} for _ in u]
        for (place, share), moved in zip(places, self.signals_at(points), strict=True):
            if moved is not None:
                found[place][share] = moved
        columns = [*(derivatives @ directions).T]
        for place, runs in enumerate(found):
            if len(runs) > 1:
                shares = sorted(runs)
                slopes = np.gradient([runs[share] for share in shares], shares, axis=0)
                columns[place] = slopes[shares.index(0.0)]
        return np.asarray(np.column_stack(columns) @ np.linalg.inv(directions))

    def intervals(self, emulator: Emulator, spread: Array) -> tuple[list[Profile], float]:
        """The profile likelihood of each parameter, its ends and its best value checked by runs.

        The error of rises of χ² follows: 0 if runs lie at all ends. Profiles are wider by it.
        """
        error, ends = 0.0, np.array([self.lower, self.upper])

        def profiles(spread: Array) -> list[Profile]:
            columns = enumerate(spread.T)
            return [self._profile(emulator, place, ends, column) for place, column in columns]

        while True:
            found = profiles(spread)
            trials = [(emulator.minimum(emulator.best, ends), _SETTLED)]
            trials += [(u, _UNCHECKED) for p in found for u in p.ends_at(LEVELS[1])]
            new = [u for u, farthest in trials if emulator.distance(u) > farthest]
            if not new:
                return found, 0.0
            if not self.left:
                return profiles(spread * (1.0 + error)) if error > TOLERATED else found, error
            error = self.check(emulator, new)

    def check(self, emulator: Emulator, points: Sequence[Array]) -> float:
        """Run parameters for an emulator: largest error of a rise of χ² before it learns them.

        An error is relative to the rise or, of small rises, the one at the ends of 90 %.
        """
        signals, emulated = self.signals_at(points), emulator.misfit(np.array(points))
        errors = [0.0]
        for signal, misfit in zip(signals, emulated, strict=True):
            if signal is not None:
                run = self.misfit(signal)
                errors.append(abs(run - misfit) / max(run - emulator.least, _RISE))
        self.teach(emulator, points, signals)
        return float(max(errors))

    def _profile(self, emulator: Emulator, place: int, ends: Array, spread: Array) -> Profile:
        """Signed roots of the rise of χ² over values of one parameter, the others at their best."""
        least = float(emulator.misfit(emulator.best))
        deviation = float(emulator.deviations[place])
        rows, highest = [(emulator.best, 0.0)], _BEYOND * root_of(LEVELS[-1], spread) ** 2
        for sign in (1.0, -1.0):
            u = emulator.best
            for reach in _REACHES:
                value = emulator.best[place] + sign * reach * deviation
                value = float(np.clip(value, ends[0, place], ends[1, place]))
                u = u + (value - u[place]) * np.eye(u.size)[place]
                u = emulator.minimum(u, ends, place)
                rise = max(float(emulator.misfit(u)) - least, 0.0)
                rows.append((u, sign * np.sqrt(rise)))
                if rise > highest or value in ends[:, place]:
                    break
        rows.sort(key=lambda row: row[0][place])
        points, roots = (np.array(column) for column in zip(*rows, strict=True))
        monotonic = np.maximum.accumulate(roots)
        falls = bool((np.sign(roots) * (roots**2 - monotonic**2) < -_FALLEN).any())
        return Profile(place, points, monotonic, spread, falls)


@dataclass(frozen=True)
class Profile:
    """The profile likelihood of a parameter: points along it, and signed roots of rises of χ²."""

    place: int  # of the parameter
    points: Array  # all parameters at each point, shape (m, p)
    roots: Array  # shape (m,), increasing
    spread: Array  # variances with noises that the readings allow, over that with the noise taken
    falls: bool = False  # whether χ² falls again away from its least value

    def interval(self, level: float) -> tuple[float, float]:
        """The interval of a level, in the coordinate in which the parameter is sought."""
        low, high = self.ends_at(level)
        return float(low[self.place]), float(high[self.place])

    def is_open(self, level: float) -> tuple[bool, bool]:
        """Whether χ² rises too little, down to or up to the end of the range, to end it."""
        root = root_of(level, self.spread)
        return bool(self.roots[0] > -root), bool(self.roots[-1] < root)

    def ends_at(self, level: float) -> list[Array]:
        """All parameters at both ends of the interval of a level."""
        roots = root_of(level, self.spread) * np.array([-1.0, 1.0])
        return [*np.transpose([np.interp(roots, self.roots, column) for column in self.points.T])]


def root_of(level: float, spread: Array) -> float:
    """The root of the rise of χ² at both ends of the interval of a level, with one degree.

    `spread` has the variances that the parameter may have, over that which the rise refers to.
    """
    from scipy.optimize import brentq
    from scipy.special import erf, erfinv

    normal = np.sqrt(2.0) * float(erfinv(level))
    widths = np.sqrt(2.0 * spread)
    ends = 0.5 * normal * np.sqrt(spread.min()), 2.0 * normal * np.sqrt(spread.max())
    return float(brentq(lambda root: float(erf(root / widths).mean()) - level, *ends))
