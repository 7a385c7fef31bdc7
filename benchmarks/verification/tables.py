"""Numbers and tables in Markdown."""

import math
from collections.abc import Iterable, Sequence


def table(header: Sequence[str], rows: Iterable[Sequence[str]]) -> str:
    """A Markdown table, the first column to the left, the others to the right."""
    lines = [list(header), ["---", *["---:"] * (len(header) - 1)], *map(list, rows)]
    return "\n".join(f"| {' | '.join(cells)} |" for cells in lines)


def percent(fraction: float) -> str:
    """A signed deviation in per cent with two significant digits; tiny ones as powers of ten."""
    if fraction == 0.0:
        return "0"
    if abs(fraction) < 1e-6:
        return f"{fraction:+.1e}".replace("e-0", "e-")
    decimals = min(max(1 - math.floor(math.log10(abs(100.0 * fraction))), 0), 6)
    return f"{100.0 * fraction:+.{decimals}f} %"


def bound(fraction: float) -> str:
    """An allowed deviation."""
    return f"{100.0 * fraction:g} %" if fraction >= 1e-4 else f"{fraction:.0e}".replace("e-0", "e-")


def worst(deviations: Iterable[float]) -> float:
    """The deviation that is largest in size, with its sign."""
    return max(deviations, key=abs)
