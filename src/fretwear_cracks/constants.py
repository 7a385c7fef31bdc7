"""Constants of stresses and lives, and the depth that is looked at: keys of a study file."""

from __future__ import annotations

from typing import Annotated

from pydantic.dataclasses import dataclass

from fretwear.quantity import Part, Quantity

_EXAMPLE = "{depth: 0.5 mm, fatigue_strength: 1000 MPa, strength_exponent: -0.1}"

LAWS = {
    "basquin": ("fatigue_strength", "strength_exponent"),
    "manson_coffin": ("fatigue_ductility", "ductility_exponent"),
}
"""Keys of the constants of lives, by the parameters of `fretwear.fatigue`."""


@dataclass(frozen=True)
class StressConstants(Part):
    """What stresses and lives need beside a case; see `fretwear.fatigue`."""

    depth: Annotated[
        float | None,
        Quantity("m", "$z$", "largest depth", "mm", "0.5 mm", gt=0.0),
        "Depth down to which stresses are looked at; by default 2 contact half-widths.",
    ] = None
    fatigue_strength: Annotated[
        float | None,
        Quantity("Pa", "$σ_f'$", "fatigue strength", "MPa", "1000 MPa", gt=0.0),
        "σ_f' in σ_a = σ_f' (2N)^b_σ; without it there are no lives.",
    ] = None
    strength_exponent: Annotated[
        float | None,
        Quantity("1", "$b_σ$", "strength exponent", like="-0.1", lt=0.0),
        "b_σ in σ_a = σ_f' (2N)^b_σ.",
    ] = None
    fatigue_ductility: Annotated[
        float | None,
        Quantity("1", "$ε_f'$", "fatigue ductility", like="0.5", gt=0.0),
        "ε_f' in ε_a,p = ε_f' (2N)^c_ε; without it strains are elastic.",
    ] = None
    ductility_exponent: Annotated[
        float | None,
        Quantity("1", "$c_ε$", "ductility exponent", like="-0.6", lt=0.0),
        "c_ε in ε_a,p = ε_f' (2N)^c_ε.",
    ] = None
    mean_stress: Annotated[
        float,
        Quantity("Pa", r"$σ_\mathrm{m}$", "mean of the bulk stress", "MPa", "80 MPa"),
        "Mean of the stress along x in the flat.",
    ] = 0.0
    stress_ratio: Annotated[
        float | None,
        Quantity("1", "$R_σ$", "stress ratio", like="0.1", lt=1.0),
        "Ratio of the least bulk stress to the largest, instead of its mean; -1 by default.",
    ] = None

    @property
    def mistake(self) -> tuple[str, str] | None:
        """The constants of a law belong together."""
        for both in LAWS.values():
            there, lacking = ([n for n in both if (vars(self)[n] is None) == no] for no in (0, 1))
            if there and lacking:
                return f"has {there[0]} without {lacking[0]}", _EXAMPLE
        if self.fatigue_ductility is not None and self.fatigue_strength is None:
            return "has fatigue_ductility without fatigue_strength", _EXAMPLE
        if self.stress_ratio is not None and self.mean_stress:
            return "has mean_stress and stress_ratio", "give one of them"
        return None

    @property
    def constants(self) -> dict[str, object]:
        """The mean of the bulk stress and constants of lives, as `fretwear.fatigue` takes them."""
        mean = {"mean_stress": self.mean_stress, "stress_ratio": self.stress_ratio}
        pairs = {law: tuple(getattr(self, key) for key in both) for law, both in LAWS.items()}
        return mean | {law: pair for law, pair in pairs.items() if pair[0] is not None}
