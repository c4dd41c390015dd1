"""What a DXF document shows on paper: against ezdxf's own interpreter of DXF, and as long as the line types say."""

from __future__ import annotations

import math
from itertools import pairwise

import numpy as np
import pytest
from ezdxf.addons.drawing import config
from ezdxf.addons.drawing.frontend import Frontend
from ezdxf.addons.drawing.properties import RenderContext
from ezdxf.addons.drawing.recorder import FilledPathsRecord, PathRecord, PointsRecord, Recorder, SolidLinesRecord
from ezdxf.npshapes import NumpyPath2d
from matplotlib.path import Path
from scipy.spatial import KDTree

from drawings.export.document import LAYERS, LINE_TYPES, document_of
from drawings.export.strokes import Outlines, dashed, shown
from drawings.export.texts import MOVE, text_outlines
from tests.drawings.plate_sheet import sheet

STEP = 0.1
"""Distance of the places at which lines are compared, mm."""
NEAR = 0.08
"""Half a step, and what the chords of both leave their curves by, mm."""


def _along(points: np.ndarray) -> np.ndarray:
    """Places along a line."""
    found = [points[:1]]
    for a, b in pairwise(points):
        count = math.ceil(math.dist(a, b) / STEP) + 1
        found.append(a + (b - a) * np.linspace(0.0, 1.0, count)[:, None])
    return np.concatenate(found)


def _ours(lot: Outlines) -> np.ndarray:
    places = []
    for begin, end in zip(lot.begins, (*lot.begins[1:], len(lot.points)), strict=True):
        # Enlarged, since matplotlib takes a unit for a pixel.
        lines = Path(lot.points[begin:end] * 100.0, lot.codes[begin:end]).to_polygons(closed_only=False)
        places += [_along(line / 100.0) for line in map(np.asarray, lines) if len(line) > 1]
    return np.concatenate(places)


def _lines(path: NumpyPath2d) -> list[np.ndarray]:
    parts = [[(p.x, p.y) for p in part.flattening(0.005)] for part in path.to_path().sub_paths()]
    return [np.array(points) for points in parts if len(points) > 1]


def _theirs(document) -> dict[float | None, np.ndarray]:
    settings = config.Configuration(
        lineweight_policy=config.LineweightPolicy.ABSOLUTE, text_policy=config.TextPolicy.FILLING
    )
    backend = Recorder()
    Frontend(RenderContext(document), backend, config=settings).draw_layout(document.paperspace())
    found: dict[float | None, list[np.ndarray]] = {}
    for record in backend.records:
        weight = backend.properties[record.property_hash].lineweight
        match record:
            case FilledPathsRecord():
                found.setdefault(None, []).extend(line for path in record.paths for line in _lines(path))
            case PathRecord():
                found.setdefault(weight, []).extend(_lines(record.path))
            case SolidLinesRecord():
                found.setdefault(weight, []).extend(record.lines.np_vertices().reshape(-1, 2, 2))
            case PointsRecord():
                # A line; or a filled polygon, without the side that closes it.
                points = record.points.np_vertices()
                found.setdefault(None if len(points) > 2 else weight, []).append(np.concatenate((points, points[:1])))
    return {weight: np.concatenate([_along(line) for line in lines]) for weight, lines in found.items()}


def test_everything_is_where_ezdxf_has_it() -> None:
    document = document_of(sheet())
    for layer in document.layers:
        # Its viewports draw line types of views that are not 1:1 too long.
        layer.dxf.linetype = "CONTINUOUS"
    theirs = _theirs(document)
    seen = shown(document)
    ours = {lot.weight: _ours(lot) for lot in seen.lots}
    points, codes = text_outlines(seen.texts)
    letters = Outlines(points, codes, tuple(np.flatnonzero(codes == MOVE).tolist()), None)
    ours[None] = np.concatenate((ours[None], _ours(letters)))
    assert set(ours) == set(theirs) >= {None, 0.25, 0.5, 0.7}
    for weight, places in ours.items():
        for one, other in ((places, theirs[weight]), (theirs[weight], places)):
            away, _ = KDTree(other).query(one)
            assert away.max() < NEAR, weight


@pytest.mark.parametrize(("layer", "kind"), [("HIDDEN", "DASHED"), ("CENTRE", "CHAIN")])
def test_a_broken_line_has_the_same_dashes_on_paper_at_every_scale(layer: str, kind: str) -> None:
    document = document_of(sheet())
    for entity in [entity for entity in document.modelspace() if entity.dxf.layer != layer]:
        document.modelspace().delete_entity(entity)
    lot = next(lot for lot in shown(document).lots if lot.weight == LAYERS[layer][1] / 100)
    first = LINE_TYPES[kind][1][1]
    starts = {"HIDDEN": [(80.0, 185.0), (220.0, 220.0)], "CENTRE": [(77.5, 180.0), (210.0, 200.0)]}[layer]
    for start in starts:
        (begin,) = (number for number in lot.begins if math.dist(lot.points[number], start) < 1e-6)
        assert math.dist(lot.points[begin], lot.points[begin + 1]) == pytest.approx(first)


def test_dashes_run_on_round_a_corner() -> None:
    pieces = list(dashed([(0.0, 0.0), (4.0, 0.0), (4.0, 5.0)], [3.0, 2.0, 2.0, 1.0]))
    assert pieces == [
        [(0.0, 0.0), (3.0, 0.0)],
        [(4.0, 1.0), (4.0, 3.0)],
        [(4.0, 4.0), (4.0, 5.0)],
    ]
    assert list(dashed([(0.0, 0.0), (2.0, 0.0)], [3.0, 1.0])) == [[(0.0, 0.0), (2.0, 0.0)]]
