"""A sheet as a DXF document: the part in model space at 1:1, the sheet in paper space with a viewport for each scale.

Model space holds the views side by side as they stand on the paper, at the part's true size: what stands at p on the
paper is at p / scale there, and views of another scale stand off by a distance of their own. So a shop can measure the
part in the file, and every DIMENSION measures what it says. A dimension's picture (its block) is drawn here, from
`drawings.annotation_ink`, so that it is the same in every program and the texts stand where the layout put them.

The document is the same, byte for byte, for the same sheet.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from typing import Any

from ezdxf._options import options
from ezdxf.document import Drawing
from ezdxf.enums import TextEntityAlignment
from ezdxf.filemanagement import new

from drawings.annotation import Angular, Linear, Round
from drawings.annotation_ink import annotation_ink, note_ink
from drawings.dxf_writing import document_text
from drawings.frame import PAPERS, frame
from drawings.ink import Circle, Ink, Stroke, Words
from drawings.lettering import FONT, LARGE, NARROWED, STYLE, TEXT, prepare
from drawings.sheet import Sheet, scale_text
from drawings.title_block import title_ink
from drawings.view import Arc, Box2, Curve, Layer, Point2, Segment, View

LAYERS: dict[str, tuple[int, int, str]] = {
    "VISIBLE": (7, 50, "CONTINUOUS"),
    "HIDDEN": (4, 25, "DASHED"),
    "CENTRE": (1, 25, "CHAIN"),
    "SECTION": (6, 25, "CHAIN"),
    "HATCH": (8, 18, "CONTINUOUS"),
    "DIMENSION": (3, 25, "CONTINUOUS"),
    "TEXT": (7, 25, "CONTINUOUS"),
    "FRAME": (7, 70, "CONTINUOUS"),
    "BORDER": (8, 25, "CONTINUOUS"),
    "VIEWPORT": (9, 0, "CONTINUOUS"),
}
"""Colour index, weight in hundredths of a millimetre, and line type (ISO 128-2: wide lines twice as wide as narrow)."""

LINE_TYPES = {
    "DASHED": ("hidden edges", [4.0, 3.0, -1.0]),
    "CHAIN": ("centre lines and cutting planes", [9.0, 6.0, -1.0, 1.0, -1.0]),
}
"""Lengths on paper, mm: whole pattern, then dashes and gaps."""

MILLIMETRES = 4
"""Unit of the drawing, as DXF numbers it."""

SHORT_CHAIN = 12.0
"""Centre lines shorter than this on paper are drawn without a break, mm: a chain of one dash looks like chance."""


def dxf_text(text: str) -> str:
    """Text as every program that reads DXF shows it, whatever its font has."""
    return text.replace("⌀", "%%c").replace("°", "%%d").replace("±", "%%p")


def document_of(sheet: Sheet) -> Drawing:
    """The `ezdxf` drawing of a sheet."""
    prepare()
    with _without_the_time():
        doc = new("R2010", units=MILLIMETRES)
    _tables(doc)
    paper = doc.paperspace()
    width, height = PAPERS[sheet.paper]
    paper.page_setup(size=(width, height), margins=(0, 0, 0, 0), units="mm", name=sheet.name[:32])
    for ink in (*frame(sheet.paper), *title_ink(sheet.title, sheet.paper), *sheet.tables):
        _put(paper, ink, _Place())
    for note in sheet.notes:
        for ink in note_ink(note):
            _put(paper, ink, _Place())
    model = doc.modelspace()
    places = _places(sheet)
    drawn: dict[float, list[Box2]] = {scale: [] for scale in places}
    for view in sheet.views:
        place = places[view.scale]
        _curves(model, view, place)
        drawn[view.scale] += [box for box in [view_box(view)] if box]
        for ink in label_ink(view):
            _put(model, ink, place)
            drawn[view.scale].append(_ink_box(ink))
    for annotation in sheet.annotations:
        view = sheet.view(annotation.view)
        inks = list(annotation_ink(annotation, view))
        drawn[view.scale] += map(_ink_box, inks)
        if isinstance(annotation, Linear | Round | Angular):
            _dimension(doc, annotation, view, inks, places[view.scale])
        else:
            for ink in inks:
                _put(model, ink, places[view.scale])
    for scale, boxes in drawn.items():
        _viewport(paper, _around(boxes), places[scale])
    return doc


class _Place:
    """Where paper coordinates are in model space: at (p + shift) / scale."""

    def __init__(self, scale: float = 1.0, shift: Point2 = (0.0, 0.0)) -> None:
        self.scale = scale
        self.shift = shift

    def __call__(self, point: Point2) -> Point2:
        return ((point[0] + self.shift[0]) / self.scale, (point[1] + self.shift[1]) / self.scale)

    def length(self, value: float) -> float:
        return value / self.scale


def _places(sheet: Sheet) -> dict[float, _Place]:
    """A place for each scale of the sheet, the main one first and unshifted, none over another."""
    width = PAPERS[sheet.paper][0]
    scales = sorted({view.scale for view in sheet.views}, key=lambda scale: (scale != sheet.scale, -scale))
    places: dict[float, _Place] = {}
    right = 0.0
    for scale in scales:
        places[scale] = _Place(scale, (right * scale, 0.0))
        right += 1.25 * width / scale
    return places


def _tables(doc: Any) -> None:
    header = doc.header
    # Line types are given for paper and scaled by each entity, so that viewports need not do it.
    header["$PSLTSCALE"], header["$LTSCALE"], header["$MEASUREMENT"], header["$LWDISPLAY"] = 0, 1.0, 1, 1
    for name, (meaning, pattern) in LINE_TYPES.items():
        doc.linetypes.add(name, pattern, description=meaning)
    for name, (colour, weight, line_type) in LAYERS.items():
        layer = doc.layers.add(name, color=colour, lineweight=weight, linetype=line_type)
        layer.dxf.plot = int(name != "VIEWPORT")
    doc.styles.add(STYLE, font=FONT).dxf.width = NARROWED


def _curves(model: Any, view: View, place: _Place) -> None:
    for layer, curves in view.curves.items():
        for curve in curves:
            _curve(model, curve, view, layer, place)


def _curve(model: Any, curve: Curve, view: View, layer: Layer, place: _Place) -> None:
    attributes: dict[str, Any] = {"layer": layer}
    if LAYERS[layer][2] != "CONTINUOUS":
        attributes["ltscale"] = place.length(1.0)

    def at(point: Point2) -> Point2:
        return place(view.to_paper(point))

    if isinstance(curve, Segment):
        if layer == "CENTRE" and math.dist(curve.start, curve.end) * view.scale < SHORT_CHAIN:
            attributes["linetype"] = "CONTINUOUS"
        model.add_line(at(curve.start), at(curve.end), dxfattribs=attributes)
    elif isinstance(curve, Arc):
        _arc(model, at(curve.centre), curve.radius, curve, attributes)
    else:
        model.add_lwpolyline([at(point) for point in curve.points], dxfattribs=attributes)


def _arc(layout: Any, centre: Point2, radius: float, arc: Arc, attributes: dict[str, Any]) -> None:
    if arc.end_angle - arc.start_angle > 359.999:
        layout.add_circle(centre, radius, dxfattribs=attributes)
    else:
        layout.add_arc(centre, radius, arc.start_angle, arc.end_angle, dxfattribs=attributes)


def _put(layout: Any, ink: Ink, place: _Place, layer: str = "") -> None:
    if isinstance(ink, Words):
        _words(layout, ink, place)
        return
    attributes = {"layer": layer or (ink.layer if layout.is_any_paperspace else "DIMENSION")}
    if not layout.is_any_paperspace and ink.layer == "FRAME":
        attributes = {"layer": "SECTION", "linetype": "CONTINUOUS", "lineweight": LAYERS["FRAME"][1]}
    if isinstance(ink, Circle):
        _arc(layout, place(ink.arc.centre), place.length(ink.arc.radius), ink.arc, attributes)
    elif isinstance(ink, Stroke):
        points = [place(point) for point in ink.points]
        if len(points) == 2:
            layout.add_line(*points, dxfattribs=attributes)
        else:
            layout.add_lwpolyline(points, dxfattribs=attributes)
    else:
        _fill(layout, [place(point) for point in ink.points], attributes)


def _fill(layout: Any, points: list[Point2], attributes: dict[str, Any]) -> None:
    if len(points) <= 4:
        # A SOLID runs through its corners crosswise.
        layout.add_solid([*points[:2], *reversed(points[2:])], dxfattribs=attributes)
    else:
        layout.add_hatch(dxfattribs=attributes).paths.add_polyline_path(points)


_ANCHORS = {
    "left": TextEntityAlignment.LEFT,
    "middle": TextEntityAlignment.CENTER,
    "right": TextEntityAlignment.RIGHT,
}


def _words(layout: Any, words: Words, place: _Place) -> None:
    attributes = {"layer": "TEXT", "style": STYLE, "width": NARROWED}
    text = layout.add_text(
        dxf_text(words.text), height=place.length(words.height), rotation=words.angle, dxfattribs=attributes
    )
    text.set_placement(place(words.at), align=_ANCHORS[words.anchor])


def _dimension(doc: Any, d: Linear | Round | Angular, view: View, inks: Iterable[Ink], place: _Place) -> None:
    """A DIMENSION with its picture, in the style of its scale and decimals."""
    block = doc.blocks.new_anonymous_block(type_char="D")
    for ink in inks:
        _put(block, ink, place, "DIMENSION")
    text, decimals = measured_text(d)

    def at(point: Point2) -> Any:
        return (*place(view.to_paper(point)), 0.0)

    attributes: dict[str, Any] = {
        "layer": "DIMENSION",
        "geometry": block.name,
        "dimstyle": _style(doc, place.scale, decimals),
        "text": dxf_text(text),
        "attachment_point": 5,
    }
    middles = [words for words in inks if isinstance(words, Words)]
    if middles:
        attributes["text_midpoint"] = (*place(_middle(middles[0])), 0.0)
    if isinstance(d, Linear):
        attributes |= {
            "dimtype": 0 | 32 | 128,
            "defpoint": (*place(_on_line(d, view)), 0.0),
            "defpoint2": at(d.first),
            "defpoint3": at(d.second),
            "angle": d.angle,
        }
    elif isinstance(d, Angular):
        attributes |= {
            "dimtype": 5 | 32 | 128,
            "defpoint": (*place(d.arc_at), 0.0),
            "defpoint2": at(d.first),
            "defpoint3": at(d.second),
            "defpoint4": at(d.vertex),
        }
    else:
        turn = math.radians(d.towards)
        out = (d.radius * math.cos(turn), d.radius * math.sin(turn))
        on = (d.centre[0] + out[0], d.centre[1] + out[1])
        opposite = (d.centre[0] - out[0], d.centre[1] - out[1])
        attributes |= {
            "dimtype": (3 if d.kind == "diameter" else 4) | 32 | 128,
            "defpoint": at(opposite if d.kind == "diameter" else d.centre),
            "defpoint4": at(on),
        }
    entity = doc.modelspace().new_entity("DIMENSION", attributes)
    entity.dxf.actual_measurement = entity.get_measurement() if not isinstance(d, Angular) else math.radians(d.measured)


def measured_text(d: Linear | Round | Angular) -> tuple[str, int]:
    """A dimension's text with `<>` for the measured number, and the decimals that number has.

    Raises:
        ValueError: the text does not say what was measured.
    """
    for decimals in range(4, -1, -1):
        number = f"{d.measured:.{decimals}f}"
        start = d.text.find(number)
        while start >= 0:
            end = start + len(number)
            if not d.text[start - 1 : start].isdigit() and not d.text[end : end + 1].isdigit():
                return f"{d.text[:start]}<>{d.text[end:]}", decimals
            start = d.text.find(number, start + 1)
    raise ValueError(f"dimension {', '.join(d.names)} says '{d.text}', but measures {d.measured:.4f}")


def _middle(words: Words) -> Point2:
    turn = math.radians(words.angle)
    return (words.at[0] - math.sin(turn) * words.height / 2, words.at[1] + math.cos(turn) * words.height / 2)


def _on_line(d: Linear, view: View) -> Point2:
    """Where the dimension line is met from the second point, as DXF wants it."""
    turn = math.radians(d.angle)
    u = (math.cos(turn), math.sin(turn))
    point = view.to_paper(d.second)
    along = (point[0] - d.line_at[0]) * u[0] + (point[1] - d.line_at[1]) * u[1]
    return (d.line_at[0] + along * u[0], d.line_at[1] + along * u[1])


def _style(doc: Any, scale: float, decimals: int) -> str:
    """Name of the dimension style for a scale and a number of decimals; made when it is not there."""
    name = f"{scale_text(scale).replace(':', '-')} {decimals} decimals"
    if name not in doc.dimstyles:
        style = doc.dimstyles.new(name)
        values = {
            "dimscale": 1.0 / scale, "dimtxt": TEXT, "dimtxsty": STYLE, "dimasz": 3.0, "dimexe": 2.0, "dimexo": 1.0,
            "dimgap": 1.0, "dimtad": 1, "dimtih": 0, "dimtoh": 0, "dimtofl": 1, "dimtmove": 2,
            # Decimals are the tolerance class: none may be dropped.
            "dimdec": decimals, "dimzin": 0, "dimadec": decimals, "dimazin": 0, "dimdsep": ord("."), "dimlunit": 2,
        }  # fmt: skip
        for key, value in values.items():
            style.dxf.set(key, value)
    return name


def label_ink(view: View) -> Iterator[Ink]:
    """The name of a section or detail, below its view."""
    box = view_box(view)
    if view.label and box:
        yield Words(view.label, view.label_at or ((box[0] + box[2]) / 2, box[1] - 3.0 - LARGE), LARGE, "middle")


def view_box(view: View) -> Box2 | None:
    """Room of a view's lines on the paper; none for a view without lines."""
    points = [point for curves in view.curves.values() for curve in curves for point in outermost(curve)]
    if not points:
        return None
    xs, ys = zip(*map(view.to_paper, points))
    return (min(xs), min(ys), max(xs), max(ys))


def outermost(curve: Curve) -> list[Point2]:
    """Points of a curve that span its box."""
    if isinstance(curve, Segment):
        return [curve.start, curve.end]
    if not isinstance(curve, Arc):
        return list(curve.points)
    (x, y), radius = curve.centre, curve.radius
    quarters = range(math.ceil(curve.start_angle / 90), math.floor(curve.end_angle / 90) + 1)
    angles = [curve.start_angle, curve.end_angle, *(90.0 * quarter for quarter in quarters)]
    return [(x + radius * math.cos(math.radians(a)), y + radius * math.sin(math.radians(a))) for a in angles]


def _ink_box(ink: Ink) -> Box2:
    from drawings.annotation_ink import text_box

    if isinstance(ink, Words):
        return text_box(ink)
    points = outermost(ink.arc) if isinstance(ink, Circle) else list(ink.points)
    xs, ys = zip(*points)
    return (min(xs), min(ys), max(xs), max(ys))


def _around(boxes: list[Box2], margin: float = 2.0) -> Box2:
    x0, y0, x1, y1 = zip(*boxes)
    return (min(x0) - margin, min(y0) - margin, max(x1) + margin, max(y1) + margin)


def _viewport(paper: Any, box: Box2, place: _Place) -> None:
    width, height = box[2] - box[0], box[3] - box[1]
    middle = ((box[0] + box[2]) / 2, (box[1] + box[3]) / 2)
    paper.add_viewport(
        center=middle,
        size=(width, height),
        view_center_point=place(middle),
        view_height=place.length(height),
        dxfattribs={"layer": "VIEWPORT"},
    )


def dxf_bytes(doc: Drawing) -> bytes:
    """The document as a file, the same bytes for the same document."""
    # ezdxf adds the classes it needs in the order of a set, which differs from process to process.
    doc.classes.add_required_classes(doc.dxfversion)
    doc.classes.classes = dict(sorted(doc.classes.classes.items(), key=lambda item: str(item[0])))
    with _without_the_time():
        return document_text(doc).encode("utf-8")


@contextmanager
def _without_the_time() -> Iterator[None]:
    """ezdxf notes the time, and a random name, when a document is made and when it is written; here it does not."""
    before = options.write_fixed_meta_data_for_testing
    options.write_fixed_meta_data_for_testing = True
    try:
        yield
    finally:
        options.write_fixed_meta_data_for_testing = before
