"""Closed forms for comparison with the results of a case."""

from __future__ import annotations

import math

from fretwear.study.case import Case
from fretwear.theory import HertzContact, LineContact


def unworn(case: Case) -> dict[str, float]:
    """Return results, SI units, of the smooth elastic contact of a case before wear, by name.

    They follow Hertz, Cattaneo and Mindlin. Results without a closed form are left out, such as the
    energy of bodies other than a sphere or cylinder; a coated flat has its whole coating alone.
    """
    if case.coating is not None:
        return {"exposed_area": 0.0, "coating_left": case.coating.thickness}
    hertz, sizes = case.hertz, case.indenter.half_widths
    if case.wears_unevenly:
        hertz = hertz.with_load(case.load_at(0.0))  # in the middle of the stroke
    results = {
        "contact_area": hertz.load / hertz.mean_pressure,
        "contact_radius": math.sqrt(math.prod(sizes(hertz))),
        "central_pressure": float(hertz.pressure(0.0)),
        "peak_pressure": hertz.peak_pressure,
        "approach": hertz.approach,
    }
    if case.tangential_ratio >= 1.0 or case.normal.pulsating_load < 1.0:
        return results
    # By Ciavarella and Jäger, the stick zone is the contact of the same bodies under P*.
    stick = hertz.with_load(case.stick_load)
    results["stick_area"] = stick.load / stick.mean_pressure
    results["stick_radius"] = math.sqrt(math.prod(sizes(stick)))
    moved = case.coupling * (hertz.approach - stick.approach)
    results["tangential_displacement"] = case.friction_law.coefficient * moved
    if type(hertz) in (HertzContact, LineContact):
        sliding = case.indenter.partial_slip(
            hertz, case.friction_law.coefficient, case.tangential_load, case.coupling
        )
        results["stick_load_share"] = share = sliding.stick_load_share
        results["mean_stick_pressure"] = share * hertz.load / results["stick_area"]
        results["dissipated_energy"] = sliding.dissipated_energy
    return results
