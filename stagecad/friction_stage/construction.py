"""Parts, assembly and intended contacts of the friction stage."""

import tomllib
from collections.abc import Mapping
from functools import partial
from importlib import import_module
from itertools import product
from pathlib import Path
from typing import Any, cast

from stagecad.friction_stage.assembly import CARRIED, MOVING, accessories, assemble, documents, machine_masses, masses
from stagecad.friction_stage.parameters.derived import Derived
from stagecad.friction_stage.parts import Definition
from stagecad.friction_stage.purchased import Purchased
from stagecad.solids.modelling.part import Construction, Instance, Part, PartSource, Position

_STATED = tomllib.loads(Path(__file__).with_suffix(".toml").read_text("utf-8"))
MADE, OF_TEETH, OF_END_STOPS, FROM_BELOW = (
    tuple(_STATED["parts"][kind]) for kind in ("made", "of_teeth", "of_end_stops", "from_below")
)
"""Parts that are made from a drawing, that only a machine with magnetic teeth or with end stops (which stop the tooth
irons) has, and that are also shown from below."""
PURCHASED = tuple(_STATED["purchased"])
"""Parts that are bought."""
CAP_SCREWS: dict[str, str] = _STATED["cap_screws"]
"""Screws, with their tables in the parameter file."""

ENDS = (-1.0, 0.0, 1.0)

INTENDED: dict[frozenset[str], str] = {
    frozenset(pair.split()): kind for kind, pairs in _STATED["intended"].items() for pair in pairs
}
"""Intended relation of two kinds of part."""


def module_name(name: str) -> str:
    """Dotted name of the module that defines a part."""
    place = f"parts.{name}" if name in MADE else f"purchased.{_STATED['purchased'][name]}"
    return f"stagecad.friction_stage.{place}"


def part_definition(name: str) -> Part:
    """The definition of a part: of its module, or of an entry in the `PARTS` of a module for several parts."""
    module = import_module(module_name(name))
    if name in MADE:
        return cast(Part, Definition(module, name))
    return cast(Part, Purchased(getattr(module, "PARTS", {}).get(name, module), CAP_SCREWS.get(name, name)))


def part_source(name: str) -> PartSource:
    """Where a part comes from."""
    modules = (module_name(name), (Definition if name in MADE else Purchased).__module__)
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
    modules=("stagecad.friction_stage.assembly", "stagecad.friction_stage.purchased.simple", __name__),
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
