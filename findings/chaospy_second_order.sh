#!/usr/bin/env bash
# chaospy 4.3.21: `SecondOrderSobol(expansion, coefficients)` of a fitted chaos expansion returns for a pair of
# parameters not the share of their interaction but, with it, the whole share of the later of the two
# (its first-order index and its powers are counted in). `Sens_m2` of the same polynomial is right. A
# model without any interaction, wear = a + 2b + 3c, seems to be all interaction.
#
# Seen of a + 2b + 3c: (a, b) 0.286, (a, c) 0.643, (b, c) 0.643, where Sens_m2 has 0; of a + 2b + 3c + 4ab:
# (a, b) 0.491 instead of 0.038; first-order indices agree.
set -euo pipefail
folder="$(mktemp -d)"
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/env"
"$folder/env/bin/pip" install --quiet chaospy==4.3.21 numpy==2.4.6
"$folder/env/bin/python" -W ignore - <<'PYTHON'
import chaospy
import numpy as np

a, b, c = chaospy.variable(3)
inputs = chaospy.Iid(chaospy.Uniform(0.0, 1.0), 3)
basis = chaospy.generate_expansion(2, inputs, normed=True)
points, weights = chaospy.generate_quadrature(3, inputs, rule="gaussian")
for name, model, expected in (
    ("a + 2b + 3c", a + 2 * b + 3 * c, (4 / 14, 9 / 14, 9 / 14)),
    ("a + 2b + 3c + 4ab", a + 2 * b + 3 * c + 4 * a * b, (52 / 106, 27 / 106, 27 / 106)),
):
    fit, coefficients = chaospy.fit_quadrature(basis, points, weights, model(*points), retall=1)
    found = chaospy.SecondOrderSobol(basis, coefficients)
    right = chaospy.Sens_m2(fit, inputs)
    pairs = np.triu_indices(3, 1)
    print(name, "SecondOrderSobol", found[pairs].round(3), "Sens_m2", right[pairs].round(3))
    assert np.allclose(chaospy.FirstOrderSobol(basis, coefficients), chaospy.Sens_m(model, inputs), atol=1e-6)
    assert np.allclose(found[pairs], expected, atol=1e-3)
    assert right[pairs].max() < 0.05
PYTHON
