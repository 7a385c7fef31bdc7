"""Write a page whose blocks are all Python as a notebook: text and code, without output.

    python docs/extensions/notebook.py docs/exercises.md

writes ``docs/exercises.ipynb``.
"""

from __future__ import annotations

import json
import re
import sys
from pathlib import Path
from typing import Any

from examples import blocks


def notebook(page: str) -> dict[str, Any]:
    """The cells of a page: its text, and its blocks of Python; shown output is left out."""
    cells, end = [], 0

    def add(kind: str, text: str) -> None:
        if not (text := text.strip()):
            return
        code = {"execution_count": None, "outputs": []} if kind == "code" else {}
        lines = text.splitlines(keepends=True)
        cells.append(
            {"cell_type": kind, "id": f"cell{len(cells)}", "metadata": {}, **code, "source": lines}
        )

    def add_text(text: str) -> None:
        # Links of the site lead nowhere from a file that was copied.
        add("markdown", re.sub(r"\{download\}(`[^`]*`)|\[([^]]+)\]\([^)]*\)", r"\1\2", text))

    for block in blocks(page):
        fence = page.rindex("```", 0, block.start)
        add_text(page[end:fence])
        if block.language == "python":
            add("code", block.text)
        end = block.start + len(block.text) + len("```\n")
    add_text(page[end:])
    kernel = {"display_name": "Python 3", "language": "python", "name": "python3"}
    return {"cells": cells, "metadata": {"kernelspec": kernel}, "nbformat": 4, "nbformat_minor": 5}


def text_of(page: Path) -> str:
    """The notebook of a page as the text of its file."""
    made = notebook(page.read_text(encoding="utf-8"))
    return json.dumps(made, indent=1, ensure_ascii=False, sort_keys=True) + "\n"


if __name__ == "__main__":
    for name in sys.argv[1:]:
        file = Path(name)
        file.with_suffix(".ipynb").write_text(text_of(file), encoding="utf-8")
