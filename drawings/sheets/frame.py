"""The drawing frame with its zones, centring and trimming marks (ISO 5457), and the title block (ISO 7200)."""

import string
from collections.abc import Iterator
from dataclasses import dataclass
from itertools import pairwise
from typing import Literal

from drawings.annotations.primitives import (
    LARGE_HEIGHT,
    SMALL_HEIGHT,
    TEXT_HEIGHT,
    ArcStroke,
    FilledPolygon,
    Primitive,
    Stroke,
    Text,
    rectangle,
    text_width,
)
from drawings.views.view import Arc, Box2, Point2

Paper = Literal["A4", "A3", "A2", "A1", "A0"]

PAPERS: dict[Paper, tuple[float, float]] = {
    "A4": (210.0, 297.0),
    "A3": (420.0, 297.0),
    "A2": (594.0, 420.0),
    "A1": (841.0, 594.0),
    "A0": (1189.0, 841.0),
}
"""Trimmed sizes, mm: width, height."""

FILING_MARGIN, MARGIN = 20.0, 10.0
"""Distance of the frame from the trimmed edge: on the left, and elsewhere, mm."""
BORDER = 5.0
"""Width of the border that carries the zones, mm."""
ZONE = 50.0
"""Length of a zone, counted from the centring marks, mm."""
CENTRING = 10.0
"""How far a centring mark reaches into the frame, mm."""

_LETTERS = [letter for letter in string.ascii_uppercase if letter not in "IO"]


def drawing_space(paper: Paper) -> Box2:
    """Inside of the frame, mm."""
    width, height = PAPERS[paper]
    return (FILING_MARGIN, MARGIN, width - MARGIN, height - MARGIN)


def frame(paper: Paper) -> Iterator[Primitive]:
    """Frame, border, zones and marks of a sheet."""
    width, height = PAPERS[paper]
    x0, y0, x1, y1 = drawing_space(paper)
    outer = (x0 - BORDER, y0 - BORDER, x1 + BORDER, y1 + BORDER)
    yield rectangle(drawing_space(paper), "FRAME")
    yield rectangle(outer)
    middle = (width / 2, height / 2)
    for start, end in (
        ((outer[0], middle[1]), (x0 + CENTRING, middle[1])),
        ((outer[2], middle[1]), (x1 - CENTRING, middle[1])),
        ((middle[0], outer[1]), (middle[0], y0 + CENTRING)),
        ((middle[0], outer[3]), (middle[0], y1 - CENTRING)),
    ):
        yield Stroke((start, end), "FRAME")
    yield from _zones(middle[0], x0, x1, [str(i + 1) for i in range(99)], (y0 - BORDER, y1), upright=False)
    yield from _zones(middle[1], y0, y1, _LETTERS, (x0 - BORDER, x1), upright=True)
    yield from _trimming(width, height)


def _zones(
    middle: float, low: float, high: float, names: list[str], borders: tuple[float, float], *, upright: bool
) -> Iterator[Primitive]:
    """Division marks and names along two opposite borders; letters run from the top down."""
    reach = int((high - low) / 2 // ZONE)
    inner = [middle + i * ZONE for i in range(-reach, reach + 1)]
    # A remainder shorter than a third of a zone is part of the last zone.
    marks = [at for at in inner if min(at - low, high - at) > ZONE / 3]
    centres = [(a + b) / 2 for a, b in pairwise([low, *marks, high])]
    if upright:
        centres.reverse()

    def point(along: float, across: float) -> Point2:
        return (across, along) if upright else (along, across)

    for border in borders:
        for at in marks:
            if at != middle:
                yield Stroke((point(at, border), point(at, border + BORDER)))
        for name, at in zip(names, centres):
            x, y = point(at, border + BORDER / 2)
            yield Text(name, (x, y - TEXT_HEIGHT / 2), TEXT_HEIGHT, "middle")


def _trimming(width: float, height: float) -> Iterator[Primitive]:
    long, short = 10.0, 5.0
    for x, toward_x in ((0.0, 1), (width, -1)):
        for y, toward_y in ((0.0, 1), (height, -1)):
            for a, b in ((long, short), (short, long)):
                yield FilledPolygon(
                    ((x, y), (x + toward_x * a, y), (x + toward_x * a, y + toward_y * b), (x, y + toward_y * b))
                )


WIDTH, HEIGHT = 180.0, 67.0
BASE_LINE, DESCENT = 1.9, 0.43
"""Least height of a base line over the lower edge of its cell, mm, and in heights of the text: an underscore stays in
the cell."""
REVISION_ROW = 5.0
"""Height of a row of the revision table, mm."""


@dataclass(frozen=True)
class TitleBlock:
    """Fields of the title block."""

    title: str  # name of the part or of the sheet
    supplement: str  # product of the part
    number: str  # file name of the drawing, `THS_PZT_TIP`
    material: str  # of the part; empty on an assembly
    mass: str  # with its unit, `39.1 g`
    scale: str  # of the main views, `1:2`
    # sheet, sheets: number of this sheet, and of how many
    sheet: int
    sheets: int
    revision: str  # of the drawing
    parameters: str  # hash of the parameters the sheet depends on
    kind: str  # of document, `Part drawing`
    finish: str  # general surface texture
    tolerances: tuple[tuple[str, str], ...]  # class and tolerance, `("X.XX", "±0.01")`; `ANGLE` for all angles
    edges: str = "-"  # state of edges (ISO 13715)
    treatment: str = "-"  # of the material
    date: str = "-"  # of the issue
    creator: str = "stagecad"  # of the issue
    checker: str = "-"  # of the issue
    approver: str = "-"  # of the issue
    company: str = "-"  # of the issue
    revisions: tuple[str, ...] = ()  # changes since the earlier issue, a line each
    geometry: str = ""  # general geometrical tolerance; empty for none


def title_area(block: TitleBlock, paper: Paper) -> Box2:
    """Bounding box of the title block with the revision table above it, where there is an earlier issue."""
    x0, y0, x1, y1 = title_box(paper)
    return (x0, y0, x1, y1 + REVISION_ROW * (len(block.revisions) + bool(block.revisions)))


def revision_primitives(block: TitleBlock, paper: Paper) -> Iterator[Primitive]:
    """Lines and texts of the revision table: what differs from the earlier issue."""
    if not block.revisions:
        return
    (x0, _, x1, y), top = title_box(paper), title_area(block, paper)[3]
    yield rectangle((x0, y, x1, top), "FRAME")
    for text in (*reversed(block.revisions), f"Revision {block.revision}, {block.date}: changes"):
        fitting = min(1.0, (x1 - x0 - 3.0) / text_width(text, SMALL_HEIGHT))
        yield Text(text, (x0 + 1.8, y + (REVISION_ROW - SMALL_HEIGHT) / 2), SMALL_HEIGHT * fitting)
        y += REVISION_ROW
        if y < top - 1e-6:
            yield Stroke(((x0, y), (x1, y)))


def title_box(paper: Paper) -> Box2:
    """Bounding box of the title block, mm."""
    _, y0, x1, _ = drawing_space(paper)
    return (x1 - WIDTH, y0, x1, y0 + HEIGHT)


def title_primitives(block: TitleBlock, paper: Paper) -> Iterator[Primitive]:
    """Lines and lettering of the title block."""
    x0, y0, x1, y1 = title_box(paper)
    yield rectangle((x0, y0, x1, y1), "FRAME")
    rows = [y0, y0 + 11, y0 + 22, y0 + 33, y0 + 44, y0 + 55, y1]
    for y in rows[1:-1]:
        yield Stroke(((x0, y), (x1, y)))

    def cells(row: int, *fields: tuple[str, str, float, float]) -> Iterator[Primitive]:
        """One row of cells from left to right: caption, text, width, height of text."""
        left = x0
        for number, (caption, text, width, height) in enumerate(fields):
            if number:
                yield Stroke(((left, rows[row]), (left, rows[row + 1])))
            yield from _cell((left, rows[row], left + width, rows[row + 1]), caption, text, height)
            left += width

    # From the bottom up: the lowest row is read first.
    yield from cells(
        0,
        ("File name", block.number, 66, LARGE_HEIGHT),
        ("Scale", block.scale, 30, LARGE_HEIGHT),
        ("Units", "MM", 18, LARGE_HEIGHT),
        ("Revision", block.revision, 24, TEXT_HEIGHT),
        ("Sheet", f"{block.sheet} of {block.sheets}", 42, LARGE_HEIGHT),
    )
    yield from cells(1, ("", "", 66, TEXT_HEIGHT), ("", "", 114, TEXT_HEIGHT))
    yield from _cell((x0 + 66, rows[1], x1, rows[2]), "Title", block.title.upper(), LARGE_HEIGHT)
    yield from cells(
        2,
        ("", "", 66, TEXT_HEIGHT),
        ("Belongs to", block.supplement, 74, TEXT_HEIGHT),
        ("Projection, third angle", "", 40, TEXT_HEIGHT),
    )
    yield from _third_angle((x0 + 161, rows[2] + 1.8))
    yield from cells(
        3,
        ("Material", block.material, 66, TEXT_HEIGHT),
        ("Mass", block.mass, 30, TEXT_HEIGHT),
        ("Document type", block.kind, 44, TEXT_HEIGHT),
        ("Parameters", block.parameters, 40, TEXT_HEIGHT),
    )
    yield from cells(
        4,
        ("Treatment", block.treatment, 66, TEXT_HEIGHT),
        ("Edges, ISO 13715", block.edges, 74, TEXT_HEIGHT),
        ("Roughness unless stated", block.finish, 40, TEXT_HEIGHT),
    )
    yield from cells(
        5,
        ("Owner", block.company, 42, TEXT_HEIGHT),
        ("Date of issue", block.date, 30, TEXT_HEIGHT),
        ("Drawn by", block.creator, 36, TEXT_HEIGHT),
        ("Checked by", block.checker, 36, TEXT_HEIGHT),
        ("Approved by", block.approver, 36, TEXT_HEIGHT),
    )
    yield from revision_primitives(block, paper)
    yield from _tolerances(block, (x0, rows[1], x0 + 66, rows[3]))


def _cell(box: Box2, caption: str, text: str, height: float) -> Iterator[Primitive]:
    x0, y0, x1, y1 = box
    if caption:
        yield Text(caption, (x0 + 1.2, y1 - 1.0 - SMALL_HEIGHT * 0.72), SMALL_HEIGHT * 0.72)
    if text:
        fitting = min(1.0, (x1 - x0 - 3.0) / text_width(text, height))
        yield Text(text, (x0 + 1.8, y0 + max(BASE_LINE, DESCENT * height)), height * fitting)


def _tolerances(block: TitleBlock, box: Box2) -> Iterator[Primitive]:
    """The table of what the decimals of a dimension allow, and angles; the general geometrical tolerance."""
    x0, y0, x1, y1 = box
    classes = block.tolerances
    caption = f"ISO 8015; {block.geometry}; by decimals" if block.geometry else "ISO 8015; lengths by decimals"
    if not classes:
        return
    yield Text(caption, (x0 + 1.2, y1 - 1.0 - SMALL_HEIGHT * 0.72), SMALL_HEIGHT * 0.72)
    width = (x1 - x0) / max(1, len(classes))
    for number, (name, allowed) in enumerate(classes):
        left = x0 + number * width
        yield Text(name, (left + width / 2, y0 + 12.6), TEXT_HEIGHT, "middle")
        yield Text(allowed, (left + width / 2, y0 + 2.4), TEXT_HEIGHT, "middle")
        if number:
            yield Stroke(((left, y0), (left, y0 + 11)))


def _third_angle(at: Point2, size: float = 5.0) -> Iterator[Primitive]:
    """The symbol of third-angle projection (ISO 5456-2): two circles, and the cone they belong to at their right."""
    x, y = at
    y += size / 2
    circles = (x - size * 1.1, y)
    for diameter in (size, size / 2):
        yield ArcStroke(Arc(circles, diameter / 2))
    left, right = x + size * 0.35, x + size * 1.55
    small, wide = size / 4, size / 2
    cone = ((left, y - small), (right, y - wide), (right, y + wide), (left, y + small), (left, y - small))
    yield Stroke(cone)
    over = 1.0
    yield Stroke(((circles[0] - size / 2 - over, y), (circles[0] + size / 2 + over, y)))
    yield Stroke(((circles[0], y - size / 2 - over), (circles[0], y + size / 2 + over)))
    yield Stroke(((left - over, y), (right + over, y)))
