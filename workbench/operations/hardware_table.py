"""A project's table of hardware to start from: CSV with the hardware of a design."""

from __future__ import annotations

import csv
import io
from collections.abc import Iterator
from typing import TYPE_CHECKING, Any

from stagecad.parameters.units import from_si, to_si

if TYPE_CHECKING:
    from stagecad.parameters.design import Design
    from stagecad.parameters.project_tables import Kind

_UNITS = {"m": "um", "m^2": "mm^2", "kg": "g", "Pa": "MPa", "F": "uF"}
"""Units of the columns whose keys are kept in others."""


def table_text(design: Design, kind: str) -> str:
    """The table of a kind with one row for each piece of hardware in the design."""
    from stagecad.parameters.project_tables import NAME, SOURCE

    declared = design.machine.kinds()[kind]
    columns = [column for column, one in declared.columns.items() if not one.computed]
    memory = io.StringIO()
    writer = csv.writer(memory, lineterminator="\n")
    kept = {column: declared.columns[column].unit for column in columns}
    units = {column: _UNITS.get(unit, unit) for column, unit in kept.items()}
    writer.writerow([NAME, *(f"{one} [{unit}]" if unit else one for one, unit in units.items()), SOURCE])
    for name, keys in dict(_rows(design, kind, declared, columns)).items():
        values = [design.value(key) for key in keys]
        cells = [_cell(value, kept[column], units[column]) for column, value in zip(columns, values, strict=True)]
        writer.writerow([name, *cells, f"assumed: as in {design.file}"])
    return memory.getvalue()


def _rows(design: Design, kind: str, declared: Kind, columns: list[str]) -> Iterator[tuple[str, list[str]]]:
    """Names of the rows with the keys of their values."""
    for slot in declared.slots:
        yield str(design.value(f"{slot}.part_number")), [f"{slot}.{column}" for column in columns]
    for name in declared.names:
        yield name, [f"{kind}.{name}_{column}" for column in columns]
    if kind == "materials":
        for name in design.materials:
            yield name, [f"{kind}.{name}.{column}" for column in columns]


def _cell(value: Any, kept: str, unit: str) -> str:
    if isinstance(value, bool):
        return str(value).lower()
    return f"{from_si(to_si(value, kept), unit):.10g}" if isinstance(value, float) else str(value)
