"""Places of the annotations round one view.

They are placed one after another, each at the cheapest of its likely places that leaves every text free; short
dimensions first, so that they stand next to the part and longer ones outside. Nothing here is random or depends on the
order of a set: the same view gives the same places.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, replace

from drawings.annotations.annotation import Annotation, Callout, LinearDimension, SectionMark
from drawings.annotations.font import LARGE_HEIGHT
from drawings.annotations.symbols import symbol_text_width
from drawings.dimensions.specification import Asked, AskedAngle, AskedCallout, AskedDistance, AskedFrame, AskedRound
from drawings.dimensions.text import DIAMETER
from drawings.placement.candidates import Candidate, of_angle, of_axis, of_callout, of_distance, of_frame, of_round
from drawings.placement.field import Field, Line, Lines, around, grown, reaches
from drawings.placement.occupied import about, curve_lines, keeps_off_itself, occupied, tip_of, view_outline
from drawings.views.view import Box2, Point2, View

CLEAR = 1.2
"""Room round a text, mm."""
LANE = 6.0
"""Least distance of parallel dimension lines, mm."""
HIT, CROSSING, OVER_PART = 80.0, 3.0, 0.3
"""Cost of a text that touches something, of a line that crosses an annotation's, of one that crosses the part's, mm."""
ON_PART = 12.0
"""Cost of a dimension line that runs along a line of the part, mm."""
IN_THE_WAY = 1.5
"""Cost of a text where an extension line may have to pass later, mm."""
RUNS = 6
"""How often a view is dressed anew when something found no free place."""
CROWDED = 6.0
"""Cost of an arrow whose tip is at another one's, mm."""
ASTRAY = 30.0
"""Cost of a leader that ends where no line of the part is drawn, mm."""


@dataclass(frozen=True)
class Dressed:
    """A view at the origin of the paper, with its annotations, and the room both take.

    Args:
        room: box of all ink.
        hits: how many places were left where something touches a text.
        asked, marks: what it was dressed with.
    """

    view: View
    annotations: tuple[Annotation, ...]
    room: Box2
    hits: int
    asked: tuple[Asked, ...]
    marks: tuple[Annotation, ...]


def dress(view: View, asked: Sequence[Asked], marks: Sequence[Annotation] = ()) -> Dressed:
    """Finds places for what a view is asked to show.

    Args:
        view: with its curves and scale; its place is not looked at.
        asked: of this view.
        marks: annotations with a place already (cutting lines, circles of details), view at the origin.
    """
    view = replace(view, place=(0.0, 0.0))
    order = sorted(asked, key=_order)
    best: tuple[_Placer, Point2 | None] | None = None
    for _ in range(RUNS):
        placer = _Placer(view)
        label_at = placer.dress(order, marks)
        if best is None or placer.hits < best[0].hits:
            best = (placer, label_at)
        if not placer.troubled:
            break
        # What found no free place comes first the next time.
        order = placer.troubled + [one for one in order if one not in placer.troubled]
    assert best is not None
    placer, label_at = best
    view = replace(view, label_at=label_at)
    return Dressed(view, tuple(placer.kept), placer.room(), placer.hits, tuple(asked), tuple(marks))


def _order(asked: Asked) -> tuple[int, float]:
    """Distances first, short before long; then what needs a given place on a face; then what is free to wander."""
    match asked:
        case AskedDistance():
            turn = math.radians(asked.angle)
            along = [p[0] * math.cos(turn) + p[1] * math.sin(turn) for p in (asked.first, asked.second)]
            return (1, round(abs(along[1] - along[0]), 6))
        case AskedAngle():
            return (2, 0.0)
        case AskedFrame():
            return (3, 0.0 if asked.letter else 1.0)
        case AskedRound():
            return (4, asked.radius)
        case AskedCallout():
            return (5, round(-asked.at[1], 6))


class _Placer:
    """Places annotations round one view."""

    def __init__(self, view: View) -> None:
        self.view = view
        self.field = Field()
        self.kept: list[Annotation] = []
        self.hits = 0
        drawn = [line for curves in view.curves.values() for curve in curves for line in curve_lines(curve, view)]
        self.field.part.add(drawn)
        self.outline = view_outline(view)
        x0, y0, x1, y1 = zip(*drawn)
        self.inked = [(min(*x0, *x1), min(*y0, *y1), max(*x0, *x1), max(*y0, *y1))]
        self.edges = Lines(1024)
        self.edges.add(
            [
                line
                for layer, curves in view.curves.items()
                if layer in ("VISIBLE", "HIDDEN")
                for curve in curves
                for line in curve_lines(curve, view)
            ]
        )
        self.tips: list[Point2] = []
        self.corridors: list[Line] = []
        self.troubled: list[Asked] = []

    def dress(self, order: Sequence[Asked], marks: Sequence[Annotation]) -> Point2 | None:
        """Places everything, and the view's name; where that stands."""
        for mark in marks:
            if not isinstance(mark, SectionMark):
                self.keep(mark)
        cuts = [mark for mark in marks if isinstance(mark, SectionMark)]
        waiting = list(order)
        while waiting:
            one = waiting.pop(0)
            if not any(isinstance(other, AskedDistance) for other in (one, *waiting)):
                self.mark(cuts)
            self.corridors = [line for other in waiting for line in self._corridors(other)]
            self.place(one)
        self.mark(cuts)
        return self.label()

    def _corridors(self, asked: Asked) -> list[Line]:
        """Where extension lines of a distance may have to run later."""
        if not isinstance(asked, AskedDistance) or asked.angle not in (0.0, 90.0):
            return []
        reach, lines = 60.0, []
        for x, y in map(self.view.to_paper, (asked.first, asked.second)):
            if asked.angle == 0.0:
                ends = (self.outline[1] - reach, self.outline[3] + reach)
                lines += [(x, ends[0], x, y), (x, y, x, ends[1])]
            else:
                ends = (self.outline[0] - reach, self.outline[2] + reach)
                lines += [(ends[0], y, x, y), (x, y, ends[1], y)]
        return lines

    def room(self) -> Box2:
        return around(self.inked)

    def label(self) -> Point2 | None:
        """A free place for the view's name, below the part and what is close below it."""
        if not self.view.label:
            return None
        half, middle = symbol_text_width(self.view.label, LARGE_HEIGHT) / 2, (self.outline[0] + self.outline[2]) / 2
        step = 0.0
        while True:
            low = self.outline[1] - 4.0 - LARGE_HEIGHT - step
            box = (middle - half, low, middle + half, low + LARGE_HEIGHT)
            if not self.field.text_hits(box, 1.5):
                break
            step += 1.0
        self.field.boxes.append(box)
        self.inked.append(box)
        return (middle, low)

    def mark(self, cuts: list[SectionMark]) -> None:
        """Ends of cutting lines outside what dimensions stand there; each once."""
        while cuts:
            cut = cuts.pop(0)
            size = math.dist(cut.start, cut.end)
            u = ((cut.end[0] - cut.start[0]) / size, (cut.end[1] - cut.start[1]) / size)
            tried = [
                (
                    3.0 * (i + j),
                    replace(
                        cut,
                        start=(cut.start[0] - 3.0 * i * u[0], cut.start[1] - 3.0 * i * u[1]),
                        end=(cut.end[0] + 3.0 * j * u[0], cut.end[1] + 3.0 * j * u[1]),
                    ),
                )
                for i in range(16)
                for j in range(16)
            ]
            self._keep_best(tried)

    def place(self, asked: Asked) -> None:
        """Keeps the best of the likely places, or else of all."""
        if self._keep_best(self._candidates(asked, harder=False), only_free=True):
            return
        before = self.hits
        self._keep_best(self._candidates(asked, harder=True))
        if self.hits > before:
            self.troubled.append(asked)

    def _keep_best(self, candidates: Iterable[Candidate], *, only_free: bool = False) -> bool:
        """Keeps the cheapest; with `only_free`, nothing where even that touches a text. Whether it kept one."""
        best, least, touched = None, math.inf, 0
        for cost, annotation in sorted(candidates, key=lambda item: item[0]):
            if cost >= least:
                break
            extra, hits = self._extra(annotation, least - cost)
            if cost + extra < least:
                best, least, touched = annotation, cost + extra, hits
        if best is None or (only_free and touched):
            return False
        self.hits += touched
        self.keep(best)
        return True

    def _candidates(self, asked: Asked, *, harder: bool) -> Iterator[Candidate]:
        match asked:
            case AskedDistance():
                return of_distance(asked, self.view, self.outline, self.field.part, harder=harder)
            case AskedRound():
                return of_round(asked, self.view, self.outline, harder=harder)
            case AskedAngle():
                return of_angle(asked, self.view, harder=harder)
            case AskedFrame():
                across = self._across(asked)
                if across and not harder:
                    return of_axis(asked, self.view, across)
                return of_frame(asked, self.view, harder=harder)
            case AskedCallout():
                room = self.room()
                places = (asked.at, *asked.choices) if asked.choices else ()
                drawn = [p for p in places if self.edges.touching(about(self.view.to_paper(p)))]
                if drawn:
                    asked = replace(asked, at=drawn[0], choices=tuple(drawn[1:]))
                columns = (room[0] - 3.0, room[2] + 3.0)
                return of_callout(asked, self.view, self.outline, columns, harder=harder)

    def _across(self, asked: AskedFrame) -> LinearDimension | None:
        """The dimension of the diameter whose axis a datum is, where it stands in this view."""
        lines = (one for one in self.kept if isinstance(one, LinearDimension) and one.text.startswith(DIAMETER))
        return next((one for one in lines if abs(one.measured - asked.diameter) < 1e-6), None)

    def _extra(self, annotation: Annotation, most: float) -> tuple[float, int]:
        """What a place costs for what is there already, and how many texts are touched; stops beyond `most`."""
        boxes, lines, lanes = occupied(annotation, self.view)
        hits = sum(self.field.in_lane(lane, LANE) for lane in lanes)
        if not keeps_off_itself(annotation):
            hits += sum(reaches(line, box) for box in [grown(box, 0.2) for box in boxes] for line in lines)
        hits += self.field.over_texts(lines, 0.4)
        if HIT * hits >= most:
            return HIT * hits, hits
        hits += sum(self.field.text_hits(box, CLEAR) for box in boxes)
        cost = HIT * hits
        if cost >= most:
            return cost, hits
        cost += CROSSING * self.field.crossings(lines)
        cost += IN_THE_WAY * sum(reaches(line, box) for box in boxes for line in self.corridors)
        if cost >= most:
            return cost, hits
        tip = tip_of(annotation, self.view)
        if tip and not self.edges.touching(about(tip)):
            cost += ASTRAY
        end = tip or (self.view.to_paper(annotation.at) if isinstance(annotation, Callout) else None)
        if end:
            cost += CROWDED * sum(math.dist(end, other) < 3.0 for other in self.tips)
        cost += OVER_PART * sum(self.field.part.crossing(line) for line in lines)
        cost += ON_PART * sum(self.field.part.beside(lane, 1.5) for lane in lanes)
        return cost, hits

    def keep(self, annotation: Annotation) -> None:
        """Takes the room of an annotation."""
        boxes, lines, lanes = occupied(annotation, self.view)
        tip = tip_of(annotation, self.view)
        tip = tip or (self.view.to_paper(annotation.at) if isinstance(annotation, Callout) else None)
        self.tips += [tip] if tip else []
        self.field.boxes += boxes
        self.field.drawn.add(lines)
        self.field.lanes += lanes
        self.kept.append(annotation)
        self.inked += boxes
        self.inked += [(min(a, c), min(b, d), max(a, c), max(b, d)) for a, b, c, d in lines]
