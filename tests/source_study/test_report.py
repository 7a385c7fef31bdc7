"""The claims in the report of a study."""

import html
import re

import pytest
import xarray as xr

from fretwear.source_study.judge import CLAIMS, judge
from fretwear.source_study.section import source_sections


@pytest.fixture(scope="module")
def sections(finished):
    return {section.id: section for section in source_sections(finished.summary, finished.cases)}


def words(section):
    return html.unescape(re.sub(r"\s+", " ", re.sub(r"<[^>]+>", " ", section.body)))


def test_every_claim_is_told_with_criterion_numbers_and_verdict(sections, quartet):
    text = words(sections["claims"])
    judgements = judge(quartet)
    assert [judgement.number for judgement in judgements] == list(range(1, len(CLAIMS) + 1))
    for judgement in judgements:
        for part in (judgement.statement, judgement.criterion, judgement.sentence):
            assert part in text
        for finding in judgement.findings:
            for measurement in finding.measurements:
                assert f"{measurement.label}: {measurement.text}" in text


def test_radius_that_the_study_does_not_give_is_named(sections):
    assert "The study gives no radius of the sphere: these cases have 10 mm." in words(
        sections["claims"]
    )


def test_simpler_model_is_compared_case_by_case(sections):
    text = words(sections["slip-models"])
    assert "After 3500 cycles" in text
    assert "Wear volume" in text
    assert re.search(r"rough elastic \d+ %", text)


def test_section_is_whole_html(sections):
    for section in sections.values():
        for tag in ("table", "tbody", "tr", "td", "div", "p"):
            opened = len(re.findall(rf"<{tag}[ >]", section.body))
            assert opened == section.body.count(f"</{tag}>"), tag


def test_another_study_has_no_such_sections(finished):
    assert list(source_sections(finished.summary.assign_coords(load=40.0), finished.cases)) == []


def test_radii_are_compared_where_a_study_has_several(finished):
    one_model = finished.summary.isel(slip_model=[0])
    radii = [one_model.assign_coords(radius=radius) for radius in (0.01, 0.04)]
    summary = xr.concat(radii, "radius", data_vars="all", coords="minimal")
    (section,) = source_sections(summary, finished.cases)
    text = words(section)
    assert "R = 40 mm, jaeger" in text
    # Both radii stand for the same files here.
    assert "No claim gets another answer at another radius." in text
