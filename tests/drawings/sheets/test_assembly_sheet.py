"""The assembly's sheet: a balloon for each row of the parts list, on what it names, and none over another."""

import math
import shutil
from collections.abc import Callable
from dataclasses import replace
from itertools import pairwise, product
from pathlib import Path

import pytest

from drawings.annotations.annotation import BALLOON, Balloon, LinearDimension, SectionMark
from drawings.annotations.primitives import SMALL_HEIGHT, Text
from drawings.draw_sheets import PICTURES, machine_size, stored_picture
from drawings.friction_stage.sheets import ACROSS, ALONG, NOT_CUT, VIEWS
from drawings.lint import lint
from drawings.pictures.machine import machine_picture
from drawings.pictures.picture import Picture, scene_of
from drawings.sheets.assembly import AssemblyDescription, assembly_sheet, spread, uncrossed
from drawings.sheets.frame import drawing_space
from drawings.sheets.sheet import Sheet
from drawings.views.segment_index import SegmentIndex, curve_points, enlarged, line_meets_box
from drawings.views.view import Cut, Segment, View, view_box
from stagecad.friction_stage.assembly import CARRIED, assemble
from stagecad.parameters.design import Design
from stagecad.solids.artefacts.store import ArtefactStore
from stagecad.solids.assembly.built_machine import BuiltMachine, shapes_of
from stagecad.solids.modelling.frame import transformed_box
from tests.process_state import python

ROOT = Path(__file__).parents[3]


@pytest.fixture(scope="module")
def shown(machine: BuiltMachine, design: Design) -> Callable[..., Picture]:
    """Makes a picture of the machine."""
    instances = machine.assembly.instances
    shapes = {name: shape.wrapped for name, shape in shapes_of(instances, machine.parts, design).items()}
    scene = scene_of(shapes, {name: part.mesh for name, part in machine.parts.items()})

    def make(name: str, *, exact: bool = True) -> Picture:
        picture = machine_picture(name, instances, scene, VIEWS, exact=exact)
        assert picture is not None
        return picture

    return make


@pytest.fixture(scope="module")
def pictures(machine: BuiltMachine, design: Design, store: ArtefactStore) -> dict[str, Picture]:
    """The exact pictures, drawn once for these tests and the commands."""
    found = {}
    for name in PICTURES["assembly"]:
        picture = stored_picture(store, name, assemble(machine.parts, design), machine.parts, design)
        assert picture is not None
        found[name] = picture
    return found


@pytest.fixture(scope="module")
def described(machine: BuiltMachine, design: Design) -> Callable[[str], AssemblyDescription]:
    """Describes the machine, drawn from one parameter."""
    size = machine_size(machine.assembly.instances, machine.parts, design)
    return lambda read: AssemblyDescription(machine.bill_of_materials, size, "1 kg", "0", (read,), carried=CARRIED)


@pytest.fixture(scope="module")
def sheet(described, design: Design, pictures: dict[str, Picture]) -> Sheet:
    return assembly_sheet(described("0"), design, pictures)


def middles_of_hatch(view: View) -> list[tuple[float, float]]:
    """The middle of each line of hatch."""
    ends = [(line.start, line.end) for line in view.curves["HATCH"] if isinstance(line, Segment)]
    return [((a[0] + b[0]) / 2, (a[1] + b[1]) / 2) for a, b in ends]


@pytest.mark.parametrize(("name", "cut"), [("section A-A", ALONG), ("section B-B", ACROSS)])
def test_every_part_that_the_plane_crosses_is_hatched(machine: BuiltMachine, pictures, name: str, cut: Cut) -> None:
    view = pictures[name].view
    middles = middles_of_hatch(view)
    crossed = 0
    for instance in machine.assembly.instances:
        box = transformed_box(instance.frame, machine.parts[instance.part].geometry.bounding_box)
        corners = list(product(*zip(*box, strict=True)))
        heights = [sum(n * (c - p) for n, c, p in zip(cut.normal, corner, cut.point)) for corner in corners]
        if instance.part in NOT_CUT or min(heights) > -1.0 or max(heights) < 1.0:
            continue
        crossed += 1
        seen = [map(view.projection.to_view, corners)]
        (u0, u1), (v0, v1) = ((min(ends), max(ends)) for ends in zip(*seen[0], strict=True))
        assert any(u0 < u < u1 and v0 < v < v1 for u, v in middles), instance.name
    assert crossed >= 8


def test_balloons_are_one_for_each_row_apart_and_point_at_drawn_lines(sheet: Sheet, machine: BuiltMachine) -> None:
    numbers = sorted(a.number for a in sheet.annotations if isinstance(a, Balloon))
    assert numbers == [row.item for row in machine.bill_of_materials]
    x0, y0, x1, y1 = drawing_space(sheet.paper)
    centres = [a.centre for a in sheet.annotations if isinstance(a, Balloon)]
    for i, one in enumerate(centres):
        assert x0 + BALLOON < one[0] < x1 - BALLOON and y0 + BALLOON < one[1] < y1 - BALLOON
        assert all(math.dist(one, other) > 2 * BALLOON for other in centres[i + 1 :])
    placed = [(sheet.view(a.view).to_paper(a.at), a.centre) for a in sheet.annotations if isinstance(a, Balloon)]
    for i, (end, centre) in enumerate(placed):
        for other_end, other in placed[:i]:
            assert not SegmentIndex([(*end, *centre)]).count_crossing((*other_end, *other))
            assert not line_meets_box((*end, *centre), enlarged((*other, *other), BALLOON / 2))
    for balloon in sheet.annotations:
        if isinstance(balloon, Balloon):
            (u, v) = balloon.at
            curves = sheet.view(balloon.view).curves["VISIBLE"]
            ends = [(c.start, c.end) for c in curves if isinstance(c, Segment)]
            near = [a for a, b in ends if math.dist(a, (u, v)) + math.dist(b, (u, v)) < math.dist(a, b) + 0.1]
            assert near or len(ends) < len(curves)


def test_balloons_are_exchanged_and_spread_in_their_order() -> None:
    """Three parts of equal height one behind the other, and one below: the nearest has the lowest balloon."""
    ends = [(60.0, 0.0), (20.0, 50.0), (30.0, 50.0), (40.0, 50.0)]
    centres = [(0.0, 0.0), (0.0, 50.0), (0.0, 63.0), (0.0, 76.0)]
    assert uncrossed(ends, centres) == [0, 1, 2, 3]
    assert uncrossed([ends[0], *reversed(ends[1:])], centres) == [0, 3, 2, 1] and uncrossed([], []) == []
    assert spread([1.0, 2.0, 30.0], 10.0, 0.0, 100.0) == [1.0, 11.0, 30.0]
    assert spread([90.0, 95.0, 99.0], 10.0, 0.0, 100.0) == [80.0, 90.0, 100.0]
    assert spread([], 10.0, 0.0, 1.0) == []


def test_the_sheet_is_legible_hatched_and_free_of_hits(sheet: Sheet) -> None:
    """The columns have widths that follow their contents: no text is reduced by more than a tenth."""
    words = [ink for ink in sheet.tables if isinstance(ink, Text)]
    assert min(ink.height for ink in words) > 0.9 * SMALL_HEIGHT
    section = sheet.view("section A-A")
    assert section.label == "A-A" and len(section.curves["HATCH"]) > 50
    assert any(type(a).__name__ == "SectionMark" for a in sheet.annotations)
    assert [str(hit) for hit in lint(sheet)] == []


def test_the_revision_table_is_between_title_block_and_parts_list(described, design: Design, pictures) -> None:
    earlier = replace(design, earlier=(("stage.length", "12 mm"),))
    later = assembly_sheet(described("stage.length"), earlier, pictures)
    assert later.title.revisions and [str(hit) for hit in lint(later)] == []


def test_the_list_says_what_the_bill_of_materials_says(sheet: Sheet, machine: BuiltMachine) -> None:
    words = [ink.text for ink in sheet.tables if isinstance(ink, Text)]
    for row in machine.bill_of_materials:
        assert row.part.replace("_", " ") in words and row.part_number in words and row.material in words
    quantities = [int(words[i + 1]) for i in range(6, len(words), 6)]
    assert sum(quantities) == sum(row.quantity for row in machine.bill_of_materials)


def test_the_section_across_the_travel_cuts_ways_bars_stage_and_base(sheet: Sheet, design: Design) -> None:
    """Hatch in each of them, where the parameters place them; a cutting line for each section."""
    middles = middles_of_hatch(sheet.view("section B-B"))
    way, top = design.bearing_way, design.bearing_way.height + design.pads.height
    gap, bar = design.base.way_gap / 2, design.teeth.bar_spacing / 2
    for side in (-1.0, 1.0):
        for low, high, floor, roof in (
            (gap, gap + way.width, 0.0, way.height),
            (bar - 12.0, bar + 12.0, 0.0, design.tooth_bar.height),
            (gap, gap + way.width, top, top + design.stage.thickness),
            (gap, gap + way.width, -design.base.height, 0.0),
        ):
            assert any(low < side * u < high and floor < v < roof for u, v in middles)
    assert {a.letter for a in sheet.annotations if isinstance(a, SectionMark)} == {"A", "B"}


def test_trail_lines_lead_from_each_screw_to_its_hole(sheet: Sheet, machine: BuiltMachine, pictures) -> None:
    """Upright, and on the screw's own axis; the tip below the stage is seen."""
    view = sheet.view("exploded")
    trails = [line for line in view.curves["CENTRE"] if isinstance(line, Segment)]
    shafts = [i.exploded.point((0.0, 0.0, 0.0)) for i in machine.assembly.instances if i.part == "way_screw"]
    apart = [view.projection.to_view(shaft)[0] for shaft in shafts]
    # The middle of a screw is that of its mesh.
    led = [any(max(abs(line.start[0] - u), abs(line.end[0] - u)) < 0.3 for line in trails) for u in apart]
    assert sum(led) >= len(shafts) - 2
    curves = [curve for part, curves in pictures["exploded"].pieces if part == "tip" for curve in curves]
    assert sum(math.dist(a, b) for curve in curves for a, b in pairwise(curve_points(curve, 1.0))) > 300.0


def test_size_and_travel_are_those_of_the_machine(sheet: Sheet, pictures: dict[str, Picture], design: Design) -> None:
    """The numbers against parameters, and against what the hidden-line algorithm gives of the machine."""
    said = {a.names[0]: (a.measured, a.text) for a in sheet.annotations if isinstance(a, LinearDimension)}
    # Half of the travel is on both sides.
    assert len(said) == sum(isinstance(a, LinearDimension) for a in sheet.annotations) - 1
    base, stage = design.base, design.stage
    bracket = (base.bracket_spacing_along / 2) + design.stop_bar.overhang + design.sensor_bracket.length
    long = base.length / 2 + bracket
    assert said["overall length"] == (pytest.approx(long, abs=1e-6), f"({long:.1f})")
    assert said["overall width"] == (pytest.approx(base.width, abs=1e-6), f"({base.width:.1f})")
    assert said["half of the travel"] == (pytest.approx(stage.travel / 2, abs=1e-6), f"({stage.travel / 2:.1f})")
    over = stage.length + stage.travel + design.mirror.thickness
    assert said["length over the ends of travel"] == (pytest.approx(over, abs=1e-6), f"({over:.1f})")
    _, v0, _, v1 = view_box(replace(pictures["section A-A"].view, scale=1.0)) or (0.0,) * 4
    assert said["overall height"] == (pytest.approx(v1 - v0, abs=1e-6), f"({v1 - v0:.1f})")
    u0, v0, u1, v1 = view_box(replace(pictures["top"].view, scale=1.0)) or (0.0,) * 4
    assert (u1 - u0, v1 - v0) == pytest.approx((long, base.width), abs=1e-6)


def test_the_stage_is_shown_at_the_ends_of_its_travel(sheet: Sheet, machine: BuiltMachine, design: Design) -> None:
    """Against the machine put together there."""
    drawn = sheet.view("section A-A").curves["PHANTOM"]
    for travel in (-1.0, 1.0):
        (stage,) = (piece for piece in assemble(machine.parts, design, travel=travel) if piece.part == "stage")
        (x0, _, z0), (x1, _, z1) = machine.parts["stage"].geometry.bounding_box
        mirror = design.mirror.thickness if travel < 0 else 0.0
        end = travel * mirror + travel * max(travel * stage.frame.point((x, 0.0, 0.0))[0] for x in (x0, x1))
        lines = [line for line in drawn if isinstance(line, Segment)]
        upright = [one for one in lines if (one.start[0], one.end[0]) == pytest.approx((end, end), abs=1e-6)]
        assert any(math.dist(line.start, line.end) <= z1 - z0 + 1e-6 for line in upright)


def test_a_view_that_does_not_fit_under_the_exploded_view_is_smaller_and_above_the_list(described, design, pictures):
    below, curves = pictures["from below"], {"VISIBLE": (Segment((0.0, 0.0), (0.0, 1400.0)),)}
    tall = replace(below, view=replace(below.view, curves=curves), pieces=())
    every = assembly_sheet(described("0"), design, {**pictures, "from below": tall}).views
    views = {view.name: view for view in every}
    assert views["from below"].scale == views["top"].scale / 2
    assert views["from below"].label == "FROM BELOW (1:4)"


@pytest.mark.slow
@pytest.mark.parametrize("name", ["exploded", "from below"])
def test_by_mesh_the_machine_looks_the_same(name: str, shown: Callable[..., Picture], pictures) -> None:
    """What is drawn when the exact algorithm hangs: the same box, and much the same length of lines of each part."""
    exact, meshed = pictures[name], shown(name, exact=False)
    assert view_box(meshed.view) == pytest.approx(view_box(exact.view), abs=0.1)
    lengths = [ink_by_part(one) for one in (exact, meshed)]
    assert lengths[1].keys() == lengths[0].keys()
    for part, length in lengths[0].items():
        # The shortest of the screws' lines, of a mesh or not, are a matter of chance.
        assert lengths[1][part] == pytest.approx(length, rel=0.15, abs=5.0), part


def ink_by_part(shown: Picture) -> dict[str, float]:
    """Length of all lines of each part, mm."""
    found: dict[str, float] = {}
    for part, lines in shown.pieces:
        length = sum(math.dist(a, b) for curve in lines for a, b in pairwise(curve_points(curve)))
        found[part] = found.get(part, 0.0) + length
    return found


DRAW = """
import sys
from pathlib import Path
from drawings.draw_sheets import build_sheets
from stagecad.parameters.load import load_design
from stagecad.solids.artefacts.store import ArtefactStore
build_sheets(ArtefactStore(Path(sys.argv[1])), "assembly", load_design())
"""


@pytest.mark.slow
def test_another_process_draws_the_same_bytes(machine: BuiltMachine, tmp_path: Path) -> None:
    files = []
    for seed in ("1", "2"):
        store = tmp_path / seed
        entries = store / "entries"
        entries.mkdir(parents=True)
        for part in machine.parts.values():
            shutil.copytree(part.entry.folder, entries / part.entry.folder.name)
        shutil.copytree(machine.assembly.entry.folder.parent.parent / "reads", store / "reads")
        python("-c", DRAW, store, folder=ROOT, PYTHONHASHSEED=seed)
        (made,) = (path.parent for path in entries.glob("*/assembly.dxf"))
        files.append({kind: (made / f"assembly.{kind}").read_bytes() for kind in ("dxf", "svg", "pdf", "png")})
    assert files[0] == files[1]
