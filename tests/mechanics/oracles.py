"""Contact and wear by other ways than the library: own Love formula, dense matrices, a full FFT.

The tangential problem is solved directly, |q| ≤ µp and no slip below the bound, and knows
nothing of a reduced normal load; wear is Archard's law as it is written, one contact after the
other.
"""

from dataclasses import dataclass, replace

import numpy as np

from fretwear.arrays import Array, Mask
from fretwear.mechanics.contact.grid import Grid
from fretwear.mechanics.contact.problem import ContactProblem, solve_contact
from fretwear.mechanics.surfaces.laws import Means
from fretwear.mechanics.wear.state import State, WearProblem

from .problems import unfolded

_TOLERANCE = 1e-9


def love(x: Array, y: Array, spacing: tuple[float, float], modulus: float) -> Array:
    """Displacement, m/Pa, at a distance (x, y), m, from the center of a loaded rectangle.

    Love (1929), in its form with logarithms; it is even in x and y, and taken where both are
    positive no logarithm cancels.
    """
    x, y = np.abs(x), np.abs(y)
    k, l = x + spacing[0] / 2, x - spacing[0] / 2  # noqa: E741 - the letters of the formula
    m, n = y + spacing[1] / 2, y - spacing[1] / 2
    total = (
        k * np.log((m + np.hypot(k, m)) / (n + np.hypot(k, n)))
        + l * np.log((n + np.hypot(l, n)) / (m + np.hypot(l, m)))
        + m * np.log((k + np.hypot(k, m)) / (l + np.hypot(l, m)))
        + n * np.log((l + np.hypot(l, n)) / (k + np.hypot(k, n)))
    )
    return total / (np.pi * modulus)


def influence_matrix(window: Grid, modulus: float) -> Array:
    """Displacement of each cell of a whole window under unit pressure on each, m/Pa."""
    x, y = (c.ravel() for c in np.meshgrid(window.x, window.y, indexing="ij"))
    return love(x[:, None] - x, y[:, None] - y, window.spacing, modulus)


def with_images(kernel: Array, i: Array, j: Array) -> Array:
    """Displacement of cells (i, j) of a quarter under unit pressure on each and its images, m/Pa.

    ``kernel`` is that of one cell, m/Pa, by the distances along x and y in cells.
    """
    return sum(
        kernel[x, y]
        for x in (np.abs(i[:, None] - i), i[:, None] + i + 1)
        for y in (np.abs(j[:, None] - j), j[:, None] + j + 1)
    )


def displacement(pressure: Array, spacing: tuple[float, float], modulus: float) -> Array:
    """Displacement, m, under a pressure, Pa, on a whole window, by a zero-padded FFT."""
    nx, ny = pressure.shape
    x = np.fft.ifftshift(np.arange(-nx, nx)) * spacing[0]
    y = np.fft.ifftshift(np.arange(-ny, ny)) * spacing[1]
    kernel = love(x[:, None], y[None, :], spacing, modulus)
    spectrum = np.fft.rfft2(kernel) * np.fft.rfft2(pressure, s=kernel.shape)
    return np.fft.irfft2(spectrum, s=kernel.shape)[:nx, :ny]


def worst_violation(problem: WearProblem, state: State) -> float:
    """How far a state is from the conditions of contact, by its pressure and its shape alone.

    The largest error of the load, gap under pressure, overlap of the bodies and difference of the
    state's own gap from the gap of its shape; relative to the load and to the approach.
    """
    shape = problem.unworn(state.geometry) + state.wear + state.plastic
    fields = (state.pressure, shape, state.gap)
    pressure, shape, reported = (unfolded(field, state.geometry.even) for field in fields)
    spacing = state.geometry.spacing
    gap = displacement(pressure, spacing, problem.bodies.composite_modulus) + shape - state.approach
    load = float(pressure.sum()) * spacing[0] * spacing[1]
    lengths = np.abs(gap[pressure > 0]).max(), -gap.min(), np.abs(reported - gap).max()
    return max(abs(load / problem.hertz.load - 1.0), float(max(lengths)) / state.approach)


def normal_contact(
    influence: Array,
    shape: Array,
    cell: Array | float,
    load: float,
    loaded: Mask | None = None,
    limit: float = np.inf,
) -> tuple[Array, Array, float]:
    """Pressure (Pa), gap (m) and approach (m) of a rigid shape (m) on the half-space.

    All cells start in contact, or those ``loaded``; cells leave while their pressure pulls, and
    come back while they penetrate. Cells above the limit are held there while they penetrate.
    ``cell`` is the area of a cell, m², or of each.
    """
    areas = np.broadcast_to(cell, shape.shape)
    if loaded is None:
        loaded = np.ones(shape.size, dtype=bool)
    full = np.zeros_like(loaded)
    for _ in range(100):
        pressure = np.where(full, limit, 0.0)
        inside = np.flatnonzero(loaded & ~full)
        pressure[inside], approach = _solve_with_total(
            influence[np.ix_(inside, inside)],
            -(shape + influence @ pressure)[inside],
            load - areas @ pressure,
            areas[inside],
        )
        gap = shape + influence @ pressure - approach
        wanted = np.where(loaded, pressure > 0.0, gap < 0.0)
        yielding = np.where(full, gap < 0.0, pressure > limit)
        if np.array_equal(wanted, loaded) and np.array_equal(yielding, full):
            return pressure, np.where(loaded & ~full, 0.0, gap), approach
        loaded, full = wanted, yielding
    raise RuntimeError("the contact set did not settle")


@dataclass(frozen=True, eq=False)
class TangentialStep:
    """Traction at the end of a step (Pa), relative displacement during it (m) and rigid shift."""

    traction: Array
    slip: Array
    displacement: float


def tangential_step(
    influence: Array,
    bound: Array,
    initial: Array,
    cell: float,
    force: float | None = None,
    displacement: float = 0.0,
    drag: Array | float = 0.0,
) -> TangentialStep:
    """Bring the tangential force to ``force``, or shift distant points by ``displacement``.

    It starts from a state with the traction ``initial``, which need not belong to the same
    pressure. ``influence`` is the tangential one, m/Pa; ``bound`` is µp in Pa, shape (n,). The
    relative displacement of the surfaces in the step is v = δ - K (q - initial) - drag: zero where
    |q| < µp, positive where q = µp, negative where q = -µp. ``drag``, m, is what a change of
    pressure adds to K (q - initial).
    """
    drag = np.zeros_like(bound) + drag
    touching = bound > 0.0
    # a step that barely moves leaves slipping cells on both bounds at once, up to rounding
    outside = bound + 1e-12 * bound.max()
    upper, lower = np.zeros_like(touching), np.zeros_like(touching)
    for _ in range(200):
        traction = np.where(upper, bound, np.where(lower, -bound, 0.0))
        stick = np.flatnonzero(touching & ~upper & ~lower)
        matrix, forced = influence[np.ix_(stick, stick)], influence[stick] @ (traction - initial)
        forced = forced + drag[stick]
        if force is None:
            traction[stick] = np.linalg.solve(matrix, displacement - forced)
        else:
            total, areas = force / cell - traction.sum(), np.ones(stick.size)
            traction[stick], displacement = _solve_with_total(matrix, -forced, total, areas)
        slip = displacement - influence @ (traction - initial) - drag
        above = np.where(upper, slip >= 0.0, ~lower & touching & (traction > outside))
        below = np.where(lower, slip <= 0.0, ~upper & touching & (traction < -outside))
        if np.array_equal(above, upper) and np.array_equal(below, lower):
            slip[stick] = 0.0
            return TangentialStep(traction, slip, displacement)
        upper, lower = above, below
    raise RuntimeError("the slip zones did not settle")


def vector_friction(matrix: Array, bound: Array, total: float) -> tuple[Array, Array]:
    """Slip (m, shape (n,)) and traction (Pa, shape (2n,)) of friction along x and y, ∑q = (Q, 0).

    The traction minimises ½ q·Kq in |q| ≤ µp by accelerated projected gradients, and the slip is
    δ − Kq. Bodies even along y alone have no displacement along y.
    """

    def within(traction: Array) -> Array:
        """The nearest traction within the discs that carries Q, which shifts it along x."""
        x, y = np.split(traction, 2)

        def shifted(by: float) -> Array:
            factor = np.minimum(1.0, bound / np.maximum(np.hypot(x + by, y), 1e-300))
            return np.concatenate([factor * (x + by), factor * y])

        low, high = -(most := np.abs(x).max() + 4.0 * bound.max()), most
        for _ in range(50):
            middle = (low + high) / 2
            enough = shifted(middle)[: bound.size].sum() >= total
            low, high = (low, middle) if enough else (middle, high)
        return shifted(high)

    largest = np.linalg.norm(matrix, 2)
    traction = ahead = within(np.zeros(2 * bound.size))
    momentum, change = 1.0, np.inf
    while np.abs(change).max() > 3e-8 * bound.max():
        following = within(ahead - matrix @ ahead / largest)
        change = following - traction
        if (ahead - following) @ change > 0.0:
            momentum = 1.0
        gained = (1.0 + np.sqrt(1.0 + 4.0 * momentum**2)) / 2
        traction, ahead = following, following + (momentum - 1.0) / gained * change
        momentum = gained
    sticks = (np.hypot(*np.split(traction, 2)) < (1 - 1e-5) * bound) & (bound > 0)
    x, y = np.split(matrix @ traction, 2)
    return np.where(sticks, 0.0, np.hypot(x[sticks].mean() - x, y)), traction


def _solve_with_total(
    matrix: Array, right: Array, total: float, areas: Array
) -> tuple[Array, float]:
    """Solve K z - λ = right with ΣAz = total for z and λ."""
    size = right.size
    system = np.zeros((size + 1, size + 1))
    # K in units of its own diagonal, so that both kinds of rows weigh alike
    scale = matrix[0, 0]
    system[:size, :size] = matrix / scale
    system[:size, size] = -1.0
    system[size, :size] = areas / areas[0]
    solution = np.linalg.solve(system, np.append(right / scale, total / areas[0]))
    return solution[:size], float(solution[size] * scale)


@dataclass(frozen=True)
class Worn:
    """Wear and plastic depth, m, pressure, Pa, and gap of the reduced problem, m."""

    wear: Array
    plastic: Array
    pressure: Array
    reduced_gap: Array


def explicit_wear(problem: WearProblem, window: Grid, cycles: float, steps: int) -> Worn:
    """Euler's method for dW/dN = β p g* − K e_t/µ ≥ 0 on a window that the contact never leaves.

    Before each step the bodies yield where the pressure reaches its limit, for good, and the
    contact at the reduced load is solved on the shape of that moment. Loads are forces, which may
    change over the cycles as all else may. A limit that friction lowers follows from q/µp of the
    step before.
    """
    bodies, unworn = problem.half_space(window), problem.unworn(window)
    wear, plastic = np.zeros(window.shape), np.zeros(window.shape)
    pressure, reduced, load = None, None, None
    for step in range(steps + 1):
        now = problem.at(step * cycles / steps)
        limit = now.plastic_limit
        if reduced is not None:
            sheared = 1.0 - reduced.pressure / np.where(pressure > 0.0, pressure, np.inf)
            growth = now.junction_growth * now.friction_law.coefficient**2
            limit = limit / np.sqrt(1.0 + growth * sheared**2)
        shape = unworn + wear + plastic
        contact = solve_contact(now.contact(bodies, shape, limit=limit), pressure, _TOLERANCE)
        pressure = contact.pressure
        contact_load = window.integral(pressure)
        plastic = plastic + contact.penetration
        if reduced is None or contact.penetration.any() or load != now.stick_load:
            load = now.stick_load
            reduced = solve_contact(
                ContactProblem(bodies, unworn + wear + plastic, load),
                None if reduced is None else reduced.pressure,
                _TOLERANCE,
            )
            gap = np.where(reduced.pressure > 0, 0.0, np.maximum(reduced.gap, 0.0))
        if step < steps:
            if now.wear_law.follows_contact:
                # Any gap beside the contact is far larger than where it closes.
                area = window.integral((contact.gap <= 1e-5 * contact.approach).astype(float))
                slip = now.friction_law.coefficient * now.coupling * gap
                mean = window.integral(pressure * slip) / contact_load
                density = 4.0 * now.friction_law.coefficient * contact_load * mean / area
                now = now.under(Means(density, contact_load / area, mean))
            friction = now.friction_law.coefficient
            withheld = now.combined_wear_coefficient * now.wear_threshold / friction
            rate = now.wear_growth * pressure * gap - withheld
            worn = cycles / steps * np.maximum(rate, 0.0)
            wear = wear + worn
            gap = gap + worn
    return Worn(wear, plastic, pressure, gap)


def extrapolated_wear(problem: WearProblem, window: Grid, cycles: float, steps: int) -> Worn:
    """`explicit_wear` without its first-order error, from runs of ``steps`` and of twice as many.

    The gap, which ends in zero where the contact sticks, is that of the shorter steps.
    """
    coarse, fine = (explicit_wear(problem, window, cycles, count) for count in (steps, 2 * steps))
    names = ("wear", "plastic", "pressure")
    return replace(fine, **{n: 2 * getattr(fine, n) - getattr(coarse, n) for n in names})


def explicit_strokes(
    problem: WearProblem, window: Grid, influence: Array, cycles: float, steps: int, places: int
) -> Array:
    """Euler's method over strokes under a load in phase with them: wear of flat and indenter, m.

    Positions are the middles of equal parts of the stroke, and the indenter is interpolated
    linearly. ``influence`` is that of the cells of a window and their images along y, and loads
    are per width in a line contact.
    """
    (x, y), stroke, gap = (window.x, window.y), problem.loading.stroke, problem.indenter.gap
    positions = stroke * (2.0 * (np.arange(places) + 0.5) / places - 1.0)
    ratio, worn = problem.normal.pulsating_load, np.zeros((2, *window.shape))
    loads = problem.hertz.load * (0.5 * (1.0 + ratio) + 0.5 * (1.0 - ratio) * positions / stroke)
    least = problem.hertz.contact_radius**2 / (2.0 * problem.indenter.curvature_radius)
    loaded = [gap(x[:, None] - place, y).ravel() < least for place in positions]
    rates = 4.0 * stroke * np.array(problem.wear_law.wear_coefficient)[::-1, None, None]

    def moved(field: Array, by: float) -> Array:
        return np.stack([np.interp(x - by, x, row) for row in field.T], axis=1)

    for _ in range(steps):
        means = np.zeros_like(worn)
        for index, place in enumerate(positions):
            shape = gap(x[:, None] - place, y) + worn[0] + moved(worn[1], place)
            pressure, *_ = normal_contact(
                influence, shape.ravel(), window.unit_area, loads[index], loaded[index]
            )
            loaded[index] = pressure > 0.0
            pressure = pressure.reshape(window.shape)
            means += np.stack([pressure, moved(pressure, -place)]) / places
        worn += rates * means * cycles / steps
    return worn
