"""Convolutions by ducc0 and by scipy agree with plain Fourier transforms of the padded window."""

import numpy as np
import pytest

from fretwear.mechanics.contact import convolution, kernels

from .problems import EVEN, folded, unfolded


@pytest.mark.parametrize("library", ["ducc0", "scipy"])
@pytest.mark.parametrize("even", EVEN)
@pytest.mark.parametrize("shape", [(4, 6), (10, 12), (54, 40), (32, 216)], ids=str)
def test_a_convolution_is_that_of_fourier_transforms(shape, even, library, monkeypatch):
    if library == "scipy":
        monkeypatch.setattr(kernels, "ducc0", None)
    elif kernels.ducc0 is None:
        pytest.skip("ducc0 is not installed")
    # Several blocks of rows and of columns.
    monkeypatch.setattr(convolution, "_BLOCK_BYTES", 4000)
    random = np.random.default_rng(3)
    kernel = random.random((shape[0] + 1, shape[1] + 1))
    kernel[0, 0] = 0.3 * kernel.size
    field = random.standard_normal(folded(np.empty(shape), even).shape)
    whole = unfolded(field, even)
    ours = convolution.convolution(kernel.copy(), even)
    periodic = np.pad(kernel, [(0, n - 1) for n in shape], "reflect")
    spectrum = np.fft.fft2(periodic).real
    far = np.fft.ifft2(spectrum * np.fft.fft2(whole, spectrum.shape)).real[: shape[0], : shape[1]]
    near = np.fft.ifft2(np.fft.fft2(whole) / (0.5 * spectrum[::2, ::2] + 7.0)).real
    single, given = ours.in_single(2.0), field.astype(np.float32)
    found = ours(field), single(given), single.inverse(7.0)(+given)
    for one, other, rtol in zip(found, (far, far / 2, near), (1e-14, 2e-6, 2e-6), strict=True):
        assert one.dtype == (field if rtol < 1e-7 else given).dtype
        np.testing.assert_allclose(one, folded(other, even), atol=rtol * np.abs(other).max())
