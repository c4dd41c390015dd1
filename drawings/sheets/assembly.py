"""The assembly sheet: top view, sections through actuator 1, exploded views with balloons, parts list."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

from drawings.annotations.annotation import ARROW, BALLOON, Annotation, Balloon, LinearDimension, Note, SectionMark
from drawings.annotations.primitives import (
    LARGE_HEIGHT,
    LINE_PITCH,
    SMALL_HEIGHT,
    TEXT_HEIGHT,
    Primitive,
    Stroke,
    Text,
    text_width,
)
from drawings.pictures.picture import EXPLODED, FROM_BELOW, SCALE, SECTION, SIDE_SECTION, TOP, Picture
from drawings.sheets.frame import Paper, TitleBlock, title_area, title_box
from drawings.sheets.sheet import Sheet, scale_text, sheet_area
from drawings.views.segment_index import enlarged, line_meets_box, lines_cross
from drawings.views.view import Box2, Curve, Point2, Segment, View, extreme_points, view_box
from stagecad.parameters.dimension import Point
from stagecad.solids.assembly.bill_of_materials import Accessory, Row

FIRST, NEXT = 12.0, 10.0
"""Distance of the first dimension line from the view, and of the next ones, mm on the paper."""
SIDE = 24.0
"""Distance of the dimension lines from the top view, beyond the letters of the sections, mm on the paper."""
DIMENSIONED = FIRST + 2 * NEXT
"""Height of the dimensions above a view, mm on the paper."""
_NEAR = 1e-3
Size = tuple[Point, Point, float]
"""Corners of a machine's bounding box at the middle of travel, assembly coordinates, and the travel of the parts that
move, from end to end, 0 without; mm."""


def travel_range(stage: Sequence[Curve], travel: float) -> tuple[tuple[Curve, ...], list[Point2]]:
    """The end faces of the stage, given its visible lines in a view with the travel along u, at the ends of travel, mm
    from end to end, and its upper and lower edges up to the middle position; and the upper corners of its end faces,
    left and right, at the middle of travel."""
    lines: list[Curve] = []
    corners: list[Point2] = []
    for side in (-1.0, 1.0):
        farthest = {number: max(side * u for u, _ in extreme_points(curve)) for number, curve in enumerate(stage)}
        face = [stage[number] for number, end in farthest.items() if end > max(farthest.values()) - _NEAR]
        upright = [c for c in face if isinstance(c, Segment) and abs(c.start[0] - c.end[0]) < _NEAR]
        shift = side * travel / 2
        low, high = (
            pick((point for curve in upright or face for point in extreme_points(curve)), key=lambda point: point[1])
            for pick in (min, max)
        )
        corners.append(high)
        moved = [(u + shift, v) for u, v in (low, high)]
        lines.append(Segment(moved[0], moved[1]))
        lines += [Segment(at, end) for at, end in zip((low, high), moved, strict=True)]
    return tuple(lines), corners


def overall_dimensions(size: Size, top: View, front: View, ends: Sequence[Point2]) -> Iterator[LinearDimension]:
    """Length and width at the view from above, height at the section, and with the upper corners of the end faces of
    what moves the travel."""
    (x0, y0, z0), (x1, y1, z1), travel = size
    left, _, _, above = view_box(top) or (0.0, 0.0, 0.0, 0.0)
    yield _reference(top, (x0, y1), (x1, y1), 0.0, (left, above + SIDE), "overall length")
    yield _reference(top, (x0, y0), (x0, y1), 90.0, (left - SIDE, above), "overall width")
    _, _, right, above = view_box(front) or (0.0, 0.0, 0.0, 0.0)
    if not ends:
        yield _reference(front, (x1, z0), (x1, z1), 90.0, (right + FIRST, above), "overall height")
        return
    half = travel / 2
    (u0, v0), (u1, v1) = ends
    yield _reference(front, (x1, z0), (u1 + half, z1), 90.0, (right + FIRST, above), "overall height")
    halves = [
        _reference(front, first, second, 0.0, (right, above + FIRST), "half of the travel")
        for first, second in (((u0 - half, v0), (u0, v0)), ((u1, v1), (u1 + half, v1)))
    ]
    # Where the number does not fit between the arrows, the travel is in the notes only.
    if half * front.scale > max(text_width(one.text) for one in halves) + 2 * ARROW:
        yield from halves
    over = (right, above + FIRST + NEXT)
    yield _reference(front, (u0 - half, v0), (u1 + half, v1), 0.0, over, "length over the ends of travel")


def _reference(view: View, first: Point2, second: Point2, angle: float, line_at: Point2, name: str) -> LinearDimension:
    """A horizontal or vertical dimension in brackets between two points of a view."""
    measured = abs(second[0] - first[0]) if angle == 0.0 else abs(second[1] - first[1])
    return LinearDimension(view.name, first, second, angle, line_at, f"({measured:.1f})", measured, (name,))


SIZES: tuple[Paper, ...] = ("A3", "A2", "A1", "A0")
"""Sizes of the paper, the smallest on which the exploded view fits beside the other views."""
HEADINGS: tuple[str, ...] = ("Item", "Qty", "Part", "Number", "Material", "Mass each")
"""Headings of the columns of the parts list."""
ROW = 6.5
"""Height of its rows, mm."""
CELL = 3.0
"""Distance of a text from both sides of its cell together, mm."""
MARGIN = 24.0
"""Least distance around the top view and the section, mm."""


@dataclass(frozen=True)
class AssemblyDescription:
    """The data of the machine for its sheets."""

    rows: tuple[Row, ...]  # bill of materials
    size: Size
    mass: str  # total, with its unit
    digest: str  # hash of the parameters
    reads: tuple[str, ...]  # names of the parameters
    accessories: tuple[Accessory, ...] = ()  # what is needed besides the parts
    carried: tuple[str, ...] = ()  # parts that move, and those that move with them
    scale: float = SCALE  # of the views
    notes: tuple[str, ...] = ()  # of the sheet, a line each


def assembly_sheet(machine: AssemblyDescription, design: Any, pictures: Mapping[str, Picture]) -> Sheet:
    """The sheet of the whole machine."""
    exploded = [pictures[name] for name in (EXPLODED, FROM_BELOW) if name in pictures]
    cut = pictures[SECTION]
    carried = [line for part, lines in cut.pieces if part in machine.carried for line in lines]
    front, notes, ends = cut.view, ("NOTES", *machine.notes), []
    if carried:
        lines, ends = travel_range(carried, machine.size[2])
        front = replace(front, curves={**front.curves, "PHANTOM": lines})
        notes = (*notes, f"- Travel {machine.size[2]:.1f} mm; chain lines with two dots show its ends.")
    rows = len(machine.rows) + len(machine.accessories)
    column = [pictures[TOP].view, front, pictures[SIDE_SECTION].view]
    drawn = [*column, *(one.view for one in exploded)]
    paper = _paper(drawn)
    title = title_of(machine, design, "assembly")
    above = title_area(title, paper)
    views = _placed(drawn, (above[0], above[3] + (rows + 1) * ROW), len(notes), paper)
    marks: list[Annotation] = [*_marks(views[0]), *overall_dimensions(machine.size, views[0], views[1], ends)]
    placed = [replace(one, view=view) for one, view in zip(exploded, views[3:], strict=True)]
    marks += all_balloons(placed, machine.rows)
    return Sheet(
        name="assembly",
        part="assembly",
        paper=paper,
        scale=machine.scale,
        title=title,
        views=tuple(views),
        annotations=tuple(marks),
        notes=(Note(sheet_area(paper).space[:2], notes),),
        tables=tuple(parts_list(machine.rows, above, machine.accessories)),
    )


def all_balloons(pictures: Sequence[Picture], rows: Sequence[Row]) -> list[Balloon]:
    """A balloon for each row of the parts list, in the first of the placed views that shows its part."""
    found: list[Balloon] = []
    for one in pictures:
        shown = {balloon.number for balloon in found}
        found += balloons(one, [row for row in rows if row.item not in shown])
    return found


def _paper(views: Sequence[View]) -> Paper:
    """The smallest paper on which the exploded view and its balloons fit between the other views and the parts list."""
    boxes = [view_box(view) or (0.0, 0.0, 0.0, 0.0) for view in views]
    low, high = _column(boxes)
    needed = high - low + 2 * MARGIN + boxes[3][2] - boxes[3][0] + 8 * BALLOON
    tall = sum(box[3] - box[1] for box in boxes[:3]) + 4 * MARGIN + 2 * DIMENSIONED + 4 * LARGE_HEIGHT
    for paper in SIZES:
        x0, y0, _, y1 = sheet_area(paper).space
        if needed <= title_box(paper)[0] - x0 and tall <= y1 - y0:
            return paper
    return SIZES[-1]


def _column(boxes: Sequence[Box2]) -> tuple[float, float]:
    """Left and right end of the views in the left column, from their origin, with their dimensions."""
    upper, lower, side = boxes[:3]
    return min(upper[0] - SIDE, lower[0], side[0]), max(upper[2], lower[2] + FIRST, side[2])


def _placed(views: Sequence[View], corner: Point2, notes: int, paper: Paper) -> list[View]:
    """Views on the paper: top view above the sections on the left, exploded view in the middle, from below under it.
    The view from below is at half the scale above the parts list (`corner`: its upper left) if it does not fit under
    the exploded view."""
    x0, y0, x1, y1 = sheet_area(paper).space
    boxes = [view_box(view) or (0.0, 0.0, 0.0, 0.0) for view in views]
    upper, lower, side = boxes[:3]
    low_x, high_x = _column(boxes)
    column = high_x - low_x + 2 * MARGIN
    left = x0 + MARGIN - low_x
    floor = y0 + (notes + 2) * LINE_PITCH * TEXT_HEIGHT
    label = 2 * LARGE_HEIGHT
    height = sum(box[3] - box[1] for box in boxes[:3]) + MARGIN + 2 * DIMENSIONED + 2 * label
    gap = max(0.4 * MARGIN, (y1 - floor - height) / 4)
    top_at = (left, y1 - gap - DIMENSIONED - upper[3])
    front_at = (left, top_at[1] + upper[1] - gap - DIMENSIONED - lower[3])
    places = [top_at, front_at, (left, front_at[1] + lower[1] - label - gap - side[3])]
    list_left, list_top = corner
    middle = (x0 + column, y0, list_left, y1)
    apart = [replace(view, place=place) for view, place in zip(views, places, strict=False)]
    if len(views) > 4:
        stacked = _stacked(boxes[3], boxes[4], middle)
        if stacked:
            below = replace(views[4], label=FROM_BELOW.upper())
            return [*apart, *(replace(v, place=place) for v, place in zip((views[3], below), stacked, strict=True))]
        scale = views[4].scale / 2
        half = replace(views[4], scale=scale, label=f"{FROM_BELOW.upper()} ({scale_text(scale)})")
        box = view_box(half) or (0.0, 0.0, 0.0, 0.0)
        views, boxes = [*views[:4], half], [*boxes[:4], box]
    placed = zip(views[3:], boxes[3:], (middle, (list_left, list_top, x1, y1)), strict=False)
    return [*apart, *(replace(view, place=_centred(box, area)) for view, box, area in placed)]


def _stacked(upper: Box2, lower: Box2, area: Box2) -> tuple[Point2, Point2] | None:
    """Places of two views one above the other in an area, the lower with a label; None if they do not fit."""
    label = 2 * LARGE_HEIGHT
    gap = (area[3] - area[1] - (upper[3] - upper[1]) - (lower[3] - lower[1]) - label) / 3
    wide = max(box[2] - box[0] for box in (upper, lower)) + 8 * BALLOON
    if gap < 2 * BALLOON or wide > area[2] - area[0]:
        return None
    x, _ = _centred(upper, area)
    u, _ = _centred(lower, area)
    return (x, area[3] - gap - upper[3]), (u, area[1] + gap + label - lower[1])


def _centred(box: Box2, area: Box2) -> Point2:
    return ((area[0] + area[2] - box[0] - box[2]) / 2, (area[1] + area[3] - box[1] - box[3]) / 2)


def _marks(top: View) -> Iterator[SectionMark]:
    """Cutting lines of the sections, through the origin."""
    x0, y0, x1, y1 = view_box(top) or (0.0, 0.0, 0.0, 0.0)
    (x, y), beyond = top.place, 8.0
    yield SectionMark(top.name, (x0 - beyond, y), (x1 + beyond, y), (0.0, 1.0), "A")
    yield SectionMark(top.name, (x, y0 - beyond), (x, y1 + beyond), (-1.0, 0.0), "B")


def balloons(shown: Picture, rows: Sequence[Row]) -> Iterator[Balloon]:
    """Balloons of rows of the parts list, in two columns next to a view, in the order of the heights of their parts."""
    view = shown.view
    x0, y0, x1, y1 = view_box(view) or (0.0, 0.0, 0.0, 0.0)
    middle = (x0 + x1) / 2
    ends: dict[int, list[Point2]] = {
        row.item: [at for part, piece in shown.pieces if part == row.part for at in _points(piece)] for row in rows
    }
    # The left half of the points gets balloons on the left.
    chosen: list[tuple[float, int, Point2]] = []
    for item, points in ends.items():
        if points:
            at = max(points, key=lambda p: (round(abs(view.to_paper(p)[0] - middle), 3), p))
            chosen.append((view.to_paper(at)[0], item, at))
    chosen.sort()
    half = len(chosen) // 2
    for column, x in ((chosen[:half], x0 - 3 * BALLOON), (chosen[half:], x1 + 3 * BALLOON)):
        ordered = sorted(column, key=lambda entry: view.to_paper(entry[2])[1])
        heights = spread([view.to_paper(at)[1] for _, _, at in ordered], 2.6 * BALLOON, y0, y1)
        order = uncrossed([view.to_paper(at) for _, _, at in ordered], [(x, y) for y in heights])
        for place, y in zip(order, heights, strict=True):
            _, item, at = ordered[place]
            yield Balloon(view.name, at, (x, y), item)


def uncrossed(ends: Sequence[Point2], centres: Sequence[Point2]) -> list[int]:
    """Which end each balloon of a column leads to, in the order of their heights: two are exchanged as long as this
    reduces the number of leaders that cross another or a balloon, or at an equal number their length."""
    order = list(range(len(ends)))

    def conflicts(i: int, j: int) -> int:
        one, other = ((*centres[k], *ends[order[k]]) for k in (i, j))
        boxes = [enlarged((*centres[k], *centres[k]), BALLOON) for k in (i, j)]
        return lines_cross(one, other) + line_meets_box(one, boxes[1]) + line_meets_box(other, boxes[0])

    def cost(i: int, j: int) -> tuple[int, float]:
        found = sum(conflicts(k, m) for k in (i, j) for m in range(len(order)) if m not in (i, j)) + conflicts(i, j)
        return found, round(sum(math.dist(centres[k], ends[order[k]]) for k in (i, j)), 6)

    improved = True
    while improved:
        improved = False
        for i in range(len(order)):
            for j in range(i):
                before = cost(i, j)
                order[i], order[j] = order[j], order[i]
                if cost(i, j) < before:
                    improved = True
                else:
                    order[i], order[j] = order[j], order[i]
    return order


def _points(piece: Sequence[Curve]) -> Iterator[Point2]:
    """Middles of the long straight lines of a piece, or if it has none, middle points of its curves."""
    straight = [c for c in piece if isinstance(c, Segment) and math.dist(c.start, c.end) > 4.0]
    if straight:
        yield from (((c.start[0] + c.end[0]) / 2, (c.start[1] + c.end[1]) / 2) for c in straight)
    else:
        # An end of a curve may be where another piece begins to hide it.
        yield from (points[len(points) // 2] for points in map(extreme_points, piece))


def spread(wanted: Sequence[float], apart: float, low: float, high: float) -> list[float]:
    """Heights near the desired ones, in order, at least `apart` from each other, within the limits if they fit."""
    places = list(wanted)
    for i in range(1, len(places)):
        places[i] = max(places[i], places[i - 1] + apart)
    if places and places[-1] > high:
        places[-1] = high
        for i in range(len(places) - 2, -1, -1):
            places[i] = min(places[i], places[i + 1] - apart)
    shift = max(0.0, low - places[0]) if places else 0.0
    return [place + shift for place in places]


def parts_list(rows: Sequence[Row], title: Box2, others: Sequence[Accessory] = ()) -> Iterator[Primitive]:
    """The parts list above the title block, numbered from below (ISO 7573), accessories last."""
    x0, _, x1, y0 = title
    cells = [list(HEADINGS)]
    for row in rows:
        mass = f"{row.mass:.2f} kg" if row.mass >= 1.0 else f"{1000 * row.mass:.3g} g"
        name = row.part.replace("_", " ")
        cells.append([str(row.item), str(row.quantity), name, row.part_number, row.material, mass])
    for item, other in enumerate(others, start=len(rows) + 1):
        cells.append([str(item), str(other.quantity), other.name, other.specification, "", ""])
    needed = [
        CELL + max(text_width(row[n], SMALL_HEIGHT) for row in cells if n + 1 == len(row) or row[n + 1])
        for n in range(len(HEADINGS))
    ]
    widths = [width * (x1 - x0) / sum(needed) for width in needed]
    for index, texts in enumerate(cells):
        y = y0 + index * ROW
        yield Stroke(((x0, y + ROW), (x1, y + ROW)), "FRAME" if index in (0, len(cells) - 1) else "BORDER")
        left = x0
        for number, (width, text) in enumerate(zip(widths, texts)):
            # The specification of what has no material goes on into that column.
            space = width if number + 1 < len(texts) and texts[number + 1] else sum(widths[number:])
            fitting = min(1.0, (space - CELL) / max(1e-9, text_width(text, SMALL_HEIGHT)))
            if text:
                yield Text(text, (left + CELL / 2, y + (ROW - SMALL_HEIGHT) / 2), SMALL_HEIGHT * fitting)
                yield Stroke(((left, y), (left, y + ROW)), "BORDER" if number else "FRAME")
            left += width


def title_of(machine: AssemblyDescription, design: Any, sheet: str) -> TitleBlock:
    """Title block of a sheet of the whole machine: `assembly`, or its `procedure`."""
    from drawings.sheets.part import issue_of, revisions_of, supplement_of

    drawn = sheet == "assembly"
    return TitleBlock(
        title=sheet if drawn else f"assembly {sheet}",
        supplement=supplement_of(design, machine.reads),
        number=getattr(design.drawing, f"file_{sheet}"),
        material="",
        mass=machine.mass if drawn else "",
        scale=scale_text(machine.scale),
        sheet=1,
        sheets=1,
        revision=design.drawing.revision,
        parameters=machine.digest,
        kind="Assembly drawing" if drawn else "Procedure",
        finish="",
        tolerances=(),
        **issue_of(design),
        revisions=revisions_of(design, machine.reads) if drawn else (),
    )
