"""Bill of materials: each part with number, quantity, material and mass."""

import csv
import io
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass
from typing import Any

from stagecad.parameters.mass_properties import MassProperties
from stagecad.solids.artefacts.part import BuiltPart
from stagecad.solids.modelling.part import Instance, construction, count

HEADINGS = ("item", "part", "description", "part number", "quantity", "material", "mass each [kg]", "mass [kg]")


@dataclass(frozen=True)
class Accessory:
    """One kind of accessory; it has no solid."""

    name: str  # as in the parts list
    specification: str  # for ordering
    quantity: int  # in one machine


@dataclass(frozen=True)
class Row:
    """One kind of part."""

    item: int  # number in the list, counted from 1
    part: str  # its name
    description: str  # in words
    part_number: str  # of the catalogue or of the drawing; empty without either
    quantity: int  # in one machine
    material: str  # designation for ordering
    mass: float  # of one, kg
    purchased: bool  # whether it is bought


def bill_of_materials(
    instances: Sequence[Instance], parts: Mapping[str, BuiltPart], masses: Mapping[str, MassProperties], design: Any
) -> tuple[Row, ...]:
    """The list of all parts in the assembly, manufactured parts first."""
    counts = count(instances)
    rows: list[Row] = []
    for name, source in construction(design).sources(design).items():
        if name not in counts:
            continue
        part = parts[name]
        rows.append(
            Row(
                item=len(rows) + 1,
                part=name,
                description=part.description,
                part_number=part.part_number or getattr(design.drawing, f"file_{source.kind}", ""),
                quantity=counts[name],
                material=design.materials[part.material].description,
                mass=masses[name].mass,
                purchased=source.purchased,
            )
        )
    return tuple(rows)


def csv_text(rows: Sequence[Row], others: Sequence[Accessory] = ()) -> str:
    """The list as CSV, masses to a tenth of a gram, accessories without mass, with a last row for the whole."""
    memory = io.StringIO()
    writer = csv.writer(memory, lineterminator="\n")
    writer.writerow(HEADINGS)
    for row in rows:
        masses = (f"{row.mass:.4f}", f"{row.quantity * row.mass:.4f}")
        texts = [_plain(text) for text in (row.part, row.description, row.part_number, row.material)]
        writer.writerow([row.item, *texts[:3], row.quantity, texts[3], *masses])
    for item, other in enumerate(others, start=len(rows) + 1):
        writer.writerow([item, other.name, "accessory", _plain(other.specification), other.quantity, "", "", ""])
    total = sum(row.quantity * row.mass for row in rows)
    writer.writerow(["", "total", "", "", sum(row.quantity for row in rows), "", "", f"{total:.4f}"])
    return memory.getvalue()


def _plain(text: str) -> str:
    """A cell that a spreadsheet shows as it is: one beginning like a formula gets an apostrophe before it."""
    return f"'{text}" if text.startswith(("=", "+", "-", "@", "\t", "\r")) else text


def document(rows: Sequence[Row]) -> list[dict[str, Any]]:
    """The list for JSON."""
    return [{**asdict(row), "mass": {"value": row.mass, "unit": "kg"}} for row in rows]
