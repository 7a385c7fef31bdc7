"""Closed forms beside which the results of a case are shown."""

from __future__ import annotations

import math

from fretwear.study.case import Case
from fretwear.theory import HertzContact, LineContact, gross_slip_energy


def unworn(case: Case) -> dict[str, float]:
    """Return results, SI units, of the smooth elastic contact of a case before wear, by name.

    They follow Hertz, Cattaneo and Mindlin, or a contact that slides as a whole. What
    has no closed form, such as the energy of bodies other than a sphere or cylinder, is left out.
    """
    hertz, friction, coupling = case.hertz, case.friction_law.coefficient, case.coupling
    if case.wears_unevenly:
        hertz = hertz.with_load(case.load_at(0.0))  # in the middle of the stroke
    is_hertzian, is_even = type(hertz) in (HertzContact, LineContact), all(case.indenter.even)
    sizes = case.indenter.half_widths
    results = {
        "contact_area": hertz.load / hertz.mean_pressure,
        "central_pressure": float(hertz.pressure(0.0)),
        "peak_pressure": hertz.peak_pressure,
        "approach": hertz.approach,
    }
    if is_even:
        along_x, along_y = sizes(hertz)
        results |= {"contact_half_width_x": along_x, "contact_half_width_y": along_y}
        results["contact_radius"] = math.sqrt(along_x * along_y)
    if case.tangential_ratio >= 1.0:
        results |= {"stick_half_width_x": 0.0, "stick_radius": 0.0, "stick_area": 0.0}
        if stroke := case.loading.stroke:
            results["dissipated_energy"] = 4.0 * friction * hertz.load * stroke
            return {**results, "tangential_displacement": stroke}
        # The rig takes up µP/S of the displacement, or the bodies of a cylinder.
        slid = case.displacement_amplitude - friction * hertz.load * case.loading.flexibility(hertz)
        if is_hertzian:
            results["dissipated_energy"] = gross_slip_energy(hertz, friction, coupling, slid)
        return {**results, "tangential_displacement": slid}
    # By Ciavarella and Jäger, the stick zone is the contact of the same bodies under P*.
    stick = hertz.with_load(case.stick_load)
    results["stick_area"] = stick.load / stick.mean_pressure
    moved = hertz.approach
    if pulsates := case.normal.pulsating_load < 1.0:
        moved = 0.5 * (moved + hertz.with_load(case.load_at(-1.0)).approach)
    results["tangential_displacement"] = friction * coupling * (moved - stick.approach)
    if is_even:
        results["stick_half_width_x"], along_y = sizes(stick)
        results["stick_radius"] = math.sqrt(results["stick_half_width_x"] * along_y)
    if is_hertzian and not pulsates:
        sliding = case.indenter.partial_slip(hertz, friction, case.tangential_load, coupling)
        results["stick_load_share"] = share = sliding.stick_load_share
        results["mean_stick_pressure"] = share * hertz.load / results["stick_area"]
        results["dissipated_energy"] = sliding.dissipated_energy
    return results
