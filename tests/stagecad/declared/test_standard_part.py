"""Standard parts: sizes of the standards, masses of the makers' catalogues, threads in tapped holes."""

import math
from pathlib import Path

import pytest

from stagecad.consent import give_consent
from stagecad.declared.construction import standard_part
from stagecad.parameters.errors import InputError
from stagecad.parameters.load import load_design
from stagecad.solids.artefacts.part import build_parts
from stagecad.solids.artefacts.store import ArtefactStore
from stagecad.solids.assembly.interference import stored_interferences
from stagecad.solids.modelling.part import CLASH, THREAD

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
    solid = standard_part(text).build(None)
    assert solid.Volume() * STEEL == pytest.approx(grams, rel=0.08)


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


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ("ISO 4762 M6x21", "its lengths: 10, 12, 16, 20, 25"),
        ("ISO 4762 M6", "no such length"),
        ("ISO 4762 M7x20", "no size 'M7'"),
        ("ISO 7089 6x3", "it has no length"),
        ("ISO 4763 M6x20", "did you mean 'ISO 4762'"),
        ("6999", "no size '6999'"),
    ],
)
def test_what_cannot_be_ordered_is_refused_in_one_line(text: str, says: str) -> None:
    with pytest.raises(InputError, match=says) as caught:
        standard_part(text)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize(
    ("hole", "screw", "kind"),
    [
        ("design.thread('m5').tap_drill", "ISO 4762 M5x12", THREAD),
        ("design.thread('m5').tap_drill", PACKAGED, THREAD),
        ("3.0", "ISO 4762 M5x12", CLASH),
    ],
)
def test_a_screw_in_its_tapped_hole_is_no_clash(hole: str, screw: str, kind: str, tmp_path: Path) -> None:
    (tmp_path / "block.py").write_text(BLOCK.replace("HOLE", hole))
    (tmp_path / "stage.toml").write_text(MACHINE.replace("ISO 4762 M5x12", screw))
    give_consent((tmp_path / "block.py",))
    design = load_design(tmp_path / "stage.toml")
    parts = build_parts(ArtefactStore(), ["plate", "screw"], design, isolate=False)
    (found,) = stored_interferences(ArtefactStore(), parts, design).document("interferences.json")
    assert found["kind"] == kind
