"""What a cutting plane leaves of a piece that has triangles: as much of it as a picture can show, and no solid.

Only the faces that cross the plane are cut, all at once, and the plane by them; what lies behind stays as it is, with
the triangles it has. That takes half the time of a solid's cut, and nothing of it has to be meshed but the cut faces.
"""

# The kernel's Python bindings are compiled and carry no names that a type checker could see.
# pyright: reportAttributeAccessIssue=false, reportMissingImports=false

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from drawings.pictures.visibility import MeshedFaces, Scene, compound_of, faces_of, meshed, moved
from drawings.views.section import cut_faces, cut_shape
from drawings.views.view import Cut
from stagecad.solids.modelling.frame import Frame

if TYPE_CHECKING:
    from OCP.TopoDS import TopoDS_Shape

NEAR = 0.05
"""How near to the plane the triangles of a face must come for the face to be cut, mm: more than they leave it by."""


def cut_piece(scene: Scene, name: str, frame: Frame, cut: Cut) -> tuple[MeshedFaces, tuple[TopoDS_Shape, ...]]:
    """What is behind the plane of a piece, in place, with the faces that the plane makes; and those by themselves.

    A face of the result may be a compound of several: what is left of one that the plane cut. Where the faces that were
    cut do not close to a surface with those that were not, the solid is cut instead, which takes longer.

    Args:
        scene: holds the piece's shape.
        name: of that shape.
        frame: where it stands.
        cut: the plane.

    Raises:
        ValueError: the plane misses the piece.
    """
    piece = scene.faces(name)
    faces = tuple(faces_of(moved(compound_of(piece.faces), frame)))
    corners = piece.corners @ np.array(frame.rotation).T + frame.shift
    placed = MeshedFaces(faces, corners, piece.triangles, piece.owners)
    return faces_cut(placed, cut) or solid_cut(moved(scene.solid(name), frame), cut)


def solid_cut(solid: TopoDS_Shape, cut: Cut) -> tuple[MeshedFaces, tuple[TopoDS_Shape, ...]]:
    """As `cut_piece`, of a solid in place."""
    left = cut_shape(solid, cut)
    return meshed(left), tuple(cut_faces(left, cut))


def faces_cut(piece: MeshedFaces, cut: Cut) -> tuple[MeshedFaces, tuple[TopoDS_Shape, ...]] | None:
    """As `cut_piece` of a piece in place; None where what is found is no closed surface with faces in the plane."""
    normal = np.array(cut.normal)
    heights = (piece.corners - cut.point) @ normal
    low, high = _reach(piece, heights)
    crossing = np.flatnonzero((low < NEAR) & (high > -NEAR)).tolist()
    behind = {index: (face,) for index, face in enumerate(piece.faces) if high[index] <= -NEAR}
    left, regions = _parted([piece.faces[index] for index in crossing], piece.corners, cut)
    for index, pieces in zip(crossing, left, strict=True):
        behind[index] = tuple(face for face in pieces if (_inside(face) - cut.point) @ normal < 0.0)
    caps = bounded([face for index in crossing for face in behind[index]], regions)
    if not caps or not _closed([face for pieces in behind.values() for face in pieces] + caps):
        return None
    new = meshed(compound_of(caps))
    corners, triangles, owners = _clipped(piece.corners, piece.triangles, piece.owners, heights)
    count = len(piece.faces)
    return (
        MeshedFaces(
            (*(compound_of(behind.get(index, ())) for index in range(count)), *new.faces),
            np.concatenate((corners, new.corners)),
            # Who sees a face from within looks through material: where triangles leave a gap beside a cut face, that
            # is shut.
            np.concatenate((triangles, triangles[:, ::-1], new.triangles + len(corners))),
            np.concatenate((owners, np.full(len(owners), count), new.owners + count)),
        ),
        tuple(caps),
    )


def _reach(piece: MeshedFaces, heights: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Least and greatest height of each face's triangles."""
    low, high = np.full(len(piece.faces), np.inf), np.full(len(piece.faces), -np.inf)
    for corner in piece.triangles.T:
        np.minimum.at(low, piece.owners, heights[corner])
        np.maximum.at(high, piece.owners, heights[corner])
    return low, high


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
        return [[] for _ in faces], []
    return [_images(algorithm, face) for face in faces], _images(algorithm, sheet)


def _images(algorithm: Any, face: Any) -> list[Any]:
    """What has become of a face."""
    from OCP.TopoDS import TopoDS
    from OCP.TopTools import TopTools_ListOfShape

    if algorithm.IsDeleted(face):
        return []
    # Emptied one by one, as the binding takes 0.3 ms to begin to iterate over such a list.
    left, images = TopTools_ListOfShape(algorithm.Modified(face)), []
    while left.Size():
        images.append(TopoDS.Face_s(left.First()))
        left.RemoveFirst()
    return images or [face]


def bounded(behind: Sequence[Any], regions: Sequence[Any]) -> list[Any]:
    """The regions of the plane that are cut faces: crossing an edge of a face behind, one comes from air into material.

    The plane's own outline is in air; so is a region that can be reached from there over an even number of such edges.
    """
    from OCP.TopAbs import TopAbs_EDGE
    from OCP.TopExp import TopExp
    from OCP.TopTools import TopTools_IndexedMapOfShape

    known = TopTools_IndexedMapOfShape()
    TopExp.MapShapes_s(compound_of([*behind, *regions]), TopAbs_EDGE, known)
    odd: set[int] = set()
    for face in behind:
        for edge in _edges(face):
            odd ^= {known.FindIndex(edge)}
    beside: dict[int, list[int]] = {}
    for number, region in enumerate(regions):
        for edge in _edges(region):
            beside.setdefault(known.FindIndex(edge), []).append(number)
    material = {ends[0]: False for ends in beside.values() if len(ends) == 1}
    reached = list(material)
    for number in reached:
        for edge, ends in beside.items():
            if number in ends:
                for other in ends:
                    if other not in material:
                        material[other] = material[number] ^ (edge in odd)
                        reached.append(other)
    return [region for number, region in enumerate(regions) if material.get(number)]


def _edges(face: Any) -> Iterator[Any]:
    """Edges of a face, one that it meets on both sides twice."""
    from OCP.TopAbs import TopAbs_EDGE
    from OCP.TopExp import TopExp_Explorer

    explorer = TopExp_Explorer(face, TopAbs_EDGE)
    while explorer.More():
        yield explorer.Current()
        explorer.Next()


def _closed(faces: Sequence[Any]) -> bool:
    """Whether each edge lies between two faces, so that nothing is missing and nothing too much."""
    from OCP.BRep import BRep_Builder, BRep_Tool
    from OCP.TopoDS import TopoDS_Shell

    shell = TopoDS_Shell()
    builder = BRep_Builder()
    builder.MakeShell(shell)
    for face in faces:
        builder.Add(shell, face)
    return BRep_Tool.IsClosed_s(shell)


def _inside(face: Any) -> np.ndarray:
    """A point inside a face."""
    from OCP.BOPTools import BOPTools_AlgoTools3D
    from OCP.gp import gp_Pnt, gp_Pnt2d
    from OCP.IntTools import IntTools_Context

    point = gp_Pnt()
    if BOPTools_AlgoTools3D.PointInFace_s(face, point, gp_Pnt2d(), IntTools_Context()):
        return np.full(3, np.nan)
    return np.array((point.X(), point.Y(), point.Z()))


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
