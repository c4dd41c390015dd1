"""The DXF file and its flat copy show lines and texts of the sheet where lint judges them."""

from collections.abc import Iterator
from dataclasses import replace
from itertools import zip_longest

import numpy as np
import pytest
from ezdxf.document import Drawing
from scipy.spatial import KDTree

from drawings.annotations.annotation import Primitive, Text, printed
from drawings.annotations.annotation_geometry import annotation_primitives, label_primitives, note_primitives, text_box
from drawings.export.dxf import flattened
from drawings.placement.conflicts import primitive_lines, view_lines
from drawings.sheets.frame import frame, title_primitives
from drawings.sheets.sheet import Sheet
from drawings.views.segment_index import Line, polyline_lines
from stagecad.friction_stage.construction import MADE
from tests.drawings.drawn import document_of, sheets
from tests.drawings.export.dxf_reading import PaperContent, entity_points, visible_entities
from tests.drawings.test_lint import CLEAN

SAME = 1e-3
"""Greatest distance of a place in the file from that on the sheet, mm."""


def drawn_by(sheet: Sheet) -> Iterator[Primitive]:
    """All primitives of a sheet but the lines of its views."""
    yield from (*frame(sheet.paper), *title_primitives(sheet.title, sheet.paper), *sheet.tables)
    for note in sheet.notes:
        yield from note_primitives(note)
    for view in sheet.views:
        yield from label_primitives(view)
    for annotation in sheet.annotations:
        yield from annotation_primitives(annotation, sheet.view(annotation.view))


def ends(lines: list[Line]) -> np.ndarray:
    return np.array([end for x0, y0, x1, y1 in lines for end in ((x0, y0), (x1, y1))])


def apart(points: np.ndarray, others: np.ndarray) -> list[list[float]]:
    """Those of some points that are at none of the others."""
    distance, _ = KDTree(others).query(points)
    return points[distance > SAME].round(3).tolist()


def middle_of(text: Text) -> tuple[float, float]:
    x0, y0, x1, y1 = text_box(replace(text, text=printed(text.text)))
    return ((x0 + x1) / 2, (y0 + y1) / 2)


def differences(sheet: Sheet, document: Drawing) -> list:
    """What the document shows otherwise than the sheet, a line each."""
    content = PaperContent(document)
    pieces = list(drawn_by(sheet))
    lines = [line for view in sheet.views for line in view_lines(view)]
    lines += [line for piece in pieces for line in primitive_lines(piece)]
    found: list = list(content.cut_off)
    found += [f"no line ends at {end}" for end in apart(ends(lines), ends(content.lines))]
    found += [f"a line ends at {end}" for end in apart(ends(content.lines), ends(lines))]
    wanted = sorted((piece.text.replace("⌀", "Ø"), middle_of(piece)) for piece in pieces if isinstance(piece, Text))
    written = sorted((text.text, text.middle) for text in content.texts)
    found += [f"{a} and {b}" for a, b in zip_longest(wanted, written) if a is None or b is None or a[0] != b[0]]
    places = [np.array([middle for _, middle in texts]) for texts in (wanted, written)]
    return found + apart(*places) + apart(*reversed(places))


def wrong_numbers(document: Drawing) -> list[str]:
    """Dimensions whose drawn text is not what their points measure."""
    found = []
    for dimension in document.modelspace().query("DIMENSION"):
        measured = dimension.get_measurement()  # pyright: ignore[reportAttributeAccessIssue]
        decimals = document.dimstyles.get(dimension.dxf.dimstyle).dxf.dimdec
        expected = dimension.dxf.text.replace("<>", f"{measured:.{decimals}f}")
        drawn = "".join(one.plain_text() for one in visible_entities(document, [dimension]) if one.dxftype() == "TEXT")
        for code, sign in (("%%c", "Ø"), ("%%d", "°"), ("%%p", "±"), ("⌀", "Ø")):
            expected, drawn = expected.replace(code, sign), drawn.replace(code, sign)
        if "<>" not in dimension.dxf.text or expected != drawn:
            found.append(f"{drawn} is drawn, {expected} is measured")
    return found


@pytest.mark.parametrize("part", MADE)
def test_the_file_shows_what_the_sheet_has(part: str) -> None:
    for sheet in sheets(part):
        document = document_of(sheet)
        assert differences(sheet, document) == []
        assert wrong_numbers(document) == []
        auditor = document.audit()
        assert [error.message for error in (*auditor.errors, *auditor.fixes)] == []


def test_a_line_or_number_that_differs_is_found() -> None:
    document = document_of(CLEAN)
    assert differences(CLEAN, document) == []
    document.modelspace().add_line((250.0, 350.0), (251.0, 350.0), dxfattribs={"layer": "VISIBLE"})
    assert differences(CLEAN, document)
    dimension = document.modelspace().query("DIMENSION").first
    assert dimension is not None
    assert wrong_numbers(document) == []
    dimension.dxf.defpoint3 = (dimension.dxf.defpoint3.x + 1.0, dimension.dxf.defpoint3.y)
    assert len(wrong_numbers(document)) == 1


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
