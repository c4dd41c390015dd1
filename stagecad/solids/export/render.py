"""Shaded pictures of parts and assembly, as PNG."""

import io
from collections.abc import Sequence

import numpy as np

from stagecad.solids.export.tessellation import Mesh
from stagecad.solids.modelling.frame import PlacedShape

SIZE = (1400, 1000)
MARGIN = 0.06

ISOMETRIC = (1.0, -1.15, 0.85)
"""Direction towards the viewer: in front (-y), to the right (+x) and above."""

BELOW = (1.0, -1.15, -0.85)
"""Direction of view from below, for the working faces of the stage."""


def picture(
    shapes: Sequence[PlacedShape],
    meshes: dict[str, Mesh],
    viewer: tuple[float, float, float] = ISOMETRIC,
    size: tuple[int, int] = SIZE,
) -> bytes:
    """PNG of an assembly that fills the picture of `size` pixels, with edges, in the colours of the materials, seen
    from the direction `viewer`; `meshes` has that of each part, mm."""
    from PIL import Image

    from stagecad.solids.export.rasteriser import ProjectedMesh, draw

    view = _view(viewer)
    colours = sorted({shape.colour for shape in shapes})
    points, normals, triangles, colour_index, edges, ends = [], [], [], [], [], [np.zeros(1, dtype=np.int64)]
    for shape in shapes:
        mesh = meshes[shape.part].placed(shape.frame)
        triangles.append(mesh.triangles.astype(np.int64) + sum(len(block) for block in points))
        if len(mesh.edge_ends) > 1:
            ends.append(mesh.edge_ends[1:] + ends[-1][-1])
        points.append(mesh.vertices @ view.T)
        normals.append(mesh.normals @ view.T)
        colour_index.append(np.full(len(mesh.triangles), colours.index(shape.colour)))
        edges.append(mesh.edge_points @ view.T)
    cloud = np.concatenate(points)
    low, high = cloud.min(axis=0), cloud.max(axis=0)
    scale = (1.0 - 2.0 * MARGIN) * min(size[0] / (high[0] - low[0]), size[1] / (high[1] - low[1]))
    middle = (low + high) / 2.0

    def to_pixels(places: np.ndarray) -> np.ndarray:
        shifted = (places - middle) * scale
        return np.column_stack([size[0] / 2 + shifted[:, 0], size[1] / 2 - shifted[:, 1], -shifted[:, 2]])

    projected = ProjectedMesh(
        to_pixels(cloud),
        *(np.concatenate(blocks) for blocks in (normals, triangles, colour_index)),
        edge_points=to_pixels(np.concatenate(edges)),
        edge_ends=np.concatenate(ends),
    )
    pixels = draw(projected, np.array(colours), size, light_sign=1.0 if viewer[2] >= 0.0 else -1.0)
    memory = io.BytesIO()
    Image.fromarray(pixels).save(memory, format="PNG", optimize=False, compress_level=6)
    return memory.getvalue()


def _view(viewer: tuple[float, float, float]) -> np.ndarray:
    """Rows: right, up, towards the viewer."""
    towards = np.array(viewer) / np.linalg.norm(viewer)
    right = np.cross((0.0, 0.0, 1.0), towards)
    right /= np.linalg.norm(right)
    return np.array([right, np.cross(towards, right), towards])
