"""``fretwear show`` and ``fretwear compare``: parameters and key results as text."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator
from contextlib import suppress
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

from fretwear.cli.common import CaseFile, aligned, argument, open_checked, say
from fretwear.units import in_unit, number_text, readable_unit, with_error

if TYPE_CHECKING:
    import xarray as xr

    from fretwear.variable import Variable

_MORE_RESULTS = (
    *("approach", "tangential_displacement", "plastic_volume"),
    *("exposed_area", "coating_left"),
    *("mean_slip_friction", "central_pressure", "peak_pressure"),
)
_COMPARED = ("plastic_volume", "central_pressure", "peak_pressure")
_MARK = "† In one cell or on one line; ± ∞: grows at the edge of a worn stick zone as cells narrow."
_SAME = 1e-12  # relative difference of equal parameters
_UNWORN = "Unworn: closed forms for smooth elastic bodies (Hertz, Cattaneo and Mindlin)."


def show(file: CaseFile) -> None:
    """Print parameters and key results of a case, beside closed forms of smooth elastic bodies."""
    with open_checked(file) as (case, history):
        for line in case_lines(case, history):
            say(line)


def compare(
    first: Annotated[Path, argument("A.nc", "Case file (netCDF).")],
    second: Annotated[Path, argument("B.nc", "Case file to compare it with.")],
) -> None:
    """Print the parameters in which two cases differ, and their key results with the ratios."""
    with open_checked(first) as (a, _), open_checked(second) as (b, _):
        for line in (f"A  {first}", f"B  {second}", "", *comparison_lines(a, b)):
            say(line)


def case_lines(case: xr.Dataset, history: xr.Dataset) -> Iterator[str]:
    """Yield parameters and results of a case as lines for people."""
    from fretwear.results import FORCES, RESULTS, SYMMETRIES, contact_frame, headlines
    from fretwear.study.unworn import unworn

    title, case_id = (case.attrs[name] for name in ("title", "case_id"))
    yield title if case_id in title else f"{title}, case {case_id}"
    yield case.attrs["source"]
    part = ("all", "half", "a quarter")[sum(SYMMETRIES[case.attrs["symmetry"]])]
    cells = " x ".join(str(case.sizes[axis]) for axis in ("x", "y") if axis in case.sizes)
    yield f"{cells} cells ({part} of the contact), {history.sizes['step'] - 1} steps"
    yield from ("", "Parameters")
    yield from aligned([_in_words(value) for value in case.coords.values() if value.ndim == 0])
    yield from ("", "Results")
    closed_forms: dict[str, float] = {}
    with suppress(TypeError, ValueError):  # a case of another version
        closed_forms = unworn(case.fretwear.case)
    forces = [name for key, names in FORCES.items() if key not in case.coords for name in names]
    rows = [("", *(f"cycle {case['cycle'].values[end]:.0f}" for end in (0, -1)), "unworn", "")]
    names = dict.fromkeys((*headlines([*map(str, case)]), *_MORE_RESULTS, *forces))
    for name in (name for name in names if name in case):
        variable, values = RESULTS[name].in_frame(contact_frame(case)), case[name].values
        errors = case.get(f"{name}_error", 0.0 * case[name]).values
        shown = [values[0], values[-1], closed_forms.get(name, math.nan)]
        rows.append((variable.marked, *_texts(shown, variable, [errors[0], errors[-1], 0.0])))
    yield from aligned(rows)
    yield from ("", *case.attrs.get("warnings", "").splitlines())
    yield from (_MARK, _UNWORN)


def comparison_lines(a: xr.Dataset, b: xr.Dataset) -> Iterator[str]:
    """Yield the lines that compare two cases, called A and B."""
    from fretwear.results import FORCES, RESULTS, headlines

    rows: list[tuple[str, ...]] = [("", "A", "B")]
    for name in _different_parameters(a, b):
        known = {i: _in_words(c.coords[name]) for i, c in enumerate((a, b)) if name in c.coords}
        words = next(iter(known.values()))[0]
        rows.append((words, *(known.get(i, ("", "–"))[1] for i in (0, 1))))
    yield "Parameters that differ" if len(rows) > 1 else "All parameters are the same."
    yield from aligned(rows[len(rows) == 1 :])
    yield from ("", "Results")
    first, second = _compared_cycles(a, b)
    rows = [("", f"A, cycle {first}", f"B, cycle {second}", "", "B/A")]
    states, coords = (a.sel(cycle=first), b.sel(cycle=second)), a.coords.keys() & b.coords.keys()
    forces = [name for key, names in FORCES.items() if key not in coords for name in names]
    for name in (*headlines([name for name in map(str, a) if name in b]), *_COMPARED, *forces):
        if name in a and name in b:
            variable = RESULTS[name].in_dataset(a)
            values, errors = (
                [float(state.get(each, 0.0)) for state in states]
                for each in (name, variable.error.name)
            )
            ratio = values[1] / values[0] if values[0] else math.nan
            text = number_text(ratio, 3) if math.isfinite(ratio) else "–"
            rows.append((variable.marked, *_texts(values, variable, errors), text))
    yield from aligned(rows)
    yield from ("", _MARK)


def _compared_cycles(a: xr.Dataset, b: xr.Dataset) -> tuple[int, int]:
    """Return the last common snapshot or, if only cycle 0 is common, the last one of each."""
    cycles = [{int(cycle) for cycle in case["cycle"].values} for case in (a, b)]
    common = max(set.intersection(*cycles), default=0)
    return (common, common) if common else (max(cycles[0]), max(cycles[1]))


def _different_parameters(a: xr.Dataset, b: xr.Dataset) -> Iterator[str]:
    """Yield the parameters of two cases that differ beyond rounding, in the order of the first."""
    pair = [{str(n): v.item() for n, v in case.coords.items() if not v.dims} for case in (a, b)]
    for name in {**pair[0], **pair[1]}:
        first, second = (parameters.get(name) for parameters in pair)
        if isinstance(first, float) and isinstance(second, float):
            first = second if math.isclose(first, second, rel_tol=_SAME) else first
        if first != second:
            yield name


def _in_words(parameter: xr.DataArray) -> tuple[str, str]:
    """Return the words of a parameter of a case and its value as text."""
    from fretwear.study.parameters import value_text

    name, value = str(parameter.name), in_unit(parameter.item(), parameter.attrs.get("units", ""))
    return parameter.attrs.get("long_name", name), value_text(name, value)


def _texts(values: Iterable[float], variable: Variable, errors: Iterable[float]) -> list[str]:
    """Return values of a result with their errors as text in one readable unit, then the unit."""
    # A ratio has the unit, or none, that it has elsewhere.
    unit = variable.unit if variable.si_unit == "1" else None
    unit = unit or readable_unit([*values], variable.si_unit)
    pairs = zip(values, errors, strict=True)
    return [*(with_error(unit.of(value), unit.of(error), 4) for value, error in pairs), unit.name]
