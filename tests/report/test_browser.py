"""A real browser opens the report from disk: it works by mouse and keyboard, on any screen."""

from pathlib import Path

import numpy as np
import pytest
import xarray as xr
from selenium.webdriver.common.keys import Keys

from fretwear.data.files import open_case
from fretwear.figures.index import INDEX_NAME
from fretwear.report import build_report
from fretwear.study.plan import Plan
from fretwear.study.reading import load_study

from ..studies import run_study, write_study
from .browser import CONTRASTS, DESKTOP, MISSING, Browser

pytestmark = [pytest.mark.slow, pytest.mark.skipif(bool(MISSING), reason=MISSING or "never")]

CASE = {
    "normal_load": "40 N",
    "coefficient_of_friction": "0.4",
    "roughness_amplitude": "0.3 µm",
    "plastic_limit": "elastic",
}
LAST = 4
WHITE = "rgb(255, 255, 255)"


@pytest.fixture(scope="module")
def browser(tmp_path_factory):
    opened = Browser(tmp_path_factory.mktemp("browser"))
    yield opened
    opened.close()


@pytest.fixture(scope="module")
def file(page, tmp_path_factory):
    file = tmp_path_factory.mktemp("page") / "report.html"
    file.write_text(page, encoding="utf-8")
    return file


@pytest.fixture
def opened(browser, file):
    browser.open(file)
    return browser


@pytest.mark.slow
def test_it_opens_without_errors_asks_for_nothing_and_runs_no_other_script(opened, file):
    assert opened.requests() == [file.as_uri()]
    assert opened.errors() == []
    assert opened.find("#explorer-body").is_displayed()
    assert not opened.find("#explorer-status").is_displayed()
    opened.ask(
        "const script = document.createElement('script'); script.textContent = 'window.evil = 1';"
        "document.body.append(script);"
        "document.body.insertAdjacentHTML('beforeend', '<img src=x: onerror=\"window.evil = 2\">')"
    )
    assert opened.ask("return typeof window.evil") == "undefined"
    sent = opened.driver.execute_async_script(
        "const done = arguments[0];fetch('data:,x').then(() => done('sent'), () => done('refused'))"
    )
    assert sent == "refused"


def test_the_slider_shows_profiles_and_zones_of_its_cycle(opened, finished):
    opened.choose("a", **CASE)
    points = {tuple(point.labels.values()): point.id for point in finished.plan.points}
    case_id = points["40 N", "0.4", "0.3 um", "none"]
    with open_case(finished.cases / f"{case_id}.nc") as case:
        stored = case.isel(y=0).load()
    mark, marks = "return document.getElementById('history-plot').layout.shapes[0].x0", []
    for place, cycle in enumerate([0, 1, 10, 100, 1000]):
        opened.move(place)
        marks.append(opened.ask(mark))
        assert opened.find("#cycle-shown").text == str(cycle)
        now = stored.sel(cycle=cycle)
        for name in ("pressure", "shear_traction"):
            shown = opened.curve(f"a {name}")
            expected = 1e-6 * now[name].values[: shown.size]
            assert shown == pytest.approx(expected, abs=1e-4 * float(np.ptp(expected)))
        for name, state in (("stick", 2), ("slip", 1)):
            expected = 1e6 * float(stored["cell_x"]) * (now["contact_state"].values == state).sum()
            assert opened.curve(f"a {name}", along="x").sum() == pytest.approx(expected)
    assert marks == sorted(set(marks))
    widths = {"a contact_half_width_x", "a stick_half_width_x"}
    assert widths <= opened.curves("history-plot")
    assert np.all(np.diff(opened.curve("a wear_volume", "history-plot")) >= 0.0)


def test_profiles_along_y_are_those_of_the_file_and_have_an_address(opened, finished):
    opened.choose("a", **CASE)
    opened.move(4)
    opened.find("#along [value=y]").click()
    points = {tuple(point.labels.values()): point.id for point in finished.plan.points}
    with open_case(finished.cases / f"{points['40 N', '0.4', '0.3 um', 'none']}.nc") as case:
        now = case.isel(x=0, cycle=-1).load()
    for name in ("pressure", "shear_traction"):
        shown = opened.curve(f"a {name}")
        expected = 1e-6 * now[name].values[: shown.size]
        assert shown == pytest.approx(expected, abs=1e-4 * float(np.ptp(expected)))
    stick = 1e6 * float(now["cell_y"]) * (now["contact_state"].values == 2).sum()
    assert opened.curve("a stick", along="x").sum() == pytest.approx(stick)
    address = opened.ask("return location.hash")
    assert address.endswith("&along=y")
    opened.ask("location.hash = arguments[0]; return 1", address.removesuffix("&along=y"))
    opened.wait("return document.getElementById('along').value === 'x'")


def test_two_cases_are_laid_over_each_other(opened):
    opened.choose("a", **CASE)
    assert not any(name.startswith("b ") for name in opened.curves())
    opened.find("#compare").click()
    assert {"a pressure", "b pressure", "b stick", "b slip"} <= opened.curves()
    assert {"b contact_half_width_x", "b wear_volume"} <= opened.curves("history-plot")
    assert opened.texts(".readout thead th") == ["A", "B", "B to A"]
    opened.choose("b", **CASE)
    assert opened.curve("b wear_depth") == pytest.approx(opened.curve("a wear_depth"))
    assert set(opened.texts(".readout td:last-child")) <= {"", "× 1.00", "–"}
    opened.choose("b", roughness_amplitude="smooth")
    assert not np.allclose(
        opened.curve("b wear_depth")[:40], opened.curve("a wear_depth")[:40], rtol=0.1
    )
    opened.find("#compare").click()
    assert "b pressure" not in opened.curves()


def test_a_case_without_results_says_why(opened):
    opened.choose("a", **CASE)
    opened.choose("a", plastic_limit="3000 MPa")
    status = opened.find("#explorer-status").text
    assert "is failed: it did not converge in cycle 7 <of 1000>" in status
    assert opened.curves() == set()
    opened.choose("a", normal_load="20 N", coefficient_of_friction="0.2")
    assert "is invalid: " in opened.find("#explorer-status").text
    opened.choose("a", **CASE)
    assert not opened.find("#explorer-status").is_displayed()
    assert "a pressure" in opened.curves()


def test_play_walks_through_the_cycles_and_scales_stay_unless_they_are_to_fit(opened):
    # In one script: on a busy machine the film would go on between two questions.
    begun = opened.ask(
        "const told = (where) => document.querySelector(where).textContent;"
        "document.getElementById('play').click();"
        "return [told('#play .words'), told('#cycle-shown')]"
    )
    assert begun == ["Pause", "0"]
    opened.wait("return document.getElementById('cycle').value > 0")
    opened.move(LAST - 1)
    assert opened.find("#play").text.endswith("Play")
    opened.find("#play").click()
    opened.wait("return document.getElementById('cycle').value === '4'")
    opened.wait("return document.querySelector('#play .words').textContent === 'Play'")
    opened.choose("a", **CASE)
    scale = "return document.getElementById('profile-plot').layout.yaxis4.range[0]"
    deepest = opened.ask(scale)
    opened.move(2)
    assert opened.ask(scale) == deepest
    opened.find("#own-scale").click()
    assert opened.ask(scale) < deepest


def test_the_table_sorts_by_any_column(opened):
    numbers = "#case-table tbody th"
    assert opened.texts(numbers) == [str(n) for n in range(1, 17)]
    script = (
        "return [...document.querySelectorAll('#case-table tbody tr')]"
        ".map((row) => row.cells[6].dataset.value).filter(Boolean).map(Number)"
    )
    before = opened.ask(script)
    depth = opened.find("#case-table thead th:nth-child(7) button")
    depth.click()
    values = opened.ask(script)
    assert values == sorted(before) != before
    assert len(values) == 11
    assert opened.texts("#case-table tbody tr:last-child td:nth-child(7)") == ["–"]
    depth.click()
    assert opened.find("[aria-sort=descending]").text.startswith("Maximum")
    assert opened.texts(numbers) != [str(n) for n in range(1, 17)]


def test_the_table_filters_by_value_and_text_and_its_rows_lead_to_the_explorer(opened):
    rows = "#case-table tbody th"
    opened.ask(
        "const s = document.querySelector('.filters select'); s.value = '40 N';"
        "s.dispatchEvent(new Event('input', { bubbles: true }))"
    )
    assert opened.texts(rows) == [str(n) for n in range(9, 17)]
    opened.find(".filters input").send_keys("failed")
    assert len(opened.texts(rows)) == 1
    assert opened.texts(".filters output") == ["1 of 16 shown"]
    opened.find(".filters button").click()
    opened.wait("return document.querySelector('.filters output').textContent.startsWith('16')")
    links = opened.driver.find_elements("css selector", "#case-table tbody th a")
    assert len(links) == 11
    opened.ask("arguments[0].click()", links[0])
    load = "return document.querySelector('#case-a select').selectedOptions[0].text"
    assert opened.ask(load) == "20 N"


def test_everything_can_be_done_by_keyboard_and_what_has_the_focus_is_outlined(opened):
    opened.press(Keys.TAB)
    assert opened.ask("return document.activeElement.className") == "skip"
    for _ in range(40):
        style, width, element = opened.ask(
            "const s = getComputedStyle(document.activeElement);"
            "return [s.outlineStyle, parseFloat(s.outlineWidth), document.activeElement.outerHTML]"
        )
        assert style != "none", element[:200]
        assert width >= 2.0, element[:200]
        opened.press(Keys.TAB)
    opened.ask("document.querySelector('#case-a select').focus()")
    for expected in ["SELECT"] * 4 + ["compare", "own-scale", "along", "play", "cycle"]:
        focus = "return document.activeElement.id || document.activeElement.tagName"
        assert opened.ask(focus) == expected
        opened.press(Keys.TAB)
    opened.ask("document.getElementById('compare').focus()")
    opened.press(Keys.SPACE)
    assert "b pressure" in opened.curves()
    opened.ask("document.getElementById('cycle').focus()")
    opened.press(Keys.HOME)
    assert opened.find("#cycle-shown").text == "0"
    opened.press(Keys.ARROW_RIGHT, Keys.ARROW_RIGHT)
    assert opened.find("#cycle").get_attribute("aria-valuetext") == "cycle 10"
    opened.ask("document.querySelector('#case-a select').focus()")
    opened.press(Keys.ARROW_UP)
    assert opened.ask("return document.activeElement.selectedOptions[0].text") == "20 N"
    opened.ask("document.querySelector('#case-table thead button').focus()")
    opened.press(Keys.ENTER, Keys.ENTER)
    assert opened.texts("#case-table tbody th")[0] == "16"


def test_no_screen_scrolls_sideways_and_each_begins_with_the_answer(opened):
    bottom = "return document.querySelector(arguments[0]).getBoundingClientRect().bottom"
    beyond = (
        "const found = [...document.querySelectorAll(arguments[0])];"
        "const shown = found.filter((e) => e.checkVisibility());"
        "const cut = shown.filter((e) => e.getBoundingClientRect().right > innerWidth + 1);"
        "return [shown.length, cut.map((e) => e.outerHTML.slice(0, 80))]"
    )
    opened.find("#compare").click()
    for size in ((320, 700), (390, 844), (768, 1024), (1400, 900)):
        opened.resize(size)
        opened.wait(f"return innerWidth === {size[0]}")
        details = "document.querySelectorAll('.pairs details').forEach((e) => { e.open = %s; })"
        opened.ask(f"scrollTo(0, 0); {details % 'false'}")
        # The answer and its figure on a laptop; on a phone the answer.
        if size[0] >= 390:
            assert (
                opened.ask(bottom, ".verdict img" if size[0] > 1000 else ".verdict dl") <= size[1]
            )
        # Plots follow the width of the window a moment later.
        opened.wait("const e = document.documentElement; return e.scrollWidth <= e.clientWidth")
        # Results of the case table are on the screen from a laptop on, and on a phone, where each
        # case is a list; everywhere the numbers of the effects, and figures in frames of their own.
        seen = ".answers dd, .pairs li, .paper, figcaption"
        if size[0] >= 1400 or size[0] < 700:
            seen += ", #case-table td, #case-table th"
        opened.ask(details % "true")
        count, cut = opened.ask(beyond, seen)
        assert count > 30
        assert cut == []
        # 7 points on a page 190 mm wide are 9 pixels at least; what is too wide can be moved.
        for width, share, moves in opened.ask(
            "return [...document.querySelectorAll('.paper img')].map((e) => [e.clientWidth,"
            "innerWidth < 720 && e.className ? 90 / 190 : e.style.getPropertyValue('--share'),"
            "getComputedStyle(e.closest('.paper')).overflowX])"
        ):
            assert 7 * float(width) / (190 / 25.4 * 72 * float(share)) >= 9.0
            assert moves == "auto"
        for plot in ("profile-plot", "history-plot"):
            drawn = f"document.querySelector('#{plot} .main-svg').getBoundingClientRect().right"
            opened.wait(f"return {drawn} <= document.documentElement.clientWidth + 1")


def test_every_text_can_be_read_on_what_is_behind_it_and_plots_follow_the_scheme(opened):
    opened.find("#compare").click()
    opened.ask("document.querySelectorAll('details').forEach((one) => { one.open = true; })")
    color = "return document.getElementById('profile-plot').data.at(-1).line.color"
    light = opened.ask(color)
    assert opened.ask("return getComputedStyle(document.body).backgroundColor") == WHITE
    assert opened.ask(CONTRASTS) == []
    dark = {"features": [{"name": "prefers-color-scheme", "value": "dark"}]}
    opened.driver.execute_cdp_cmd("Emulation.setEmulatedMedia", dark)
    opened.wait(f"{color} !== '{light}'")
    assert opened.ask("return getComputedStyle(document.body).backgroundColor") != WHITE
    assert opened.ask(CONTRASTS) == []


@pytest.mark.parametrize(
    ("size", "scheme"), [(DESKTOP, "light"), ((390, 844), "dark")], ids=["laptop", "phone"]
)
def test_axe_finds_nothing_that_hinders_a_keyboard_or_a_screen_reader(browser, file, size, scheme):
    axe = pytest.importorskip("axe_core_python", reason="axe-core-python is not installed")
    script = Path(axe.__file__).with_name("axe.min.js").read_text(encoding="utf-8")
    browser.open(file, size=size, prefers_color_scheme=scheme)
    browser.find("#compare").click()
    browser.ask("document.querySelectorAll('details').forEach((one) => { one.open = true; })")
    assert browser.violations(script) == []


def test_who_wants_less_motion_gets_none_and_paper_no_controls(browser, file):
    browser.open(file, prefers_reduced_motion="reduce")
    assert not browser.find("#play").is_displayed()
    browser.move(1)
    assert browser.find("#cycle-shown").text == "1"
    browser.open(file, media="print", prefers_color_scheme="dark")
    for selector in ("nav", ".filters", ".controls", ".cycle-bar"):
        assert not browser.find(selector).is_displayed()
    assert browser.ask("return getComputedStyle(document.body).backgroundColor") == WHITE
    assert browser.find("#profile-plot").is_displayed()


def test_points_of_a_zip_are_chosen_from_one_list_and_one_case_needs_no_choice(
    browser, finished, tmp_path
):
    def show(vary, **base):
        folder = tmp_path / vary[1:4]
        folder.mkdir()
        study = finished.derived(folder, vary, friction="0.4", plastic_limit="none", **base)
        (folder / "page.html").write_text(study.report(), encoding="utf-8")
        browser.open(folder / "page.html")

    show("{design: zip, load: [20 N, 40 N, 40 N], roughness.amplitude: [0 um, 0 um, 0.3 um]}")
    assert len(browser.texts("#case-a select")) == 1
    browser.choose("a", point="1: normal load 20 N, smooth")
    smooth = browser.curve("a pressure")
    browser.find("#compare").click()
    browser.choose("b", point="3: normal load 40 N, roughness amplitude 0.3 µm")
    assert browser.curve("b pressure").max() > 2 * smooth.max()
    assert browser.errors() == []
    waves = {"kind": "wavy", "amplitude": "0.3 um", "slope_x": "1.8 deg", "slope_y": "1 deg"}
    show("{load: [40 N]}", roughness=waves)
    assert browser.texts("#case-a select") == []
    assert not browser.find("#compare").is_displayed()
    assert browser.curve("a pressure").max() > 0.0
    assert browser.errors() == []


def test_every_state_has_an_address_that_brings_it_back(opened, browser, file):
    opened.choose("a", **CASE)
    opened.move(2)
    address = opened.ask("return location.hash")
    assert address.endswith("&cycle=10")
    expected = opened.curve("a pressure")
    browser.driver.get("about:blank")
    browser.driver.get(file.as_uri() + address)
    browser.wait("return document.documentElement.dataset.explorer === 'ready'")
    assert browser.find("#cycle-shown").text == "10"
    np.testing.assert_allclose(browser.curve("a pressure"), expected)


# A sphere that slides: nothing sticks, and the contact begins at a tenth of its last radius.
SLIDING = """
base:
  radius: 10 mm
  youngs_modulus: 208 GPa
  poisson_ratio: 0.3
  load: 1 N
  displacement_amplitude: 10 um
  friction: 0.5
  wear_coefficient: 3e-12 / Pa
  cell: 5 um
  tolerance: 0.1
  error_estimate: false
  cycles: 18000
"""


def test_names_of_curves_that_begin_close_together_stand_apart(browser, tmp_path):
    study = load_study(write_study(tmp_path / "sliding.yaml", SLIDING))
    summary = xr.load_dataset(run_study(study, tmp_path) / "summary.nc")
    (tmp_path / "figures").mkdir()
    (tmp_path / "figures" / INDEX_NAME).write_text("[]")
    page = tmp_path / "report.html"
    page.write_text(build_report(Plan(study), summary, tmp_path), encoding="utf-8")
    script = (
        "return [...document.querySelectorAll('#history-plot .annotation-text')]"
        ".filter((one) => one.textContent !== '//').map((one) => one.getBoundingClientRect())"
        ".map((box) => [box.left, box.right, box.top, box.bottom])"
    )
    for size in (DESKTOP, (390, 844)):
        browser.open(page, size=size)
        one, other = browser.ask(script)
        gaps = [max(one[at], other[at]) - min(one[at + 1], other[at + 1]) for at in (0, 2)]
        assert max(gaps) > 4.0  # pixels
        assert all(left > 0.0 and right < size[0] for left, right, *_ in (one, other))
