"""A case as it moves.

Pressure, wear depth and contact zones, one picture for each snapshot that the case has kept: what
`fretwear animate` makes.
"""

import xarray as xr

import fretwear

summary = xr.open_dataset("results/gallery/summary.nc")
point = summary.sel(normal_load=40, roughness_amplitude=2e-7, plastic_limit=4.5e9)
file = f"results/gallery/cases/{point['case_id'].item()}.nc"
animation = fretwear.figures.animation(fretwear.open_case(file), fretwear.open_history(file))
animation.save("results/gallery/wear.gif")
figure = animation.figure
