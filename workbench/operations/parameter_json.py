"""Parameters and their differences as JSON documents, in SI."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from stagecad.parameters.file import Entry
    from stagecad.parameters.load import Difference


def _si(entry: Entry) -> dict[str, Any]:
    """The entry's value as JSON: a quantity in SI, or the plain value where it has no unit."""
    from stagecad.parameters.units import as_json, to_si

    if isinstance(entry.value, bool | str):
        return {"value": entry.value}
    unit = {"mm": "m", "deg": "rad"}.get(entry.unit, entry.unit)
    if unit == entry.unit:
        return as_json(entry.value, unit, entry.std)
    std = None if entry.std is None else to_si(entry.std, entry.unit)
    return as_json(to_si(entry.value, entry.unit), unit, std)


def entry_json(entry: Entry) -> dict[str, Any]:
    """An entry of the parameter file as JSON, in SI."""
    return {
        **_si(entry),
        "text": entry.text,
        "formula": entry.formula or None,
        "tolerance": entry.tolerance,
        "origin": entry.origin,
        "meaning": entry.meaning,
    }


def difference_json(difference: Difference) -> dict[str, Any]:
    """A difference as a JSON document."""
    before, after = difference.before, difference.after
    return {
        "key": difference.key,
        "before": entry_json(before) if before else None,
        "after": entry_json(after) if after else None,
    }
