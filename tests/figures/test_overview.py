"""The overview of one case holds its profiles, its scar and its zones."""

from collections.abc import Callable

import pytest
from matplotlib.figure import Figure

from fretwear import figures
from fretwear.running.simulate import Result


@pytest.mark.parametrize("dense", [False, True])
def test_all_of_a_case_on_one_page(
    dense: bool, smooth_run: Result, check_texts: Callable[[Figure], list[str]]
) -> None:
    history = smooth_run.history if dense else None
    figure = figures.overview(smooth_run.dataset, history)
    words = check_texts(figure)
    assert {
        "Pressure (MPa)",
        "Shear traction (MPa)",
        "Gap (µm)",
        "Wear depth (µm)",
        "Half-width along x (µm)",
        "contact",
        "stick",
    } <= set(words)
    assert any("$P$ = 40 N" in text and "smooth" in text for text in words)


def test_a_rough_capped_case_has_an_overview(
    rough, check_texts: Callable[[Figure], list[str]]
) -> None:
    words = check_texts(figures.overview(rough))
    assert any("4500 MPa" in text for text in words)
