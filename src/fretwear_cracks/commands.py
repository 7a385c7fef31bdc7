"""The commands ``fretwear stress`` and ``fretwear fatigue``."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from fretwear.cli.common import (
    CaseFile,
    CommandError,
    add_command,
    aligned,
    check_output,
    open_checked,
    option,
    say,
)
from fretwear.units import cycle_text

if TYPE_CHECKING:
    import xarray as xr

_DEPTH = "Depth with its unit, such as '20 um', or several with commas."
_DEPTHS = "16 from 0.05 to 2 contact half-widths"
_FATEMI = "Constants of the Fatemi-Socie parameter, such as '1, 1000 MPa'."
_CROSSLAND = "Weight of the mean stress in the Crossland parameter."
_BASQUIN = "Fatigue strength and its exponent, such as '1000 MPa, -0.1'."
_MANSON = "Fatigue ductility and its exponent, such as '0.5, -0.6'."
_MEAN = "Mean of the bulk stress along x."
_RATIO = "Ratio R of the least bulk stress to the largest, instead of its mean."
_TABLE = (
    "tension: along x, of the surface at the edge of contact; damage: Miner's sum; –: not known"
)

MeanStress = Annotated[str, option("--mean-stress", "STRESS", _MEAN)]
StressRatio = Annotated[float | None, option("--stress-ratio", "R", _RATIO, "-1")]


def stress_below(
    file: CaseFile,
    output: Annotated[
        Path | None, option("-o/--output", "STRESS.nc", "File to write.", "OUT-stress.nc")
    ] = None,
    cycle: Annotated[
        float | None, option("--cycle", "NUMBER", "Snapshot of the case.", "the last")
    ] = None,
    depth: Annotated[str | None, option("--depth", "DEPTH", _DEPTH, _DEPTHS)] = None,
    fatemi_socie: Annotated[str | None, option("--fatemi-socie", "K,STRENGTH", _FATEMI)] = None,
    crossland: Annotated[float | None, option("--crossland", "ALPHA", _CROSSLAND)] = None,
    mean_stress: MeanStress = "0 MPa",
    stress_ratio: StressRatio = None,
) -> None:
    """Compute stresses in the flat over one cycle, and parameters for cracks, on the plane y = 0.

    Prints the largest value of each with its place.
    """
    from fretwear_cracks.stresses import largest_values, stress

    def compute(case: xr.Dataset) -> xr.Dataset:
        return stress(
            case,
            case["cycle"].values[-1] if cycle is None else cycle,
            depths=None if depth is None else depth.split(","),
            fatemi_socie=fatemi_socie,
            crossland=crossland,
            mean_stress=mean_stress,
            stress_ratio=stress_ratio,
        )

    path, stresses = _written(file, output, "stress", compute)
    say(f"Largest values at cycle {cycle_text(stresses['cycle'].item())}, in the flat")
    for line in (*aligned([*largest_values(stresses)], str.ljust), str(path)):
        say(line)


def fatigue_of(
    file: CaseFile,
    output: Annotated[
        Path | None, option("-o/--output", "FATIGUE.nc", "File to write.", "OUT-fatigue.nc")
    ] = None,
    basquin: Annotated[str | None, option("--basquin", "STRENGTH,B", _BASQUIN)] = None,
    manson_coffin: Annotated[str | None, option("--manson-coffin", "DUCTILITY,C", _MANSON)] = None,
    depth: Annotated[
        str | None, option("--depth", "DEPTH", "Largest depth.", "2 contact half-widths")
    ] = None,
    mean_stress: MeanStress = "0 MPa",
    stress_ratio: StressRatio = None,
) -> None:
    """Report where a crack is expected at each snapshot, and whether wear or the crack comes first.

    Prints the largest Smith-Watson-Topper parameter with its place and plane. With the fatigue
    constants of a material it also prints lives, and Miner's sum at points that
    wear uncovers and removes.
    """
    from fretwear_cracks import fatigue

    compute = partial(
        fatigue.fatigue,
        depth=depth,
        basquin=basquin,
        manson_coffin=manson_coffin,
        mean_stress=mean_stress,
        stress_ratio=stress_ratio,
    )
    path, lives = _written(file, output, "fatigue", compute)
    for line in (*aligned(fatigue.fatigue_table(lives)), _TABLE, str(path)):
        say(line)


def _written(
    file: Path, output: Path | None, ending: str, compute: Callable[[xr.Dataset], xr.Dataset]
) -> tuple[Path, xr.Dataset]:
    """Compute results of a case, print their warnings, and write them to `output`.

    The file is named as the case with `ending` where there is no `output`.
    """
    from fretwear.data.files import write_groups
    from fretwear_cracks import StressError

    with open_checked(file) as (case, _):
        # A loop over the files in cases/ must meet cases alone.
        beside = file.parent.parent if file.parent.name == "cases" else file.parent
        path = check_output(output or beside / f"{file.stem}-{ending}.nc", ".nc")
        try:
            computed = compute(case)
        except StressError as error:
            raise CommandError(f"{file}: {error}") from error
        write_groups(path, {"": computed})
    for warning in computed.attrs["warnings"].splitlines():
        typer.echo(f"fretwear: warning: {warning}", err=True)
    return path, computed


app = typer.Typer()
add_command(app, stress_below, "fretwear stress results/demo/cases/ID.nc -o stress.nc")
add_command(app, fatigue_of, "fretwear fatigue results/demo/cases/ID.nc")
