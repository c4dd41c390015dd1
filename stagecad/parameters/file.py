"""The parameter file: text parsed into entries by key, and each entry checked against the declaration of its key."""

import math
import re
import tomllib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cache
from pathlib import Path
from typing import Any

from stagecad.parameters.errors import InputError, nearest, require, require_known
from stagecad.parameters.input_file import decoded, load_toml, read_input
from stagecad.parameters.iso286 import deviations, in_range, is_class
from stagecad.parameters.machine import packaged_machine
from stagecad.parameters.project_tables import HARDWARE, ProjectTable, read_project_tables
from stagecad.parameters.schema import TOLERANCE_CLASSES, Declaration, Entry, FileEntry
from stagecad.parameters.units import from_si, parse_uncertain, quoted

PACKAGED = "thesis"
"""Name of the packaged design, as in `extends = "thesis"`."""

ORIGINS = "thesis SECTION, catalogue PART, assumed: REASON, measured: EXPERIMENT"
_ORIGIN = re.compile(r"(thesis|catalogue) \S.*|(assumed|measured): \S.*")
_FIELDS = ("value", "tolerance", "origin", "free")
_LARGEST = 4_000_000
"""Largest accepted size of a parameter file, bytes."""


@dataclass(frozen=True)
class ParameterFile:
    """The entries of a file by dotted key, with the file's name in messages and its folder."""

    name: str
    entries: Mapping[str, FileEntry]
    folder: Path
    extends: str | None = None
    machine: Mapping[str, Any] | None = None
    """The table `[machine]`, as parsed (`stagecad.parameters.machine_declaration`)."""
    tables: tuple[ProjectTable, ...] = ()  # the project's tables of hardware


def packaged_path() -> Path:
    """The packaged parameter file: the design of the thesis."""
    return packaged_machine().file


def packaged_text() -> str:
    """Text of the packaged thesis design."""
    return packaged_path().read_text("utf-8")


def read_parameter_file(path: str | Path | None = None) -> ParameterFile:
    """Read a parameter file, or the packaged design where `path` is left out."""
    return _packaged() if path is None else parse_parameter_text(parameter_text(path), str(path), Path(path).parent)


def parameter_text(path: str | Path) -> str:
    """Text of a parameter file."""
    name = str(path)
    try:
        data = read_input(path, _LARGEST)
    except FileNotFoundError:
        raise InputError(f"{name}: no such parameter file") from None
    except IsADirectoryError:
        raise InputError(f"{name}: is a folder, not a parameter file") from None
    except OSError as error:
        raise InputError(f"{name}: cannot be read ({error.strerror})") from None
    return decoded(data, name)


@cache
def _packaged() -> ParameterFile:
    return parse_parameter_text(packaged_text(), f"{PACKAGED}.toml")


def parse_parameter_text(text: str, name: str, folder: Path | None = None) -> ParameterFile:
    """Like `read_parameter_file`, from text."""
    try:
        document = load_toml(text, name)
    except tomllib.TOMLDecodeError as error:
        raise InputError(f"{name}: {_toml_error(text, str(error))}") from None
    extends = document.pop("extends", None)
    if extends not in (None, PACKAGED):
        raise InputError(f"{name}: extends = {extends!r}: only '{PACKAGED}', the packaged design, can be extended")
    machine = document.pop("machine", None)
    if machine is not None and not isinstance(machine, dict):
        raise InputError(f"{name}: machine = {_value_text(machine)}: write a table [machine]")
    named = document.pop(HARDWARE, {})
    require(isinstance(named, dict), f"{name}: {HARDWARE} = {_value_text(named)}: write a table [{HARDWARE}]")
    folder = Path(name).parent if folder is None else folder
    tables = read_project_tables(named, folder, name, packaged_machine().kinds())
    entries: dict[str, FileEntry] = {}
    for table, content in document.items():
        if not isinstance(content, dict):
            raise InputError(
                f"{name}: {table} = {_value_text(content)} is outside a table; write it in a table like [stage]"
            )
        _collect(name, table, content, entries)
    return ParameterFile(name, entries, folder, extends, machine, tables)


def _collect(name: str, prefix: str, content: dict[str, Any], entries: dict[str, FileEntry]) -> None:
    for key, value in content.items():
        path = f"{prefix}.{key}"
        require(path.isprintable(), f"{name}: the key {path!r} contains characters that cannot be printed")
        if not isinstance(value, dict):
            entries[path] = FileEntry(_scalar(value, f"{name}: {path}"), f"{name}: {path}")
        elif "value" in value or (value and set(value) <= {"tolerance", "origin", "free"}):
            entries[path] = written_entry(f"{name}: {path}", value)
        else:
            _collect(name, path, value, entries)


def written_entry(place: str, table: Mapping[str, Any]) -> FileEntry:
    """An entry that is written as a table with value, tolerance, origin and free range."""
    for word in table:
        require_known(word, _FIELDS, f"{place}: unknown field '{word}'")
    require("value" in table, f'{place}: has no value; write {{value = "12 mm", origin = "assumed: why"}}')
    value = _scalar(table["value"], f"{place}: value")
    tolerance, origin = table.get("tolerance"), table.get("origin")
    if origin is not None:
        require_origin(origin, place)
    free = table.get("free", "")
    if not isinstance(free, str) or (free and ".." not in free and "|" not in free):
        raise InputError(
            f"{place}: free = {_value_text(free)}; write a range like '8 mm..20 mm', or choices like 'A | B'"
        )
    return FileEntry(value, place, tolerance, origin, free)


def _scalar(value: Any, place: str) -> str | float | bool:
    if not isinstance(value, str | int | float | bool):
        raise InputError(f"{place} = {_value_text(value)} is not a value; write text like '12 mm', or a number")
    return value


def require_origin(origin: Any, place: str) -> None:
    """Raise an InputError unless `origin` has one of the accepted forms."""
    if not isinstance(origin, str) or not _ORIGIN.fullmatch(origin) or not origin.isprintable():
        raise InputError(f"{place}: origin = {_value_text(origin)}; write one of: {ORIGINS}")


def _value_text(value: Any) -> str:
    if isinstance(value, bool):
        return str(value).lower()
    text = repr(value) if isinstance(value, str | int | float) else f"a {type(value).__name__}"
    return {"a dict": "a table", "a list": "a list"}.get(text, text)


def _toml_error(text: str, message: str) -> str:
    """The message of the TOML parser, beginning with the line number; names a key that is repeated."""
    match = re.fullmatch(r"(?P<what>.*) \(at line (?P<line>\d+), column \d+\)", message)
    if match is None:
        ends = text.count("\n") + 1
        return f"line {ends}: not TOML: {message.removesuffix(' (at end of document)')}"
    lines, number = text.splitlines(), int(match["line"])
    what, line = match["what"], lines[number - 1].strip() if number <= len(lines) else ""
    if "overwrite" in what or "twice" in what or "already" in what:
        key = line.split("=")[0].strip() if "=" in line else line
        # The parser reports a repeated key where its value ends, possibly at the start of the next line.
        if not key and number > 1:
            key = lines[number - 2].split("=")[0].strip()
        return f"line {number}: '{key}' is given twice; keep one of them"
    return f"line {number}: not TOML: {what[0].lower()}{what[1:]}: {line[:60]}"


def read_formula(key: str, entry: FileEntry, formula: str, value: float, declaration: Declaration) -> Entry:
    """The entry of a design from the value of a formula, in the unit of the attribute."""
    text = f"{value:.10g} {declaration.unit}".strip()
    bare = entry.tolerance is None and entry.origin is None and declaration.unit == "mm"
    plain = FileEntry(
        text, f"{entry.place} = '{formula}'", "X.X" if bare else entry.tolerance, entry.origin, entry.free
    )
    return replace(read_entry(key, plain, declaration, ()), formula=formula)


def read_entry(key: str, entry: FileEntry, declaration: Declaration, materials: Sequence[str]) -> Entry:
    """The entry of a design from an entry of the file, checked against the declaration of its key."""
    value, std, tolerance = entry.value, None, entry.tolerance
    shown = str(value).lower() if isinstance(value, bool) else str(value)
    place = entry.place
    if tolerance not in (None, *TOLERANCE_CLASSES) and not (isinstance(tolerance, str) and is_class(tolerance)):
        raise InputError(
            f"{place}: tolerance = {_value_text(tolerance)}; allowed: {', '.join(TOLERANCE_CLASSES)}, "
            "or a class of ISO 286 like H7 or g6"
        )
    if declaration.kind == "number":
        value, std = _number(entry, declaration)
        if tolerance is None and entry.origin is None and declaration.unit == "mm":
            tolerance = class_by_decimals(shown)
        if tolerance is not None and is_class(tolerance) and not (declaration.unit == "mm" and in_range(value)):
            raise InputError(f"{place}: tolerance = '{tolerance}' is for diameters up to 250 mm, not for {shown}")
        if tolerance is not None and is_class(tolerance):
            try:
                deviations(value, tolerance)
            except ValueError as error:
                raise InputError(f"{place}: {error} (ISO 286-1)") from None
    elif declaration.kind == "count":
        value = _count(entry, declaration)
    elif declaration.kind == "switch":
        require(shown in ("true", "false"), f"{place}: {quoted(shown)} is neither true nor false")
        value, shown = shown == "true", shown.strip()
    else:
        if not isinstance(value, str) or not value.strip() or not value.isprintable():
            raise InputError(f"{place}: {shown!r} is not a line of text")
        allowed = materials if declaration.kind == "material" else declaration.allowed
        if allowed and value not in allowed:
            what = "material" if declaration.kind == "material" else "choice"
            raise InputError(f"{place}: no {what} {quoted(value)}{nearest(value, allowed)}")
    if std is not None:
        std = from_si(std, declaration.unit)
    origin = entry.origin or "assumed: the file gives no origin"
    return Entry(key, shown, value, declaration.unit, tolerance, origin, declaration.meaning, std, free=entry.free)


def _number(entry: FileEntry, declaration: Declaration) -> tuple[float, float | None]:
    si, std = parse_uncertain(entry.value, declaration.unit, entry.place)
    value = attribute_value(si, declaration.unit)
    if not in_bounds(value, declaration):
        raise InputError(f"{entry.place}: {quoted(str(entry.value))} {bounds_text(declaration, value)}")
    return value, std


def in_bounds(value: float, declaration: Declaration) -> bool:
    """Whether a number is within the bounds declared for its key."""
    above = value > declaration.low or (value == declaration.low and declaration.closed)
    return above and value <= declaration.high and not math.isinf(value)


def attribute_value(si: float, unit: str) -> float:
    """A number in SI in the unit of its attribute; a length in mm without the rounding error of the conversion."""
    value = from_si(si, unit)
    return round(value, 9) if unit == "mm" and math.isfinite(value) else value


def bounds_text(declaration: Declaration, value: float) -> str:
    """The permitted range of a number that `value` is not in, as the end of a message."""
    unit = f" {declaration.unit}" if declaration.unit else ""
    low, high = declaration.low, declaration.high
    if low > 0.0 and not 0.0 < value < math.inf:
        return "must be positive, and finite"
    if math.isinf(high):
        if low == 0.0:
            return f"must be {'zero or more' if declaration.closed else 'positive'}, and finite"
        if math.isinf(low):
            return "must be finite"
        return f"must be {'at least' if declaration.closed else 'more than'} {low:g}{unit}, and finite"
    why = f": {declaration.why}" if declaration.why else ""
    within = "lie between {:g} and {:g}" if declaration.closed else "be more than {:g} and at most {:g}"
    return f"must {within.format(low, high)}{unit}{why}"


def _count(entry: FileEntry, declaration: Declaration) -> int:
    si, _ = parse_uncertain(entry.value, "", entry.place)
    low, high = declaration.low, declaration.high
    if not low <= si <= high or si != round(si):
        shown = quoted(str(entry.value))
        raise InputError(f"{entry.place}: {shown} must be a whole number from {low:g} to {high:g}")
    return int(si)


def class_by_decimals(text: str) -> str:
    """The tolerance class implied by the decimals of a bare value."""
    if not text.rstrip().endswith("mm"):
        return "X.X"
    decimals = len(text.partition(".")[2].rstrip(" m"))
    return ("X", "X.X", "X.XX")[min(decimals, 2)]
