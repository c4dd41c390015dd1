"""The parts by name, and the module that defines each; importing this module imports none of them."""

from __future__ import annotations

from collections.abc import Sequence
from importlib import import_module
from typing import Any, cast

from stagecad.friction_stage.parameters.derived import Derived
from stagecad.parameters.errors import InputError, nearest
from stagecad.solids.modelling.part import Part

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

CAP_SCREWS = ("way_screw", "clamp_screw_long", "clamp_screw_short", "bar_screw", "stop_screw")
PURCHASED = ("piezo", *CAP_SCREWS, "set_screw", "spring", "buffer", "lead_clip", "interferometer", "mirror")
"""Parts that are bought."""

ASSEMBLY = "assembly"

OF_TEETH = ("magnet", "tooth_iron", "tooth_bar", "bar_screw")
"""Parts of a machine with magnetic teeth only."""

OF_END_STOPS = ("stop_bar", "sensor_bracket", "stop_screw", "buffer", "interferometer", "mirror")
"""Parts of a machine with end stops only, which stop the tooth irons."""


def part_names(design: Any) -> tuple[str, ...]:
    """Names of the parts that this design has, made ones first."""
    left_out = () if design.teeth.fitted else OF_TEETH
    if not Derived(design).end_stops:
        left_out += OF_END_STOPS
    return tuple(name for name in (*MADE, *PURCHASED) if name not in left_out)


def module_name(name: str) -> str:
    """Dotted name of the module that defines a part."""
    if name in MADE:
        return f"stagecad.friction_stage.parts.{name}"
    return f"stagecad.friction_stage.purchased.{'screws' if name in CAP_SCREWS else name}"


def part_definition(name: str) -> Part:
    """The definition of a part: its module, or an entry in the `PARTS` of a module for several parts."""
    module = import_module(module_name(name))
    return cast(Part, getattr(module, "PARTS", {}).get(name, module))


def chosen(names: Sequence[str], design: Any) -> tuple[str, ...]:
    """The named parts (`assembly` possibly among them), or all parts when none is named.

    Raises:
        InputError: an unknown part; names the nearest.
    """
    known = (*part_names(design), ASSEMBLY)
    for name in names:
        if name in OF_TEETH and name not in known:
            raise InputError(f"part '{name}': this design has no magnetic teeth; set teeth.fitted = true")
        if name in OF_END_STOPS and name not in known:
            raise InputError(f"part '{name}': this design has no end stops; they need teeth.fitted = true and buffers")
        if name not in known:
            raise InputError(f"no part '{name}'{nearest(name, known)}")
    return tuple(name for name in known if name in names) if names else known
