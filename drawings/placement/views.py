"""Places of the views on the sheet, each with its annotations: in line as third angle asks, nothing over another.

`dressed` puts round each view what is asked of it; `arrange` gives the dressed views places on a sheet. Whether all
fits is part of the answer: who calls takes a larger paper, another corner for the notes, or lets a view stand by itself
(`detached`).
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

from drawings.annotations.annotation import Annotation, DetailMark, SectionMark
from drawings.dimensions.specification import Asked
from drawings.placement.field import around, grown, overlap
from drawings.placement.occupied import moved, view_outline
from drawings.placement.place import Dressed, dress
from drawings.sheets.sheet import SheetArea
from drawings.views.view import Box2, Point2, View, dot

APART = 9.0
"""Least distance of what stands round two views, mm."""
STEP = 4.0
"""How finely places on the sheet are tried, mm."""
OUTSIDE = 6.0
"""How far a cutting line reaches beyond the part, mm."""


@dataclass(frozen=True)
class Arrangement:
    """Views and annotations with places.

    Args:
        fits: whether all stands within the area, nothing over another.
        hits: texts that touch something round their own view; 0 on a good sheet.
        needed: width and height that the views in line take, mm.
    """

    views: tuple[View, ...]
    annotations: tuple[Annotation, ...]
    fits: bool
    hits: int
    needed: tuple[float, float]


def dressed(views: Sequence[View], asked: Sequence[Asked]) -> tuple[Dressed, ...]:
    """Views with their annotations round them.

    Args:
        views: with curves and scale; `beside` says which stand in line, the first one in the middle.
        asked: as `drawings.dimensions.dimensioning.request` gives it.
    """
    marks = _marks(views)
    return tuple(
        dress(view, [one for one in asked if one.view == view.name], marks.get(view.name, ())) for view in views
    )


def detached(every: Sequence[Dressed], name: str) -> tuple[Dressed, ...]:
    """The views, the named one no longer in line with another, and so with its name below it."""
    return tuple(
        dress(replace(one.view, beside="", label=name.upper()), one.asked, one.marks) if one.view.name == name else one
        for one in every
    )


def arrange(every: Sequence[Dressed], area: SheetArea) -> Arrangement:
    """Gives dressed views places on a sheet."""
    group = _in_line(every)
    alone = [one for one in every if one.view.name not in group]
    rooms = [_at(one.room, group[one.view.name]) for one in every if one.view.name in group]
    whole = around(rooms)
    needed = (whole[2] - whole[0], whole[3] - whole[1])
    places, fits = _on_sheet(rooms, whole, [one.room for one in alone], area)
    shift, *others = places
    by_name = {name: (x + shift[0], y + shift[1]) for name, (x, y) in group.items()}
    by_name |= {one.view.name: place for one, place in zip(alone, others, strict=True)}
    placed = tuple(_placed(one.view, by_name[one.view.name]) for one in every)
    annotations = tuple(moved(a, by_name[one.view.name]) for one in every for a in one.annotations)
    return Arrangement(placed, annotations, fits, sum(one.hits for one in every), needed)


def _placed(view: View, place: Point2) -> View:
    label_at = (view.label_at[0] + place[0], view.label_at[1] + place[1]) if view.label_at else None
    return replace(view, place=place, label_at=label_at)


def _marks(views: Sequence[View]) -> dict[str, list[Annotation]]:
    """Cutting lines and circles of details, by the view that shows them, its origin at (0, 0)."""
    found: dict[str, list[Annotation]] = {}
    for view in views:
        parent = _parent(view, views)
        if parent is None:
            continue
        outline = view_outline(parent)
        if view.clip:
            (u, v), radius = view.clip
            away = (radius * parent.scale + 4.0) * math.sqrt(0.5)
            letter_at = (u * parent.scale + away, v * parent.scale + away)
            mark = DetailMark(parent.name, (u, v), radius, letter_at, view.label[:1])
        elif view.cut:
            normal = parent.projection.to_view(view.cut.normal)
            at = parent.projection.to_view(view.cut.point)
            along = (normal[1], -normal[0]) if abs(normal[1]) > abs(normal[0]) else (-normal[1], normal[0])
            reach = [
                (x - at[0] * parent.scale) * along[0] + (y - at[1] * parent.scale) * along[1]
                for x in (outline[0], outline[2])
                for y in (outline[1], outline[3])
            ]
            start, end = (
                (at[0] * parent.scale + r * along[0], at[1] * parent.scale + r * along[1])
                for r in (min(reach) - OUTSIDE, max(reach) + OUTSIDE)
            )
            mark = SectionMark(parent.name, start, end, (-normal[0], -normal[1]), view.cut.letter)
        else:
            continue
        found.setdefault(parent.name, []).append(mark)
    return found


def _parent(view: View, views: Sequence[View]) -> View | None:
    """The view that shows where a section or a detail is taken."""
    whole = [other for other in views if other.name != view.name and not other.clip and other.projection.name != "iso"]
    first = [other for other in whole if other.name == view.beside]
    for other in (*first, *whole):
        if view.clip and other.projection == view.projection:
            return other
        if view.cut and abs(dot(view.cut.normal, other.projection.towards_eye)) < 1e-6 and not other.cut:
            return other
    return None


def _in_line(dressed: Sequence[Dressed]) -> dict[str, Point2]:
    """Places of the first view, at (0, 0), and of all that stand in line with it, by name."""
    places: dict[str, Point2] = {dressed[0].view.name: (0.0, 0.0)}
    rooms = {dressed[0].view.name: dressed[0].room}
    waiting = list(dressed[1:])
    while True:
        one = next((one for one in waiting if one.view.beside in places), None)
        if one is None:
            return places
        waiting.remove(one)
        parent = next(other for other in dressed if other.view.name == one.view.beside)
        side = _side(one.view, parent.view)
        x, y = places[parent.view.name]
        step = 0.0
        while True:
            place = (x + side[0] * step, y + side[1] * step)
            room = grown(_at(one.room, place), APART / 2)
            if not any(overlap(room, grown(other, APART / 2)) for other in rooms.values()):
                break
            step += 1.0
        places[one.view.name] = place
        rooms[one.view.name] = _at(one.room, place)


def _side(view: View, parent: View) -> Point2:
    """Where third angle puts a view: on the side it is seen from; a parallel one to the right, or above."""
    eye = view.projection.towards_eye
    across, up = dot(eye, parent.projection.right), dot(eye, parent.projection.up)
    if abs(across) > 0.5:
        return (math.copysign(1.0, across), 0.0)
    if abs(up) > 0.5:
        return (0.0, math.copysign(1.0, up))
    x0, y0, x1, y1 = view_outline(parent)
    return (1.0, 0.0) if x1 - x0 <= 1.5 * (y1 - y0) else (0.0, -1.0)


def _on_sheet(rooms: Sequence[Box2], whole: Box2, alone: Sequence[Box2], area: SheetArea) -> tuple[list[Point2], bool]:
    """Shift of the views in line, and of each that stands alone; and whether all fit."""
    x0, y0, x1, y1 = area.space
    width, height = whole[2] - whole[0], whole[3] - whole[1]
    free = (x1 - x0 - width, y1 - y0 - height)
    best: list[Point2] | None = None
    for share in _shares():
        shift = (x0 - whole[0] + free[0] * share[0], y0 - whole[1] + free[1] * share[1])
        placed = [_at(room, shift) for room in rooms]
        if not all(_free(room, area, ()) for room in placed):
            continue
        best = best or [shift]
        others: list[Point2] = []
        for room in alone:
            place = _corner(room, area, placed)
            if place is None:
                break
            others.append(place)
            placed.append(_at(room, place))
        else:
            return [shift, *others], True
    shift = best[0] if best else (x0 - whole[0], y1 - whole[3])
    return [shift, *((x1 - room[2], y1 - room[3]) for room in alone)], False


def _shares() -> list[Point2]:
    """Places of the views in line within what room they leave, the middle first, then towards the upper left."""
    steps = [i / 10 for i in range(11)]
    return sorted(((a, b) for a in steps for b in steps), key=lambda s: (math.hypot(s[0] - 0.45, s[1] - 0.6), s))


def _corner(room: Box2, area: SheetArea, placed: Sequence[Box2]) -> Point2 | None:
    """A free place for a view that stands alone, next to the upper right corner."""
    x0, y0, x1, y1 = area.space
    columns = int((x1 - x0 - (room[2] - room[0])) // STEP) + 1
    rows = int((y1 - y0 - (room[3] - room[1])) // STEP) + 1
    places = [(x1 - room[2] - STEP * i, y1 - room[3] - STEP * j) for i in range(columns) for j in range(rows)]
    for place in sorted(places, key=lambda p: -(p[0] + p[1])):
        if _free(_at(room, place), area, placed):
            return place
    return None


def _free(room: Box2, area: SheetArea, placed: Sequence[Box2]) -> bool:
    x0, y0, x1, y1 = area.space
    inside = x0 - 1e-6 <= room[0] and y0 - 1e-6 <= room[1] and room[2] <= x1 + 1e-6 and room[3] <= y1 + 1e-6
    if not inside or any(overlap(room, grown(box, 3.0)) for box in area.taken):
        return False
    return not any(overlap(room, grown(box, APART)) for box in placed)


def _at(room: Box2, place: Point2) -> Box2:
    return (room[0] + place[0], room[1] + place[1], room[2] + place[0], room[3] + place[1])
