"""Arrangement of views with their annotations on a sheet in third-angle projection, without overlap.

`annotated_views` places annotations around each view; `arrange` places these views on a sheet. Whether they fit is part
of the result: otherwise the caller takes a larger paper, another place for the notes, or detaches a view from its row.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

from drawings.annotations.annotation import Annotation, DetailMark, ReferenceArrow, SectionMark
from drawings.dimensions.specification import DimensionSpec
from drawings.placement.lint_rules import view_outline
from drawings.placement.place import AnnotatedView, place_annotations
from drawings.views.segment_index import boxes_overlap, enlarged
from drawings.views.view import Box2, Point2, View, dot, enclosing_box
from stagecad.parameters.dimension import Point

VIEW_SPACING, TABLE_SPACING = 9.0, 3.0
"""Least distance between two views with their annotations, and between a view and a table, mm."""
STEP = 4.0
"""Step between the trial positions of a view that is not aligned with another, mm."""
REFERENCE_LETTERS = "PQRSTUVW"
"""Labels of views that are not in their place by projection."""
OUTSIDE = 6.0
"""Length of a cutting line beyond the part at either end, mm."""
BESIDE_CUTTING_LINE = 20.0
"""Distance of a reference arrow from a cutting line parallel to it, mm."""


@dataclass(frozen=True)
class SheetArea:
    """Area available for views and annotations."""

    space: Box2  # inside of the frame, less a margin
    taken: tuple[Box2, ...]  # title block and other boxes within it


@dataclass(frozen=True)
class Arrangement:
    """Views and annotations in place."""

    views: tuple[View, ...]
    annotations: tuple[Annotation, ...]
    fits: bool  # whether all views are within the area and do not overlap
    conflicts: int  # sum of the conflicts around each view; 0 on a good sheet


def annotated_views(views: Sequence[View], specs: Sequence[DimensionSpec]) -> tuple[AnnotatedView, ...]:
    """Views with their annotations."""
    views = [_labelled(view, views) for view in views]
    return tuple(
        place_annotations(view, [spec for spec in specs if spec.view == view.name], _marks(view, views))
        for view in views
    )


def _labelled(view: View, views: Sequence[View]) -> View:
    """A section with `turned` in its label where it is turned against its place by projection (ISO 128-3)."""
    parent = _parent(view, views) if view.cut and not view.clip else None
    return replace(view, label=f"{view.label}, turned") if parent and _is_turned(view, parent) else view


def detached(every: Sequence[AnnotatedView], name: str) -> tuple[AnnotatedView, ...]:
    """The views, the named one not aligned: labelled with a letter, and indicated by a reference arrow in another."""
    letters = {one.view.label[:1] for one in every}
    letter = next(letter for letter in REFERENCE_LETTERS if letter not in letters)
    eye = next(one.view for one in every if one.view.name == name).projection.towards_eye
    usual = (o.view for o in every if not o.view.clip and o.view.projection.name not in ("iso", "auxiliary"))
    # A face at a compound angle is seen as a line in none.
    parent = min(usual, key=lambda view: (round(abs(dot(view.projection.towards_eye, eye)), 6), view.cut is not None))
    found = []
    for one in every:
        if one.view.name == name:
            view = replace(one.view, aligned_with="", label=f"{letter} {one.view.label}".strip())
            one = place_annotations(view, one.specs, one.marks)
        elif one.view.name == parent.name:
            one = place_annotations(one.view, one.specs, (*one.marks, _reference_arrow(parent, eye, letter, one.marks)))
        found.append(one)
    return tuple(found)


def _reference_arrow(parent: View, eye: Point, letter: str, marks: Sequence[Annotation]) -> ReferenceArrow:
    """The arrow of a view from a direction, outside the middle of the side of another view that it faces, and beside
    a cutting line that ends there."""
    x0, y0, x1, y1 = view_outline(parent)
    u, v = parent.projection.to_view(eye)
    middle, half = ((x0 + x1) / 2, (y0 + y1) / 2), ((x1 - x0) / 2 + OUTSIDE, (y1 - y0) / 2 + OUTSIDE)
    x, y = middle[0] + u * half[0], middle[1] + v * half[1]
    for mark in marks:
        if isinstance(mark, SectionMark):
            dx, dy = mark.end[0] - mark.start[0], mark.end[1] - mark.start[1]
            along, off = dx * v - dy * u, (x - mark.start[0]) * v - (y - mark.start[1]) * u
            if abs(along) < 1e-6 and abs(off) < BESIDE_CUTTING_LINE:
                x, y = x - BESIDE_CUTTING_LINE * v, y + BESIDE_CUTTING_LINE * u
    return ReferenceArrow(parent.name, (x, y), (-u, -v), letter)


def arrange(every: Sequence[AnnotatedView], area: SheetArea) -> Arrangement:
    """Place annotated views on a sheet."""
    aligned = _aligned(every)
    alone = [one for one in every if one.view.name not in aligned]
    boxes = [_shifted(one.box, aligned[one.view.name]) for one in every if one.view.name in aligned]
    places, fits = _on_sheet(boxes, [one.box for one in alone], area)
    shift, *others = places
    by_name = {name: (x + shift[0], y + shift[1]) for name, (x, y) in aligned.items()}
    by_name |= {one.view.name: place for one, place in zip(alone, others, strict=True)}
    placed = tuple(_placed(one.view, by_name[one.view.name]) for one in every)
    annotations = tuple(a.translated(by_name[one.view.name]) for one in every for a in one.annotations)
    return Arrangement(placed, annotations, fits, sum(one.conflicts for one in every))


def _placed(view: View, place: Point2) -> View:
    label_at = (view.label_at[0] + place[0], view.label_at[1] + place[1]) if view.label_at else None
    return replace(view, place=place, label_at=label_at)


def _marks(view: View, views: Sequence[View]) -> list[Annotation]:
    """Cutting lines and circles of details that a view shows, for the view at the origin of the paper."""
    shown = [other for other in views if _parent(other, views) is view]
    shown = [other for other in shown if other.clip or (other.cut and other.cut.letter)]
    return [_detail_mark(view, *one.clip, one.label[:1]) if one.clip else _section_mark(view, one) for one in shown]


def _detail_mark(parent: View, centre: Point2, radius: float, letter: str) -> DetailMark:
    away = (radius * parent.scale + 4.0) * math.sqrt(0.5)
    letter_at = (centre[0] * parent.scale + away, centre[1] * parent.scale + away)
    return DetailMark(parent.name, centre, radius, letter_at, letter)


def _section_mark(parent: View, section: View) -> SectionMark:
    """The cutting line along the path of a section, its ends outside the outline of the parent."""
    cut = section.cut
    assert cut is not None
    x0, y0, x1, y1 = view_outline(parent)
    normal = parent.projection.to_view(cut.normal)
    along = (normal[1], -normal[0]) if abs(normal[1]) > abs(normal[0]) else (-normal[1], normal[0])
    if not cut.more and cut.kind == "offset":
        u, v = parent.projection.to_view(cut.point)
        path = [(u, v), (u + along[0], v + along[1])]
    else:
        path = [parent.projection.to_view(point) for point in cut.path]
    path = [(u * parent.scale, v * parent.scale) for u, v in path]

    def outside(before: Point2, point: Point2) -> Point2:
        """The end of a leg beyond the outline."""
        size = math.dist(before, point)
        u, v = (point[0] - before[0]) / size, (point[1] - before[1]) / size
        exits = [((x1 if u > 0 else x0) - before[0]) / u] if abs(u) > 1e-6 else []
        exits += [((y1 if v > 0 else y0) - before[1]) / v] if abs(v) > 1e-6 else []
        reach = min(exits) + OUTSIDE
        return (before[0] + reach * u, before[1] + reach * v)

    start, end = outside(path[1], path[0]), outside(path[-2], path[-1])
    return SectionMark(parent.name, start, end, (-normal[0], -normal[1]), cut.letter, tuple(path[1:-1]))


def _parent(view: View, views: Sequence[View]) -> View | None:
    """The view that shows where a section or a detail is taken."""
    whole = [other for other in views if other.name != view.name and not other.clip and other.projection.name != "iso"]
    first = [other for other in whole if other.name == view.aligned_with]
    # A detail is marked in the view from outside rather than in a section, and that of a section there.
    for other in sorted(whole, key=lambda other: other.cut != view.cut):
        if view.clip and other.projection == view.projection:
            return other
    # Preferably where the section would be in its place by projection, not turned.
    for other in (*first, *sorted(whole, key=lambda other: _is_turned(view, other))):
        cut, eye = view.cut, other.projection.towards_eye
        # The corners of a path are one behind the other where it changes along the line of sight.
        straight = cut and cut.kind == "offset" and not cut.more
        seen = cut and abs(dot(cut.normal, eye)) < 1e-6 and (straight or abs(dot(cut.way, eye)) < 1e-6)
        if seen and not view.clip and not (other.cut and other.cut.letter):
            return other
    return None


def _is_turned(view: View, other: View) -> bool:
    """Whether a view is turned against its place by projection beside, above or below another view."""
    shared = "up" if abs(dot(view.projection.towards_eye, other.projection.right)) > 0.5 else "right"
    return dot(getattr(view.projection, shared), getattr(other.projection, shared)) < 1 - 1e-6


def _aligned(every: Sequence[AnnotatedView]) -> dict[str, Point2]:
    """Places of the first view, at (0, 0), and of all views aligned with it, by name."""
    places: dict[str, Point2] = {every[0].view.name: (0.0, 0.0)}
    boxes = {every[0].view.name: every[0].box}
    waiting = list(every[1:])
    while True:
        one = next((one for one in waiting if one.view.aligned_with in places), None)
        if one is None:
            return places
        waiting.remove(one)
        parent = next(other for other in every if other.view.name == one.view.aligned_with)
        side = _side(one.view, parent.view)
        x, y = places[parent.view.name]
        step = 0.0
        while True:
            place = (x + side[0] * step, y + side[1] * step)
            box = enlarged(_shifted(one.box, place), VIEW_SPACING / 2)
            if not any(boxes_overlap(box, enlarged(other, VIEW_SPACING / 2)) for other in boxes.values()):
                break
            step += 1.0
        places[one.view.name] = place
        boxes[one.view.name] = _shifted(one.box, place)


def _side(view: View, parent: View) -> Point2:
    """Side of the parent on which third-angle projection puts a view; a parallel view is to the right, or below."""
    eye = view.projection.towards_eye
    across, up = dot(eye, parent.projection.right), dot(eye, parent.projection.up)
    if abs(across) > 0.5:
        return (math.copysign(1.0, across), 0.0)
    if abs(up) > 0.5:
        return (0.0, math.copysign(1.0, up))
    x0, y0, x1, y1 = view_outline(parent)
    return (1.0, 0.0) if x1 - x0 <= 1.5 * (y1 - y0) else (0.0, -1.0)


def _on_sheet(aligned: Sequence[Box2], alone: Sequence[Box2], area: SheetArea) -> tuple[list[Point2], bool]:
    """Shift of the aligned views, then of each other view; and whether all fit."""
    x0, y0, x1, y1 = area.space
    whole = enclosing_box(aligned)
    free = (x1 - x0 - (whole[2] - whole[0]), y1 - y0 - (whole[3] - whole[1]))
    best: list[Point2] | None = None
    # Fractions of the free width and height, from near the middle outwards.
    steps = [i / 10 for i in range(11)]
    places = [(a, b) for a in steps for b in steps]
    for fraction in sorted(places, key=lambda s: (math.hypot(s[0] - 0.45, s[1] - 0.6), s)):
        shift = (x0 - whole[0] + free[0] * fraction[0], y0 - whole[1] + free[1] * fraction[1])
        placed = [_shifted(box, shift) for box in aligned]
        if not all(_free(box, area, ()) for box in placed):
            continue
        best = best or [shift]
        others: list[Point2] = []
        for box in alone:
            place = _free_place(box, area, placed)
            if place is None:
                break
            others.append(place)
            placed.append(_shifted(box, place))
        else:
            return [shift, *others], True
    shift = best[0] if best else (x0 - whole[0], y1 - whole[3])
    return [shift, *((x1 - box[2], y1 - box[3]) for box in alone)], False


def _free_place(box: Box2, area: SheetArea, placed: Sequence[Box2]) -> Point2 | None:
    """The free place nearest to the upper right corner for a view that is not aligned."""
    x0, y0, x1, y1 = area.space
    columns = int((x1 - x0 - (box[2] - box[0])) // STEP) + 1
    rows = int((y1 - y0 - (box[3] - box[1])) // STEP) + 1
    places = [(x1 - box[2] - STEP * i, y1 - box[3] - STEP * j) for i in range(columns) for j in range(rows)]
    by_distance = sorted(places, key=lambda p: -(p[0] + p[1]))
    return next((place for place in by_distance if _free(_shifted(box, place), area, placed)), None)


def _free(box: Box2, area: SheetArea, placed: Sequence[Box2]) -> bool:
    x0, y0, x1, y1 = area.space
    inside = x0 - 1e-6 <= box[0] and y0 - 1e-6 <= box[1] and box[2] <= x1 + 1e-6 and box[3] <= y1 + 1e-6
    if not inside or any(boxes_overlap(box, enlarged(taken, TABLE_SPACING)) for taken in area.taken):
        return False
    return not any(boxes_overlap(box, enlarged(other, VIEW_SPACING)) for other in placed)


def _shifted(box: Box2, place: Point2) -> Box2:
    return (box[0] + place[0], box[1] + place[1], box[2] + place[0], box[3] + place[1])
