"""The friction stage of the thesis: what it states of itself for the tool."""

import tomllib
from pathlib import Path

from stagecad.friction_stage.design import Design
from stagecad.friction_stage.parameters.derived import COMPUTED, Tables
from stagecad.friction_stage.parameters.physics import Material
from stagecad.friction_stage.parameters.ranges import kinds, with_range
from stagecad.parameters.machine import Machine

_RULES = ("sliding", "height", "holes", "making", "stops", "teeth", "values")
_OWNERS = tomllib.loads(Path(__file__).with_name("construction.toml").read_text("utf-8"))["owners"]

MACHINE = Machine(
    name="friction_stage",
    tables=Tables,
    material=Material,
    design=Design,
    computed=COMPUTED,
    bounded=with_range,
    kinds=kinds,
    rules=tuple(f"{__name__}.rules.{module}" for module in _RULES),
    owners={table: tuple(parts) for table, parts in _OWNERS.items()},
    file=Path(__file__).parent / "parameters" / "thesis.toml",
)
