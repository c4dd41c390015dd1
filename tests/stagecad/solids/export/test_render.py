"""Pictures are drawn without a display, show the part where it is, and hide what is behind."""

import io
import os
import subprocess
import sys

import cadquery as cq
import numpy as np
import pytest
from PIL import Image

from stagecad.solids.export.mesh import Mesh, mesh_of
from stagecad.solids.export.render import picture
from stagecad.solids.modelling.frame import IDENTITY, Frame, PlacedShape

RED, BLUE = (0.9, 0.1, 0.1), (0.1, 0.1, 0.9)
FRONT = (0.0, -1.0, 1e-6)


@pytest.fixture(scope="module")
def cube() -> Mesh:
    solid = cq.Workplane().box(10, 10, 10).val()
    return mesh_of(solid, 1000.0)  # type: ignore[arg-type]


def pixels(data: bytes) -> np.ndarray:
    return np.asarray(Image.open(io.BytesIO(data))).astype(int)


def area(image: np.ndarray, channel: int) -> int:
    """Pixels in which one colour channel stands out."""
    others = [index for index in range(3) if index != channel]
    return int(np.sum(image[..., channel] > 40 + image[..., others].max(axis=-1)))


def test_pictures_are_filled_and_hide_what_is_behind(cube: Mesh) -> None:
    image = pixels(picture([PlacedShape("cube", "cube", RED)], {"cube": cube}, FRONT, (300, 200)))
    assert image.shape == (200, 300, 3)
    rows, columns = np.nonzero(np.abs(image - image[0, 0]).max(axis=-1) > 60)
    # The cube is a square of 88 % of the height in the middle.
    assert (rows.min(), rows.max()) == pytest.approx((12, 187), abs=2)
    assert (columns.min(), columns.max()) == pytest.approx((62, 237), abs=2)
    behind = Frame(IDENTITY, (0.0, 30.0, 0.0))
    front = [PlacedShape("near", "cube", RED), PlacedShape("far", "cube", BLUE, behind)]
    image = pixels(picture(front, {"cube": cube}, FRONT, (200, 200)))
    assert area(image, 0) > 20_000 and area(image, 2) == 0
    image = pixels(picture(front, {"cube": cube}, (0.0, 1.0, 1e-6), (200, 200)))
    assert area(image, 0) == 0 and area(image, 2) > 20_000
    image = pixels(picture([PlacedShape("cube", "cube", RED)], {"cube": cube}, (1.0, -1.0, 0.8), (400, 400)))
    dark = image.max(axis=-1) < 110
    # From a corner nine edges show; the three that meet behind would cross at the middle of the outline.
    assert np.sum(dark) > 400
    rows, columns = np.nonzero(np.abs(image - image[0, 0]).max(axis=-1) > 60)
    middle = (rows.min() + rows.max()) // 2, (columns.min() + columns.max()) // 2
    below = image[middle[0] + 30 : middle[0] + 60, middle[1] - 60 : middle[1] - 30]
    assert np.all(below.max(axis=-1) > 110)
    # A small cube before a large one: what lies behind its contour is darkened near it.
    large = Mesh(**{**vars(cube), "vertices": 4.0 * cube.vertices, "edge_points": 4.0 * cube.edge_points})
    shapes = [PlacedShape("far", "large", BLUE), PlacedShape("near", "cube", RED, Frame(IDENTITY, (0.0, -60.0, 0.0)))]
    image = pixels(picture(shapes, {"cube": cube, "large": large}, FRONT, (400, 400)))
    near = np.nonzero(image[..., 0] > 40 + image[..., 2])
    middle, edge = int(np.median(near[0])), int(near[1].max())
    beside, away = image[middle, edge + 4], image[middle, edge + 60]
    assert beside.sum() < away.sum() - 20
    assert np.all(image[2] == image[2, 0]) and image[2, 0].min() > 230


@pytest.mark.slow
def test_works_without_a_display_and_repeats(cube: Mesh) -> None:
    program = """
import sys, cadquery as cq
from stagecad.solids.modelling.frame import PlacedShape
from stagecad.solids.export.mesh import mesh_of
from stagecad.solids.export.render import picture
mesh = mesh_of(cq.Workplane().box(10, 10, 10).val(), 1000.0)
sys.stdout.buffer.write(picture([PlacedShape("cube", "cube", (0.9, 0.1, 0.1))], {"cube": mesh}, size=(120, 100)))
"""
    bare = {key: value for key, value in os.environ.items() if key not in ("DISPLAY", "WAYLAND_DISPLAY")}
    run = subprocess.run([sys.executable, "-c", program], capture_output=True, env=bare, check=True, timeout=240)
    here = picture([PlacedShape("cube", "cube", RED)], {"cube": cube}, size=(120, 100))
    assert np.abs(pixels(run.stdout) - pixels(here)).max() == 0
