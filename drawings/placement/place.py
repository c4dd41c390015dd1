"""Placement of annotations around one view: greedy label placement with restarts.

Each annotation has a finite set of candidate positions with a cost (`drawings.placement.candidates`). The annotations
are placed one after another, each at the candidate of least total cost: the cost of the position itself and that of
its conflicts with what is already placed. Short dimensions come before long ones, so that they are nearer to the part.
Annotations without a position free of conflicts come first in the next run; the best of at most `RUNS` runs is kept.
The result is deterministic. Survey: Christensen, Marks, Shieber, ACM Transactions on Graphics 14 (1995) 203.
"""

import math
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, replace

from drawings.annotations.annotation import (
    THICK_END,
    AngularDimension,
    Annotation,
    Callout,
    DetailMark,
    LinearDimension,
    ReferenceArrow,
    SectionMark,
)
from drawings.annotations.primitives import LARGE_HEIGHT
from drawings.annotations.symbols import symbol_text_width
from drawings.dimensions.edges import CLEAR_OF_END
from drawings.dimensions.specification import (
    AngleSpec,
    CalloutSpec,
    DimensionSpec,
    DistanceSpec,
    FrameSpec,
    RoundSpec,
    TagSpec,
    TargetSpec,
)
from drawings.dimensions.text import DIAMETER
from drawings.placement.candidates import (
    Candidate,
    angle_candidates,
    axis_candidates,
    between,
    callout_candidates,
    detail_mark_candidates,
    distance_candidates,
    frame_candidates,
    reference_arrow_candidates,
    round_candidates,
    section_mark_candidates,
    tag_candidates,
    target_candidates,
)
from drawings.placement.lint_rules import LEADER_TIP, LINE_CLEARANCE, Footprint, Occupancy, footprint_of, view_outline
from drawings.views.segment_index import Line, SegmentIndex, enlarged, line_meets_box
from drawings.views.view import Box2, Point2, View, direction, distance_along, offset

CONFLICT = 80.0
"""Cost of each conflict: a text that touches a line or a text, or dimension lines too near to each other, mm."""
CROSSING = 3.0
"""Cost of each crossing of a line with a line of another annotation, mm."""
PART_CROSSING = 0.3
"""Cost of each crossing of a line with a line of the part, mm."""
OUTLINE_CROSSING = 1.5
"""Further cost of each crossing of a leader with an edge of the part, mm."""
ON_PART_LINE, ON_PART_DISTANCE = 12.0, 1.5
"""Cost of each line of the part close to a dimension line, and the distance below which it counts, mm."""
KEEP_OUT = 2.5
"""Cost of each keep-out line that a text covers, mm."""
SHARED_TIP, TIP_DISTANCE = 6.0, 3.0
"""Cost of each leader tip near the tip of another leader, and the distance below which it counts, mm."""
MOVED_TIP = 4.0
"""Step by which the end of a leader is moved along a straight edge, mm."""
DETACHED = 30.0
"""Cost of a leader that ends at a datum triangle, or of a callout where no edge of the part is drawn, mm."""
DATUM_DISTANCE = 4.5
"""Distance from the foot of a datum triangle below which a leader ends at the triangle, mm."""
LEADER_WAY, WAY_OUT = 3.0, 30.0
"""Cost of each probable leader that a dimension line crosses, and the length of such a leader, mm."""
KEEP_OUT_LENGTH = 60.0
"""Length of a keep-out line outside the part, mm."""
RUNS = 6
"""Largest number of runs."""


@dataclass(frozen=True)
class AnnotatedView:
    """A view at the origin of the paper with its annotations in place."""

    view: View
    annotations: tuple[Annotation, ...]
    box: Box2  # bounding box of view and annotations
    conflicts: int  # number of conflicts left; 0 on a good sheet
    # specs, marks: the arguments of `place_annotations`
    specs: tuple[DimensionSpec, ...]
    marks: tuple[Annotation, ...]


def place_annotations(view: View, specs: Sequence[DimensionSpec], marks: Sequence[Annotation] = ()) -> AnnotatedView:
    """Place the annotations of one view."""
    view = replace(view, place=(0.0, 0.0))
    order = sorted(specs, key=_priority)
    best, crowded = None, False
    tried: list[tuple[list[DimensionSpec], bool]] = []
    footprints: dict[Annotation, Footprint] = {}
    while len(tried) < RUNS and (order, crowded) not in tried:
        tried.append((order, crowded))
        run = _Run(view, footprints)
        run.place_all(order, marks, cutting_lines_first=crowded)
        if best is None or run.conflicts < best.conflicts:
            best = run
        if not run.unplaced and (crowded or not run.crowded):
            break
        crowded = crowded or run.crowded
        # A symbol in line with a diameter comes after it.
        axes = {spec.diameter for spec in run.unplaced if isinstance(spec, FrameSpec)} - {0.0}
        first = [spec for spec in order if isinstance(spec, DistanceSpec) and spec.measured in axes]
        first += [spec for spec in run.unplaced if spec not in first]
        order = first + [spec for spec in order if spec not in first]
    assert best is not None
    view = replace(view, label_at=best.label_at)
    return AnnotatedView(view, tuple(best.placed), best.occupancy.box, best.conflicts, tuple(specs), tuple(marks))


def _priority(spec: DimensionSpec) -> tuple[int, float]:
    """Order of placement: distances, short before long; annotations with few candidate positions; callouts last."""
    match spec:
        case DistanceSpec():
            return (1, round(abs(distance_along(spec.second, spec.first, direction(spec.angle))), 6))
        case AngleSpec():
            return (2, 0.0)
        case FrameSpec():
            return (3, 0.0 if spec.letter else 1.0)
        case RoundSpec():
            return (4, spec.radius)
        case TagSpec():
            return (5, 0.0)
        case TargetSpec():
            return (6, 0.0)
        case CalloutSpec():
            return (7, round(-spec.at[1], 6))


class _Run:
    """One run of the greedy placement: annotations placed, and specifications without a position free of conflicts."""

    def __init__(self, view: View, footprints: dict[Annotation, Footprint]) -> None:
        self.view = view
        self._footprints = footprints  # of the candidates of all runs
        self.outline = view_outline(view)
        self.occupancy = Occupancy(view)
        self.placed: list[Annotation] = []
        self.unplaced: list[DimensionSpec] = []
        self.crowded = False  # whether cutting lines have no position free of conflicts
        self.conflicts = 0
        self.label_at: Point2 | None = None
        self._keep_out, self._leader_ways = SegmentIndex(), SegmentIndex()

    def place_all(
        self, order: Sequence[DimensionSpec], marks: Sequence[Annotation], *, cutting_lines_first: bool = False
    ) -> None:
        """Place annotations in an order, cutting lines outside the distances or first, and last the label of the
        view."""
        bends = [at for mark in marks if isinstance(mark, SectionMark) for at in mark.corners]
        self._keep_out.add([(x - THICK_END, y, x + THICK_END, y) for x, y in bends])
        self._keep_out.add([(x, y - THICK_END, x, y + THICK_END) for x, y in bends])
        for mark in marks:
            if isinstance(mark, DetailMark):
                self._add_best(detail_mark_candidates(mark, self.view, self.outline))
        cutting_lines = [mark for mark in marks if isinstance(mark, SectionMark | ReferenceArrow)]
        distances = [] if cutting_lines_first else [n for n, one in enumerate(order) if isinstance(one, DistanceSpec)]
        last_distance = max(distances, default=-1)
        for number, spec in enumerate(order):
            if number == last_distance + 1:
                self._place_cutting_lines(cutting_lines)
            others = order[number + 1 :]
            self._keep_out = SegmentIndex([line for other in others for line in self._extension_lines(other)])
            self._leader_ways = SegmentIndex([line for other in others for line in self._ways_out(other)])
            self._place(spec)
        if last_distance == len(order) - 1:
            self._place_cutting_lines(cutting_lines)
        self._place_label()

    def _extension_lines(self, spec: DimensionSpec) -> list[Line]:
        """Keep-out lines of a distance that is not placed yet: possible paths of its extension lines."""
        if not isinstance(spec, DistanceSpec) or spec.angle not in (0.0, 90.0):
            return []
        x0, y0, x1, y1 = self.outline
        lines: list[Line] = []
        for x, y in map(self.view.to_paper, (spec.first, spec.second)):
            if spec.angle == 0.0:
                lines += [(x, y0 - KEEP_OUT_LENGTH, x, y), (x, y, x, y1 + KEEP_OUT_LENGTH)]
            else:
                lines += [(x0 - KEEP_OUT_LENGTH, y, x, y), (x, y, x1 + KEEP_OUT_LENGTH, y)]
        return lines

    def _ways_out(self, spec: DimensionSpec) -> list[Line]:
        """Probable path out of its face of the leader of an annotation that is not placed yet."""
        if isinstance(spec, CalloutSpec) and spec.outward is not None:
            start, outward = self.view.to_paper(spec.at), spec.outward
        elif isinstance(spec, FrameSpec) and not spec.diameter:
            first, second = self.view.to_paper(spec.first), self.view.to_paper(spec.second)
            start, outward = between(first, second, spec.at), spec.outward
        else:
            return []
        return [(*start, *offset(start, direction(outward), WAY_OUT))]

    def _place_label(self) -> None:
        """Place the label of the view at the highest free position below the part."""
        if not self.view.label:
            return
        half = symbol_text_width(self.view.label, LARGE_HEIGHT) / 2
        middle = (self.outline[0] + self.outline[2]) / 2
        low = self.outline[1] - 4.0 - LARGE_HEIGHT
        while self.occupancy.text_conflicts(box := (middle - half, low, middle + half, low + LARGE_HEIGHT), 1.5):
            low -= 1.0
        self.occupancy.add_text(box)
        self.label_at = (middle, low)

    def _place_cutting_lines(self, marks: Sequence[SectionMark | ReferenceArrow]) -> None:
        before = self.conflicts
        for mark in marks:
            reach = max(abs(a - b) for a, b in zip(self.occupancy.box, self.outline, strict=True))
            section = isinstance(mark, SectionMark)
            self._add_best(section_mark_candidates(mark, reach) if section else reference_arrow_candidates(mark))
        self.crowded = self.conflicts > before

    def _place(self, spec: DimensionSpec) -> None:
        """Place an annotation at the best of its usual candidates, or if all have conflicts, of its extended ones."""
        if self._add_best(self._candidates(spec, extended=False), only_free=True):
            return
        before = self.conflicts
        self._add_best(self._candidates(spec, extended=True))
        if self.conflicts > before:
            self.unplaced.append(spec)

    def _add_best(self, candidates: Iterable[Candidate], *, only_free: bool = False) -> bool:
        """Add the candidate of least total cost, with `only_free` only if it has no conflict; whether one was added."""
        best, least, conflicts = None, CONFLICT if only_free else math.inf, 0
        for own_cost, annotation in sorted(candidates, key=lambda candidate: candidate[0]):
            if own_cost >= least:
                break
            extra, found = self._conflict_cost(annotation, least - own_cost)
            if own_cost + extra < least:
                best, least, conflicts = annotation, own_cost + extra, found
        if best is None:
            return False
        self.conflicts += conflicts
        self.occupancy.add(best, self.view)
        self.placed.append(best)
        return True

    def _candidates(self, spec: DimensionSpec, *, extended: bool) -> Iterator[Candidate]:
        match spec:
            case DistanceSpec():
                return distance_candidates(spec, self.view, self.outline, self.occupancy.part_lines, extended=extended)
            case RoundSpec():
                return round_candidates(spec, self.view, self.outline, extended=extended)
            case AngleSpec():
                return angle_candidates(spec, self.view, extended=extended)
            case FrameSpec():
                diameter = self._diameter_dimension(spec)
                if diameter:
                    return axis_candidates(spec, self.view, diameter)
                return frame_candidates(spec, self.view, extended=extended)
            case TagSpec():
                return tag_candidates(spec, self.view, extended=extended)
            case TargetSpec():
                return target_candidates(spec, self.view, self.outline)
            case CalloutSpec():
                box = self.occupancy.box
                ends = (spec.at, *spec.choices) if spec.choices else ()
                drawn = [end for end in ends if self.occupancy.is_on_outline(self.view.to_paper(end))]
                if drawn:
                    spec = replace(spec, at=drawn[0], choices=tuple(drawn[1:]))
                elif not spec.radius:
                    spec = replace(spec, choices=self._along_edge(spec.at))
                columns = (box[0] - 3.0, box[2] + 3.0)
                return callout_candidates(spec, self.view, self.outline, columns, extended=extended)

    def _along_edge(self, at: Point2) -> tuple[Point2, ...]:
        """Other points of the straight edge through a point, clear of the ends of the edge, view coordinates."""
        x, y = self.view.to_paper(at)
        box = enlarged((x, y, x, y), LEADER_TIP)
        for line in self.occupancy.outline_lines.near(box):
            length = math.dist(line[:2], line[2:])
            if length > MOVED_TIP and line_meets_box(line, box):
                u = ((line[2] - line[0]) / length, (line[3] - line[1]) / length)
                low, high = self.occupancy.outline_lines.collinear_run((x, y), u, LEADER_TIP)
                steps = (MOVED_TIP, -MOVED_TIP, 2 * MOVED_TIP, -2 * MOVED_TIP)
                clear = [s for s in steps if low + CLEAR_OF_END <= s <= high - CLEAR_OF_END]
                return tuple((at[0] + s * u[0] / self.view.scale, at[1] + s * u[1] / self.view.scale) for s in clear)
        return ()

    def _diameter_dimension(self, spec: FrameSpec) -> LinearDimension | None:
        """The placed dimension of the diameter, or of the distance of the two faces, whose centre is the datum."""
        for one in self.placed:
            if isinstance(one, LinearDimension) and abs(one.measured - spec.diameter) < 1e-6:
                across = abs(math.cos(math.radians(one.angle - spec.outward)))
                if one.text.startswith(DIAMETER) or across > 1 - 1e-6:
                    return one
        return None

    def _conflict_cost(self, annotation: Annotation, limit: float) -> tuple[float, int]:
        """Cost of a position due to the elements drawn so far, mm, and its conflicts; incomplete above a limit."""
        occupancy = self.occupancy
        # The texts of a callout, of which there are most candidates, are known without its lines.
        boxes = annotation.boxes if isinstance(annotation, Callout) else []
        conflicts = sum(map(occupancy.text_conflicts, boxes))
        if CONFLICT * conflicts >= limit:
            return CONFLICT * conflicts, conflicts
        if annotation not in self._footprints:
            self._footprints[annotation] = footprint_of(annotation, self.view)
        footprint = self._footprints[annotation]
        conflicts += occupancy.line_conflicts(footprint, limit / CONFLICT)
        if CONFLICT * conflicts < limit and not boxes:
            conflicts += sum(map(occupancy.text_conflicts, footprint.texts))
        if CONFLICT * conflicts < limit:
            conflicts += sum(number for _, number in occupancy.leader_conflicts(annotation, self.view, footprint))
        tip = annotation.leader_tip(self.view)
        faults = 0
        if CONFLICT * conflicts < limit and not (tip and occupancy.continues_dimension_line(tip, footprint)):
            faults = sum(1 for _ in occupancy.end_faults(annotation, self.view))
        conflicts += 0 if boxes else faults
        cost = CONFLICT * conflicts + (DETACHED * faults if boxes else 0.0)
        if cost >= limit:
            return cost, conflicts
        cost += KEEP_OUT * self._keep_out.count_in(*(enlarged(box, LINE_CLEARANCE) for box in footprint.texts))
        cost += CROSSING * occupancy.annotation_lines.count_crossing(*footprint.lines)
        if tip:
            cost += SHARED_TIP * sum(math.dist(tip, other) < TIP_DISTANCE for other in occupancy.leader_tips)
            cost += DETACHED * sum(math.dist(tip, other) < DATUM_DISTANCE for other in occupancy.datum_feet)
        cost += PART_CROSSING * occupancy.part_lines.count_crossing(*footprint.lines)
        cost += OUTLINE_CROSSING * occupancy.outline_lines.count_crossing(*footprint.leaders)
        if isinstance(annotation, LinearDimension):
            cost += LEADER_WAY * self._leader_ways.count_crossing(*footprint.dimension_lines)
        own = footprint.lines if isinstance(annotation, AngularDimension) else footprint.dimension_lines
        parallel_lines = occupancy.part_lines.count_beside(ON_PART_DISTANCE, *own)[0]
        return cost + ON_PART_LINE * parallel_lines, conflicts
