"""Views of an assembly: pieces in place that hide one another.

A depth buffer (z-buffer) of all triangles shows which faces are in front somewhere. Only these are given to the exact
hidden-line removal, because its time grows with the number of faces that overlap in projection: without the buffer the
section of the machine takes 2.4 s instead of 0.5 s, and the command ``drawings assembly`` a quarter longer. A face that
is nowhere in front hides nothing that is visible.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from typing import Any

import numba
import numpy as np

from drawings.views.line_cleaning import cleaned
from drawings.views.projection import hidden_lines
from drawings.views.view import Curve, Projection, Segment, View, dot
from stagecad.parameters.dimension import Point
from stagecad.solids.export.mesh import Mesh, triangulated
from stagecad.solids.modelling.frame import UNMOVED, Frame
from stagecad.solids.modelling.kernel import KernelShape, compound_of, cq, moved, parts_of
from stagecad.solids.modelling.surface import Surface, surface_of

PIXELS = 2800
"""Number of pixels of the depth buffer along its longer side."""
DEFLECTION, TURN = 0.5, 0.6
"""Tolerances of the mesher for a shape that has no triangles yet: chord error in mm, angle between facets in rad."""
FINE = (0.05, 0.3)
"""The same for the views of a part by itself."""

SHORTEST = 4.0
"""Length of a visible stretch of a line below which it is left out, mm."""


@dataclass(frozen=True)
class MeshedShape:
    """A shape, and the triangles of its faces in one array."""

    shape: KernelShape  # in its own coordinates
    faces: tuple[Any, ...]  # of the shape, in the order of the kernel
    vertices: np.ndarray  # (n, 3), mm
    triangles: np.ndarray  # (m, 3) indices into `vertices`, counter-clockwise seen from outside
    owners: np.ndarray  # (m,) index of the face of each triangle

    def placed_vertices(self, frame: Frame) -> np.ndarray:
        """The vertices (n, 3) of the shape placed by a frame."""
        return self.vertices @ np.array(frame.rotation).T + frame.shift


Scene = Mapping[str, MeshedShape]
"""Shapes by name."""


def scene_of(shapes: Mapping[str, KernelShape], meshes: Mapping[str, Mesh]) -> dict[str, MeshedShape]:
    """Shapes with their triangles, by name; a shape without a mesh is meshed here."""
    return {name: meshed(shape, meshes.get(name)) for name, shape in shapes.items()}


@dataclass(frozen=True)
class DepthBuffer:
    """Depth and number of the face in front, by pixel."""

    axes: np.ndarray  # (3, 3), its rows the directions of columns, rows (down) and depth (away from the eye)
    low: np.ndarray  # least coordinates along them, mm
    pixel: float  # size, mm
    # (rows, columns); depth: pixels, infinite for none; front: number of the face, -1 for none
    depth: np.ndarray
    front: np.ndarray


def depth_buffer(
    pieces: Sequence[tuple[MeshedShape, Frame]], projection: Projection, pixels: int = PIXELS
) -> DepthBuffer:
    """The depth buffer of placed shapes, faces numbered in their order; `pixels` along its longer side."""
    # Columns to the right, rows downwards, depth away from the eye.
    axes = np.array([projection.right, [-c for c in projection.up], [-c for c in projection.towards_eye]])
    first_vertex = np.cumsum([0, *(len(piece.vertices) for piece, _ in pieces)])
    first_face = np.cumsum([0, *(len(piece.faces) for piece, _ in pieces)])
    points = np.concatenate([piece.placed_vertices(frame) @ axes.T for piece, frame in pieces])
    low, high = points.min(axis=0), points.max(axis=0)
    pixel = float((high - low)[:2].max()) / pixels
    width, height = (int(np.ceil(extent / pixel)) + 1 for extent in (high - low)[:2])
    depth, front = np.full((height, width), np.inf, dtype=np.float32), np.full((height, width), -1, dtype=np.int32)
    points = (points - low) / pixel
    for (piece, _), vertex, face in zip(pieces, first_vertex, first_face, strict=False):
        _rasterise(points, piece.triangles + vertex, piece.owners + face, depth, front)
    return DepthBuffer(axes, low, pixel, depth, front)


def visible_faces(pieces: Sequence[tuple[MeshedShape, Frame]], projection: Projection) -> list[KernelShape | None]:
    """For each placed shape, a compound of its faces that are in front somewhere; None where there are none."""
    front = depth_buffer(pieces, projection).front
    first_face = np.cumsum([0, *(len(piece.faces) for piece, _ in pieces)])
    visible = np.zeros(first_face[-1], dtype=bool)
    visible[front[front >= 0]] = True
    found: list[KernelShape | None] = []
    for (piece, frame), begin in zip(pieces, first_face, strict=False):
        shown = [face for number, face in enumerate(piece.faces, start=begin) if visible[number]]
        found.append(moved(compound_of(shown), frame) if shown else None)
    return found


PART_PIXELS = 1400
"""Number of pixels along the longer side of the depth buffer of a single part."""
WITHIN = 2.0
"""Distance from the corner of a triangle, in pixels, of the point where it is looked for."""
EDGE_ON = 1e-6
"""Cosine between the normal of a triangle and the direction of view up to which it is seen edge-on: rounding errors."""


def faces_of_view(shape: MeshedShape, projection: Projection) -> KernelShape:
    """The faces of a solid that a view of its visible lines needs, as a compound.

    Left out are faces that are seen from behind or edge-on, since each of their visible edges, or one in front of it,
    belongs to a face that is seen from the front; and faces that others hide. A face is taken as hidden if it is
    nowhere in front in the depth buffer, and the centroid of each of its triangles, and the points two pixels within
    its corners, are behind all pixels around them. So the strip of a slightly curved face that is narrower than a pixel
    counts. Not found is a face of which only less than two pixels are visible, at an edge of what hides the rest.
    """
    buffer = depth_buffer([(shape, UNMOVED)], projection, PART_PIXELS)
    corners = ((shape.vertices @ buffer.axes.T - buffer.low) / buffer.pixel)[shape.triangles]
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    # The third axis points away from the eye, and rows count downwards.
    towards = normals[:, 2] < -EDGE_ON * np.linalg.norm(normals, axis=1)
    surfaces = [surface_of(cq.Face(face)) for face in shape.faces]
    along = [s.kind == "CYLINDER" and abs(dot(s.axis, projection.towards_eye)) > 1 - EDGE_ON for s in surfaces]
    towards &= ~np.array(along)[shape.owners]
    front = _with_rims(buffer, [s for s, one in zip(surfaces, along, strict=True) if one and not s.outward])
    middle = corners[towards].mean(axis=1, keepdims=True)
    inwards = middle - corners[towards]
    part = np.minimum(1.0, WITHIN / np.maximum(np.linalg.norm(inwards[..., :2], axis=-1, keepdims=True), WITHIN))
    points = np.concatenate([corners[towards] + part * inwards, middle], axis=1)
    around = np.array([(row, column) for row in (-1, 0, 1) for column in (-1, 0, 1)])
    rows, columns = (
        np.clip(points[..., axis, None].astype(int) + around[:, step], 0, buffer.depth.shape[step] - 1)
        for axis, step in ((1, 0), (0, 1))
    )
    free = points[..., 2] <= buffer.depth[rows, columns].max(axis=-1)
    needed = np.zeros(len(shape.faces), dtype=bool)
    needed[front[front >= 0]] = True
    needed[shape.owners[towards][free.any(axis=1)]] = True
    return compound_of([face for face, need in zip(shape.faces, needed, strict=True) if need])


def _with_rims(buffer: DepthBuffer, bores: Sequence[Surface]) -> np.ndarray:
    """The faces in front, where the rims of bores along the direction of view hide what is deeper within `WITHIN`: the
    triangles of a bore and of those that cross it are apart by their accuracy, and show faces that begin at its wall.
    """
    front = buffer.front
    for bore in bores:
        column, row, _ = (buffer.axes @ bore.origin - buffer.low) / buffer.pixel
        near = min(buffer.axes[2] @ vertex - buffer.low[2] for vertex in bore.vertices) / buffer.pixel + WITHIN
        radius, reach = bore.radius / buffer.pixel, bore.radius / buffer.pixel + WITHIN + 1
        area = tuple(slice(max(0, int(middle - reach)), int(middle + reach) + 2) for middle in (row, column))
        rows, columns = np.ogrid[tuple(slice(one.start, min(one.stop, n)) for one, n in zip(area, front.shape))]
        rim = abs(np.hypot(rows + 0.5 - row, columns + 0.5 - column) - radius) < WITHIN
        front[area][rim & (buffer.depth[area] > near)] = -1
        buffer.depth[area][rim] = np.minimum(buffer.depth[area][rim], near)
    return front


MANY_FACES = 60
"""Number of faces of a part up to which hidden-line removal takes less than to find the faces that a view needs: six
views of a shaft of 81 faces take 0.5 s either way, of a block of 95 faces with crossing bores 0.6 instead of 4 s."""


def faces_of_views(shape: KernelShape, mesh: Mesh | None) -> Callable[[Projection], KernelShape]:
    """What gives the faces of a solid that its visible lines in a direction of view need (`faces_of_view`)."""
    if sum(1 for _ in parts_of(shape, "Face")) <= MANY_FACES:
        return lambda projection: shape
    return partial(faces_of_view, meshed(shape, mesh or triangulated(cq.Shape.cast(shape), *FINE)))


def visible_stretches(
    pieces: Sequence[tuple[MeshedShape, Frame]], projection: Projection, lines: Sequence[tuple[Point, Point]]
) -> list[Segment]:
    """Stretches of lines in space, given by their ends, that no shape in its place hides, longer than `SHORTEST`, in
    view coordinates."""
    buffer = depth_buffer(pieces, projection)
    found: list[Segment] = []
    for start, end in np.array(lines, dtype=float).reshape(-1, 2, 3):
        count = max(2, int(np.linalg.norm(end - start)))
        along = np.linspace(0.0, 1.0, count + 1)[:, None]
        points = start + along * (end - start)
        at = (points @ buffer.axes.T - buffer.low) / buffer.pixel
        column = np.clip(at[:, 0].astype(int), 0, buffer.depth.shape[1] - 1)
        row = np.clip(at[:, 1].astype(int), 0, buffer.depth.shape[0] - 1)
        free = np.concatenate([[False], at[:, 2] < buffer.depth[row, column], [False]])
        for first, last in np.flatnonzero(free[1:] != free[:-1]).reshape(-1, 2):
            u, v = (projection.to_view((x, y, z)) for x, y, z in points[[first, last - 1]].tolist())
            if np.hypot(v[0] - u[0], v[1] - u[1]) > SHORTEST:
                found.append(Segment(u, v))
    return found


@numba.njit(cache=True)
def _rasterise(points, triangles, owners, depth, front):  # pragma: no cover - compiled
    """Draw triangles of `points` (column, row, depth in pixels) and the numbers of their faces into a depth buffer."""
    height, width = depth.shape
    x, y = np.empty(3), np.empty(3)
    for t in range(triangles.shape[0]):
        a, b, c = triangles[t, 0], triangles[t, 1], triangles[t, 2]
        x[0], y[0], za = points[a, 0], points[a, 1], points[a, 2]
        x[1], y[1], zb = points[b, 0], points[b, 1], points[b, 2]
        x[2], y[2], zc = points[c, 0], points[c, 1], points[c, 2]
        area = (x[1] - x[0]) * (y[2] - y[0]) - (x[2] - x[0]) * (y[1] - y[0])
        if area >= 0.0:
            # Back face (rows count downwards): the solid is closed, another face hides it.
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
                    front[row, column] = owners[t]
                z += along


def meshed(shape: KernelShape, mesh: Mesh | None = None) -> MeshedShape:
    """A shape with its triangles: of a given mesh, else of the kernel's mesher."""
    mesh = mesh or triangulated(cq.Shape.cast(shape), DEFLECTION, TURN)
    faces = tuple(parts_of(shape, "Face"))
    return MeshedShape(shape, faces, mesh.vertices, mesh.triangles.astype(np.int64), mesh.faces.astype(np.int64))


TOP, SECTION, SIDE_SECTION = "top", "section A-A", "section B-B"
EXPLODED, FROM_BELOW = "exploded", "from below"
"""Names of the machine's pictures, and of their views."""
SCALE = 0.5
"""Scale of the views of the whole machine."""
CHORD = 0.015
"""Greatest distance of a polyline of these views from its curve, mm on the paper."""


@dataclass(frozen=True)
class Piece:
    """A shape of an assembly in place."""

    part: str  # name of its part
    shape: MeshedShape  # in its own coordinates
    frame: Frame  # position and orientation in the assembly


@dataclass(frozen=True)
class Picture:
    """One view of an assembly."""

    view: View  # not yet placed
    pieces: tuple[tuple[str, tuple[Curve, ...]], ...]  # part of each piece, and its visible lines


def picture(
    name: str, projection: Projection, pieces: Sequence[Piece], scale: float = SCALE, *, exact: bool = True
) -> Picture:
    """The visible lines of an assembly."""
    chord = CHORD / scale
    faces = visible_faces([(piece.shape, piece.frame) for piece in pieces], projection)
    lines = hidden_lines(faces, projection, chord=chord, exact=exact)
    visible, _ = cleaned((curve for piece in lines for curve in piece), chord=chord)
    parts = tuple((piece.part, curves) for piece, curves in zip(pieces, lines, strict=True))
    return Picture(View(name, projection, {"VISIBLE": visible}, scale), parts)
