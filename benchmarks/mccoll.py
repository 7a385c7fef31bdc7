"""Time of the case of McColl, Ding and Leen (2004) on one core: `python -m benchmarks.mccoll`.

The finite-element solutions with which docs/mccoll.md compares it took 16 993 and 20 573 s, on
another machine.
"""

from __future__ import annotations

import os
import time
from pathlib import Path

FINITE_ELEMENTS = (16_993.0, 20_573.0)


def main() -> None:
    """Print the worn depth of the flat and the time of the fastest of three runs."""
    os.environ["OMP_NUM_THREADS"] = "1"
    from fretwear.running.simulate import steps
    from fretwear.study.study import load_study

    file = Path(__file__).parents[1] / "studies" / "mccoll.yaml"
    (case,) = load_study(file).cases().values()
    seconds = []
    for _ in range(3):
        begun = time.process_time()
        depths = {step.state.cycle: 1e6 * step.state.wear_flat.max() for step in steps(case)}
        seconds.append(time.process_time() - begun)
    print(f"worn depth of the flat: {depths[5000]:.4f} and {depths[18000]:.4f} µm")
    print(f"processor time: {min(seconds):.2f} s, {len(depths) - 1} steps")
    ratios = " and ".join(f"{each / min(seconds):,.0f}" for each in FINITE_ELEMENTS)
    print(f"finite elements, on another machine: {ratios} times that")


if __name__ == "__main__":
    main()
