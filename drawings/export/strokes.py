"""What a sheet's DXF document shows on paper: outlines to be drawn along, one lot for each line weight, or to be
filled, as arrays; and texts.

The document is read as any program reads it: layers give weights and line types, viewports show model space, a
dimension is its block. A sheet holds seven kinds of entity only, so that is a short matter; ezdxf's own interpreter of
DXF, which a test holds against this one, takes five times as long. Formats differ in words only. So an outline is kept
as matplotlib has it, points with a code each, and all outlines of one weight lie in one pair of arrays, which are
written or painted as a whole.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import numpy as np
from ezdxf.document import Drawing

from drawings.export.texts import CUBIC, LINE, MOVE, PaperText
from drawings.export.windows import Window, drawn, windows
from drawings.views.view import Arc, Point2

FLAT = 0.02
"""How far the chords of a broken arc may leave it, mm on paper."""
BY_LAYER = -1


@dataclass(frozen=True)
class Outlines:
    """Outlines drawn with one pen.

    Attributes:
        points: (n, 2), mm on paper.
        codes: (n,) what each point is for.
        begins: index of the point with which each outline begins.
        weight: of the line, mm; none for what is filled.
    """

    points: np.ndarray
    codes: np.ndarray
    begins: tuple[int, ...]
    weight: float | None


@dataclass(frozen=True)
class Shown:
    """Everything on the paper.

    Attributes:
        lots: outlines in lots of one weight, thin lines first, and what is filled last.
        texts: in the order of the document.
    """

    lots: tuple[Outlines, ...]
    texts: tuple[PaperText, ...]


def shown(document: Drawing) -> Shown:
    """What a document has on the paper, that of model space as its viewports show it."""
    pens = _Pens(document)
    paper = document.paperspace()
    for entity in drawn(document, paper):
        pens.draw(entity, None)
    seen = list(windows(paper))
    for entity in drawn(document, document.modelspace()):
        at = _first_point(entity)
        for window in seen:
            if window.shows(at):
                pens.draw(entity, window)
    return Shown(tuple(pens.lots()), tuple(pens.texts))


class _Pen:
    """What is drawn with one pen."""

    def __init__(self) -> None:
        self.points: list[Point2] = []
        self.codes: list[int] = []
        self.begins: list[int] = []

    def line(self, points: Sequence[Point2]) -> None:
        self.add(points, [MOVE] + [LINE] * (len(points) - 1))

    def add(self, points: Sequence[Point2], codes: Sequence[int]) -> None:
        self.begins.append(len(self.points))
        self.points += points
        self.codes += codes

    def lot(self, weight: float | None) -> Outlines:
        return Outlines(np.array(self.points), np.array(self.codes), tuple(self.begins), weight)


class _Pens:
    """Draws the entities of one document, each with the pen of its weight."""

    def __init__(self, document: Drawing) -> None:
        self._pens: dict[float, _Pen] = {}
        self._fills = _Pen()
        self.texts: list[PaperText] = []
        self._patterns = {line_type.dxf.name.upper(): _pattern(line_type) for line_type in document.linetypes}
        self._layers = {layer.dxf.name: layer.dxf for layer in document.layers}

    def lots(self) -> list[Outlines]:
        found = [pen.lot(weight) for weight, pen in sorted(self._pens.items())]
        return [*found, self._fills.lot(None)] if self._fills.points else found

    def draw(self, entity: Any, window: Window | None) -> None:
        """One entity, in the paper space itself or as a viewport shows it."""
        to, along, scale = (window.to_paper, window.on_paper, window.scale) if window else (_as_it_is, list, 1.0)
        d, kind = entity.dxf, entity.dxftype()
        if kind == "VIEWPORT" or not self._layers[d.layer].plot:
            return
        match kind:
            case "LINE":
                self._stroke(entity, [to((d.start.x, d.start.y)), to((d.end.x, d.end.y))], scale)
            case "LWPOLYLINE":
                self._stroke(entity, along([(x, y) for x, y, *_ in entity.lwpoints]), scale)
            case "CIRCLE" | "ARC":
                angles = (d.start_angle, d.end_angle) if kind == "ARC" else (0.0, 360.0)
                self._arc(entity, Arc(to((d.center.x, d.center.y)), d.radius * scale, *angles), scale)
            case "SOLID":
                # Its corners run crosswise; of a triangle the last one comes twice.
                corners = [to((p.x, p.y)) for p in (d.vtx0, d.vtx1, d.vtx3, d.vtx2)]
                self._fills.line([*corners, corners[0]])
            case "HATCH":
                for path in entity.paths:
                    corners = [to((x, y)) for x, y, *_ in path.vertices]
                    self._fills.line([*corners, corners[0]])
            case "TEXT":
                self._text(entity, to, scale)
            case _:
                raise ValueError(f"a sheet has no {kind}")

    def _stroke(self, entity: Any, points: Sequence[Point2], scale: float) -> None:
        pen, pattern = self._pen(entity), self._pattern(entity, scale)
        if pattern:
            for piece in dashed(points, pattern):
                pen.line(piece)
        else:
            pen.line(points)

    def _arc(self, entity: Any, arc: Arc, scale: float) -> None:
        if self._pattern(entity, scale):
            self._stroke(entity, _chords(arc), scale)
        else:
            self._pen(entity).add(*_curves(arc))

    def _pen(self, entity: Any) -> _Pen:
        d = entity.dxf
        weight = d.lineweight if d.hasattr("lineweight") else BY_LAYER
        weight = (weight if weight >= 0 else self._layers[d.layer].lineweight) / 100.0
        return self._pens.setdefault(weight, _Pen())

    def _pattern(self, entity: Any, scale: float) -> list[float]:
        """Dashes and gaps in turn, mm on paper; none for an unbroken line."""
        d = entity.dxf
        name = d.linetype if d.hasattr("linetype") else self._layers[d.layer].linetype
        size = scale * (d.ltscale if d.hasattr("ltscale") else 1.0)
        return [size * length for length in self._patterns[name.upper()]]

    def _text(self, entity: Any, to: Callable[[Point2], Point2], scale: float) -> None:
        d = entity.dxf
        align, first, second = entity.get_placement()
        at = first if align.name == "LEFT" else (second or first)
        words = PaperText(entity.plain_text(), to((at.x, at.y)), d.height * scale, d.rotation, d.width)
        self.texts.append(words.moved_back({"LEFT": 0.0, "CENTER": 0.5, "RIGHT": 1.0}[align.name]))


def _as_it_is(point: Point2) -> Point2:
    return point


def _first_point(entity: Any) -> Point2:
    d = entity.dxf
    match entity.dxftype():
        case "LINE":
            return (d.start.x, d.start.y)
        case "LWPOLYLINE":
            return entity.lwpoints[0][:2]
        case "CIRCLE" | "ARC":
            return (d.center.x, d.center.y)
        case "SOLID":
            return (d.vtx0.x, d.vtx0.y)
        case "HATCH":
            return entity.paths[0].vertices[0][:2]
        case _:
            return (d.insert.x, d.insert.y)


def _pattern(line_type: Any) -> list[float]:
    """Dashes and gaps of a line type in turn, none for an unbroken one."""
    lengths = [abs(tag.value) for tag in line_type.pattern_tags.tags if tag.code == 49]
    return lengths if len(lengths) > 1 else []


def dashed(points: Sequence[Point2], pattern: Sequence[float]) -> Iterator[list[Point2]]:
    """The dashes of a line through points, the first at its beginning.

    Args:
        pattern: lengths of dashes and gaps in turn.
    """
    number, left = 0, pattern[0]
    piece = [points[0]]
    for (x0, y0), (x1, y1) in pairwise(points):
        length, done = math.hypot(x1 - x0, y1 - y0), 0.0
        while length - done > left:
            done += left
            at = (x0 + (x1 - x0) * done / length, y0 + (y1 - y0) * done / length)
            if number % 2 == 0:
                yield [*piece, at]
            piece = [at]
            number = (number + 1) % len(pattern)
            left = pattern[number]
        left -= length - done
        piece.append((x1, y1))
    if number % 2 == 0 and len(piece) > 1:
        yield piece


def _sweep(arc: Arc) -> float:
    return math.radians((arc.end_angle - arc.start_angle) % 360.0 or 360.0)


def _on(arc: Arc, turn: float, share: float = 1.0) -> Point2:
    radius = arc.radius * share
    return (arc.centre[0] + radius * math.cos(turn), arc.centre[1] + radius * math.sin(turn))


def _chords(arc: Arc) -> list[Point2]:
    """Points along an arc whose chords leave it by no more than `FLAT`."""
    step = 2 * math.acos(max(1 - FLAT / max(arc.radius, FLAT), 0.0))
    sweep, start = _sweep(arc), math.radians(arc.start_angle)
    count = max(2, math.ceil(sweep / step))
    return [_on(arc, start + sweep * i / count) for i in range(count + 1)]


def _curves(arc: Arc) -> tuple[list[Point2], list[int]]:
    """An arc as cubic curves of an eighth of a circle at most, 4e-6 of the radius off."""
    sweep, start = _sweep(arc), math.radians(arc.start_angle)
    count = max(1, math.ceil(sweep / (math.pi / 4) - 1e-9))
    step = sweep / count
    # The controls lie on the tangents at both ends.
    reach = 4 / 3 * math.tan(step / 4)
    share, lean = math.hypot(1.0, reach), math.atan(reach)
    points = [_on(arc, start)]
    for i in range(count):
        begin, end = start + step * i, start + step * (i + 1)
        points += [_on(arc, begin + lean, share), _on(arc, end - lean, share), _on(arc, end)]
    return points, [MOVE] + [CUBIC] * (3 * count)
