"""The pictures of the whole machine: from above, cut along and across the travel, exploded, and from below."""

# The kernel's Python bindings are compiled and carry no names that a type checker could see.
# pyright: reportAttributeAccessIssue=false, reportMissingImports=false

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np

from drawings.pictures.picture import ACROSS, EXPLODED, FROM_BELOW, SCALE, SECTION, TOP, Picture, Piece, picture
from drawings.pictures.scene import DEFLECTION, MeshedShape, meshed, moved
from drawings.views.section import cut_faces, cut_shape, hatch, in_plane
from drawings.views.view import PROJECTIONS, Cut, Projection
from stagecad.solids.assembly.machine import MOVING
from stagecad.solids.modelling.frame import UNMOVED

if TYPE_CHECKING:
    from OCP.TopoDS import TopoDS_Shape

    from stagecad.solids.assembly.assemble import Instance

EYE_BELOW = Projection(
    FROM_BELOW,
    (1 / math.sqrt(2), 1 / math.sqrt(2), 0.0),
    (1 / math.sqrt(6), -1 / math.sqrt(6), 2 / math.sqrt(6)),
)
"""The isometric direction from below, for the parts under the stage."""

_FASTENERS = ("way_screw", "clamp_screw_long", "clamp_screw_short", "bar_screw", "set_screw")
NOT_CUT = (*_FASTENERS, "height_pin_1", "height_pin_2", "piezo", "spring")
"""Parts that a section shows whole: fasteners, pins and springs (ISO 128-3)."""


def machine_picture(
    name: str, instances: Sequence[Instance], scene: Mapping[str, MeshedShape], *, exact: bool = True
) -> Picture | None:
    """One picture of the machine; None for the picture from below where no irons and magnets are under the stage.

    Args:
        name: of the picture.
        instances: all parts in place.
        scene: shapes by `Instance.shape` (`drawings.pictures.scene.scene_of`).
        exact: method of hidden-line removal (`drawings.views.projection.project`).
    """
    match name:
        case "top":
            pieces = [Piece(i.part, scene[i.shape], i.frame) for i in instances]
            return picture(TOP, PROJECTIONS["top"], pieces, exact=exact)
        case "section A-A":
            return _section(SECTION, ALONG_TRAVEL, PROJECTIONS["front"], instances, scene, exact=exact)
        case "section B-B":
            try:
                return _section(ACROSS, ACROSS_TRAVEL, PROJECTIONS["right"], instances, scene, exact=exact)
            except ValueError:
                # The kernel does not cut every solid in every plane; the sheet is then drawn without this section.
                return None
        case "exploded":
            pieces = [Piece(i.part, scene[i.shape], i.exploded, i.trail) for i in instances]
            return picture(EXPLODED, PROJECTIONS["iso"], pieces, exact=exact)
        case "from below":
            pieces = [Piece(i.part, scene[i.shape], i.exploded) for i in instances if i.part in MOVING]
            return picture(FROM_BELOW, EYE_BELOW, pieces, exact=exact) if len(pieces) > 1 else None
        case _:
            raise ValueError(f"there is no picture '{name}' of the machine")


CLOSE_BY = (-0.01, 0.01, -0.2, 0.2, -1.0, 1.0)
"""Distances by which a cutting plane is moved where the kernel cannot cut in it, mm."""
ALONG_TRAVEL = Cut((0.0, 0.0, 0.0), (0.0, -1.0, 0.0), "A")
ACROSS_TRAVEL = Cut((0.0, 0.0, 0.0), (1.0, 0.0, 0.0), "B")
"""Cutting planes through the axis of actuator 1: along the travel, and across it through ways, pads, teeth and bars."""


def _cut_part(shape: TopoDS_Shape, cut: Cut) -> tuple[MeshedShape, list[Any]]:
    """A part behind a cutting plane, and its faces in the plane.

    The kernel may fail where the plane is tangent to a face or contains one: then the plane is moved a little.
    """
    for shift in (0.0, *CLOSE_BY):
        point = tuple(p + shift * n for p, n in zip(cut.point, cut.normal, strict=True))
        plane = replace(cut, point=point)
        try:
            left = cut_shape(shape, plane)
        except ValueError:
            if shift == CLOSE_BY[-1]:
                raise
            continue
        return meshed(left), list(cut_faces(left, plane))
    raise AssertionError("unreachable")


def _section(
    name: str,
    cut: Cut,
    projection: Projection,
    instances: Sequence[Instance],
    scene: Mapping[str, MeshedShape],
    *,
    exact: bool,
) -> Picture:
    """The machine cut by a plane."""
    pieces: list[Piece] = []
    faces_in_plane: dict[int, list[Any]] = {}
    covers: list[np.ndarray] = []
    for number, instance in enumerate(instances):
        shape, frame = scene[instance.shape], instance.frame
        vertices = shape.placed_vertices(frame)
        in_front = (vertices - np.array(cut.point)) @ np.array(cut.normal)
        if in_front.min() > -DEFLECTION:
            continue
        if in_front.max() < DEFLECTION or instance.part in NOT_CUT:
            if in_front.max() > 0.0:
                covers.append(in_plane(vertices, shape.triangles, cut, projection))
            pieces.append(Piece(instance.part, shape, frame))
            continue
        left, faces_in_plane[number] = _cut_part(moved(shape.shape, frame), cut)
        pieces.append(Piece(instance.part, left, UNMOVED))
    # The hatch of neighbouring parts runs in different directions.
    hatched = [
        line
        for number, faces in faces_in_plane.items()
        for line in hatch(faces, projection, SCALE, falling=bool(number % 2), covers=covers)
    ]
    shown = picture(name, projection, pieces, exact=exact)
    curves = {**shown.view.curves, "HATCH": tuple(hatched)}
    return replace(shown, view=replace(shown.view, curves=curves, label=f"{cut.letter}-{cut.letter}", cut=cut))
