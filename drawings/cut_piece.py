"""What a cutting plane leaves of a piece that has triangles: as much of it as a picture can show, and no solid.

Only the faces that cross the plane are cut, all at once, and the plane by them; what lies behind stays as it is, with
the triangles it has. That takes half the time of a solid's cut, and nothing of it has to be meshed but the cut faces.
"""

# The kernel's Python bindings are compiled and carry no names that a type checker could see.
# pyright: reportAttributeAccessIssue=false, reportMissingImports=false

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from drawings.view import Cut
from drawings.visibility import MeshedFaces, compound_of, meshed
from stagecad.solids.frame import Frame

if TYPE_CHECKING:
    from OCP.TopoDS import TopoDS_Shape

NEAR = 0.05
"""How near to the plane the triangles of a face must come for the face to be cut, mm: more than they leave it by."""
BEYOND = 1e-3
"""How far behind the plane it is asked whether there is material, mm."""


def cut_piece(piece: MeshedFaces, frame: Frame, cut: Cut) -> tuple[MeshedFaces, tuple[TopoDS_Shape, ...]]:
    """What is behind the plane of a piece, in place, with the faces that the plane makes; and those by themselves.

    A face of the result may be a compound of several: what is left of one that the plane cut.

    Args:
        piece: in its own coordinates.
        frame: where it stands.
        cut: the plane.

    Raises:
        ValueError: the plane misses the piece.
    """
    corners = piece.corners @ np.array(frame.rotation).T + frame.shift
    normal = np.array(cut.normal)
    heights = (corners - cut.point) @ normal
    of_triangles = heights[piece.triangles]
    low, high = np.full(len(piece.faces), np.inf), np.full(len(piece.faces), -np.inf)
    np.minimum.at(low, piece.owners, of_triangles.min(axis=1))
    np.maximum.at(high, piece.owners, of_triangles.max(axis=1))
    crossing = np.flatnonzero((low < NEAR) & (high > -NEAR)).tolist()
    solid = corners[piece.triangles]
    faces = _placed_faces(piece.faces, frame)
    left, made = _parted([faces[index] for index in crossing], corners, cut)
    for index, pieces in zip(crossing, left, strict=True):
        behind = [face for face in pieces if (_inside(face) - cut.point) @ normal < 0.0]
        faces[index] = compound_of(behind)
    caps = tuple(face for face in made if _holds(solid, _inside(face) - BEYOND * normal, -normal))
    if not caps:
        raise ValueError(f"section {cut.letter}-{cut.letter}: the plane does not cut the part")
    new = meshed(compound_of(caps))
    behind, triangles, owners = _clipped(corners, piece.triangles, piece.owners, heights)
    # Who sees a face from within looks through material: where triangles leave a gap beside a cut face, that is shut.
    return (
        MeshedFaces(
            (*faces, *new.faces),
            np.concatenate((behind, new.corners)),
            np.concatenate((triangles, triangles[:, ::-1], new.triangles + len(behind))),
            np.concatenate((owners, np.full(len(owners), len(faces)), new.owners + len(faces))),
        ),
        caps,
    )


def _placed_faces(faces: Sequence[Any], frame: Frame) -> list[Any]:
    from OCP.TopLoc import TopLoc_Location
    from OCP.TopoDS import TopoDS

    from stagecad.solids.export import transformation

    place = TopLoc_Location(transformation(frame))
    return [TopoDS.Face_s(face.Moved(place)) for face in faces]


def _parted(faces: Sequence[Any], corners: np.ndarray, cut: Cut) -> tuple[list[list[Any]], list[Any]]:
    """The pieces into which a plane parts each of some faces, and those into which they part the plane."""
    from OCP.BRepAlgoAPI import BRepAlgoAPI_BuilderAlgo
    from OCP.BRepBuilderAPI import BRepBuilderAPI_MakeFace
    from OCP.gp import gp_Dir, gp_Pln, gp_Pnt
    from OCP.TopTools import TopTools_ListOfShape

    size = 2.0 * float(np.abs(corners - cut.point).max()) + 1.0
    plane = gp_Pln(gp_Pnt(*cut.point), gp_Dir(*cut.normal))
    sheet = BRepBuilderAPI_MakeFace(plane, -size, size, -size, size).Face()
    arguments = TopTools_ListOfShape()
    # As one argument, so that the faces are not cut by one another.
    arguments.Append(compound_of(faces))
    arguments.Append(sheet)
    algorithm = BRepAlgoAPI_BuilderAlgo()
    algorithm.SetArguments(arguments)
    algorithm.SetNonDestructive(True)
    algorithm.Build()
    if not algorithm.IsDone():
        raise ValueError(f"section {cut.letter}-{cut.letter}: the kernel cannot cut the part")
    return [_images(algorithm, face) for face in faces], _images(algorithm, sheet)


def _images(algorithm: Any, face: Any) -> list[Any]:
    """What has become of a face."""
    from OCP.TopoDS import TopoDS

    if algorithm.IsDeleted(face):
        return []
    return [TopoDS.Face_s(image) for image in algorithm.Modified(face)] or [face]


def _inside(face: Any) -> np.ndarray:
    """A point inside a face."""
    from OCP.BOPTools import BOPTools_AlgoTools3D
    from OCP.gp import gp_Pnt, gp_Pnt2d
    from OCP.IntTools import IntTools_Context

    point = gp_Pnt()
    if BOPTools_AlgoTools3D.PointInFace_s(face, point, gp_Pnt2d(), IntTools_Context()):
        raise ValueError("a face without a point inside")
    return np.array((point.X(), point.Y(), point.Z()))


def _holds(solid: np.ndarray, point: np.ndarray, direction: np.ndarray) -> bool:
    """Whether a closed mesh (n, 3, 3) has a point inside: a ray from there leaves it once more than it enters it."""
    away = solid - point
    # Few of the triangles stand around the ray's line: the others are left out by their boxes.
    u = np.cross(direction, np.eye(3)[np.argmin(np.abs(direction))])
    flat = away @ np.column_stack((u, np.cross(direction, u)))
    around = ((flat.min(axis=1) <= 0.0) & (flat.max(axis=1) >= 0.0)).all(axis=1)
    a, b, c = (away[around, corner] for corner in range(3))
    # Sides of the ray's line on which the edges pass.
    sides = np.column_stack([np.cross(p, q) @ direction for p, q in ((a, b), (b, c), (c, a))])
    through = (sides > 0.0).all(axis=1) | (sides < 0.0).all(axis=1)
    normals = np.cross(b[through] - a[through], c[through] - a[through])
    facing = normals @ direction
    ahead = (normals * a[through]).sum(axis=1) * facing > 0.0
    return int(np.sign(facing[ahead]).sum()) > 0


def _clipped(
    corners: np.ndarray, triangles: np.ndarray, owners: np.ndarray, heights: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """What of some triangles lies below zero height: corners, triangles and their owners."""
    below = heights[triangles] < 0.0
    count = below.sum(axis=1)
    parts, tags = [triangles[count == 3]], [owners[count == 3]]
    added: list[np.ndarray] = []
    free = len(corners)
    for wanted in (1, 2):
        chosen = count == wanted
        lone = np.argmax(below[chosen] if wanted == 1 else ~below[chosen], axis=1)
        # The corner that is alone on its side comes first; the triangles stay the same way round.
        turned = np.take_along_axis(triangles[chosen], (lone[:, None] + np.arange(3)) % 3, axis=1)
        first, second, third = turned.T
        ends = []
        for other in (second, third):
            share = heights[first] / (heights[first] - heights[other])
            added.append(corners[first] + share[:, None] * (corners[other] - corners[first]))
            ends.append(free + np.arange(len(first)))
            free += len(first)
        pieces = [(first, *ends)] if wanted == 1 else [(ends[0], second, third), (ends[0], third, ends[1])]
        parts += [np.column_stack(piece) for piece in pieces]
        tags += [owners[chosen]] * len(pieces)
    return np.concatenate((corners, *added)), np.concatenate(parts), np.concatenate(tags)
