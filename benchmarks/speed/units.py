"""The unit CE, clocks, and the share of time inside transforms."""

import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from statistics import median
from types import ModuleType
from typing import Any

import numpy as np
import scipy.fft

# Kept as they are here, so that a unit is never counted as a transform of the job.
_dct, _idct = scipy.fft.dct, scipy.fft.idct
_COSINE = ("dct", "idct", "dctn", "idctn")
_FOURIER = ("fft", "ifft", "rfft", "irfft", "fft2", "ifft2", "rfft2", "irfft2", "fftn", "rfftn")
_TRANSFORMS = {
    "scipy.fft": _COSINE + _FOURIER,
    "ducc0.fft": ("dct", "separable_hartley"),
    "pyfftw.interfaces.scipy_fft": _COSINE,
}


@dataclass
class Spent:
    """Time of a job, s: of the processor in this process, and of the clock on the wall."""

    cpu: float = 0.0
    wall: float = 0.0

    def __add__(self, other: "Spent") -> "Spent":
        return Spent(self.cpu + other.cpu, self.wall + other.wall)

    def over(self, unit: "Spent") -> "Spent":
        """Both times in units of another pair."""
        return Spent(self.cpu / unit.cpu, self.wall / unit.wall)


def middle(times: list[Spent]) -> Spent:
    """Median of each clock."""
    return Spent(median(t.cpu for t in times), median(t.wall for t in times))


class Stopwatch:
    """Both clocks since it was made or read."""

    def __init__(self) -> None:
        self.read()

    def read(self) -> Spent:
        """Time since the last reading."""
        cpu, wall = time.process_time(), time.perf_counter()
        spent = Spent()
        if hasattr(self, "_cpu"):
            spent = Spent(cpu - self._cpu, wall - self._wall)
        self._cpu, self._wall = cpu, wall
        return spent


def bare_convolution(pressure: np.ndarray, spectrum: np.ndarray) -> np.ndarray:
    """The convolution of an even field with a kernel of a real spectrum, by scipy.fft.

    The quarter ``pressure``, shape (nx, ny), is padded with zeros to the shape (2 nx, 2 ny) of
    ``spectrum``; rows that are zero are not transformed.
    """
    nx, ny = pressure.shape
    rows = _dct(pressure, n=2 * ny, axis=1)
    both = _dct(rows, n=2 * nx, axis=0)
    both *= spectrum
    rows = _idct(both, axis=0, overwrite_x=True)[:nx]
    return _idct(rows, axis=1, overwrite_x=True)[:, :ny]


class Unit:
    """One CE: the bare convolution on a quarter window, sampled whenever it is asked for.

    Parameters
    ----------
    shape
        Cells of the quarter window.
    """

    def __init__(self, shape: tuple[int, int]) -> None:
        nx, ny = shape
        generator = np.random.default_rng(1)
        self._pressure = generator.random(shape)
        self._spectrum = generator.random((2 * nx, 2 * ny))
        self._times: list[Spent] = []
        for _ in range(2):
            bare_convolution(self._pressure, self._spectrum)

    def sample(self, count: int = 1) -> Spent:
        """Time some convolutions; the median of these alone."""
        times = []
        for _ in range(count):
            watch = Stopwatch()
            bare_convolution(self._pressure, self._spectrum)
            times.append(watch.read())
        self._times += times
        return middle(times)

    @property
    def time(self) -> Spent:
        """Median of all samples."""
        return middle(self._times)

    @property
    def samples(self) -> int:
        return len(self._times)


class Units:
    """The unit of each window that a run comes to."""

    def __init__(self) -> None:
        self._units: dict[tuple[int, int], Unit] = {}

    def __getitem__(self, shape: tuple[int, int]) -> Unit:
        if shape not in self._units:
            self._units[shape] = Unit(shape)
        return self._units[shape]

    def complete(self, least: int) -> None:
        """Sample each unit until it has so many samples."""
        for unit in self._units.values():
            unit.sample(max(1, least - unit.samples))


@dataclass
class Transforms:
    """Processor time, s, spent inside the calls of transforms, and their number."""

    seconds: float = 0.0
    calls: int = 0

    @contextmanager
    def counted(self) -> Iterator[None]:
        """Count every transform in the block, whichever module calls it by whichever name."""
        replaced: list[tuple[ModuleType, str, Any]] = []
        wrapped: dict[int, Callable[..., Any]] = {}
        for library, names in _TRANSFORMS.items():
            for name in names:
                function = getattr(sys.modules.get(library), name, None)
                if function is not None:
                    wrapped[id(function)] = self._timed(function)
        for module in _modules():
            for name, value in list(vars(module).items()):
                if id(value) in wrapped:
                    replaced.append((module, name, value))
        for module, name, value in replaced:
            setattr(module, name, wrapped[id(value)])
        try:
            yield
        finally:
            for module, name, value in replaced:
                setattr(module, name, value)

    def _timed(self, function: Callable[..., Any]) -> Callable[..., Any]:
        def call(*arguments: Any, **keywords: Any) -> Any:
            started = time.process_time()
            result = function(*arguments, **keywords)
            self.seconds += time.process_time() - started
            self.calls += 1
            return result

        return call


def _modules() -> list[ModuleType]:
    """The modules that call transforms: ours and the libraries' own names for them."""
    return [
        module
        for name, module in list(sys.modules.items())
        if isinstance(module, ModuleType)
        and (name in _TRANSFORMS or name == "fretwear" or name.startswith("fretwear."))
    ]
