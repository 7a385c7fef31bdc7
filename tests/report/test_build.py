"""The report is one sound page that loads nothing, escapes what users wrote and tells all."""

import base64
import csv
import gzip
import json
import re
import shutil
import sys
from html.parser import HTMLParser
from importlib.resources import files

import numpy as np
import pytest
import xarray as xr
import yaml
from markupsafe import Markup

from fretwear.data.atomic import DataFileError
from fretwear.data.files import open_case, open_history
from fretwear.report import Section, answers, build_report
from fretwear.report.build import parameter_rows, study_text
from fretwear.report.explorer import EXPLORED_PROFILES
from fretwear.report.page import macros
from fretwear.report.results import (
    computation_facts,
    examine,
    point_results,
    residuals,
)
from fretwear.study.plan import Plan
from fretwear.study.reading import load_study
from fretwear.vocabulary import HEADLINES, RESULTS

from ..studies import base, run_study, write_study

VOID = {"meta", "link", "br", "img", "input", "hr", "mspace", "wbr", "source"}


class Page(HTMLParser):
    """Elements of a page; fails where one is closed that is not open."""

    def __init__(self, text):
        super().__init__(convert_charrefs=True)
        self.open, self.elements, self.words = [], [], []
        self.feed(text)
        self.close()
        assert not self.open

    def handle_starttag(self, tag, attrs):
        self.elements.append((tag, dict(attrs)))
        self.open += [tag] * (tag not in VOID)

    def handle_startendtag(self, tag, attrs):
        self.elements.append((tag, dict(attrs)))

    def handle_endtag(self, tag):
        assert self.open.pop() == tag

    def handle_data(self, data):
        if "script" not in self.open and "style" not in self.open:
            self.words.append(data)

    @property
    def text(self):
        return re.sub(r"\s+", " ", " ".join(self.words))

    def count(self, tag):
        return sum(name == tag for name, _ in self.elements)


@pytest.fixture(scope="module")
def parsed(page):
    return Page(page)


def test_every_element_is_closed_ids_are_unique_and_nothing_is_loaded_from_anywhere(parsed, page):
    ids = [attrs["id"] for _, attrs in parsed.elements if "id" in attrs]
    assert len(ids) == len(set(ids)) > 20
    for _, attrs in parsed.elements:
        assert set((attrs.get("aria-labelledby") or "").split()) <= set(ids)
        for name in ("src", "href", "action", "data", "srcset", "poster"):
            value = attrs.get(name) or "data:image/"
            assert value[1:] in ids or value.startswith(("data:image/", "data:text/csv", "#case="))
    outside_images = re.sub(r"data:image/[^\"]*", "", page)
    assert not re.search(r"https?://|url\(|@import", outside_images)
    policy = next(attrs["content"] for _, attrs in parsed.elements if attrs.get("http-equiv"))
    assert policy.startswith("default-src 'none'")


def test_what_users_wrote_is_escaped(page, parsed):
    assert parsed.count("b") == page.count("<b>")
    assert "<b>friction</b>" not in page
    assert "<script>alert" not in page
    assert "Loads & <b>friction</b>" in parsed.text
    assert "</code><script>alert(1)</script>" in parsed.text
    assert "it did not converge in cycle 7 <of 1000>" in parsed.text
    assert "</pre><b>cycle 7</b>" in parsed.text
    assert page.count("<script") == parsed.count("script")


def test_every_point_is_in_the_table_of_cases_with_its_numbers(page, finished):
    table = Page(page.split('id="case-table"')[1].split("<tbody>")[1].split("</tbody>")[0])
    assert table.count("tr") == len(finished.plan.points) == 16
    case_id, *others = finished.plan.study.cases()
    assert all(each in table.text for each in (case_id, *others))
    assert table.text.count("invalid") == 4
    assert table.text.count("failed") == 1
    row = next(line for line in page.split("<tr") if case_id in line and "data-value" in line)
    number = r'class="number" data-label="[^"]*" data-unit="[^"]*" data-value="([^"]+)"'
    values = [float(value) for value in re.findall(number, row)]
    with open_case(finished.cases / f"{case_id}.nc") as case:
        expected = [float(case[name][-1]) for name in HEADLINES]
    assert values == pytest.approx(expected, rel=1e-5)
    keys = re.findall(r'data-value="([^"]+)"', page)
    assert not {"inf", "nan", "None"} & set(keys)
    assert max(map(float, keys)) == sys.float_info.max
    heads = page.split('id="case-table"')[1].split("</thead>")[0]
    assert all(RESULTS[name].label in heads for name in HEADLINES)
    # What a single cell says is no key result.
    assert not {"peak_pressure", "central_pressure"} & set(HEADLINES)


def test_each_result_has_a_line_for_each_parameter_and_folds_those_below_the_third(page, finished):
    lists = [part.split("</dl>")[0] for part in page.split('<dl class="answers">')[1:]]
    cards = "".join(lists).split("<dt>")[1:]
    found = list(answers(finished.summary))
    assert len(cards) == len(found) > 4
    for card, answer in zip(cards, found, strict=True):
        assert len(answer.lines) == 4
        shown, _, folded = card.partition("<details>")
        for place, line in enumerate(answer.lines):
            assert line.text in (folded if place > 2 else shown)
            assert line.text not in (shown if place > 2 else folded)


def test_where_nothing_sticks_there_is_no_mean_stick_pressure(finished):
    summary = finished.summary.copy(deep=True)
    summary["mean_stick_pressure"] *= np.nan
    page = build_report(finished.plan, summary, finished.folder)
    shown = re.findall(r'data-label="Mean stick pressure".*?<span>(.*?)</span>', page)
    assert len(shown) == 16
    assert set(shown) == {"–"}


def test_figures_reasons_and_how_it_was_computed_are_on_the_page(parsed, finished):
    images = [attrs for tag, attrs in parsed.elements if tag == "img"]
    assert len(images) == parsed.count("figcaption") == 11
    assert all(attrs["alt"] and attrs["src"].startswith("data:image/") for attrs in images)
    assert "Points without results" in parsed.text
    assert "Q must be less than µP = 4 N" in parsed.text
    assert parsed.text.count("it did not converge in cycle 7") == 1
    done = [p for p in finished.plan.points if p.case is not None and p.id != finished.failed]
    assert f"Results exist for {len(done)} of 16 points." in parsed.text
    for words in ("Tolerance of the wear integration", "Convolutions", "fretwear 0.1"):
        assert words in parsed.text
    assert parsed.count("math") > 10
    assert "Permission is hereby granted, free of charge" in parsed.text


def test_what_makes_results_doubtful_is_a_note_below_the_answer(finished, tmp_path):
    # One of these has not been run; what is doubtful of it is known before.
    limits = "plastic_limit: [none, 200 MPa]"
    doubtful = finished.derived(
        tmp_path, f"{{load: [40 N], friction: [0.4], roughness.amplitude: [0.3 um], {limits}}}"
    )
    older = "1 of 1 case was computed by another version of the code: their code_digest is 0123"
    doubtful.summary["code_digest"][...] = "0123"
    page = Page(doubtful.report())
    assert doubtful.plan.doubts
    for doubt, cases in doubtful.plan.doubts.items():
        assert f" case{'s' * (len(cases) != 1)} the contact {doubt.what}" in page.text
        assert doubt.detail in page.text
    assert page.text.index("To be checked:") > page.text.index("Wear volume")
    assert page.text.count("computed by another version of the code") == 2
    assert older in page.text


def test_the_same_results_give_the_same_page_small_enough_to_send_and_sections_find_their_place(
    finished, page
):
    assert finished.report() == page
    assert len(page.encode()) < 10_000_000
    section = Section("claims", "Claims & verdicts", Markup("<p>one <em>claim</em></p>"))
    page = finished.report(sections=[section])
    assert '<a href="#claims">Claims &amp; verdicts</a>' in page
    order = [page.index(f'id="{name}"') for name in ("figures", "claims", "computation")]
    assert order == sorted(order)
    assert "<p>one <em>claim</em></p>" in page
    Page(page)


def test_words_labels_and_units_of_results_stand_in_the_vocabulary_alone():
    templates = files("fretwear.report") / "templates"
    scripts = "".join((templates / name).read_text() for name in ("explorer.js", "table.js"))
    written = re.sub(r"/\*.*?\*/", "", scripts, flags=re.DOTALL)
    for variable in RESULTS.values():
        assert variable.label not in written
        assert variable.words not in written or variable.words == variable.name
    assert not re.search("µm|nm|MPa|µJ", written)


def test_a_summary_of_another_study_or_of_cases_that_it_no_longer_has_is_refused(finished):
    with pytest.raises(DataFileError, match=r"'load': 1.*merge the study again"):
        build_report(finished.plan, finished.summary.isel(normal_load=[0]), finished.folder)
    other = finished.summary.copy(deep=True)
    other["case_id"] = other["case_id"].str.replace("N1000", "N2000")
    with pytest.raises(DataFileError, match=r"N2000.*'small' has.*N1000.*merge the study again"):
        build_report(finished.plan, other, finished.folder)


def test_a_heavy_vector_figure_gives_way_to_its_bitmap(finished, tmp_path):
    folder = shutil.copytree(finished.folder, tmp_path / "copy")
    heavy = folder / "figures" / "wear_volume.svg"
    heavy.write_text(heavy.read_text(encoding="utf-8") + "<!--" + "x" * 1_500_000 + "-->")
    kinds = ("data:image/png", "data:image/svg+xml")
    light, heavier = (
        [build_report(finished.plan, finished.summary, each).count(kind) for kind in kinds]
        for each in (finished.folder, folder)
    )
    assert heavier == [light[0] + 1, light[1] - 1]


def test_one_case_alone_and_a_study_without_results_have_a_report(finished, tmp_path):
    alone = "load: [40 N], friction: [0.4], roughness.amplitude: [0.3 um], plastic_limit: [none]"
    parsed = Page(finished.derived(tmp_path, f"{{{alone}}}").report())
    assert "Points without results" not in parsed.text
    assert "1 case" in parsed.text
    for silly in ("What mattered", "There are no two cases", "the case "):
        assert silly not in parsed.text.split("Explorer")[0]
    plan, summary = finished.plan, finished.summary.copy(deep=True)
    summary["status"] = summary["status"].where(summary["status"] == 2, 1)
    folder = tmp_path / "none"
    (folder / "figures").mkdir(parents=True)
    (folder / "figures/index.json").write_text("[]")
    page = build_report(plan, summary, folder)
    assert 'id="explorer"' not in page
    assert "No point of this study has results." in page
    assert len(page) < 200_000


def test_the_download_is_the_table_of_all_points_with_final_values(finished, parsed):
    (link,) = (attrs for tag, attrs in parsed.elements if tag == "a" and attrs.get("download"))
    text = base64.b64decode(str(link["href"]).partition("base64,")[2]).decode()
    rows = list(csv.DictReader(text.splitlines()))
    assert [*rows[0]][:2] == ["case_id", "status"]
    assert [*rows[0]][-1] == "code_digest"
    assert len(rows) == len(finished.plan.points)
    for row, planned in zip(rows, finished.plan.points, strict=True):
        assert row["case_id"] == planned.id
        if row["status"] != "done":
            assert row["wear_volume"] == ""
            continue
        with open_case(finished.cases / f"{planned.id}.nc") as case:
            for name in (*HEADLINES, "peak_pressure"):
                assert float(row[name]) == pytest.approx(float(case[name][-1]), rel=1e-8)
            for name in ("load", "tangential_load", "radius"):
                assert float(row[name]) == pytest.approx(float(case[name]), rel=1e-8)


def test_varied_parameters_come_first_in_units_for_people_and_random_ones_as_a_range(
    finished, tmp_path
):
    rows = parameter_rows(finished.plan)
    varied = [(row.name, row.values) for row in rows if row.choices]
    assert varied == [
        ("load", "20 N, 40 N"),
        ("friction", "0.2, 0.4"),
        ("roughness_amplitude", "smooth, 0.3 µm"),
        ("plastic_limit", "elastic, 3000 MPa"),
    ]
    values = {row.name: row.values for row in rows}
    assert values["radius"] == "10 mm"
    assert values["wear_coefficient"] == "7·10⁻¹³ Pa⁻¹"
    assert values["roughness_slope_x"] == "1.8°"
    assert values["tangential_load"] == "5 N"
    case = next(iter(finished.plan.study.cases().values()))
    numerics = {"cell_x", "cell_y", "tolerance", "slip_model", "error_estimate"}
    assert set(case.scalar_coordinates()) - set(values) == numerics
    content = yaml.safe_load(finished.plan.study.file.read_text(encoding="utf-8"))
    content["base"] |= {"friction": 0.4, "plastic_limit": "none", "roughness": "none"}
    content["vary"] = {"load": {"from": "26 N", "to": "40 N"}}
    content["design"] = {"kind": "sobol", "points": 64, "seed": 1}
    study = load_study(write_study(tmp_path / "drawn.yaml", content))
    rows = {row.name: row.values for row in parameter_rows(Plan(study))}
    low, high = rows["normal_load"].removesuffix(" (64 values)").split(" to ")
    assert 26.0 <= float(low.removesuffix(" N")) < 27.0
    assert 39.0 < float(high.removesuffix(" N")) <= 40.0


def test_numerics_and_residuals_are_those_of_the_files(finished):
    results = point_results(finished.plan, finished.summary, {})
    ids = [result.id for result in results if result.done]
    numerics = [examine(finished.cases / f"{case_id}.nc") for case_id in ids]
    facts = computation_facts(numerics, len(ids) + 1)
    steps = []
    for case_id in ids:
        with open_history(finished.cases / f"{case_id}.nc") as history:
            steps.append(history.sizes["step"] - 1)
    assert facts["Accepted steps"] == f"{min(steps)} to {max(steps)}"
    with open_case(finished.cases / f"{ids[0]}.nc") as case:
        assert facts["Simulated with"] == case.attrs["source"]
    assert facts["Grid spacing along x"] == "3.9 µm"
    assert facts["Cases examined"] == f"{len(ids)} of {len(ids) + 1}, evenly spread"
    assert xr.__version__ in facts["Report made with"]
    numerics = numerics[0]
    assert 0.0 < numerics.residuals.load < 1e-6
    assert 0.0 < numerics.residuals.tangential_load < 1e-6
    assert numerics.residuals.complementarity < 1e-4
    with open_case(finished.cases / f"{ids[0]}.nc", full=True) as whole:
        fields = {name: whole[name].values[-1] for name in EXPLORED_PROFILES}
    assert residuals(fields, numerics.numbers, copies=1).load < 1e-6
    fields["pressure"] = 1.25 * fields["pressure"]
    assert residuals(fields, numerics.numbers, copies=1).load == pytest.approx(0.25, rel=1e-5)


def test_the_study_file_is_shown_as_written_unless_it_was_changed(finished):
    study = finished.plan.study
    assert study_text(study) == study.file.read_text(encoding="utf-8")
    changed = load_study(study.file, ["tolerance=0.02"])
    text = study_text(changed)
    assert yaml.safe_load(text)["base"]["tolerance"] in (0.02, "0.02")
    assert json.dumps(yaml.safe_load(text)) == json.dumps(changed.content)


def test_the_texts_on_a_line_contact_with_debris_are_about_it(tmp_path):
    given = base(debris_fraction=0.5, load="20 N/mm", radius=None, cycles=20)
    given["indenter"] = {"kind": "cylinder", "radius": "6 mm"}
    study = load_study(write_study(tmp_path / "line.yaml", {"title": "Line", "base": given}))
    run_study(study, tmp_path)
    plan = Plan(study)
    rows = {row.name: row for row in parameter_rows(plan)}
    assert rows["hertz_radius"].words == "Hertz contact half-width"
    assert rows["tangential_load"].words == "tangential load amplitude per length"
    assert rows["tangential_load"].values == "8 N/mm"
    with open_case(next((tmp_path / "cases").glob("*.nc"))) as case:
        assert "cell_y" not in case.coords
        assert case["hertz_radius"].attrs["long_name"] == rows["hertz_radius"].words
    (tmp_path / "figures").mkdir()
    (tmp_path / "figures" / "index.json").write_text("[]", encoding="utf-8")
    with xr.open_dataset(tmp_path / "summary.nc") as summary:
        page = build_report(plan, summary, tmp_path)
    text = page[page.index("<main") :]
    for wrong in ("sphere", "Fourier", "No third body", "y = 0", "along y", "∬"):
        assert wrong not in text, wrong
    for right in ("plane strain", "Debris stays where it was worn off", "strip of half-width"):
        assert right in text
    (packed,) = re.findall(r'id="explorer-data">(.*?)<', page)
    words = json.loads(gzip.decompress(base64.b64decode(packed)))["words"]
    assert words["wear_volume"]["label"].startswith("Wear volume per length (")


@pytest.mark.parametrize(
    ("kinds", "vector", "single"),
    [
        ({"one direction"}, 0, 1),
        ({"two directions"}, 1, 0),
        ({"one direction", "two directions"}, 1, 1),
    ],
)
def test_the_report_says_how_slip_was_computed(kinds, vector, single):
    made = macros()
    told = made["computation"]({}, "study.yaml", "", {"grid", "point", *kinds})
    assert told.count("Coulomb’s law") == vector
    assert told.count("reduced load") == single
    assert made["limits"]({"point", *kinds}).count("One component of traction") == single
