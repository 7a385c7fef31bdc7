"""One symbol has one meaning: in files, figures and reports."""

from generated_reference import notation

# A symbol stands for one quantity: given or found, of one body or the other, in one law or another.
SAME = (
    {"load", "normal_force"},
    {"indentation", "approach"},
    {"tangential_load", "tangential_force", "force"},
    {"sliding_amplitude", "slip"},
    {"cycles", "cycle"},
    {"frequency"},
    {"friction", "values"},
    {"depth", "z"},
    {"tangential_displacement", "displacement"},
    {"radius", "radii"},
    {"flat_half_width", "flat_radius"},
)


def test_no_symbol_stands_for_two_quantities():
    for symbol, declared in notation().items():
        names = {name.rpartition(".")[2] for name, _ in declared}
        assert len(names) == 1 or any(names <= same for same in SAME), symbol
        assert len({about.si_unit for _, about in declared}) == 1, symbol
