"""Which shapes of a drawing one sees, where, and how large: right values by hand from SVG 2 and CSS."""

import numpy as np
import pytest
from planar import area

from turingfold import read_outline

SEVEN = '<rect width="7" height="7"/>'


def drawing(tmp_path, body, attributes=""):
    file = tmp_path / "a.svg"
    file.write_text(f'<svg xmlns="http://www.w3.org/2000/svg" {attributes}>{body}</svg>')
    return file


def box_of(points):
    """Return left, top, right, bottom of points (2, n), with y downward as in the drawing."""
    (left, low), (right, high) = points.min(1), points.max(1)
    return [left, -high, right, -low]


@pytest.mark.parametrize(
    ("attributes", "box"),
    [
        ('width="100mm" viewBox="0 0 100 50"', [10, 10, 90, 40]),
        ('height="5cm" viewBox="0 0 100 50"', [10, 10, 90, 40]),
        ('width="auto" height="50MM" viewBox="0 0 100 50"', [10, 10, 90, 40]),
        ('style="width:100mm" width="7mm" viewBox="0,0,100,50"', [10, 10, 90, 40]),
        ('width="100mm" height="100mm" viewBox="0 0 100 50"', [10, 35, 90, 65]),
        (
            'width="100mm" height="100mm" viewBox="0 0 100 50" preserveAspectRatio="xMinYMax"',
            [10, 60, 90, 90],
        ),
        ('width="100mm" height="100mm" viewBox="0 0 100 50" preserveAspectRatio="none"', [10, 20, 90, 80]),
        (
            'width="100mm" height="100mm" viewBox="0 0 100 50" preserveAspectRatio="xMidYMid slice"',
            [-30, 20, 130, 80],
        ),
        ('width="200mm" height="100mm" viewBox="50 10 100 50"', [-80, 0, 80, 60]),
        ('width="101.6mm" height="192" viewBox="0 0 100 50"', [10.16, 10.16, 91.44, 40.64]),
        ('width="100mm"', [10 / 96 * 25.4, 10 / 96 * 25.4, 90 / 96 * 25.4, 40 / 96 * 25.4]),
    ],
)
def test_a_drawing_is_laid_into_its_width_and_height(tmp_path, attributes, box):
    """By hand: 80 by 30 units at (10, 10), scaled by the smaller (slice: larger) ratio; the rest is shared.

    192 px are 2 in, 50.8 mm, so that a unit is 1.016 mm; without a viewBox it is 1/96 in.
    """
    found = read_outline(drawing(tmp_path, '<path d="M10 10H90V40H10Z"/>', attributes))
    assert box_of(1e3 * found.single()) == pytest.approx(box, abs=1e-9)
    assert found.unit == 1.0


@pytest.mark.parametrize(
    ("attributes", "message"),
    [
        ('width="100mm" height="100%" viewBox="0 0 1 1"', "svg: height='100%' gives the drawing no size"),
        ('width="0mm" viewBox="0 0 1 1"', "width='0mm' gives the drawing no size"),
        ('width="90mm" viewBox="0 0 1"', "viewBox='0 0 1' must be four numbers"),
        ('width="90mm" viewBox="0 0 1 0"', "viewBox='0 0 1 0' has no size"),
        ('width="90mm" viewBox="0 0 1 1" preserveAspectRatio="middle"', "preserveAspectRatio='middle'"),
    ],
)
def test_a_drawing_without_a_size_is_refused_unless_a_unit_is_given(tmp_path, attributes, message):
    body = '<rect width="2" height="1"/>'
    with pytest.raises(ValueError, match=message):
        read_outline(drawing(tmp_path, body, attributes))
    plain = drawing(tmp_path, body, 'width="100%" height="100%" viewBox="0 0 4 4"')
    assert read_outline(plain).unit is None
    assert np.ptp(read_outline(plain, unit="mm").single(), axis=1) == pytest.approx([2e-3, 1e-3])


@pytest.mark.parametrize(
    "hidden",
    [
        "<defs>{}</defs>",
        '<g display="none"><g display="inline">{}</g></g>',
        '<g style="display: none !important" display="inline">{}</g>',
        '<style>.a, #b {{ display: none }}</style><g class="c a">{}</g><g id="b">{}</g>',
        '<style media="print">g {{display:inline}}</style><g display="none">{}</g>',
        '<style>g.a{{visibility:hidden}}</style><g class="a">{}</g>',
        '<g visibility="hidden">{}</g>',
        '<g style="visibility:collapse">{}</g>',
        "<symbol>{}</symbol>",
        "<marker>{}</marker>",
        "<mask>{}</mask>",
        "<clipPath>{}</clipPath>",
        "<pattern>{}</pattern>",
        "<switch><g><rect width='0' height='1'/></g><g>{}</g></switch>",
        '<switch><g systemLanguage="fr, de-CH">{}</g><text>brain</text></switch>',
        '<switch><g requiredExtensions="http://ns.adobe.com/x/1">{}</g></switch>',
        '<x xmlns="http://www.example.org">{}</x>',
        '<use display="none" href="#seen"/>',
        '<mask id="m">{}</mask><use href="#m"/>',
    ],
)
def test_what_is_not_shown_is_not_read(tmp_path, hidden):
    """By the chapters on structure, rendering and linking of SVG 2; the square of 9 is all that one sees."""
    body = '<rect id="seen" width="9" height="9"/><text>10,10</text>'
    for text in (
        hidden.format(SEVEN, SEVEN) + body,
        body + hidden.format(SEVEN, SEVEN),
    ):
        assert [abs(area(loop)) for loop in read_outline(drawing(tmp_path, text)).loops] == [81]


@pytest.mark.parametrize(
    "shown",
    [
        '<g visibility="hidden"><rect width="9" height="9" visibility="visible"/></g>',
        '<switch><g systemLanguage="fr"/><g systemLanguage="en-GB"><rect width="9" height="9"/></g></switch>',
        '<a href="#"><rect width="9" height="9"/></a>',
        '<clipPath><path id="p" d="M0 0H9V9H0Z"/></clipPath><use href="#p" x="2"/>',
        '<defs><g id="d"><rect width="9" height="9"/></g></defs><use href="#d"/>',
        '<style>g{display:none} #g{display:inline}</style><g id="g"><rect width="9" height="9"/></g>',
        '<style>#r {width: 9px; height: 9px} rect {width: 5px}</style><rect id="r"/>',
        '<rect style="width:9px" width="3" height="9"/>',
        '<rect width="50%" height="90%"/>',
    ],
)
def test_what_is_shown_is_read(tmp_path, shown):
    found = read_outline(drawing(tmp_path, shown, 'viewBox="0 0 18 10"')).single()
    assert abs(area(found)) == pytest.approx(81, rel=1e-12)


@pytest.mark.parametrize(
    ("body", "holds", "cuts", "shape"),
    [
        ('<svg x="10" y="20" width="@" height="20"!><circle id="c" cx="20" cy="10" r="8"/></svg>',
         "28", "27.9", "svg hides .* circle c"),
        ('<symbol id="s" viewBox="0 0 10 10"!><circle id="c" cx="5" cy="5" r="@"/></symbol>'
         '<use href="#s" width="20" height="20" transform="rotate(30)"/>',
         "5", "5.01", "symbol s hides .* circle c"),
        ('<g transform="scale(2 1)"><svg width="10" height="20" viewBox="0 0 10 10"!'
         ' preserveAspectRatio="xMinYMid slice"><rect id="c" y="3" width="@" height="4"/></svg></g>',
         "5", "5.1", "svg hides .* rect c"),
    ],
)  # fmt: skip
def test_what_an_inner_viewport_hides_is_refused(tmp_path, body, holds, cuts, shape):
    def read(number, overflow=""):
        text = body.replace("@", number).replace("!", overflow)
        return read_outline(drawing(tmp_path, text, 'viewBox="0 0 200 100"'), unit="mm")

    read(holds)
    for hidden in ("", ' overflow="hidden"', ' overflow="visible" style="overflow:scroll"'):
        with pytest.raises(ValueError, match=f"{shape} reaches there"):
            read(cuts, hidden)
    for shown in (' overflow="visible"', ' style="overflow: visible"'):
        read(cuts, shown)


@pytest.mark.parametrize(
    ("body", "box"),
    [
        ('<rect width="9" height="9" transform="scale(2)" transform-origin="10 10"/>', [-10, -10, 8, 8]),
        ('<rect width="9" height="9" style="transform:scale(2);transform-origin:right"/>',
         [-200, -50, -182, -32]),
        ('<rect width="9" height="9" transform="rotate(90)" transform-origin="25% 40%"/>', [81, -10, 90, -1]),
        ('<g transform="translate(5 1)"><rect width="4" height="2" style="transform:scaleX(-1)"/></g>',
         [1, 1, 5, 3]),
        ('<rect width="4" height="2" style="transform: translate(10%, 1px) rotate(0.25turn)"/>',
         [18, 1, 20, 5]),
        ('<symbol id="s" viewBox="0 0 10 10"><rect x="1" width="8" height="5"/></symbol>'
         '<use href="#s" x="100" y="10" width="40" height="20"/>', [112, 10, 128, 20]),
        ('<symbol id="s" viewBox="0 0 9 8" preserveAspectRatio="none"><rect width="50%" height="4"/></symbol>'
         '<use href="#s" width="40" height="20" transform="scale(2)"/>', [0, 0, 40, 20]),
        ('<symbol id="s" width="20" height="20" viewBox="0 0 10 10"><rect width="4" height="5"/></symbol>'
         '<use href="#s" y="3"/>', [0, 3, 8, 13]),
        ('<svg x="10" y="20"><rect width="4" height="5"/></svg>', [10, 20, 14, 25]),
        ('<svg x="10" y="20" width="20" height="5" viewBox="0 0 1 1"><rect width="1" height="1"/></svg>',
         [17.5, 20, 22.5, 25]),
    ],
)  # fmt: skip
def test_shapes_are_where_one_sees_them(tmp_path, body, box):
    """By hand, in a viewBox of 200 by 100; SVG 2 on coordinate systems, CSS on transforms."""
    points = read_outline(drawing(tmp_path, body, 'viewBox="0 0 200 100"'), unit=1e-3).single()
    assert box_of(1e3 * points) == pytest.approx(box, abs=1e-9)


@pytest.mark.parametrize(
    ("body", "message"),
    [
        (
            "<rect width='1' height='1' style='transform:scale(2);transform-box:fill-box'/>",
            "transform-box='fill-box'",
        ),
        (
            "<rect width='1' height='1' style='scale:2'/>",
            "style of rect has the property scale, which is not read",
        ),
        (
            "<style>g > rect { display: none }</style>",
            "gives display to 'g > rect'; only kinds, ids and classes",
        ),
        ("<style>@media print { rect {visibility:hidden} }</style>", "gives visibility to '@media rect'"),
        ("<rect width='1em' height='1'/>", "rect: width='1em' is no length; known units are px, mm"),
        ("<rect width='50%' height='1'/>", "width='50%' is a share of a window whose size no file states"),
        ("<circle r='-2'/>", "circle: r='-2' is negative"),
        ("<use href='b.svg#x'/>", "use shows 'b.svg#x', which is not in this file"),
        ("<g id='g'><use href='#g'/></g>", "use shows itself"),
        (
            "<clipPath id='c'/><circle id='b' r='2' clip-path='url(#c)'/>",
            r"circle b has clip-path='url\(#c\)'.*Cut the shape itself",
        ),
        ("<g id='g' style='mask: url(#m)'><g><circle r='2'/></g></g>", r"g g has mask='url\(#m\)'"),
        (
            "<style>.in { clip-path: circle(1px) }</style><rect class='in' width='2' height='2'/>",
            "rect has clip",
        ),
        ("<foreignObject><svg><path d='M0 0'/></svg></foreignObject>", "foreignObject holds shapes"),
    ],
)
def test_what_cannot_be_placed_is_refused_by_name(tmp_path, body, message):
    with pytest.raises(ValueError, match=message):
        read_outline(drawing(tmp_path, body + SEVEN))


def test_only_shapes_that_are_asked_for_must_be_whole(tmp_path):
    body = '<circle id="a" r="9" clip-path="url(#c)"/><rect id="b" width="7" height="7" mask="none"/>'
    assert abs(area(read_outline(drawing(tmp_path, body), name="b").single())) == pytest.approx(49)


CORNERS = np.array([[10, 20, 20, 15, 15, 10], [10, 10, 20, 25, 40, 40]])


@pytest.mark.parametrize(
    "shape",
    [
        '<path d="M 10 10 L 20 10 L 20 20 L 15 25 V 40. H 10 Z"/>',
        '<path d="M 10. 10. L 20. 10. L 2.e1 20 L 15 25 L 15,4.e+1,10. 40. Z"/>',
        '<path d="m10 10 10 0 0 10-5. 5.v15.h-5z"/>',
        '<polygon points="10,10 20,10 20,20 15,25 15,40.,10,40"/>',
        '<polygon points="1.e1,10. 20.,10,20 20 15,25. 15,4.e1 10,40"/>',
    ],
)
def test_numbers_that_end_in_a_point_are_read(tmp_path, shape):
    """SVG 1.1 allows "40." and "4.e1"; the corners are those that the same numbers without the point give."""
    found = 1e3 * read_outline(drawing(tmp_path, shape), unit=1e-3).single()
    assert found[:, :6] == pytest.approx(CORNERS * [[1], [-1]])
    assert abs(area(found)) == pytest.approx(212.5)


@pytest.mark.parametrize(
    ("curves", "out"),
    [
        ("q 5 5 10 0 s 10 -5 10 0", 15 - 50 / 3),
        ("q 5 5 10 0 S 30 5 30 10", 15 - 50 / 3),
        ("t 10 0 s 10 -5 10 0", 15),
        ("c 0 5 10 5 10 0 t 10 0", -30),
        ("h 10 t 10 0", 0),
        ("c 0 5 10 5 10 0 s 10 -5 10 0", 0),
        ("q 5 5 10 0 t 10 0", 0),
        ("q 5 5 10 0 T 30 10", 0),
        ("l 10 0 q 5 5 10 0", -50 / 3),
        ("a 5. 5 0 0110 0 t 10 0", 12.5 * np.pi),
    ],
)
def test_only_a_curve_of_its_kind_gives_a_smooth_one_its_control_point(tmp_path, curves, out):
    """By hand, from SVG 2, 9.3.6: else the first control point of S and T is where they begin.

    y dx of q 5 5 10 0 is 2/3 of the triangle of its points, 50/3; of c 0 5 10 5 10 0 30; of c 0 0 10 -5 10 0
    15 the other way; reflected curves undo the one before. The rest of the shape is a square of 20 by 20.
    """
    file = drawing(tmp_path, f'<path d="M 10 10 {curves} v 20 h -20 z"/>')
    found = 1e3 * read_outline(file, unit=1e-3, samples=400).single()
    assert abs(area(found)) == pytest.approx(400 + out, abs=1e-3)


@pytest.mark.parametrize(
    ("transform", "box"),
    [
        ("scale(50%)", [5, 10, 15, 15]),
        ("SCALE(2., 1.e0)", [20, 20, 60, 30]),
        ("skew(45)", [30, 20, 60, 30]),
        ("skew(0 45deg)", [10, 30, 30, 60]),
        ("skewY(0.125turn)", [10, 30, 30, 60]),
        ("rotate(100grad 10px 20)", [0, 20, 10, 40]),
        ("translate(10% 1in),rotate(-90)", [40, 66, 50, 86]),
        ("translate(25.4mm, 0) matrix(1 0 0 -1. 0 0)", [106, -30, 126, -20]),
        ("translateY(2.54cm)translateX(1pc) scale(2 1)", [36, 116, 76, 126]),
    ],
)
def test_every_function_of_a_transform_is_read(tmp_path, transform, box):
    """By hand for x from 10 to 30 and y from 20 to 30 in a viewBox of 200 by 100; an inch is 96 units."""
    body = f'<rect x="10" y="20" width="20" height="10" transform="{transform}"/>'
    points = read_outline(drawing(tmp_path, body, 'viewBox="0 0 200 100"'), unit=1e-3).single()
    assert box_of(1e3 * points) == pytest.approx(box, abs=1e-9)


@pytest.mark.parametrize(
    "transform",
    ["rotate(50%)", "rotate(9 1)", "scale(2px)", "matrix(1 2 3)", "skew(1 2 3)", "turn(3) scale(2)"],
)
def test_a_transform_that_is_none_is_refused(tmp_path, transform):
    with pytest.raises(ValueError, match=r"rect: the transform .* is not one that SVG knows"):
        read_outline(drawing(tmp_path, f'<rect width="2" height="1" transform="{transform}"/>'))
