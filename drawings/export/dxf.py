"""A sheet as a DXF document: the part in model space at 1:1, the sheet in paper space with a viewport for each scale.

Model space holds the views in their positions on the paper, at the part's true size: a point p of the paper is
at p / scale there, and views of another scale are moved sideways. So a shop can measure the part in the file, and each
DIMENSION measures its value. The block of a dimension is written from the primitives of the sheet, so that it looks
the same in every program.
"""

import io
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from ezdxf._options import options
from ezdxf.document import Drawing
from ezdxf.filemanagement import new, readfile
from ezdxf.math import Matrix44

from drawings.annotations.annotation_geometry import primitive_box
from drawings.annotations.primitives import FONT, LAYERS, LINE_TYPES, TEXT_STYLE, WIDTH_FACTOR, LineType, SheetLayer
from drawings.export.drawing_model import DrawingModel
from drawings.export.dxf_entities import ON_PAPER, ModelMapping, add_dimension, add_primitive
from drawings.views.view import Box2, enclosing_box

COLOURS: dict[SheetLayer, int] = {
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

DESCRIPTIONS: dict[LineType, str] = {
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
        lengths = LINE_TYPES[name]
        signed = [-length if number % 2 else length for number, length in enumerate(lengths)]
        doc.linetypes.add(name, [sum(lengths), *signed], description=description)
    for name, (weight, line_type) in LAYERS.items():
        layer = doc.layers.add(name, color=COLOURS[name], lineweight=round(100 * weight), linetype=line_type)
        layer.dxf.plot = 1
    layer = doc.layers.add(VIEWPORT_LAYER, color=VIEWPORT_COLOUR, lineweight=0, linetype="CONTINUOUS")
    layer.dxf.plot = 0
    doc.styles.add(TEXT_STYLE, font=FONT).dxf.width = WIDTH_FACTOR


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
