"""The compiled kernels against those in NumPy, and what both promise."""

import subprocess
import sys
from dataclasses import replace
from functools import partial

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from fretwear.mechanics import convolution, kernels, state, team
from fretwear.mechanics.geometry import grid
from fretwear.mechanics.integrator import evolve
from fretwear.mechanics.roughness import SelfAffineRoughness
from fretwear.mechanics.team import ALONE, Team

from .problems import CONVERGED, ROUGH, fretting

compiled = pytest.importorskip(
    "fretwear.mechanics.compiled_kernels", reason="the kernels were not compiled here"
)

# Fewer cells than a vector has, a few vectors and a rest, more than a block, and rows of such.
SHAPES = [(1, 1), (3, 5), (7, 13), (40, 67), (2, 40_000)]


# Of the wear of a stage: none, tiny, common and huge.
EXPONENTS = (0.0, 1e-15, 1e-9, 2e-5, 4e-5, 150.0, 1e4)


class Fields:
    """Fields of one shape, drawn in the order in which they are asked for."""

    def __init__(self, shape, seed=0):
        self.shape, self._random = shape, np.random.default_rng(seed)

    def double(self):
        return self._random.standard_normal(self.shape)

    def positive(self):
        return self._random.random(self.shape)

    def single(self):
        return self._random.standard_normal(self.shape, np.float32)

    def inside(self):
        return (self._random.random(self.shape) < 0.6).astype(np.float32)

    def mask(self):
        return self._random.random(self.shape) < 0.5

    def pressure(self):
        """Open cells, free ones and ones at the limit of 1."""
        return np.clip(self._random.normal(0.5, 0.8, self.shape), 0.0, 1.0)

    def loaded(self):
        return self.pressure() + 0.1

    def full(self):
        return np.ones(self.shape)

    def relieved(self):
        """Pressure of none in the cells that have the exponents of ``known`` alone."""
        pressure = self.pressure()
        pressure.flat[: len(EXPONENTS)] = 0.0
        return pressure

    def known(self):
        known = 2.0 * self.positive()
        known.flat[: len(EXPONENTS)] = EXPONENTS[: known.size]
        return known


# What each kernel is called with, by its name and a variant: fields by their kind.
STAGE = ("relieved", 1.7, "known")
CALLS = {
    "inner": ("single", "single"),
    "inner of doubles": ("double", "double"),
    "total": ("single",),
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
    "evaluate": ("double", "pressure", 1.0, 0.3, 0.1, "double", "mask"),
    "evaluate elastic": ("double", "loaded", np.inf, 0.3, 0.1, "double", "mask"),
    "evaluate saturated": ("double", "full", 1.0, 0.3, 0.1, "double", "mask"),
    "scale_step": ("pressure", "double", "single", 0.3, "single", 0.01, "double"),
    "descent": ("double", "double"),
    "move": (0.8, "double", 1.0, "single", 0.3, 0.1, "double", "pressure", "double", "double"),
    "scale_and_clip": (1.3, 1.0, 1.0, None, "pressure"),
    "scale_and_clip weighted": (0.7, 1.0, 0.9, "positive", "pressure"),
    "scale_and_clip elastic": (1.3, np.inf, np.inf, None, "double"),
    "wear": (*STAGE, "positive", "positive", "double", "double"),
    "wear without flow": (*STAGE, "positive", "positive", None, "double"),
    "wear_slope": (*STAGE, "positive", "double", 1.7, "single"),
    "wear_slope without flow": (*STAGE, "positive", None, 1.7, "single"),
}


PASSES = {name: each for name, each in vars(kernels).items() if isinstance(each, kernels.Pass)}
IN_NUMPY = {name: each.in_numpy for name, each in PASSES.items()}
NAMES = {variant.split()[0] for variant in CALLS}


def arguments(variant, f):
    return [getattr(f, each)() if isinstance(each, str) else each for each in CALLS[variant]]


def as_tuple(result):
    return result if isinstance(result, tuple) else (result,)


def test_without_the_compiled_ones_numpy_does_the_arithmetic():
    script = (
        "import sys; sys.modules['fretwear.mechanics.compiled_kernels'] = None\n"
        "from fretwear.mechanics import kernels\n"
        "assert kernels.inner.compiled is None"
    )
    subprocess.run([sys.executable, "-c", script], check=True)
    assert kernels.inner.compiled is not None


# Offered by processors that have vectors for them.
WINDOWS = {"SingleWindow", "DoubleWindow"}
with_windows = pytest.mark.skipif(
    not hasattr(compiled, "DoubleWindow"), reason="this processor's vectors are too short"
)


def test_every_kernel_is_compiled_and_compared():
    offered = {name for name in vars(compiled) if not name.startswith("_")}
    others = {"source", "Threads", "product", *WINDOWS}
    assert offered - others == NAMES == set(PASSES)
    for name in NAMES:
        assert PASSES[name].compiled is getattr(compiled, name)


@pytest.mark.parametrize("shape", SHAPES, ids=str)
@pytest.mark.parametrize("variant", CALLS)
def test_a_compiled_pass_does_what_numpy_does(variant, shape):
    name = variant.split()[0]
    ours, theirs = (arguments(variant, Fields(shape)) for _ in range(2))
    before = arguments(variant, Fields(shape))
    found = as_tuple(PASSES[name](ALONE, *ours))
    expected = as_tuple(IN_NUMPY[name](*theirs))
    assert len(found) == len(expected)
    single = any(getattr(each, "dtype", None) == np.float32 for each in (*ours, *found))
    rtol = 2e-6 if single else 2e-13
    changed = 0
    for one, other, was in zip(
        (*found, *ours), (*expected, *theirs), (*[None] * len(found), *before), strict=True
    ):
        if other is None:
            assert one is None
            continue
        # Sums of numbers of both signs cancel.
        scale = np.abs(np.asarray(other, np.float64)).max(initial=0.0)
        cells = shape[0] * shape[1] if np.ndim(other) == 0 else 1
        np.testing.assert_allclose(one, other, rtol=rtol, atol=rtol * (scale + cells))
        assert getattr(one, "dtype", None) == getattr(other, "dtype", None)
        if isinstance(was, np.ndarray):
            changed += not np.array_equal(one, was)
    # Nothing but what a kernel is to change has changed.
    writes = {"advance": 2, "move": 3, "evaluate": 2}
    writes |= dict.fromkeys(("inner", "total", "largest", "descent", "level"), 0)
    assert changed <= writes.get(name, 1)


WITHOUT_SYMMETRY = [(4, 6), (10, 12), (54, 40), (32, 108), (512, 600)]


@with_windows
@pytest.mark.parametrize("shape", WITHOUT_SYMMETRY, ids=str)
def test_the_compiled_convolution_does_what_numpy_does_by_however_many_threads(monkeypatch, shape):
    random = np.random.default_rng(3)
    kernel, field = random.random((shape[0] + 1, shape[1] + 1)), random.standard_normal(shape)
    kernel[0, 0] = 0.3 * kernel.size
    ours, *shared = (
        convolution.Convolution.with_kernel(kernel.copy(), (False, False), Team(workers))
        for workers in (1, 2, 3)
    )
    assert type(ours) is convolution.WholeConvolution
    for each in shared:
        np.testing.assert_array_equal(each(field), ours(field))
    single = field.astype(np.float32)
    found = [ours(field), ours.in_single(2.0)(single), ours.in_single(2.0).inverse(7.0)(+single)]
    monkeypatch.setattr(convolution, "library", None)
    theirs = convolution.Convolution.with_kernel(kernel, (False, False))
    expected = [
        theirs(field), theirs.in_single(2.0)(single), theirs.in_single(2.0).inverse(7.0)(+single)
    ]  # fmt: skip
    for one, other, rtol in zip(found, expected, (1e-14, 2e-6, 2e-6), strict=True):
        assert one.dtype == other.dtype
        np.testing.assert_allclose(one, other, atol=rtol * np.abs(other).max())


@with_windows
def test_a_compiled_convolution_refuses_fields_of_other_windows():
    window, threads = compiled.DoubleWindow(4, 6), ALONE.threads
    spectrum, field = np.ones((4, compiled.DoubleWindow.lanes)), np.ones((4, 6))
    window.convolve(threads, field, [spectrum], field.copy())
    for fields in ((field, [spectrum], field[:2].copy()), (field, [spectrum[:3]], field.copy())):
        with pytest.raises(ValueError, match="must be of"):
            window.convolve(threads, *fields)
    for spectra in ([spectrum] * 2, []):
        with pytest.raises(ValueError, match="one spectrum or four"):
            window.convolve(threads, field, spectra, field.copy())
    with pytest.raises(ValueError, match="even numbers"):
        compiled.DoubleWindow(3, 4).convolve(threads, field, [spectrum], field.copy())
    with pytest.raises(ValueError, match="2, 3 and 5"):
        compiled.DoubleWindow(14, 4)


def test_the_product_of_matrices_is_that_of_numpy():
    f = Fields((70, 9))
    left, right = f.double(), np.random.default_rng(1).random((9, 130))
    expected = np.einsum("ik,kj->ij", left, right)
    for one, other in ((left, right), (np.asfortranarray(left), np.repeat(right, 2, 1)[:, ::2])):
        np.testing.assert_allclose(kernels.product(one, other), expected, atol=1e-14)
    with pytest.raises(ValueError, match="must fit"):
        kernels.product(left, right[:8])


@pytest.mark.parametrize("variant", CALLS)
def test_a_team_does_what_one_thread_does_to_the_last_bit(variant):
    """On more cells than go unshared."""
    name, shape = variant.split()[0], (500, 400)
    given = [arguments(variant, Fields(shape)) for _ in range(3)]
    alone, *shared = (
        as_tuple(PASSES[name](Team(workers), *each)) for workers, each in enumerate(given, 1)
    )
    whole = arguments(variant, Fields(shape))
    np.testing.assert_allclose(
        np.array(alone, float),
        np.array(as_tuple(IN_NUMPY[name](*whole)), float),
        rtol=1e-5,
        atol=0.02,
    )
    for found, fields in zip(shared, given[1:], strict=True):
        assert found == alone
        for one, other in zip(fields, given[0], strict=True):
            np.testing.assert_array_equal(one, other)


@pytest.mark.parametrize("variant", ["project_mean", "evaluate", "scale_step", "wear", "weigh"])
def test_what_is_not_a_number_is_not_hidden(variant):
    name = variant.split()[0]
    for kernel in (IN_NUMPY[name], partial(PASSES[name], ALONE)):
        given = arguments(variant, Fields((7, 13)))
        fields = [each for each in given if isinstance(each, np.ndarray)]
        # A pressure that is none never comes as far as a step: it is the step's here.
        fields[2 if name == "scale_step" else 0][3, 5] = np.nan
        result = kernel(*given)
        outcome = given[-1] if result is None else np.array(result)
        assert not np.isfinite(outcome).all(), kernel


def test_fields_to_be_read_lie_as_they_like_and_those_to_be_written_are_taken_as_they_are():
    f = Fields((6, 9))
    field, other, step = f.double(), f.double(), f.single()
    expected = IN_NUMPY["inner"](field, other)
    wide = np.repeat(field, 2, axis=1)
    for same in (np.asfortranarray(field), wide[:, ::2], np.broadcast_to(field, (6, 9))):
        assert kernels.inner(ALONE, same, other) == pytest.approx(expected, rel=1e-14)
    whole = step.round()
    assert kernels.descent(ALONE, field, whole) == pytest.approx(IN_NUMPY["descent"](field, whole))
    for wrong in (f.double(), "field", None, np.zeros(3, np.float32)):
        with pytest.raises(TypeError):
            kernels.total(ALONE, wrong)
    frozen = step.copy()
    frozen.flags.writeable = False
    for wrong in (field, step[:, ::2], np.asfortranarray(step), step.ravel(), frozen):
        kept = wrong.copy()
        with pytest.raises(TypeError):
            kernels.update_direction(ALONE, 0.5, f.single(), wrong)
        np.testing.assert_array_equal(wrong, kept)
    with pytest.raises(ValueError, match="one shape"):
        kernels.inner(ALONE, field, np.ascontiguousarray(other[:5]))


@given(st.floats(-30.0, 200.0))
def test_the_exponential_is_good_to_two_units_in_the_last_place(exponent):
    one, nothing, known = np.ones((1, 1)), np.zeros((1, 1)), np.array([[exponent]])
    result = np.zeros((1, 1))
    kernels.wear(ALONE, nothing, 1.0, known, nothing, one, None, result)
    exact = np.expm1(np.longdouble(exponent))
    assert abs(result[0, 0] - exact) <= 2.5 * np.spacing(abs(np.float64(exact)))


@pytest.mark.parametrize("limit", [np.inf, 0.7])
def test_a_run_is_the_same_without_the_compiled_kernels(monkeypatch, limit):
    problem = fretting(16, roughness=ROUGH, limit=limit)
    *_, by_compiled = evolve(problem, [300], accuracy=CONVERGED)
    for each in PASSES.values():
        monkeypatch.setattr(each, "compiled", None)
    for module in (convolution, kernels):
        monkeypatch.setattr(module, "library", None)
    *_, by_numpy = evolve(problem, [300], accuracy=CONVERGED)
    assert by_compiled.step == by_numpy.step
    scale = by_numpy.wear.max()
    np.testing.assert_allclose(by_compiled.wear, by_numpy.wear, atol=1e-7 * scale)
    np.testing.assert_allclose(by_compiled.plastic, by_numpy.plastic, atol=1e-6 * scale)


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


@pytest.mark.parametrize("library", [compiled, None], ids=["compiled", "python"])
def test_threads_keep_the_order_of_results_and_raise_what_one_of_them_raises(monkeypatch, library):
    monkeypatch.setattr(team, "library", library)
    both = Team(2)
    with pytest.raises(ZeroDivisionError):
        both.each(lambda part: 1 // (part - 7), range(20))
    assert both.each(lambda part: part**2, range(20)) == [part**2 for part in range(20)]
