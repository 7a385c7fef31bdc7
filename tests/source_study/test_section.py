"""The sections on the source study in the report of a study."""

import html
import re

import pytest
import xarray as xr

from fretwear.source_study.cases import TITLES, reference_cases
from fretwear.source_study.claims import judge
from fretwear.source_study.section import excess_shear, source_sections


@pytest.fixture(scope="module")
def sections(merged):
    return {section.id: section for section in source_sections(merged.summary, merged.folder)}


@pytest.fixture(scope="module")
def simple(merged):
    _, simple = reference_cases(merged.summary, merged.folder)
    return simple.load()


def words(section):
    return html.unescape(re.sub(r"\s+", " ", re.sub(r"<[^>]+>", " ", section.body)))


def row(section, label):
    """The cells of the first row of a table that begins with a label."""
    body = re.sub(r"\s+", " ", section.body)
    _, _, rest = body.partition(f">{label}</th>")
    return re.findall(r">([^<]*)</td>", rest.partition("</tr>")[0])


def test_every_claim_is_told_with_criterion_numbers_and_a_word_for_each_model(
    sections, cases, simple
):
    text = words(sections["claims"])
    assert "as the study describes it slip that follows the worn shape" in text
    for described, following in zip(judge(simple), judge(cases), strict=True):
        claim = following.claim
        verdicts = f"{described.verdict.value} {following.verdict.value}"
        assert f"{claim.number} {claim.words} {claim.criterion} {verdicts}" in text
        for finding in [*described.findings.values(), *following.findings.values()]:
            assert finding.remark in text
            for what, number in finding.numbers.items():
                assert f"{what}: {number}" in text


def test_sections_are_whole_html_and_name_the_radius_that_the_study_does_not_give(sections):
    assert "gives no radius of the sphere: these cases have 10 mm." in words(sections["claims"])
    for section in sections.values():
        for tag in ("table", "tbody", "tr", "td", "div", "p"):
            opened = len(re.findall(rf"<{tag}[ >]", section.body))
            assert opened == section.body.count(f"</{tag}>"), tag


def test_radii_are_compared_where_a_study_has_several(merged):
    one_model = merged.summary.isel(slip_model=[0])
    radii = [one_model.assign_coords(radius=radius) for radius in (0.01, 0.04)]
    summary = xr.concat(radii, "radius", data_vars="all", coords="minimal")
    (section,) = source_sections(summary, merged.folder)
    text = words(section)
    assert "R = 40 mm, slip that follows the worn shape" in text
    # Both radii stand for the same files here.
    assert "other than those at 10 mm: there are none." in text


def test_models_agree_on_the_unworn_smooth_sphere_and_constant_slip_wears_less(
    sections, cases, simple
):
    section = sections["slip-models"]
    assert "After 3500 cycles" in words(section)
    for ratio in row(section, "Wear volume"):
        assert 0.3 < float(ratio) < 0.9
    for name in ("dissipated_energy", "stick_half_width_x", "contact_half_width_x"):
        first, other = (one[TITLES[0]].scalar(name, 0) for one in (cases, simple))
        assert other == pytest.approx(first, rel=0.02)
    for title, ratio in zip(TITLES, row(sections["slip-models"], "Plastic volume"), strict=True):
        assert (ratio == "–") == ("elastic" in title), title


def test_only_the_simple_model_loads_valleys_with_shear(sections, cases, simple):
    for case in cases.values():
        # Single precision of the stored fields.
        assert excess_shear(case, case.last) < 1e-5
    assert excess_shear(simple["rough elastic"], 0) > 0.05
    assert excess_shear(simple["smooth elastic"], 0) < 1e-3
    assert re.search(r"rough elastic \d+", words(sections["slip-models"]))
