"""Keys stay within their figure."""

import pytest
from matplotlib.lines import Line2D

from fretwear.figures.axes import outside_key
from fretwear.figures.style import JournalFigure, style_context


@pytest.mark.parametrize("columns", [1, 2])
@pytest.mark.parametrize("words", ["short", "some more words than that"])
def test_a_key_is_no_wider_than_its_figure(columns: int, words: str) -> None:
    with style_context():
        figure = JournalFigure(columns, 60.0)
        figure.subplots()
        labels = [f"{words} {number}" for number in range(9)]
        key = outside_key(figure, [Line2D([], []) for _ in labels], labels)
        figure.draw_without_rendering()
        assert key.get_window_extent().width <= figure.bbox.width
        assert figure.legends == [key]
        assert [text.get_text() for text in key.get_texts()] == labels
