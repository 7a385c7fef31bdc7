"""The page and its data: docs/performance.md, docs/performance.json, docs/images/performance."""

import json
import time
from pathlib import Path

from benchmarks.performance.parts import PARTS, Data, Part
from benchmarks.speed.rows import surroundings
from benchmarks.verification.store import rounded

from fretwear.figures import save_figure

IMAGES = Path("images") / "performance"

INTRODUCTION = """\
# Performance

Every number on this page is measured by one command, from the repository's root, with the package
and its extra `bench` installed:

```
python -m benchmarks.performance
```

It keeps what it found in `performance.json` beside this page, and writes the page and its figures
from that file. Parts can be measured alone ({names}); `--render` only writes the page. For a
quick look without changing the page: `python -m benchmarks.speed` (the table, a minute or two),
`python -m benchmarks.peers`, `python -m benchmarks.scale`.

**1 CE** is the time of one bare convolution by scipy.fft on the same quarter window, on one thread:
cosine transform of the rows that are not zero, then of all columns, multiplication, inverse. It is
measured in the same process, in turn with the job: around each cold solve, after each step of a
run. The time of a run in CE is the sum over its steps, each in the unit of the window that it was
made on; a window grows with the contact, so units of the last window would give a smaller number,
which is noted too. All CE are ratios of medians of processor times, which other work on the machine
disturbs less than the clock; what the clock says is noted. Rows of the transforms' share count the
processor time inside the calls of transforms, of whichever library, as medians of some runs. Start
times are the shortest of nine on the clock: what else the machine does can only add. The time per
cell at half the spacing is a ratio of means of runs that take turns. scipy's convolution is dearer
per cell where the cells along an axis are a power of two, as in the cold solves: their numbers in
CE are smaller for it. What the same solves take on 250² cells is noted beside.
"""


def load(docs: Path) -> Data:
    """What was measured so far."""
    path = docs / "performance.json"
    return json.loads(path.read_text(encoding="utf-8")) if path.exists() else {}


def measure(docs: Path, part: Part) -> None:
    """Measure a part and keep what it finds with the circumstances."""
    print(f"== {part.title}", flush=True)
    before, started = surroundings(), time.perf_counter()
    data = part.measure()
    entry = {**before, "seconds": round(time.perf_counter() - started), "data": rounded(data)}
    entries = load(docs) | {part.name: entry}
    text = json.dumps(entries, indent=1, ensure_ascii=False) + "\n"
    (docs / "performance.json").write_text(text, encoding="utf-8")


def render(entries: Data) -> str:
    """The page in Markdown."""
    names = ", ".join(f"`{part.name}`" for part in PARTS)
    parts = [INTRODUCTION.format(names=names)]
    for part in PARTS:
        if part.name not in entries:
            continue
        entry = entries[part.name]
        image = f"![{part.title}]({(IMAGES / part.name).as_posix()}.svg)"
        text = part.text(entry["data"]).replace("{figure}", image)
        versions = ", ".join(f"{name} {number}" for name, number in entry["versions"].items())
        parts.append(
            f"## {part.title}\n\n{text.rstrip()}\n\n*{entry['seconds']} s on {entry['cores']} "
            f"cores of {entry['processor']}, load average {entry['load_average']} at the start; "
            f"{versions}*\n"
        )
    return "\n".join(parts)


def write(docs: Path) -> None:
    """Write the page and its figures to a folder."""
    entries = load(docs)
    for part in PARTS:
        if part.figure is not None and part.name in entries:
            stem = docs / IMAGES / part.name
            stem.parent.mkdir(parents=True, exist_ok=True)
            save_figure(part.figure(entries[part.name]["data"]), stem, ("svg",))
    (docs / "performance.md").write_text(render(entries), encoding="utf-8")


def check(docs: Path) -> int:
    """Exit status: 0 where the page in a folder is what its data say, else 1."""
    page = docs / "performance.md"
    if page.exists() and page.read_text(encoding="utf-8") == render(load(docs)):
        return 0
    print(f"{page} is not what its data say: python -m benchmarks.performance --render")
    return 1
