"""Triangles and outline edges of a solid, in millimetres, for pictures; and STL and GLB of them, as bytes.

GLB has a material that is not metallic (viewers show a metallic one black), lengths in metres and y up, as required by
glTF 2.0 section 3.4.
"""

from __future__ import annotations

import io
import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, cast

import numpy as np

from stagecad.deferred import trimesh
from stagecad.solids.modelling.frame import UNMOVED, Colour, Frame, PlacedShape
from stagecad.solids.modelling.kernel import cq, occ, parts_of

LINEAR = 0.05
"""Largest distance between a triangle and the face, mm."""

ANGULAR = (0.2, 0.17, 0.12, 0.09, 0.06, 0.04)
"""Largest angle between neighbouring chords, rad: the first that preserves the volume is used. A polygon of chords
encloses 1 - angle^2/6 of its circle's area; but the mesher refines a torus further, and a plate has few round faces."""

VOLUME_ERROR = 0.0028
"""Largest relative difference between the volumes of mesh and solid; an exported mesh may have 0.003."""

ROUGHNESS = 0.7
"""Of the material in GLB."""


@dataclass(frozen=True)
class Mesh:
    """Triangles face by face: normals are discontinuous at the edges of the solid and continuous within a face."""

    vertices: np.ndarray  # (n, 3) float64, mm; points on an edge occur once for each adjacent face, bit for bit equal
    normals: np.ndarray  # (n, 3) unit, out of the material
    triangles: np.ndarray  # (m, 3) indices, counter-clockwise seen from outside
    faces: np.ndarray  # (m,) number of the solid's face of each triangle, from 0
    edge_points: np.ndarray  # (k, 3) points of the solid's sharp edges, mm
    edge_ends: np.ndarray  # (e + 1,) index of each edge's first point in `edge_points`, and the end of the last

    @property
    def volume(self) -> float:
        """Volume within the triangles by the divergence theorem, mm^3."""
        a, b, c = (self.vertices[self.triangles[:, i]] for i in range(3))
        return float(np.einsum("ij,ij->", a, np.cross(b, c)) / 6.0)

    def placed(self, frame: Frame) -> Mesh:
        """The mesh where `frame` puts it."""
        if frame == UNMOVED:
            return self
        rotation, shift = np.array(frame.rotation), np.array(frame.shift)
        return replace(
            self,
            vertices=self.vertices @ rotation.T + shift,
            normals=self.normals @ rotation.T,
            edge_points=self.edge_points @ rotation.T + shift,
        )


def mesh_of(shape: cq.Shape, volume: float, *, exported: bool = True) -> Mesh:
    """Mesh of a copy of a solid, fine enough that its volume agrees with the exact one, mm^3, within `VOLUME_ERROR`;
    where none does, the finest one if it is for pictures only."""
    error, needed = 1.0, ANGULAR[0]
    for angular in ANGULAR:
        if angular > needed and angular != ANGULAR[-1]:
            continue
        meshed = _meshed_copy(shape, LINEAR, angular)
        occ.BRepGProp.VolumeProperties_s(meshed, enclosed := occ.GProp_GProps(), False, False, True)
        error = abs(enclosed.Mass() / volume - 1.0)
        if error <= VOLUME_ERROR or (angular == ANGULAR[-1] and not exported):
            return _mesh(meshed)
        # The error falls with the square of the angle, and somewhat faster where the mesher refines a face further.
        needed = 1.2 * angular * math.sqrt(VOLUME_ERROR / error)
    raise ValueError(f"the finest mesh misses the solid's volume by {error:.2%}")


def triangulated(shape: cq.Shape, linear: float, angular: float) -> Mesh:
    """Mesh of a shape within `linear` mm and `angular` rad, without sharp edges."""
    return _mesh(_meshed_copy(shape, linear, angular), edges=False)


def _meshed_copy(shape: cq.Shape, linear: float, angular: float) -> Any:
    """Meshed copy of a shape: a mesh loosens the bounding box and enlarges the stored solid."""
    copy = occ.BRepBuilderAPI_Copy(shape.wrapped, True, False).Shape()
    occ.BRepMesh_IncrementalMesh(copy, linear, False, angular, True)
    return copy


def _mesh(meshed: Any, *, edges: bool = True) -> Mesh:
    """Triangles and sharp edges, unless without these, of a meshed shape of the kernel."""
    faces = list(parts_of(meshed, "Face"))
    vertices: list[np.ndarray] = []
    normals: list[np.ndarray] = []
    triangles: list[np.ndarray] = []
    count = 0
    for face in faces:
        location = occ.TopLoc_Location()
        triangulation = occ.BRep_Tool.Triangulation_s(face, location)
        if triangulation is None:
            raise ValueError("a face of the solid could not be meshed")
        points, outward, corners = _arrays(face, triangulation)
        points, outward = _moved(points, location), _moved(outward, location, directions=True)
        if face.Orientation() == occ.TopAbs_REVERSED:
            corners = corners[:, ::-1]
            outward = -outward
        # At the pole of a sphere a side of a triangle has no length: such a triangle has no area and opens the mesh.
        a, b, c = (points[corners[:, i]] for i in range(3))
        degenerate = (a == b).all(axis=1) | (b == c).all(axis=1) | (c == a).all(axis=1)
        vertices.append(points)
        normals.append(outward)
        triangles.append(corners[~degenerate] + count)
        count += len(points)
    edge_points, edge_ends = _edges(faces if edges else ())
    return Mesh(
        np.concatenate(vertices),
        _unit(np.concatenate(normals)),
        np.concatenate(triangles).astype(np.uint32),
        np.repeat(np.arange(len(triangles), dtype=np.int32), [len(corners) for corners in triangles]),
        edge_points,
        edge_ends,
    )


def _arrays(face: Any, triangulation: Any) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Points (n, 3), surface normals (n, 3) and triangles (m, 3) of a face, in the coordinates of its own location."""
    occ.BRepLib_ToolTriangulatedShape.ComputeNormals_s(face, triangulation)
    nodes = range(1, triangulation.NbNodes() + 1)
    points = [triangulation.Node(i).Coord() for i in nodes]
    normals = [triangulation.Normal(i).Coord() for i in nodes]
    corners = [triangulation.Triangle(i).Get() for i in range(1, triangulation.NbTriangles() + 1)]
    return np.array(points), np.array(normals), np.array(corners, dtype=np.int64) - 1


def _moved(vectors: np.ndarray, location: Any, *, directions: bool = False) -> np.ndarray:
    """Points, or directions, (n, 3) after the rigid motion of a location of the kernel."""
    if location.IsIdentity():
        return vectors
    move = location.Transformation()
    rows = np.array([[move.Value(row, column) for column in range(1, 5)] for row in range(1, 4)])
    return vectors @ rows[:, :3].T + (0.0 if directions else rows[:, 3])


def _edges(meshed: Sequence[Any]) -> tuple[np.ndarray, np.ndarray]:
    """Sharp edges as polylines of the faces' mesh, without seams and tangent joints: points, and where each begins."""
    numbered = occ.TopTools_IndexedMapOfShape()
    beside: list[list[int]] = []
    for index, face in enumerate(meshed):
        for edge in parts_of(face, "Edge"):
            number = numbered.Add(edge)
            if number > len(beside):
                beside.append([])
            beside[number - 1].append(index)
    lines: list[np.ndarray] = []
    for number, indices in enumerate(beside, start=1):
        edge = occ.TopoDS.Edge_s(numbered.FindKey(number))
        faces = [meshed[index] for index in indices]
        if occ.BRep_Tool.Degenerated_s(edge) or len(faces) != 2 or faces[0].IsSame(faces[1]):
            continue
        if occ.BRep_Tool.Continuity_s(edge, faces[0], faces[1]) != occ.GeomAbs_C0 or _tangent(edge, faces):
            continue
        location = occ.TopLoc_Location()
        surface = occ.BRep_Tool.Triangulation_s(faces[0], location)
        polygon = occ.BRep_Tool.PolygonOnTriangulation_s(edge, surface, location)
        if polygon is None:
            continue
        line = [surface.Node(polygon.Node(i)).Coord() for i in range(1, polygon.NbNodes() + 1)]
        lines.append(_moved(np.array(line), location))
    if not lines:
        return np.zeros((0, 3)), np.zeros(1, dtype=np.int64)
    return np.concatenate(lines), np.cumsum([0, *(len(line) for line in lines)])


def _tangent(edge: object, faces: list) -> bool:
    """Whether two faces meet at the middle of an edge without a corner (within 3 degrees)."""
    directions = []
    for face in faces:
        curve = occ.BRepAdaptor_Curve2d(edge, face)  # type: ignore[arg-type]
        place = curve.Value((curve.FirstParameter() + curve.LastParameter()) / 2)
        point, along_u, along_v = occ.gp_Pnt(), occ.gp_Vec(), occ.gp_Vec()
        occ.BRepAdaptor_Surface(face).D1(place.X(), place.Y(), point, along_u, along_v)
        directions.append(along_u.Crossed(along_v))
    if any(direction.Magnitude() < 1e-12 for direction in directions):
        return False
    return directions[0].IsParallel(directions[1], np.radians(3.0))


def _unit(vectors: np.ndarray) -> np.ndarray:
    length = np.linalg.norm(vectors, axis=1, keepdims=True)
    return vectors / np.where(length > 0.0, length, 1.0)


def save(mesh: Mesh, path: Path) -> None:
    """Write a mesh to a file that `load` reads."""
    memory = io.BytesIO()
    np.savez(memory, **{name: getattr(mesh, name) for name in Mesh.__dataclass_fields__})
    path.write_bytes(memory.getvalue())


def load(path: Path) -> Mesh:
    """Read a mesh written by `save`."""
    with np.load(path) as stored:
        return Mesh(**{name: cast(np.ndarray, stored[name]) for name in Mesh.__dataclass_fields__})


def stl_bytes(meshes: Sequence[Mesh]) -> bytes:
    """Binary STL in millimetres, of one or several bodies."""
    data = trimesh.util.concatenate([_body(mesh) for mesh in meshes]).export(file_type="stl")
    return b"binary STL, millimetres".ljust(80) + data[80:]


def glb_bytes(name: str, shapes: Sequence[PlacedShape], meshes: dict[str, Mesh]) -> bytes:
    """glTF 2.0 binary: metres, y up, a root node `name`, one node per shape, one mesh per part, one material per
    colour."""
    scene = trimesh.Scene()
    # The root turns z up into y up; all nodes below it keep the axes of the machine.
    upright = np.array([[1.0, 0.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0], [0.0, -1.0, 0.0, 0.0], [0.0, 0.0, 0.0, 1.0]])
    root = f"{name} upright" if name in {shape.name for shape in shapes} else name
    scene.graph.update(root, matrix=upright)
    for shape in shapes:
        if shape.part not in scene.geometry:
            scene.geometry[shape.part] = _body(meshes[shape.part], 1e-3, shape.colour)
        place = np.eye(4)
        place[:3, :3], place[:3, 3] = shape.frame.rotation, np.array(shape.frame.shift) / 1000.0
        scene.graph.update(shape.name, root, matrix=place, geometry=shape.part)
    return scene.export(file_type="glb", include_normals=True)


def _body(mesh: Mesh, scale: float = 1.0, colour: Colour | None = None) -> Any:
    """A mesh for export, in units of 1 mm / `scale`, of a material that is not metallic where it has a colour."""
    visual = None
    if colour is not None:
        # Colours are sRGB here and linear in glTF.
        linear = [value / 12.92 if value <= 0.04045 else ((value + 0.055) / 1.055) ** 2.4 for value in colour]
        material = trimesh.visual.material.PBRMaterial(
            baseColorFactor=[*linear, 1.0], metallicFactor=0.0, roughnessFactor=ROUGHNESS
        )
        visual = trimesh.visual.TextureVisuals(material=material)
    return trimesh.Trimesh(
        mesh.vertices * scale, mesh.triangles, vertex_normals=mesh.normals, visual=visual, process=False
    )
