"""Draws triangles and lines into a picture by depth buffer, on the processor: no display, no graphics driver.

Orthographic. The picture is drawn `SAMPLES` times finer in each direction and averaged, which smooths every edge.
Shading: a key light from the upper left of the viewer, light from above and below (sky and floor), a weak highlight,
and darkening of places that lie behind a near contour (depth darkening after Luft, Colditz and Deussen, SIGGRAPH
2006), which makes pockets and gaps readable.
"""

from __future__ import annotations

import numba
import numpy as np
from scipy import ndimage

SAMPLES = 2
INK = np.array([0.10, 0.11, 0.13], dtype=np.float32)
FAR = np.float32(np.inf)


@numba.njit(cache=True)
def _fill(points, normals, triangles, tint, depth, facing, paint):  # pragma: no cover - compiled
    """Triangles into the depth buffer; points are (column, row, depth), nearer is smaller."""
    height, width = depth.shape
    for t in range(triangles.shape[0]):
        a, b, c = triangles[t, 0], triangles[t, 1], triangles[t, 2]
        xa, ya, za = points[a, 0], points[a, 1], points[a, 2]
        xb, yb, zb = points[b, 0], points[b, 1], points[b, 2]
        xc, yc, zc = points[c, 0], points[c, 1], points[c, 2]
        area = (xb - xa) * (yc - ya) - (xc - xa) * (yb - ya)
        if area >= 0.0:
            # Seen from behind (rows count downwards): the solid is closed, another face hides it.
            continue
        first_row = max(0, int(np.ceil(min(ya, yb, yc) - 0.5)))
        last_row = min(height - 1, int(np.floor(max(ya, yb, yc) - 0.5)))
        first_column = max(0, int(np.ceil(min(xa, xb, xc) - 0.5)))
        last_column = min(width - 1, int(np.floor(max(xa, xb, xc) - 0.5)))
        for row in range(first_row, last_row + 1):
            y = row + 0.5
            for column in range(first_column, last_column + 1):
                x = column + 0.5
                u = ((xb - x) * (yc - y) - (xc - x) * (yb - y)) / area
                v = ((xc - x) * (ya - y) - (xa - x) * (yc - y)) / area
                w = 1.0 - u - v
                if u < -1e-9 or v < -1e-9 or w < -1e-9:
                    continue
                z = u * za + v * zb + w * zc
                if z < depth[row, column]:
                    depth[row, column] = z
                    paint[row, column] = tint[t]
                    for axis in range(3):
                        facing[row, column, axis] = u * normals[a, axis] + v * normals[b, axis] + w * normals[c, axis]


@numba.njit(cache=True)
def _stroke(points, ends, width_px, slack, depth, ink):  # pragma: no cover - compiled
    """Lines that are not hidden, as round dots along them; `slack` is the depth a line may lie under its own face."""
    height, width = depth.shape
    radius = width_px / 2.0
    reach = int(np.ceil(radius))
    for line in range(ends.shape[0] - 1):
        for i in range(ends[line], ends[line + 1] - 1):
            dx = points[i + 1, 0] - points[i, 0]
            dy = points[i + 1, 1] - points[i, 1]
            dz = points[i + 1, 2] - points[i, 2]
            steps = int(np.ceil(max(abs(dx), abs(dy)))) + 1
            for step in range(steps + 1):
                x = points[i, 0] + dx * step / steps
                y = points[i, 1] + dy * step / steps
                z = points[i, 2] + dz * step / steps - slack
                column, row = int(np.floor(x)), int(np.floor(y))
                if column < 0 or row < 0 or column >= width or row >= height:
                    continue
                # A line on a contour lies beside its face as often as on it: visible if any neighbour lets it be.
                visible = False
                for r in range(max(0, row - 1), min(height, row + 2)):
                    for c in range(max(0, column - 1), min(width, column + 2)):
                        if z <= depth[r, c]:
                            visible = True
                if not visible:
                    continue
                for r in range(max(0, row - reach), min(height, row + reach + 1)):
                    for c in range(max(0, column - reach), min(width, column + reach + 1)):
                        if (c + 0.5 - x) ** 2 + (r + 0.5 - y) ** 2 <= radius * radius and z <= depth[r, c] + 4 * slack:
                            ink[r, c] = 1.0


def draw(
    points: np.ndarray,
    normals: np.ndarray,
    triangles: np.ndarray,
    tint: np.ndarray,
    colours: np.ndarray,
    edge_points: np.ndarray,
    edge_ends: np.ndarray,
    size: tuple[int, int],
    line_width: float = 1.1,
    lit_from: float = 1.0,
) -> np.ndarray:
    """Shaded picture with outline edges on a light ground.

    Args:
        points: (n, 3): column, row (both in pixels, rows downwards) and depth (same scale, nearer is smaller).
        normals: (n, 3) unit, in view axes: right, up, towards the viewer.
        triangles: (m, 3) indices.
        tint: (m,) index into `colours` of each triangle.
        colours: (c, 3) sRGB, 0 to 1.
        edge_points: (k, 3) like `points`.
        edge_ends: (e + 1,) where each edge begins in `edge_points`.
        size: width and height in pixels.
        line_width: of the edges, pixels.
        lit_from: 1 for light from above, -1 from below, for a part seen from below.

    Returns:
        (height, width, 3) uint8.
    """
    width, height = size[0] * SAMPLES, size[1] * SAMPLES
    depth = np.full((height, width), FAR, dtype=np.float32)
    facing = np.zeros((height, width, 3), dtype=np.float32)
    paint = np.full((height, width), -1, dtype=np.int32)
    ink = np.zeros((height, width), dtype=np.float32)
    finer = (points * SAMPLES).astype(np.float64)
    _fill(finer, normals.astype(np.float64), triangles.astype(np.int64), tint.astype(np.int32), depth, facing, paint)
    _stroke(
        (edge_points * SAMPLES).astype(np.float64),
        edge_ends.astype(np.int64),
        line_width * SAMPLES,
        1.5 * SAMPLES,
        depth,
        ink,
    )
    picture = _ground(height, width)
    seen = paint >= 0
    picture[seen] = _shade(facing[seen], colours.astype(np.float32)[paint[seen]], lit_from)
    picture[seen] *= (1.0 - _shadow(depth)[seen])[:, None]
    picture += ink[:, :, None] * 0.85 * (INK - picture)
    coarse = picture.reshape(size[1], SAMPLES, size[0], SAMPLES, 3).mean(axis=(1, 3))
    return np.round(np.clip(coarse, 0.0, 1.0) * 255.0).astype(np.uint8)


def _ground(height: int, width: int) -> np.ndarray:
    """Almost white, a little darker towards the foot."""
    fall = np.linspace(0.0, 1.0, height, dtype=np.float32)[:, None, None]
    top, foot = np.array([0.985, 0.988, 0.992], np.float32), np.array([0.915, 0.925, 0.938], np.float32)
    return np.broadcast_to(top + fall * (foot - top), (height, width, 3)).copy()


def _shade(facing: np.ndarray, colour: np.ndarray, lit_from: float) -> np.ndarray:
    normal = facing / np.maximum(np.linalg.norm(facing, axis=1, keepdims=True), 1e-6)
    key = np.array([-0.45, 0.65 * lit_from, 0.62], np.float32)
    key /= np.linalg.norm(key)
    diffuse = np.clip(normal @ key, 0.0, 1.0)
    sky = 0.5 + 0.5 * lit_from * normal[:, 1]
    half = key + np.array([0.0, 0.0, 1.0], np.float32)
    half /= np.linalg.norm(half)
    shine = np.clip(normal @ half, 0.0, 1.0) ** 30
    light = 0.52 + 0.18 * sky + 0.40 * diffuse
    return colour * light[:, None] + 0.10 * shine[:, None]


def _shadow(depth: np.ndarray) -> np.ndarray:
    """Darkening behind near contours: how far the surroundings lie in front of a place, wide and narrow."""
    far = np.isinf(depth)
    if far.all():
        return np.zeros_like(depth)
    deepest = float(depth[~far].max())
    filled = np.where(far, deepest, depth)
    total = np.zeros_like(depth)
    # The blurs are wide and smooth: taken on every second sample they are the same and four times quicker.
    coarse = filled[::2, ::2]
    for share, strength in ((1 / 220, 0.20), (1 / 60, 0.20)):
        radius = max(1.0, share * depth.shape[1])
        blurred = ndimage.gaussian_filter(coarse, radius / 2, truncate=2.5)
        wide = np.repeat(np.repeat(blurred, 2, axis=0), 2, axis=1)[: depth.shape[0], : depth.shape[1]]
        total += strength * np.clip((filled - wide) / (6.0 * radius), 0.0, 1.0)
    return np.where(far, 0.0, np.clip(total * 2.0, 0.0, 0.5))
