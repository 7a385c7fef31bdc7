import shutil
from pathlib import Path

import pytest

from fretwear_fit.request import Measurement
from fretwear_fit.search import fit

from ..cli.conftest import desk  # noqa: F401

EXPERIMENTS = Path(__file__).parents[2] / "studies/experiments"


def measured(x, values, quantity="wear_depth", **keys):
    """A measurement of the section fit with readings in SI units, without a file."""
    result = Measurement.unchecked(quantity=quantity, **keys)
    vars(result)["_read"] = x, values, ""
    return result


@pytest.fixture(scope="session")
def titanium(made_once):
    """The fit of the measured U scar of a Ti-6Al-4V cylinder, with its study and its runs."""

    def make(folder):
        for file in EXPERIMENTS.glob("arnaud2021_u*"):
            shutil.copy(file, folder)
        fit(folder / "arnaud2021_u_fit.yaml", folder=folder / "runs")

    folder = made_once("titanium", make)
    return fit(folder / "arnaud2021_u_fit.yaml", folder=folder / "runs")
