"""Width of the contact.

All cases of a study over the cycles. Varied parameters make panels, colours and line styles.
"""

import xarray as xr

import fretwear

summary = xr.open_dataset("results/gallery/summary.nc")
figure = fretwear.figures.contact_half_width(summary)
