"""Draw the figures of docs/paper.md from the results of studies/paper.yaml.

Run ``snakemake --cores 2 --config study=paper`` first, then ``python docs/images/paper.py``.
"""

import io
import sys
from pathlib import Path

from PIL import Image

from fretwear.data.files import open_summary
from fretwear_source_study.figures import source_figures

RESULTS = Path(sys.argv[1] if len(sys.argv) > 1 else "results/paper")
FOLDER = Path(__file__).with_suffix("")

FOLDER.mkdir(exist_ok=True)
with open_summary(RESULTS / "summary.nc") as summary:
    for drawn in source_figures(summary, RESULTS / "cases"):
        picture = io.BytesIO()
        drawn.figure.savefig(picture, dpi=120)
        small = Image.open(picture).convert("RGB").quantize(64, dither=Image.Dither.NONE)
        small.save(FOLDER / f"{drawn.name.partition('_')[0]}.png", optimize=True)
