"""Every claim of the answer, and every number in its sentence, is that of the table of results."""

import csv
import io
import json
import math
import re
from itertools import combinations, pairwise

import numpy as np
import pytest
import xarray as xr
from hypothesis import given
from hypothesis import strategies as st
from scipy.stats import qmc

from fretwear.data.effects import final_results, results_table
from fretwear.report.answer import answer_text, answers, regimes
from fretwear.report.results import Level, PointResult, over_seeds
from fretwear.study.parameters import parameter, value_text
from fretwear.units import in_unit
from fretwear.vocabulary import RESULTS, PointStatus

from ..studies import sampled

KEYS = [
    *("result", "parameter", "from", "to", "where", "pairs", "lowest_factor", "highest_factor"),
    *("undefined", "appears", "vanishes", "text"),
]
NUMBER = r"[−\d.]+(?:·10[⁻⁰¹²³⁴⁵⁶⁷⁸⁹]+)?"
RANGE = rf"({NUMBER})(?: to ({NUMBER}))?"
CLAUSES = {
    "grows %": rf"grows by {RANGE}\xa0%",
    "grows": rf"grows by a factor of {RANGE}",
    "falls %": rf"falls by {RANGE}\xa0%",
    "falls": rf"falls by a factor of {RANGE}",
    "stays": r"changes by less than 0\.5\xa0%",
    "same": "stays the same",
    "appears": r"rises from zero to (?P<size>[^,;]*?)",
    "vanishes": r"falls from (?P<size>[^,;]*?) to zero",
    "zero": "is zero",
    "undefined": "is undefined",
    "zone appears": r"a stick zone appears",
    "zone vanishes": r"the stick zone \((?P<size>.*?)\) vanishes",
    "nothing": "nothing sticks",
}
COUNT = r"(?: in (?:(\d+)(?: of (\d+) pairs)?|(both) pairs|all (\d+) pairs))?"
AFTER = (
    r"(?: \((?P<after>[^()]*|\([^()]*\) × [^()]*)\))?"
    r"(?P<why>, as (?:gross|partial) slip becomes (?:gross|partial) slip"
    r"|, where a case slides as a whole)?"
)
BETWEEN = (
    r", end to end; in between it (falls|grows|varies by more)(?: in (\d+) of these (\d+) pairs)?"
)


class Table:
    """The done points of results.csv, and what they say of pairs of them."""

    def __init__(self, summary):
        rows = list(csv.DictReader(io.StringIO(results_table(summary))))
        named = {str(name): {*each.dims} for name, each in summary.coords.items()}
        along = {*summary["status"].dims}
        self.varied = [n for n, dims in named.items() if dims and dims <= along]
        self.varied = [n for n in self.varied if n not in ("case_id", "point")]
        done = {tuple(row[n] for n in self.varied): row for row in rows if row["status"] == "done"}
        self.rows = list(done.values())
        self.units = {name: summary[name].attrs.get("units", "") for name in self.varied}

    def level(self, row, name):
        try:
            value = float(row[name])
        except ValueError:
            return row[name]
        return "none" if math.isinf(value) else value

    def value(self, row, result):
        """A final result; what is no larger than its estimated error is not known."""
        value = float(row[result] or "nan")
        error = float(row.get(f"{result}_error") or "nan")
        return math.nan if value and error >= abs(value) else value

    def slides(self, row):
        return row.get("regime") == "1"

    def pairs(self, name, first, last, where):
        """Rows of cases that differ in this parameter alone and have these levels."""
        for line in self.lines(name):
            row = {self.level(each, name): each for each in line}
            ends = row.get(first), row.get(last)
            held = all(self.level(line[0], n) == level for n, level in where.items())
            if held and None not in ends and ends[0]["case_id"] != ends[1]["case_id"]:
                yield ends

    def lines(self, name):
        """Two or more rows that differ in this parameter alone."""
        found = {}
        for row in self.rows:
            found.setdefault(tuple(row[n] for n in self.varied if n != name), []).append(row)
        return [line for line in found.values() if len(line) > 1]

    def between(self, pair, name, result):
        """The known results of one line from one row to another."""
        low, high = (self.level(row, name) for row in pair)
        if isinstance(low, str) or isinstance(high, str):
            return []
        (line,) = (line for line in self.lines(name) if pair[0] in line)
        inside = [r for r in line if self.level(r, name) != "none"]
        inside = [r for r in inside if low <= self.level(r, name) <= high]
        values = [self.value(r, result) for r in sorted(inside, key=lambda r: self.level(r, name))]
        return [value for value in values if not math.isnan(value)]


def number(text):
    """A printed number, and half of its last digit."""
    mantissa, _, power = text.replace("−", "-").partition("·10")
    digits = str.maketrans("⁻⁰¹²³⁴⁵⁶⁷⁸⁹", "-0123456789")
    scale = 10.0 ** int(power.translate(digits) or 0)
    decimals = len(mantissa.partition(".")[2])
    # A whole number may stand for one of three digits.
    zeros = len(mantissa) - len(mantissa.rstrip("0")) if not decimals and len(mantissa) > 3 else 0
    return float(mantissa) * scale, 0.5001 * 10.0 ** (zeros - decimals) * scale


def agree(printed, values):
    """Compare a printed range with the smallest and the largest of some values."""
    texts = [text for text in printed if text]
    ends = [min(values), max(values)]
    for text, value in zip([texts[0], texts[-1]], ends, strict=True):
        shown, half = number(text)
        assert abs(shown - value) <= half + 1e-6 * abs(value), (printed, ends)


SIZES = {
    **{"µm³": 1e-18, "× 10³ µm³": 1e-15, "× 10⁶ µm³": 1e-12, "mm³": 1e-9},
    **{"µm²": 1e-12, "× 10³ µm²": 1e-9, "mm²": 1e-6, "MPa": 1e6, "%": 1e-2},
    **{"pm": 1e-12, "nm": 1e-9, "µm": 1e-6, "mm": 1e-3, "J": 1.0, "J/m": 1.0},
    **{
        f"{p}{j}": 10.0**-n
        for n, p in zip((12, 9, 6, 3), "pnµm", strict=True)
        for j in ("J", "J/m")
    },
}


def agree_size(text, values):
    """Compare a range with its unit, such as (16.4 to 207) × 10³ µm³, with values in SI units."""
    low, high, unit = re.fullmatch(rf"\(?{RANGE}\)?\s*(.*)", text).groups()
    agree([low, high], [value / SIZES[unit] for value in values])


def way(before, after):
    if before > 0.0:
        factor = after / before
        return (factor > 1.005) - (factor < 0.995)
    return 1 if after > 0.0 else 0


def expected_of(pairs, table, result):
    """Sort pairs by what happens between them."""
    found = {}
    for pair in pairs:
        before, after = (table.value(row, result) for row in pair)
        if math.isnan(before) or math.isnan(after):
            kind = "undefined"
        elif before == 0.0 or after == 0.0:
            kind = {(False, True): "appears", (True, False): "vanishes"}.get(
                (before > 0.0, after > 0.0), "zero"
            )
        else:
            kind = {1: "grows", -1: "falls", 0: "stays"}[way(before, after)]
        found.setdefault(kind, []).append((pair, before, after))
    return found


def check_text(claim, table, pairs):
    """Read the sentence of a claim again and compare each of its numbers."""
    name, result, text = claim["parameter"], claim["result"], claim["text"]
    found, (first, last) = expected_of(pairs, table, result), (claim["from"], claim["to"])
    ends = [
        value_text(name, in_unit(math.inf if level == "none" else level, table.units[name]))
        for level in (first, last)
    ]
    match = re.fullmatch(r"(?:where (?P<where>.*?), )?from (?P<low>.*?) to (?P<high>.*)", text)
    rest = match["high"].replace("\xa0", " ", ends[1].count(" "))
    assert rest.startswith(f"{ends[1]} "), (text, ends)
    low = match["low"].replace("\xa0", " ")
    numbers, units = zip(*(end.partition(" ")[::2] for end in ends), strict=True)
    has_unit = not isinstance(first, str) and units[0] == units[1]
    assert low == (numbers[0] if has_unit else ends[0])
    assert bool(match["where"]) == bool(claim["where"])
    rest = rest.removeprefix(ends[1]).removeprefix(" it").removeprefix(" ")
    told, count = {}, len(pairs)
    while rest:
        if between := re.fullmatch(BETWEEN, rest):
            check_between(claim, table, pairs, between)
            break
        rest = re.sub(r"^(, | and )", "", rest)
        clauses = (
            (k, re.match(f"{p}{COUNT}{AFTER}(?=$|, | and )", rest)) for k, p in CLAUSES.items()
        )
        kind, here = next(each for each in clauses if each[1])
        rest = rest[here.end() :]
        groups = here.groups()
        some, of, both, whole = groups[-6:-2]
        number_told = int(some or whole or (2 if both else 1))
        if of:
            assert int(of) == count
        if both or whole or not some:
            assert number_told == count
        name = kind.partition(" ")[0] if kind.endswith("%") else kind
        name = {
            "same": "stays",
            "zone appears": "appears",
            "zone vanishes": "vanishes",
            "nothing": "zero",
        }.get(name, name)
        told[name] = number_told
        these = found[name]
        factors = [after / before for _, before, after in these if before > 0.0 and after > 0.0]
        if kind == "grows %":
            agree(groups[:2], [100.0 * (f - 1.0) for f in factors])
        elif kind == "grows":
            agree(groups[:2], factors)
        elif kind == "falls %":
            agree(groups[:2], [100.0 * (1.0 - f) for f in factors])
        elif kind == "falls":
            agree(groups[:2], [1.0 / f for f in factors])
        elif kind == "same":
            assert max(abs(f - 1.0) for f in factors) < 1e-6
        size = here.groupdict().get("size") or here["after"]
        if name == "appears":
            agree_size(size, [after for *_, after in these])
        elif name == "vanishes":
            agree_size(size, [before for _, before, _ in these])
        sliding = [[table.slides(row) for row in pair] for pair, *_ in these]
        if here["why"]:
            assert {
                ", as gross slip becomes partial slip": all(s == [True, False] for s in sliding),
                ", as partial slip becomes gross slip": all(s == [False, True] for s in sliding),
                ", where a case slides as a whole": all(map(any, sliding)),
            }[here["why"]]
    assert told == {kind: len(those) for kind, those in found.items()}, text


def check_between(claim, table, pairs, match):
    result = claim["result"]
    known = [p for p in pairs if all(table.value(row, result) > 0.0 for row in p)]
    sign = {"falls": 1, "grows": -1, "varies by more": 0}[match[1]]
    counted = 0
    for pair in known:
        values = table.between(pair, claim["parameter"], result)
        ways = [way(a, b) for a, b in pairwise(values)]
        counted += any(w * sign < 0 if sign else w for w in ways)
        ends = way(*(table.value(row, result) for row in pair))
        assert ends == sign
    assert counted == int(match[2] or len(known)) > 0
    assert len(known) == int(match[3] or len(known))


def check_chance(claim, table):
    result = claim["result"]
    ensembles = [
        [table.value(row, result) for row in line] for line in table.lines("roughness_seed")
    ]
    pairs = [pair for line in ensembles for pair in combinations(line, 2)]
    assert claim["pairs"] == len(pairs)
    assert claim["undefined"] == sum(not (a > 0.0 and b > 0.0) for a, b in pairs)
    lines = [np.array([v for v in line if v > 0.0]) for line in ensembles]
    lines = [line for line in lines if line.size > 1]
    if not lines:
        assert claim["lowest_factor"] is claim["highest_factor"] is None
        assert "undefined or zero" in claim["text"]
        return
    shares = np.concatenate([line / line.mean() for line in lines])
    assert claim["lowest_factor"] == pytest.approx(shares.min(), rel=1e-7)
    assert claim["highest_factor"] == pytest.approx(shares.max(), rel=1e-7)
    deviation = np.sqrt(np.mean([(line.std(ddof=1) / line.mean()) ** 2 for line in lines]))
    (shown,) = re.findall(r"standard deviation of ([\d.]+)\xa0%", claim["text"])
    agree([shown], [100.0 * deviation])


def check_claims(summary):
    """Check all that is told of a study against its table, and return the claims."""
    found, table = list(answers(summary)), Table(summary)
    claims = json.loads(answer_text(found))
    for claim in claims:
        assert [*claim] == KEYS
        if claim["from"] is None:
            check_chance(claim, table)
            continue
        ends = claim["from"], claim["to"]
        pairs = list(table.pairs(claim["parameter"], *ends, claim["where"]))
        kinds = expected_of(pairs, table, claim["result"])
        known = [pair for kind in ("grows", "falls", "stays") for pair in kinds.get(kind, ())]
        factors = [after / before for _, before, after in known]
        assert claim["pairs"] == len(pairs) > 0
        assert claim["undefined"] == len(pairs) - len(factors)
        assert claim["appears"] == len(kinds.get("appears", ()))
        assert claim["vanishes"] == len(kinds.get("vanishes", ()))
        bounds = claim["lowest_factor"], claim["highest_factor"]
        if factors:
            assert bounds == pytest.approx((min(factors), max(factors)), rel=1e-7)
        else:
            assert bounds == (None, None)
        check_text(claim, table, pairs)
    for answer in found:
        check_lines(answer, table)
    return claims


def check_lines(answer, table):
    """Compare which parameters are told of, in which order, and of which levels."""
    name = answer.name
    lines = {varied: groups for varied in table.varied if (groups := table.lines(varied))}
    imposed = {
        n for n in lines if re.search(rf"to the {parameter(n).words}( and|[,.])", answer.rest)
    }
    for varied in imposed:
        word = f"inversely proportional to the {parameter(varied).words}"
        power = -1 if word in answer.rest else 1
        for one, other in (pair for line in lines[varied] for pair in combinations(line, 2)):
            ratio = float(one[varied]) / float(other[varied])
            factor = table.value(one, name) / table.value(other, name)
            assert factor == pytest.approx(ratio**power, rel=1e-5)
    told = [line.parameter for line in answer.lines]
    assert {*told} == {*lines} - imposed

    def importance(varied):
        known = [[table.value(row, name) for row in group] for group in lines[varied]]
        known = [[v for v in line if not math.isnan(v)] for line in known]
        known = [line for line in known if any(line)]
        sizes = [math.log(max(line) / min(line)) for line in known if min(line)]
        appearing = round((len(known) - len(sizes)) / len(lines[varied]), 9)
        return appearing, round(float(np.mean(sizes)) if sizes else 0.0, 6)

    assert [importance(varied) for varied in told] == sorted(map(importance, told), reverse=True)
    for line in answer.lines:
        if line.parameter == "roughness_seed":
            continue
        contents = [claim.content() for claim in line.claims]
        ends = {(content["from"], content["to"]) for content in contents}
        for group in lines[line.parameter]:
            levels = [table.level(row, line.parameter) for row in group]
            numbers = sorted(level for level in levels if not isinstance(level, str))
            if len(numbers) > 1:
                assert numbers[0] in {first for first, _ in ends}
                assert numbers[-1] in {last for _, last in ends}
            if numbers and "none" in levels:
                assert (numbers[-1], "none") in ends
    shown = [v for row in table.rows if not math.isnan(v := table.value(row, name))]
    if "stick" in name:
        shown = [v for v in shown if v]
    values, _, cases = answer.values.partition(", in ")
    agree_size(values, shown)
    missing = len(table.rows) - len(shown)
    assert cases == (f"{len(shown)} of {len(table.rows)} cases" if missing else "")


NOISE = (0.0, 1e-3, 0.01, 0.5)
LEVELS = {
    "load": (10.0, 20.0, 35.0, 40.0, 50.0),
    "friction": (0.2, 0.4, 0.6, 0.8),
    "plastic_limit": (math.inf, 3e9, 4.5e9, 6e9),
    "rig_stiffness": (5e6, 2e7, math.inf),
    "roughness_amplitude": (0.0, 1e-7, 2e-7),
    "youngs_modulus": ("[208 GPa, 70 GPa]", "[100 GPa, 70 GPa]", "210 GPa"),
    "slip_model": ("jaeger", "cattaneo_mindlin", "uniform"),
    "roughness_seed": (1.0, 2.0, 3.0, 4.0, 5.0),
}


def made_study(rng):
    """Return a merged study as `merge_study` writes it, of any results."""
    names = rng.permutation(sorted(LEVELS))[: rng.integers(1, 4)].tolist()
    chosen = {
        name: rng.permutation(np.array(LEVELS[name]))[: rng.integers(1, 6)].tolist()
        for name in names
    }
    is_line, is_grid, noise = rng.random() < 0.3, rng.random() < 0.7, rng.choice(NOISE)
    if is_grid:
        dims, shape = tuple(names), tuple(map(len, chosen.values()))
        places = np.indices(shape)
        coordinates = {name: (name, np.array(levels)) for name, levels in chosen.items()}
    else:
        dims, shape = ("point",), (int(rng.integers(1, 13)),)
        places = [rng.integers(len(levels), size=shape) for levels in chosen.values()]
        listed = zip(chosen.items(), places, strict=True)
        coordinates = {name: ("point", np.array(levels)[at]) for (name, levels), at in listed}
        coordinates["point"] = ("point", np.arange(shape[0]))

    def result():
        """Effects of either sign, of some size or none, that may turn, and noise."""
        total = noise * rng.standard_normal(shape)
        for at, levels in zip(places, chosen.values(), strict=True):
            steps = rng.choice((0.0, 0.003, 0.1, 1.0)) * rng.standard_normal(len(levels))
            effect = np.cumsum(np.abs(steps)) if rng.random() < 0.6 else steps
            if rng.random() < 0.2 and not any(isinstance(level, str) for level in levels):
                numbers = [level for level in levels if 0.0 < level < math.inf] or [1.0]
                effect = np.log([v / numbers[0] if v in numbers else 1.0 for v in levels])
            total = total + rng.choice((-1, 1)) * effect[at]
        return np.exp(np.clip(total, -4.0, 4.0))

    slides = rng.random(shape) < rng.choice((0.0, 0.3, 1.0))
    volume = np.where(rng.random(shape) < rng.choice((0.0, 0.0, 0.2)), 0.0, result())
    # Twins are the same case.
    if not is_grid:
        _, first, twin = np.unique(np.array(places), axis=1, return_index=True, return_inverse=True)
        alike = first[twin.ravel()]
        slides, volume = slides[alike], volume[alike]
    given = {
        "wear_volume": 1e-14 * volume,
        "stick_half_width_x": np.where(slides, 0.0, 5e-5 * volume),
        "mean_stick_pressure": np.where(slides, rng.choice((0.0, np.nan)), 1e9 * volume),
        "dissipated_energy": 1e-6 * volume**2,
        "dissipated_energy_error": np.full(shape, rng.choice((0.0, 1e-6, np.inf))),
        # A grid may be too coarse to show what sticks.
        "regime": (slides & ((volume > 1.0) | (rng.random() < 0.7))).astype(float),
    }
    alike = np.arange(slides.size) if is_grid else alike
    status = np.where(rng.random(shape) < rng.choice((0.0, 0.2)), 1, 0).astype("int8")
    status = status.ravel()[alike].reshape(shape)
    short = rng.random(shape) < 0.3
    units = {"wear_volume": "m2", "dissipated_energy": "J m-1"} if is_line else {}
    variables = {}
    for name, last in given.items():
        last = np.where(status == 0, last, np.nan)
        steps = [0.5 * last, last, np.where(short, np.nan, last)]
        steps[1] = np.where(short, last, 0.7 * last) if name != "regime" else last
        si_unit = units.get(name, RESULTS[name.removesuffix("_error")].si_unit)
        variables[name] = ((*dims, "cycle"), np.stack(steps, axis=-1), {"units": si_unit})
    if is_line and "load" in coordinates:
        coordinates["load"] = (*coordinates["load"], {"units": "N m-1"})
    ids = np.array([f"case {i}" for i in alike]).reshape(shape)
    dataset = xr.Dataset(
        {"status": (dims, status), "code_digest": (dims, ids), **variables},
        {**coordinates, "case_id": (dims, ids), "cycle": [0.0, 10.0, 100.0]},
    )
    return dataset.transpose("cycle", ...) if rng.random() < 0.3 else dataset


@given(st.integers(0, 2**32 - 1))
def test_every_claim_and_every_number_told_is_that_of_the_table_of_results(seed):
    check_claims(made_study(np.random.default_rng(seed)))


def test_every_sentence_holds_for_every_pair_of_a_study_with_holes(finished):
    claims = check_claims(finished.summary)
    assert {claim["parameter"] for claim in claims} == {*map(str, finished.summary["status"].dims)}
    assert not any("not held" in claim["text"] for claim in claims)


@pytest.mark.slow
def test_every_sentence_on_the_default_study_holds_for_all_pairs(coarse_demo):
    claims = check_claims(xr.load_dataset(coarse_demo / "results/demo/summary.nc"))
    whole = [claim for claim in claims if not claim["where"]]
    assert {claim["pairs"] for claim in whole} == {8, 12}


def made_up(values, volumes, **more):
    """Return a merged study with these final wear volumes, or other results, over a grid."""
    dims, shape = list(values), np.shape(next(iter(more.values()), volumes))
    results = {"wear_volume": volumes, **more}
    return xr.Dataset(
        {
            "status": (dims, np.zeros(shape, dtype="int8")),
            "code_digest": (dims, np.full(shape, "")),
            **{
                name: ((*dims, "cycle"), np.stack([0.0 * each, each], axis=-1))
                for name, each in results.items()
                if each is not None
            },
        },
        {
            **values,
            "cycle": [0.0, 10.0],
            "case_id": (dims, np.arange(np.prod(shape)).astype(str).reshape(shape)),
        },
    )


def told(summary, result="wear_volume"):
    """Check all claims of a study, and return the lines on one result by their parameter."""
    check_claims(summary)
    (answer,) = (each for each in answers(summary) if each.name == result)
    return {line.parameter: line.text.replace("\xa0", " ") for line in answer.lines}


def test_a_limit_that_is_none_is_not_the_hardest_level():
    limits = [np.inf, 3e9, 4.5e9]
    volumes = 1e-15 * np.array([[16.4, 55.2, 63.6], [46.4, 185.1, 207.3]])
    study = made_up({"load": [25.0, 50.0], "plastic_limit": limits}, volumes)
    lines = told(study)
    # The first line answers whether a harder surface wears less.
    assert next(iter(lines.items())) == (
        "plastic_limit",
        "from 3000 to 4500 MPa it grows by 12 to 15 % in both pairs; "
        "from 4500 MPa to elastic it falls by 74 to 78 % in both pairs",
    )
    assert "average" not in " ".join(lines.values())


def test_a_stick_zone_that_appears_is_said_to_and_the_regimes_are_named():
    along = ("load", [6e4, 1.2e5], {"units": "N m-1"})
    stick, regime = np.array([0.0, 51.3e-6]), np.array([1.0, 0.0])
    pressure = np.array([np.nan, 7e8])
    results = {"stick_half_width_x": stick, "mean_stick_pressure": pressure, "regime": regime}
    study = made_up({"load": along}, 1e-10 * np.array([4.0, 0.1]), **results)
    assert told(study, "stick_half_width_x")["load"] == (
        "from 60 to 120 N/mm a stick zone appears (51.3 µm), as gross slip becomes partial slip"
    )
    assert told(study, "mean_stick_pressure")["load"] == (
        "from 60 to 120 N/mm it is undefined, where a case slides as a whole"
    )
    assert (
        regimes(study)
        == "After the last cycle 1 of 2 cases is in partial slip and 1 in gross slip."
    )
    shown = {answer.name: answer.values for answer in answers(study)}
    assert shown["stick_half_width_x"] == "51.3 µm, in 1 of 2 cases"
    assert shown["mean_stick_pressure"] == "700 MPa, in 1 of 2 cases"
    gone = made_up({"load": along}, None, stick_half_width_x=stick[::-1], regime=regime[::-1])
    assert (
        "the stick zone (51.3 µm) vanishes, as partial slip"
        in told(gone, "stick_half_width_x")["load"]
    )
    none = made_up({"load": along}, stick + 1.0, stick_half_width_x=0.0 * stick, regime=regime)
    assert [answer.name for answer in answers(none)] == ["wear_volume"]


def test_a_case_without_a_stick_zone_is_said_to_slide_only_where_it_does():
    pressure = np.array([[np.nan, np.nan], [7e8, 8e8]])
    results = {"mean_stick_pressure": pressure, "regime": np.array([[1.0, 0.0], [0.0, 0.0]])}
    study = made_up({"load": [60.0, 120.0], "friction": [0.3, 0.6]}, None, **results)
    lines = told(study, "mean_stick_pressure")
    assert lines["load"] == "from 60 to 120 N it is undefined in both pairs"


def test_what_was_undefined_at_the_last_cycle_is_not_that_of_an_earlier_one():
    study = made_up({"load": [10.0, 20.0]}, np.ones(2), mean_stick_pressure=np.array([5e8, 6e8]))
    study["mean_stick_pressure"][1, 1] = np.nan
    study["mean_stick_pressure"][:, 0] = 1e9
    # A case may end earlier: then nothing is known of it at the last cycle.
    study["wear_volume"][0, 1] = study["mean_stick_pressure"][0, 1] = np.nan
    final = final_results(study)
    np.testing.assert_equal(final["mean_stick_pressure"], [1e9, np.nan])


def test_a_parameter_that_fixes_a_result_by_definition_is_no_finding():
    energy = 0.096 * np.outer([10.0, 20.0], [0.3, 0.6, 0.9])
    given = {"load": [10.0, 20.0], "friction": [0.3, 0.6, 0.9]}
    study = made_up(given, 1.0 / energy, dissipated_energy=energy)
    check_claims(study)
    volume, dissipated = answers(study)
    assert volume.lines == dissipated.lines == ()
    assert dissipated.rest == (
        "Imposed quantities make it proportional to the coefficient of friction and proportional "
        "to the normal load."
    )
    assert volume.rest.startswith("Imposed quantities make it inversely proportional to the")


def test_the_slope_of_a_smooth_surface_changes_nothing_and_nothing_is_said_of_it():
    given = {"roughness_slope_x": [0.05, 0.1], "roughness_amplitude": [0.0, 2e-7]}
    study = made_up(given, np.array([[1.0, 2.0], [1.0, 3.0]]))
    study["case_id"][1, 0] = study["case_id"][0, 0]
    assert told(study)["roughness_slope_x"] == "from 2.8648° to 5.7296° it grows by 50 %"


def test_what_is_no_larger_than_its_error_is_undefined():
    given = {"dissipated_energy": np.array([1e-6, 4e-10])}
    study = made_up({"load": [10.0, 20.0]}, np.ones(2), **given)
    study["dissipated_energy_error"] = 0.0 * study["dissipated_energy"] + 1e-9
    assert told(study, "dissipated_energy") == {"load": "from 10 to 20 N it is undefined"}


def test_what_rises_and_falls_again_is_told_in_runs_and_what_wavers_end_to_end():
    loads = {"load": [10.0, 20.0, 30.0, 40.0, 50.0, 60.0]}
    hump = told(made_up(loads, np.array([1.0, 1.2, 1.5, 1.4, 1.2, 0.9])))
    assert hump["load"] == "from 10 to 30 N it grows by 50 %; from 30 to 60 N it falls by 40 %"
    wavering = told(made_up(loads, np.array([1.0, 2.0, 1.5, 3.0, 2.0, 4.0])))
    assert wavering["load"] == (
        "from 10 to 60 N it grows by a factor of 4.00, end to end; in between it falls"
    )


@pytest.mark.parametrize("levels", [9, 301])
def test_a_change_of_many_small_steps_is_told_as_a_whole(levels):
    wobbling = 0.002 * (-1.0) ** np.arange(levels)
    volumes = np.exp(np.linspace(0.0, 0.03, levels) + wobbling)
    (answer,) = answers(made_up({"load": np.linspace(20.0, 30.0, levels)}, volumes))
    (line,) = answer.lines
    assert line.text == "from 20 to 30\xa0N it grows by 3.0\xa0%"


def test_a_parameter_that_acts_both_ways_is_told_where_it_does_which():
    volumes = np.array([[1.0, 0.9], [3.0, 6.5]])
    study = made_up({"plastic_limit": [4.5e9, np.inf], "roughness_amplitude": [0.0, 2e-7]}, volumes)
    assert told(study)["roughness_amplitude"] == (
        "where the plastic limit is 4500 MPa, from smooth to 0.2 µm it falls by 10 %; "
        "where elastic, from smooth to 0.2 µm it grows by a factor of 2.17"
    )


def test_what_goes_both_ways_without_a_reason_is_counted():
    volumes = np.array([[1.0, 1.0, 1.0, 1.0, 0.0], [1.5, 1.25, 0.75, 1.001, 2.0]])
    study = made_up({"load": [20.0, 30.0], "friction": [0.2, 0.4, 0.6, 0.7, 0.8]}, volumes)
    assert told(study)["load"] == (
        "from 20 to 30 N it grows by 25 to 50 % in 2 of 5 pairs, falls by 25 % in 1, changes by "
        "less than 0.5 % in 1 and rises from zero to 2·10⁹ mm³ in 1"
    )


def test_one_case_and_what_nothing_changes_are_said_to_be_so():
    (alone,) = answers(made_up({"load": [20.0]}, np.array([1.0])))
    assert (alone.lines, alone.headline) == ((), "")
    same = told(made_up({"load": [20.0, 30.0]}, np.array([1.0, 1.004])))
    assert same["load"] == "from 20 to 30 N it changes by less than 0.5 %"
    same = told(made_up({"load": [20.0, 30.0]}, np.array([1.0, 1.0])))
    assert same["load"] == "from 20 to 30 N it stays the same"


def test_what_the_intervals_of_a_sample_do_not_tell_apart_is_not_ranked():
    unit = qmc.Sobol(3, seed=8).random(64)
    noise = 0.05 * np.random.default_rng(9).standard_normal(64)
    (alike,) = answers(sampled(unit, 1.0 + unit[:, 0] + unit[:, 1] + 0.1 * unit[:, 2] + noise))
    assert "matter most, and their order is uncertain. Alone they explain" in alike.headline
    (apart,) = answers(sampled(unit, 1.0 + 2.0 * unit[:, 0] + unit[:, 1] + noise))
    assert apart.headline.startswith("The normal load matters most: alone it explains 79")
    assert json.loads(answer_text([alike, apart])) == []


def test_what_a_seed_does_is_chance_and_told_by_its_deviation():
    values = np.array([1.00, 1.04, 0.97, 1.01])
    study = made_up({"roughness_seed": [1, 2, 3, 4]}, values)
    spread = 100.0 * values.std(ddof=1) / values.mean()
    assert told(study) == {
        "roughness_seed": f"it varies by chance, with a standard deviation of {spread:.1f} %"
    }


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
