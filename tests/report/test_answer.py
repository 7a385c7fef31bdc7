"""Every sentence of the answer holds for all pairs of cases that it speaks of."""

import re
from itertools import combinations

import numpy as np
import pytest
import xarray as xr
from scipy.stats import qmc

from fretwear.data.effects import Points
from fretwear.report.answer import Claim, answers, companions
from fretwear.report.results import Level, PointResult, over_seeds
from fretwear.vocabulary import HEADLINES, PointStatus

from ..studies import sampled


def table(summary):
    varied = list(map(str, summary["status"].dims))
    frame = summary["status"].to_dataframe()
    for name in HEADLINES:
        frame[name] = summary[name].isel(cycle=-1).to_series()
    return frame[frame["status"] == 0].reset_index(), varied


def pairs(frame, varied, parameter, result):
    """Yield every two points that differ in one parameter: their values, what is held, factor."""
    rows = frame.to_dict("records")
    for one, other in combinations(rows, 2):
        if [n for n in varied if one[n] != other[n]] == [parameter]:
            low, high = sorted((one, other), key=lambda row: row[parameter])
            held = {name: low[name] for name in varied if name != parameter}
            if low[result] > 0.0 and high[result] > 0.0:
                yield low[parameter], high[parameter], held, high[result] / low[result]


def check(claim, factors):
    """Compare what a claim says with the factors of its pairs, recomputed."""
    assert sorted(claim.factors) == pytest.approx(sorted(factors), rel=1e-6)
    rising, falling = min(factors, default=1.0) > 0.999, max(factors, default=1.0) < 1.001
    if "stays the same" in claim.text:
        assert np.abs(np.array(factors) - 1.0).max() <= 5e-3
    elif claim.text.startswith("grows") and " and falls" not in claim.text:
        assert rising
    elif claim.text.startswith("falls"):
        assert falling
    told_of = {1: "" if claim.where else "in the one pair", 2: "in both pairs"}
    if " and falls" not in claim.text:
        assert told_of.get(len(factors), f"in all {len(factors)} pairs") in claim.text


def check_answer(answer, frame, varied):
    sizes = {}
    for finding in answer.findings:
        effect = finding.effect
        name, levels = effect.parameter, effect.points.levels[effect.parameter]
        known = list(pairs(frame, varied, name, answer.name))
        covered = 0
        for claim in (*finding.claims, Claim.whole(effect)):
            ends = levels[claim.low], levels[claim.high]
            scope = [each for each in known if each[:2] == ends]
            if claim.where:
                divider = effect.divider
                level = effect.points.place(divider)[effect.low[claim.pairs][0]]
                value = effect.points.levels[divider][level]
                scope = [each for each in scope if each[2][divider] == value]
            check(claim, [factor for *_, factor in scope])
            covered += len(scope)
        if len(finding.claims) > 1 or len(levels) == 2:
            # Claims share out the pairs; the claim about all of them has each once more.
            neighbours = {(levels[i], levels[i + 1]) for i in range(len(levels) - 1)}
            ends = {(levels[c.low], levels[c.high]) for c in finding.claims}
            in_steps = [each for each in known if each[:2] in ends]
            all_ends = [each for each in known if each[:2] == (levels[0], levels[-1])]
            assert covered == len(in_steps) + len(all_ends)
            assert ends in ({(levels[0], levels[-1])}, neighbours)
        lines = {}
        for *_, held, factor in known:
            size = lines.setdefault(tuple(held.values()), 0.0)
            lines[tuple(held.values())] = max(size, abs(np.log(factor)))
        sizes[name] = np.mean(list(lines.values())) if lines else 0.0
    order = [finding.effect.parameter for finding in answer.findings]
    assert order == sorted(order, key=lambda name: -sizes[name])
    average = re.search(r"on average by a factor of ([\d.]+):", answer.headline)
    assert float(average[1]) == pytest.approx(np.exp(sizes[order[0]]), rel=6e-3)


def test_every_sentence_holds_for_every_pair_of_a_study_with_holes(finished):
    frame, varied = table(finished.summary)
    # Wear that has ceased leaves nothing to compare.
    found = [a for a in answers(finished.summary) if a.name != "dissipated_energy"]
    assert [answer.name for answer in found] == list(HEADLINES[:-1])
    for answer in found:
        check_answer(answer, frame, varied)


@pytest.mark.slow
def test_every_sentence_on_the_default_study_holds_for_all_pairs(coarse_demo):
    summary = xr.load_dataset(coarse_demo / "results/demo/summary.nc")
    frame, varied = table(summary)
    for answer in answers(summary):
        assert {finding.effect.parameter for finding in answer.findings} == set(varied)
        check_answer(answer, frame, varied)
    together = companions(Points.of(summary))
    assert "tangential load amplitude is not held" in together
    assert together.count("by a factor of 2.00 with the ") == 2


def made_up(values, volumes):
    """Return a merged study with these final wear volumes over a grid."""
    dims, shape = list(values), volumes.shape
    return xr.Dataset(
        {
            "status": (dims, np.zeros(shape, dtype="int8")),
            "wear_volume": ((*dims, "cycle"), np.stack([0 * volumes, volumes], axis=-1)),
        },
        {
            **values,
            "cycle": [0.0, 10.0],
            "case_id": (dims, np.arange(volumes.size).astype(str).reshape(shape)),
        },
    )


def test_what_rises_and_falls_again_is_told_step_by_step():
    limits = [3e9, 4.5e9, np.inf]
    volumes = np.array([[1.0, 0.87, 4.0], [1.0, 0.88, 4.2]]).T
    (answer,) = answers(made_up({"plastic_limit": limits, "friction": [0.3, 0.6]}, volumes))
    hardness = next(f for f in answer.findings if f.effect.parameter == "plastic_limit")
    assert (
        "from 3000\u00a0MPa to 4500\u00a0MPa it falls by 12 to 13\u00a0% in both" in hardness.text
    )
    assert "from 4500\u00a0MPa to elastic it grows by a factor of 4.60 to 4.77" in hardness.text
    assert answer.headline.endswith(
        "from 3000\u00a0MPa to elastic it grows by a factor of 4.00 to 4.20 in both pairs, "
        "though not in every step."
    )


@pytest.mark.parametrize("levels", [9, 301])
def test_a_change_of_many_small_steps_is_told_as_a_whole(levels):
    wobbling = 0.002 * (-1.0) ** np.arange(levels)
    volumes = np.exp(np.linspace(0.0, 0.03, levels) + wobbling)
    (answer,) = answers(made_up({"load": np.linspace(20.0, 30.0, levels)}, volumes))
    told = "from 20\u00a0N to 30\u00a0N it grows by 3.0"
    assert told in answer.headline
    assert told in answer.findings[0].text


def test_a_parameter_that_acts_both_ways_is_told_where_it_does_which():
    volumes = np.array([[1.0, 0.9], [3.0, 6.5]])
    study = made_up({"plastic_limit": [4.5e9, np.inf], "roughness_amplitude": [0.0, 2e-7]}, volumes)
    (answer,) = answers(study)
    finding = next(f for f in answer.findings if f.effect.parameter == "roughness_amplitude")
    assert finding.text == (
        "from smooth to 0.2\u00a0µm it falls by 10\u00a0% where the plastic limit is 4500 MPa and "
        "grows by a factor of 2.17 where elastic"
    )


def test_what_goes_both_ways_without_a_reason_is_counted():
    volumes = np.array([[1.0, 1.0, 1.0], [1.5, 1.25, 0.75]])
    (answer,) = answers(made_up({"load": [20.0, 30.0], "friction": [0.2, 0.4, 0.6]}, volumes))
    load = next(f for f in answer.findings if f.effect.parameter == "load")
    assert Claim.whole(load.effect).text == (
        "grows by 25 to 50\u00a0% in 2 and falls by 25\u00a0% in 1 of 3 pairs"
    )


def test_one_case_what_nothing_changes_and_what_the_intervals_do_not_tell_apart_are_said_to_be_so():
    (alone,) = answers(made_up({"load": [20.0]}, np.array([1.0])))
    assert alone.headline == ""
    (same,) = answers(made_up({"load": [20.0, 30.0]}, np.array([1.0, 1.0])))
    assert same.headline == "The normal load does not change it by more than 0.5\u00a0%."


def test_a_result_that_vanishes_in_some_cases_is_ranked_in_the_others_only():
    stuck = np.array([[1.0, 0.0, 0.0], [2.0, 1.5, 0.0]])
    (answer,) = answers(made_up({"load": [10.0, 20.0], "friction": [0.2, 0.4, 0.6]}, stuck))
    assert answer.headline == (
        "It vanishes in 3 of 6 cases. In the others the normal load matters most, on average by a "
        "factor of 2.00: from 10\u00a0N to 20\u00a0N it grows by a factor of 2.00 in the one pair "
        "(in 2 more it vanishes at one end)."
    )
    texts = {finding.name: finding.text for finding in answer.findings}
    assert "cannot" not in " ".join(texts.values())
    assert texts["coefficient of friction"].count("vanishes") <= 1


def test_where_one_parameter_varies_nothing_is_ranked_and_what_vanishes_is_left_out():
    study = made_up({"load": [20.0, 30.0, 40.0]}, np.array([1.0, 1.5, 2.02]))
    study["stick_half_width_x"] = 0.0 * study["wear_volume"]
    (only,) = answers(study)
    assert only.headline == (
        "With the normal load from 20\u00a0N to 40\u00a0N it grows by a factor of 2.02."
    )
    unit = qmc.Sobol(3, seed=8).random(64)
    noise = 0.05 * np.random.default_rng(9).standard_normal(64)
    (alike,) = answers(sampled(unit, 1.0 + unit[:, 0] + unit[:, 1] + 0.1 * unit[:, 2] + noise))
    assert "matter most, and their order is uncertain. Alone they explain" in alike.headline
    (apart,) = answers(sampled(unit, 1.0 + 2.0 * unit[:, 0] + unit[:, 1] + noise))
    assert apart.headline.startswith("The normal load matters most: alone it explains 79")


def test_what_a_seed_does_is_chance_and_told_by_its_deviation():
    values = np.array([1.00, 1.04, 0.97, 1.01])
    numbers = dict.fromkeys(HEADLINES, (("roughness_seed", "cycle"), values[:, None]))
    summary = xr.Dataset(
        {
            **numbers,
            "status": ("roughness_seed", np.zeros(4, int)),
            "case_id": ("roughness_seed", list("abcd")),
        },
        {"roughness_seed": [1, 2, 3, 4], "cycle": [1000]},
    )
    told = {answer.name: answer for answer in answers(summary)}["wear_volume"]
    spread = 100.0 * values.std(ddof=1) / values.mean()
    assert told.headline.endswith(f"chance, with a standard deviation of {spread:.1f}\u00a0%.")
    assert "from 1 to 4" not in told.headline


def test_means_and_deviations_are_over_the_seeds_of_each_other_combination():
    def point(load, seed, volume, status=PointStatus.DONE):
        levels = {
            "load": Level(f"{load} N", "", load),
            "roughness_seed": Level(str(seed), "", seed),
        }
        return PointResult(1, "id", status, "", levels, {"wear_volume": volume}, {}, False)

    points = [point(load, seed, load * seed) for load in (1.0, 2.0) for seed in (1, 2, 3)]
    points.append(point(1.0, 4, np.nan, PointStatus.FAILED))
    one, two = over_seeds(points)
    assert [each.levels["load"].sort_key for each in (one, two)] == [1.0, 2.0]
    assert (one.seeds, one.spread) == (3, {"wear_volume": (2.0, 1.0)})
    assert two.spread == {"wear_volume": (4.0, 2.0)}
    assert "roughness_seed" not in one.levels
    assert not over_seeds(points[:2])
