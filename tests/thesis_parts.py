"""The design of the thesis and the solids of its parts, each read and built once in a process."""

from functools import cache

import cadquery as cq

from stagecad.friction_stage.construction import part_definition
from stagecad.parameters.design import Design
from stagecad.parameters.load import load_design


@cache
def thesis() -> Design:
    return load_design()


@cache
def solid_of(name: str) -> cq.Solid:
    return part_definition(name).build(thesis())  # type: ignore[return-value]
