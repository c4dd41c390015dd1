"""Interference check: contacts, fits and clashes of parts at the ends and middle of travel and height adjustment.

The table `INTENDED` lists the pairs of parts that touch, fit or overlap by design; common volume of any other pair is a
clash. Threads are cosmetic (a screw has its major diameter, a tapped hole its drill's), so a thread engagement has a
common volume, which must not exceed the ring between the two diameters. The tip overlaps the stage slightly, since this
sets its preload.
"""

# The kernel's Python bindings are compiled and carry no names that a type checker could see.
# pyright: reportAttributeAccessIssue=false

from __future__ import annotations

import json
import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import asdict, dataclass
from functools import partial
from itertools import combinations
from pathlib import Path
from typing import TYPE_CHECKING, Any

from stagecad.solids.artefacts.part import BuiltPart, in_processes, kernel_errors
from stagecad.solids.artefacts.store import Artefact, ArtefactStore
from stagecad.solids.assembly.assemble import HEIGHT_ENDS, TRAVEL_ENDS, Instance, assemble
from stagecad.solids.assembly.built_assembly import shapes_of
from stagecad.solids.modelling.frame import Box, Frame, Vector, dot, subtract, transformed_box
from stagecad.solids.modelling.registry import ASSEMBLY

if TYPE_CHECKING:
    import cadquery as cq

NAME = "interference"
"""Of the artefact."""

TOUCH = 1e-2
"""Common volume below which two parts only touch, mm^3: a face of 10 000 mm^2 pressed in by a nanometre."""

NEAR = 1.5
"""Gap up to which a pair is listed, mm."""

CONTACT = "contact"
FIT = "clearance fit"
THREAD = "thread engagement"
SLIDING = "sliding contact"
DRIVE = "drive contact"
GAP = "gap"
CLASH = "clash"

INTENDED: dict[frozenset[str], str] = {
    frozenset(pair): kind
    for kind, pairs in {
        CONTACT: (
            ("base", "bearing_way"),
            ("bearing_way", "way_screw"),
            ("base", "spring"),
            ("height_pin_1", "set_screw"),
            ("height_pin_1", "spring"),
            ("height_pin_1", "height_pin_2"),
            ("height_pin_2", "holder"),
            ("piezo", "tip"),
            ("stage", "tooth_iron"),
            ("stage", "magnet"),
            ("tooth_iron", "magnet"),
            ("base", "tooth_bar"),
            ("tooth_bar", "bar_screw"),
            ("base", "stop_bar"),
            ("stop_bar", "stop_screw"),
            ("stop_bar", "buffer"),
            ("stop_bar", "sensor_bracket"),
            ("stop_bar", "lead_clip"),
            ("sensor_bracket", "bar_screw"),
            ("sensor_bracket", "interferometer"),
            ("base", "lead_clip"),
            ("stage", "mirror"),
        ),
        FIT: (("base", "height_pin_1"), ("base", "height_pin_2"), ("base", "holder"), ("holder", "piezo")),
        THREAD: (
            ("base", "way_screw"),
            ("base", "clamp_screw_long"),
            ("base", "clamp_screw_short"),
            ("base", "bar_screw"),
            ("base", "stop_screw"),
            ("stop_bar", "bar_screw"),
            ("base", "set_screw"),
        ),
        SLIDING: (("stage", "bearing_way"),),
        DRIVE: (("stage", "tip"),),
        GAP: (
            ("tooth_bar", "tooth_iron"),
            ("tooth_bar", "magnet"),
            ("stage", "tooth_bar"),
            ("tip", "holder"),
            ("buffer", "tooth_iron"),
            ("buffer", "stage"),
            ("stop_bar", "stage"),
        ),
    }.items()
    for pair in pairs
}
"""Intended relation of two kinds of part. `GAP`: close to each other without contact."""

THREADED = {
    "way_screw": ("screws.way.diameter", "screws.way.length", "threads.unc_3_8_tap_drill"),
    "clamp_screw_long": ("screws.clamp_long.diameter", "screws.clamp_long.length", "threads.unc_3_8_tap_drill"),
    "clamp_screw_short": ("screws.clamp_short.diameter", "screws.clamp_short.length", "threads.unc_3_8_tap_drill"),
    "bar_screw": ("screws.bar.diameter", "screws.bar.length", "threads.m5_tap_drill"),
    "stop_screw": ("screws.stop.diameter", "screws.stop.length", "threads.m6_tap_drill"),
    "set_screw": ("set_screw.diameter", "set_screw.length", "threads.unc_1_tap_drill"),
}


@dataclass(frozen=True)
class Interference:
    """Two parts that touch, fit, overlap or are close to each other.

    Attributes:
        first, second: names of the instances.
        kind: the intended relation; `CLASH` for a common volume that is not intended, or larger than intended.
        travel, height: position of stage and height adjustment, -1 to 1.
        common_volume: of the two solids, mm^3.
        clearance: least distance, mm; 0 for contact or overlap. None if it was not measured: distances are slow, and
            are measured for the first pair of two kinds of part at mid-travel and mid-height.
    """

    first: str
    second: str
    kind: str
    travel: float
    height: float
    common_volume: float
    clearance: float | None

    @property
    def clash(self) -> bool:
        return self.kind == CLASH


def find_interferences(
    parts: Mapping[str, BuiltPart],
    design: Any,
    travels: Iterable[float] = TRAVEL_ENDS,
    heights: Iterable[float] = HEIGHT_ENDS,
) -> list[Interference]:
    """All pairs closer than `NEAR`, for every combination of travel and height.

    Pairs with the same relative position in several combinations are intersected only once.
    """
    volumes: dict[tuple[Any, ...], float] = {}
    measured: set[frozenset[str]] = set()
    found: list[Interference] = []
    for travel in travels:
        for height in heights:
            instances = assemble(parts, design, travel, height)
            shapes = shapes_of(instances, parts, design)
            for one, two in combinations(instances, 2):
                if not near(_box(one, parts), _box(two, parts), NEAR):
                    continue
                key = (one.shape, two.shape, _relative(one.frame, two.frame))
                if key not in volumes:
                    volumes[key] = common_volume(one, two, shapes)
                volume = volumes[key]
                pair = frozenset((one.part, two.part))
                distance = 0.0 if volume > TOUCH else None
                if travel == height == 0.0 and distance is None and pair in INTENDED and pair not in measured:
                    measured.add(pair)
                    distance = _distance(one, two, shapes)
                kind = _kind(one.part, two.part, volume, distance, design)
                if kind is not None:
                    found.append(Interference(one.name, two.name, kind, travel, height, volume, distance))
    return found


def build_interferences(store: ArtefactStore, parts: Mapping[str, BuiltPart], design: Any) -> list[Interference]:
    """All interference pairs at the ends and middles, from the cache or computed now, in another process."""
    depends = [part.entry.key for part in parts.values()]
    if store.find(NAME, design, (__name__,), depends) is None:
        # Without the loaded solids and meshes, which do not pickle.
        stored = {name: BuiltPart(name, part.entry) for name, part in parts.items()}
        in_processes(partial(_compute, store.folder, stored, design), [ASSEMBLY], design)
    entry = _compute(store.folder, parts, design)
    return [Interference(**document) for document in entry.document("interferences.json")]


def _compute(folder: Path, parts: Mapping[str, BuiltPart], design: Any, _: str = ASSEMBLY) -> Artefact:
    def make(tracked: Any, made: Path) -> None:
        with kernel_errors(ASSEMBLY, design):
            found = [asdict(pair) for pair in find_interferences(parts, tracked)]
        (made / "interferences.json").write_text(json.dumps(found, indent=1), "utf-8")

    depends = [part.entry.key for part in parts.values()]
    return ArtefactStore(folder).make(NAME, design, (__name__,), make, depends)


def clashes(found: Sequence[Interference]) -> list[Interference]:
    """The pairs that are not intended."""
    return [pair for pair in found if pair.clash]


def _kind(one: str, two: str, volume: float, distance: float | None, design: Any) -> str | None:
    """Relation of a pair; None if it is not close."""
    intended = INTENDED.get(frozenset((one, two)))
    if intended == THREAD:
        return intended if volume <= _ring(one if one in THREADED else two, design) + TOUCH else CLASH
    if volume > TOUCH and intended != DRIVE:
        return CLASH
    return intended if distance is None or distance <= NEAR else None


def _ring(screw: str, design: Any) -> float:
    """Volume between a thread's major diameter and its tap drill over the whole screw, mm^3."""
    diameter, length, drill = (_value(design, key) for key in THREADED[screw])
    return math.pi / 4.0 * (diameter**2 - drill**2) * length


def _value(design: Any, key: str) -> float:
    value = design
    for name in key.split("."):
        value = getattr(value, name)
    return value


def common_volume(one: Instance, two: Instance, shapes: Mapping[str, cq.Shape]) -> float:
    """Common volume of two instances, mm^3."""
    from OCP.BRepAlgoAPI import BRepAlgoAPI_Common
    from OCP.BRepGProp import BRepGProp
    from OCP.GProp import GProp_GProps

    common = BRepAlgoAPI_Common(_placed(one, shapes), _placed(two, shapes))
    properties = GProp_GProps()
    BRepGProp.VolumeProperties_s(common.Shape(), properties)
    return abs(properties.Mass())


def _distance(one: Instance, two: Instance, shapes: Mapping[str, cq.Shape]) -> float | None:
    """Least distance of two instances, mm; None if the kernel fails."""
    from OCP.BRepExtrema import BRepExtrema_DistShapeShape

    distance = BRepExtrema_DistShapeShape(_placed(one, shapes), _placed(two, shapes))
    return float(distance.Value()) if distance.IsDone() else None


def _placed(instance: Instance, shapes: Mapping[str, cq.Shape]) -> Any:
    from OCP.TopLoc import TopLoc_Location

    from stagecad.solids.export.step_stl_glb import transformation

    return shapes[instance.shape].wrapped.Moved(TopLoc_Location(transformation(instance.frame)))


def _box(instance: Instance, parts: Mapping[str, BuiltPart]) -> Box:
    """Bounding box of an instance in the assembly, mm: that of the part's transformed box."""
    low, high = parts[instance.part].geometry.bounding_box
    # A spring off its installed length is longer or shorter along its own z.
    high = (high[0], high[1], high[2] + max(0.0, -instance.compression))
    return transformed_box(instance.frame, (low, high))


def near(one: Box, two: Box, gap: float) -> bool:
    """Whether two boxes are closer than a gap, mm, along every axis."""
    return all(one[0][axis] - gap <= two[1][axis] and two[0][axis] - gap <= one[1][axis] for axis in range(3))


def _relative(one: Frame, two: Frame) -> tuple[float, ...]:
    """Transformation from the first part to the second, rounded to the accuracy of the geometry."""
    columns = [_triple(row[axis] for row in one.rotation) for axis in range(3)]
    other = [_triple(row[axis] for row in two.rotation) for axis in range(3)]
    apart = subtract(two.shift, one.shift)
    turn = [round(dot(a, b), 9) + 0.0 for a in columns for b in other]
    return (*turn, *(round(dot(a, apart), 7) + 0.0 for a in columns))


def _triple(values: Iterable[float]) -> Vector:
    a, b, c = values
    return (a, b, c)
