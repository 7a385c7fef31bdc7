"""Cosine and Hartley transforms against their definitions, whichever library makes them."""

import numpy as np
import pytest

from fretwear.mechanics import convolution
from fretwear.mechanics.convolution import dct, hartley

SHAPE = (6, 10)


@pytest.fixture(params=["as installed", "scipy"], autouse=True)
def _library(request, monkeypatch):
    if request.param == "scipy":
        monkeypatch.setattr(convolution, "ducc0", None)


def field(shape: tuple[int, int] = SHAPE) -> np.ndarray:
    return np.random.default_rng(3).standard_normal(shape)


def type_2(count: int) -> np.ndarray:
    k, j = np.ogrid[:count, :count]
    return 2.0 * np.cos(np.pi * k * (2 * j + 1) / (2 * count))


def type_3(count: int) -> np.ndarray:
    result = type_2(count).T
    result[:, 0] = 1.0
    return result


def type_4(count: int) -> np.ndarray:
    k, j = np.ogrid[:count, :count]
    return 2.0 * np.cos(np.pi * (2 * k + 1) * (2 * j + 1) / (4 * count))


COSINE = [(2, type_2), (3, type_3), (4, type_4)]


@pytest.mark.parametrize(("kind", "matrix"), COSINE)
def test_cosine_transforms_are_their_definitions_along_the_axes_given(kind, matrix):
    both, rows, columns = field(), field(), field()
    dct(kind, both, (0, 1))
    dct(kind, rows, (1,))
    dct(kind, columns, (0,))
    np.testing.assert_allclose(rows, field() @ matrix(10).T, atol=1e-13)
    np.testing.assert_allclose(columns, matrix(6) @ field(), atol=1e-13)
    np.testing.assert_allclose(both, matrix(6) @ field() @ matrix(10).T, atol=1e-13)


@pytest.mark.parametrize(("kind", "matrix"), COSINE)
def test_a_transform_into_another_field_leaves_its_own_as_it_was(kind, matrix):
    source, target = field((9, 10)), np.full((9, 10), np.nan)
    result = dct(kind, source, (1,), into=target)
    assert result is target
    np.testing.assert_array_equal(source, field((9, 10)))
    np.testing.assert_allclose(result, source @ matrix(10).T, atol=1e-13)


@pytest.mark.parametrize(("kind", "matrix"), COSINE)
@pytest.mark.parametrize("elsewhere", [True, False])
def test_single_precision_stays_single(kind, matrix, elsewhere):
    source = field().astype(np.float32)
    expected = source @ matrix(10).T
    result = dct(kind, source, (1,), into=np.empty_like(source) if elsewhere else None)
    assert result.dtype == np.float32
    assert (result is source) is not elsewhere
    np.testing.assert_allclose(result, expected, atol=1e-5)


def cas(count: int) -> np.ndarray:
    angle = 2.0 * np.pi * np.outer(np.arange(count), np.arange(count)) / count
    return np.cos(angle) - np.sin(angle)


@pytest.mark.parametrize(("precision", "rounding"), [(np.float64, 1e-13), (np.float32, 1e-5)])
def test_hartley_transforms_are_their_definition_and_undo_themselves(precision, rounding):
    source = field().astype(precision)
    rows = hartley(source, 1, into=np.empty_like(source))
    columns = hartley(source.copy(), 0)
    assert rows.dtype == columns.dtype == precision
    np.testing.assert_array_equal(source, field().astype(precision))
    np.testing.assert_allclose(rows, source @ cas(10), atol=rounding)
    np.testing.assert_allclose(columns, cas(6) @ source, atol=rounding)
    np.testing.assert_allclose(hartley(rows, 1) / 10, source, atol=rounding)
