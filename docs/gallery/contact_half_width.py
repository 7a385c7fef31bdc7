"""Width of the contact.

All cases of a study over the cycles. What the study varies makes panels, colours and line styles.
"""

import xarray as xr

import fretwear

summary = xr.open_dataset("results/gallery/summary.nc")
figure = fretwear.figures.contact_half_width(summary)
