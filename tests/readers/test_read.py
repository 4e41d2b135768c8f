"""Closed curves of CSV and SVG files: what is read, in which unit, and what is refused with its place."""

import os
import re
import warnings
from pathlib import Path

import numpy as np
import pytest
from planar import area

from turingfold import gyrification_index, outline, read_outline, read_section
from turingfold.geometry.units import metres

BESIDE = Path(__file__).parents[3] / "shared" / "reference" / "sections"
REAL = Path(os.environ.get("BRAIN_SECTIONS", BESIDE))
SQUARE, SHIFTED = "0,0\n1,0\n1,1\n0,1\n", "3,3\n4,3\n4,4\n3,4\n"


def circle(radius, count=90):
    at = 2 * np.pi * np.arange(count) / count
    return radius * np.stack([np.cos(at), np.sin(at)])


def written(tmp_path, text, name="a.csv", encoding="utf-8"):
    file = tmp_path / name
    file.write_text(text, encoding=encoding)
    return file


def rows(points):
    return "".join(f"{x!r},{y!r}\n" for x, y in points.T.tolist())


def drawing(tmp_path, body, attributes=""):
    space = 'xmlns="http://www.w3.org/2000/svg" xmlns:inkscape="http://www.inkscape.org/namespaces/inkscape"'
    return written(tmp_path, f"<svg {space} {attributes}>{body}</svg>", "a.svg")


# columns


@pytest.mark.parametrize(
    "text",
    [
        "1,2\n3,4e0\n5,-.5\n",
        "x,y\r\n1,2\r\n3,4\r\n5,-0.5\r\n",
        "1 2\n3\t4\n5   -0.5\n",
        "# note, with 2 commas\n1;2\n3; 4 # the second\n5;-0,5\n",
        "sep=;\nx;y\n1;2\n3;4\n5;-0,5\n",
        "x\ty\n1,0\t2,0\n3,0\t4,0\n5,0\t-0,5\n",
        '"x","y"\n"1","2"\n"3","4"\n"5","-0.5"\n',
        "Umriß der Rinde\nx,y\n1,2,\n3,4,\n5,\N{MINUS SIGN}0.5,\n1,2\n",
        "% from a tracing\n1, 2\n3, 4\n5, -0.5\n\n\n",
    ],
)
@pytest.mark.parametrize("encoding", ["utf-8", "utf-8-sig", "utf-16"])
def test_columns_are_read_however_they_are_written(tmp_path, text, encoding):
    found = read_outline(written(tmp_path, text, encoding=encoding), unit=2.0)
    assert found.single().tolist() == [[2, 6, 10], [4, 8, -1]]


def test_a_header_in_latin_1_is_read(tmp_path):
    found = read_outline(written(tmp_path, "Größe x,Größe y\n" + SQUARE, encoding="latin-1"))
    assert found.single().shape == (2, 4)


@pytest.mark.parametrize(
    ("header", "unit"),
    [
        ("x (mm),y (mm)", 1e-3),
        ("x,y\nmm,mm", 1e-3),
        ("x_um,y_um", 1e-6),
        ("x [cm],y [cm]", 1e-2),
        ("x,y", 0),
        ("x (in),y (in)", 0.0254),
        ("x in,y in\nInches,Inches", 0.0254),
        ("x (CM), y (CM)", 1e-2),
        ("X / MM;Y / MM", 1e-3),
        ("Rinde in mm, links (Fall 3)", 1e-3),
        ("X position,Y position (left)", 0),
        ("# units: cm", 1e-2),
        ("# x (mm), y (mm)\nx,y", 1e-3),
        ("% all coordinates in inches", 0.0254),
        ("#x,y\n#mm,mm", 1e-3),
        ("# Units (um)", 1e-6),
        ("# in mm", 1e-3),
        ("x (left), y (up)", 0),
        ("x [-], y [-]", 0),
        ("x (1), y (1)", 0),
        ("x (RAS),y (RAS)", 0),
        ("x (raw data),y (raw data)", 0),
        ("x (section 3),y (section 3)", 0),
        ("x (in),y (out)", 0),
        ("in,out", 0),
        ("way_in,way_out", 0),
        ("label (A),label (A)", 0),
        ("x_in,y_in", 0.0254),
        ("x / in,y / in", 0.0254),
        ("x (in),y", 0.0254),
        ("in,in", 0.0254),
        ("x (mm),y (up)", 1e-3),
        ("# coordinates (cm)", 1e-2),
        ("# all points [m]", 1.0),
        ("# scale: mm", 1e-3),
        ("# scale (in)", 0.0254),
        ("# scale in mm", 1e-3),
        ("# scale is in mm", 1e-3),
        ("# the scale in the image is arbitrary", 0),
        ("# drawn to scale in Inkscape", 0),
        ("# scale: in the image", 0),
        ("x,y\n# lengths to scale in mm", 1e-3),
        ("# units are in mm", 1e-3),
        ("# coordinates after rigid alignment (in)", 0),
        ("# points (in)", 0.0254),
        ("x (mm),y (mm)\n# pixel spacing 0.1 mm", 1e-3),
        ("# units: mm\n# traced at resolution 0.05 mm", 1e-3),
        ("Traced in Fiji at 0.1 mm per pixel\nx (mm),y (mm)", 1e-3),
        ("# mm units", 1e-3),
        ("xmm,ymm", 1e-3),
        ("xin,yin", 0.0254),
        ("x{mm},y{mm}", 1e-3),
        ("x <cm>,y <cm>", 1e-2),
        ("# units: cm\n# sampled every mm", 1e-2),
        ("Outline smoothed by 2 mm", 0),
        ("# scale bar 5 mm", 0),
        ("# seen in the microscope (10x), unit tests passed, smoothed by 2 mm", 0),
    ],
)
def test_the_unit_is_that_of_the_header(tmp_path, header, unit):
    found = read_outline(written(tmp_path, f"{header}\n{SQUARE}"))
    assert found.unit == (unit or None)
    assert np.ptp(found.single(), axis=1) == pytest.approx(unit or 1.0)


@pytest.mark.parametrize(
    ("header", "word"),
    [
        ("x (furlong),y (furlong)", "furlong"),
        ("x_px,y_px", "px"),
        ("x,y\nvoxels,voxels", "voxels"),
        ("# units: arbitrary", "arbitrary"),
        ("# x [dm], y [dm]", "dm"),
        ("x [dm],y (up)", "dm"),
        ("x (in mm),y (in mm)", "in mm"),
        ("x (1/mm),y (1/mm)", "1/mm"),
        ("x (0.1 mm),y (0.1 mm)", "0.1 mm"),
        ("x [%],y [%]", "%"),
        ("# 1 unit = 0.05 mm", "0.05 mm"),
        ("# 1 px = 0.05 mm", "0.05 mm"),
        ("# pixel spacing 0.1 mm, traced by hand", "0.1 mm"),
        ("# 0.1 mm / pixel", "0.1 mm"),
        ("Traced in Fiji, pixel spacing 0.1 mm\nx,y", "0.1 mm"),
        ("# all points in mm\n# pixel spacing 0.1 mm", "0.1 mm"),
        ("x_px,y_px\n# 1 px = 0.1 mm", "px"),
        ("# units: in Inkscape", "Inkscape"),
    ],
)
def test_a_unit_that_is_not_known_is_refused_unless_one_is_given(tmp_path, header, word):
    file = written(tmp_path, f"{header}\n{SQUARE}")
    with pytest.raises(ValueError, match=rf"a\.csv: .* states the unit '{word}'; known are m, cm, mm.*unit="):
        read_outline(file)
    assert np.ptp(read_outline(file, unit=1e-4).single(), axis=1) == pytest.approx(1e-4)


@pytest.mark.parametrize(
    ("header", "word"),
    [
        ("# sampled every mm", "mm"),
        ("# Outline of slice 3, mm", "mm"),
        ("# pixel coordinates", "pixel"),
        ("mm_x,mm_y", "mm"),
        ("pixel x,pixel y", "pixel"),
    ],
)
def test_a_unit_in_passing_is_refused_unless_one_is_given(tmp_path, header, word):
    file = written(tmp_path, f"{header}\n{SQUARE}")
    with pytest.raises(ValueError, match=rf"a\.csv: .* mentions '{word}', .*give unit="):
        read_outline(file)
    assert np.ptp(read_outline(file, unit="cm").single(), axis=1) == pytest.approx(1e-2)


CORNER = np.array([[0.0, 4.0, 4.0], [0.0, 0.0, 3.0]])  # of right angles, 4 across and 3 up


@pytest.mark.parametrize(
    ("header", "columns"),
    [
        ("x,y", (CORNER[0], CORNER[1])),
        ("y,x", (CORNER[1], CORNER[0])),
        ("y;x", (CORNER[1], CORNER[0])),
        ("Y position;X position", (CORNER[1], CORNER[0])),
        ("# y, x", (CORNER[1], CORNER[0])),
        ("# columns: Y X", (CORNER[1], CORNER[0])),
        ("row,col", (-CORNER[1], CORNER[0])),
        ("# row col", (-CORNER[1], CORNER[0])),
        ("column,row", (CORNER[0], -CORNER[1])),
        ("x,z", (CORNER[0], CORNER[1])),
        ("y,z", (CORNER[0], CORNER[1])),
        ("x_row,y_row", (CORNER[0], CORNER[1])),
        ("x1,x2", (CORNER[0], CORNER[1])),
        ("# y is upward, x to the right", (CORNER[0], CORNER[1])),
        ("y (mm),x (mm)", (1e3 * CORNER[1], 1e3 * CORNER[0])),
        ("ymm,xmm", (1e3 * CORNER[1], 1e3 * CORNER[0])),
    ],
)
@pytest.mark.filterwarnings("error")
def test_columns_are_those_that_their_names_say(tmp_path, header, columns):
    """Rows of an image are counted from its top."""
    numbers = "".join(f"{a:g};{b:g}\n" for a, b in zip(*columns, strict=True))
    assert read_outline(written(tmp_path, f"{header}\n{numbers}")).single() == pytest.approx(CORNER)


@pytest.mark.parametrize(
    ("header", "message"),
    [
        ("y,row", r"a\.csv: the columns are named 'y,row', which does not tell which"),
        ("z,y", "'z,y', which does not tell which"),
        ("x,x", "'x,x', which does not tell which"),
        ("# y, x\n# x, y", r"a\.csv: it names its columns in several orders, 'y, x' and 'x, y'"),
        ("rl,si", r"a\.csv: the columns are named 'rl,si', which does not tell whether they count"),
        ("# dv, ml", "'dv, ml', which does not tell whether"),
    ],
)
def test_columns_of_which_the_order_cannot_be_told_are_refused(tmp_path, header, message):
    with pytest.raises(ValueError, match=message):
        read_outline(written(tmp_path, f"{header}\n{SQUARE}"))


@pytest.mark.parametrize(
    ("text", "warns"), [("x,y\n# row, column", True), ("# y, x\nx,y", True), ("x,y\n# row, y", False)]
)
def test_a_header_counts_before_comments_that_name_other_columns(tmp_path, text, warns):
    numbers = "".join(f"{a:g},{b:g}\n" for a, b in CORNER.T)
    with warnings.catch_warnings(record=True) as told:
        warnings.simplefilter("always")
        assert read_outline(written(tmp_path, f"{text}\n{numbers}")).single() == pytest.approx(CORNER)
    assert [each.filename for each in told] == [__file__] * warns
    assert all("its header 'x,y', which counts" in str(each.message) for each in told)


def test_numbers_as_large_as_millimetres_are_pointed_out(tmp_path):
    file = written(tmp_path, rows(circle(40.0)))
    with pytest.warns(UserWarning, match=r'a\.csv is 80 by 79.* if they are mm, give unit="mm"'):
        read_outline(file)
    assert area(read_outline(file, unit="mm").single()) == pytest.approx(np.pi * 0.04**2, rel=1e-3)


@pytest.mark.parametrize("between", ["\n", "nan,nan\n", ",\n", "\nx,y\n", "\n# inner\n"])
def test_rows_without_a_point_begin_a_new_curve(tmp_path, between):
    outer, inner = circle(1.0), circle(0.8)[:, ::-1]
    found = read_outline(written(tmp_path, rows(outer) + between + rows(inner)))
    assert [loop.shape for loop in found.loops] == [(2, 90), (2, 90)]
    assert found.loops[0] == pytest.approx(outer)
    assert gyrification_index(found.loops[0]) == pytest.approx(1.0, abs=0.01)
    with pytest.raises(ValueError, match=r"holds 2 closed curves .* wanted: 0 \(3\.14\), 1 \(2\.01\)"):
        found.single()


@pytest.mark.parametrize("closed", [True, False])
def test_two_curves_joined_to_one_are_refused(tmp_path, closed):
    loops = circle(1.0), circle(0.5)
    if closed:
        loops = tuple(np.concatenate([loop, loop[:, :1]], axis=1) for loop in loops)
    file = written(tmp_path, "x,y\n" + "".join(map(rows, loops)))
    second = 2 + loops[0].shape[1]
    with pytest.raises(ValueError, match=rf"lines 2 and {second}: closed curves begin here"):
        read_outline(file)


def test_a_long_straight_base_is_no_second_curve(tmp_path):
    half = circle(1.0, 200)[:, :101]
    for turn in (0, 30, 60):
        points = np.roll(half, turn, axis=1)
        assert read_outline(written(tmp_path, rows(points))).single() == pytest.approx(points)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("0.03O,0.0\n" + SQUARE, r"line 1: '0\.03O,0\.0' is not two numbers"),
        ("x,y\nO.03,0.0\n" + SQUARE, r"line 2: 'O\.03,0\.0' is not two numbers"),
        ("x,y\n1,2\n3,four\n", "line 3: '3,four' is not two numbers"),
        ("x,y\n1,2\nx,y\n3,4\n", "line 3: 'x,y' is not two numbers"),
        ("x,y\n1,2,3\n", "line 2: '1,2,3' is not two numbers"),
        ("x,y\n0,5,1,5\n", "line 2: '0,5,1,5' has 4 fields; if commas are decimal signs"),
        ("x;y\n0,5;1.5\n", "line 2: '0,5;1.5' is not two numbers"),
        ("x,y\n", "no points"),
        ("", "no points"),
        ("x,y\n1,2\nnan,3\n", "line 3: 'nan,3' is not finite; leave that point out"),
        ("1,2\n1,-inf\n", "line 2: '1,-inf' is not finite"),
        ("1,2\n\n3,4\n\n5,6\n", r"line 1: a curve of 1 point.*Blank rows begin a new curve"),
        ("x (mm),y (cm)\n1,2\n", "several units of length, mm, cm"),
        ("# units: mm\nx (cm),y (cm)\n1,2\n", "several units"),
    ],
)
def test_wrong_columns_are_refused_by_line(tmp_path, text, message):
    with pytest.raises(ValueError, match=message):
        read_outline(written(tmp_path, text))


@pytest.mark.parametrize("content", [b"1,2\n\x00\x01", b"\xff\xfe1"])
def test_what_is_no_text_is_refused(tmp_path, content):
    (tmp_path / "a.csv").write_bytes(content)
    with pytest.raises(ValueError, match=r"a\.csv is no text"):
        read_outline(tmp_path / "a.csv")


# drawings


def test_a_bezier_circle_is_a_circle(tmp_path):
    k = 4 * (np.sqrt(2) - 1) / 3  # the usual handle length; its radius is at most 2.8e-4 too large
    body = (
        f'<path id="brain" d="M1,0 C1,{k} {k},1 0,1 S-1,{k} -1,0 c0,{-k} {1 - k},-1 1,-1 s1,{1 - k} 1,1 z"/>'
        '<polygon id="other" points="0,0 1,0 1,1"/>'
    )
    points = read_outline(drawing(tmp_path, body), name="brain").single()
    assert np.hypot(*points) == pytest.approx(1.0, abs=3e-4)
    assert np.hypot(*points).max() > 1.0002
    assert points[:, 6][1] < 0  # y points upward


def test_straight_and_quadratic_path_commands(tmp_path):
    box, line = read_outline(drawing(tmp_path, "<path d='m1 1h2v2 H1 V1z M 0 0 L .5.5-1 2'/>")).loops
    assert box.tolist() == [[1, 3, 3, 1], [-1, -1, -3, -3]]
    assert line.tolist() == [[0, 0.5, -1], [0, -0.5, -2]]
    x, y = read_outline(drawing(tmp_path, "<path d='M0 0 Q1 2 2 0 T4 0'/>"), samples=4).single()
    assert x == pytest.approx(np.linspace(0, 4, 9))
    assert -y == pytest.approx(np.array([0, 0.75, 1, 0.75, 0, -0.75, -1, -0.75, 0]))


@pytest.mark.parametrize(
    ("shape", "exact"),
    [
        ('<circle cx="7" r="3"/>', 9 * np.pi),
        ('<ellipse cx="1" cy="2" rx="3" ry="2"/>', 6 * np.pi),
        ('<rect x="1" y="2" width="3" height="2"/>', 6.0),
        ('<polygon points="0,0 4,0 4,3"/>', 6.0),
        ('<polyline points="0 0 4 0 4 3"/>', 6.0),
        ('<path d="M3 0A3 3 0 0 1-3 0A3 3 0 013 0"/>', 9 * np.pi),
        ('<path d="M0 0A3 2 0 0 1 6 0z"/>', 3 * np.pi),
    ],
)
@pytest.mark.parametrize(
    ("around", "factor"),
    [
        ("{}", 1.0),
        ('<g transform="translate(5,2) rotate(30)"><g transform="scale(2,-3)">{}</g></g>', 6.0),
        ('<g style="fill:none;transform:matrix(1,0,0.7,2,0,0)">{}</g>', 2.0),
        ('<svg x="1" width="50" height="50" viewBox="-8 -8 25 25">{}</svg>', 4.0),
    ],
)
def test_shapes_have_their_areas_in_all_transforms(tmp_path, shape, exact, around, factor):
    found = read_outline(drawing(tmp_path, around.format(shape)), unit=1e-2).single()
    assert abs(area(found)) == pytest.approx(1e-4 * factor * exact, rel=1.5e-3)


def test_a_path_closed_by_a_long_straight_segment_is_closed(tmp_path):
    turns = np.linspace(0.0, np.pi, 101)  # half a disc: Z, its base, is 64 times as long as the others
    arc = " ".join(f"L {np.cos(t):.9f} {np.sin(t):.9f}" for t in turns[1:])
    loops = read_outline(drawing(tmp_path, f"<path d='M 1 0 {arc} Z'/>"), unit=1.0)
    body = outline(loops.single(), thickness=0.2, size=0.1)
    assert area(body.nodes[:, body.pial]) == pytest.approx(np.pi / 2, rel=1e-2)


def test_places_follow_transforms_and_the_viewbox(tmp_path):
    """It spans 2 to 4 in x and 1 to 2 in y, is moved by 10 and doubled; a unit of the viewBox is 0.5 mm."""
    body = '<rect x="2" y="1" width="2" height="1" style="transform:translate(10px,0)"/>'
    body = f'<g transform="scale(2)">{body}</g>'
    found = read_outline(drawing(tmp_path, body, 'width="80mm" height="40mm" viewBox="0 0 160 80"'))
    assert found.unit == 1.0
    (left, bottom), (right, top) = found.single().min(1), found.single().max(1)
    assert [left, bottom, right, top] == pytest.approx([12e-3, -2e-3, 14e-3, -1e-3], rel=1e-12)


def test_an_outline_without_a_physical_width_has_the_numbers_of_its_viewbox(tmp_path):
    body = '<rect x="2" y="1" width="3" height="1"/>'
    found = read_outline(drawing(tmp_path, body, 'width="1000" height="500" viewBox="0 0 10 5"'))
    assert found.unit is None
    assert np.ptp(found.single(), axis=1).tolist() == [3.0, 1.0]


def test_every_part_of_a_compound_path_is_a_curve(tmp_path):
    """After Z the pen is back at the start, so that "l" and "m" go on from there."""
    found = read_outline(drawing(tmp_path, '<path id="p" d="M1 1h8v8h-8z m2 2h2v2h-2z l9 0v1z"/>'), unit=1)
    assert found.names == ("p", "p", "p")
    assert [abs(area(loop)) for loop in found.loops] == [64.0, 4.0, 4.5]
    assert found.loops[2][:, 0].tolist() == [3.0, -3.0]


def test_shapes_of_one_name_are_all_kept(tmp_path):
    body = (
        '<rect id="a" width="1" height="1"/><rect id="a" width="2" height="1"/>'
        '<g inkscape:label="pial"><rect id="b" width="3" height="1"/><rect width="4" height="1"/></g>'
        '<rect id="c" inkscape:label="white" width="5" height="1"/>'
    )
    file = drawing(tmp_path, body)

    def areas(name):
        return [abs(area(loop)) for loop in read_outline(file, name=name).loops]

    assert areas("a") == [1, 2]
    assert areas("pial") == [3, 4]
    assert areas("white") == areas("c") == [5]
    assert areas("") == [1, 2, 3, 4, 5]
    with pytest.raises(ValueError, match=r"no outline is called 'pia', names are a, b, c, pial, white"):
        read_outline(file, name="pia")


@pytest.mark.parametrize(
    ("body", "message"),
    [
        ("<path d='M0 0L1 1 2'/>", r"a\.svg: path: path command 'L' has '1 1 2'"),
        ("<path id='p' d='M0 0A1 1 0 2 0 1 1'/>", "path p: path command 'A'"),
        ("<path d='M0 0L1 1 nan 2'/>", "there is no path command 'n'"),
        ("<path d='L0 1 2 3'/>", "begins with 'L'"),
        ("<path d='0 1 2 3'/>", "begins with '0 1 2 3'"),
        ("<path d=''/>", "no shape with at least 3 points"),
        ("<polygon points='1 2 3'/>", "pairs"),
        ("<polygon points='1 2 3x 4'/>", "pairs"),
        ("<g transform='scle(2)'><rect width='1' height='1'/></g>", r"transform 'scle\(2\)' is not one"),
        ("<image href='a.png'/>", "no shape"),
        ("<path d='M 0 0'", "not well-formed"),
    ],
)
def test_wrong_drawings_are_refused(tmp_path, body, message):
    with pytest.raises(ValueError, match=message):
        read_outline(drawing(tmp_path, body))


def test_what_is_no_drawing_is_refused(tmp_path):
    with pytest.raises(ValueError, match=r"a\.svg is no SVG: its outermost element is 'html'"):
        read_outline(written(tmp_path, "<html/>", "a.svg"))


# files


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"path": None}, "path=None must be the path of a CSV or SVG file"),
        ({"path": "brain.csv"}, r"no file brain\.csv"),
        ({"unit": "furlong"}, "unit='furlong' must be one of m, "),
        ({"unit": "px"}, "unit='px' must be one of m, "),
        ({"unit": 0}, "unit=0 must be positive"),
        ({"name": "brain"}, r"curves of a\.csv have no names"),
    ],
)
def test_wrong_arguments_are_named(tmp_path, options, message):
    with pytest.raises(ValueError, match=message):
        read_outline(**({"path": written(tmp_path, SQUARE)} | options))


@pytest.mark.parametrize(
    ("file", "unit", "times"),
    [
        ("x (mm),y (mm)\n" + SQUARE, "cm", 10),
        ("# units: um\n" + SQUARE, 1e-4, 100),
        (
            "<svg xmlns='http://www.w3.org/2000/svg' width='4cm' viewBox='0 0 20 20'><circle r='5'/></svg>",
            "mm",
            0.5,
        ),
    ],
)  # fmt: skip
def test_a_unit_that_is_not_what_the_file_states_is_told(tmp_path, file, unit, times, recwarn):
    path = written(tmp_path, file, "a.svg" if "svg" in file else "a.csv")
    right = read_outline(path)
    assert read_outline(path, unit=metres(unit) / times).unit == pytest.approx(metres(unit) / times)
    assert not recwarn.list
    with pytest.warns(UserWarning, match=rf"{path.name} states .* unit={unit!r} .* {times:g} times") as told:
        found = read_outline(path, unit=unit)
    assert len(told) == 1
    assert "test_read" in told[0].filename
    assert np.ptp(found.loops[0], axis=1) == pytest.approx(times * np.ptp(right.loops[0], axis=1), rel=1e-3)


def test_a_unit_is_not_compared_where_the_file_states_none_or_the_width_is_given(tmp_path, recwarn):
    read_outline(written(tmp_path, "x,y\n" + SQUARE), unit="mm")
    read_outline(written(tmp_path, "# sampled every mm\n" + SQUARE), unit="cm")
    read_section(written(tmp_path, "x (mm),y (mm)\n" + SQUARE), width=0.1)
    assert not recwarn.list


def test_other_files_are_refused(tmp_path):
    with pytest.raises(ValueError, match=r"'\.png'; outlines are read from"):
        read_outline(written(tmp_path, "", "a.png"))


@pytest.mark.skipif(not REAL.is_dir(), reason="the folder BRAIN_SECTIONS of real sections is not here")
def test_real_sections_are_read_as_they_are():
    files = sorted(REAL.glob("*.csv"))
    assert len(files) > 20
    for file in files:
        text = file.read_text(encoding="utf-8")
        numbers = np.array(re.findall(r"-?\d+\.\d+", text), dtype=float).reshape(-1, 2).T
        assert read_outline(file, unit="mm").single() == pytest.approx(1e-3 * numbers)


@pytest.mark.parametrize("factor", [0.1, 100.0])
def test_a_point_far_from_both_its_neighbours_is_named_by_its_row(tmp_path, factor):
    points = circle(30e-3, 180)
    assert read_outline(written(tmp_path, rows(points))).loops[0].shape == (2, 180)  # nothing is said
    points[0, 7] *= factor
    with pytest.warns(UserWarning, match=r"a\.csv, line 8: .* as far from both its neighbours") as told:
        read_outline(written(tmp_path, rows(points)))
    assert len(told) == 1  # that it is large is no matter of units
