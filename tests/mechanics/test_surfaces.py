"""Waves, random surfaces and indenters, against their spectra and the closed forms of contact."""

import math
from dataclasses import astuple, replace

import numpy as np
import pytest

from fretwear.mechanics.contact.grid import Grid
from fretwear.mechanics.contact.rings import Rings
from fretwear.mechanics.surfaces.indenters import (
    CrossedCylinders,
    Cylinder,
    Ellipsoid,
    FlatPunch,
    RoundPunch,
    Sphere,
)
from fretwear.mechanics.surfaces.pressing import NormalLoad
from fretwear.mechanics.surfaces.roughness import BothRough, SelfAffineRoughness, WavyRoughness
from fretwear.mechanics.wear.integrator import evolve, first_loading
from fretwear.mechanics.wear.measures import Measures
from fretwear.run.states import wear_problem
from fretwear.study.case import CaseError
from fretwear.theory import EllipticContact, RoundContact, RoundedPunch
from fretwear.units import LINE_CONTACT

from ..studies import near, steel
from .problems import MODULUS, fretting

RADIUS, AMPLITUDE = 10e-3, 0.2e-6
SLOPE_X, SLOPE_Y = np.tan(np.deg2rad(5.7)), np.tan(np.deg2rad(1.0))
WAVES = WavyRoughness(AMPLITUDE, np.arctan(SLOPE_X), np.arctan(SLOPE_Y))


def test_waves_are_those_of_the_study_and_rise_with_the_mean_slope():
    x, y = np.linspace(-3e-5, 3e-5, 41), np.linspace(-8e-5, 8e-5, 37)
    expected = AMPLITUDE * np.outer(
        np.sin(np.pi / 2 + 0.5 * np.pi * SLOPE_X / AMPLITUDE * x),
        np.cos(0.5 * np.pi * SLOPE_Y / AMPLITUDE * y),
    )
    # One rounding of the sine's argument, which reaches a few tens.
    np.testing.assert_allclose(WAVES.height(x[:, None], y), expected, atol=1e-14 * AMPLITUDE)
    for slope, place in ((SLOPE_X, [1.0, 0.0]), (SLOPE_Y, [0.0, 1.0])):
        length = 4 * AMPLITUDE / slope
        height = WAVES.height(*np.outer(place, np.linspace(0, length, 20001)))
        # The path up and down of a whole wave, 4 A, over its length; crests fall on sample points.
        assert np.abs(np.diff(height)).sum() / length == near(slope, rel=1e-7)
        assert height[-1] == near(AMPLITUDE, rel=1e-12)
    ridges = WavyRoughness(AMPLITUDE, 0.0, np.arctan(SLOPE_Y)).height(x[:, None], y)
    np.testing.assert_array_equal(ridges[1:], ridges[:-1])
    assert np.ptp(ridges[0]) > AMPLITUDE


def test_a_rough_sphere_is_even_the_sum_of_both_and_reaches_as_far_as_it_rises():
    """Waves enter by their means over cells, less by sin(kΔ/2)/(kΔ/2) each way."""
    window = Grid((12, 10), (2e-6, 5e-6), even=(False, False))
    rough, smooth = (fretting(roughness=each).unworn(window) for each in (WAVES, None))
    less = np.prod(np.sinc(np.multiply(WAVES.wavenumbers, window.spacing) / (2 * np.pi)))
    mean = less * WAVES.height(window.x[:, None], window.y)
    # Simpson's rule errs by (kΔ)⁴/2880.
    np.testing.assert_allclose(rough - smooth, mean, rtol=3e-3)
    np.testing.assert_allclose(rough, rough[::-1], rtol=1e-12)
    np.testing.assert_allclose(rough, rough[:, ::-1], rtol=1e-12)
    approach = 1.7e-6
    for roughness, height in ((None, approach), (WAVES, approach + AMPLITUDE)):
        for reach in fretting(roughness=roughness).reach(approach):
            assert reach == near(np.sqrt(2 * RADIUS * height), rel=1e-11)


def test_of_two_rough_surfaces_the_gap_has_both():
    random = SelfAffineRoughness(0.1e-6, 0.8, 60e-6, 30e-6, 3)
    half = WavyRoughness(0.5 * AMPLITUDE, *(np.arctan(0.5 * s) for s in (SLOPE_X, SLOPE_Y)))
    x, y = np.linspace(-3e-5, 3e-5, 11)[:, None], np.linspace(-8e-5, 8e-5, 7)
    twice, mixed = BothRough(half, half), BothRough(WAVES, random)
    np.testing.assert_allclose(twice.height(x, y), WAVES.height(x, y), atol=1e-14 * AMPLITUDE)
    np.testing.assert_array_equal(mixed.height(x, y), WAVES.height(x, y) + random.height(x, y))
    assert (twice.even, mixed.even) == ((True, True), (False, False))
    assert twice.highest == near(AMPLITUDE, rel=1e-14)
    assert astuple(twice.tip) == near(astuple(WAVES.tip), rel=1e-12)
    # The finer surface sets the cells along each axis.
    assert mixed.finest == (min(WAVES.finest[0], 30e-6), min(WAVES.finest[1], 30e-6))
    assert mixed.wavelengths == (min(WAVES.finest[0], 60e-6), min(WAVES.finest[1], 60e-6))


ROLLOFF, SHORTEST, HEIGHT = 80e-6, 20e-6, 0.2e-6
SURFACE = SelfAffineRoughness(HEIGHT, 0.8, ROLLOFF, SHORTEST, seed=7)
PERIOD = 16 * ROLLOFF


def moment(power, hurst):
    """∫ qᵏ C(q) dq of the continuous spectrum, up to the factor that all moments share."""
    rolloff, shortest = 2 * np.pi / ROLLOFF, 2 * np.pi / SHORTEST
    falling = power - 2 - 2 * hurst + 1
    return (
        rolloff ** (power + 1) / (power + 1)
        + rolloff ** (2 + 2 * hurst) * (shortest**falling - rolloff**falling) / falling
    )


def wave_numbers(count):
    numbers = np.fft.fftfreq(count, 1 / count)
    return np.hypot(numbers[:, None], numbers)


def test_the_spectrum_is_flat_falls_with_the_hurst_exponent_and_ends():
    wanted = HEIGHT * np.sqrt(moment(3, 0.8) / moment(1, 0.8))
    assert SURFACE.rms_slope == near(wanted, rel=2e-3)
    count = 3 * round(PERIOD / SHORTEST)
    x, number = (np.arange(count) + 0.5) * PERIOD / count, wave_numbers(count)
    power = np.abs(np.fft.fft2(SURFACE.height(x[:, None], x)) / count**2) ** 2
    assert np.sqrt(power.sum()) == near(HEIGHT, rel=1e-9)
    slope = np.sqrt((power * (2 * np.pi * number / PERIOD) ** 2).sum())
    assert slope == near(SURFACE.rms_slope, rel=1e-9)
    falling = (number > 16) & (number < 63.5)
    slope = np.polyfit(np.log(number[falling]), np.log(power[falling]), 1)[0]
    assert slope == pytest.approx(-2 - 2 * 0.8, abs=0.005)
    flat = (number > 0) & (number < 16)
    np.testing.assert_allclose(power[flat], power[flat].mean(), rtol=1e-9)
    assert power[number > 64.5].max() < 1e-20 * power.max()


@pytest.mark.slow
def test_heights_of_a_point_are_normally_distributed_over_the_seeds():
    heights = [replace(SURFACE, seed=seed).height(0.0, 0.0) for seed in range(400)]
    assert np.mean(heights) == pytest.approx(0.0, abs=4 * HEIGHT / 20)
    # 68 % of a normal distribution lie within the root mean square; four deviations of the share.
    assert np.abs(heights).max() < SURFACE.highest < 10 * HEIGHT
    inside = np.mean(np.abs(heights) < HEIGHT)
    assert inside == pytest.approx(0.683, abs=4 * np.sqrt(0.683 * 0.317 / 400))
    with pytest.raises(ValueError, match="at most the roll-off wavelength"):
        replace(SURFACE, shortest_wavelength=2 * ROLLOFF)
    with pytest.raises(ValueError, match="200 times as long as the shortest"):
        replace(SURFACE, shortest_wavelength=ROLLOFF / 200)


def test_the_surface_is_the_same_at_every_cell_size_and_with_shorter_waves():
    coarse = Grid((40, 30), (3e-6, 3e-6), (False, False))
    # Cells a third as large have every third centre in common, larger windows the inner cells.
    fine = Grid((180, 150), (1e-6, 1e-6), (False, False))
    height = SURFACE.height(coarse.x[:, None], coarse.y[None, :])
    there = SURFACE.height(fine.x[:, None], fine.y[None, :])[31:-29:3, 31:-29:3]
    np.testing.assert_allclose(height, there, atol=1e-12 * HEIGHT)
    x, y = np.meshgrid(coarse.x[:3], coarse.y[:2], indexing="ij")
    np.testing.assert_allclose(SURFACE.height(x, y), height[:3, :2], atol=1e-12 * HEIGHT)
    x = np.linspace(-PERIOD / 2, PERIOD / 2, 320, endpoint=False)
    more = replace(SURFACE, shortest_wavelength=SHORTEST / 2)
    height, finer = (surface.height(x[:, None], x) for surface in (SURFACE, more))
    kept = np.fft.fft2(finer)
    kept[wave_numbers(320) > 64.001] = 0.0
    same = np.fft.ifft2(kept).real
    np.testing.assert_allclose(same / same.std(), height / height.std(), atol=1e-9)


def test_heights_of_cells_are_means_over_them():
    cell, points = (4e-6, 3e-6), np.polynomial.legendre.leggauss(8)
    window = Grid((20, 16), cell, (False, False))
    laid = replace(SURFACE, anisotropy=2.0)
    mean = np.zeros(window.shape)
    for at_x, weight_x in zip(*points, strict=True):
        for at_y, weight_y in zip(*points, strict=True):
            x, y = window.x + 0.5 * at_x * cell[0], window.y + 0.5 * at_y * cell[1]
            mean += 0.25 * weight_x * weight_y * laid.height(x[:, None], y[None, :])
    found = laid.mean_height(window.x, window.y, cell)
    np.testing.assert_allclose(found, mean, atol=1e-12 * HEIGHT)
    both = BothRough(laid, SURFACE).mean_height(window.x, window.y, cell)
    np.testing.assert_array_equal(both, found + SURFACE.mean_height(window.x, window.y, cell))


@pytest.mark.parametrize(("anisotropy", "along_x", "along_y"), [(4.0, 4.0, 1.0), (0.25, 1.0, 4.0)])
def test_along_the_lay_all_wavelengths_are_longer(anisotropy, along_x, along_y):
    laid = replace(SURFACE, anisotropy=anisotropy)
    x, y = np.linspace(0, 1e-3, 50)[:, None], np.linspace(0, 3e-4, 40)
    expected = SURFACE.height(x / along_x, y / along_y)
    np.testing.assert_allclose(laid.height(x, y), expected, atol=1e-12 * HEIGHT)
    assert laid.finest == near((SHORTEST * along_x, SHORTEST * along_y), rel=1e-12)
    squares = SURFACE.rms_slope**2 / 2 * (1 / along_x**2 + 1 / along_y**2)
    assert laid.rms_slope == near(np.sqrt(squares), rel=1e-6)


PUNCH_RADIUS = 150e-6


def case(indenter, load=50.0, ratio=0.5, **changes):
    keys = {"radius": None, "indenter": indenter, "load": load, "tangential_ratio": ratio}
    return steel(cycles=100, **keys | changes)


# Half-axes a along x and b: E*Aa/p₀, E*Ba/p₀ of the gap Ax² + By², E*δ/(p₀a), and κ at ν = 0.3 in
# the centre and by the curvatures along x and y.
ELLIPSES = {
    0.5: (0.630306, 1.79181, 1.07826, (1.2505, 1.1653, 1.3704)),
    0.2: (0.409502, 4.84301, 0.603222, (1.2909, 1.2352, 1.4087)),
}


def ellipsoid(slender):
    along_x, along_y, *_ = ELLIPSES[slender]
    return {"kind": "ellipsoid", "radius_x": 10e-3, "radius_y": 10e-3 * along_x / along_y}


@pytest.mark.parametrize("slender", ELLIPSES)
def test_an_elliptical_contact_is_that_of_hertz(slender):
    along_x, along_y, approach, couplings = ELLIPSES[slender]
    contact = EllipticContact.of(0.5 / along_x, 0.5 / along_y, 1.0, MODULUS)
    half_x, half_y = contact.half_widths
    unit = contact.peak_pressure / MODULUS
    assert half_y / half_x == near(slender, rel=1e-5)
    assert unit / half_x == near(1.0, rel=1e-5)
    assert contact.approach / (unit * half_x) == near(approach, rel=1e-5)
    assert contact.load == near(2 / 3 * math.pi * half_x * half_y * contact.peak_pressure)
    found = case(ellipsoid(slender))
    assert found.coupling == near(couplings[0], rel=1e-4)
    assert found.indenter.couplings(found.bodies) == near(couplings[1:], rel=1e-4)
    # Turned by a right angle, slip is across the ellipse.
    turned = EllipticContact.of(0.5 / along_y, 0.5 / along_x, 1.0, MODULUS)
    assert turned.half_widths == near((half_y, half_x), rel=1e-12)


@pytest.mark.parametrize(("angle", "slender"), [(90, 1.0), (30, 0.180565)])
def test_crossed_cylinders_touch_in_an_ellipse(angle, slender):
    crossed = case({"kind": "crossed_cylinders", "radii": "5 mm", "angle": f"{angle} deg"})
    assert crossed.hertz.axis_ratio == near(slender, rel=2e-6)
    # The gap follows from its principal radii along axes, the first of which halves the angle.
    indenter = crossed.indenter
    turn = indenter.rotation
    assert turn == near(math.radians(angle) / 2, rel=1e-9) if angle < 90 else turn == 0.0
    x, y = np.meshgrid([1e-4, -2e-4, 3e-5], [2e-4, 5e-5])
    along, across = x * np.cos(turn) + y * np.sin(turn), y * np.cos(turn) - x * np.sin(turn)
    first, second = indenter.radii_of_gap
    expected = along**2 / (2 * first) + across**2 / (2 * second)
    np.testing.assert_allclose(indenter.gap(x, y), expected, rtol=1e-9)
    assert indenter.even == (angle == 90, angle == 90)


# b/a: dR/a², PR/E*a³, c/a at Q/µP = 0.2, 0.5, 0.8.
PUNCHES = {
    0.8: (0.0851991, 0.157199, (0.975806, 0.933204, 0.876029)),
    0.5: (0.342427, 0.558933, (0.950546, 0.859500, 0.725449)),
}


@pytest.mark.parametrize("flat", PUNCHES)
def test_a_round_punch_is_that_of_the_method_of_dimensionality_reduction(flat):
    approach, load, sticks = PUNCHES[flat]
    contact = RoundContact.under(RoundedPunch(flat, 1.0), load, 1.0)
    assert contact.contact_radius == near(1.0, rel=3e-6)
    assert contact.approach == near(approach, rel=3e-6)
    for ratio, stick in zip((0.2, 0.5, 0.8), sticks, strict=True):
        assert contact.with_load((1 - ratio) * load).contact_radius == near(stick, rel=3e-6)
    # The midpoints of rings carry the load.
    rings = (np.arange(400) + 0.5) / 400
    carried = 2.0 * math.pi * (rings * contact.pressure(rings)).mean()
    assert carried == near(load, rel=2e-4)
    at_depth = contact.with_approach(contact.approach)
    assert at_depth.load == near(load, rel=1e-9)


# Each kind of indenter by two random numbers of the order of 1: its size, m, and its proportions.
INDENTERS = {
    "sphere": lambda size, _: Sphere(size),
    "cylinder": lambda size, _: Cylinder(size),
    "ellipsoid": lambda size, part: Ellipsoid(size, part * size),
    "crossed_cylinders": lambda size, part: CrossedCylinders((size, part * size), 0.25 * math.pi),
    # In whole micrometres, as users write them.
    "round_punch": lambda size, part: RoundPunch(1e-6 * round(1e5 * size), part * size),
    "flat_punch": lambda size, part: FlatPunch(1e-6 * round(1e5 * size), part * size),
}


@pytest.mark.parametrize("kind", INDENTERS)
def test_closed_forms_hold_for_forty_shapes_of_each_indenter(kind):
    """Load, approach and pressure belong together, however sharp an edge and light the load."""
    sizes, parts, widths, moduli = 10 ** np.random.default_rng(1).uniform(
        [[-3], [-1], [-6], [8]], [[-1], [1], [-0.8], [11.5]], (4, 40)
    )
    angle = (np.arange(100) + 0.5) / 100
    shapes = zip(sizes, parts, widths, moduli, strict=True)
    for size, part, wide, modulus in shapes:
        indenter = INDENTERS[kind](size, part)
        flat = getattr(indenter, "flat", 0.0)
        unit = indenter.hertz(NormalLoad(1.0), modulus)
        radius = flat + wide * (indenter.edge_radius if flat else unit.radius)
        pressed = unit.with_load(unit.load_at(radius))
        # What is beyond a flat has lost as many digits as it is narrower.
        digits = 1e-13 * radius / (radius - flat)
        assert pressed.contact_radius == near(radius, rel=1e-12)
        assert pressed.load_at(pressed.contact_radius) == near(pressed.load, rel=max(digits, 1e-11))
        assert pressed.with_approach(pressed.approach).load == near(pressed.load, rel=1e-9)
        less, more = (pressed.with_load(part * pressed.load) for part in (0.999, 1.001))
        stiffness = 0.002 * pressed.load / (more.approach - less.approach)
        if indenter.frame is LINE_CONTACT:
            assert stiffness == near(1 / pressed.compliance, rel=1e-6)
        elif indenter.is_axisymmetric:
            assert stiffness == near(2 * modulus * radius, rel=1e-6)
        else:
            assert stiffness == near(1.5 * pressed.load / pressed.approach, rel=1e-6)
        heavier = [pressed.with_load(part * pressed.load) for part in (1.0, 1.5, 20.0)]
        for name in ("contact_radius", "approach", "mean_pressure"):
            assert (np.diff([getattr(each, name) for each in heavier]) > 0).all(), name
        # The midpoints of two parts of the contact, on and beyond the flat, where r = a sin φ.
        end = math.atan2(flat, math.sqrt((radius - flat) * (radius + flat)))
        angles = np.concatenate([end * angle, end + (0.5 * math.pi - end) * angle])
        steps = np.repeat([end, 0.5 * math.pi - end], 100) / 100
        sines, pressure = np.sin(angles), pressed.pressure(radius * np.sin(angles))
        weight = 2.0 if indenter.frame is LINE_CONTACT else 2.0 * math.pi * radius * sines
        carried = (pressure * weight * radius * np.cos(angles) * steps).sum()
        # The pressure has an infinite slope at the end of a flat.
        assert carried == near(pressed.load, rel=1e-3)
        assert (pressure > 0).all()
        assert pressure.max() <= (1 + 1e-5) * pressed.peak_pressure <= 1.01 * pressure.max()


def test_a_round_punch_is_moved_and_pressed_by_displacements():
    """P(c) = (1 − X) P and U = µκ (g(a) − g(c)), whichever of them is given."""
    flat = 0.5
    approach, _, sticks = PUNCHES[flat]
    indenter, load = punch(flat)
    deep = approach * PUNCH_RADIUS**2 / 10e-3
    for ratio, stick in zip((0.2, 0.5, 0.8), sticks, strict=True):
        moved = case(indenter, load).indenter.profile.depth(stick * PUNCH_RADIUS)
        way = 0.5 * case(indenter, load).coupling * (deep - moved)
        for pressed in (load, None):
            held = {} if pressed else {"indentation": deep}
            pushed = case(indenter, pressed, None, displacement_amplitude=way, **held)
            state = first_loading(wear_problem(pushed, Rings))
            assert 1 - state.reduced.load / state.load == near(ratio, rel=1e-4)
            assert pushed.tangential_ratio == near(ratio, rel=1e-4)
    begins = 0.5 * pushed.coupling * deep
    assert pushed.loading.transition(0.5, pushed.coupling, pushed.hertz) == near(begins, rel=1e-5)


def punch(flat):
    """A punch, and the load under which its contact has the radius."""
    indenter = {"kind": "round_punch", "flat_radius": flat * PUNCH_RADIUS, "edge_radius": 10e-3}
    profile = RoundedPunch(flat * PUNCH_RADIUS, 10e-3)
    return indenter, RoundContact.under(profile, 1.0, MODULUS).load_at(PUNCH_RADIUS)


@pytest.mark.parametrize(
    ("indenter", "load", "rings"),
    [
        (ellipsoid(0.2), 50.0, False),
        *((*punch(0.5), rings) for rings in (False, True)),
        ({"kind": "crossed_cylinders", "radii": ["5 mm", "9 mm"]}, 50.0, False),
    ],
)
def test_first_loading_at_the_default_cell_is_that_of_the_closed_form(indenter, load, rings):
    pressed = case(indenter, load)
    contact, stick = pressed.hertz, pressed.hertz.with_load(pressed.stick_load)
    problem = wear_problem(pressed, Rings if rings else Grid)
    state = first_loading(problem)
    found = Measures(problem, state)
    area = problem.hertz.load / contact.mean_pressure
    center = float(contact.pressure(0.0))
    assert state.geometry.integral(state.pressure) == near(load, rel=1e-9)
    assert found.approach == near(contact.approach, rel=1e-4)
    assert found.central_pressure == near(center, rel=1e-3)
    assert found.peak_pressure == near(contact.peak_pressure, rel=2e-3)
    assert found.contact_area == near(area, rel=1e-2)
    sticks = zip(("x", "y"), pressed.indenter.half_widths(stick), strict=True)
    for axis, half_width in sticks:
        assert getattr(found, f"stick_half_width_{axis}") == near(half_width, rel=3e-3)


def test_a_contact_at_an_angle_wears_alike_on_opposite_sides():
    turned = case(
        {"kind": "crossed_cylinders", "radii": "10 mm", "angle": "60 deg"}, cell="6 um", ratio=0.8
    )
    problem = wear_problem(turned)
    *_, state = evolve(problem, [1000])
    assert state.geometry.even == (False, False)
    wear = state.wear
    np.testing.assert_allclose(wear, wear[::-1, ::-1], atol=1e-5 * wear.max())
    # It is no mirror image of itself.
    assert np.abs(wear - wear[::-1]).max() > 0.3 * wear.max()


def test_a_round_ellipsoid_is_a_sphere_and_so_is_a_profile_of_a_paraboloid(tmp_path):
    sphere = steel(cycles=100, tangential_ratio=0.5)
    alike = case({"kind": "ellipsoid", "radius_x": "10 mm", "radius_y": "10 mm"})
    for name in ("coupling", "hertz_radius", "hertz_pressure"):
        assert getattr(alike, name) == near(getattr(sphere, name), rel=1e-12)
    assert alike.hertz.approach == near(sphere.hertz.approach, rel=1e-12)
    assert alike.grid_spacing == sphere.grid_spacing
    tip = tmp_path / "tip.csv"
    rows = (f"{r}, {r**2 / 20e3}" for r in range(0, 405, 5))
    tip.write_text("r (um), z (um)\n" + "\n".join(rows))
    profile = case({"kind": "profile", "file": str(tip)})
    assert profile.hertz.contact_radius == near(sphere.hertz.contact_radius, rel=1e-4)
    assert profile.hertz.approach == near(sphere.hertz.approach, rel=1e-4)
    problem = wear_problem(profile, Rings)
    found = Measures(problem, first_loading(problem))
    assert found.approach == near(sphere.hertz.approach, rel=3e-4)
    assert found.stick_half_width_x == near(sphere.stick_radius, rel=1e-3)
    assert not {"hertz_pressure", "hertz_radius"} & profile.scalar_coordinates().keys()
    with pytest.raises(CaseError, match="is too much for this profile"):
        case({"kind": "profile", "file": str(tip)}, load=2000.0)
