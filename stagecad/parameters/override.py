"""Values given in place of those of the parameter file: texts `KEY=VALUE`, as of `--set`."""

from collections.abc import Mapping
from dataclasses import replace

from stagecad.parameters.design import Design
from stagecad.parameters.errors import InputError, require
from stagecad.parameters.machine import Machine
from stagecad.parameters.schema import Declaration, FileEntry, nearest_key
from stagecad.parameters.variations import Source, Variations


def override(
    text: str, keys: Mapping[str, Declaration], given: Mapping[str, FileEntry], machine: Machine
) -> tuple[str, FileEntry]:
    """Key and entry of a text `KEY=VALUE`, with the tolerance class of the entry that it replaces."""
    require(text.isprintable(), f"--set {text!r}: contains characters that cannot be printed")
    key, equals, value = (part.strip() for part in text.partition("="))
    require(equals and key and value, f"--set '{text}': write KEY=VALUE, like stage.length=240mm")
    key = machine.own_key(key)
    if key not in keys:
        raise InputError(f"--set: no parameter '{key}'{nearest_key(key, keys)}")
    source = given.get(key) or machine.computed.get(key)
    free = source.free if isinstance(source, FileEntry) else ""
    tolerance = source.tolerance if source else None
    return key, FileEntry(value, f"--set {key}", tolerance, "assumed: given by --set", free)


def overridden(design: Design, values: Mapping[str, str]) -> Design:
    """A design of a machine of the user's own with other values of some keys, without regard to rules."""
    if not values:
        return design
    source: Source = design.source
    given = dict(source.given)
    for key, text in values.items():
        found, entry = override(f"{key}={text}", source.keys, given, source.machine)
        given[found] = entry
    return Variations(source).of(replace(source, given=given, overrides=(*source.overrides, *values)))
