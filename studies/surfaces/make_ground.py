"""Write ground.nc, the surface of studies/measured.yaml.

It is made up, not measured: random heights with a lay along y as grinding leaves them, tilted, and
with points that a profilometer would have missed. The file has the format that SurfaceTopography
writes as netCDF.
"""

from pathlib import Path

import netCDF4
import numpy as np

from fretwear.mechanics.surfaces.roughness import SelfAffineRoughness

SIZE, POINTS = 512e-6, 256

rough = SelfAffineRoughness("0.08 um", 0.7, "50 um", "10 um", 3, 0.25)
at = (np.arange(POINTS) + 0.5) * SIZE / POINTS
heights = rough.height(at[:, None], at[None, :]) + 2e-3 * at[:, None] - 1e-3 * at[None, :]
heights[np.random.default_rng(1).random(heights.shape) < 0.004] = np.nan

with netCDF4.Dataset(Path(__file__).with_name("ground.nc"), "w", format="NETCDF3_CLASSIC") as file:
    for name in ("x", "y"):
        file.createDimension(name, POINTS)
        along = file.createVariable(name, "f4", (name,))
        along[:] = at * 1e6
        along.setncatts({"length": SIZE * 1e6, "unit": "um"})
    values = file.createVariable("heights", "f4", ("x", "y"))
    values[:] = np.nan_to_num(heights * 1e6)
    values.unit = "um"
    mask = file.createVariable("mask", "i1", ("x", "y"))
    mask[:] = np.isnan(heights)
