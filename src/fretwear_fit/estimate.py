"""The best parameters by Gauss–Newton steps, and their intervals by the profile likelihood."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from contextlib import suppress
from dataclasses import dataclass, field

import numpy as np

from fretwear.arrays import Array
from fretwear_fit.comparison import Comparison
from fretwear_fit.noise import Noise
from fretwear_fit.request import FreeParameter

LEVELS = (0.68, 0.9, 0.95)
"""Probabilities of the intervals."""

_LEAST_FRACTION = 1e-3
_STEP = 0.04  # of a derivative, in logarithms or parts of a range
_MOST_ROUNDS, _MOST_STEPS = 6, 30
_FLAT, _SAME = 2e-3, 5e-3  # least relative change of χ², and of parameters; later steps are finer
_PLACES, _STARTS = 8, 2  # where a search begins anew that has not explained the data
_INVALID = 1e3  # residual of parameters that make no case
# Places of the runs that intervals rest on, in standard deviations.
_OUT = 1.645
_NARROWEST = 0.008  # least step of these runs
_LEAST_ROOM = 0.02  # of the range beside the best parameters, in parts of a step
_SETTLED = 0.02  # change of the sum of squares that does not matter
_FAR = 0.25  # step after which the runs around the best parameters are made anew
_MOST_MOVES = 3
_ALIKE = (
    0.3  # logarithm of a ratio of standard deviations with which the runs lie where they should
)
# In coordinates of the emulator, in which runs along its directions lie at 1: where a run counts as
# known, how far runs are taken in, how far what they miss reaches, and when places are the same.
_UNCHECKED, _NEAR, _REACH_OF_RUN, _SAME_RUN, _NUGGET = 0.3, 3.0, 1.5, 1e-6, 1e-4
# Values of a profile, in standard deviations, up to this part of the highest rise of χ² asked for.
_REACHES, _BEYOND = (0.4, 0.8, 1.2, 1.6, 2.0, 2.6, 3.3, 4.5, 6.0, 9.0, 15.0, 30.0, 100.0), 1.8
_FALLEN = 0.5  # fall of χ² along a profile that is another minimum
_NOISES = 256  # draws of the noise


@dataclass(frozen=True)
class Unknown:
    """What is sought: a free parameter of all tests, or its value in one test."""

    free: FreeParameter
    test: int | None = None  # None: of all tests

    @property
    def name(self) -> str:
        """Its name, with the number of its test if it has one."""
        return self.free.name + ("" if self.test is None else f"[{self.test}]")

    @property
    def is_fraction(self) -> bool:
        """Whether it is a part of a whole, sought on the logarithm of x/(1 − x)."""
        about = self.free.about
        bounds = about.ge, about.le
        return bounds == (0.0, 1.0) and not self.free.logarithmic

    def inner(self, value: float) -> float:
        """The coordinate in which it is sought: a logarithm, or the part of its range."""
        low, high = self.free.low, self.free.high
        if self.is_fraction:
            inside = min(max(value, _LEAST_FRACTION), 1.0 - _LEAST_FRACTION)
            return float(np.log(inside / (1.0 - inside)))
        return float(np.log(value)) if self.free.logarithmic else (value - low) / (high - low)

    def value(self, inner: float | Array) -> Array:
        """The value, in SI units, from the coordinate in which it is sought."""
        low, high = self.free.low, self.free.high
        if self.is_fraction:
            return np.asarray(1.0 / (1.0 + np.exp(-np.asarray(inner))))
        value = np.exp(inner) if self.free.logarithmic else low + np.asarray(inner) * (high - low)
        return np.asarray(value)

    @property
    def ends(self) -> tuple[float, float]:
        """The range, in the coordinate in which it is sought."""
        return self.inner(self.free.low), self.inner(self.free.high)


@dataclass
class Emulator:
    """χ² and signals near the best parameters u₀ + Σ c_i v_i, from the runs around them.

    χ² is the one of residuals linear in c, with the base line taken out, plus what this misses at
    the runs, interpolated by Gaussian radial functions. The signal S₀ + Σ c_i S'_i
    + ½ Σ c_i² S''_i is right at u₀ and where runs along the v_i were.
    """

    center: Array  # u₀, shape (p,)
    directions: Array  # the v_i as columns, shape (p, p)
    signal: Array  # S₀, shape (g,)
    first: Array  # S'_i, shape (g, p)
    second: Array  # S''_i, shape (g, p)
    rest: Array  # residuals at u₀, shape (n,)
    slopes: Array  # their derivatives by c, shape (n, p)
    best: Array = field(init=False)  # the run with the least χ², shape (p,)
    least: float = field(init=False)  # its χ²

    def __post_init__(self) -> None:
        """Begin without further runs."""
        self.best, self.least = self.center, float(self.rest @ self.rest)
        self._base = self.least
        self._gradient, self._curvature = self.slopes.T @ self.rest, self.slopes.T @ self.slopes
        self._inverse = np.linalg.inv(self.directions)
        self._runs, self._missed = np.zeros((0, self.center.size)), np.zeros(0)
        self.learn(self.center, self.least)

    def at(self, u: Array) -> Array:
        """Coordinates c of parameters, shape (p,) or (m, p)."""
        return np.asarray((u - self.center) @ self._inverse.T)

    def misfit(self, c: Array) -> Array:
        """χ² at coordinates, shape (p,) or (m, p)."""
        return np.asarray(self._linear(c) + self._kernel(c) @ self._weights)

    def _linear(self, c: Array) -> Array:
        square = ((c @ self._curvature) * c).sum(axis=-1)
        return np.asarray(self._base + 2.0 * c @ self._gradient + square)

    def _kernel(self, c: Array) -> Array:
        squares = ((c[..., None, :] - self._runs) ** 2).sum(axis=-1)
        return np.asarray(np.exp(-0.5 * squares / _REACH_OF_RUN**2))

    def signal_at(self, c: Array) -> Array:
        """The signal at coordinates, shape (g,)."""
        return np.asarray(self.signal + self.first @ c + 0.5 * self.second @ c**2)

    def learn(self, u: Array, misfit: float) -> None:
        """Take in the χ² of a run."""
        c = self.at(u)
        if self.distance(c) > _SAME_RUN:
            self._runs = np.concatenate([self._runs, c[None]])
            self._missed = np.append(self._missed, misfit - self._linear(c))
            gram = self._kernel(self._runs) + _NUGGET * np.eye(len(self._runs))
            self._weights = np.linalg.solve(gram, self._missed)
        if misfit < self.least:
            self.least, self.best = misfit, u

    def distance(self, c: Array) -> float:
        """Distance of coordinates from the nearest run that was taken in."""
        return float(np.sqrt(((c - self._runs) ** 2).sum(axis=1).min(initial=np.inf)))

    def minimum(self, start: Array, ends: Array, fixed: int | None = None) -> Array:
        """The parameters with the least χ² within their ranges, shape (2, p), one of them fixed."""
        from scipy.optimize import minimize

        free = [place for place in range(start.size) if place != fixed]
        if not free:
            return start
        scales, u = np.abs(self.directions).max(axis=1)[free], start.copy()

        def at(step: Array) -> float:
            u[free] = start[free] + step * scales
            return float(self.misfit(self.at(u)))

        # No further than runs are taken in.
        low, high = (np.clip((e[free] - start[free]) / scales, -_NEAR, _NEAR) for e in ends)
        optimum = minimize(at, np.zeros(len(free)), bounds=[*zip(low, high, strict=True)])
        at(optimum.x)
        return u


class _StalledError(Exception):
    """Updated derivatives no longer lead down."""


class Fitter:
    """Least squares of measurements on the parameters of runs."""

    def __init__(
        self,
        unknowns: Sequence[Unknown],
        comparisons: Sequence[Comparison],
        signals: Callable[[Sequence[Array]], list[list[Array] | None]],
    ) -> None:
        """Begin; `signals` runs parameters and gives the signal of each measurement or None."""
        self.unknowns, self.comparisons, self._signals = unknowns, [*comparisons], signals
        ends = np.array([unknown.ends for unknown in unknowns])
        self.lower, self.upper = ends.T
        self.settled: list[Array | None] = [None] * len(comparisons)
        self._jacobian: tuple[Array, Array, Array] | None = None  # at u, signal, derivative
        self.signals_of: dict[bytes, Array | None] = {}
        self.sizes: list[int] = []

    def signals_at(self, points: Sequence[Array]) -> list[Array | None]:
        """The signals of all measurements, one after the other, at some parameters."""
        new = {u.tobytes(): u for u in points if u.tobytes() not in self.signals_of}
        for key, signals in zip(new, self._signals([*new.values()]), strict=True):
            if signals is not None:
                self.sizes = [part.size for part in signals]
            self.signals_of[key] = None if signals is None else np.concatenate(signals)
        return [self.signals_of[u.tobytes()] for u in points]

    def text(self, u: Array) -> str:
        """The values of parameters, for people."""
        pairs = zip(self.unknowns, u, strict=True)
        return ", ".join(f"{unknown.name} = {float(unknown.value(x)):.4g}" for unknown, x in pairs)

    def split(self, signal: Array) -> list[Array]:
        """The signal of each measurement."""
        return np.split(signal, np.cumsum(self.sizes)[:-1])

    def settle(self, signal: Array) -> list[Array]:
        """The nuisances of each measurement that suit a signal best."""
        nuisances = []
        for place, (comparison, part) in enumerate(
            zip(self.comparisons, self.split(signal), strict=True)
        ):
            self.settled[place] = comparison.settled(part, self.settled[place])
            nuisances.append(self.settled[place])
        return nuisances  # type: ignore[return-value]

    def residuals(self, signal: Array) -> Array:
        """Whitened residuals of all measurements at the best nuisances."""
        nuisances = self.settle(signal)
        parts = zip(self.comparisons, self.split(signal), nuisances, strict=True)
        return np.concatenate([c.residuals(s, n) for c, s, n in parts])

    def misfit(self, signal: Array) -> float:
        """χ²: the sum of squares of the residuals."""
        rest = self.residuals(signal)
        return float(rest @ rest)

    def projected(self, signal: Array, changes: Array) -> Array:
        """Derivatives of the residuals by changes of the signal, without what nuisances take up.

        Kaufman's approximation of variable projection (BIT 15, 1975).
        """
        columns = []
        nuisances = self.settle(signal)
        parts = zip(self.comparisons, self.split(signal), nuisances, strict=True)
        split = [self.split(change) for change in changes.T]
        for place, (comparison, part, fixed) in enumerate(parts):
            slopes = comparison.slopes(part, fixed)
            moved = np.column_stack(
                [comparison.by_signal(part, fixed, column[place]) for column in split]
            )
            q, _ = np.linalg.qr(slopes)
            columns.append(moved - q @ (q.T @ moved))
        return np.concatenate(columns)

    def derivatives(self, u: Array, signal: Array) -> Array:
        """Derivatives of the signal by finite differences, shape (g, p); one run each."""
        steps = np.where(u + _STEP > self.upper, -_STEP, _STEP)
        points = [u + step * row for step, row in zip(steps, np.eye(u.size), strict=True)]
        columns = [
            (ahead - signal) / step if ahead is not None else np.zeros_like(signal)
            for ahead, step in zip(self.signals_at(points), steps, strict=True)
        ]
        self._jacobian = u.copy(), signal, np.column_stack(columns)
        return self._jacobian[2]

    def _updated(self, u: Array, signal: Array) -> Array:
        """Derivatives at other parameters by Broyden's update of the last ones."""
        assert self._jacobian is not None
        before, there, jacobian = self._jacobian
        if (step := u - before).any():
            missed = signal - there - jacobian @ step
            jacobian = jacobian + np.outer(missed, step) / float(step @ step)
            self._jacobian = u.copy(), signal, jacobian
        return jacobian

    def best(self, start: Array) -> Array:
        """Return the parameters with the least χ².

        Derivatives between finite differences are updated by Broyden's formula. Where steps with
        these fail, and at the end, finite differences take their place.
        """
        u = np.clip(start, self.lower + 1e-6, self.upper - 1e-6)
        for _ in range(_MOST_ROUNDS):
            signal = self.signal(u)
            if self._jacobian is None or not np.array_equal(self._jacobian[0], u):
                self.derivatives(u, signal)
            assert self._jacobian is not None
            slopes, rest = self.projected(signal, self._jacobian[2]), self.residuals(signal)
            q, _ = np.linalg.qr(slopes)
            gain = float(((q.T @ rest) ** 2).sum())
            at_end = ((u - self.lower < 1e-3) | (self.upper - u < 1e-3)).any()
            if not at_end and gain < max(_SETTLED, _FLAT * float(rest @ rest)):
                break
            after = self._descended(u)
            reached = self.misfit(self.signal(after))
            if reached > (1.0 - _FLAT) * float(rest @ rest):
                break
            u = after
            self.derivatives(u, self.signal(u))
        return u

    def elsewhere(self) -> list[Array]:
        """Where searches end that begin at the best of places spread over the ranges."""
        generator, shares = np.random.default_rng(0), (np.arange(_PLACES) + 0.5) / _PLACES
        cube = np.column_stack([generator.permutation(shares) for _ in self.unknowns])
        points = [*(self.lower + cube * (self.upper - self.lower))]
        misfits = []
        for u, signal in zip(points, self.signals_at(points), strict=True):
            self.settled = [None] * len(self.comparisons)
            if signal is not None:
                misfits.append((self.misfit(signal), u))
        misfits.sort(key=lambda pair: pair[0])
        ends = []
        for _, u in misfits[:_STARTS]:
            self.settled, self._jacobian = [None] * len(self.comparisons), None
            ends.append(self.best(u))
        return ends

    def _descended(self, start: Array) -> Array:
        """Least squares from a place with fresh derivatives, until updated ones fail."""
        from scipy.optimize import least_squares

        rows = self.residuals(self.signal(start)).size
        # From a place at distance 1 of the origin the first step is at most a factor e.
        origin = start - 1.0 / np.sqrt(start.size)
        least, best, failed, fresh = np.inf, start, 0, True

        def missing(step: Array) -> Array:
            nonlocal least, best, failed
            u = start if np.array_equal(step, start - origin) else origin + step
            signal = self.signals_at([u])[0]
            rest = np.full(rows, _INVALID) if signal is None else self.residuals(signal)
            if (misfit := float(rest @ rest)) < least:
                least, best, failed = misfit, u, 0
            else:
                failed += 1
            if failed > 1 and not fresh:
                raise _StalledError
            return rest

        def slopes(step: Array) -> Array:
            nonlocal fresh
            u = start if np.array_equal(step, start - origin) else origin + step
            signal = self.signal(u)
            projection = self.projected(signal, self._updated(u, signal))
            fresh = np.array_equal(u, start)
            return projection

        with suppress(_StalledError):
            least_squares(
                missing,
                start - origin,
                slopes,
                (self.lower - origin, self.upper - origin),
                ftol=_FLAT,
                xtol=_SAME,
                max_nfev=_MOST_STEPS,
            )
        return best

    def signal(self, u: Array) -> Array:
        """The signals of all measurements at parameters that make a case."""
        signal = self.signals_at([u])[0]
        assert signal is not None
        return signal

    def covariance(self, signal: Array, derivatives: Array) -> Array:
        """The covariance of the parameters by a linear model; unknown directions are wide."""
        return self._covariance(self.projected(signal, derivatives))

    def _covariance(self, slopes: Array) -> Array:
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
        parts = [
            comparison.unweighted(part, nuisances, self.split_all(derivatives, place))
            for place, (comparison, part, nuisances) in enumerate(
                zip(self.comparisons, self.split(signal), self.settle(signal), strict=True)
            )
        ]

        def variances(noises: Sequence[Noise | None]) -> Array:
            slopes = []
            for comparison, columns, noise in zip(self.comparisons, parts, noises, strict=True):
                whitened = columns
                if noise is not None and comparison.measurement.readings is not None:
                    x, _ = comparison.measurement.readings
                    readings = noise.whitened(x, columns[: x.size])
                    whitened = np.concatenate([readings, columns[x.size :]])
                moved, of_nuisances = np.split(whitened, [len(self.unknowns)], axis=1)
                q, _ = np.linalg.qr(of_nuisances)
                slopes.append(moved - q @ (q.T @ moved))
            return np.diag(self._covariance(np.concatenate(slopes)))

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

    def split_all(self, changes: Array, place: int) -> list[Array]:
        """Changes of the signal of one measurement, from columns with the changes of all."""
        return [self.split(change)[place] for change in changes.T]

    def emulator(self, u: Array) -> Emulator:
        """Return an emulator of the runs around the best parameters.

        Its runs lie where intervals end. If these turn out to end elsewhere, or the best parameters
        to lie there, the runs are made anew.
        """
        ends = np.array([self.lower, self.upper])
        for _ in range(_MOST_MOVES):
            signal = self.signal(u)
            covariance = self.covariance(signal, self._updated(u, signal))
            emulator = self._along(u, signal, covariance)
            derivatives = emulator.first @ np.linalg.inv(emulator.directions)
            self._jacobian = u, signal, derivatives
            ratios = np.diag(self.covariance(signal, derivatives)) / np.diag(covariance)
            moved = emulator.minimum(emulator.best, ends)
            if np.abs(emulator.at(moved)).max() > _FAR:
                ahead = self.signals_at([moved])[0]
                if ahead is not None and self.misfit(ahead) < self.misfit(signal):
                    u = moved
                    continue
            if np.abs(np.log(ratios)).max() < _ALIKE:
                break
        return emulator

    def _emulator(
        self, u: Array, signal: Array, directions: Array, first: Array, second: Array
    ) -> Emulator:
        rest, slopes = self.residuals(signal), self.projected(signal, first)
        emulator = Emulator(u, directions, signal, first, second, rest, slopes)
        for key, moved in self.signals_of.items():
            at = np.frombuffer(key)
            if moved is not None and np.abs(emulator.at(at)).max() < _NEAR:
                emulator.learn(at, self.misfit(moved))
        return emulator

    def _along(self, u: Array, signal: Array, covariance: Array) -> Emulator:
        """Runs on both sides of the best parameters along the columns of their covariance."""
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
        slopes: list[list[tuple[float, Array]]] = [[] for _ in u]
        for (place, share), moved in zip(places, self.signals_at(points), strict=True):
            if moved is not None:
                slopes[place].append((share, (moved - signal) / share))
        first, second = [0.0 * signal for _ in u], [0.0 * signal for _ in u]
        for place, slopes_here in enumerate(slopes):
            # A quadratic through three points, which need not be equally far apart, or a line.
            if slopes_here:
                (a, ahead), (b, behind) = slopes_here[0], slopes_here[-1]
                curve = (ahead - behind) / (a - b) if len(slopes_here) > 1 else 0.0 * signal
                first[place], second[place] = ahead - a * curve, 2.0 * curve
        return self._emulator(u, signal, directions, *map(np.column_stack, (first, second)))

    def intervals(self, emulator: Emulator, spread: Array) -> list[Profile]:
        """The profile likelihood of each parameter, its ends and its best value checked by runs."""
        ends = np.array([self.lower, self.upper])
        for last in (False, False, True):
            trials = [emulator.minimum(emulator.best, ends)]
            profiles = [
                self._profile(emulator, place, ends, column)
                for place, column in enumerate(spread.T)
            ]
            trials += [u for profile in profiles for u in profile.ends_at(LEVELS[1])]
            new = [u for u in trials if emulator.distance(emulator.at(u)) > _UNCHECKED]
            if last or not new:
                break
            for u, signal in zip(new, self.signals_at(new), strict=True):
                if signal is not None:
                    emulator.learn(u, self.misfit(signal))
        return profiles

    def _profile(self, emulator: Emulator, place: int, ends: Array, spread: Array) -> Profile:
        """Signed roots of the rise of χ² over values of one parameter, the others at their best."""
        least = float(emulator.misfit(emulator.at(emulator.best)))
        deviation = float(np.abs(emulator.directions[place]).max()) / _OUT
        rows, highest = [(emulator.best, 0.0)], _BEYOND * root_of(LEVELS[-1], spread) ** 2
        for sign in (1.0, -1.0):
            u = emulator.best
            for reach in _REACHES:
                value = emulator.best[place] + sign * reach * deviation
                value = float(np.clip(value, ends[0, place], ends[1, place]))
                u = u + (value - u[place]) * np.eye(u.size)[place]
                u = emulator.minimum(u, ends, place)
                rise = max(float(emulator.misfit(emulator.at(u))) - least, 0.0)
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
        low, high = (self._at(sign * root_of(level, self.spread)) for sign in (-1.0, 1.0))
        return float(low[self.place]), float(high[self.place])

    def is_open(self, level: float) -> tuple[bool, bool]:
        """Whether χ² rises too little, down to or up to the end of the range, to end it."""
        root = root_of(level, self.spread)
        return bool(self.roots[0] > -root), bool(self.roots[-1] < root)

    def ends_at(self, level: float) -> list[Array]:
        """All parameters at both ends of the interval of a level."""
        return [self._at(sign * root_of(level, self.spread)) for sign in (-1.0, 1.0)]

    def _at(self, root: float) -> Array:
        return np.array([np.interp(root, self.roots, column) for column in self.points.T])


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
