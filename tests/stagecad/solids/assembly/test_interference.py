"""Nothing runs into anything that is not meant to meet it; the bill of materials and files of `stagecad parts`."""

import csv
import io
import json
import math
import os
import shutil
from dataclasses import replace
from pathlib import Path

import cadquery as cq
import pytest

from stagecad.friction_stage.construction import PURCHASED
from stagecad.parameters.design import Design
from stagecad.solids.artefacts.store import ArtefactStore
from stagecad.solids.assembly import interference
from stagecad.solids.assembly.bill_of_materials import csv_text
from stagecad.solids.assembly.built_machine import BuiltMachine
from stagecad.solids.assembly.interference import (
    Interference,
    build_interferences,
    clashes,
    common_volume,
    common_volumes,
    find_interferences,
    least_distance,
    relative_frame,
)
from stagecad.solids.modelling.frame import Frame
from stagecad.solids.modelling.part import construction
from tests.process_state import python

C, S = math.cos(math.radians(30.0)), math.sin(math.radians(30.0))
TURNED = ((C, -S, 0.0), (S, C, 0.0), (0.0, 0.0, 1.0))
RING = math.pi * (3.5**2 - 3.0**2) * 10
"""Common volume of the plate and a pin of 7 mm in one of its holes, mm^3."""


@pytest.fixture(scope="module")
def found(machine: BuiltMachine, design: Design, store: ArtefactStore) -> list[Interference]:
    return build_interferences(store, machine.parts, design)


def at_rest(found: list[Interference], first: str, second: str) -> Interference:
    (meeting,) = [m for m in found if {m.first, m.second} == {first, second} and m.travel == m.height == 0.0]
    return meeting


def test_contacts_fits_threads_and_gaps_are_those_of_the_design(found: list[Interference], design: Design) -> None:
    assert [(m.first, m.second, m.travel, m.height, m.common_volume) for m in clashes(found)] == []
    assert {(m.travel, m.height) for m in found} == {(t, h) for t in (-1.0, 0.0, 1.0) for h in (-1.0, 0.0, 1.0)}
    touching = [m for m in found if m.kind in ("contact", "sliding contact", "drive contact")]
    measured = [m for m in touching if m.clearance is not None and m.travel == m.height == 0.0]
    assert len(measured) >= 12
    for meeting in measured:
        assert meeting.clearance == pytest.approx(0.0, abs=1e-6), meeting
    holder = (design.base.pocket_diameter - design.holder.diameter) / 2.0
    assert at_rest(found, "base", "holder_1").clearance == pytest.approx(holder, abs=1e-5)
    pin = (design.base.pin_2_bore - design.height_pin_2.diameter) / 2.0
    assert at_rest(found, "base", "height_pin_2_1").clearance == pytest.approx(pin, abs=1e-5)
    screw, drill = design.screws.way, design.threads.unc_3_8_tap_drill
    ring = math.pi / 4.0 * (screw.diameter**2 - drill**2) * design.derived.way_screw_engagement
    overlap = at_rest(found, "base", "way_screw_left_1").common_volume
    # The screw's chamfered end and the hole's chamfered mouth take a little of it.
    assert overlap == pytest.approx(ring, rel=0.15) and overlap < ring
    gaps = [m.clearance for m in found if m.kind == "gap" and "tooth_iron" in m.second and m.clearance is not None]
    assert gaps and gaps[0] == pytest.approx(design.teeth.gap, abs=1e-6)
    drive = {m.height: m for m in found if m.kind == "drive contact" and m.travel == 0.0}
    assert drive[1.0].common_volume > 1.0 and drive[0.0].common_volume < interference.TOUCH


def test_a_part_put_wrong_is_found(machine: BuiltMachine, design: Design, monkeypatch: pytest.MonkeyPatch) -> None:
    made = construction(design)

    def sunk(*arguments: object, **named: object) -> tuple:
        """The stage half a millimetre too low."""
        return tuple(
            replace(instance, frame=instance.frame.shifted((0.0, 0.0, -0.5))) if instance.part == "stage" else instance
            for instance in made.assemble(*arguments, **named)  # type: ignore[arg-type]
            if instance.part in ("stage", "bearing_way", "base")
        )

    monkeypatch.setattr(interference, "construction", lambda _: replace(made, assemble=sunk))
    wrong = clashes(find_interferences(machine.parts, design, [(0.0, 0.0)]))
    pressed = {frozenset((m.first, m.second)): m.common_volume for m in wrong}
    assert set(pressed) == {frozenset(("bearing_way_left", "stage")), frozenset(("bearing_way_right", "stage"))}
    # Half a millimetre of the crowned pads: less than of flat ones, and a good part of it.
    pads = {"left": 2, "right": 1}
    for side, number in pads.items():
        flat = number * 0.5 * design.pads.length * design.pads.width
        assert 0.85 * flat < pressed[frozenset((f"bearing_way_{side}", "stage"))] < flat


@pytest.fixture(scope="module")
def solids():
    """A plate of 40 x 40 x 10 with a bore of 12 through its middle, and a pin of 10 x 30 along z."""
    plate = cq.Solid.makeBox(40, 40, 10, cq.Vector(-20, -20, 0)).cut(cq.Solid.makeCylinder(6, 10))
    pin = cq.Solid.makeCylinder(5, 30)
    return plate.Solids()[0], pin


def test_frames_common_volumes_and_distances_of_a_pin_and_a_plate(solids) -> None:
    one, two = Frame(TURNED, (5.0, -3.0, 2.0)), Frame(((0.0, -1.0, 0.0), (1.0, 0.0, 0.0), (0.0, 0.0, 1.0)), (1, 2, 3))
    frame = relative_frame(one, two)
    for point in ((0.0, 0.0, 0.0), (1.0, -2.0, 4.0)):
        assert one.point(frame.point(point)) == pytest.approx(two.point(point), abs=1e-8)
    one, two = Frame(shift=(0.1, 0.2, 0.3)), Frame(TURNED, (1.1, 0.7, 12.9))
    by = (100.3, -7.7, 1 / 3)
    assert relative_frame(one, two) == relative_frame(one.shifted(by), two.shifted(by))
    plate, pin = solids
    assert common_volume(plate, pin, Frame(TURNED, (13.0, -9.0, 4.0))) == pytest.approx(math.pi * 25 * 6, rel=1e-9)
    assert common_volume(plate, pin, Frame(shift=(0.0, 0.0, -5.0))) == 0.0
    for height in (12.0, 30.0, 300.0):
        distance = least_distance(plate, pin, Frame(shift=(13.0, 0.0, height)), 1.5)
        assert distance is not None and distance > 1.5


@pytest.fixture(scope="module")
def drilled():
    """A plate of 200 x 40 x 10 with 20 holes of 6 mm, 9 mm apart."""
    holes = cq.Workplane().box(200, 40, 10, centered=False).faces(">Z").workplane(origin=(0, 20, 0))
    return holes.pushPoints([(10 + 9 * k, 0) for k in range(20)]).hole(6).solids().val()


@pytest.mark.parametrize("holes", [(0,), (3, 0, 19), tuple(range(20))])
def test_common_volumes_of_others_that_are_apart(drilled, holes: tuple[int, ...]) -> None:
    pin = cq.Solid.makeCylinder(3.5, 30)
    others = [(pin, Frame(shift=(10.0 + 9 * hole, 20.0, -5.0))) for hole in holes]
    volumes = common_volumes(drilled, [*others, (pin, Frame(shift=(10.0, 60.0, -5.0)))])
    assert volumes == pytest.approx([RING] * len(holes) + [0.0], rel=1e-9)


def test_common_volumes_of_pieces_and_overlapping_others(drilled) -> None:
    # Two grooves of 2 mm leave five layers, of which three are the plate's and two are air.
    layers = [cq.Solid.makeBox(200, 40, 2, cq.Vector(0, 0, z)) for z in (0.0, 4.0, 8.0)]
    solid, block = cq.Compound.makeCompound(layers), cq.Solid.makeBox(5, 5, 30)
    others = [(block, Frame(shift=(x, 2.0, -5.0))) for x in (10.0, 30.0)]
    assert common_volumes(solid, others) == pytest.approx([5 * 5 * 6.0] * 2, rel=1e-9)
    pin = cq.Solid.makeCylinder(3.5, 30)
    near = [(pin, Frame(shift=(19.0 + by, 20.0, -5.0))) for by in (0.0, 0.2, 1.5)]
    alone = [common_volume(drilled, other, frame) for other, frame in near]
    assert alone[0] == pytest.approx(RING, rel=1e-9) and alone[2] > 1.5 * RING
    assert common_volumes(drilled, near) == pytest.approx(alone, rel=1e-9)
    far = (pin, Frame(shift=(181.0, 20.0, -5.0)))
    assert common_volumes(drilled, [*near, far]) == pytest.approx([*alone, RING], rel=1e-9)


@pytest.mark.parametrize(
    ("shift", "expected"),
    [((0.0, 0.0, -5.0), 1.0), ((0.25, 0.0, -5.0), 0.75), ((13.0, 0.0, 10.0), 0.0), ((13.0, 0.0, 10.4), 0.4)],
)
def test_distance_up_to_the_gap_is_exact(solids, shift: tuple[float, float, float], expected: float) -> None:
    plate, pin = solids
    assert least_distance(plate, pin, Frame(shift=shift), 1.5) == pytest.approx(expected, abs=1e-9)


CATALOGUE = {
    "piezo": "ASB170C801NP0",
    "way_screw": "91251A624",
    "clamp_screw_long": "91251A648",
    "clamp_screw_short": "91251A642",
    "set_screw": "91375A904",
    "spring": "9657K26",
}
"""Part numbers of the thesis, section 1 of its digest."""


@pytest.fixture
def cached(machine: BuiltMachine, store: ArtefactStore, monkeypatch: pytest.MonkeyPatch) -> ArtefactStore:
    monkeypatch.setenv("STAGECAD_CACHE", str(store.folder))
    return store


def test_the_list_has_each_part_once_and_its_masses_add_up(machine: BuiltMachine) -> None:
    rows = {row.part: row for row in machine.bill_of_materials}
    assert len(rows) == len(machine.bill_of_materials)
    assert sum(row.quantity for row in rows.values()) == len(machine.assembly.instances)
    assert {name: rows[name].part_number for name in CATALOGUE} == CATALOGUE
    assert {name for name, row in rows.items() if row.purchased} == set(PURCHASED)
    total = sum(row.quantity * row.mass for row in machine.bill_of_materials)
    assert total == pytest.approx(machine.whole.mass, rel=1e-12)
    table = list(csv.reader(io.StringIO(csv_text(machine.bill_of_materials))))
    assert table[-1][1] == "total" and float(table[-1][-1]) == pytest.approx(total, abs=1e-4)


@pytest.mark.parametrize("text", ["=cmd|' /C calc'!A0", "+1", "-1", "@SUM(1)", "\t=1"])
def test_a_part_number_that_a_spreadsheet_would_calculate_is_text(machine: BuiltMachine, text: str) -> None:
    row = replace(machine.bill_of_materials[0], part_number=text)
    cells = list(csv.reader(io.StringIO(csv_text([row]))))[1]
    assert f"'{text}" in cells and text not in cells


def test_command_writes_files_document_and_manifest(cached, machine: BuiltMachine, tmp_path, command) -> None:
    document = command.json("parts", "--out", tmp_path)
    assert set(document["parts"]) == {*machine.parts, "assembly"}
    stage = document["parts"]["stage"]
    assert stage["mass"] == {"value": pytest.approx(machine.masses["stage"].mass), "unit": "kg"}
    assert [Path(file).name for file in stage["files"]] == ["stage.step", "stage.stl", "stage.glb"]
    assert document["moving_body"]["mass"]["value"] == pytest.approx(machine.moving_body.mass)
    listed = json.loads((tmp_path / "parts_manifest.json").read_text())["files"]
    assert set(listed) == {path.name for path in tmp_path.iterdir()} - {"parts_manifest.json"}
    assert all(Path(file).is_file() for part in document["parts"].values() for file in part["files"])


def test_command_leaves_good_files_alone_and_mends_others(cached: ArtefactStore, tmp_path: Path, command) -> None:
    command("parts", "stage", "piezo", "--out", tmp_path)
    names = {path.name for path in tmp_path.iterdir()}
    assert names == {f"{part}.{kind}" for part in ("stage", "piezo") for kind in ("step", "stl", "glb")} | {
        "parts_manifest.json"
    }
    before = {name: (tmp_path / name).stat().st_mtime_ns for name in names}
    good = (tmp_path / "piezo.step").read_bytes()
    (tmp_path / "piezo.step").write_bytes(good[:100])
    command("parts", "stage", "piezo", "--out", tmp_path)
    assert (tmp_path / "piezo.step").read_bytes() == good
    changed = {name for name in names if (tmp_path / name).stat().st_mtime_ns != before[name]}
    assert changed == {"piezo.step"}


def test_command_makes_again_what_is_damaged_in_the_cache(machine, store, tmp_path, monkeypatch, command) -> None:
    # A cache of its own: other tests read the common one meanwhile.
    shutil.copytree(store.folder, tmp_path / "cache", ignore=shutil.ignore_patterns(".*"), copy_function=os.link)
    monkeypatch.setenv("STAGECAD_CACHE", str(tmp_path / "cache"))
    common = machine.parts["magnet"].entry.path("magnet.stl")
    good = common.read_bytes()
    own = tmp_path / "cache" / common.relative_to(store.folder)
    own.unlink()
    own.write_bytes(good[:-1] + b"x")
    assert "damaged" in command("parts", "magnet", "--out", tmp_path).err
    assert (tmp_path / "magnet.stl").read_bytes() == good


def test_unknown_part_names_the_nearest(cached: ArtefactStore, tmp_path, command) -> None:
    error = command.refused("parts", "stag", "--out", tmp_path)
    assert "no part 'stag'" in error and "did you mean 'stage'" in error
    assert list(tmp_path.iterdir()) == []


def test_nothing_changed_needs_no_kernel(cached: ArtefactStore, design: Design, tmp_path: Path) -> None:
    program = (
        "import sys; from workbench.cli import run; status = run(sys.argv[1:]); "
        "bad = {'cadquery', 'OCP', 'vtk', 'numba', 'scipy', 'pandas'} & set(sys.modules); "
        "sys.exit(status or (f'imported {sorted(bad)}' if bad else 0))"
    )
    python("-c", program, "parts", "--out", tmp_path)
    assert (tmp_path / "assembly.step").is_file()
