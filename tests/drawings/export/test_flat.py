"""The flat file shows in model space what the sheet shows on its paper."""

import numpy as np
from scipy.spatial import KDTree

from drawings.export.dxf import flattened
from drawings.views.segment_index import polyline_lines
from tests.drawings.drawn import document_of, sheets
from tests.drawings.export.dxf_reading import PaperContent, entity_points


def test_all_lines_and_texts_are_at_their_places_on_the_paper() -> None:
    (sheet,) = sheets("stop_bar")
    before = PaperContent(document_of(sheet))
    flat = flattened(document_of(sheet))
    assert not flat.modelspace().query("DIMENSION") and len(flat.paperspace().query("VIEWPORT")) <= 1
    lines = [
        line
        for entity in flat.modelspace()
        if entity.dxftype() != "TEXT"
        for line in polyline_lines(entity_points(entity))
    ]
    ends = [np.array([end for line in found for end in (line[:2], line[2:])]) for found in (before.lines, lines)]
    for some, others in (ends, ends[::-1]):
        # Chords of arcs are as dense as the scale of the view asks for.
        distance, _ = KDTree(others).query(some)
        assert np.quantile(distance, 0.9) < 1e-6 and distance.max() < 3.0
    texts = sorted(entity.plain_text() for entity in flat.modelspace().query("TEXT"))
    assert texts == sorted(text.text for text in before.texts)
    assert not flat.audit().errors
