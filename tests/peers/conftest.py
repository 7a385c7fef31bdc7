"""The marker of the tests that other libraries take part in."""

import pytest


def pytest_configure(config: pytest.Config) -> None:
    config.addinivalue_line("markers", "peers: compares with tamaas and ContactMechanics")
