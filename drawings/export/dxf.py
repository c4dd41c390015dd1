"""A sheet as a DXF document: the part in model space at 1:1, the sheet in paper space with a viewport for each scale.

Model space holds the views in their positions on the paper, at the part's true size: a point p of the paper is
at p / scale there, and views of another scale are moved sideways. So a shop can measure the part in the file, and each
DIMENSION measures its value. The block of a dimension is written from the primitives of the sheet, so that it looks
the same in every program.

A DIMENSION entity has its measured points, its text with `<>` in place of the number, and a block with its primitives.
A program that opens the file measures the number itself; the block has the text where the layout put it.
"""

import io
import math
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from ezdxf._options import options
from ezdxf.document import Drawing
from ezdxf.enums import TextEntityAlignment
from ezdxf.filemanagement import new, readfile
from ezdxf.math import Matrix44

from drawings.annotations import primitives
from drawings.annotations.annotation import AngularDimension, LinearDimension, MeasuredDimension, primitive_box
from drawings.annotations.symbols import unframed
from drawings.export.drawing_model import DrawingModel, PrimitiveGroup
from drawings.sheets.sheet import scale_text
from drawings.views.view import Box2, Point2, View, direction, distance_along, enclosing_box, offset

_ALIGNMENTS = {
    "left": TextEntityAlignment.LEFT,
    "middle": TextEntityAlignment.CENTER,
    "right": TextEntityAlignment.RIGHT,
}
_DECIMALS = 9
"""Decimals of lengths in model space, mm: rounding errors of scaling to paper and back are removed."""


@dataclass(frozen=True)
class ModelMapping:
    """Mapping from paper to model space: (x, y) is at ((x + shift) / scale, y / scale)."""

    scale: float = 1.0
    shift: float = 0.0

    def __call__(self, point: Point2) -> Point2:
        return ((point[0] + self.shift) / self.scale, point[1] / self.scale)


ON_PAPER = ModelMapping()


def dxf_text(text: str) -> str:
    """Text with the codes of DXF for the signs that not every font has."""
    return text.replace("⌀", "%%c").replace("°", "%%d").replace("±", "%%p")


def add_primitive(layout: Any, primitive: primitives.Primitive, mapping: ModelMapping) -> None:
    """Add a primitive to a layout or block."""
    match primitive:
        case primitives.Stroke(points):
            attributes = _attributes(primitive, mapping)
            if len(points) == 2:
                layout.add_line(mapping(points[0]), mapping(points[1]), dxfattribs=attributes)
            else:
                layout.add_lwpolyline(list(map(mapping, points)), dxfattribs=attributes)
        case primitives.ArcStroke(arc):
            centre, radius = mapping(arc.centre), round(arc.radius / mapping.scale, _DECIMALS)
            attributes = _attributes(primitive, mapping)
            if arc.end_angle - arc.start_angle > 359.999:
                layout.add_circle(centre, radius, dxfattribs=attributes)
            else:
                layout.add_arc(centre, radius, arc.start_angle, arc.end_angle, dxfattribs=attributes)
        case primitives.FilledPolygon(points) if len(points) <= 4:
            # A SOLID runs through its corners crosswise.
            first, second, *others = map(mapping, points)
            layout.add_solid([first, second, *reversed(others)], dxfattribs={"layer": primitive.layer})
        case primitives.FilledPolygon(points):
            hatch = layout.add_hatch(dxfattribs={"layer": primitive.layer})
            hatch.paths.add_polyline_path(list(map(mapping, points)))
        case primitives.Text():
            height = round(primitive.height / mapping.scale, _DECIMALS)
            attributes = {"layer": "TEXT", "style": primitives.TEXT_STYLE, "width": primitives.WIDTH_FACTOR}
            entity = layout.add_text(
                dxf_text(primitive.text), height=height, rotation=primitive.angle, dxfattribs=attributes
            )
            entity.set_placement(mapping(primitive.at), align=_ALIGNMENTS[primitive.alignment])


def _attributes(primitive: primitives.Stroke | primitives.ArcStroke, mapping: ModelMapping) -> dict[str, Any]:
    """Layer, and what is not that of the layer: line type, weight, and the scale of the line type in model space."""
    attributes: dict[str, Any] = {"layer": primitive.layer}
    own, style = primitives.LAYERS[primitive.layer], primitive.style or primitives.LAYERS[primitive.layer]
    if style.line_type != own.line_type:
        attributes["linetype"] = style.line_type
    if style.weight != own.weight:
        attributes["lineweight"] = round(100 * style.weight)
    if style.line_type != "CONTINUOUS":
        attributes["ltscale"] = 1.0 / mapping.scale
    return attributes


def add_dimension(doc: Any, group: PrimitiveGroup, mapping: ModelMapping) -> None:
    """Add the DIMENSION of a group with its block, in the dimension style of its scale and decimals."""
    d, view = group.dimension, group.view
    if d is None or view is None:
        raise ValueError("the group shows no dimension")
    block = doc.blocks.new_anonymous_block(type_char="D")
    for primitive in group.primitives:
        add_primitive(block, primitive, mapping)
    text, decimals = measured_text(d)
    attributes: dict[str, Any] = {
        "layer": "DIMENSION",
        "geometry": block.name,
        "dimstyle": _dimension_style(doc, mapping.scale, decimals, "{box:" in d.text),
        "text": dxf_text(text),
        "attachment_point": 5,
    }
    first = next((primitive for primitive in group.primitives if isinstance(primitive, primitives.Text)), None)
    if first:
        middle = offset(first.at, direction(first.angle), 0.0, first.height / 2)
        middle = d.text_at if isinstance(d, LinearDimension) and d.text_at else middle
        attributes["text_midpoint"] = (*mapping(middle), 0.0)
    for name, value in _definition(d, view).items():
        attributes[name] = (*mapping(value), 0.0) if isinstance(value, tuple) else value
    entity = doc.modelspace().new_entity("DIMENSION", attributes)
    angular = isinstance(d, AngularDimension)
    entity.dxf.actual_measurement = math.radians(d.measured) if angular else entity.get_measurement()


def _definition(d: MeasuredDimension, view: View) -> dict[str, Any]:
    """Type and definition points of a DIMENSION, points on paper."""
    # 32: the block belongs to this dimension alone; 128: the position of the text is user-defined.
    own = 32 | 128
    if isinstance(d, LinearDimension):
        u = direction(d.angle)
        return {
            "dimtype": 0 | own,
            # Where the extension line of the second point meets the dimension line.
            "defpoint": offset(d.line_at, u, distance_along(view.to_paper(d.second), d.line_at, u)),
            "defpoint2": view.to_paper(d.first),
            "defpoint3": view.to_paper(d.second),
            "angle": d.angle,
        }
    if isinstance(d, AngularDimension):
        return {
            "dimtype": 5 | own,
            "defpoint": d.arc_at,
            "defpoint2": view.to_paper(d.first),
            "defpoint3": view.to_paper(d.second),
            "defpoint4": view.to_paper(d.vertex),
        }
    u, diameter = direction(d.towards), d.kind == "diameter"
    return {
        "dimtype": (3 if diameter else 4) | own,
        "defpoint": view.to_paper(offset(d.centre, u, -d.radius) if diameter else d.centre),
        "defpoint4": view.to_paper(offset(d.centre, u, d.radius)),
    }


def measured_text(d: MeasuredDimension) -> tuple[str, int]:
    """A dimension's text with `<>` in place of the measured number, and the number's decimals."""
    words = unframed(d.text)
    for decimals in range(4, -1, -1):
        number = f"{d.measured:.{decimals}f}"
        start = words.find(number)
        while start >= 0:
            end = start + len(number)
            # The number of equal features (`3x`) is not the measured number.
            if not words[start - 1 : start].isdigit() and words[end : end + 1] not in tuple("0123456789x"):
                return f"{words[:start]}<>{words[end:]}", decimals
            start = words.find(number, start + 1)
    raise ValueError(f"dimension {', '.join(d.names)} has the text '{d.text}', but measures {d.measured:.4f}")


def _dimension_style(doc: Any, scale: float, decimals: int, framed: bool) -> str:
    """Name of the dimension style for a scale, a number of decimals, and a frame; added when it is not there."""
    name = f"{scale_text(scale).replace(':', '-')} {decimals} decimals"
    name += ", framed" if framed else ""
    if name not in doc.dimstyles:
        # A negative distance frames the text.
        lines = {"dimscale": 1.0 / scale, "dimasz": 3.0, "dimexe": 2.0, "dimexo": 1.0}
        text = {
            "dimtxt": primitives.TEXT_HEIGHT,
            "dimtxsty": primitives.TEXT_STYLE,
            "dimgap": -1.0 if framed else 1.0,
            "dimdsep": ord("."),
            "dimlunit": 2,
        }
        places = {"dimtad": 1, "dimtih": 0, "dimtoh": 0, "dimtofl": 1, "dimtmove": 2}
        # All trailing zeros are kept, since decimals are the tolerance class.
        zeros = {"dimdec": decimals, "dimzin": 0, "dimadec": decimals, "dimazin": 0}
        doc.dimstyles.new(name, dxfattribs={**lines, **text, **places, **zeros})
    return name


COLOURS: dict[primitives.SheetLayer, int] = {
    "VISIBLE": 7,
    "HIDDEN": 4,
    "CENTRE": 1,
    "SECTION": 6,
    "HATCH": 8,
    "PHANTOM": 2,
    "THREAD": 5,
    "DIMENSION": 3,
    "TEXT": 7,
    "FRAME": 7,
    "BORDER": 8,
}
"""Colour index of each layer; all layers are printed in black."""
VIEWPORT_LAYER, VIEWPORT_COLOUR = "VIEWPORT", 9

DESCRIPTIONS: dict[primitives.LineType, str] = {
    "DASHED": "hidden edges",
    "CHAIN": "centre lines and cutting planes",
    "PHANTOM": "end positions of moving parts",
}
MILLIMETRES = 4
"""Unit of the drawing, as DXF numbers it."""
MARGIN = 2.0
"""Margin between the primitives of a scale and the edge of their viewport, mm on paper."""


def dxf_document(drawing: DrawingModel) -> Drawing:
    """The `ezdxf` document of a sheet."""
    with _fixed_metadata():
        doc = new("R2010", units=MILLIMETRES)
    _add_tables(doc)
    paper, model = doc.paperspace(), doc.modelspace()
    paper.page_setup(size=drawing.size, margins=(0, 0, 0, 0), units="mm", name=drawing.name[:32])
    mappings = _mappings(drawing)
    boxes: dict[float, list[Box2]] = {scale: [] for scale in mappings}
    for group in drawing.groups:
        if group.view is None:
            for primitive in group.primitives:
                add_primitive(paper, primitive, ON_PAPER)
            continue
        mapping = mappings[group.view.scale]
        boxes[group.view.scale] += map(primitive_box, group.primitives)
        if group.dimension:
            add_dimension(doc, group, mapping)
        else:
            for primitive in group.primitives:
                add_primitive(model, primitive, mapping)
    for scale, drawn in boxes.items():
        _add_viewport(paper, enclosing_box(drawn, MARGIN), mappings[scale])
    return doc


def _mappings(drawing: DrawingModel) -> dict[float, ModelMapping]:
    """The mapping of each scale of the sheet, the main one first and not moved; no two overlap in model space."""
    width = drawing.size[0]
    found = {group.view.scale for group in drawing.groups if group.view}
    mappings: dict[float, ModelMapping] = {}
    right = 0.0
    for scale in sorted(found, key=lambda scale: (scale != drawing.scale, -scale)):
        mappings[scale] = ModelMapping(scale, right * scale)
        right += 1.25 * width / scale
    return mappings


def _add_tables(doc: Any) -> None:
    header = doc.header
    # Line types are given for paper and scaled by each entity, so that viewports need not do it.
    header["$PSLTSCALE"], header["$LTSCALE"], header["$MEASUREMENT"], header["$LWDISPLAY"] = 0, 1.0, 1, 1
    for name, description in DESCRIPTIONS.items():
        lengths = primitives.LINE_TYPES[name]
        signed = [-length if number % 2 else length for number, length in enumerate(lengths)]
        doc.linetypes.add(name, [sum(lengths), *signed], description=description)
    for name, (weight, line_type) in primitives.LAYERS.items():
        layer = doc.layers.add(name, color=COLOURS[name], lineweight=round(100 * weight), linetype=line_type)
        layer.dxf.plot = 1
    layer = doc.layers.add(VIEWPORT_LAYER, color=VIEWPORT_COLOUR, lineweight=0, linetype="CONTINUOUS")
    layer.dxf.plot = 0
    doc.styles.add(primitives.TEXT_STYLE, font=primitives.FONT).dxf.width = primitives.WIDTH_FACTOR


def _add_viewport(paper: Any, box: Box2, mapping: ModelMapping) -> None:
    width, height = box[2] - box[0], box[3] - box[1]
    middle = ((box[0] + box[2]) / 2, (box[1] + box[3]) / 2)
    paper.add_viewport(
        center=middle,
        size=(width, height),
        view_center_point=mapping(middle),
        view_height=height / mapping.scale,
        dxfattribs={"layer": VIEWPORT_LAYER},
    )


def dxf_bytes(doc: Drawing) -> bytes:
    """The document as a file, the same bytes for the same document."""
    # ezdxf adds the classes it needs in the order of a set, which differs from process to process.
    doc.classes.add_required_classes(doc.dxfversion)
    doc.classes.classes = dict(sorted(doc.classes.classes.items(), key=lambda item: str(item[0])))
    stream = io.StringIO()
    with _fixed_metadata():
        doc.write(stream)
    return stream.getvalue().encode("utf-8")


@contextmanager
def _fixed_metadata() -> Iterator[None]:
    """Without the time and the random identifiers that ezdxf writes into a new document and into a file."""
    before = options.write_fixed_meta_data_for_testing
    options.write_fixed_meta_data_for_testing = True
    try:
        yield
    finally:
        options.write_fixed_meta_data_for_testing = before


def flat_file(path: Path) -> bytes:
    """The DXF file of a sheet, flat."""
    return dxf_bytes(flattened(readfile(path)))


def flattened(document: Drawing) -> Drawing:
    """Move everything on the paper of a document to its model space, in place."""
    model, paper = document.modelspace(), document.paperspace()
    viewports = [view for view in paper.query("VIEWPORT") if view.dxf.id != 1]
    for dimension in model.query("DIMENSION"):
        for entity in document.blocks.get(dimension.dxf.geometry):
            model.add_entity(entity.copy())
        model.delete_entity(dimension)  # type: ignore[arg-type]
    for entity in list(model):
        viewport = _of(entity, viewports)
        scale = viewport.dxf.height / viewport.dxf.view_height
        middle, seen = viewport.dxf.center, viewport.dxf.view_center_point
        place = Matrix44.translate(middle.x - scale * seen.x, middle.y - scale * seen.y, 0.0)
        entity.transform(Matrix44.scale(scale, scale, scale) @ place)
        if entity.dxf.hasattr("ltscale"):
            entity.dxf.ltscale = 1.0
    for entity in list(paper):
        if entity.dxftype() != "VIEWPORT":
            paper.move_to_layout(entity, model)
    for viewport in viewports:
        paper.delete_entity(viewport)  # type: ignore[arg-type]
    document.layers.remove(VIEWPORT_LAYER)
    return document


def _of(entity: Any, viewports: list[Any]) -> Any:
    """The viewport that shows an entity."""
    from ezdxf.bbox import extents

    box = extents([entity], fast=True)
    at = box.center if box.has_data else entity.dxf.insert

    def distance(viewport: Any) -> float:
        """How far a place is outside the part of model space that a viewport shows."""
        half = viewport.dxf.view_height / 2
        wide = half * viewport.dxf.width / viewport.dxf.height
        middle = viewport.dxf.view_center_point
        return max(abs(at.x - middle.x) - wide, abs(at.y - middle.y) - half)

    return min(viewports, key=distance)
