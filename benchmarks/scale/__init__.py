"""How time and memory grow with the cells of a case and with the cases of a study."""
