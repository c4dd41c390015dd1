"""Parts, assembly and intended contacts of the friction stage."""

from collections.abc import Mapping
from functools import partial
from importlib import import_module
from itertools import product
from typing import Any, cast

from stagecad.friction_stage.assembly import CARRIED, MOVING, accessories, assemble, documents, machine_masses, masses
from stagecad.friction_stage.parameters.derived import Derived
from stagecad.friction_stage.parts import Definition
from stagecad.friction_stage.purchased.catalogue import Purchased
from stagecad.solids.modelling.part import (
    CONTACT,
    DRIVE,
    FIT,
    GAP,
    SLIDING,
    THREAD,
    Construction,
    Instance,
    Part,
    PartSource,
    Position,
)

MADE = (
    "tip",
    "holder",
    "stage",
    "bearing_way",
    "base",
    "height_pin_1",
    "height_pin_2",
    "magnet",
    "tooth_iron",
    "tooth_bar",
    "stop_bar",
    "sensor_bracket",
)
"""Parts that are made from a drawing."""

CAP_SCREWS = {
    "way_screw": "screws.way",
    "clamp_screw_long": "screws.clamp_long",
    "clamp_screw_short": "screws.clamp_short",
    "bar_screw": "screws.bar",
    "stop_screw": "screws.stop",
}
"""Screws, with their tables in the parameter file."""
PURCHASED = ("piezo", *CAP_SCREWS, "set_screw", "spring", "buffer", "lead_clip", "interferometer", "mirror")
"""Parts that are bought."""

OF_TEETH = ("magnet", "tooth_iron", "tooth_bar", "bar_screw")
"""Parts of a machine with magnetic teeth only."""

OF_END_STOPS = ("stop_bar", "sensor_bracket", "stop_screw", "buffer", "interferometer", "mirror")
"""Parts of a machine with end stops only, which stop the tooth irons."""

FROM_BELOW = ("stage", "tip", "tooth_iron")
"""Parts with working faces on their underside: also shown from below."""

ENDS = (-1.0, 0.0, 1.0)

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


def module_name(name: str) -> str:
    """Dotted name of the module that defines a part."""
    folder = "parts" if name in MADE else "purchased"
    return f"stagecad.friction_stage.{folder}.{'screws' if name in CAP_SCREWS else name}"


def part_definition(name: str) -> Part:
    """The definition of a part: of its module, or of an entry in the `PARTS` of a module for several parts."""
    module = import_module(module_name(name))
    if name in MADE:
        return cast(Part, Definition(module, name))
    return cast(Part, Purchased(getattr(module, "PARTS", {}).get(name, module), CAP_SCREWS.get(name, name)))


def part_source(name: str) -> PartSource:
    """Where a part comes from."""
    kind = Definition if name in MADE else Purchased
    modules = (module_name(name), kind.__module__)
    return PartSource(name, name, modules, partial(part_definition, name), name in PURCHASED)


def sources(design: Any) -> Mapping[str, PartSource]:
    """The parts of a design."""
    left_out = () if design.teeth.fitted else OF_TEETH
    if not Derived(design).end_stops:
        left_out += OF_END_STOPS
    return {name: part_source(name) for name in (*MADE, *PURCHASED) if name not in left_out}


def refusal(name: str, design: Any) -> str:
    """Why a design lacks a part."""
    if name in OF_TEETH:
        return "this design has no magnetic teeth; set teeth.fitted = true"
    if name in OF_END_STOPS:
        return "this design has no end stops; they need teeth.fitted = true and buffers"
    return ""


def _assemble(parts: Mapping[str, Any], design: Any, position: Position) -> tuple[Instance, ...]:
    return assemble(parts, design, *position)


def _relations(design: Any) -> Mapping[frozenset[str], str]:
    return INTENDED


CONSTRUCTION = Construction(
    sources=sources,
    refusal=refusal,
    modules=("stagecad.friction_stage.assembly", "stagecad.friction_stage.purchased.spring", __name__),
    assemble=_assemble,
    masses=masses,
    machine_masses=machine_masses,
    documents=documents,
    positions=tuple(product(ENDS, ENDS)),
    relations=_relations,
    moving=MOVING,
    carried=CARRIED,
    below=FROM_BELOW,
    accessories=accessories,
)
