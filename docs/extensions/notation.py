"""Quantities of the theory that no dataset has, for the table of notation."""

from fretwear.variable import variables

NOTATION = variables(
    r"""
shape | m | $h$ | | height of the surfaces | | gap without load and approach, with all wear
roughness_height | m | $h_\mathrm{r}$ | | height of the roughness | | a part of $h$
elastic_displacement | m | $u_z$ | | elastic displacement of the surface | | by the pressure
composite_modulus | Pa | $E^*$ | | composite modulus | |
shear_modulus | Pa | $G$ | | | |
tangential_modulus | Pa | $G^*$ | | composite modulus of tangential traction | |
coupling | 1 | $κ$ | | tangential over normal compliance | | $E^*/G^*$; 1 in plane strain
dundurs_parameter | 1 | $β_\mathrm{D}$ | | Dundurs' parameter of two materials | |
reduced_load | N | $P^*$ | | reduced load | | $P - Q/µ$; the contact under it is the stick zone
reduced_pressure | Pa | $p^*$ | | pressure under the reduced load | |
reduced_approach | m | $δ^*$ | | approach under the reduced load | |
reduced_gap | m | $g^*$ | | gap under the reduced load | | zero where the surfaces stick
load_ratio | 1 | $X$ | | tangential load ratio in equations | | $Q/µP$
sliding_displacement | m | $U_t$ | | displacement at which the unworn contact begins to slide | |
loop_opening | m | $U_0$ | | displacement at which the force of a loop vanishes | |
wear_growth | Pa-1 | $β$ | | wear per cycle over pressure and reduced gap | | $4 K_w µ κ$
wear_time | 1 | $τ$ | | cycles without dimension | | $β p_0 N$
"""
)
