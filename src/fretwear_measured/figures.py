"""Pictures of measured surfaces."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import numpy as np
from matplotlib.artist import Artist
from matplotlib.colors import Normalize
from matplotlib.figure import Figure
from matplotlib.patches import Circle, Patch

from fretwear.figures.axes import add_key, add_scale
from fretwear.figures.colours import CATEGORICAL
from fretwear.figures.style import MUTED, one_panel, styled
from fretwear.study.reading import load_study
from fretwear.units import MICROMETRE, readable_unit
from fretwear_measured.files import find_spikes
from fretwear_measured.surfaces import MeasuredRoughness


def surfaces_of_study(file: Path) -> Iterator[tuple[str, Figure]]:
    """Draw the measured surfaces of a study, each once: name of its file, figure."""
    seen = set()
    for case in load_study(file).cases().values() if file.suffix in (".yaml", ".yml") else ():
        for surface in (case.roughness, case.counterface):
            if isinstance(surface, MeasuredRoughness) and surface not in seen:
                seen.add(surface)
                yield surface.slug, measured_map(surface, case.hertz_radius)


@styled
def measured_map(roughness: MeasuredRoughness, contact_radius: float) -> Figure:
    """Draw the heights of a measured surface as they are used, around the centre of the contact.

    Points that were not measured are white, and crosses mark spikes. The circle has the radius of
    the unworn contact of smooth bodies, in m.
    """
    surface = roughness.surface()
    heights = np.where(surface.measured, surface.heights, np.nan)
    heights = heights if roughness.body == "flat" else heights[::-1]
    low, high = np.nanpercentile(heights, (0.5, 99.5))
    unit = readable_unit([low, high], "m")
    figure, axes = one_panel(1, 80.0, None)
    half_x, half_y = (MICROMETRE.of(0.5 * side) for side in surface.sides)
    image = axes.imshow(
        unit.of(heights).T,
        "cividis",
        Normalize(unit.of(low), unit.of(high)),
        origin="lower",
        extent=(-half_x, half_x, -half_y, half_y),
    )
    circle = Circle(
        (0.0, 0.0), MICROMETRE.of(contact_radius), fill=False, ec=CATEGORICAL[0], lw=1.2
    )
    keys: list[Artist] = [axes.add_patch(circle)]
    names = ["contact of smooth bodies"]
    spikes = find_spikes(surface.heights, surface.measured)
    if count := int(spikes.sum()):
        x, y = (
            MICROMETRE.of(centres[n])
            for centres, n in zip((surface.x, surface.y), np.nonzero(spikes), strict=True)
        )
        x = x if roughness.body == "flat" else -x
        keys += axes.plot(x, y, "x", ms=3, color=CATEGORICAL[1])
        names.append(f"spikes: {count}")
    if missing := int(surface.missing):
        keys.append(Patch(fc="white", ec=MUTED, lw=0.5))
        names.append(f"not measured: {missing} of {surface.measured.size} points")
    axes.set(xlabel="x (µm), direction of slip", ylabel="y (µm)")
    add_scale(figure, [axes], image, f"Height ({unit.name})")
    add_key(figure, keys, names)
    return figure
