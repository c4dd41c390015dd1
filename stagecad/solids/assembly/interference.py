"""Interference check: contacts, fits and clashes of parts at the ends and middle of travel and height adjustment.

A machine states the pairs of parts that touch, fit or overlap by design; common volume of any other pair is a clash.
Threads are cosmetic (a screw has its major diameter, a tapped hole its drill's), so a thread engagement has a common
volume, which must not exceed the ring between the two diameters. The tip overlaps the stage slightly, since this sets
its preload.

Common volume and least distance of two solids, measured in the coordinates of the first.

The result depends on the two solids and on the position of the second relative to the first alone, so that it can be
kept while the pair moves together.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from itertools import combinations
from pathlib import Path
from typing import Any

from stagecad.solids.artefacts.part import BuiltPart, in_processes, kernel_errors
from stagecad.solids.artefacts.store import ArtefactStore
from stagecad.solids.assembly.built_machine import contents_of, shapes_of
from stagecad.solids.modelling.frame import Frame, dot, near, subtract, transformed_box
from stagecad.solids.modelling.kernel import box_of, compound_of, cq, moved, occ, parts_of
from stagecad.solids.modelling.part import (
    ASSEMBLY,
    CLASH,
    CONTACT,
    DRIVE,
    GAP,
    OPEN,
    OVERLAP,
    THREAD,
    Instance,
    Position,
    construction,
    part_source,
)

DIGITS = 9
"""Digits after the point to which a relative position is rounded, mm; its directions have three more."""


def relative_frame(one: Frame, two: Frame) -> Frame:
    """Frame from the coordinates of the second part to those of the first, R_1^T (R_2 x + t_2 - t_1), to `DIGITS`."""
    columns = list(zip(*one.rotation, strict=True))
    others = list(zip(*two.rotation, strict=True))
    apart = subtract(two.shift, one.shift)
    rows = [[round(dot(a, b), DIGITS + 3) + 0.0 for b in others] for a in columns]
    x, y, z = (round(dot(a, apart), DIGITS) + 0.0 for a in columns)
    r1, r2, r3 = ((a, b, c) for a, b, c in rows)
    return Frame((r1, r2, r3), (x, y, z))


def common_volume(one: cq.Shape, two: cq.Shape, frame: Frame) -> float:
    """Common volume of two solids, mm^3."""
    return common_volumes(one, [(two, frame)])[0]


def common_volumes(one: cq.Shape, others: Sequence[tuple[cq.Shape, Frame]]) -> list[float]:
    """Common volumes of a solid and each of several others, mm^3.

    Others whose bounding boxes are apart are intersected with the solid in one operation, since its time grows with the
    number of faces of the solid. A solid of the result belongs to the other whose box contains its centre of mass.
    """
    placed = [moved(other.wrapped, frame) for other, frame in others]
    boxes = [box_of(shape) for shape in placed]
    volumes = [0.0] * len(others)
    for group in _apart(boxes):
        common = occ.BRepAlgoAPI_Common(one.wrapped, compound_of(placed[number] for number in group)).Shape()
        for piece in map(cq.Solid, parts_of(common, "Solid")):
            centre = piece.Center().toPnt()
            number = next((n for n in group if not boxes[n].IsOut(centre)), group[0])
            volumes[number] += abs(piece.Volume())
    return volumes


def _apart(boxes: Sequence[Any]) -> list[list[int]]:
    """Indices of boxes in groups, in each of which no two boxes touch."""
    groups: list[list[int]] = []
    for number, box in enumerate(boxes):
        group = next((group for group in groups if all(boxes[other].IsOut(box) for other in group)), None)
        if group is None:
            groups.append(group := [])
        group.append(number)
    return groups


def least_distance(one: cq.Shape, two: cq.Shape, frame: Frame, gap: float) -> float | None:
    """Least distance of two solids without a common volume, mm; None if the kernel fails.

    Only the faces of each within `gap` of the bounding box of the other are compared: exact up to `gap`; above it, the
    result is larger than `gap`.
    """
    first, second = one.wrapped, moved(two.wrapped, frame)
    distance = occ.BRepExtrema_DistShapeShape(_faces_near(first, second, gap), _faces_near(second, first, gap))
    return float(distance.Value()) if distance.IsDone() else None


def _faces_near(shape: Any, other: Any, gap: float) -> Any:
    """The faces of a shape whose bounding boxes are within a gap of that of another, as a compound; all where none
    is."""
    reach = box_of(other)
    reach.Enlarge(gap)
    near = [face for face in parts_of(shape, "Face") if not reach.IsOut(box_of(face))]
    return compound_of(near) if near else shape


NAME = "interference"
"""Name of the artefact."""

TOUCH = 1e-2
"""Common volume below which two parts only touch, mm^3: a face of 10 000 mm^2 pressed in by a nanometre."""

NEAR = 1.5
"""Gap up to which a pair is listed, mm."""

TOUCHING = 1e-3
"""Distance up to which two parts without a stated relation touch, mm."""


@dataclass(frozen=True)
class Interference:
    """Two parts that touch, fit, overlap or are close to each other."""

    # first, second: names of the instances
    first: str
    second: str
    kind: str  # the intended relation; `CLASH` for a common volume that is not intended, or larger than intended
    # travel, height: position of stage and height adjustment, -1 to 1
    travel: float
    height: float
    common_volume: float  # of the two solids, mm^3
    # least distance, mm; 0 for contact or overlap. None if it was not measured: distances are slow, and are measured
    # for the first pair of two kinds of part at mid-travel and mid-height.
    clearance: float | None

    @property
    def clash(self) -> bool:
        return self.kind == CLASH


@dataclass(frozen=True)
class _Place:
    """Two instances close to each other at one travel and height, and the frame of the second relative to the first."""

    one: Instance
    two: Instance
    travel: float
    height: float
    frame: Frame

    @property
    def key(self) -> str:
        """Values besides the parts on which the common volume depends."""
        return repr((self.one.part, self.one.compression, self.two.part, self.two.compression, self.frame))

    @property
    def at_rest(self) -> bool:
        return self.travel == self.height == 0.0


@dataclass(frozen=True)
class PairValues:
    """Measured values of two kinds of part."""

    volumes: Mapping[str, float]  # common volume by `_Place.key`, mm^3
    # least distance at the first place at rest without a common volume, mm; None if not measured
    clearance: float | None


Measure = Callable[[Sequence[_Place]], PairValues]


def find_interferences(
    parts: Mapping[str, BuiltPart],
    design: Any,
    positions: Iterable[Position] | None = None,
    measure: Measure | None = None,
    untracked: Any = None,
) -> list[Interference]:
    """All pairs closer than `NEAR`, at each position; `untracked`: the design itself where `design` is a proxy."""
    measure = measure or (lambda places: _measured(places, parts, design))
    places: list[_Place] = []
    for travel, height in construction(design).positions if positions is None else positions:
        instances = construction(design).assemble(parts, design, (travel, height))
        # A spring off its installed length is longer or shorter along its own z.
        extents = [(*parts[i.part].geometry.bounding_box, max(0.0, -i.compression)) for i in instances]
        extents = [(low, (x, y, z + longer)) for low, (x, y, z), longer in extents]
        boxes = [transformed_box(i.frame, extent) for i, extent in zip(instances, extents, strict=True)]
        for (one, box), (two, other) in combinations(zip(instances, boxes, strict=True), 2):
            if near(box, other, NEAR):
                places.append(_Place(one, two, travel, height, relative_frame(one.frame, two.frame)))
    pairs: dict[frozenset[str], list[_Place]] = {}
    for place in places:
        pairs.setdefault(frozenset((place.one.part, place.two.part)), []).append(place)
    values = {pair: measure(group) for pair, group in pairs.items()}
    awaited = {pair for pair, found in values.items() if found.clearance is not None}
    found: list[Interference] = []
    for place in places:
        pair = frozenset((place.one.part, place.two.part))
        volume = values[pair].volumes[place.key]
        distance = 0.0 if volume > TOUCH else None
        if place.at_rest and distance is None and pair in awaited:
            awaited.remove(pair)
            distance = values[pair].clearance
        kind = _kind(place.one.part, place.two.part, volume, distance, untracked or design)
        if kind is not None:
            found.append(
                Interference(place.one.name, place.two.name, kind, place.travel, place.height, volume, distance)
            )
    return found


def _measured(places: Sequence[_Place], parts: Mapping[str, BuiltPart], design: Any) -> PairValues:
    """Values of two kinds of part at all their places, measured now."""
    shapes: dict[str, cq.Shape] = {}

    def shape(instance: Instance) -> cq.Shape:
        if instance.shape not in shapes:
            shapes.update(shapes_of([instance], parts, design))
        return shapes[instance.shape]

    volumes: dict[str, float] = {}
    by_shape: dict[str, dict[str, _Place]] = {}
    for place in {place.key: place for place in places}.values():
        by_shape.setdefault(place.one.shape, {})[place.key] = place
    for group in by_shape.values():
        others = [(shape(place.two), place.frame) for place in group.values()]
        one = shape(next(iter(group.values())).one)
        volumes |= dict(zip(group, common_volumes(one, others), strict=True))
    clearance = None
    free = [place for place in places if place.at_rest and volumes[place.key] <= TOUCH]
    if free and frozenset((free[0].one.part, free[0].two.part)) in construction(design).relations(design):
        clearance = least_distance(shape(free[0].one), shape(free[0].two), free[0].frame, NEAR)
    return PairValues(volumes, clearance)


def build_interferences(store: ArtefactStore, parts: Mapping[str, BuiltPart], design: Any) -> list[Interference]:
    """All interference pairs at the ends and middles, from the cache or computed now, in another process."""
    if store.find(NAME, design, _modules(design), contents_of(parts, design)) is None:
        # Without the loaded solids and meshes, which do not pickle.
        stored = {name: replace(part) for name, part in parts.items()}
        in_processes(partial(_compute, store.folder, stored, design), [ASSEMBLY], design)
    return stored_interferences(store, parts, design)


def _compute(folder: Path, parts: Mapping[str, BuiltPart], design: Any, _: str) -> None:
    stored_interferences(ArtefactStore(folder), parts, design)


def stored_interferences(store: ArtefactStore, parts: Mapping[str, BuiltPart], design: Any) -> list[Interference]:
    """The interference pairs, from the cache or computed in this process."""

    @kernel_errors(ASSEMBLY, design)
    def compute(tracked: Any) -> list[Interference]:
        measure = partial(_stored_values, store, parts, tracked)
        return find_interferences(parts, tracked, measure=measure, untracked=design)

    return store.computed(NAME, design, _modules(design), compute, contents_of(parts, design))


def _modules(design: Any) -> tuple[str, ...]:
    return (__name__, *construction(design).modules)


def _stored_values(
    store: ArtefactStore, parts: Mapping[str, BuiltPart], design: Any, places: Sequence[_Place]
) -> PairValues:
    """Values of two kinds of part, from the cache or measured now; they depend on the two and on their places."""
    pair = sorted({places[0].one.part, places[0].two.part})
    # Each place once; those at rest in their order, since the first without a common volume is measured.
    keys = [*dict.fromkeys(place.key for place in places), *(place.key for place in places if place.at_rest)]
    depends = [*(parts[name].entry.content for name in pair), "\n".join(keys)]
    measured = partial(_measured, places, parts)
    return store.computed(f"{NAME} of {' and '.join(pair)}", design, _modules(design), measured, depends)


def clashes(found: Sequence[Interference]) -> list[Interference]:
    """The pairs that are not intended."""
    return [pair for pair in found if pair.clash]


def _kind(one: str, two: str, volume: float, distance: float | None, design: Any) -> str | None:
    """Relation of a pair; None if it is not close."""
    intended = construction(design).relations(design).get(frozenset((one, two)))
    if intended == THREAD or (intended in (OPEN, CONTACT) and volume > TOUCH and design.machine.declaration):
        return THREAD if volume <= _thread_ring(one, two, design) + TOUCH else CLASH
    if volume > TOUCH and intended not in (DRIVE, OVERLAP):
        return CLASH
    if intended == OPEN:
        if distance is None or distance > NEAR:
            return None
        return CONTACT if distance <= TOUCHING else GAP
    return intended if distance is None or distance <= NEAR else None


def _thread_ring(one: str, two: str, design: Any) -> float:
    """Greatest volume between a screw's major diameter and the tap drill of another part's holes for it, mm^3."""
    for screw, other in ((one, two), (two, one)):
        sources = [part_source(name, design) for name in (screw, other)]
        parts: list[Any] = [source.definition() for source in sources]
        if hasattr(parts[0], "thread"):
            diameter, length = parts[0].thread(sources[0].design_of(design))
            holes = [d for d in parts[1].dimensions(sources[1].design_of(design)) if abs(d.major - diameter) < 0.01]
            drills = [d.value for d in holes if d.kind == "tap_drill"]
            depths = [d.value for d in holes if d.kind == "thread_depth"]
            if drills:
                # Where each hole states the depth of its thread, a screw must not go beyond it.
                engaged = min(length, max(depths)) if len(depths) == len(drills) else length
                return math.pi / 4.0 * (diameter**2 - min(drills) ** 2) * engaged
    return 0.0
