"""Shaded pictures of parts and assembly, as PNG.

Renders triangles and lines with a depth buffer on the CPU, without display or graphics driver.

Orthographic. The picture is rendered with `SAMPLES` times the resolution in each direction and averaged (antialiasing).
Shading: a key light from the upper left of the viewer, hemispherical ambient light, a weak specular highlight, and
depth darkening behind near contours (Luft, Colditz and Deussen, SIGGRAPH 2006), which makes pockets and gaps visible.
"""

import io
from collections.abc import Sequence
from typing import NamedTuple

import numba
import numpy as np
from scipy import ndimage

from stagecad.solids.export.mesh import Mesh
from stagecad.solids.modelling.frame import PlacedShape, Vector

SAMPLES = 2
INK = (0.10, 0.11, 0.13)
TOP, FOOT = (0.985, 0.988, 0.992), (0.915, 0.925, 0.938)
"""Colours of the lines, and of the background at the upper and the lower edge."""
FAR = np.float32(np.inf)


class Samples(NamedTuple):
    """What is in front, by sample (h, w)."""

    depth: np.ndarray  # of the surface in front, infinite for the background
    facing: np.ndarray  # (h, w, 3) its normal, of any length
    paint: np.ndarray  # index of its colour, -1 for the background
    ink: np.ndarray  # not 0 where a line is


@numba.njit(cache=True)
def _columns(x, y, row, first, last):  # pragma: no cover - compiled
    """Columns between the sides of a triangle in a row, with a margin of one, within the first and last given."""
    left, right = np.inf, -np.inf
    for side in range(3):
        other = (side + 1) % 3
        low, high = y[side], y[other]
        if low != high and min(low, high) - 1e-6 <= row <= max(low, high) + 1e-6:
            place = x[side] + (row - low) * (x[other] - x[side]) / (high - low)
            left, right = min(left, place), max(right, place)
    if left > right:
        return first, last
    begin = int(np.floor(max(left, first - 1.0) - 1.5))
    return max(first, begin), min(last, int(np.ceil(min(right, last + 2.0) + 0.5)))


@numba.njit(cache=True)
def _fill(points, normals, triangles, colour_index, depth, facing, paint):  # pragma: no cover - compiled
    """Render triangles into the depth buffer; points are (column, row, depth), nearer is smaller."""
    height, width = depth.shape
    x, y = np.empty(3), np.empty(3)
    for t in range(triangles.shape[0]):
        a, b, c = triangles[t, 0], triangles[t, 1], triangles[t, 2]
        xa, ya, za = points[a, 0], points[a, 1], points[a, 2]
        xb, yb, zb = points[b, 0], points[b, 1], points[b, 2]
        xc, yc, zc = points[c, 0], points[c, 1], points[c, 2]
        area = (xb - xa) * (yc - ya) - (xc - xa) * (yb - ya)
        if area >= 0.0:
            # A back face (rows count downwards): hidden, since the solid is closed.
            continue
        first_row = max(0, int(np.ceil(min(ya, yb, yc) - 0.5)))
        last_row = min(height - 1, int(np.floor(max(ya, yb, yc) - 0.5)))
        first_column = max(0, int(np.ceil(min(xa, xb, xc) - 0.5)))
        last_column = min(width - 1, int(np.floor(max(xa, xb, xc) - 0.5)))
        if first_column > last_column:
            continue
        x[0], x[1], x[2] = xa, xb, xc
        y[0], y[1], y[2] = ya, yb, yc
        for row in range(first_row, last_row + 1):
            q = row + 0.5
            begin, end = _columns(x, y, q, first_column, last_column)
            for column in range(begin, end + 1):
                p = column + 0.5
                u = ((xb - p) * (yc - q) - (xc - p) * (yb - q)) / area
                v = ((xc - p) * (ya - q) - (xa - p) * (yc - q)) / area
                w = 1.0 - u - v
                if u < -1e-9 or v < -1e-9 or w < -1e-9:
                    continue
                z = u * za + v * zb + w * zc
                if z < depth[row, column]:
                    depth[row, column] = z
                    paint[row, column] = colour_index[t]
                    for axis in range(3):
                        facing[row, column, axis] = u * normals[a, axis] + v * normals[b, axis] + w * normals[c, axis]


@numba.njit(cache=True)
def _stroke(points, ends, width_px, slack, depth, ink):  # pragma: no cover - compiled
    """Render visible lines as round dots; `slack` is the depth by which a line may lie behind its own face."""
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
                # A line on a contour may fall outside its face: it is visible if visible at any neighbouring pixel.
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


@numba.njit(cache=True)
def _compose(samples, averages, steps, colours, key, light_sign, picture):  # pragma: no cover - compiled
    """Shade and darken each sample, lay the lines over it, and average samples into `picture` (h, w, 3)."""
    depth, facing, paint, ink = samples.depth, samples.facing, samples.paint, samples.ink
    height = paint.shape[0]
    half = key + np.array([0.0, 0.0, 1.0])
    half /= np.sqrt(np.sum(half * half))
    sample, total = np.empty(3), np.empty(3)
    for row in range(picture.shape[0]):
        for column in range(picture.shape[1]):
            total[:] = 0.0
            for r in range(row * SAMPLES, (row + 1) * SAMPLES):
                for c in range(column * SAMPLES, (column + 1) * SAMPLES):
                    if paint[r, c] < 0:
                        # Almost white, slightly darker towards the bottom.
                        for k in range(3):
                            sample[k] = TOP[k] + r / (height - 1.0) * (FOOT[k] - TOP[k])
                    else:
                        x, y, z = facing[r, c, 0], facing[r, c, 1], facing[r, c, 2]
                        length = max(np.sqrt(x * x + y * y + z * z), 1e-6)
                        x, y, z = x / length, y / length, z / length
                        diffuse = min(max(x * key[0] + y * key[1] + z * key[2], 0.0), 1.0)
                        shine = min(max(x * half[0] + y * half[1] + z * half[2], 0.0), 1.0) ** 30
                        light = 0.52 + 0.18 * (0.5 + 0.5 * light_sign * y) + 0.40 * diffuse
                        shadow = 0.0
                        for k in range(2):
                            behind = depth[r, c] - averages[k, r // 2, c // 2]
                            shadow += 0.40 * min(max(behind / steps[k], 0.0), 1.0)
                        for k in range(3):
                            lit = colours[paint[r, c], k] * light + 0.10 * shine
                            sample[k] = lit * (1.0 - min(shadow, 0.5))
                    for k in range(3):
                        total[k] += sample[k] + (0.85 * (INK[k] - sample[k]) if ink[r, c] else 0.0)
            for k in range(3):
                picture[row, column, k] = np.uint8(min(max(total[k] / SAMPLES**2, 0.0), 1.0) * 255.0 + 0.5)


def _average_depths(depth: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Averages (2, h / 2, w / 2) of a depth (h, w) over a narrow and a wide neighbourhood, and their steps."""
    # The averages are smooth: every second sample is sufficient.
    coarse = depth[::2, ::2].copy()
    far = np.isinf(coarse)
    coarse[far] = coarse[~far].max(initial=0.0)
    radii = [max(1.0, share * depth.shape[1]) for share in (1 / 220, 1 / 60)]
    averages = [ndimage.gaussian_filter(coarse, radius / 2, truncate=2.5) for radius in radii]
    return np.stack(averages), 6.0 * np.array(radii)


SIZE = (1400, 1000)
MARGIN = 0.06
LINE = 1.1
"""Width of the lines, pixels."""

ISOMETRIC = (1.0, -1.15, 0.85)
"""Direction towards the viewer: in front (-y), to the right (+x) and above."""

BELOW = (1.0, -1.15, -0.85)
"""Direction of view from below, for the working faces of the stage."""


def picture(
    shapes: Sequence[PlacedShape], meshes: dict[str, Mesh], viewer: Vector = ISOMETRIC, size: tuple[int, int] = SIZE
) -> bytes:
    """PNG of an assembly that fills the picture of `size` pixels, with edges, in the colours of the materials, seen
    from the direction `viewer`; `meshes` has that of each part, mm."""
    from PIL import Image

    towards = np.array(viewer) / np.linalg.norm(viewer)
    right = np.cross((0.0, 0.0, 1.0), towards)
    right /= np.linalg.norm(right)
    view = np.array([right, np.cross(towards, right), towards])
    colours = sorted({shape.colour for shape in shapes})
    points, normals, triangles, colour_index, edges, ends = [], [], [], [], [], [np.zeros(1, dtype=np.int64)]
    for shape in shapes:
        mesh = meshes[shape.part].placed(shape.frame)
        triangles.append(mesh.triangles.astype(np.int64) + sum(len(block) for block in points))
        if len(mesh.edge_ends) > 1:
            ends.append(mesh.edge_ends[1:] + ends[-1][-1])
        points.append(mesh.vertices @ view.T)
        normals.append(mesh.normals @ view.T)
        colour_index.append(np.full(len(mesh.triangles), colours.index(shape.colour), dtype=np.int32))
        edges.append(mesh.edge_points @ view.T)
    cloud = np.concatenate(points)
    low, high = cloud.min(axis=0), cloud.max(axis=0)
    scale = (1.0 - 2.0 * MARGIN) * min(size[0] / (high[0] - low[0]), size[1] / (high[1] - low[1]))
    middle = (low + high) / 2.0

    def to_samples(places: np.ndarray) -> np.ndarray:
        """Column, row (downwards) and depth (nearer is smaller), in samples."""
        shifted = (places - middle) * scale
        return SAMPLES * np.column_stack([size[0] / 2 + shifted[:, 0], size[1] / 2 - shifted[:, 1], -shifted[:, 2]])

    width, height = size[0] * SAMPLES, size[1] * SAMPLES
    samples = Samples(
        depth=np.full((height, width), FAR, dtype=np.float32),
        facing=np.zeros((height, width, 3), dtype=np.float32),
        paint=np.full((height, width), -1, dtype=np.int32),
        ink=np.zeros((height, width), dtype=np.float32),
    )
    depth, facing, paint, ink = samples
    outward, corners, painted = (np.concatenate(blocks) for blocks in (normals, triangles, colour_index))
    _fill(to_samples(cloud), outward, corners, painted, depth, facing, paint)
    _stroke(to_samples(np.concatenate(edges)), np.concatenate(ends), LINE * SAMPLES, 1.5 * SAMPLES, depth, ink)
    # Light from above, or from below for a part seen from below.
    light_sign = 1.0 if viewer[2] >= 0.0 else -1.0
    light = np.array([-0.45, 0.65 * light_sign, 0.62])
    light /= np.linalg.norm(light)
    pixels = np.empty((size[1], size[0], 3), dtype=np.uint8)
    _compose(samples, *_average_depths(depth), np.array(colours, float), light, light_sign, pixels)
    memory = io.BytesIO()
    Image.fromarray(pixels).save(memory, format="PNG", optimize=False, compress_level=6)
    return memory.getvalue()
