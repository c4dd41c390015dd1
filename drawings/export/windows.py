"""The viewports of a sheet's DXF document, and what each of them shows of model space."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from typing import Any

from drawings.views.view import Box2, Point2


@dataclass(frozen=True)
class Window:
    """A viewport: paper = middle + (model - seen) * scale, for what lies within its box in model space."""

    scale: float
    middle: Point2
    seen: Point2
    box: Box2

    def shows(self, point: Point2) -> bool:
        return self.box[0] <= point[0] <= self.box[2] and self.box[1] <= point[1] <= self.box[3]

    def shows_all(self, points: Sequence[Point2]) -> bool:
        """Whether each of some points lies within the box."""
        xs, ys = zip(*points)
        low_x, low_y, high_x, high_y = self.box
        return low_x <= min(xs) and max(xs) <= high_x and low_y <= min(ys) and max(ys) <= high_y

    def on_paper(self, points: Iterable[Point2]) -> list[Point2]:
        """`to_paper` of many points."""
        (x, y), (u, v), scale = self.middle, self.seen, self.scale
        return [(x + (a - u) * scale, y + (b - v) * scale) for a, b in points]

    def to_paper(self, point: Point2) -> Point2:
        return (
            self.middle[0] + (point[0] - self.seen[0]) * self.scale,
            self.middle[1] + (point[1] - self.seen[1]) * self.scale,
        )


def windows(paper: Any) -> Iterator[Window]:
    """The viewports of a paper space."""
    for viewport in of_type(paper, "VIEWPORT"):
        d = viewport.dxf
        if d.id == 1:  # the paper space's own
            continue
        scale = d.height / d.view_height
        seen = (d.view_center_point.x, d.view_center_point.y)
        half = (d.width / scale / 2, d.height / scale / 2)
        box = (seen[0] - half[0], seen[1] - half[1], seen[0] + half[0], seen[1] + half[1])
        yield Window(scale, (d.center.x, d.center.y), seen, box)


def of_type(layout: Iterable[Any], kind: str) -> Iterator[Any]:
    """A layout's entities of one kind, in their order."""
    return (entity for entity in layout if entity.dxftype() == kind)


def drawn(document: Any, layout: Iterable[Any]) -> Iterator[Any]:
    """What a layout draws: its entities, those of the block in place of a dimension."""
    for entity in layout:
        if entity.dxftype() == "DIMENSION":
            yield from document.blocks.get(entity.dxf.geometry)
        else:
            yield entity
