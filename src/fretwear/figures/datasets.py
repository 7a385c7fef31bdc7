"""What figures are given: found out at once, with words on what to give instead."""

from __future__ import annotations

from collections.abc import Mapping
from os import PathLike
from typing import Any

import xarray as xr


def check_dataset(dataset: Any) -> None:
    """Refuse what is no dataset.

    Raises
    ------
    TypeError
        With what was given, and how to come to a dataset from it.
    """
    if isinstance(dataset, xr.Dataset):
        return
    given = type(dataset).__name__
    if isinstance(dataset, str | PathLike):
        remedy = f"open the file first: fretwear.open_case({str(dataset)!r})"
    elif isinstance(dataset, xr.DataArray):
        remedy = "give the whole dataset, not one of its variables"
    elif isinstance(dataset, Mapping):
        remedy = "give one of its datasets; several cases are drawn by the functions compare_..."
    elif given == "Case":
        remedy = "simulate it first: fretwear.simulate(case)"
    else:
        remedy = "open_case and simulate of fretwear return such a dataset"
    raise TypeError(f"A figure is drawn from an xarray.Dataset, not from a {given}; {remedy}.")


def check_cases(cases: Any) -> None:
    """Refuse what is no mapping of titles to datasets, or an empty one.

    Raises
    ------
    TypeError
        When it is something else.
    ValueError
        When there is no case.
    """
    if not isinstance(cases, Mapping) or isinstance(cases, xr.Dataset):
        raise TypeError(
            f"Cases are given by their titles, not as a {type(cases).__name__}; "
            'for example {"smooth": first, "rough": second}.'
        )
    if not cases:
        raise ValueError("There is no case to draw.")
    for dataset in cases.values():
        check_dataset(dataset)


def missing_variable(dataset: xr.Dataset, variable: str) -> ValueError:
    """Return the error that says what a dataset without a variable is, and what to give."""
    if "step" in dataset.dims:
        reason = "it is the history of a case, which has no fields; open_case opens the case"
    elif "status" in dataset:
        reason = (
            "it is a merged study, which has profiles and no fields; open the case with open_case"
        )
    else:
        reason = f"it has {', '.join(sorted(map(str, dataset.data_vars))) or 'none at all'}"
    return ValueError(f"The dataset has no variable {variable!r}: {reason}.")
