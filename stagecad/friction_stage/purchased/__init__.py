"""Purchased parts as clean simplified solids: outer dimensions true, threads cosmetic.

Their numbers and descriptions are those of the catalogue, void where a size is not the catalogue's.
"""

from typing import Any

from stagecad.friction_stage.parts import Definition
from stagecad.parameters.design import Design
from stagecad.parameters.dimension import Dimension
from stagecad.parameters.load import load_design


class Purchased(Definition):
    """A part that is bought; it has no dimensions."""

    def dimensions(self, design: Any) -> tuple[Dimension, ...]:
        return ()

    def part_number(self, design: Any) -> str:
        """Number in the catalogue; the sizes in its place where the packaged number stands beside other sizes."""
        sizes = _changed(design, self.table)
        return f"{', '.join(sizes)}: no catalogue number" if sizes else str(design.value(f"{self.table}.part_number"))

    def description(self, design: Any) -> str:
        """Description, without the sizes where they are not those of the catalogue."""
        words = str(design.value(f"{self.table}.description"))
        return words.partition(" x ")[0] if _changed(design, self.table) else words


def _changed(design: Design, table: str) -> list[str]:
    """Sizes that differ from those of the packaged number: `length 205 mm`."""
    packaged = load_design()
    number = f"{table}.part_number"
    if design.value(number) != packaged.value(number):
        return []
    found = []
    for entry in packaged.entries:
        # What follows from other parts is cut to size.
        if not entry.key.startswith(f"{table}.") or entry.formula or entry.key in packaged.machine.computed:
            continue
        name, value = entry.key.removeprefix(f"{table}."), design.value(entry.key)
        if (entry.unit == "mm" or name == "thread") and value != entry.value:
            found.append(f"{name.replace('_', ' ')} {value if isinstance(value, str) else f'{value:g} mm'}")
    return found
