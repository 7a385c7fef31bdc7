"""Cosine transforms against their definition, whichever library makes them."""

import numpy as np
import pytest

from fretwear.mechanics import transforms
from fretwear.mechanics.transforms import cosine, inverse_cosine

SHAPE = (6, 10)


@pytest.fixture(params=["as installed", "scipy"])
def _library(request, monkeypatch):
    if request.param == "scipy":
        monkeypatch.setattr(transforms, "ducc0", None)


def field() -> np.ndarray:
    return np.random.default_rng(3).standard_normal(SHAPE)


def definition(count: int) -> np.ndarray:
    """DCT-II: 2 cos(πk(2n + 1)/2N)."""
    k, n = np.ogrid[:count, :count]
    return 2.0 * np.cos(np.pi * k * (2 * n + 1) / (2 * count))


@pytest.mark.usefixtures("_library")
def test_cosine_is_its_definition_along_the_axes_given():
    both, rows = field(), field()
    cosine(both, (0, 1))
    cosine(rows, (1,))
    np.testing.assert_allclose(rows, field() @ definition(10).T, atol=1e-13)
    np.testing.assert_allclose(both, definition(6) @ field() @ definition(10).T, atol=1e-13)


@pytest.mark.usefixtures("_library")
@pytest.mark.parametrize("axes", [(0,), (1,), (0, 1)])
def test_inverse_undoes_it_but_for_the_factor(axes):
    result = field()
    cosine(result, axes)
    inverse_cosine(result, axes)
    factor = np.prod([2 * SHAPE[axis] for axis in axes])
    np.testing.assert_allclose(result / factor, field(), atol=1e-14)


@pytest.mark.usefixtures("_library")
def test_some_rows_of_a_larger_field_are_transformed_in_place():
    whole = np.zeros((9, 10))
    whole[:6] = field()
    cosine(whole[:6], (1,))
    np.testing.assert_allclose(whole[:6], field() @ definition(10).T, atol=1e-13)
    assert not whole[6:].any()
