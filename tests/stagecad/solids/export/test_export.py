"""Exported files: the same bytes every time, the same body to programs that are not ours, and its picture."""

import io
import json
import os
import re
import struct
import subprocess
import sys
from pathlib import Path

import cadquery as cq
import numpy as np
import pytest
import trimesh
from PIL import Image

from stagecad.solids.export.mesh import LINEAR, Mesh, glb_bytes, mesh_of, stl_bytes, triangulated
from stagecad.solids.export.render import picture
from stagecad.solids.export.step import PRESENTATION, ordered_styles, step_bytes
from stagecad.solids.modelling.frame import IDENTITY, Frame, PlacedShape
from stagecad.solids.modelling.mass import geometry_of

GREY = (0.7, 0.7, 0.8)
TURNED = Frame(((0.0, -1.0, 0.0), (1.0, 0.0, 0.0), (0.0, 0.0, 1.0)), (10.0, 20.0, 50.0))


def bracket() -> cq.Solid:
    """A plate with round corners, counterbored holes and a ball's hollow: planes, cylinders, and a sphere."""
    plate = cq.Workplane().box(60, 40, 12).edges("|Z").fillet(5)
    plate = plate.faces(">Z").workplane().rarray(30, 20, 2, 2).cboreHole(5.5, 10, 5)
    return plate.cut(cq.Workplane().sphere(8).translate((0, 0, 8))).solids().val()  # type: ignore[return-value]


@pytest.fixture(scope="module")
def solid() -> cq.Solid:
    return bracket()


@pytest.fixture(scope="module")
def mesh(solid: cq.Solid) -> Mesh:
    return mesh_of(solid, solid.Volume())


def pair() -> list[PlacedShape]:
    return [PlacedShape("one", "bracket", GREY), PlacedShape("two", "bracket", GREY, TURNED)]


def test_step_repeats_to_the_byte_in_one_process(solid: cq.Solid) -> None:
    shapes = {"bracket": solid.wrapped}
    for name, pieces in (("bracket", [PlacedShape("bracket", "bracket", GREY)]), ("pair", pair())):
        first = step_bytes(name, pieces, shapes)
        assert step_bytes(name, pieces, shapes) == first and f"PRODUCT('{name}','{name}'".encode() in first


def test_step_repeats_to_the_byte_in_another_process(solid: cq.Solid) -> None:
    here = step_bytes("pair", pair(), {"bracket": solid.wrapped})
    program = (
        "import sys; sys.path.insert(0, sys.argv[1]); import test_export as t; "
        "from stagecad.solids.export.step import *; "
        "sys.stdout.buffer.write(step_bytes('pair', t.pair(), {'bracket': t.bracket().wrapped}))"
    )
    run = subprocess.run(
        [sys.executable, "-c", program, str(Path(__file__).parent)], capture_output=True, check=True, timeout=120
    )
    assert run.stdout == here


def test_step_reads_back_as_the_same_bodies(solid: cq.Solid, tmp_path: Path) -> None:
    path = tmp_path / "pair.step"
    path.write_bytes(step_bytes("pair", pair(), {"bracket": solid.wrapped}))
    bodies = cq.importers.importStep(str(path)).solids().vals()
    assert len(bodies) == 2
    for body, shift in zip(bodies, ((0.0, 0.0, 0.0), TURNED.shift), strict=True):
        assert body.Volume() == pytest.approx(solid.Volume(), rel=1e-9)
        assert body.Center().z - solid.Center().z == pytest.approx(shift[2], abs=1e-7)
    box = bodies[1].BoundingBox()
    assert (box.xlen, box.ylen) == pytest.approx((40.0, 60.0), abs=1e-5)


def test_meshes_are_watertight_with_normals_and_sharp_edges(solid: cq.Solid, mesh: Mesh) -> None:
    body = trimesh.load(io.BytesIO(stl_bytes([mesh])), file_type="stl")
    assert body.is_watertight and body.is_winding_consistent
    assert body.volume == pytest.approx(solid.Volume(), rel=3e-3)
    assert mesh.volume == pytest.approx(body.volume, rel=1e-5)
    a, b, c = (mesh.vertices[mesh.triangles[:, i]] for i in range(3))
    face = np.cross(b - a, c - a)
    assert np.all(np.einsum("ij,ij->i", face, mesh.normals[mesh.triangles[:, 0]]) > 0.0)
    flat = np.abs(face[:, 2]) > 0.999 * np.linalg.norm(face, axis=1)
    assert np.all(np.abs(mesh.normals[mesh.triangles[flat]][..., 2]) > 0.999)
    box = cq.Workplane().box(10, 10, 10).edges("|Z").fillet(2).solids().val()
    outline = mesh_of(box, box.Volume())
    # Two rims of 4 lines and 4 arcs; where fillet and side run into each other there is nothing to see.
    assert len(outline.edge_ends) - 1 == 16


def test_glb_is_metres_y_up_and_not_metallic(solid: cq.Solid, mesh: Mesh) -> None:
    data = glb_bytes("pair", pair(), {"bracket": mesh})
    document = json.loads(data[20 : 20 + struct.unpack_from("<I", data, 12)[0]])
    for material in document["materials"]:
        assert material["pbrMetallicRoughness"]["metallicFactor"] == 0.0
        assert material["pbrMetallicRoughness"]["roughnessFactor"] == 0.7
    scene = trimesh.load(io.BytesIO(data), file_type="glb")
    assert sorted(name for name in scene.graph.nodes_geometry) == ["one", "two"]
    # Height 12 mm about z = 0, and 50 mm higher: along y of the file, in metres.
    assert scene.bounds[:, 1] == pytest.approx([-0.006, 0.056], abs=1e-6)
    assert sum(body.volume for body in scene.dump()) == pytest.approx(2e-9 * solid.Volume(), rel=3e-3)


def test_geometry_against_closed_forms() -> None:
    geometry = geometry_of(cq.Workplane().box(30, 20, 10).translate((100, -50, 25)).solids().val())
    volume = 30.0 * 20.0 * 10.0
    assert geometry.volume == pytest.approx(volume, rel=1e-12)
    assert geometry.centre == pytest.approx((100.0, -50.0, 25.0), rel=1e-12)
    expected = np.diag([20**2 + 10**2, 30**2 + 10**2, 30**2 + 20**2]) * volume / 12.0
    assert np.array(geometry.second_moments) == pytest.approx(expected, rel=1e-9, abs=1e-6 * volume)
    low, high = geometry_of(cq.Workplane().sphere(7).solids().val()).bounding_box
    assert (*low, *high) == pytest.approx((-7, -7, -7, 7, 7, 7), abs=1e-6)


def test_bent_wires_and_meshing_leave_boxes_exact(solid: cq.Solid) -> None:
    before = geometry_of(solid)
    mesh_of(solid, solid.Volume())
    assert geometry_of(solid) == before
    ring = cq.Solid.makeTorus(8.0, 1.0)
    for angular in (0.2, 0.17):
        mesh = triangulated(ring, LINEAR, angular)
        assert 1.0 - mesh.volume / ring.Volume() == pytest.approx(angular**2 / 12.0, rel=0.1)


HEAD = "ISO-10303-21;\nDATA;\n#1 = SHAPE('one');\n#2 = SHAPE('two');\n#3 = CONTEXT();\n#4 = CONTEXT();\n"
TAIL = "ENDSEC;\nEND-ISO-10303-21;\n"
ONE_FIRST = f"""#5 = {PRESENTATION}('',(
    #6),#3);
#6 = STYLED_ITEM('color',(#7),#1);
#7 = COLOUR_RGB('',0.1,0.2,0.3);
#8 = {PRESENTATION}('',(#9),#4);
#9 = STYLED_ITEM('color',(#7),#2);
"""
TWO_FIRST = f"""#5 = {PRESENTATION}('',(#6),#4);
#6 = STYLED_ITEM('color',(#7),#2);
#7 = COLOUR_RGB('',0.1,0.2,0.3);
#8 = {PRESENTATION}('',(
    #9),#3);
#9 = STYLED_ITEM('color',(#7),#1);
"""


def test_colours_of_step_files() -> None:
    one, two = (ordered_styles(HEAD + styles + TAIL) for styles in (ONE_FIRST, TWO_FIRST))
    assert one == two and one == HEAD + re.sub(r"\n\s+", "", ONE_FIRST) + TAIL
    assert ordered_styles(HEAD + TAIL) == HEAD + TAIL


def test_a_mesh_that_misses_the_volume_is_for_pictures_only() -> None:
    solid = cq.Workplane().box(30, 20, 10).val()
    stated = 1.02 * 30 * 20 * 10
    assert mesh_of(solid, stated, exported=False).volume == pytest.approx(30 * 20 * 10)
    with pytest.raises(ValueError, match="misses the solid's volume"):
        mesh_of(solid, stated)


RED, BLUE = (0.9, 0.1, 0.1), (0.1, 0.1, 0.9)
FRONT = (0.0, -1.0, 1e-6)


@pytest.fixture(scope="module")
def cube() -> Mesh:
    solid = cq.Workplane().box(10, 10, 10).val()
    return mesh_of(solid, 1000.0)  # type: ignore[arg-type]


def pixels(data: bytes) -> np.ndarray:
    return np.asarray(Image.open(io.BytesIO(data))).astype(int)


def area(image: np.ndarray, channel: int) -> int:
    """Pixels in which one colour channel stands out."""
    others = [index for index in range(3) if index != channel]
    return int(np.sum(image[..., channel] > 40 + image[..., others].max(axis=-1)))


def test_pictures_are_filled_and_hide_what_is_behind(cube: Mesh) -> None:
    image = pixels(picture([PlacedShape("cube", "cube", RED)], {"cube": cube}, FRONT, (300, 200)))
    assert image.shape == (200, 300, 3)
    rows, columns = np.nonzero(np.abs(image - image[0, 0]).max(axis=-1) > 60)
    # The cube is a square of 88 % of the height in the middle.
    assert (rows.min(), rows.max()) == pytest.approx((12, 187), abs=2)
    assert (columns.min(), columns.max()) == pytest.approx((62, 237), abs=2)
    behind = Frame(IDENTITY, (0.0, 30.0, 0.0))
    front = [PlacedShape("near", "cube", RED), PlacedShape("far", "cube", BLUE, behind)]
    image = pixels(picture(front, {"cube": cube}, FRONT, (200, 200)))
    assert area(image, 0) > 20_000 and area(image, 2) == 0
    image = pixels(picture(front, {"cube": cube}, (0.0, 1.0, 1e-6), (200, 200)))
    assert area(image, 0) == 0 and area(image, 2) > 20_000
    image = pixels(picture([PlacedShape("cube", "cube", RED)], {"cube": cube}, (1.0, -1.0, 0.8), (400, 400)))
    dark = image.max(axis=-1) < 110
    # From a corner nine edges show; the three that meet behind would cross at the middle of the outline.
    assert np.sum(dark) > 400
    rows, columns = np.nonzero(np.abs(image - image[0, 0]).max(axis=-1) > 60)
    middle = (rows.min() + rows.max()) // 2, (columns.min() + columns.max()) // 2
    assert np.all(image[middle[0] + 30 : middle[0] + 60, middle[1] - 60 : middle[1] - 30].max(axis=-1) > 110)
    # A small cube before a large one: what lies behind its contour is darkened near it.
    large = Mesh(**{**vars(cube), "vertices": 4.0 * cube.vertices, "edge_points": 4.0 * cube.edge_points})
    shapes = [PlacedShape("far", "large", BLUE), PlacedShape("near", "cube", RED, Frame(IDENTITY, (0.0, -60.0, 0.0)))]
    image = pixels(picture(shapes, {"cube": cube, "large": large}, FRONT, (400, 400)))
    near = np.nonzero(image[..., 0] > 40 + image[..., 2])
    middle, edge = int(np.median(near[0])), int(near[1].max())
    beside, away = image[middle, edge + 4], image[middle, edge + 60]
    assert beside.sum() < away.sum() - 20
    assert np.all(image[2] == image[2, 0]) and image[2, 0].min() > 230


@pytest.mark.slow
def test_works_without_a_display_and_repeats(cube: Mesh) -> None:
    program = """
import sys, cadquery as cq
from stagecad.solids.modelling.frame import PlacedShape
from stagecad.solids.export.mesh import mesh_of
from stagecad.solids.export.render import picture
mesh = mesh_of(cq.Workplane().box(10, 10, 10).val(), 1000.0)
sys.stdout.buffer.write(picture([PlacedShape("cube", "cube", (0.9, 0.1, 0.1))], {"cube": mesh}, size=(120, 100)))
"""
    bare = {key: value for key, value in os.environ.items() if key not in ("DISPLAY", "WAYLAND_DISPLAY")}
    run = subprocess.run([sys.executable, "-c", program], capture_output=True, env=bare, check=True, timeout=240)
    here = picture([PlacedShape("cube", "cube", RED)], {"cube": cube}, size=(120, 100))
    assert np.abs(pixels(run.stdout) - pixels(here)).max() == 0
