"""A sheet as a DXF document: the part in model space at 1:1, the sheet in paper space with a viewport for each scale.

Model space holds the views side by side as they stand on the paper, at the part's true size: what stands at p on the
paper is at p / scale there, and views of another scale stand off by a distance of their own. So a shop can measure the
part in the file, and every DIMENSION measures what it says. A dimension's block is drawn here, from
`drawings.annotations.annotation_geometry`, so that it is the same in every program.

The document is the same, byte for byte, for the same sheet.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

from ezdxf._options import options
from ezdxf.document import Drawing
from ezdxf.filemanagement import new

from drawings.annotations.annotation import AngularDimension, LinearDimension, RadialDimension
from drawings.annotations.annotation_geometry import (
    annotation_primitives,
    label_primitives,
    note_primitives,
    primitive_box,
)
from drawings.annotations.font import FONT, TEXT_STYLE, WIDTH_FACTOR, prepare
from drawings.export.dxf_dimensions import add_dimension
from drawings.export.dxf_entities import ON_PAPER, Place, add_arc, add_line, add_polyline, put
from drawings.export.dxf_writing import document_text
from drawings.sheets.frame import PAPERS, frame
from drawings.sheets.sheet import Sheet
from drawings.sheets.title_block import title_primitives
from drawings.views.bounding_box import enclosing_box, view_box
from drawings.views.view import Arc, Box2, Curve, Layer, Point2, Segment, View

LAYERS: dict[str, tuple[int, int, str]] = {
    "VISIBLE": (7, 50, "CONTINUOUS"),
    "HIDDEN": (4, 25, "DASHED"),
    "CENTRE": (1, 25, "CHAIN"),
    "SECTION": (6, 25, "CHAIN"),
    "HATCH": (8, 18, "CONTINUOUS"),
    "PHANTOM": (2, 25, "PHANTOM"),
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
    "PHANTOM": ("ends of what moves", [11.0, 6.0, -1.0, 1.0, -1.0, 1.0, -1.0]),
}
"""Lengths on paper, mm: whole pattern, then dashes and gaps."""

MILLIMETRES = 4
"""Unit of the drawing, as DXF numbers it."""

MARGIN = 2.0
"""From what is drawn to the edge of its viewport, mm on paper."""

SHORT_CHAIN = 12.0
"""Centre lines shorter than this on paper are drawn without a break, mm: a chain of one dash looks like chance."""


def document_of(sheet: Sheet) -> Drawing:
    """The `ezdxf` drawing of a sheet."""
    prepare()
    with _without_the_time():
        doc = new("R2010", units=MILLIMETRES)
    _tables(doc)
    paper = doc.paperspace()
    width, height = PAPERS[sheet.paper]
    paper.page_setup(size=(width, height), margins=(0, 0, 0, 0), units="mm", name=sheet.name[:32])
    for ink in (*frame(sheet.paper), *title_primitives(sheet.title, sheet.paper), *sheet.tables):
        put(paper, ink, ON_PAPER)
    for note in sheet.notes:
        for ink in note_primitives(note):
            put(paper, ink, ON_PAPER)
    model = doc.modelspace()
    places = _places(sheet)
    drawn: dict[float, list[Box2]] = {scale: [] for scale in places}
    for view in sheet.views:
        place = places[view.scale]
        _curves(model, view, place)
        drawn[view.scale] += [box for box in [view_box(view)] if box]
        for ink in label_primitives(view):
            put(model, ink, place)
            drawn[view.scale].append(primitive_box(ink))
    for annotation in sheet.annotations:
        view = sheet.view(annotation.view)
        inks = list(annotation_primitives(annotation, view))
        drawn[view.scale] += map(primitive_box, inks)
        if isinstance(annotation, LinearDimension | RadialDimension | AngularDimension):
            add_dimension(doc, annotation, view, inks, places[view.scale])
        else:
            for ink in inks:
                put(model, ink, places[view.scale])
    for scale, boxes in drawn.items():
        _viewport(paper, enclosing_box(boxes, MARGIN), places[scale])
    return doc


def _places(sheet: Sheet) -> dict[float, Place]:
    """A place for each scale of the sheet, the main one first and unshifted, none over another."""
    width = PAPERS[sheet.paper][0]
    scales = sorted({view.scale for view in sheet.views}, key=lambda scale: (scale != sheet.scale, -scale))
    places: dict[float, Place] = {}
    right = 0.0
    for scale in scales:
        places[scale] = Place(scale, (right * scale, 0.0))
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
    doc.styles.add(TEXT_STYLE, font=FONT).dxf.width = WIDTH_FACTOR


def _curves(model: Any, view: View, place: Place) -> None:
    for layer, curves in view.curves.items():
        for curve in curves:
            _curve(model, curve, view, layer, place)


def _curve(model: Any, curve: Curve, view: View, layer: Layer, place: Place) -> None:
    attributes: dict[str, Any] = {"layer": layer}
    if LAYERS[layer][2] != "CONTINUOUS":
        attributes["ltscale"] = place.length(1.0)

    def at(point: Point2) -> Point2:
        return place(view.to_paper(point))

    if isinstance(curve, Segment):
        if layer == "CENTRE" and math.dist(curve.start, curve.end) * view.scale < SHORT_CHAIN:
            attributes["linetype"] = "CONTINUOUS"
        add_line(model, at(curve.start), at(curve.end), attributes)
    elif isinstance(curve, Arc):
        add_arc(model, at(curve.centre), curve.radius, curve, attributes)
    else:
        add_polyline(model, [at(point) for point in curve.points], attributes)


def _viewport(paper: Any, box: Box2, place: Place) -> None:
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
