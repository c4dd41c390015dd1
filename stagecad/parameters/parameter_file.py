"""The parameter file as text: read into entries by key, and one value written back with its comments kept.

What the entries mean is the business of `design`; here they are what stands in the file.
"""

from __future__ import annotations

import re
import tomllib
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache
from importlib.resources import files
from pathlib import Path
from typing import Any

from stagecad.parameters.atomic import atomic_write_text
from stagecad.parameters.errors import InputError, nearest
from stagecad.parameters.schema import TOLERANCE_CLASSES

PACKAGED = "thesis"
"""Name of the packaged design, for `extends` at the head of a file."""

ORIGINS = "thesis SECTION, catalogue PART, assumed: REASON, measured: EXPERIMENT"
_ORIGIN = re.compile(r"(thesis|catalogue) \S.*|(assumed|measured): \S.*")
_PEDIGREE = ("value", "tolerance", "origin")
_LARGEST = 4_000_000


@dataclass(frozen=True)
class FileEntry:
    """One key of a parameter file.

    Args:
        value: as written: text, number or truth value.
        place: file and key, for messages.
        tolerance, origin: as written; none where the entry is a bare value.
    """

    value: Any
    place: str
    tolerance: str | None = None
    origin: str | None = None


@dataclass(frozen=True)
class ParameterFile:
    """The entries of a file by dotted key, with the name messages call it by."""

    name: str
    entries: Mapping[str, FileEntry]
    extends: str | None = None


def packaged_text() -> str:
    """Text of the packaged thesis design: where a new parameter file starts from."""
    return files("stagecad.parameters").joinpath("thesis.toml").read_text("utf-8")


def read_parameter_file(path: str | Path | None = None) -> ParameterFile:
    """Read a parameter file, or the packaged design where `path` is left out.

    Raises:
        InputError: the file is missing, no text, or no TOML; an entry is neither a value nor a table with its pedigree.
    """
    if path is None:
        return _packaged()
    name = str(path)
    try:
        if Path(path).stat().st_size > _LARGEST:
            raise InputError(f"{name}: is larger than a parameter file can be")
        data = Path(path).read_bytes()
    except FileNotFoundError:
        raise InputError(f"{name}: no such parameter file") from None
    except IsADirectoryError:
        raise InputError(f"{name}: is a folder, not a parameter file") from None
    except OSError as error:
        raise InputError(f"{name}: cannot be read ({error.strerror})") from None
    try:
        return parse_parameter_text(data.decode("utf-8-sig"), name)
    except UnicodeDecodeError as error:
        line = data[: error.start].count(b"\n") + 1
        raise InputError(f"{name}: line {line}: not UTF-8 text; save the file as UTF-8") from None


@cache
def _packaged() -> ParameterFile:
    return parse_parameter_text(packaged_text(), f"{PACKAGED}.toml")


def parse_parameter_text(text: str, name: str) -> ParameterFile:
    """As `read_parameter_file`, from text; `name` is what messages call the file."""
    try:
        document = tomllib.loads(text)
    except tomllib.TOMLDecodeError as error:
        raise InputError(f"{name}: {_toml_mistake(text, str(error))}") from None
    except RecursionError:
        raise InputError(f"{name}: is nested too deeply for a parameter file") from None
    extends = document.pop("extends", None)
    if extends not in (None, PACKAGED):
        raise InputError(f"{name}: extends = {extends!r}: only '{PACKAGED}', the packaged design, can be extended")
    entries: dict[str, FileEntry] = {}
    for table, content in document.items():
        if not isinstance(content, dict):
            raise InputError(f"{name}: {table} = {_shown(content)} stands in no table; write it below one like [stage]")
        _collect(name, table, content, entries)
    return ParameterFile(name, entries, extends)


def _collect(name: str, prefix: str, content: dict[str, Any], entries: dict[str, FileEntry]) -> None:
    for key, value in content.items():
        path = f"{prefix}.{key}"
        if not path.isprintable():
            raise InputError(f"{name}: the key {path!r} holds characters that cannot be printed")
        if not isinstance(value, dict):
            if not isinstance(value, str | int | float | bool):
                raise InputError(f"{name}: {path} = {_shown(value)} is no value; write text like '12 mm', or a number")
            entries[path] = FileEntry(value, f"{name}: {path}")
        elif "value" in value or (value and set(value) <= {"tolerance", "origin"}):
            entries[path] = _entry(name, path, value)
        else:
            _collect(name, path, value, entries)


def _entry(name: str, path: str, table: dict[str, Any]) -> FileEntry:
    place = f"{name}: {path}"
    for word in table:
        if word not in _PEDIGREE:
            raise InputError(f"{place}: '{word}' is not known beside value{nearest(word, _PEDIGREE)}")
    if "value" not in table:
        raise InputError(f'{place}: has no value; write {{value = "12 mm", origin = "assumed: why"}}')
    value, tolerance, origin = table["value"], table.get("tolerance"), table.get("origin")
    if not isinstance(value, str | int | float | bool):
        raise InputError(f"{place}: value = {_shown(value)} is no value; write text like '12 mm', or a number")
    if tolerance is not None and tolerance not in TOLERANCE_CLASSES:
        raise InputError(f"{place}: tolerance = {_shown(tolerance)}; allowed: {', '.join(TOLERANCE_CLASSES)}")
    if origin is not None:
        require_origin(origin, place)
    return FileEntry(value, place, tolerance, origin)


def require_origin(origin: Any, place: str) -> None:
    """Raise an InputError unless `origin` says where a value comes from."""
    if not isinstance(origin, str) or not _ORIGIN.fullmatch(origin):
        raise InputError(f"{place}: origin = {_shown(origin)}; write one of: {ORIGINS}")


def _shown(value: Any) -> str:
    if isinstance(value, bool):
        return str(value).lower()
    text = repr(value) if isinstance(value, str | int | float) else f"a {type(value).__name__}"
    return {"a dict": "a table", "a list": "a list"}.get(text, text)


def _toml_mistake(text: str, message: str) -> str:
    """What the TOML reader says, begun with the line, and naming the key that stands there twice."""
    match = re.fullmatch(r"(?P<what>.*) \(at line (?P<line>\d+), column \d+\)", message)
    if match is None:
        ends = text.count("\n") + 1
        return f"line {ends}: not TOML: {message.removesuffix(' (at end of document)')}"
    lines, number = text.splitlines(), int(match["line"])
    what, line = match["what"], lines[number - 1].strip() if number <= len(lines) else ""
    if "overwrite" in what or "twice" in what or "already" in what:
        key = line.split("=")[0].strip() if "=" in line else line
        # The reader notices a repeated key once its value ends, which may be at the start of the next line.
        if not key and number > 1:
            key = lines[number - 2].split("=")[0].strip()
        return f"line {number}: '{key}' is given twice; keep one of them"
    return f"line {number}: not TOML: {what[0].lower()}{what[1:]}: {line[:60]}"


def write_value(path: str | Path, key: str, value: str | float | bool, origin: str) -> None:
    """Write one value back into a parameter file, with its origin; comments, order and all other entries stay.

    Args:
        path: the parameter file.
        key: dotted key, `bearing.dynamic_friction`.
        value: as it is to stand in the file: `"12.05 mm"`; a number or truth value stays one.
        origin: `measured: EXPERIMENT`, or another origin.

    Raises:
        InputError: the file or the value is bad; then the file is left as it was.
    """
    write_values(path, {key: (value, origin)})


def write_values(path: str | Path, changes: Mapping[str, tuple[str | float | bool, str]]) -> None:
    """As `write_value`, several at once: by key, the value and its origin. All are written, or none."""
    read_parameter_file(path)
    with Path(path).open(encoding="utf-8-sig", newline="") as stream:
        text = stream.read()
    atomic_write_text(path, changed_text(text, str(path), changes))


def changed_text(text: str, name: str, changes: Mapping[str, tuple[str | float | bool, str]]) -> str:
    """Text of a parameter file with values and origins replaced, checked as a whole; `name` is for messages."""
    import tomlkit
    from tomlkit.items import InlineTable

    from stagecad.parameters.design import design_from_text

    document = tomlkit.parse(text)
    for key, (value, origin) in changes.items():
        place = f"{name}: {key}"
        require_origin(origin, place)
        *tables, last = key.split(".")
        if not tables:
            raise InputError(f"{place}: a key is written TABLE.NAME, like stage.length")
        holder: Any = document
        for table in tables:
            if table not in holder:
                holder[table] = tomlkit.table()
            holder = holder[table]
        found = holder.get(last)
        if isinstance(found, InlineTable):
            found["value"] = value
            found["origin"] = origin
        else:
            entry = tomlkit.inline_table()
            entry["value"] = value
            entry["origin"] = origin
            holder[last] = entry
    written = tomlkit.dumps(document)
    design_from_text(written, name)
    return written
