"""Standard and purchased parts."""

import math
from pathlib import Path
from typing import Any

import pytest

from stagecad.consent import give_consent
from stagecad.declared.standard_part import standard_part
from stagecad.friction_stage.construction import PURCHASED, part_definition
from stagecad.friction_stage.purchased.simple import Spring
from stagecad.parameters.design import Design
from stagecad.parameters.load import load_design
from stagecad.solids.artefacts.part import build_part, build_parts
from stagecad.solids.artefacts.store import ArtefactStore
from stagecad.solids.assembly.interference import stored_interferences
from stagecad.solids.modelling.part import CLASH, THREAD
from tests.refusals import refused

STEEL = 7.85e-3
"""Density, g/mm^3."""
BLOCK = '''"""block: a block with one tapped hole."""
from stagecad.parameters.dimension import Datum
from stagecad.solids.modelling.dimensioning import DOWN, DimensionDeclarations, X, Z, named
NAME = "block"
PARAMETERS = {"side": "30.0 mm", "thread_depth": "14.0 mm", "drill_depth": "18.0 mm"}
def build(design):
    import cadquery as cq
    side = design.block.side
    block = cq.Workplane("XY").box(side, side, side, centered=(True, True, False))
    return block.faces(">Z").workplane().hole(HOLE, design.block.drill_depth)
def material(design):
    return "steel"
def datums(design):
    return named(Datum("hole", (0, 0, design.block.side), Z, X))
def dimensions(design):
    d, top = DimensionDeclarations(design, NAME), design.block.side
    d.tapped("thread", "m5", (0, 0, top), DOWN, ("thread_depth", "drill_depth"))
    return tuple(d)
'''
MACHINE = """extends = "thesis"
[machine]
description = "a screw in a block"
[machine.parts]
plate = {file = "block.py"}
screw = {part = "ISO 4762 M5x12"}
[machine.mates]
plate = {}
screw = {datum = "seat", on = "plate.hole"}
"""


PACKAGED = 'bar_screw", parameters = {"screws.bar.length" = "12 mm"}, description = "of the packaged machine'


@pytest.mark.parametrize(("text", "grams"), [("608", 12.0), ("6204", 106.0), ("6001", 21.0), ("6305", 230.0)])
def test_bearings_have_the_mass_of_the_catalogues(text: str, grams: float) -> None:
    assert standard_part(text).build(None).Volume() * STEEL == pytest.approx(grams, rel=0.08)


@pytest.mark.parametrize(
    ("text", "number", "size"),
    [
        ("ISO 4762 M6x20", "ISO 4762 - M6 x 20", (10.0, 10.0, 26.0)),
        ("ISO 4762 - M5 x 16", "ISO 4762 - M5 x 16", (8.5, 8.5, 21.0)),
        ("ISO 10642 M5x20", "ISO 10642 - M5 x 20", (11.2, 11.2, 20.0)),
        ("ISO 4026 M4x10", "ISO 4026 - M4 x 10", (4.0, 4.0, 10.0)),
        ("ISO 7089 8", "ISO 7089 - 8", (16.0, 16.0, 1.6)),
        ("ISO 8734 6x20", "ISO 8734 - 6 m6 x 20", (6.0, 6.0, 20.0)),
        ("ISO 4032 M8", "ISO 4032 - M8", (13 / math.cos(math.radians(30)), 13.0, 6.8)),
        ("6204", "6204", (47.0, 47.0, 14.0)),
    ],
)
def test_number_and_size_follow_the_designation(text: str, number: str, size: tuple[float, ...]) -> None:
    part = standard_part(text)
    box = part.build(None).BoundingBox()
    assert part.part_number(None) == number
    assert (box.xlen, box.ylen, box.zlen) == pytest.approx(size, abs=1e-3)


@pytest.mark.parametrize(("text", "says"), [
    ("ISO 4762 M6x21", "its lengths: 10, 12, 16, 20, 25"), ("ISO 4762 M6", "no such length"),
    ("ISO 4762 M7x20", "no size 'M7'"), ("ISO 7089 6x3", "it has no length"),
    ("ISO 4763 M6x20", "did you mean 'ISO 4762'"), ("6999", "no size '6999'"),
])  # fmt: skip
def test_what_cannot_be_ordered_is_refused_in_one_line(text: str, says: str) -> None:
    refused(says, standard_part, text)


@pytest.mark.parametrize(("hole", "screw", "kind"), [
    ("design.thread('m5').tap_drill", "ISO 4762 M5x12", THREAD),
    ("design.thread('m5').tap_drill", PACKAGED, THREAD), ("3.0", "ISO 4762 M5x12", CLASH),
])  # fmt: skip
def test_a_screw_in_its_tapped_hole_is_no_clash(hole: str, screw: str, kind: str, tmp_path: Path) -> None:
    (tmp_path / "block.py").write_text(BLOCK.replace("HOLE", hole))
    (tmp_path / "stage.toml").write_text(MACHINE.replace("ISO 4762 M5x12", screw))
    give_consent((tmp_path / "block.py",))
    design = load_design(tmp_path / "stage.toml")
    parts = build_parts(ArtefactStore(), ["plate", "screw"], design, isolate=False)
    (found,) = stored_interferences(ArtefactStore(), parts, design)
    assert found.kind == kind


def hexagon(width: float) -> float:
    """Area of a hexagon by its width across flats."""
    return math.sqrt(3.0) / 2.0 * width**2


@pytest.mark.parametrize("name", PURCHASED)
def test_one_valid_closed_solid(name: str, design: Design, store: ArtefactStore) -> None:
    part = build_part(store, name, design)
    solid = part.solid
    assert solid.isValid() and len(solid.Shells()) == 1
    assert part.geometry.volume > 0.0 and part.part_number
    assert part.description and part.material in design.materials


@pytest.mark.parametrize("key", ["way", "clamp_long", "clamp_short", "bar", "stop"])
def test_screw_against_cylinders(key: str, design: Design, store: ArtefactStore) -> None:
    screw = getattr(design.screws, key)
    name = key.replace("clamp", "clamp_screw") if "clamp" in key else f"{key}_screw"
    part = build_part(store, name, design)
    shank = math.pi / 4.0 * screw.diameter**2 * screw.length
    head = math.pi / 4.0 * screw.head_diameter**2 * screw.head_height
    socket = hexagon(screw.socket_width) * screw.head_height / 2.0
    chamfers = 0.02 * (shank + head)
    assert part.geometry.volume == pytest.approx(shank + head - socket - chamfers / 2, abs=chamfers)
    low, high = part.geometry.bounding_box
    assert (low[2], high[2]) == pytest.approx((-screw.length, screw.head_height), abs=1e-6)
    assert high[0] == pytest.approx(screw.head_diameter / 2.0, abs=1e-6)


def test_only_the_touched_part_is_made_again_and_set_screws_are_cylinders(design: Design, store: ArtefactStore) -> None:
    screw = design.set_screw
    body = (math.pi / 4.0 * screw.diameter**2 - hexagon(screw.socket_width) / 2.0) * screw.length
    assert build_part(store, "set_screw", design).geometry.volume == pytest.approx(body, rel=0.02)
    longer = load_design(overrides=("screws.way.length=26 mm",))
    for name in PURCHASED:
        same = build_part(store, name, longer).entry.key == build_part(store, name, design).entry.key
        assert same == (name != "way_screw")


def test_springs_have_the_length_of_their_wire_also_pushed_together(design: Design, store: ArtefactStore) -> None:
    spring = design.spring
    made = build_part(store, "spring", design).geometry
    radius = (spring.outer_diameter - spring.wire_diameter) / 2.0
    turns = round(spring.coils) + 1
    rise = spring.installed_length - spring.wire_diameter
    wire = math.hypot(2.0 * math.pi * radius * turns, rise)
    assert made.volume == pytest.approx(math.pi / 4.0 * spring.wire_diameter**2 * wire, rel=5e-3)
    low, high = made.bounding_box
    assert (low[2], high[2]) == pytest.approx((0.0, spring.installed_length), abs=1e-5)
    assert high[1] == pytest.approx(spring.outer_diameter / 2.0, abs=1e-5)
    free, pressed = (Spring.build(design, compression) for compression in (0.0, 8.0))
    assert pressed.BoundingBox().zlen == pytest.approx(design.spring.installed_length - 8.0, abs=1e-4)
    assert pressed.Volume() == pytest.approx(free.Volume(), rel=0.01)


def test_piezo_against_cylinder_and_cap(design: Design, store: ArtefactStore) -> None:
    piezo = design.piezo
    radius, crown = piezo.diameter / 2.0, piezo.end_radius
    sag = crown - math.sqrt(crown**2 - radius**2)
    cap = math.pi * sag**2 * (3.0 * crown - sag) / 3.0
    chamfer = 0.04 * piezo.diameter
    # Pappus: the chamfer's triangle at its centroid's radius.
    removed = chamfer**2 / 2.0 * 2.0 * math.pi * (radius - chamfer / 3.0)
    volume = math.pi * radius**2 * (piezo.length - sag) + cap - removed
    made = build_part(store, "piezo", design)
    assert made.geometry.volume == pytest.approx(volume, rel=1e-9)
    assert made.datums["end"].origin == (0.0, 0.0, piezo.length)


BLOCKS = {
    "buffer": (8 * 10 * 3.6, (10, 3.6, 8)),
    "lead_clip": (20 * (6 * 6 - 3 * 4), (20, 6, 6)),
    "interferometer": (60 * 40 * 40, (60, 40, 40)),
    "mirror": (8 * (42 * 12 - 2 * math.pi / 4 * 4.5**2), (42, 12, 8)),
}


@pytest.mark.parametrize("name", BLOCKS)
def test_blocks_have_their_exact_volume_and_size(name: str, design: Design, store: ArtefactStore) -> None:
    volume, size = BLOCKS[name]
    made = build_part(store, name, design).geometry
    assert made.volume == pytest.approx(volume, rel=1e-9)
    low, high = made.bounding_box
    assert [b - a for a, b in zip(low, high, strict=True)] == pytest.approx(size, abs=1e-6)


def test_the_buffers_have_the_stiffness_of_the_end_stops(design: Design) -> None:
    """E A / l of a block, E of 70 Shore A by Gent: 0.0981 (56 + 7.62336 S) / (0.137505 (254 - 2.54 S)) MPa."""
    shore = 70.0
    modulus = 0.0981 * (56.0 + 7.62336 * shore) / (0.137505 * (254.0 - 2.54 * shore))
    assert design.materials["polyurethane"].youngs_modulus == pytest.approx(modulus * 1e6, rel=0.02)
    buffer = design.buffer
    stiffness = modulus * buffer.width * buffer.height / buffer.length
    assert stiffness * 1e3 == pytest.approx(design.end_stop.stiffness, rel=0.02)


def test_a_catalogue_number_is_void_beside_other_sizes() -> None:
    longer = load_design(overrides=["screws.clamp_long.length=205 mm"], rules=False)
    screw: Any = part_definition("clamp_screw_long")
    assert screw.part_number(load_design()) == "91251A648" and '6"' in screw.description(load_design())
    assert screw.part_number(longer) == "length 205 mm: no catalogue number" and '6"' not in screw.description(longer)
    # A number of the user's own is taken as it is.
    named = ["screws.clamp_long.length=205 mm", "screws.clamp_long.part_number=made to order"]
    assert screw.part_number(load_design(overrides=named, rules=False)) == "made to order"
