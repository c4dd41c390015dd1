"""The steps of the assembly as templates, whose sentences name their figures in braces, and the figures.

The file `procedure.toml` has the steps, and the figures that are parameters or calculated values as they are."""

import math
import tomllib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from pathlib import Path
from typing import Any

from drawings.sheets.plans import CALCULATED, Figure
from stagecad.declared.standard_part import standard_part
from stagecad.friction_stage.assembly import accessories
from stagecad.friction_stage.construction import part_definition
from stagecad.friction_stage.parameters.derived import Derived
from stagecad.parameters.threads import thread as thread_of
from stagecad.solids.assembly.bill_of_materials import Row


@dataclass(frozen=True)
class ProcedureValues:
    """Calculated values of the procedure; SI."""

    # way_preload, bar_preload, clamp_force: axial force of one screw at its torque, N
    way_preload: float
    bar_preload: float
    clamp_force: float
    magnet_pull: float | None  # force of all magnets on the stage, N; None without teeth
    # lift_per_turn, lift_per_degree: height of the tip per turn and per degree of the set screw, m
    lift_per_turn: float
    lift_per_degree: float
    adjustment: float  # range of the height on either side of the middle, m
    ellipse_height: float  # height of the path of the tip, m
    clamp_squeeze: float  # rise of the tip by elastic compression of the holder, m
    # clamp_drop, clamp_sideways: greatest shift of the tip downwards and sideways by tilt of the holder, m
    clamp_drop: float
    clamp_sideways: float
    run_in_distance: float  # sliding distance of a pad, m
    run_in_time: float  # at full speed, s
    run_in_wear: float  # wear depth of the film, m
    film_strokes: float  # number of strokes there and back that wear half of the film


_DATA = tomllib.loads(Path(__file__).with_suffix(".toml").read_text("utf-8"))
"""Figures and steps."""


def figures_of(design: Any, rows: Sequence[Row], values: ProcedureValues) -> dict[str, Figure]:
    """All figures by name; those of the magnets only in a design with teeth."""
    figures = {name: _of_parameter(design, key) for name, key in _DATA["parameters"].items()}
    for name, (unit, digits) in _DATA["calculated"].items():
        value = getattr(values, name)
        if value is not None:
            figures[name] = Figure(_quantity(value, unit, digits), CALCULATED)
    for name, (part, dimension) in _DATA["counts"].items():
        declared = {d.name: d for d in part_definition(part).dimensions(design)}
        figures[name] = Figure(str(declared[dimension].count), f"{part}: {dimension}")
    figures |= {name: Figure(thread_of(thread).designation, "threads") for name, thread in _DATA["threads"].items()}
    for one in (one for one in accessories(design) if one.name == "screw of mirror and interferometer"):
        key = standard_part(one.specification.replace(" - ", " ").replace(" x ", "x")).row["socket"]
        figures["sensor_screws"] = Figure(f"{one.quantity} screws {one.specification}", "list of parts")
        figures["sensor_key"] = Figure(f"{key:g} mm", "list of parts")
    base = next(row for row in rows if row.part == "base")
    play = design.base.pocket_diameter - design.holder.diameter
    proud = design.holder.floor + design.piezo.length - design.holder.height
    engaged = design.screws.way.length - design.bearing_way.flange_thickness
    half_ellipse = values.ellipse_height / 2
    shim_angle, ellipse_angle = (
        height / values.lift_per_degree for height in (design.si("shim.thinnest"), half_ellipse)
    )
    return figures | {
        "base_mass": Figure(f"{base.mass:.0f} kg", "list of parts"),
        "way_engagement": Figure(f"{engaged:.1f} mm", "screws.way.length, bearing_way.flange_thickness"),
        "piezo_proud": Figure(f"{proud:.2f} mm", "holder.floor, piezo.length, holder.height"),
        "play": Figure(f"{play:.2f} mm", "base.pocket_diameter, holder.diameter"),
        "half_range_turns": Figure(f"{values.adjustment / values.lift_per_turn:.1f}", CALCULATED),
        "shim_angle": Figure(f"{shim_angle:.0f}°", CALCULATED),
        "half_ellipse": Figure(_quantity(half_ellipse, "m", 2), CALCULATED),
        "half_ellipse_angle": Figure(f"{ellipse_angle:.0f}°", CALCULATED),
        "run_in_time": Figure(f"{values.run_in_time / 3600:.1f} h", CALCULATED),
        "film_strokes": Figure(f"{values.film_strokes:.0f}", CALCULATED),
    }


def _of_parameter(design: Any, key: str) -> Figure:
    entry = design.entry(key)
    match entry.value, entry.unit:
        case str(text), _:
            return Figure(text, key)
        case value, "mm":
            return Figure(_inches(entry.text) or f"{value:g} mm", key)
        case value, "rad":
            return Figure(f"{math.degrees(value):g}°", key)
    return Figure(_quantity(design.si(key), entry.unit, 4), key)


def _quantity(value: float, unit: str, digits: int) -> str:
    """A quantity for the workshop: lengths below a millimetre in µm, no powers of ten."""
    if unit == "m":
        value, unit = (
            (value * 1e6, "µm") if abs(value) < 1e-3 else (value, "m") if abs(value) >= 1 else (value * 1e3, "mm")
        )
    elif unit == "N" and abs(value) >= 1e3:
        value, unit = value / 1e3, "kN"
    elif unit == "m/s":
        value, unit = value * 1e3, "mm/s"
    rounded = float(f"{value:.{digits}g}")
    shown = f"{rounded:.0f}" if abs(rounded) >= 10 ** (digits - 1) else f"{rounded:g}"
    return f"{shown} {unit.replace('*', '·')}".strip()


def _inches(text: str) -> str:
    """A size in inches by which the tool is named, `5/16 in`; empty for any other unit."""
    number, _, unit = text.partition(" ")
    if unit != "in":
        return ""
    size = Fraction(number)
    return f"{size} in" if size.denominator <= 64 else f"{number} in ({float(size) * 25.4:.4f} mm)"


def quantity(text: str, listed: Mapping[str, Row], design: Any) -> tuple[Row, int]:
    """Row of a part that a step puts in, and how many of it: all, or one for each seat of the parts that it is on."""
    part, _, carrier = text.partition(" on ")
    seats = part_definition(carrier).datums(design) if carrier else {}
    number = sum(name.startswith(f"{part}_") for name in seats)
    return listed[part], number * listed[carrier].quantity if carrier else listed[part].quantity


def step_templates(design: Any, values: ProcedureValues) -> list[dict[str, Any]]:
    """The steps of a design in the order of assembly, as `procedure.toml` states them: `title`, `tools` and `sentences`
    with names of figures in braces, `parts` that are put in (`SCREW on PART` for those of its seats), and `torque`, the
    name of the figure of the screws where there is one."""
    teeth = "teeth" if design.teeth.fitted else "no teeth"
    film = "film lasts" if values.film_strokes >= design.bearing.run_in_cycles else "film wears out"
    hold = ("", teeth, film, *(("end stops",) if Derived(design).end_stops else ()))

    def texts(items: Sequence[str | dict[str, str]]) -> tuple[str, ...]:
        stated = [{"when": "", "text": item} if isinstance(item, str) else item for item in items]
        return tuple(item["text"] for item in stated if item["when"] in hold)

    steps = ({"parts": (), "tools": (), "torque": "", **step} for step in _DATA["step"] if step.get("when", "") in hold)
    return [{**step, "tools": texts(step["tools"]), "sentences": texts(step["sentences"])} for step in steps]
