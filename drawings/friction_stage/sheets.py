"""Sheets of the friction stage: plans of its parts, views of the whole, procedure.

Scales of the thesis: tip and holder 1:1, stage 1:2, bearing way 1:4. The pins are drawn at 2:1. The base is on three
sheets at 1:2, as its holes cannot be read at the 1:5 and 0.35 of the thesis, with detail X at 1:1. Small parts that the
thesis does not draw have a standard scale. Where a view is too small for its dimensions, there is a section or detail
at a larger scale.
"""

import math
import string
from collections.abc import Callable, Sequence
from typing import Any

from drawings.friction_stage.procedure import ProcedureValues, figures_of, quantity, step_templates
from drawings.pictures.machine import MachineViews
from drawings.sheets.plans import PartUse, SheetPlan, Sheets, Step, ViewPlan
from drawings.views.view import Cut
from stagecad.friction_stage.assembly import CARRIED, MOVING
from stagecad.friction_stage.construction import CAP_SCREWS
from stagecad.friction_stage.parameters.derived import Derived
from stagecad.friction_stage.parts.base_clamp import clamps
from stagecad.parameters.dimension import Point
from stagecad.solids.assembly.bill_of_materials import Row


def sheet_plans(part: str, design: Any) -> tuple[SheetPlan, ...]:
    """The sheets of a part, in order; none for one without a plan."""
    return _PLANS[part](design) if part in _PLANS else ()


TOP = ViewPlan("top", "top")
FRONT = ViewPlan("front", "front", "top")
RIGHT = ViewPlan("right", "right", "front")
BOTTOM = ViewPlan("bottom", "bottom", "front")
LEFT = ViewPlan("left", "left", "front")
ISO = ViewPlan("iso", "iso")

_BASE_1 = (
    "length",
    "width",
    "height",
    "edge chamfer",
    "way ",
    "seat ",
    "hole chamfer",
    "setting-pin",
    "pocket",
    "lead channel",
    "left side",
    "lifting",
    "bracket",
    "tooth bar",
)
"""Declarations of the base's first sheet."""


def _section(letter: str, projection: str, at: Point, aligned_with: str, scale: float | None = None) -> ViewPlan:
    normals = {"front": (0.0, -1.0, 0.0), "right": (1.0, 0.0, 0.0), "top": (0.0, 0.0, 1.0), "left": (-1.0, 0.0, 0.0)}
    return ViewPlan(
        f"section {letter}-{letter}", projection, aligned_with, cut=Cut(at, normals[projection], letter), scale=scale
    )


def _detail(letter: str, projection: str, at: Point, radius: float, scale: float) -> ViewPlan:
    return ViewPlan(f"detail {letter}", projection, detail=(at, radius), letter=letter, scale=scale)


def _stage(design: Any) -> tuple[SheetPlan, ...]:
    sea, (_, y) = design.sea, Derived(design).pad_places[0]
    reach = design.pads.width / 2 + 3.0
    edge = sea.width / 2 + sea.groove_width / 2
    groove = _detail("Y", "right", (0.0, edge, 0.0), 2.0 * max(sea.groove_width, sea.groove_depth), 5.0)
    grooves = () if sea.whole_underside else (groove,)
    views = (
        ViewPlan("top", "top", symmetry="uv"),
        _section("A", "right", (0.0, 0.0, 0.0), "front"),
        FRONT,
        RIGHT,
        ViewPlan("bottom", "bottom", "front", symmetry="uv"),
        _detail("X", "right", (0.0, y, -design.pads.height / 2), reach, 2.0),
        *grooves,
        ViewPlan("iso", "iso", scale=0.25),
    )
    return (SheetPlan("stage", ("A2", "A1"), 0.5, views),)


def _bearing_way(design: Any) -> tuple[SheetPlan, ...]:
    way = design.bearing_way
    first = -(way.bolt_count - 1) / 2 * way.bolt_spacing
    views = (ViewPlan("top", "top", symmetry="v"), FRONT, _section("A", "right", (first, 0.0, 0.0), "front", 1.0), ISO)
    return (SheetPlan("bearing_way", ("A3", "A2"), 0.25, views),)


def _base(design: Any) -> tuple[SheetPlan, ...]:
    base = design.base
    first, *_ = clamps(design)
    top = ViewPlan("top", "top", symmetry="uv")
    one = SheetPlan("base_1", ("A1",), 0.5, (top, FRONT, RIGHT, LEFT, ViewPlan("iso", "iso", scale=0.2)), _BASE_1)
    # From the axis of the pocket to beyond the far corner of the slot of the lug.
    finger = (*first.place(first.slot / 2, base.clamp_reach / 2), 0.0)
    reach = math.hypot(first.slot, base.clamp_reach) / 2 + 10.0
    two = SheetPlan(
        "base_2",
        ("A1",),
        0.5,
        (
            ViewPlan("top", "top", symmetry="u"),
            ViewPlan("right", "right", "top"),
            ViewPlan("left", "left", "top"),
            _section("A", "top", (0.0, 0.0, -base.clamp_screw_depth), ""),
            _detail("X", "top", finger, reach, 1.0),
        ),
        ("clamp",),
    )
    three = SheetPlan(
        "base_3",
        ("A1",),
        0.5,
        (
            top,
            _section("A", "front", (0.0, 0.0, 0.0), "top"),
            ViewPlan("bottom", "bottom", "section A-A", symmetry="uv"),
        ),
    )
    return (one, two, three)


_MAIN = ViewPlan("front", "front")


def _small_views(picture: float, front: ViewPlan = _MAIN) -> tuple[ViewPlan, ...]:
    """Views of a part that is drawn enlarged, with the scale of its picture."""
    return (front, ViewPlan("top", "top", "front"), RIGHT, ViewPlan("iso", "iso", scale=picture))


_PIN_VIEWS = _small_views(1.0, ViewPlan("front", "front", hidden=True, symmetry="v"))


def _one(part: str, scale: float, *views: ViewPlan) -> Callable[[Any], tuple[SheetPlan, ...]]:
    """One sheet whose views do not depend on the design."""
    return lambda design: (SheetPlan(part, ("A3", "A2"), scale, views),)


_THROUGH = _section("A", "right", (0.0, 0.0, 0.0), "front")
_PLANS: dict[str, Callable[[Any], tuple[SheetPlan, ...]]] = {
    "tip": _one("tip", 1.0, TOP, FRONT, BOTTOM, _THROUGH, ISO),
    "holder": _one("holder", 1.0, TOP, FRONT, _THROUGH, ViewPlan("back", "back", "front"), ISO),
    "stage": _stage,
    "bearing_way": _bearing_way,
    "base": _base,
    "height_pin_1": _one("height_pin_1", 2.0, *_PIN_VIEWS),
    "height_pin_2": _one("height_pin_2", 2.0, *_PIN_VIEWS),
    "magnet": _one("magnet", 5.0, *_small_views(2.0)),
    "tooth_iron": _one("tooth_iron", 5.0, *_small_views(2.0)),
    "tooth_bar": _one(
        "tooth_bar",
        0.5,
        ViewPlan("top", "top", symmetry="uv"),
        FRONT,
        _section("A", "right", (0.0, 0.0, 0.0), "front", 2.0),
        ISO,
    ),
    "stop_bar": _one("stop_bar", 1.0, TOP, FRONT, RIGHT, _section("A", "right", (0.0, 0.0, 0.0), ""), ISO),
    "sensor_bracket": _one("sensor_bracket", 1.0, TOP, FRONT, RIGHT, ISO),
}


def procedure(design: Any, rows: Sequence[Row], values: ProcedureValues) -> tuple[Step, ...]:
    """The assembly procedure of a design."""
    figures = figures_of(design, rows, values)
    listed = {row.part: row for row in rows}
    steps = []
    for place, step in enumerate(step_templates(design, values), start=1):
        used = {
            name: figures[name]
            for text in (*step["tools"], *step["sentences"], f"{{{step['torque']}}}")
            for _, name, _, _ in string.Formatter().parse(text)
            if name
        }
        shown = {name: figure.text for name, figure in used.items()}
        sentences, tools = (tuple(text.format(**shown) for text in step[kind]) for kind in ("sentences", "tools"))
        put_in = (quantity(part, listed, design) for part in step["parts"])
        torque = figures[step["torque"]] if step["torque"] else None
        parts = tuple(PartUse(row.item, row.part, row.part_number, number) for row, number in put_in)
        steps.append(Step(place, step["title"], sentences, parts, tools, torque, used))
    return tuple(steps)


ALONG = Cut((0.0, 0.0, 0.0), (0.0, -1.0, 0.0), "A")
ACROSS = Cut((0.0, 0.0, 0.0), (1.0, 0.0, 0.0), "B")
"""Through the axis of actuator 1 along the travel; and across it, through ways, a pad, teeth and bars."""
NOT_CUT = (*CAP_SCREWS, "set_screw", "height_pin_1", "height_pin_2", "piezo", "spring", "interferometer")
"""Parts that a section shows whole."""

VIEWS = MachineViews(
    {"section A-A": (ALONG, "front"), "section B-B": (ACROSS, "right")},
    NOT_CUT,
    MOVING,
    CARRIED,
    notes=(
        "- Shown at the middle of travel and of height adjustment.",
        "- Order, torques and settings: see the procedure.",
        "- Fasteners, pins, piezos, spring and interferometer are not cut.",
    ),
)


SHEETS = Sheets(
    plans=sheet_plans,
    # Titles of the thesis.
    titles={"tip": "actuator tip", "holder": "piezo holder"},
    views=lambda design, instances, parts: VIEWS,
    procedure=lambda design, rows, values: procedure(design, rows, ProcedureValues(**values)),
    travel=lambda design: design.stage.travel,
    modules=(__name__,),
)
