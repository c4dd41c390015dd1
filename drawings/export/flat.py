"""A sheet's DXF document for viewers without viewports: everything in model space, at the size of the paper.

Lines of views are moved from their true size to their place on the paper; dimensions become their lines and texts.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

from ezdxf.document import Drawing
from ezdxf.filemanagement import readfile
from ezdxf.math import Matrix44

from drawings.export.dxf import VIEWPORT_LAYER, dxf_bytes


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
