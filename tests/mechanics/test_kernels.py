"""The compiled kernels, threads and transforms agree with NumPy for any number of threads."""

import shutil
import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from fretwear.mechanics import convolution, kernels, state, team
from fretwear.mechanics.geometry import grid
from fretwear.mechanics.integrator import evolve
from fretwear.mechanics.roughness import SelfAffineRoughness
from fretwear.mechanics.team import ALONE, Team

from ..studies import near
from .problems import EVEN, folded, fretting, unfolded

# Fewer cells than a vector has, a few vectors and a rest, more than a block, rows of such, and more
# than go unshared.
SHAPES = [(1, 1), (3, 5), (7, 13), (40, 67), (2, 40_000), (500, 400)]
# Exponents of the wear of a stage: none, tiny, common and huge.
EXPONENTS = (0.0, 1e-15, 1e-9, 2e-5, 4e-5, 150.0, 1e4)


def field(kind, shape, random):
    """A field to call a kernel with; of pressures, cells that are open, free and at their limit."""
    some, part = random.standard_normal(shape), random.random(shape)
    limits = 0.2 + np.random.default_rng(2).random(shape)
    if kind in ("known", "relieved"):
        # ``relieved`` has no pressure in the cells that have these exponents of ``known`` alone.
        values = EXPONENTS if kind == "known" else np.zeros(len(EXPONENTS))
        part.flat[: len(EXPONENTS)] = values[: part.size]
    kinds = {"single": some.astype(np.float32), "inside": (part < 0.6).astype(np.float32),
             "mask": part < 0.5, "double": some, "full": np.ones(shape),
             "loaded": np.clip(0.6 + 0.8 * some, 0.1, 1.1),
             "pressure": np.clip(0.5 + 0.8 * some, 0.0, 1.0),
             "limits": limits, "under limits": np.clip(0.5 + 0.8 * some, 0.0, limits)}  # fmt: skip
    return kinds.get(kind, part)


# What each kernel is called with, by its name and a variant: fields by their kind.
STAGE = ("relieved", 1.7, "known")
CALLS = {
    "inner": ("single", "single"),
    "inner of doubles": ("double", "double"),
    "largest": ("single",),
    "largest of doubles": ("double",),
    "times": ("single", "single", "single"),
    "times a number": ("double", 0.3, "single"),
    "project_mean": (0.3, "inside", "single"),
    "weigh": ("single", "single", "single"),
    "update_direction": (0.7, "single", "single"),
    "add_layer": ("single", "single", "single"),
    "add_layer without a layer": (None, "single", "single"),
    "advance": (0.7, *("single",) * 5),
    "recover_displacement": ("single", "single", "single", 0.3, "single"),
    "recover_displacement without a layer": ("single", None, "single", 0.3, "single"),
    "level": (1.0, "double", "double", "pressure"),
    "level saturated": (1.0, "double", "double", "full"),
    "level under limits": ("limits", "double", "double", "under limits"),
    "evaluate": ("double", "pressure", 1.0, 0.3, 0.1, "double", "mask"),
    "evaluate elastic": ("double", "loaded", np.inf, 0.3, 0.1, "double", "mask"),
    "evaluate saturated": ("double", "full", 1.0, 0.3, 0.1, "double", "mask"),
    "evaluate under limits": ("double", "under limits", "limits", 0.3, 0.1, "double", "mask"),
    "scale_step": ("pressure", "double", "single", 0.3, "single", 0.01, 1.0, "double"),
    "scale_step under limits": (
        *("under limits", "double", "single", 0.3, "single", 0.01, "limits", "double"),
    ),
    "move": (0.8, "double", 1.0, "single", 0.3, 0.1, "double", "pressure", "double", "double"),
    "move under limits": (
        *(0.8, "double", "limits", "single", 0.3, 0.1),
        *("double", "under limits", "double", "double"),
    ),
    "scale_and_clip": (1.3, 1.0, True, None, "pressure"),
    "scale_and_clip weighted": (0.7, 1.0, True, "positive", "pressure"),
    "scale_and_clip elastic": (1.3, np.inf, False, None, "double"),
    "scale_and_clip under limits": (1.3, "limits", True, None, "under limits"),
    "scale_and_clip weighted under limits": (0.7, "limits", False, "positive", "under limits"),
    "wear": (*STAGE, "positive", "positive", "double", "double"),
    "wear without flow": (*STAGE, "positive", "positive", None, "double"),
    "wear_slope": (*STAGE, "positive", "double", 1.7, "single"),
    "wear_slope without flow": (*STAGE, "positive", None, 1.7, "single"),
}


# What NumPy makes of the same: results, then the fields that a kernel changes, its last arguments.


def recover_displacement(start, tangent, pressure, shift, residual):
    found = start - residual - shift - (0.0 if tangent is None else tangent * pressure)
    return [pressure.sum(dtype=float), found]


def add_layer(tangent, direction, force):
    force = force if tangent is None else force + tangent * direction
    return [(direction * force).sum(), force]


def advance(length, direction, force, weight, pressure, residual):
    left = residual - length * force
    return [(weight * left).sum(), pressure + length * direction, left]


def scale_and_clip(factor, limit, rigid, weights, pressure):
    kept = rigid & (pressure >= limit)
    found = np.where(kept, pressure, np.clip(factor * pressure, 0.0, limit))
    weights = np.ones_like(found) if weights is None else weights
    return [(weights * found).sum(), weights[found >= limit].sum(), found]


def level(limit, separation, displacement, pressure):
    free = (pressure > 0) & (pressure < limit)
    return [separation[free].sum(), free.sum(), displacement.max()]


def evaluate(separation, pressure, limit, approach, slack, *_):
    gap, open_, full = separation - approach, pressure <= 0, pressure >= limit
    wrong = np.where(open_, -gap, np.where(full, gap, np.abs(gap)))
    free = np.where(open_, gap < -slack, np.where(full, gap > slack, True))
    return [max(wrong.max(), 0.0), gap.sum(), gap, free]


def scale_step(pressure, gap, found, unit, uniform, share, limit, _):
    step = found.astype(float) * unit - uniform.astype(float) * share
    reached = pressure + step
    return [reached.min(), (reached - limit).max(), (step * gap).sum(), step]


def move(fraction, step, limit, moved, unit, offset, shape, pressure, displacement, _):
    displacement = displacement + fraction * (unit * moved.astype(float) + offset)
    pressure = np.clip(pressure + fraction * step, 0.0, limit)
    return [pressure, displacement, displacement + shape]


def wear(pressure, rate, known, start, gap, shift, result):
    x = np.minimum(rate * pressure + known, 200.0)
    if shift is None:
        return [result + start + np.expm1(x) * gap]
    flow = shift * np.divide(np.expm1(x) - x, x, out=np.zeros_like(x), where=x > 1e-12)
    return [result + start + np.maximum(np.expm1(x) * gap + flow, 0.0)]


def wear_slope(pressure, rate, known, gap, shift, factor, _):
    x = np.minimum(rate * pressure + known, 200.0)
    above = x if shift is None else np.maximum(x, 3e-5)
    slope = np.exp(above) * gap
    if shift is not None:
        phi_slope = ((above - np.expm1(above)) / above + np.expm1(above)) / above
        slope = np.maximum(slope + shift * (phi_slope + np.minimum(x - 3e-5, 0.0) / 3), 0.0)
    return [np.minimum(factor * slope, 1e30)]


IN_NUMPY = {
    "inner": lambda one, other: [(one * other).sum()],
    "largest": lambda field: [np.abs(field).max()],
    "times": lambda field, factor, _: [field * factor],
    "project_mean": lambda d, inside, r: [((r - d) ** 2 * inside).sum(), r - d],
    "weigh": lambda weight, r, field: [(r * weight * field).sum(), weight * field],
    "update_direction": lambda factor, field, direction: [factor * direction + field],
    **{each.__name__: each for each in (recover_displacement, add_layer, advance, scale_and_clip)},
    **{each.__name__: each for each in (level, evaluate, scale_step, move, wear, wear_slope)},
}


def arguments(variant, shape):
    random = np.random.default_rng(0)
    return [
        field(each, shape, random) if isinstance(each, str) else each for each in CALLS[variant]
    ]


def called(variant, given, threads=ALONE):
    """Results of a kernel and all of its fields, after a call."""
    found = getattr(kernels, variant.split()[0])(threads, *given)
    results = found if isinstance(found, list) else [] if found is None else [found]
    return results, [each for each in given if isinstance(each, np.ndarray)]


def test_every_kernel_is_compared():
    offered = {name for name in vars(kernels) if not name.startswith("_")}
    others = {
        "source",
        "compiler",
        "processor",
        "Threads",
        "product",
        "SingleWindow",
        "DoubleWindow",
        # Compared in test_polar.py.
        "toroidal_functions",
        "ring_means",
        "invert",
        "displace_waves",
        "solve_on_rings",
    }
    assert offered - others == {variant.split()[0] for variant in CALLS} == set(IN_NUMPY)


@pytest.mark.parametrize("shape", SHAPES, ids=str)
@pytest.mark.parametrize("variant", CALLS)
def test_a_kernel_does_what_numpy_says_and_changes_nothing_else_with_any_team(variant, shape):
    with np.errstate(over="ignore", invalid="ignore"):
        expected = IN_NUMPY[variant.split()[0]](*arguments(variant, shape))
    before = [each for each in arguments(variant, shape) if isinstance(each, np.ndarray)]
    results, fields = called(variant, arguments(variant, shape))
    kept = len(fields) - len(expected) + len(results)
    for one, was in zip(fields[:kept], before[:kept], strict=True):
        np.testing.assert_array_equal(one, was)
    rtol = 2e-6 if any(each.dtype == np.float32 for each in fields) else 2e-13
    for one, other in zip([*results, *fields[kept:]], expected, strict=True):
        # Sums of numbers of both signs cancel.
        scale = np.abs(np.asarray(other, np.float64)).max(initial=0.0)
        cells = shape[0] * shape[1] if np.ndim(other) == 0 else 1
        np.testing.assert_allclose(one, other, rtol=rtol, atol=rtol * (scale + cells))
    for workers in (2, 3):
        shared, same = called(variant, arguments(variant, shape), Team(workers))
        assert shared == results
        for one, other in zip(same, fields, strict=True):
            np.testing.assert_array_equal(one, other)


@pytest.mark.parametrize("variant", ["project_mean", "evaluate", "scale_step", "wear", "weigh"])
def test_what_is_not_a_number_is_not_hidden(variant):
    given = arguments(variant, (7, 13))
    # A pressure that is none never comes as far as a step: it is the step's here.
    fields = [each for each in given if isinstance(each, np.ndarray)]
    fields[2 if variant == "scale_step" else 0][3, 5] = np.nan
    results, fields = called(variant, given)
    assert not np.isfinite(results or fields[-1]).all()


RANDOM = np.random.default_rng(1)
LEFT, RIGHT = RANDOM.random((70, 9)), RANDOM.random((9, 130))


def test_fields_to_be_read_lie_as_they_like_and_those_to_be_written_are_taken_as_they_are():
    wide = np.repeat(RIGHT, 2, 1)[:, ::2]
    expected = np.einsum("ik,kj->ij", LEFT, RIGHT)
    for one, other in ((LEFT, RIGHT), (np.asfortranarray(LEFT), wide)):
        np.testing.assert_allclose(kernels.product(one, other), expected, atol=1e-14)
    for same in (np.asfortranarray(RIGHT), wide, np.broadcast_to(RIGHT, (9, 130))):
        assert kernels.inner(ALONE, same, RIGHT) == near((RIGHT**2).sum(), rel=1e-14)
    step = RIGHT.astype(np.float32)
    for wrong in (RIGHT, "field", None, np.zeros(3, np.float32)):
        with pytest.raises(TypeError):
            kernels.update_direction(ALONE, 0.5, wrong, step)
    frozen = step.copy()
    frozen.flags.writeable = False
    for wrong in (RIGHT, step[:, ::2], np.asfortranarray(step), step.ravel(), frozen):
        kept = wrong.copy()
        with pytest.raises(TypeError):
            kernels.update_direction(ALONE, 0.5, step, wrong)
        np.testing.assert_array_equal(wrong, kept)


WINDOW, SPECTRUM, FIELD = kernels.DoubleWindow(4, 6), np.ones((4, 4)), np.ones((4, 6))


@pytest.mark.parametrize(
    ("call", "given", "sentence"),
    [(kernels.product, (LEFT, RIGHT[:8]), "must fit"),
     (kernels.inner, (ALONE, RIGHT, RIGHT[:5].copy()), "one shape"),
     (WINDOW.convolve, (ALONE, FIELD, [SPECTRUM], FIELD[:2].copy()), "must be of"),
     (WINDOW.convolve, (ALONE, FIELD, [SPECTRUM[:3]], FIELD.copy()), "must be of"),
     (WINDOW.convolve, (ALONE, FIELD, [SPECTRUM] * 2, FIELD.copy()), "one spectrum or four"),
     (kernels.DoubleWindow(3, 4).convolve, (ALONE, FIELD, [SPECTRUM], FIELD), "even numbers"),
     (kernels.DoubleWindow, (14, 4), "2, 3 and 5"),
     (kernels.DoubleWindow, (0, 0), "2, 3 and 5")],
)  # fmt: skip
def test_fields_that_do_not_fit_are_refused(call, given, sentence):
    with pytest.raises(ValueError, match=sentence):
        call(*given)


@given(st.floats(-30.0, 200.0))
def test_the_exponential_is_good_to_two_units_in_the_last_place(exponent):
    one, nothing, known = np.ones((1, 1)), np.zeros((1, 1)), np.array([[exponent]])
    result = np.zeros((1, 1))
    kernels.wear(ALONE, nothing, 1.0, known, nothing, one, None, result)
    exact = np.expm1(np.longdouble(exponent))
    assert abs(result[0, 0] - exact) <= 2.5 * np.spacing(abs(np.float64(exact)))


# On the quarter by ducc0 as installed and by scipy without it.
@pytest.mark.parametrize("even", [*EVEN, "scipy"])
@pytest.mark.parametrize("shape", [(4, 6), (10, 12), (54, 40), (32, 108), (512, 600)], ids=str)
def test_a_convolution_is_that_of_fourier_transforms_by_however_many_threads(
    shape, even, monkeypatch
):
    if even == "scipy":
        monkeypatch.setattr(convolution, "ducc0", None)
        even = True, True
    random = np.random.default_rng(3)
    kernel = random.random((shape[0] + 1, shape[1] + 1))
    kernel[0, 0] = 0.3 * kernel.size
    field = random.standard_normal(folded(np.empty(shape), even).shape)
    whole = unfolded(field, even)
    ours, *shared = (
        convolution.convolution(kernel.copy(), even, Team(workers)) for workers in (1, 2, 3)
    )
    for each in shared:
        np.testing.assert_array_equal(each(field), ours(field))
    periodic = np.pad(kernel, [(0, n - 1) for n in shape], "reflect")
    spectrum = np.fft.fft2(periodic).real
    far = np.fft.ifft2(spectrum * np.fft.fft2(whole, spectrum.shape)).real[: shape[0], : shape[1]]
    near = np.fft.ifft2(np.fft.fft2(whole) / (0.5 * spectrum[::2, ::2] + 7.0)).real
    single, given = ours.in_single(2.0), field.astype(np.float32)
    found = ours(field), single(given), single.inverse(7.0)(+given)
    for one, other, rtol in zip(found, (far, far / 2, near), (1e-14, 2e-6, 2e-6), strict=True):
        assert one.dtype == (field if rtol < 1e-7 else given).dtype
        np.testing.assert_allclose(one, folded(other, even), atol=rtol * np.abs(other).max())


@pytest.mark.parametrize("limit", [np.inf, 2.0])
def test_a_run_is_the_same_by_however_many_threads(monkeypatch, limit):
    """On blocks so small that each pass over the cells has several."""
    for module, name, size in (
        (team, "_SMALL", 100),
        (grid, "_BLOCK", 100),
        (state, "_COLUMNS", 10),
        (convolution, "_BLOCK_BYTES", 4000),
    ):
        monkeypatch.setattr(module, name, size)
    rough = SelfAffineRoughness(0.1e-6, 0.8, 60e-6, 40e-6, seed=1)
    problem = fretting(14, roughness=rough, limit=limit)
    alone, *shared = (
        [*evolve(replace(problem, team=Team(workers)), [100])][-1] for workers in (1, 2, 3)
    )
    for found in shared:
        for name in ("pressure", "gap", "wear", "plastic"):
            np.testing.assert_array_equal(getattr(found, name), getattr(alone, name))
    assert (alone.plastic.max() > 0) == np.isfinite(limit)


def test_threads_keep_the_order_of_results_and_raise_what_one_of_them_raises():
    both = Team(2)
    with pytest.raises(ZeroDivisionError):
        both.each(lambda part: 1 // (part - 7), range(20))
    assert both.each(lambda part: part**2, range(20)) == [part**2 for part in range(20)]


def test_kernels_that_are_missing_or_of_other_sources_are_an_error(tmp_path):
    package = Path(team.__file__).parents[1]
    shutil.copytree(package, tmp_path / "fretwear", ignore=shutil.ignore_patterns("*.pyc"))
    library = tmp_path / "fretwear/mechanics" / Path(kernels.__file__).name

    def told(*command):
        done = subprocess.run(
            [sys.executable, *command], cwd=tmp_path, env={}, capture_output=True, text=True
        )
        return done.stderr.splitlines()

    assert told("-c", "import fretwear.mechanics.team") == []
    (tmp_path / "fretwear/mechanics/more.h").write_text("\n")
    plan = ("-m", "fretwear", "plan", "study.yaml")
    stale, missing = told(*plan), (library.unlink(), told(*plan))[1]
    for lines, words in (
        (stale, "was compiled from other sources"),
        (missing, "not been compiled"),
    ):
        assert len(lines) == 1
        assert lines[0].startswith("fretwear: error: ")
        assert words in lines[0]
        assert "install fretwear again, or compile in a checkout" in lines[0]
