"""The parameters of a design and their differences: as JSON documents, in SI, and as tables."""

import re
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from stagecad.parameters.design import Design as Values
from stagecad.parameters.design import nearest_key
from stagecad.parameters.errors import InputError
from stagecad.parameters.file import Entry
from stagecad.parameters.load import Difference, diff, load_design
from stagecad.parameters.rules import present_entries
from stagecad.parameters.schema import Declaration
from stagecad.parameters.units import as_json, attributes, si_of, to_si
from workbench.operations.result import Line, Table, plain_table

_NUMBER = re.compile(r"\s*([-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?)\s*(?:\+-\s*\S+\s*)?(.*)$")


def entry_json(entry: Entry) -> dict[str, Any]:
    """An entry of the parameter file as JSON: a quantity in SI, or the plain value where it has no unit."""
    return {
        **_si(entry),
        "text": entry.text,
        "formula": entry.formula or None,
        **attributes(entry, "tolerance", "origin", "meaning"),
    }


def _si(entry: Entry) -> dict[str, Any]:
    if isinstance(entry.value, bool | str):
        return {"value": entry.value}
    unit = si_of(entry.unit)
    if unit == entry.unit:
        return as_json(entry.value, unit, entry.std)
    return as_json(to_si(entry.value, entry.unit), unit, None if entry.std is None else to_si(entry.std, entry.unit))


def difference_json(difference: Difference) -> dict[str, Any]:
    """A difference as a JSON document."""
    before, after = difference.before, difference.after
    return {
        "key": difference.key,
        "before": entry_json(before) if before else None,
        "after": entry_json(after) if after else None,
    }


def is_named(key: str, names: Sequence[str]) -> bool:
    """Whether a key is one of `names`, or in a table of `names`; without names every key is."""
    return not names or any(key == name or key.startswith(f"{name}.") for name in names)


def require_known(names: Sequence[str], values: Values) -> None:
    """Refuse names of tables and keys that the design does not have."""
    known = [entry.key for entry in values.entries]
    for name in names:
        if not any(is_named(key, [name]) for key in known):
            tables = {key.rpartition(".")[0] for key in known}
            raise InputError(f"no table or parameter '{name}'{nearest_key(name, known if '.' in name else tables)}")


def stated_parameters(values: Values, names: Sequence[str], other: Path | None) -> tuple[list[Line], dict[str, Any]]:
    """Lines and document of the parameters named, or of those that differ from the ones of another file."""
    names = [values.machine.own_key(name) for name in names]
    if other is not None:
        differences = [item for item in diff(values, load_design(other)) if is_named(item.key, names)]
        document = {"files": [values.file, str(other)], "differences": [difference_json(item) for item in differences]}
        return difference_lines(values.file, str(other), differences), document
    require_known(names, values)
    entries = [entry for entry in values.entries if is_named(entry.key, names)] if names else present_entries(values)
    parameters = {entry.key: entry_json(entry) for entry in entries}
    return [parameter_table(entries)], {"file": values.file, "digest": values.digest, "parameters": parameters}


def parameter_table(entries: Sequence[Entry]) -> Table:
    """Value, tolerance, meaning and origin of entries; an empty row between two tables of the file."""
    rows: list[tuple[str, ...]] = []
    group = ""
    for entry in entries:
        if group and entry.key.rpartition(".")[0] != group:
            rows.append(("",) * 5)
        group = entry.key.rpartition(".")[0]
        rows.append((entry.key, _text(entry), entry.tolerance or "", entry.meaning, entry.origin))
    return plain_table("", "parameter|value|tolerance|meaning|origin", rows, "*", "meaning|origin")


def difference_lines(first: str, second: str, differences: Sequence[Difference]) -> list[Line]:
    """The keys that differ between two files, with both values."""
    if not differences:
        return [f"{first} and {second} do not differ"]
    rows = [(item.key, _cell(item.before), _cell(item.after), _what(item)) for item in differences]
    return [plain_table("", f"parameter|{first}|{second}|what differs", rows, "*", f"{first}|{second}|what differs")]


def _text(entry: Entry) -> str:
    return f"{entry.text} {entry.formula}".strip()


def _cell(entry: Entry | None) -> str:
    if entry is None:
        return "absent"
    tolerance = f" ({entry.tolerance})" if entry.tolerance else ""
    return f"{_text(entry)}{tolerance}; {entry.origin}"


def _what(difference: Difference) -> str:
    before, after = difference.before, difference.after
    if before is None or after is None:
        return "present in one"
    parts = [name for name in ("value", "tolerance", "origin") if getattr(before, name) != getattr(after, name)]
    return ", ".join(parts)


def entry_row(entry: Entry) -> dict[str, Any]:
    """An entry with its number in the unit that it is written in."""
    number, unit = _shown(entry)
    shown = attributes(entry, "key", "text") | {"number": number, "unit": unit}
    return shown | attributes(entry, "tolerance", "origin", "meaning")


def parameter_rows(values: Values) -> list[dict[str, Any]]:
    """The parameters of the machine: text, bounds in the unit of the text, origin, kind of the value."""
    keys = values.machine.schema(tuple(values.materials))
    return [{**entry_row(entry), **_bounds(entry, keys[entry.key], values)} for entry in present_entries(values)]


def _shown(entry: Entry) -> tuple[float | None, str]:
    if isinstance(entry.value, bool | str):
        return None, ""
    match = _NUMBER.match(entry.text)
    return (float(match[1]), match[2].strip()) if match else (None, "")


def _bounds(entry: Entry, declaration: Declaration, values: Values) -> dict[str, Any]:
    number, _ = _shown(entry)
    allowed = list(declaration.allowed)
    if declaration.kind == "material":
        allowed = sorted(values.materials)
    bounds: dict[str, Any] = {"low": None, "high": None}
    if number and declaration.unit != "degC":
        scale = number / float(entry.value)
        bounds = {"low": declaration.low * scale, "high": declaration.high * scale}
    return {"kind": declaration.kind, "allowed": allowed, "closed": declaration.closed, **bounds}
