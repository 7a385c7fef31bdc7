import pytest

from .checkout import Checkout


@pytest.fixture(scope="module")
def checkout(tmp_path_factory):
    made = Checkout(tmp_path_factory.mktemp("checkout").resolve())
    yield made
    made.stop()
