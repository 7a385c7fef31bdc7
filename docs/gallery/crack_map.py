"""Where a crack is expected.

The Smith–Watson–Topper parameter below the surface before and after wear, with the place and the
plane of the first crack: wear moves it from the edge of contact to the edge of the stick zone.
"""

import xarray as xr

import fretwear
from fretwear_cracks.figures import crack_map

summary = xr.open_dataset("results/gallery/summary.nc")
point = summary.sel(normal_load=40, roughness_amplitude=0, plastic_limit=4.5e9)
with fretwear.open_case(f"results/gallery/cases/{point['case_id'].item()}.nc") as case:
    found = fretwear.fatigue(case, cycles=[0, 7000], depth="60 um")
figure = crack_map(found)
