"""Tables of numbers as instruments, recorders and spreadsheets write them."""

import gzip

import numpy as np
import pytest

from fretwear.units import LENGTH, QuantityError
from fretwear_measured.tables import Layout, Sought, open_table

X, DEPTH = [-0.5e-3, 0.0, 1.25e-3], [1e-9, -2.5e-7, 3e-7]
WANTED = ("x", "position"), ("depth", "wear")
VOLTS = {"columns": (0, 1), "scale": ("10 mm/V", "1 um")}
UNITS, SECOND = {"units": ("mm", "um")}, {"columns": (1, "tiefe")}


@pytest.fixture
def columns(tmp_path):
    """Read position and depth, m, from the content of a file, a text or bytes."""
    sought = [Sought(LENGTH, words) for words in WANTED]
    file = tmp_path / "scar.csv"

    def read(content, **layout):
        file.write_bytes(content if isinstance(content, bytes) else content.encode())
        return open_table(file, Layout(**layout)).read(sought, "like (mm), this (um)")[1]

    return read


@pytest.mark.parametrize(
    ("text", "encoding", "layout"),
    [
        ("x (mm),depth (um)\n-0.5,0.001\n0,-0.25\n1.25,0.3\n", "utf-8", {}),
        ("x (mm);depth (µm)\n-0,5;0,001\n0;-0,25\n1,25;0,3\n", "utf-8-sig", {}),
        ("x [mm]\tdepth [nm]\n-0,5\t1,0\n0\t-250\n1,25\t300\n", "latin-1", {}),
        ("x (mm),depth (µm)\n-0.5,0.001\n0,-0.25\n1.25,0.3\n", "utf-16-be", {}),
        ("x (mm),depth (µm)\n-0.5,0.001\n0,-0.25\n1.25,0.3\n", "utf-16-le", {}),
        ("Position X (mm)\tWear depth (µm)\n-0.5\t0.001\n0\t-.25\n1.25\t3e-1\n", "utf-16", {}),
        ("x/mm   depth/um\n  -0,5   0,001\n  0   -0,25\n 1,25  0,3\n", "cp1252", {}),
        ("x_mm;depth_um\n-0.5;0.001;\n0;-0.25;\n1.25;0.3;\n", "utf-8", {}),
        ("Maker 12\nDay;3.4.20\n\nx;depth\n(mm);(um)\n-0.5;.001\n0;-.25\n1.25;.3\n", "utf-8", {}),
        (',time (s),"x (mm)","depth (um)"\n0,9,-0.5,1e-3\n1,9,0,-.25\n2,9,1.25,.3\n', "utf-8", {}),
        ('"x (mm)","depth (um)"\n"-0,5","0,001"\n"0","-0,25"\n"1,25","0,3"\n', "utf-8", {}),
        ("# By a maker\n# x (mm), depth\n-0.5 0.001\n0 -0.25\n1.25 0.3\n", "utf-8", UNITS),
        ("Nr;Weg;Tiefe\n1;-0,5;0,001\n2;0;-0,25\n3;1,25;0,3\n", "utf-8", UNITS | SECOND),
        ("1 2\n3 4\nx mm;depth um\n-0,5;0,001\n0;-0,25\n1,25;0,3\n", "utf-8", {"skip": 2}),
        # An empty cell in front: what pandas writes with its index, and a time that is left out.
        ("\tx (mm)\tdepth (um)\n0\t-0.5\t0.001\n1\t0\t-0.25\n2\t1.25\t0.3\n", "utf-8", {}),
        ("time\tx (mm)\tdepth (um)\n\t-0.5\t0.001\n\t0\t-0.25\n\t1.25\t0.3\n", "utf-8", {}),
        ("x (mV);depth\n-50;0.001\n0;-0.25\n125;0.3\n", "utf-8", VOLTS),
    ],
)
def test_position_and_depth_are_found_in_si_units(columns, text, encoding, layout):
    x, depth = columns(text.encode(encoding), **layout)
    np.testing.assert_allclose(x, X, rtol=1e-12)
    np.testing.assert_allclose(depth, DEPTH, rtol=1e-12)


@pytest.mark.parametrize(
    ("text", "layout", "sentence"),
    [
        ("x (mm),depth (um)\n-0,5,0,001\n0,5,0,25\n", {}, "4 cells in line 2, but 2 columns"),
        ("x (mm),depth (um)\n1,2\n2,3\n3,deep\n", {}, "'deep' in line 4"),
        ("x (mm);depth (nm)\n1;2\n2;3\n3;1.000,5\n", {}, "'1.000,5' in line 4"),
        ("x,depth\n1,2\n2,3\n", {}, "no unit for its column 'x'"),
        ("x (mm),depth (N)\n1,2\n2,3\n", {}, "'N' is a force"),
        ("x (mm),colour (um)\n1,2\n2,3\n", {}, "columns x and colour, not depth or wear"),
        ("x (mm),depth (um)\n1,2\n2,3\n", {"columns": (0, 7)}, "no column 7"),
        ("x (mm);depth (nm)\n1;25,000\n2;30,500\n3;1,125\n", {}, "'1,125'.*1.125 or 1125"),
        ('x (mm),depth (nm)\n1,"25,000"\n2,"30,500"\n', {}, "decimal: ',' or decimal: '.'"),
        ("x (mm),depth (um)\n1,2\n2,3\n", {"columns": (0, "width (um)")}, "no column 'width"),
        ("x (mm)\tdepth (um)\n1\t2\t3\n2\t3\t3\n", {}, "give every column a name"),
        ("nothing here\n", {}, "no table of numbers"),
        ("x (mm),depth (um)\n1,2\n2,3\n", {"skip": 9}, "skip leaves none"),
        ("x (mm),depth (um)\n1,2\n2,3\n", {"encoding": "klingon"}, "no encoding 'klingon'"),
    ],
)
def test_what_cannot_be_known_is_said_in_a_sentence(columns, text, layout, sentence):
    with pytest.raises(QuantityError, match=sentence):
        columns(text, **layout)


def test_archives_are_refused(columns):
    for content in (gzip.compress(b"x (mm),depth (um)\n1,2\n3,4\n"), b"PK\3\4" + bytes(40)):
        with pytest.raises(QuantityError, match="is an archive or a spreadsheet; unpack it"):
            columns(content)


@pytest.mark.parametrize("mark", ["-9999", "1e10", "-1.8e308", "***", ""])
def test_marks_of_missing_values_are_no_numbers(columns, mark):
    _, depth = columns(f"x (mm);depth (um)\n1;2\n2;-1\n3;{mark}\n4;{mark}\n5;3\n")
    np.testing.assert_allclose(depth, 1e-6 * np.array([2, -1, np.nan, np.nan, 3]))


@pytest.mark.parametrize(
    ("decimal", "depths"), [(",", "1;25,000\n2;1.030,500"), (".", "1;25\n2;1,030.5")]
)
def test_a_said_decimal_sign_tells_thousands_from_decimals(columns, decimal, depths):
    _, depth = columns(f"x (mm);depth (nm)\n{depths}\n", decimal=decimal)
    np.testing.assert_allclose(depth, 1e-9 * np.array([25.0, 1030.5]), rtol=1e-12)


def test_words_beside_numbers_matter_only_in_columns_that_are_used(columns):
    rows = "12:00:01;-0.5;0.001;ok\n12:00:02;0;-0.25;ok\n12:00:03;1.25;0.3;warm\n"
    text = f"clock;x (mm);depth (um);state\n{rows}"
    np.testing.assert_allclose(columns(text), [X, DEPTH], rtol=1e-12)
    with pytest.raises(QuantityError, match="no numbers in its column 'state', but 'ok' in line 2"):
        columns(text, columns=("x", "state"))
