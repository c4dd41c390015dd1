"""Points and rays against the closed form of a block in which bores cross."""

from itertools import product

import cadquery as cq
import numpy as np
import pytest

from stagecad.parameters.dimension import Point
from stagecad.solids.modelling.verification import DimensionVerifier

HALF = (60.0, 40.0, 25.0)


@pytest.fixture(scope="module")
def block() -> DimensionVerifier:
    """Bores of 5 mm radius along x and of 3 mm along z, which cross on their axes, and a wall of 0.3 mm at the top."""
    body = cq.Workplane().box(*(2 * half for half in HALF))
    body = body.faces(">X").workplane(centerOption="CenterOfBoundBox").rarray(20, 1, 3, 1).hole(10)
    body = body.faces(">Z").workplane(centerOption="CenterOfBoundBox").rarray(18, 20, 3, 3).hole(6)
    body = body.cut(cq.Workplane().box(8, 8, 1).translate((50, 30, 24.2)))
    return DimensionVerifier(body.val())  # pyright: ignore[reportArgumentType]


def is_material(x: float, y: float, z: float) -> bool:
    if np.any(np.abs((x, y, z)) > HALF):
        return False
    along_x = any(np.hypot(y - at, z) < 5.0 for at in (-20.0, 0.0, 20.0))
    along_z = any(np.hypot(x - a, y - b) < 3.0 for a in (-18.0, 0.0, 18.0) for b in (-20.0, 0.0, 20.0))
    return not (along_x or along_z or (abs(x - 50) < 4 and abs(y - 30) < 4 and 23.7 < z < 24.7))


def test_a_point_is_inside_where_the_closed_form_says_so(block: DimensionVerifier) -> None:
    points = np.random.default_rng(5).uniform(-1.1, 1.1, (400, 3)) * HALF
    points[:200] = points[:200].round()  # many of them on axes, in the planes of edges and on seams
    beside = [
        [is_material(*(point + way)) for way in 1e-5 * np.array(list(product((-1, 1), repeat=3)))] for point in points
    ]
    clear = [tuple(point) for point, row in zip(points, beside, strict=True) if len(set(row)) == 1]
    assert len(clear) > 380 and [*map(block.is_inside, clear)] == [is_material(*point) for point in clear]


@pytest.mark.parametrize(
    ("point", "way", "expected"),
    [
        ((50.0, 30.0, 23.7), (0.0, 0.0, 1.0), True),  # below a wall of 0.3 mm
        ((50.0, 30.0, 25.0), (0.0, 0.0, 1.0), False),
        ((21.0, 20.0, 25.0), (0.0, 0.0, -1.0), False),  # along the wall of a bore
        ((-60.0, 5.0, 0.0), (1.0, 0.0, 0.0), False),
        ((40.0, 5.0, 0.0), (0.0, 1.0, 0.0), True),  # across it
        ((60.0, 40.0, -25.0), (0.0, 0.0, 1.0), False),  # along an edge of the block
        ((60.0, 30.0, 0.0), (0.0, -1.0, 0.0), False),  # in a side of the block, through the rims of bores
    ],
)
def test_material_in_a_direction(block: DimensionVerifier, point: Point, way: Point, *, expected: bool) -> None:
    assert block.is_covered(point, way) is expected
