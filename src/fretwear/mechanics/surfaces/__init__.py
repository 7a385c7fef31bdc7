"""The unworn bodies: indenters, roughness, measured heights, materials."""
