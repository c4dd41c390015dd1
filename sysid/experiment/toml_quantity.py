"""Quantities in the tables of a TOML file."""

from __future__ import annotations

import math

from stagecad.parameters.errors import InputError
from stagecad.parameters.units import parse_quantity
from sysid.experiment.toml_table import TomlTable, kind_of, shown


def quantity(table: TomlTable, key: str, unit: str, positive: bool = False) -> float:
    """The quantity under `key` in SI.

    Raises:
        InputError: not a text, no quantity, another dimension, or not positive where it must be.
    """
    value = parse_quantity(quantity_text(table, key, unit), unit, table.where(key))
    check_value(value, positive, table, key)
    return value


def quantity_text(table: TomlTable, key: str, unit: str) -> str:
    """The text under `key`, which has to be a quantity like one of `unit`; an error where it is no text."""
    value = table.data[key]
    if not isinstance(value, str):
        example = (
            f"'{value} {unit}'" if isinstance(value, int | float) and not isinstance(value, bool) else f"'1 {unit}'"
        )
        raise InputError(
            f"{table.where(key)}: {shown(value)} is {kind_of(value)}, a quantity with its unit is wanted, "
            f"such as {example}"
        )
    return value


def check_value(value: float, positive: bool, table: TomlTable, key: str) -> None:
    """Refuse a value that is not finite, or not above zero where it has to be."""
    if not math.isfinite(value):
        raise InputError(f"{table.where(key)}: '{table.data[key]}' is not finite")
    if positive and value <= 0.0:
        raise InputError(f"{table.where(key)}: '{table.data[key]}' must be above zero")
