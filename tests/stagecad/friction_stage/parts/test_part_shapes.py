"""Each made part against what can be said of it without a geometry kernel: volume, box, holes, and what it must do."""

import math

import cadquery as cq
import numpy as np
import pytest
from OCP.BRepAdaptor import BRepAdaptor_Surface  # pyright: ignore[reportMissingImports, reportAttributeAccessIssue]

from stagecad.friction_stage.construction import part_definition
from stagecad.friction_stage.parts.base_clamp import clamps
from stagecad.parameters.load import load_design
from tests.reference.tables import cases
from tests.thesis_parts import solid_of, thesis

HOLES = cases("holes", "holes")


def bounding_box(name: str) -> tuple[float, ...]:
    b = solid_of(name).BoundingBox()
    return (b.xmin, b.xmax, b.ymin, b.ymax, b.zmin, b.zmax)


def round_axes(name: str, diameter: float) -> int:
    """How many different lines are axes of cylinders of a diameter."""
    lines = set()
    for face in solid_of(name).Faces():
        if face.geomType() == "CYLINDER":
            cylinder = BRepAdaptor_Surface(face.wrapped).Cylinder()
            if abs(2 * cylinder.Radius() - diameter) < 1e-6:
                at, to = cylinder.Axis().Location(), cylinder.Axis().Direction()
                point, along = np.array([at.X(), at.Y(), at.Z()]), np.array([to.X(), to.Y(), to.Z()])
                foot = point - along * (point @ along)
                heading = along * np.sign(along[np.argmax(np.abs(along))])
                lines.add((*(np.round(foot, 3) + 0.0), *(np.round(heading, 3) + 0.0)))
    return len(lines)


def hole(diameter: float, depth: float) -> float:
    return math.pi / 4 * diameter**2 * depth


def pointed(diameter: float, depth: float) -> float:
    """A drilled hole with its 118 degree point."""
    return hole(diameter, depth + diameter / 2 / math.tan(math.radians(59)) / 3)


BOXES = {
    "stage": (-115, 115, -135, 135, -2, 12),
    "bearing_way": (-140, 140, -40, 40, 0, 25.4),
    "base": (-180, 180, -175, 175, -90, 0),
    "holder": (-38, 38, -38, 38, 0, 36.6),
    "tip": (-30.5, 30.5, -46 / math.sqrt(12) - 7.5, 46 / math.sqrt(3) + 7.5, -1, 20),
    "height_pin_1": (-10, 6.9, -10, 10, -34, 30),
    "height_pin_2": (-8, 8, -8, 8, -0.4, 20),
    "magnet": (-20, 20, -2.5, 2.5, -5, 0),
    "tooth_iron": (-20, 20, -5, 5, -8, 0),
    "tooth_bar": (-140, 140, -22.5, 22.5, 0, 22.4),
    "stop_bar": (-39, 10, -51.5, 51.5, 0, 27.7),
    "sensor_bracket": (0, 156, -25, 25, -16.6, 6),
}


@pytest.mark.parametrize("name", BOXES)
def test_bounding_box_of_the_thesis_design(name: str) -> None:
    assert bounding_box(name) == pytest.approx(BOXES[name], abs=1e-6)


def stage_volume() -> float:
    pocket = 40.3 * 25.3 * 3
    holes = 20 * pointed(5, 9) + 2 * hole(5, 12) + 4 * pointed(3.3, 10) + 2 * hole(2.5, 9)
    corners = (4 - math.pi) * 5**2 * 12
    return 230 * 270 * 12 - corners - 2 * 1000 * 0.5**2 / 2 + 3 * 24 * 12 * 2 - 2 * pocket - holes - 2 * 230 * 1.5 * 0.3


def way_volume() -> float:
    edges = 4 * 280 + 4 * 80 + 2 * 25.4 + 2 * 14.3 + 280 + 2 * 11.1
    return 280 * (80 * 25.4 - 20 * 11.1 + (1 - math.pi / 4) * 2**2) - 7 * hole(10.5, 14.3) - edges / 2


def base_volume() -> float:
    pockets = 3 * (hole(76.03, 36.6 - 1) + hole(16, 60 - 36.6 - 8))
    access = [114, 180 - 86.60254 - 66, 180 - 86.60254 - 66]
    bores = sum(hole(26, a) + hole(22.225, 50) + hole(20, 86) for a in access)
    slots = 4 * 90 * (1.5 * (46 + 21 + 25) + 3 * 28 + hole(10, 1))
    screws = 2 * hole(10.5, 140) + 2 * hole(10.5, 100)
    taps = 14 * pointed(7.9375, 18) + 7 * pointed(8.5, 20) + 4 * pointed(5, 15) + 8 * pointed(4.2, 15)
    return 360 * (350 * 90 - 192 * 1) - pockets - bores - slots - screws - taps - 3 * 110 * 8 * 6


def stop_bar_volume() -> float:
    holes = 2 * (hole(6.6, 12) + hole(11, 15.7) + hole(4.2, 14 + 4.2 / 2 / math.tan(math.radians(59)) / 3))
    return 103 * (49 * 27.7 - 15 * 17) - holes


def bracket_volume() -> float:
    return 50 * (156 * 10 + 10 * 12.6) - 2 * hole(5.5, 10) - 2 * hole(4.5, 10)


def strip(diameter: float, width: float) -> float:
    """Area of the half of a circle's central strip: the integral of sqrt(r^2 - t^2) over |t| < width / 2."""
    r, t = diameter / 2, width / 2
    return t * math.sqrt(r**2 - t**2) + r**2 * math.asin(t / r)


def holder_volume() -> float:
    slots = 3 * 30.6 * (6 * 46 / math.sqrt(3) - strip(20, 6) - strip(10.05, 6))
    holes = 3 * hole(10.05, 30.6) + 3 * hole(5, 6) + hole(20, 30.6) + 3 * hole(3.3, 6.4) + 3 * pointed(3.3, 10)
    return hole(76, 36.6) - slots - holes - 2 * math.pi * 76 / 2


def tip_volume() -> float:
    r = 46 / math.sqrt(3)
    x, y = np.meshgrid(np.arange(-40, 40, 0.05), np.arange(-40, 40, 0.05))
    inside = np.hypot(x, y) < 11
    for angle in np.radians((90, 210, 330)):
        along, across = x * np.cos(angle) + y * np.sin(angle), y * np.cos(angle) - x * np.sin(angle)
        inside |= (np.hypot(along - r, across) < 7.5) | ((np.abs(across) < 5.5) & (along > 0) & (along < r))
    cone = math.pi / 3 * (20 - 5 - 0.92) * (7.5**2 + 7.5 * 6 + 6**2)
    cap = math.pi * 0.92**2 * (20 - 0.92 / 3)
    return 6 * float(inside.sum()) * 0.05**2 + cone + cap - 3 * hole(10.2, 1) - pointed(8, 12)


def pin_1_volume() -> float:
    z = np.linspace(-30, 30, 2001)
    d = 5.4 + 0.05 * z
    segment = 10**2 * np.arccos(d / 10) - d * np.sqrt(10**2 - d**2)
    spigot = hole(12, 4) - 4 * float(6**2 * np.arccos(3.8 / 6) - 3.8 * np.sqrt(6**2 - 3.8**2))
    return hole(20, 60) - float(np.trapezoid(segment, z)) + spigot - pointed(4.2, 13)


ESTIMATES = {
    "stop_bar": (stop_bar_volume, 1e-9),
    "sensor_bracket": (bracket_volume, 1e-9),
    "stage": (stage_volume, 2e-4),
    "bearing_way": (way_volume, 2e-4),
    "base": (base_volume, 2e-3),
    "holder": (holder_volume, 2e-3),
    "tip": (tip_volume, 0.01),
    "height_pin_1": (pin_1_volume, 3e-3),
    "height_pin_2": (lambda: hole(16, 20) - math.pi * 8**4 / (4 * 60), 5e-3),
    "magnet": (lambda: 40 * 5 * 5 - 0.3**2 / 2 * 4 * (40 + 5 + 5), 1e-3),
    "tooth_iron": (lambda: 40 * (10 * 8 - 6 * 2.5) - (4 - math.pi) * 2**2 * 5.5 - 100 * 0.3**2 / 2, 2e-3),
    "tooth_bar": (lambda: 250 * (25 * 21.4 - (25 - 8) * 2.5 - 5 * 3.5) + 2 * 15 * 45 * 10 - 4 * hole(5.5, 10), 2e-3),
}


@pytest.mark.parametrize("name", ESTIMATES)
def test_volume_against_a_closed_form(name: str) -> None:
    """Plain bodies less plain holes, added up by hand from the thesis design's sizes; the rest is within the margin."""
    estimate, within = ESTIMATES[name]
    assert solid_of(name).Volume() == pytest.approx(estimate(), rel=within)


@pytest.mark.parametrize(("name", "diameter", "count", "what"), HOLES)
def test_number_of_holes(name: str, diameter: float, count: int, what: str) -> None:
    assert round_axes(name, diameter) == count, what


@pytest.mark.parametrize("index", range(4))
def test_a_clamp_finger_hangs_on_its_neck_alone(index: int) -> None:
    """Sawing through the neck from top to bottom sets the finger free: nothing else holds it, the floor least."""
    base, design = solid_of("base"), thesis()
    clamp = clamps(design)[index]
    angle = math.radians(clamp.neck)
    radius = design.base.pocket_diameter / 2
    reach = (radius - design.base.clamp_floor_slot, radius + design.base.clamp_neck + 1)
    ends = [
        clamp.place(r * math.cos(angle) + t * math.sin(angle), r * math.sin(angle) - t * math.cos(angle))
        for r, t in ((reach[0], -0.05), (reach[1], -0.05), (reach[1], 0.05), (reach[0], 0.05))
    ]
    saw = cq.Wire.makePolygon([(x, y, -design.base.height - 1) for x, y in ends], close=True)
    pieces = base.cut(cq.Solid.extrudeLinear(saw, [], cq.Vector(0, 0, design.base.height + 2))).Solids()
    assert len(pieces) == 2
    low = min(pieces, key=lambda piece: piece.Volume()).BoundingBox()
    # The fingers of pockets 2 and 3 reach into the seats of the ways.
    top = -design.base.seat_height if clamp.pocket == 1 else 0.0
    assert (low.zmin, low.zmax) == pytest.approx((-design.base.height, top), abs=1e-6)


def test_the_seats_of_the_ways_are_raised_and_in_one_plane() -> None:
    """Flat to the chamfered side faces and to 1 mm beyond the inner edges of the ways, 1 mm over the rest."""
    faces = [f for f in solid_of("base").Faces() if f.geomType() == "PLANE" and abs(f.normalAt().z) > 1 - 1e-9]
    boxes = [f.BoundingBox() for f in faces]
    seats = sorted((b.ymin, b.ymax, b.xmin, b.xmax) for b in boxes if abs(b.zmax) < 1e-6)
    assert seats[0] == pytest.approx((-174, -96, -179, 179), abs=1e-5)
    assert seats[-1] == pytest.approx((96, 174, -179, 179), abs=1e-5)
    assert all(min(abs(low), abs(high)) > 96 - 1e-5 for low, high, *_ in seats)
    floor = [(b.ymin, b.ymax) for b in boxes if abs(b.zmax + 1) < 1e-6]
    assert (min(low for low, _ in floor), max(high for _, high in floor)) == pytest.approx((-96, 96), abs=1e-5)


def test_heights_close_and_pads_ride_on_their_middle() -> None:
    """Wedge, pin 2, holder floor, piezo and tip bring the apex to the drive surface, which pads and ways carry."""
    d = thesis()
    apex = (
        -d.base.pin_1_axis_depth
        + d.height_pin_1.flat_height
        + d.height_pin_2.length
        + d.holder.floor
        + d.piezo.length
        + part_definition("tip").datums(d)["apex"].origin[2]
    )
    way, stage = part_definition("bearing_way").datums(d), part_definition("stage").datums(d)
    surface = way["top"].origin[2] - stage["pads"].origin[2] + stage["drive_surface"].origin[2]
    assert apex == pytest.approx(surface, abs=1e-9)
    # The crown stands proud of the pad's edges by the sagitta of its sphere, l^2 / 8 R along and w^2 / 8 R across.
    d, stage = thesis(), solid_of("stage")
    x, y, z = part_definition("stage").datums(d)["pad_1"].origin
    probe = cq.Vertex.makeVertex(x + d.pads.length / 2 - 1e-6, y, z)
    sagitta = d.pads.length**2 / (8 * d.pads.crown_radius)
    pad = [face for face in stage.Faces() if face.geomType() == "SPHERE"]
    assert len(pad) == 3 and min(face.distance(probe) for face in pad) == pytest.approx(sagitta, rel=1e-3)
    d = thesis()
    assert d.height_pin_1.diameter < d.threads.unc_1_tap_drill and d.spring.outer_diameter < d.base.pin_1_bore


def test_four_pads_and_no_teeth() -> None:
    """The variant for two axes: gravity preload on four pads, drive surface without pockets and grooves."""
    design = load_design(overrides=["pads.count=4", "teeth.fitted=false", "sea.whole_underside=true"], rules=False)
    module = part_definition("stage")
    solid = module.build(design)
    assert solid.isValid() and sum(face.geomType() == "SPHERE" for face in solid.Faces()) == 4
    bottom = [f for f in solid.Faces() if f.geomType() == "PLANE" and abs(f.Center().z) < 1e-9]
    assert len(bottom) == 1
    declared = {dimension.parameter for dimension in module.dimensions(design)}
    assert not declared & {"sea.width", "stage.iron_pocket_length", "teeth.bar_spacing"}
    assert {"pad_4"} <= set(module.datums(design))
    assert not [name for name in module.datums(design) if name.startswith(("tooth", "magnet"))]
