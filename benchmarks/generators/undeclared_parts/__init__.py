"""Parts that nobody declared: shapes of the kind that CadQuery's public examples and tests show, written anew.

Each function gives a workplane without dimensions, for the proposal of dimensions (`benchmarks.part_sheets`).
"""

from benchmarks.generators.undeclared_parts import prismatic, published, turned

PARTS = {**turned.PARTS, **prismatic.PARTS, **published.PARTS}
