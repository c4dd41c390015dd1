"""Tables of a TOML file and the quantities in them, with an error message for each kind of invalid entry."""

from __future__ import annotations

import math
import tomllib
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any

from stagecad.parameters.errors import InputError, nearest, require, require_known
from stagecad.parameters.input_file import load_toml, read_input
from stagecad.parameters.units import parse_quantity

LARGEST = 1e50
"""Largest magnitude of a value, SI, and the inverse of the smallest that is not zero: the square of a second rate, a
value over the square of a time step, is a number too."""

_KINDS: dict[type, str] = {bool: "true or false", int: "a whole number", float: "a number", str: "a text"}
_KINDS |= {list: "a list", dict: "a table"}


def kind_of(value: Any) -> str:
    """Name of the TOML type of `value`."""
    return _KINDS.get(type(value), "a date or time")


def shown(value: Any) -> str:
    """`value` in TOML notation, truncated."""
    text = f"'{value}'" if isinstance(value, str) else str(value).lower() if isinstance(value, bool) else str(value)
    text = " ".join(text.split())
    return text if len(text) <= 60 else text[:57] + "..."


class TomlTable:
    """A table of a TOML file, with its file and dotted name, empty for the root table, for messages."""

    def __init__(self, file: str, name: str, data: Any) -> None:
        self.file = file
        self.name = name
        if not isinstance(data, dict):
            example = f"[{name}]" if " " not in name else "{...}" if "." in name else f"[[{name.partition(' ')[0]}]]"
            raise InputError(f"{file}: {name}: {shown(data)} is {kind_of(data)}, a table is required: write {example}")
        self.data: Mapping[str, Any] = data

    def where(self, key: str = "") -> str:
        """File and dotted key, for a message."""
        dotted = ".".join(part for part in (self.name, key) if part)
        return f"{self.file}: {dotted}" if dotted else self.file

    def allow(self, keys: Iterable[str], listed: str = "") -> None:
        """Refuse keys other than `keys`; the message names the most similar one, and where they are listed."""
        keys = tuple(keys)
        for key in self.data:
            if key not in keys:
                raise InputError(f"{self.where()}: unknown key '{key}'{nearest(key, keys)}{listed}")

    def text(self, key: str, default: str | None = None) -> str:
        """The text under `key`; an error if it is missing without a default, or is not a text."""
        if key not in self.data:
            if default is None:
                raise InputError(f"{self.where()}: '{key}' is missing")
            return default
        value = self.data[key]
        if not isinstance(value, str):
            raise InputError(f"{self.where(key)}: {shown(value)} is {kind_of(value)}, a text is required")
        _check_printable(value, self.where(key))
        return value

    def choice(self, key: str, allowed: tuple[str, ...], default: str | None = None) -> str:
        """The text under `key`, one of `allowed`."""
        value = self.text(key, default)
        require_known(value, allowed, f"{self.where(key)}: '{value}' is not allowed")
        return value

    def flag(self, key: str) -> bool:
        """The boolean under `key`; false if it is missing."""
        value = self.data.get(key, False)
        if not isinstance(value, bool):
            raise InputError(f"{self.where(key)}: {shown(value)} is {kind_of(value)}, true or false is required")
        return value

    def texts(self, key: str) -> tuple[str, ...]:
        """The list of texts under `key`; empty if it is missing."""
        value = self.data.get(key, [])
        if not isinstance(value, list):
            raise InputError(
                f'{self.where(key)}: {shown(value)} is {kind_of(value)}, a list is required: ["...", "..."]'
            )
        for item in value:
            if not isinstance(item, str):
                raise InputError(f"{self.where(key)}: {shown(item)} is {kind_of(item)}, a text is required")
            _check_printable(item, self.where(key))
        return tuple(value)

    def table(self, key: str) -> TomlTable:
        """The table under `key`; empty if it is missing."""
        return TomlTable(self.file, ".".join(part for part in (self.name, key) if part), self.data.get(key, {}))

    def tables(self, key: str) -> list[TomlTable]:
        """The array of tables under `key`, numbered from 1 in messages."""
        value = self.data.get(key, [])
        if isinstance(value, dict):
            raise InputError(
                f"{self.where(key)}: one table, a list of tables is required: write [[{key}]], not [{key}]"
            )
        if not isinstance(value, list):
            raise InputError(f"{self.where(key)}: {kind_of(value)}, a list of tables is required: write [[{key}]]")
        return [TomlTable(self.file, f"{key} {number}", item) for number, item in enumerate(value, start=1)]


def _check_printable(text: str, where: str) -> None:
    """Refuse a text with line breaks or control characters: names and paths are printed to terminals."""
    require(text.isprintable(), f"{where}: {shown(text)} contains characters that cannot be printed")


def read_toml(path: Path, shown_name: str) -> tuple[bytes, str, TomlTable]:
    """Read a TOML file."""
    try:
        data = read_input(path)
        text = data.decode("utf-8-sig")
    except OSError as error:
        raise InputError(f"{shown_name}: cannot be read: {error.strerror}") from None
    except UnicodeDecodeError as error:
        raise InputError(f"{shown_name}: byte {error.start} is not UTF-8; save the file as UTF-8") from None
    try:
        return data, text, TomlTable(shown_name, "", load_toml(text, shown_name))
    except tomllib.TOMLDecodeError as error:
        raise InputError(f"{shown_name}: not valid TOML: {error}") from None


def quantity(table: TomlTable, key: str, unit: str, positive: bool = False) -> float:
    """The quantity under `key` in SI."""
    value = parse_quantity(quantity_text(table, key, unit), unit, table.where(key))
    check_value(value, positive, table, key)
    return value


def quantity_text(table: TomlTable, key: str, unit: str) -> str:
    """The text under `key`, expected to be a quantity with the dimension of `unit`; an error if it is not a text, or a
    number that needs no unit."""
    value = table.data[key]
    is_number = isinstance(value, int | float) and not isinstance(value, bool)
    if not unit and is_number:
        return repr(value)
    if not isinstance(value, str):
        example = f"'{value if is_number else 1} {unit}'"
        raise InputError(
            f"{table.where(key)}: {shown(value)} is {kind_of(value)}, a quantity with its unit is required, "
            f"such as {example}"
        )
    return value


def check_size(value: float, written: str, where: str) -> None:
    """Refuse a value, SI, that is not finite, or with whose square nothing can be computed."""
    require(math.isfinite(value), f"{where}: {written} is not finite")
    if value and not 1.0 / LARGEST <= abs(value) <= LARGEST:
        raise InputError(
            f"{where}: {written} is {value:.3g} in SI units; {1.0 / LARGEST:g} to {LARGEST:g} are possible"
        )


def check_value(value: float, positive: bool, table: TomlTable, key: str) -> None:
    """Refuse a value of no possible size, or not positive although required."""
    check_size(value, shown(table.data[key]), table.where(key))
    if positive and value <= 0.0:
        raise InputError(f"{table.where(key)}: '{table.data[key]}' must be above zero")
