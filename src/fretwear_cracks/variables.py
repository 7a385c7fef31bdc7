"""Variables of stresses, of parameters for the initiation of cracks, and of fatigue."""

from __future__ import annotations

from fretwear.variable import variables

STRESSES = variables(
    r"""
stress_xx | Pa | $σ_{xx}$ | MPa | normal stress along x | free | tension is positive
stress_yy | Pa | $σ_{yy}$ | MPa | normal stress along y | free | tension is positive
stress_zz | Pa | $σ_{zz}$ | MPa | normal stress along the depth | free | tension is positive
stress_xy | Pa | $σ_{xy}$ | MPa | shear stress in planes of equal depth | free |
stress_xz | Pa | $σ_{xz}$ | MPa | shear stress along x and the depth | free |
    the negative shear traction just below the surface
stress_yz | Pa | $σ_{yz}$ | MPa | shear stress along y and the depth | free |
von_mises | Pa | $σ_\mathrm{M}$ | MPa | von Mises stress | |
""",
    "float32",
)
"""Stresses below the surface over the phases of a loop."""

EDGE, *EDGE_STRESSES = variables(
    r"""
edge_x | m | | µm | end of contact on the plane y = 0 | free | where the traction vanishes
edge_stress_xx | Pa | $σ_{xx}$ | MPa | surface stress along x at the edge | free |
    of contact on the plane y = 0; tension is positive
edge_stress_yy | Pa | $σ_{yy}$ | MPa | surface stress along y at the edge | free |
    of contact on the plane y = 0; tension is positive
"""
)
"""Stresses of the surface at both ends of contact, where tension along x is largest."""

CRACKS = variables(
    r"""
smith_watson_topper | Pa | $P_\mathrm{SWT}$ | MPa | Smith–Watson–Topper parameter | |
    largest normal stress of the loop times the amplitude of normal strain on the worst plane
fatemi_socie        | 1  | | 1   | Fatemi–Socie parameter | |
    amplitude of shear strain times 1 + k times the largest normal stress over the yield strength,
    on the worst plane
crossland           | Pa | | MPa | Crossland parameter | free |
    root of the second invariant of the amplitude of the deviator plus the weighed largest mean
    stress
ruiz                | Pa2 m | | | Ruiz parameter | |
    at the surface: largest tension along x times shear traction at +Q and slip
    amplitude
"""
)
"""Parameters for the initiation of cracks in a loop of stresses."""

FATIGUE = variables(
    r"""
largest_tension | Pa | | MPa | largest surface stress along x | none | at the edge of
    contact on the plane y = 0; NaN where it is singular
largest_smith_watson_topper | Pa | $P_\mathrm{SWT,max}$ | MPa |
    largest Smith–Watson–Topper parameter | | on the plane y = 0, below the surface
crack_x     | m | | µm | place of the largest parameter along x | free | where a crack is expected
crack_depth | m | | µm | depth of the largest parameter | | below the surface of the snapshot
crack_angle | degree | | | angle of the worst plane | free | from +x downwards
life        | 1 | $N_f$ | | fatigue life at the stresses of the snapshot | log |
    to a crack, in cycles; infinite where nothing is in tension
largest_damage | 1 | $D$ | 1 | largest fatigue damage of the remaining material |
    | Miner's sum since cycle 0 at fixed points of the material; 1 is a crack
crack_cycle | 1 | | | cycle of the first crack | none | by Miner's sum, also at
    points removed by wear since; NaN if there is none
fatigue_outcome | 1 | | 1 | outcome of fatigue and wear | | 0 no crack, with or without wear;
    1 wear wins: a crack would be there without it, or was worn away; 2 a crack wins
"""
)
"""What stresses over the snapshots say of cracks, dimension ``cycle``."""

FATIGUE_OUTCOMES = ("no crack", "wear wins", "crack wins")
"""Words for the values of ``fatigue_outcome``."""

FATIGUE_HEADS = (
    *("tension", "SWT", "x", "depth", "plane (°)"),
    *("life", "damage", "crack at", "outcome"),
)
"""Heads of columns for the same."""
