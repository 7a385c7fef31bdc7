"""Every claim judged on real runs, and on doctored ones that make it hold and fail."""

from dataclasses import replace

import numpy as np
import pytest

from fretwear.source_study.evolution import Evolution
from fretwear.source_study.quartet import Quartet
from fretwear.source_study.roughness import amplitude_left, asperities, rough_becomes_smooth
from fretwear.source_study.stick import stick_zone
from fretwear.source_study.tractions import (
    peak_at_stick_edge,
    pressure_moves_inward,
    shear_behaves_like_pressure,
)
from fretwear.source_study.verdict import Answer, Verdict
from fretwear.source_study.wear import (
    deepest_in_the_middle,
    even_wear,
    place_of_deepest,
    unevenness,
)
from fretwear.source_study.width import growth, late_growth, width_grows_faster_when_rough
from fretwear.vocabulary import ContactState


def everywhere(case: Evolution) -> Quartet:
    return Quartet(case, case, case, case)


def answer(judgement, subject):
    return next(f.answer for f in judgement.findings if f.subject == subject)


def picked(case, cycles):
    return replace(case, dataset=case.dataset.sel(cycle=cycles))


# Claim 1


def test_pressure_moves_into_the_stick_zone_of_elastic_contacts(quartet):
    judgement = pressure_moves_inward(quartet)
    assert answer(judgement, "smooth elastic") is Answer.YES
    assert answer(judgement, "rough elastic") is Answer.YES


def test_load_that_leaves_the_slip_zone_is_carried_by_the_stick_zone(quartet):
    case = quartet.smooth_elastic
    loads = []
    for cycle in (0, case.last):
        zones, pressure = case.zones(cycle), case.field("pressure", cycle)
        loads.append([pressure[zone].sum() for zone in (zones.stick, zones.slip)])
    (stick, slip), (last_stick, last_slip) = loads
    assert last_stick - stick == pytest.approx(slip - last_slip, rel=1e-3)


def test_pressure_that_moves_outward_fails_the_first_claim(quartet, doctored):
    case = quartet.smooth_elastic
    backwards = dict(zip(case.cycles, reversed(case.cycles), strict=True))
    reversed_ = doctored(case, pressure=lambda cycle: case.field("pressure", backwards[cycle]))
    # Zones of the late contact are larger: judge by one constant state.
    constant = doctored(reversed_, contact_state=lambda _cycle: case.state(case.last))
    judgement = pressure_moves_inward(everywhere(constant))
    assert judgement.verdict is Verdict.FAILS
    assert "falls in the stick zone" in judgement.sentence


# Claim 2


def test_peak_reaches_the_edge_of_stick_after_some_cycles(quartet):
    judgement = peak_at_stick_edge(quartet)
    assert judgement.verdict is Verdict.CONDITIONAL
    assert "on, not yet at cycle" in judgement.sentence


def test_peak_at_the_edge_at_every_snapshot_holds(quartet):
    late = picked(quartet.smooth_elastic, [0, 2000, 3500])
    assert peak_at_stick_edge(everywhere(late)).verdict is Verdict.HOLDS


def test_peak_that_stays_in_the_middle_fails_the_second_claim(quartet, doctored):
    first = quartet.smooth_elastic.field("pressure", 0)
    hertz = doctored(quartet.smooth_elastic, pressure=lambda _cycle: first)
    assert peak_at_stick_edge(everywhere(hertz)).verdict is Verdict.FAILS


# Claim 3


def test_equal_contacts_are_alike_and_others_are_not(quartet, doctored):
    smooth = quartet.smooth_elastic
    assert rough_becomes_smooth(everywhere(smooth)).verdict is Verdict.HOLDS
    louder = doctored(smooth, pressure=lambda cycle: 20.0 * smooth.field("pressure", cycle))
    pair = Quartet(smooth, louder, smooth, louder)
    assert rough_becomes_smooth(pair).verdict is Verdict.FAILS
    wider = doctored(smooth, slip=lambda cycle: 1.2 * smooth.field("slip", cycle))
    pair = Quartet(smooth, wider, smooth, wider)
    assert rough_becomes_smooth(pair).verdict is Verdict.FAILS


def test_differences_too_small_to_be_seen_in_a_figure_hold_with_a_condition(quartet, doctored):
    case = quartet.smooth_elastic
    smooth = doctored(case, pressure=lambda cycle: 0.01 * case.field("pressure", cycle))
    rough = doctored(smooth, pressure=lambda cycle: 1.2 * smooth.field("pressure", cycle))
    judgement = rough_becomes_smooth(Quartet(smooth, rough, smooth, rough))
    assert judgement.verdict is Verdict.CONDITIONAL
    assert "scale of a figure" in judgement.sentence


# Claim 4


def test_elastic_stick_zones_are_constant_and_a_plastic_one_shrinks(quartet):
    judgement = stick_zone(quartet)
    assert answer(judgement, "smooth elastic") is Answer.YES
    assert answer(judgement, "rough elastic") is Answer.YES
    assert answer(judgement, "smooth plastic") is Answer.YES


def test_a_single_changed_cell_fails_the_elastic_part(quartet):
    case = quartet.smooth_elastic
    state = case.dataset["contact_state"].copy(deep=True)
    state[-1, 0, 0] = ContactState.SLIP
    changed = replace(case, dataset=case.dataset.assign(contact_state=state))
    judgement = stick_zone(replace(quartet, smooth_elastic=changed))
    assert answer(judgement, "smooth elastic") is Answer.NO
    assert "1 cells of" in judgement.sentence


def test_a_stick_zone_that_does_not_shrink_or_yield_fails_the_plastic_part(quartet, doctored):
    plastic = quartet.smooth_plastic
    area = plastic.dataset["stick_area"] * 0.0 + float(plastic.dataset["stick_area"][0])
    constant = replace(plastic, dataset=plastic.dataset.assign(stick_area=area))
    weak = doctored(
        plastic, pressure=lambda cycle: np.minimum(plastic.field("pressure", cycle), 4.0e9)
    )
    for case, reason in ((constant, "does not shrink"), (weak, "does not yield")):
        judgement = stick_zone(replace(quartet, smooth_plastic=case))
        assert answer(judgement, "smooth plastic") is Answer.NO
        assert reason in judgement.sentence


# Claims 5 and 6


def ring_around(case, place, width=0.08):
    """A scar around one place of the slip zone of each cycle."""

    def depth(cycle):
        return np.exp(-(((case.zones(cycle).place(case.radius) - place) / width) ** 2))

    return depth


@pytest.mark.parametrize(
    ("place", "verdict"), [(0.5, Verdict.HOLDS), (0.1, Verdict.FAILS), (0.9, Verdict.FAILS)]
)
def test_deepest_wear_is_found_where_it_is(quartet, doctored, place, verdict):
    case = doctored(quartet.smooth_elastic, wear_depth=ring_around(quartet.smooth_elastic, place))
    # Rings are two cells of 4 µm wide, the slip zone some 60 µm.
    assert place_of_deepest(case, case.last) == pytest.approx(place, abs=0.1)
    assert deepest_in_the_middle(everywhere(case)).verdict is verdict


def test_scar_that_wanders_inward_holds_with_a_condition(quartet):
    judgement = deepest_in_the_middle(quartet)
    assert judgement.verdict is Verdict.CONDITIONAL
    case = quartet.smooth_elastic
    assert place_of_deepest(case, case.last) < place_of_deepest(case, 1)


def test_even_wear_holds_and_one_sided_wear_does_not(quartet, doctored):
    case = quartet.smooth_elastic

    def settled(cycle):
        return np.where(case.zones(cycle).slip, 1e-9 if cycle else 1e-5 * case.radius, 0.0)

    def one_sided(cycle):
        zones = case.zones(cycle)
        return np.where(zones.slip, np.exp(-6.0 * zones.place(case.radius)), 0.0)

    assert even_wear(everywhere(doctored(case, wear_rate=settled))).verdict is Verdict.HOLDS
    assert even_wear(everywhere(doctored(case, wear_rate=one_sided))).verdict is Verdict.FAILS


def test_wear_of_a_cycle_becomes_more_even(quartet):
    for _, case in quartet.each():
        assert unevenness(case, 2000) < unevenness(case, 0)


# Claim 7


def waves(case):
    along_x, along_y = case.wavenumbers
    return np.cos(along_x * case.x) * np.cos(along_y * case.y)


def test_wear_that_levels_the_slip_zone_only_holds(quartet, doctored):
    rough = quartet.rough_elastic
    amplitude = rough.parameter("roughness_amplitude")

    def levelled(cycle):
        # Tips are where the waves are lowest; what stands out of the valleys goes.
        return np.where(rough.zones(cycle).slip, amplitude * (1.0 - waves(rough)), 0.0)

    case = doctored(rough, wear_depth=levelled, plastic_depth=lambda _cycle: 0.0 * rough.radius)
    zones = case.zones(case.last)
    assert amplitude_left(case, case.last, zones.slip) == pytest.approx(0.0, abs=0.01)
    assert amplitude_left(case, case.last, zones.stick) == pytest.approx(1.0, abs=0.05)
    assert asperities(everywhere(case)).verdict is Verdict.HOLDS


def test_surfaces_without_wear_keep_their_asperities(quartet, doctored):
    rough = quartet.rough_elastic
    nothing = np.zeros_like(rough.radius)
    case = doctored(rough, wear_depth=lambda _cycle: nothing, plastic_depth=lambda _cycle: nothing)
    judgement = asperities(everywhere(case))
    assert judgement.verdict is Verdict.FAILS
    assert "100 % of the amplitude" in judgement.sentence


def test_asperities_go_in_the_middle_of_the_slip_zone_first(quartet):
    case = quartet.rough_elastic
    zones = case.zones(case.last)
    middle = amplitude_left(case, case.last, zones.between(0.25, 0.75))
    assert abs(middle) < 0.1
    assert amplitude_left(case, case.last, zones.stick) > 0.5


# Claim 8


def with_width(case, width):
    cycles = case.history["cycle"].values
    return replace(case, history=case.history.assign(contact_half_width_x=("step", width(cycles))))


def test_rough_contact_grows_faster_in_a_real_run(quartet):
    for cycle in (100, 1000):
        assert growth(quartet.rough_elastic, cycle) > growth(quartet.smooth_elastic, cycle)


def test_widths_that_settle_hold_and_others_do_not(quartet):
    def settling(rate, end):
        return lambda n: 1e-4 * (1.0 + (end - 1.0) * (1.0 - np.exp(-n / rate)))

    smooth = with_width(quartet.smooth_elastic, settling(400.0, 1.4))
    fast = with_width(quartet.rough_elastic, settling(200.0, 1.42))
    slow = with_width(quartet.rough_elastic, settling(800.0, 1.4))
    far = with_width(quartet.rough_elastic, settling(200.0, 1.6))
    verdicts = [
        width_grows_faster_when_rough(Quartet(smooth, rough, smooth, rough)).verdict
        for rough in (fast, slow, far)
    ]
    assert verdicts == [Verdict.HOLDS, Verdict.FAILS, Verdict.FAILS]


def test_width_that_still_grows_holds_with_a_condition(quartet):
    smooth = with_width(quartet.smooth_elastic, lambda n: 1e-4 * (1.0 + n / 35000.0))
    rough = with_width(quartet.rough_elastic, lambda n: 1e-4 * (1.0 + n / 30000.0))
    assert late_growth(smooth) == pytest.approx(0.5)
    judgement = width_grows_faster_when_rough(Quartet(smooth, rough, smooth, rough))
    assert judgement.verdict is Verdict.CONDITIONAL
    assert "still growing" in judgement.sentence


# Claim 9


def test_elastic_shear_changes_as_pressure_does(quartet):
    judgement = shear_behaves_like_pressure(quartet)
    assert answer(judgement, "smooth elastic") is Answer.YES
    assert answer(judgement, "rough elastic") is Answer.YES


def test_shear_that_goes_its_own_way_fails_the_ninth_claim(quartet, doctored):
    case = quartet.smooth_elastic
    opposite = doctored(
        case,
        shear_traction=lambda cycle: (
            2.0 * case.field("shear_traction", 0) - case.field("shear_traction", cycle)
        ),
    )
    assert shear_behaves_like_pressure(everywhere(opposite)).verdict is Verdict.FAILS


def test_noise_of_a_pressure_that_has_vanished_is_no_rise(quartet, doctored):
    case = quartet.smooth_elastic

    def vanished(cycle):
        pressure = case.field("pressure", cycle)
        noise = {2000: 0.0, case.last: 1e-6 * pressure.max()}
        return np.where(case.zones(cycle).slip, noise.get(cycle, pressure), pressure)

    late = doctored(case, pressure=vanished)
    assert pressure_moves_inward(everywhere(late)).verdict is Verdict.HOLDS
