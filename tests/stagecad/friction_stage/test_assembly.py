"""The machine put together: parts meet where their datums say, and the numbers that leave it are right."""

import io
import math
from dataclasses import replace

import numpy as np
import pytest
import trimesh

from stagecad.friction_stage.assembly import assemble, documents
from stagecad.friction_stage.construction import MADE, OF_END_STOPS, OF_TEETH, PURCHASED
from stagecad.parameters.design import Design
from stagecad.parameters.dimension import Datum
from stagecad.parameters.load import load_design
from stagecad.solids.artefacts.store import ArtefactStore
from stagecad.solids.assembly.built_machine import BuiltMachine, body_masses, build_machine, find_machine
from stagecad.solids.modelling.frame import Frame, add, mate, scaled
from stagecad.solids.modelling.mass import placed
from stagecad.solids.modelling.part import Instance, count, part_names


def by_name(instances: tuple[Instance, ...]) -> dict[str, Instance]:
    return {instance.name: instance for instance in instances}


def world(machine: BuiltMachine, instance: Instance, datum: str) -> Datum:
    """A datum of an instance in the coordinates of the assembly."""
    own = machine.parts[instance.part].datums[datum]
    frame = instance.frame
    return Datum(datum, frame.point(own.origin), frame.direction(own.normal), frame.direction(own.x_direction))


def test_mate_brings_datums_face_to_face() -> None:
    rng = np.random.default_rng(3)
    for _ in range(20):
        axes, other = (np.linalg.qr(rng.normal(size=(3, 3)))[0].T for _ in range(2))
        child = Datum("child", tuple(rng.normal(size=3)), tuple(axes[0]), tuple(axes[1]))
        parent = Datum("parent", tuple(rng.normal(size=3)), tuple(other[0]), tuple(other[1]))
        turn = np.linalg.qr(rng.normal(size=(3, 3)))[0]
        turn *= np.sign(np.linalg.det(turn))
        under = Frame(tuple(map(tuple, turn)), tuple(rng.normal(size=3)))
        frame = mate(child, under, parent)
        assert frame.point(child.origin) == pytest.approx(under.point(parent.origin), abs=1e-12)
        assert frame.direction(child.normal) == pytest.approx(scaled(under.direction(parent.normal), -1.0), abs=1e-12)
        assert frame.direction(child.x_direction) == pytest.approx(under.direction(parent.x_direction), abs=1e-12)
        assert np.linalg.det(np.array(frame.rotation)) == pytest.approx(1.0)


@pytest.mark.parametrize("height", [-1.0, 0.0, 1.0])
def test_tip_rises_by_slope_times_stroke(machine: BuiltMachine, design: Design, height: float) -> None:
    apex = world(machine, by_name(assemble(machine.parts, design, height=height))["tip_1"], "apex").origin
    way, pads = design.bearing_way.height, design.pads.height
    rise = height * design.height_pin_1.stroke / 2.0 * design.height_pin_1.slope
    # At the middle of its adjustment the tip just reaches the drive surface: way, pads, nothing between.
    assert apex == pytest.approx((0.0, 0.0, way + pads + rise), abs=1e-9)


def test_counts_places_and_end_stops_of_the_machine(machine: BuiltMachine, design: Design) -> None:
    standing = by_name(assemble(machine.parts, design))
    for number in (1, 2, 3):
        end = world(machine, standing[f"piezo_1_{number}"], "end")
        assert end.origin == pytest.approx(world(machine, standing["tip_1"], f"piezo_{number}").origin, abs=1e-9)
    for travel in (-1.0, 0.0, 1.0):
        standing = by_name(assemble(machine.parts, design, travel))
        stage = standing["stage"]
        assert stage.frame.shift[0] == pytest.approx(travel * design.stage.travel / 2.0)
        for name in machine.parts["stage"].datums:
            if not name.startswith("pad_"):
                continue
            x, y, z = world(machine, stage, name).origin
            assert z == pytest.approx(design.bearing_way.height, abs=1e-9)
            assert abs(x) + design.pads.length / 2.0 <= design.bearing_way.length / 2.0
            inner = design.base.way_gap / 2.0
            outer = inner + design.bearing_way.width - design.bearing_way.ledge_width
            assert inner <= abs(y) - design.pads.width / 2.0 and abs(y) + design.pads.width / 2.0 <= outer
    standing = assemble(machine.parts, design)
    holes = {(round(x, 6), round(y, 6)) for x, y in design.derived.way_screw_places}
    screws = [instance for instance in standing if instance.part == "way_screw"]
    assert {(round(s.frame.shift[0], 6), round(s.frame.shift[1], 6)) for s in screws} == holes
    for screw in screws:
        end = world(machine, screw, "end").origin[2]
        assert end == pytest.approx(-design.derived.way_screw_engagement, abs=1e-9)
    counts = count(machine.assembly.instances)
    assert set(counts) == set(machine.parts) and counts["bearing_way"] == 2
    assert counts["way_screw"] == 2 * design.bearing_way.bolt_count and counts["piezo"] == 3 * design.actuator.fitted
    assert (counts["magnet"], counts["tooth_iron"], counts["tooth_bar"]) == (2, 4, 2)
    assert len({instance.name for instance in machine.assembly.instances}) == len(machine.assembly.instances)
    # Gap of 0.5 mm along the travel, at the height of the part of the irons that stands out; exactly.
    for travel, bar in ((1.0, 1), (-1.0, 2)):
        standing = by_name(assemble(machine.parts, design, travel))
        irons = (stage_end(machine, standing[f"tooth_iron_{i}"], travel) for i in (2, 3))
        ends = sorted(irons, key=lambda end: travel * end[1])
        for number, (x, y) in enumerate(ends, start=1):
            face = world(machine, standing[f"buffer_{bar}_{number}"], "face")
            assert face.origin == pytest.approx((x + travel * 0.5, y, 27.4 - 2.5), abs=1e-9)
            assert face.normal == pytest.approx((-travel, 0.0, 0.0), abs=1e-12)
    standing = by_name(assemble(machine.parts, design, -1.0))
    beam = world(machine, standing["interferometer_1"], "beam")
    mirror = world(machine, standing["mirror_1"], "face")
    assert mirror.origin == pytest.approx((-100.0 - 115.0 - 8.0, 0.0, 27.4 + 6.0), abs=1e-9)
    assert beam.origin == pytest.approx((mirror.origin[0] - 50.0, 0.0, 27.4 + 6.0), abs=1e-9)
    assert beam.normal == pytest.approx((1.0, 0.0, 0.0), abs=1e-12)
    clip = by_name(machine.assembly.instances)["lead_clip_1"]
    assert world(machine, clip, "seat").origin == pytest.approx((180.0 - 1.0 - 10.0, 0.0, -1.0 - 6.0), abs=1e-9)
    # A two-axis design has a travel of its own; only where the actuators stand is of interest here.
    full = replace(design, actuator=replace(design.actuator, fitted=3))
    standing = by_name(assemble(machine.parts, full))
    for number, (x, y) in enumerate(full.derived.actuator_places, start=1):
        apex = world(machine, standing[f"tip_{number}"], "apex").origin
        assert apex == pytest.approx((x, y, full.derived.tip_apex), abs=1e-9)


@pytest.mark.parametrize("name", [*MADE, *PURCHASED])
def test_exported_mesh_is_closed_and_of_the_solids_volume(machine: BuiltMachine, name: str) -> None:
    part = machine.parts[name]
    body = trimesh.load(io.BytesIO(part.entry.data(f"{name}.stl")), file_type="stl")
    assert body.is_watertight and body.volume == pytest.approx(part.geometry.volume, rel=3e-3)
    # The kernel's centre and inertia against those of the triangles.
    assert body.center_mass == pytest.approx(part.geometry.centre, abs=0.003 * body.scale)
    moments = np.array(part.geometry.second_moments)
    assert body.moment_inertia == pytest.approx(moments, abs=6e-3 * np.max(moments))


def test_bodies_and_their_inertia_are_sums_and_turn(machine: BuiltMachine, design: Design) -> None:
    masses, body = machine.masses, machine.moving_body
    parts = masses["stage"].mass + 4.0 * masses["tooth_iron"].mass + 2.0 * masses["magnet"].mass
    assert body.mass == pytest.approx(parts)
    volume = machine.parts["stage"].geometry.volume * 1e-9
    assert masses["stage"].mass == pytest.approx(volume * design.materials[design.stage.material].density)
    # Against a sum over the triangles of the meshes where they stand.
    total, moment = 0.0, np.zeros(3)
    for instance in machine.assembly.instances:
        if instance.part in ("stage", "tooth_iron", "magnet"):
            mesh = machine.parts[instance.part].mesh.placed(instance.frame)
            triangles = trimesh.Trimesh(mesh.vertices, mesh.triangles)
            weight = masses[instance.part].mass
            total += weight
            moment += weight * triangles.center_mass / 1000.0
    assert body.centre_of_mass == pytest.approx(moment / total, abs=2e-5)
    own = machine.masses["tip"]
    angle = 0.7
    c, s = math.cos(angle), math.sin(angle)
    turned = placed(own, Frame(((c, -s, 0.0), (s, c, 0.0), (0.0, 0.0, 1.0)), (5.0, 6.0, 7.0)))
    rotation = np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])
    assert np.array(turned.inertia) == pytest.approx(rotation @ np.array(own.inertia) @ rotation.T, rel=1e-12)
    expected = add(tuple(rotation @ np.array(own.centre_of_mass)), (5e-3, 6e-3, 7e-3))
    assert turned.centre_of_mass == pytest.approx(expected)


def test_measures_on_the_parts_are_the_designs(machine: BuiltMachine, design: Design) -> None:
    measures = {name: one["value"] for name, one in documents(machine)["measures"].items()}
    assert measures["piezo_spacing"] == pytest.approx(design.si("actuator.piezo_spacing"))
    assert measures["tip_height"] == pytest.approx(design.si("actuator.tip_height"))
    assert measures["bolt_spacing"] == pytest.approx(design.si("bearing_way.bolt_spacing"))
    assert [measures[f"way_{size}"] for size in ("length", "width", "height")] == pytest.approx([0.28, 0.08, 0.0254])
    # The crown's rim is not a sharp corner, so the measured face is a little smaller than the rectangle.
    pads = design.pads
    area = pads.count * (pads.length * pads.width - (4 - math.pi) * pads.corner_radius**2)
    assert measures["pad_area"] == pytest.approx(area * 1e-6, rel=0.02)


@pytest.mark.slow
def test_one_parameter_changes_its_part_and_the_numbers_and_nothing_else(machine, design, store, tmp_path) -> None:
    thicker = load_design(overrides=("stage.thickness=13 mm",))
    assert find_machine(thicker, ArtefactStore(tmp_path)) is None
    other = build_machine(thicker, store)
    touched = {name for name in machine.parts if other.parts[name].entry.key != machine.parts[name].entry.key}
    # The beam of the interferometer is at half the height of the stage.
    assert touched == {"stage", "interferometer", "mirror"}
    gain = other.moving_body.mass - machine.moving_body.mass
    plate = 0.230 * 0.270 * 0.001 * design.materials[design.stage.material].density
    assert gain == pytest.approx(plate, rel=0.03)
    assert find_machine(thicker, store).moving_body == other.moving_body


def stage_end(machine: BuiltMachine, iron: Instance, side: float) -> tuple[float, float]:
    """End of a tooth iron along the travel, and its middle across."""
    low, high = machine.parts["tooth_iron"].geometry.bounding_box
    corners = [iron.frame.point((x, y, 0.0)) for x in (low[0], high[0]) for y in (low[1], high[1])]
    return max(side * x for x, _, _ in corners) * side, sum(y for _, y, _ in corners) / 4


@pytest.mark.parametrize("overrides", [("end_stop.count=0",), ("teeth.fitted=false",)])
def test_without_buffers_or_irons_there_are_no_end_stops(overrides: tuple[str, ...]) -> None:
    assert not set(OF_END_STOPS) & set(part_names(load_design(overrides=overrides)))


@pytest.mark.slow
def test_a_design_without_teeth_has_none(store: ArtefactStore) -> None:
    machine = build_machine(load_design(overrides=("teeth.fitted=false",)), store)
    assert not {*OF_TEETH, *OF_END_STOPS} & set(count(machine.assembly.instances))


def test_masses_of_single_parts_equal_those_of_the_machine(design, store, machine, monkeypatch):
    monkeypatch.setenv("STAGECAD_CACHE", str(store.folder))
    found = body_masses(design)
    for one, other in ((found.moving, machine.moving_body), (found.tip, machine.masses["tip"])):
        for name in ("volume", "mass", "centre_of_mass", "inertia", "bounding_box"):
            np.testing.assert_allclose(getattr(one, name), getattr(other, name), rtol=1e-12, atol=1e-15)
