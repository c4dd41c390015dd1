"""The parts by name, and the module of each; importing this imports none of them."""

from __future__ import annotations

from collections.abc import Sequence
from importlib import import_module
from typing import Any, cast

from stagecad.parameters.errors import InputError, nearest
from stagecad.solids.modelling.part import PartModule

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
)
"""Parts that are made from a drawing."""

PURCHASED = ("piezo", "way_screw", "clamp_screw_long", "clamp_screw_short", "bar_screw", "set_screw", "spring")
"""Parts that are bought."""

ASSEMBLY = "assembly"

OF_TEETH = ("magnet", "tooth_iron", "tooth_bar", "bar_screw")
"""Parts that only a machine with magnetic teeth has."""


def part_names(design: Any) -> tuple[str, ...]:
    """Names of the parts that this design has, made ones first."""
    return tuple(name for name in (*MADE, *PURCHASED) if design.teeth.fitted or name not in OF_TEETH)


def module_name(name: str) -> str:
    """Dotted name of a part's module."""
    return f"stagecad.solids.{'purchased' if name in PURCHASED else 'parts'}.{name}"


def module_of(name: str) -> PartModule:
    """The part's module, imported."""
    return cast(PartModule, import_module(module_name(name)))


def chosen(names: Sequence[str], design: Any) -> tuple[str, ...]:
    """The parts a user named (`assembly` among them), or all of them when none is named.

    Raises:
        InputError: a name that is no part, with the nearest that is.
    """
    known = (*part_names(design), ASSEMBLY)
    for name in names:
        if name in OF_TEETH and name not in known:
            raise InputError(f"part '{name}': this design has no magnetic teeth; set teeth.fitted = true")
        if name not in known:
            raise InputError(f"no part '{name}'{nearest(name, known)}")
    return tuple(name for name in known if name in names) if names else known
