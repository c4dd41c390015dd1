"""Everything that a view contains is ink on the sheet, and each hatch lies in a closed outline."""

import math
from itertools import pairwise

import numpy as np
import pytest

from drawings.export.drawing_model import drawing_model
from drawings.export.pdf import DPI
from drawings.views.segment_index import curve_points
from drawings.views.view import View
from stagecad.friction_stage.construction import MADE
from tests.drawings.drawn import sheets
from tests.drawings.rendered import assert_same_picture, picture_of

STEP = 1.0
"""Distance of the points looked at along a curve, mm on the paper."""
NEAR = 0.05
"""Greatest distance of the end of a hatch line from the outline, mm on the paper."""


def points_on_paper(view: View, layer: str) -> list[np.ndarray]:
    """Each curve of a layer as points on the paper (n, 2), mm."""
    return [
        np.array([view.to_paper(point) for point in curve_points(curve, view.scale)])
        for curve in view.curves.get(layer, ())  # type: ignore[call-overload]
    ]


def along(points: np.ndarray) -> np.ndarray:
    """Points along a polyline at most `STEP` apart, its ends among them (n, 2)."""
    pieces = [np.linspace(start, end, 2 + int(math.dist(start, end) / STEP)) for start, end in pairwise(points)]
    return np.concatenate(pieces)


@pytest.mark.parametrize("part", MADE)
def test_every_visible_edge_of_every_view_is_covered_by_ink(part: str) -> None:
    for sheet in sheets(part):
        drawing = drawing_model(sheet)
        picture, scale, height = picture_of(drawing), DPI[sheet.paper] / 25.4, drawing.size[1]
        for view in sheet.views:
            edges = points_on_paper(view, "VISIBLE")
            assert edges, view.name
            every = np.concatenate([along(edge) for edge in edges])
            column = np.rint(every[:, 0] * scale).astype(int)
            row = np.rint((height - every[:, 1]) * scale).astype(int)
            around = [picture[row + i, column + j] for i in range(-2, 3) for j in range(-2, 3)]
            assert (np.min(around, axis=0) < 128).all(), (sheet.name, view.name)


def distance_to(lines: np.ndarray, points: np.ndarray) -> np.ndarray:
    """Least distance of each point (n, 2) from straight lines (m, 4)."""
    start, step = lines[:, :2], lines[:, 2:] - lines[:, :2]
    square = np.maximum((step**2).sum(axis=1), 1e-12)
    found = []
    for block in np.array_split(points, max(1, len(points) // 200)):
        to = block[:, None, :] - start
        t = np.clip((to * step).sum(axis=2) / square, 0.0, 1.0)
        found.append(np.linalg.norm(to - t[..., None] * step, axis=2).min(axis=1))
    return np.concatenate(found)


@pytest.mark.parametrize("part", MADE)
def test_every_hatch_line_ends_on_the_outline(part: str) -> None:
    """A hatch line that ended in the air would show an outline that is open there."""
    for sheet in sheets(part):
        for view in sheet.views:
            if view.cut is None or view.clip is not None:
                continue
            hatch = points_on_paper(view, "HATCH")
            assert len(hatch) > 5
            outline = points_on_paper(view, "VISIBLE")
            lines = np.concatenate([np.hstack((edge[:-1], edge[1:])) for edge in outline])
            ends = np.concatenate([line[[0, -1]] for line in hatch])
            assert distance_to(lines, ends).max() < NEAR, (sheet.name, view.name)


@pytest.mark.parametrize(
    "part", ["stage", *(pytest.param(part, marks=pytest.mark.slow) for part in ("holder", "base"))]
)
def test_the_picture_of_a_sheet_is_that_of_its_dxf_by_ezdxf(part: str) -> None:
    """The crowns of the stage's pads have their centres 2 m off the sheet."""
    for sheet in sheets(part):
        assert_same_picture(drawing_model(sheet))
