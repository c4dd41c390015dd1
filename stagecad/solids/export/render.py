"""Shaded pictures of parts and assembly, seen from the front right above, as PNG."""

from __future__ import annotations

import io
from collections.abc import Sequence

import numpy as np

from stagecad.solids.export.mesh import Mesh
from stagecad.solids.modelling.placed_shape import PlacedShape

SIZE = (1400, 1000)
MARGIN = 0.06

ISOMETRIC = (1.0, -1.15, 0.85)
"""Where the viewer stands, seen from the part: in front (-y), to the right (+x) and above."""

BELOW = (1.0, -1.15, -0.85)
"""The same from below, where the stage's working faces are."""


def picture(
    pieces: Sequence[PlacedShape],
    meshes: dict[str, Mesh],
    viewer: tuple[float, float, float] = ISOMETRIC,
    size: tuple[int, int] = SIZE,
) -> bytes:
    """PNG of pieces as they stand, filling the picture, with edges drawn and parts in the colour of their material.

    Args:
        pieces: what stands where.
        meshes: mesh of each part, mm, by `PlacedShape.part`.
        viewer: direction from the part towards the viewer.
        size: width and height, pixels.
    """
    from PIL import Image

    from stagecad.solids.export import rasteriser

    view = _view(viewer)
    colours = sorted({piece.colour for piece in pieces})
    points, normals, triangles, tint, edges, ends = [], [], [], [], [], [np.zeros(1, dtype=np.int64)]
    for piece in pieces:
        mesh = meshes[piece.part].placed(piece.frame)
        triangles.append(mesh.triangles.astype(np.int64) + sum(len(block) for block in points))
        ends.append(mesh.edge_ends[1:] + ends[-1][-1] if len(mesh.edge_ends) > 1 else ends[-1][:0])
        points.append(mesh.vertices @ view.T)
        normals.append(mesh.normals @ view.T)
        tint.append(np.full(len(mesh.triangles), colours.index(piece.colour)))
        edges.append(mesh.edge_points @ view.T)
        if not len(ends[-1]):
            ends.pop()
    cloud = np.concatenate(points)
    low, high = cloud.min(axis=0), cloud.max(axis=0)
    scale = (1.0 - 2.0 * MARGIN) * min(size[0] / (high[0] - low[0]), size[1] / (high[1] - low[1]))
    middle = (low + high) / 2.0

    def to_pixels(place: np.ndarray) -> np.ndarray:
        shifted = (place - middle) * scale
        return np.column_stack([size[0] / 2 + shifted[:, 0], size[1] / 2 - shifted[:, 1], -shifted[:, 2]])

    pixels = rasteriser.draw(
        to_pixels(cloud),
        np.concatenate(normals),
        np.concatenate(triangles),
        np.concatenate(tint),
        np.array(colours),
        to_pixels(np.concatenate(edges)),
        np.concatenate(ends),
        size,
        lit_from=1.0 if viewer[2] >= 0.0 else -1.0,
    )
    memory = io.BytesIO()
    Image.fromarray(pixels).save(memory, format="PNG", optimize=False, compress_level=6)
    return memory.getvalue()


def _view(viewer: tuple[float, float, float]) -> np.ndarray:
    """Rows: right, up, towards the viewer."""
    towards = np.array(viewer) / np.linalg.norm(viewer)
    right = np.cross((0.0, 0.0, 1.0), towards)
    right /= np.linalg.norm(right)
    return np.array([right, np.cross(towards, right), towards])
