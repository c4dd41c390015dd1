"""The hole table on the sheet: for each kind of hole its callout, and the coordinates of every hole."""

import math
from collections.abc import Iterator

from drawings.annotations.primitives import TEXT_HEIGHT, Primitive, Stroke, Text, rectangle
from drawings.annotations.symbols import symbol_text_primitives
from drawings.dimensions.hole_table import HoleGroup, HoleTable
from drawings.sheets.sheet import wrapped
from drawings.views.view import Box2, Point2

COLUMNS = (13.0, 20.0, 20.0)
"""Widths of name, X and Y of a hole, mm."""
ACROSS = 2
"""Number of holes in a row."""
ROW = 6.5
WIDTH = ACROSS * sum(COLUMNS)


def hole_table_box(table: HoleTable, at: Point2) -> Box2:
    """Bounding box of the table, its upper left corner at a point, mm."""
    return (at[0], at[1] - ROW * sum(1 for _ in _rows(table)), at[0] + WIDTH, at[1])


def hole_table_primitives(table: HoleTable, at: Point2) -> Iterator[Primitive]:
    """Lines and texts of the table, its upper left corner at a point."""
    x, y = at
    yield rectangle(hole_table_box(table, at))
    for row in _rows(table):
        y -= ROW
        yield Stroke(((x, y), (x + WIDTH, y)))
        base = y + (ROW - TEXT_HEIGHT) / 2
        if isinstance(row, str):
            yield from symbol_text_primitives(row, (x + 1.5, base))
            continue
        left = x
        for number, text in enumerate(row):
            width = COLUMNS[number % len(COLUMNS)]
            if number:
                yield Stroke(((left, y), (left, y + ROW)))
            yield Text(text, (left + width / 2, base), TEXT_HEIGHT, "middle")
            left += width


def _rows(table: HoleTable) -> Iterator[str | tuple[str, ...]]:
    """Rows from the top down: a callout as one text, or the cells of holes."""
    yield ("hole", "X", "Y") * ACROSS
    for group in table.groups:
        yield from _callout(group)
        height = math.ceil(len(group.rows) / ACROSS)
        cells = [row.cells for row in group.rows] + [("", "", "")] * (ACROSS * height - len(group.rows))
        for index in range(height):
            yield tuple(cell for column in range(ACROSS) for cell in cells[index + column * height])


def _callout(group: HoleGroup) -> Iterator[str]:
    """Lines of a callout joined as far as they fit; control frames on lines of their own."""
    words = ", ".join(line for line in group.lines if not line.startswith("{frame:"))
    yield from wrapped(f"{group.rows[0].tag[0]}: {words}", WIDTH - 3.0)
    yield from (line for line in group.lines if line.startswith("{frame:"))
