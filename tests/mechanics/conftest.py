"""What several tests of the mechanics ask for."""

import pytest

from fretwear.mechanics import loading, slip, stages, wear

_CONVERGED = 3e-12


@pytest.fixture
def converged(monkeypatch):
    """Every contact is solved to 3e-12.

    At the usual tolerance, two ways to the same result agree to that tolerance only.
    """
    for module in (stages, loading):
        monkeypatch.setattr(module, "CONTACT_TOLERANCE", _CONVERGED)
    monkeypatch.setattr(slip, "_TOLERANCE", _CONVERGED)
    monkeypatch.setattr(slip, "_FIRST_TOLERANCE", _CONVERGED)
    monkeypatch.setattr(stages, "_PASSING_SLACK", 1.0)
    monkeypatch.setattr(wear, "_FIRST_STAGE_SLACK", 1.0)
