"""What several tests of the mechanics ask for."""

import pytest

from fretwear.mechanics import loading, slip, stages, wear


@pytest.fixture
def converged(monkeypatch):
    """Every contact is solved to 1e-11.

    At the usual tolerance, two ways to the same result agree to that tolerance only.
    """
    for module in (stages, loading):
        monkeypatch.setattr(module, "CONTACT_TOLERANCE", 1e-11)
    monkeypatch.setattr(slip, "_TOLERANCE", 1e-11)
    monkeypatch.setattr(slip, "_FIRST_TOLERANCE", 1e-11)
    monkeypatch.setattr(stages, "_PASSING_SLACK", 1.0)
    monkeypatch.setattr(wear, "_FIRST_STAGE_SLACK", 1.0)
