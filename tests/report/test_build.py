"""The report is one sound page that loads nothing, escapes what users wrote and has the numbers."""

import json
import re
import shutil
from html.parser import HTMLParser

import numpy as np
import pytest
from markupsafe import Markup

from fretwear.data.atomic import DataFileError
from fretwear.data.effects import Points, effects_table, final_results, key_results
from fretwear.report import Section, answer_text, build_report

from ..studies import near

VOID = {"meta", "img"}
KEYS = [
    *("result", "parameter", "from", "to", "where", "pairs", "lowest_factor", "highest_factor"),
    *("undefined", "appears", "vanishes"),
]


class Page(HTMLParser):
    """Elements of a page; fails where one is closed that is not open."""

    def __init__(self, text):
        super().__init__(convert_charrefs=True)
        self.open, self.elements, self.words, self.scripts = [], [], [], []
        self.feed(text)
        self.close()
        assert not self.open

    def handle_starttag(self, tag, attrs):
        self.elements.append((tag, dict(attrs)))
        self.open += [tag] * (tag not in VOID)

    def handle_endtag(self, tag):
        assert self.open.pop() == tag

    def handle_data(self, data):
        if "script" in self.open:
            self.scripts.append(data)
        elif "style" not in self.open:
            self.words.append(data)

    @property
    def text(self):
        return " ".join(" ".join(self.words).split())


@pytest.fixture(scope="module")
def parsed(page):
    return Page(page)


def test_every_element_is_closed_ids_are_unique_and_nothing_is_loaded(parsed):
    ids = [attrs["id"] for _, attrs in parsed.elements if "id" in attrs]
    assert len(ids) == len(set(ids)) >= 5
    for _, attrs in parsed.elements:
        for name in ("src", "href", "action", "data", "srcset", "poster"):
            value = attrs.get(name) or "data:image/"
            assert value.startswith("data:image/") or value[1:] in ids
    policy = next(attrs["content"] for _, attrs in parsed.elements if attrs.get("http-equiv"))
    assert policy.startswith("default-src 'none'")


def test_what_users_wrote_is_escaped(page, parsed):
    assert "<b>friction</b>" not in page
    assert "<script>alert" not in page
    assert "Loads & <b>friction</b>" in parsed.text
    assert "</code><script>alert(1)</script>" in parsed.text
    assert "it did not converge in cycle 7 <of 300>" in parsed.text


@pytest.mark.slow
def test_the_matrix_and_answer_have_the_factors_of_the_table_of_effects(page, finished):
    table = effects_table(Points.of(finished.summary))
    claims = json.loads(answer_text(table))
    assert len(claims) == len(table)
    assert all(list(claim) == KEYS for claim in claims)
    assert {claim["to"] for claim in claims if claim["parameter"] == "plastic_limit"} == {"none"}
    row = table[(table["result"] == "wear_volume") & (table["parameter"] == "friction")].iloc[0]
    low, high = (
        final_results(finished.summary.sel(friction=friction))["wear_volume"]
        for friction in (0.2, 0.4)
    )
    factors = (high / low)[np.isfinite(high / low)]
    assert row["pairs"] == factors.size
    assert (row["lowest_factor"], row["highest_factor"]) == (
        near(factors.min()),
        near(factors.max()),
    )
    cell = re.search(r'data-curve="wear_volume/friction"[^>]*>([^<]*)<', page)[1].strip()
    assert float(cell.removeprefix("×")) == pytest.approx(np.exp(np.log(factors).mean()), abs=0.005)


def test_every_point_has_a_row_of_values_with_errors_in_the_same_unit(finished):
    table, final = key_results(finished.summary), final_results(finished.summary)
    assert len(table) == 8
    assert list(table["Status"]).count("invalid") == 2
    assert list(table["Status"]).count("failed") == 1
    place = list(table["Status"]).index("done")
    value, error = (final[name].ravel()[place] for name in ("wear_volume", "wear_volume_error"))
    (name,) = (name for name in table if name.startswith("Wear volume"))
    unit = {"µm³": 1e-18, "mm³": 1e-9}[name.split("(")[1].rstrip(")")]
    shown = [float(part) for part in table[name][place].split(" ± ")]
    assert shown[0] * unit == pytest.approx(value, abs=error)
    assert shown[1] * unit == pytest.approx(error, rel=0.5)
    assert list(table["Case"])[place] in finished.plan.study.cases()


def test_the_first_screen_says_what_is_less_accurate_in_which_case_and_what_to_do(finished):
    lines = [f"Wear volume ± {n} % in {n} N: raise `budget`" for n in (12, 9, 8, 7)]
    summary = finished.summary.assign_attrs(warnings="\n".join(lines))
    told = []
    page = Page(build_report(finished.plan, summary, finished.folder, tell=told.append)[0])
    head = page.text.split("Wear volume ±", 1)[0]
    assert re.search(r"largest error after the last cycle: [a-z ]+ ± [\d.]+ %", head)
    shown = [line.replace("`", "") for line in lines]  # the key is set as code
    for line in shown:
        assert line in page.text
    assert page.text.index(shown[2]) < page.text.index("1 more warning") < page.text.index(shown[3])
    assert told == [f"warning: {line}" for line in lines]


def test_areas_stand_in_the_matrix_beside_what_is_called_an_outline(parsed):
    """The outline of a rough contact grows while its area may shrink."""
    shown = [
        parsed.text.find(f"{zone} {size}")
        for size in ("outline radius", "area")
        for zone in ("Contact", "Stick")
    ]
    assert shown[0] > -1
    assert shown == sorted(shown)
    assert "Contact radius" not in parsed.text


@pytest.mark.slow
def test_packages_add_sections_with_figures(finished):
    (name, *_) = (path.stem for path in sorted((finished.folder / "figures").glob("*.svg")))
    page = finished.report(sections=[Section("more", "More", Markup("<p>Body.</p>"), (name,))])
    section = page.split('<section id="more">')[1].split("</section>")[0]
    assert "<h2>More</h2>" in section
    assert "<p>Body.</p>" in section
    assert page.count(f'id="figure-{name}"') == section.count(f'id="figure-{name}"') == 1


def test_a_study_without_results_has_a_page(finished):
    summary = finished.summary.copy(deep=True)
    summary["status"][:] = np.where(summary["status"] == 0, 1, summary["status"])
    for name in summary.data_vars:
        if "cycle" in summary[name].dims:
            summary[name] = summary[name] * np.nan
    page = Page(build_report(finished.plan, summary, finished.folder)[0])
    assert "0 of 8 cases" in page.text
    assert not any("Plotly" in script for script in page.scripts)


@pytest.mark.slow
def test_other_points_a_damaged_index_and_a_missing_figure_are_refused(finished, tmp_path):
    with pytest.raises(DataFileError, match="has other points"):
        build_report(finished.plan, finished.summary.isel(normal_load=[0]), finished.folder)
    shutil.copytree(finished.folder, tmp_path / "copy")
    index = tmp_path / "copy/figures/index.json"
    entries = index.read_bytes()
    index.write_bytes(b"")
    with pytest.raises(DataFileError, match=r"index\.json: "):
        build_report(finished.plan, finished.summary, tmp_path / "copy")
    index.write_bytes(entries)
    path = next((tmp_path / "copy/figures").glob("*.svg"))
    path.unlink()
    with pytest.raises(DataFileError, match=path.stem):
        build_report(finished.plan, finished.summary, tmp_path / "copy")


@pytest.mark.slow
def test_a_browser_draws_the_curve_of_a_cell_and_finds_no_error(page, tmp_path):
    webdriver = pytest.importorskip("selenium.webdriver")
    browser, driver = shutil.which("chromium"), shutil.which("chromedriver")
    if not (browser and driver):
        pytest.skip("needs chromium and its driver")
    (tmp_path / "report.html").write_text(page, encoding="utf-8")
    options = webdriver.ChromeOptions()
    options.binary_location = browser
    for flag in ("--headless=new", "--no-sandbox", "--disable-gpu", "--no-first-run"):
        options.add_argument(flag)
    options.add_argument(f"--user-data-dir={tmp_path / 'profile'}")
    options.set_capability("goog:loggingPrefs", {"browser": "ALL"})
    service = webdriver.ChromeService(driver)
    with webdriver.Chrome(options=options, service=service) as chrome:
        for width in (1400, 390):
            size = {"width": width, "height": 900, "deviceScaleFactor": 1, "mobile": width < 500}
            chrome.execute_cdp_cmd("Emulation.setDeviceMetricsOverride", size)
            chrome.get((tmp_path / "report.html").as_uri())
            assert chrome.execute_script("return document.documentElement.scrollWidth") <= width
        cell = '[data-curve="maximum_wear_depth/friction"]'
        chrome.execute_script(f"document.querySelector('{cell}').click()")
        drawn = chrome.execute_script("return document.querySelector('#curve').textContent")
        assert "Maximum wear depth" in drawn
        assert chrome.get_log("browser") == []
