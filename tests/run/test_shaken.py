"""Last bits decide nothing: runs whose products and transforms round elsewhere agree."""

import json
import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from ..studies import WAVES, base, write_study

SHAKEN = str(Path(__file__).parents[1] / "shaken")
ULPS = 4  # by which `sitecustomize` changes a number at most
PRODUCTS = """
import json
import numpy as np
from fretwear.mechanics.contact.kernels import dct, inner

numbers = []
for kind in (np.float64, np.float32):
    field = np.sqrt(np.arange(1.0, 13.0)).reshape(3, 4).astype(kind)
    numbers += [[inner(field, field), *map(float, dct(2, field, (0, 1)).ravel())]]
print(json.dumps(numbers))
"""
STUDY = """
import json
from fretwear.run.simulate import RunRecord, run
from fretwear.study.reading import load_study

found = {}
for case_id, case in load_study("small.yaml").cases().items():
    record = RunRecord()
    ds = run(case, record=record, warn=lambda _: None).dataset
    names = [name.removesuffix("_error") for name in map(str, ds) if name.endswith("_error")]
    results = {n: [ds[each].values.tolist() for each in (n, f"{n}_error")] for n in names}
    found[case_id] = [len(record.history), [each.width for each in record.rounds], results]
print(json.dumps(found))
"""


def start(program, folder, **environment):
    environment = {**os.environ, "PYTHONPATH": SHAKEN, "FRETWEAR_TEST_SHAKEN": "", **environment}
    command = [sys.executable, "-c", program]
    return subprocess.Popen(command, env=environment, cwd=folder, stdout=subprocess.PIPE)


def printed(process):
    text, _ = process.communicate()
    assert process.returncode == 0
    return json.loads(text)


@pytest.mark.slow
def test_products_and_transforms_are_shaken_by_a_few_units_of_their_precision(tmp_path):
    plain, again, first, second = (
        printed(start(PRODUCTS, tmp_path, FRETWEAR_TEST_SHAKEN=seed))
        for seed in ("", "1", "1", "2")
    )
    assert again == first
    for kind, *numbers in zip((float, np.float32), plain, first, second, strict=True):
        unshaken, one, two = map(np.array, numbers)
        assert not np.array_equal(one, two)
        for each in (one, two):
            assert (each != unshaken).sum() > 1
            # The second transform takes shaken numbers: their sizes sum up.
            most = ULPS * np.finfo(kind).eps * 12 * np.abs(unshaken).max()
            assert np.abs(each - unshaken).max() <= most
    kernels = "from fretwear.mechanics.contact import kernels\nprint(kernels.ducc0 and 1 or 0)"
    assert printed(start(kernels, tmp_path, FRETWEAR_TEST_WITHOUT="ducc0")) == 0


@pytest.mark.slow
def test_a_study_on_other_last_bits_has_the_same_results_within_their_errors(tmp_path):
    content = {
        "base": base(cycles=50, roughness={**WAVES, "slope_x": "0.5 deg", "slope_y": "0.5 deg"}),
        "vary": {
            "load": ["20 N", "30 N", "45 N", "60 N", "80 N"],
            "roughness.amplitude": ["0 um", "0.3 um"],
            "plastic_limit": ["none", "2000 MPa"],
        },
        "output": {"cycles": [0, 10]},
    }
    write_study(tmp_path / "small.yaml", content)
    plain, shaken = map(
        printed, [start(STUDY, tmp_path, FRETWEAR_TEST_SHAKEN=seed) for seed in ("", "1")]
    )
    assert len(plain) == 20
    assert plain != shaken
    for case_id, (_, _, results) in plain.items():
        for name, (values, errors) in results.items():
            others, _ = shaken[case_id][2][name]
            apart = np.abs(np.subtract(values, others))
            assert (apart <= errors)[np.isfinite(apart)].all(), (case_id, name)
    changed = [case_id for case_id in plain if plain[case_id][:2] != shaken[case_id][:2]]
    assert len(changed) <= 0.05 * len(plain), changed
