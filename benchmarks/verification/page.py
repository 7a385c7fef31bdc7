"""The page: a summary of all checks, then one section after the other."""

import re
from pathlib import Path

from benchmarks.verification import (
    closed_forms,
    convergence,
    explicit,
    limiting_state,
    peak,
    peers,
    rings,
    tangential,
)
from benchmarks.verification.section import Section
from benchmarks.verification.store import Store
from benchmarks.verification.tables import bound, percent, table

from fretwear.figures import save_figure

PARTS = (closed_forms, limiting_state, rings, tangential, explicit, convergence, peak, peers)
SECTIONS: tuple[Section, ...] = tuple(part.SECTION for part in PARTS)
IMAGES = Path("images") / "verification"

INTRODUCTION = """\
# Verification

Every number on this page is measured by one command,

```
python -m benchmarks.verification
```

from the repository's root, with the package installed together with its extras `test` and `bench`.
It takes about {minutes} minutes of one core, keeps what it found in `verification.json` beside this
page, and writes the page and its figures from that file. `--render` only writes the page; names of
sections ({names})
run just those. The page is generated: edit the sections in `benchmarks/verification/`, not this
file.

Unless a section says otherwise the contact is that of the study: a steel sphere on a steel flat,
R = 10 mm (our choice: the study gives no radius), P = 50 N, µ = 0.5, E = 208 GPa, ν = 0.3,
K_w = 7e-13 / Pa; Hertz radius a = 148.6 µm, pressure p0 = 1081 MPa; X = Q/µP is the load ratio,
κ = E*/G*, and τ = 4 K_w µ κ p0 N the number of cycles without dimension (30000 cycles are
τ = 55.1). Spacings are given as fractions of a. "Capped" is elastic–perfectly plastic with
p ≤ 4500 MPa = 4.16 p0. Deviations are signed: computed over reference, minus one.

## Summary

A check *falls short* when its largest deviation is above the bound; its section says why.

{summary}
"""


def render(store: Store) -> str:
    """The page in Markdown."""
    rows, parts, seconds = [], [], 0
    for section in SECTIONS:
        entry = store.entry(section)
        if entry is None:
            continue
        seconds += entry["seconds"]
        for check in section.checks(entry["data"]):
            verdict = "holds" if check.holds else "**falls short**"
            link = f"[{section.title}](#{_anchor(section.title)})"
            rows.append([link, check.what, bound(check.required), percent(check.measured), verdict])
        body = re.sub(
            r"\{figure:(\w+)\}",
            lambda match: f"![{section.title}]({_image(section, match[1]).as_posix()}.svg)",  # noqa: B023
            section.text(entry["data"]),
        )
        versions = ", ".join(f"{name} {number}" for name, number in entry["versions"].items())
        parts.append(
            f"## {section.title}\n\n{body}\n*{entry['seconds']} s of one core; {versions}*\n"
        )
    summary = table(["section", "check", "allowed", "measured", "verdict"], rows)
    names = ", ".join(f"`{section.name}`" for section in SECTIONS)
    head = INTRODUCTION.format(minutes=-(-seconds // 60), names=names, summary=summary)
    return "\n".join([head, *parts])


def write(docs: Path, store: Store) -> None:
    """Write the page and its figures to a folder."""
    for section in SECTIONS:
        entry = store.entry(section)
        if entry is not None:
            for name, figure in section.figures(entry["data"]).items():
                stem = docs / _image(section, name)
                stem.parent.mkdir(parents=True, exist_ok=True)
                save_figure(figure, stem, ("svg",))
    (docs / "verification.md").write_text(render(store), encoding="utf-8")


def check(docs: Path, store: Store) -> int:
    """Exit status: 0 where the page in a folder is what its data say, else 1."""
    page = docs / "verification.md"
    if page.exists() and page.read_text(encoding="utf-8") == render(store):
        return 0
    print(f"{page} is not what its data say: python -m benchmarks.verification --render")
    return 1


def _image(section: Section, name: str) -> Path:
    return IMAGES / f"{section.name}_{name}"


def _anchor(title: str) -> str:
    return re.sub(r"[^\w\- ]", "", title.lower()).replace(" ", "-")
