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
from typing import TYPE_CHECKING, Any

import numpy as np

from drawings.view import Projection
from stagecad.solids.frame import Frame, Vector
from stagecad.solids.rasteriser import FAR, _fill

if TYPE_CHECKING:
    from OCP.TopoDS import TopoDS_Shape

PIXELS = 1400
"""Of the depth buffer along its longer side: of the machine, a third of a millimetre each."""
DEFLECTION, TURN = 0.5, 0.6
"""Of the triangles from the faces: mm, and rad between neighbours."""


@dataclass(frozen=True)
class _Faces:
    """The faces of one shape, and their triangles together."""

    faces: tuple[Any, ...]
    corners: np.ndarray
    triangles: np.ndarray
    owners: np.ndarray


class Scene:
    """Shapes that stand in one or several places, meshed once.

    Args:
        shapes: by name, each in its own coordinates.
    """

    def __init__(self, shapes: Mapping[str, TopoDS_Shape]) -> None:
        self._meshed = {name: _meshed(shape) for name, shape in shapes.items()}

    def with_more(self, shapes: Mapping[str, TopoDS_Shape]) -> Scene:
        """A scene with some shapes more; those that are here already are not meshed again."""
        scene = Scene(shapes)
        scene._meshed = {**self._meshed, **scene._meshed}
        return scene

    def reach(self, name: str, frame: Frame, along: Vector) -> tuple[float, float]:
        """Least and greatest place of a piece along a direction, mm; short by the triangles' deflection at most."""
        places = (self._meshed[name].corners @ np.array(frame.rotation).T + frame.shift) @ np.array(along)
        return float(places.min()), float(places.max())

    def visible(self, pieces: Sequence[tuple[str, Frame]], projection: Projection) -> list[TopoDS_Shape | None]:
        """What is seen of each piece.

        Args:
            pieces: name of the shape, and where it stands.
            projection: direction of view.

        Returns:
            For each piece, in place, the faces that are in front somewhere; None where there are none.
        """
        seen = self._seen(pieces, projection)
        found: list[TopoDS_Shape | None] = []
        start = 0
        for name, frame in pieces:
            faces = self._meshed[name].faces
            shown = [face for index, face in enumerate(faces) if start + index in seen]
            found.append(_compound(shown, frame) if shown else None)
            start += len(faces)
        return found

    def _seen(self, pieces: Sequence[tuple[str, Frame]], projection: Projection) -> set[int]:
        """Numbers of the faces that are in front somewhere, counted through all pieces."""
        axes = np.array([projection.right, [-c for c in projection.up], [-c for c in projection.towards_eye]])
        points, triangles, owners = [], [], []
        corners = faces = 0
        for name, frame in pieces:
            meshed = self._meshed[name]
            points.append((meshed.corners @ np.array(frame.rotation).T + frame.shift) @ axes.T)
            triangles.append(meshed.triangles + corners)
            owners.append(meshed.owners + faces)
            corners += len(meshed.corners)
            faces += len(meshed.faces)
        places = np.concatenate(points)
        low, high = places.min(axis=0), places.max(axis=0)
        places = (places - low) * (PIXELS / max(high[0] - low[0], high[1] - low[1]))
        size = (int(np.ceil(places[:, 1].max())) + 1, int(np.ceil(places[:, 0].max())) + 1)
        paint = np.full(size, -1, dtype=np.int32)
        _fill(
            places,
            np.zeros_like(places),
            np.concatenate(triangles),
            np.concatenate(owners).astype(np.int32),
            np.full(size, FAR, dtype=np.float32),
            np.zeros((*size, 3), dtype=np.float32),
            paint,
        )
        return set(np.flatnonzero(np.bincount(paint.ravel() + 1, minlength=1)[1:]).tolist())


def _compound(faces: Sequence[Any], frame: Frame) -> TopoDS_Shape:
    from OCP.BRep import BRep_Builder
    from OCP.TopLoc import TopLoc_Location
    from OCP.TopoDS import TopoDS_Compound

    from stagecad.solids.export import transformation

    compound = TopoDS_Compound()
    builder = BRep_Builder()
    builder.MakeCompound(compound)
    for face in faces:
        builder.Add(compound, face)
    return compound.Moved(TopLoc_Location(transformation(frame)))


def _meshed(shape: TopoDS_Shape) -> _Faces:
    from OCP.BRepMesh import BRepMesh_IncrementalMesh

    BRepMesh_IncrementalMesh(shape, DEFLECTION, False, TURN, False)
    faces = tuple(_faces(shape))
    corners, triangles, owners = [np.zeros((0, 3))], [np.zeros((0, 3), dtype=np.int64)], [np.zeros(0, dtype=np.int64)]
    count = 0
    for index, face in enumerate(faces):
        places, faceted = _triangles(face)
        corners.append(places)
        triangles.append(faceted + count)
        owners.append(np.full(len(faceted), index))
        count += len(places)
    return _Faces(faces, np.concatenate(corners), np.concatenate(triangles), np.concatenate(owners))


def _faces(shape: TopoDS_Shape) -> Iterator[Any]:
    from OCP.TopAbs import TopAbs_FACE
    from OCP.TopExp import TopExp_Explorer
    from OCP.TopoDS import TopoDS

    explorer = TopExp_Explorer(shape, TopAbs_FACE)
    while explorer.More():
        yield TopoDS.Face_s(explorer.Current())
        explorer.Next()


def _triangles(face: Any) -> tuple[np.ndarray, np.ndarray]:
    """Corners and triangles of a meshed face, turning so that one sees it from outside the material."""
    from OCP.BRep import BRep_Tool
    from OCP.TopAbs import TopAbs_REVERSED
    from OCP.TopLoc import TopLoc_Location

    location = TopLoc_Location()
    mesh = BRep_Tool.Triangulation_s(face, location)
    if mesh is None:
        return np.zeros((0, 3)), np.zeros((0, 3), dtype=np.int64)
    places = np.array([mesh.Node(i).Coord() for i in range(1, mesh.NbNodes() + 1)])
    if not location.IsIdentity():
        move = location.Transformation()
        rows = np.array([[move.Value(row, column) for column in range(1, 5)] for row in range(1, 4)])
        places = places @ rows[:, :3].T + rows[:, 3]
    faceted = np.array([mesh.Triangle(i).Get() for i in range(1, mesh.NbTriangles() + 1)]) - 1
    return places, faceted[:, ::-1] if face.Orientation() == TopAbs_REVERSED else faceted
