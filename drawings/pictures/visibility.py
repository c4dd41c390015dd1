"""Which faces of a scene can be seen at all: a depth buffer sorts out the rest before hidden lines are removed exactly.

The time of the exact algorithm grows with the square of the faces that overlap in projection, most of which are inside
holes or behind others: the machine seen from the front takes it 15 s, and its visible faces 0.1 s. A face that is
nowhere in front hides nothing that is seen, and shows no line that is not another face's as well.
"""

# The kernel's Python bindings are compiled and carry no names that a type checker could see.
# pyright: reportAttributeAccessIssue=false, reportMissingImports=false

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numba
import numpy as np

from drawings.pictures.depth_refinement import CloseUp
from drawings.pictures.spring_outline import Wire, wire_of
from drawings.views.section import in_plane
from drawings.views.view import Cut, Projection
from stagecad.solids.export.triangulation import triangulations
from stagecad.solids.modelling.frame import Frame, Vector

if TYPE_CHECKING:
    from OCP.TopoDS import TopoDS_Shape

    from stagecad.solids.export.mesh import Mesh

PIXELS = 1400
"""Of the depth buffer along its longer side: of the machine, a third of a millimetre each."""
BESIDE = 3
"""How far round a piece it is looked for what may be before it, pixels."""
DEFLECTION, TURN = 0.5, 0.6
"""Of the triangles from the faces of a shape that comes without: mm, and rad between neighbours."""


@dataclass(frozen=True)
class MeshedFaces:
    """The faces of one shape, and their triangles together.

    Attributes:
        faces: of the shape, in its own order.
        corners: of the triangles, mm, (n, 3).
        triangles: three corners of each.
        owners: the face of each.
    """

    faces: tuple[Any, ...]
    corners: np.ndarray
    triangles: np.ndarray
    owners: np.ndarray


class Scene:
    """Shapes that stand in one or several places.

    Args:
        shapes: by name, each in its own coordinates.
        meshes: of those that have one already; the others are meshed here.
    """

    def __init__(self, shapes: Mapping[str, TopoDS_Shape], meshes: Mapping[str, Mesh] | None = None) -> None:
        there = meshes or {}
        self._solids = dict(shapes)
        self._meshed = {name: _with_mesh(shape, there.get(name)) for name, shape in shapes.items()}

    def with_more(self, shapes: Mapping[str, MeshedFaces]) -> Scene:
        """A scene with some shapes more."""
        scene = Scene({})
        scene._solids = self._solids
        scene._meshed = {**self._meshed, **shapes}
        return scene

    def faces(self, name: str) -> MeshedFaces:
        """A shape's faces with their triangles."""
        return self._meshed[name]

    def solid(self, name: str) -> TopoDS_Shape:
        """A shape as it came."""
        return self._solids[name]

    def reach(self, name: str, frame: Frame, along: Vector) -> tuple[float, float]:
        """Least and greatest place of a piece along a direction, mm; short by the triangles' deflection at most."""
        places = (self._meshed[name].corners @ np.array(frame.rotation).T + frame.shift) @ np.array(along)
        return float(places.min()), float(places.max())

    def in_plane(self, name: str, frame: Frame, cut: Cut, projection: Projection) -> np.ndarray:
        """The outlines of a piece in a cutting plane, as its triangles have them
        (`drawings.views.section.in_plane`)."""
        piece = self._meshed[name]
        return in_plane(piece.corners @ np.array(frame.rotation).T + frame.shift, piece.triangles, cut, projection)

    def wire(self, name: str) -> Wire | None:
        """The round wire that a shape is; None where it is anything else."""
        return wire_of(face for part in self._meshed[name].faces for face in faces_of(part))

    def standing(self, pieces: Sequence[tuple[str, Frame]], projection: Projection) -> Standing:
        """Some pieces as one direction of view shows them.

        Args:
            pieces: name of the shape, and where it stands.
            projection: direction of view.
        """
        return Standing(projection, tuple((self._meshed[name], frame) for name, frame in pieces))


class Standing:
    """Pieces as one direction of view shows them."""

    def __init__(self, projection: Projection, pieces: Sequence[tuple[MeshedFaces, Frame]]) -> None:
        self._projection = projection
        self._pieces = pieces
        axes = np.array([projection.right, [-c for c in projection.up], [-c for c in projection.towards_eye]])
        points = [(meshed.corners @ np.array(frame.rotation).T + frame.shift) @ axes.T for meshed, frame in pieces]
        corners = np.cumsum([0, *(len(part) for part in points)])
        faces = np.cumsum([0, *(len(meshed.faces) for meshed, _ in pieces)])
        self._begins = corners
        self._first_faces = faces
        self._points = np.concatenate(points)
        self._low, self._high = self._points.min(axis=0), self._points.max(axis=0)
        self._pixel = float((self._high - self._low)[:2].max()) / PIXELS
        self._tiles = np.cumsum([0, *(len(meshed.triangles) for meshed, _ in pieces)])
        self._triangles = np.concatenate([m.triangles + first for (m, _), first in zip(pieces, corners, strict=False)])
        self._owners = np.concatenate([m.owners + first for (m, _), first in zip(pieces, faces, strict=False)])

    def visible(self, twins: Mapping[int, int] | None = None) -> list[TopoDS_Shape | None]:
        """For each piece, in place, the faces that are in front somewhere; None where there are none.

        Args:
            twins: pieces that look like others of their shape: what is seen of one is seen of both, though where the
                pixels lie may let a sliver slip through.
        """
        _, paint = self._whole
        there = _found(paint, int(self._first_faces[-1]))
        for number, first in (twins or {}).items():
            own, like = (slice(*self._first_faces[which : which + 2]) for which in (number, first))
            there[like] |= there[own]
        seen = np.flatnonzero(there)
        found: list[TopoDS_Shape | None] = []
        for (meshed, frame), first, end in zip(self._pieces, self._first_faces, self._first_faces[1:], strict=False):
            shown = [meshed.faces[index - first] for index in seen[(seen >= first) & (seen < end)]]
            found.append(moved(compound_of(shown), frame) if shown else None)
        return found

    def foremost(self, piece: int) -> bool:
        """Whether nothing stands before a piece, nor beside it so near that some of it might.

        What would escape is a thing before the piece that is thinner than a pixel throughout.
        """
        begin, end = self._begins[piece], self._begins[piece + 1]
        places = (self._points[begin:end] - self._low) / self._pixel
        low, high = places.min(axis=0), places.max(axis=0)
        left, top = (max(int(value) - BESIDE, 0) for value in low[:2])
        right, bottom = (int(value) + 1 + BESIDE for value in high[:2])
        depth, paint = (buffer[top:bottom, left:right] for buffer in self._whole)
        mine = (paint >= self._first_faces[piece]) & (paint < self._first_faces[piece + 1])
        if _beset(mine, depth, high[2]):
            return False
        alone, free = np.full(paint.shape, -1, dtype=np.int32), np.full(paint.shape, np.inf, dtype=np.float32)
        tiles = slice(self._tiles[piece], self._tiles[piece + 1])
        _fill(places - (left, top, 0.0), self._triangles[tiles] - begin, self._owners[tiles], free, alone)
        return bool((mine == (alone >= 0)).all())

    @cached_property
    def _whole(self) -> tuple[np.ndarray, np.ndarray]:
        """Depth and faces of the whole picture."""
        return self._painted(self._low, self._high, self._pixel)

    def close_up(self, piece: int, pixel: float) -> CloseUp:
        """What is in front around one piece, at a pixel of so many mm."""
        own = self._points[self._begins[piece] : self._begins[piece + 1]]
        low, high = own.min(axis=0) - 2 * pixel, own.max(axis=0) + 2 * pixel
        depth, paint = self._painted(low, high, pixel)
        own = (paint >= self._first_faces[piece]) & (paint < self._first_faces[piece + 1])
        return CloseUp(self._projection, (float(low[0]), float(low[1])), pixel, depth * pixel + low[2], own)

    def _painted(self, low: np.ndarray, high: np.ndarray, pixel: float) -> tuple[np.ndarray, np.ndarray]:
        """Depth, in pixels from `low`, and number of the face in front, -1 for none, within a box."""
        places = (self._points - low) / pixel
        size = (int(np.ceil((high[1] - low[1]) / pixel)) + 1, int(np.ceil((high[0] - low[0]) / pixel)) + 1)
        paint = np.full(size, -1, dtype=np.int32)
        depth = np.full(size, np.inf, dtype=np.float32)
        _fill(places, self._triangles, self._owners, depth, paint)
        return depth, paint


@numba.njit(cache=True)
def _fill(points, triangles, owners, depth, paint):  # pragma: no cover - compiled
    """Owners of triangles into a picture, the nearest at each place; points are (column, row, depth)."""
    height, width = depth.shape
    x, y = np.empty(3), np.empty(3)
    for t in range(triangles.shape[0]):
        a, b, c = triangles[t, 0], triangles[t, 1], triangles[t, 2]
        x[0], y[0], za = points[a, 0], points[a, 1], points[a, 2]
        x[1], y[1], zb = points[b, 0], points[b, 1], points[b, 2]
        x[2], y[2], zc = points[c, 0], points[c, 1], points[c, 2]
        area = (x[1] - x[0]) * (y[2] - y[0]) - (x[2] - x[0]) * (y[1] - y[0])
        if area >= 0.0:
            # Seen from behind (rows count downwards): the solid is closed, another face hides it.
            continue
        first = max(0, int(np.ceil(min(y[0], y[1], y[2]) - 0.5)))
        last = min(height - 1, int(np.floor(max(y[0], y[1], y[2]) - 0.5)))
        if first > last:
            continue
        along = ((zb - za) * (y[2] - y[0]) - (zc - za) * (y[1] - y[0])) / area
        down = ((zc - za) * (x[1] - x[0]) - (zb - za) * (x[2] - x[0])) / area
        for row in range(first, last + 1):
            middle = row + 0.5
            left, right = np.inf, -np.inf
            for side in range(3):
                other = (side + 1) % 3
                low, high = y[side], y[other]
                if low != high and min(low, high) <= middle <= max(low, high):
                    place = x[side] + (middle - low) * (x[other] - x[side]) / (high - low)
                    left, right = min(left, place), max(right, place)
            if left > right:
                continue
            begin, end = max(0, int(np.ceil(left - 0.5))), min(width - 1, int(np.floor(right - 0.5)))
            z = za + (middle - y[0]) * down + (begin + 0.5 - x[0]) * along
            for column in range(begin, end + 1):
                if z < depth[row, column]:
                    depth[row, column] = z
                    paint[row, column] = owners[t]
                z += along


@numba.njit(cache=True)
def _found(paint, count):  # pragma: no cover - compiled
    """Which of so many numbers a picture has."""
    found = np.zeros(count, dtype=np.bool_)
    for row in range(paint.shape[0]):
        for column in range(paint.shape[1]):
            if paint[row, column] >= 0:
                found[paint[row, column]] = True
    return found


@numba.njit(cache=True)
def _beset(mine, depth, reach):  # pragma: no cover - compiled
    """Whether something no deeper than that stands `BESIDE` pixels or less from where a mask is true."""
    height, width = mine.shape
    for row in range(height):
        for column in range(width):
            if mine[row, column] or depth[row, column] > reach:
                continue
            for other in range(max(0, row - BESIDE), min(height, row + BESIDE + 1)):
                for place in range(max(0, column - BESIDE), min(width, column + BESIDE + 1)):
                    if mine[other, place]:
                        return True
    return False


def _with_mesh(shape: TopoDS_Shape, mesh: Mesh | None) -> MeshedFaces:
    if mesh is None:
        return meshed(shape)
    return MeshedFaces(
        tuple(faces_of(shape)), mesh.vertices, mesh.triangles.astype(np.int64), mesh.faces.astype(np.int64)
    )


def compound_of(faces: Sequence[Any]) -> TopoDS_Shape:
    """Faces as one shape."""
    from OCP.BRep import BRep_Builder
    from OCP.TopoDS import TopoDS_Compound

    compound = TopoDS_Compound()
    builder = BRep_Builder()
    builder.MakeCompound(compound)
    for face in faces:
        builder.Add(compound, face)
    return compound


def moved(shape: TopoDS_Shape, frame: Frame) -> TopoDS_Shape:
    """A shape where it stands."""
    from OCP.TopLoc import TopLoc_Location

    from stagecad.solids.export.step_stl_glb import transformation

    return shape.Moved(TopLoc_Location(transformation(frame)))


def meshed(shape: TopoDS_Shape) -> MeshedFaces:
    """The faces of a shape, and triangles made now."""
    from OCP.BRepMesh import BRepMesh_IncrementalMesh
    from OCP.TopAbs import TopAbs_REVERSED

    BRepMesh_IncrementalMesh(shape, DEFLECTION, False, TURN, False)
    faces = tuple(faces_of(shape))
    corners, triangles, owners = [np.zeros((0, 3))], [np.zeros((0, 3), dtype=np.int64)], [np.zeros(0, dtype=np.int64)]
    count = 0
    for index, (face, mesh) in enumerate(zip(faces, triangulations(faces), strict=True)):
        corners.append(_placed(mesh.places, face))
        triangles.append((mesh.corners[:, ::-1] if face.Orientation() == TopAbs_REVERSED else mesh.corners) + count)
        owners.append(np.full(len(mesh.corners), index))
        count += len(mesh.places)
    return MeshedFaces(faces, np.concatenate(corners), np.concatenate(triangles), np.concatenate(owners))


def faces_of(shape: TopoDS_Shape) -> Iterator[Any]:
    """Faces of a shape, in its own order."""
    from OCP.TopAbs import TopAbs_FACE
    from OCP.TopExp import TopExp_Explorer
    from OCP.TopoDS import TopoDS

    explorer = TopExp_Explorer(shape, TopAbs_FACE)
    while explorer.More():
        yield TopoDS.Face_s(explorer.Current())
        explorer.Next()


def _placed(places: np.ndarray, face: Any) -> np.ndarray:
    """Corners of a face's triangles where the face stands."""
    from OCP.BRep import BRep_Tool
    from OCP.TopLoc import TopLoc_Location

    location = TopLoc_Location()
    BRep_Tool.Triangulation_s(face, location)
    if location.IsIdentity():
        return places
    move = location.Transformation()
    rows = np.array([[move.Value(row, column) for column in range(1, 5)] for row in range(1, 4)])
    return places @ rows[:, :3].T + rows[:, 3]
