"""Profiles of several cases.

One panel per case, with one legend for the cycles.
"""

import xarray as xr

import fretwear

summary = xr.open_dataset("results/gallery/summary.nc").sel(normal_load=40, plastic_limit=4.5e9)
cases = {
    title: f"results/gallery/cases/{summary['case_id'].sel(roughness_amplitude=value).item()}.nc"
    for title, value in {"smooth": 0, "rough": 2e-7}.items()
}
figure = fretwear.figures.field_profiles(
    {title: fretwear.open_case(file) for title, file in cases.items()}, "pressure"
)
