"""Designs that differ from one design in a few values: only what depends on these values is computed again."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, fields, replace
from typing import Any, get_type_hints

from stagecad.friction_stage.parameters.machine import MATERIALS, Tables
from stagecad.friction_stage.parameters.physics import Material
from stagecad.parameters.design import Design, Materials
from stagecad.parameters.file import Entry, FileEntry
from stagecad.parameters.resolve import Resolver
from stagecad.parameters.schema import Declaration, declarations


@dataclass(frozen=True)
class Source:
    """Entries of a file, overrides among them, with the declarations of all keys."""

    given: Mapping[str, FileEntry]
    keys: Mapping[str, Declaration]
    materials: tuple[str, ...]
    file: str
    overrides: tuple[str, ...] = ()
    """Keys replaced by `--set`."""


class Variations:
    """A design and its changes.

    Args:
        source: entries of the file.

    Attributes:
        design: the unchanged design, without regard to rules.

    Raises:
        InputError: an invalid value or formula, or a key that is missing.
    """

    def __init__(self, source: Source) -> None:
        self._source = source
        resolver = Resolver(source.given, source.keys, source.materials, source.file)
        self._entries = resolver.all()
        self._readers: dict[str, set[str]] = {}
        for key, read in resolver.reads.items():
            for other in read:
                self._readers.setdefault(other, set()).add(key)
        typed = _typed(self._entries, tuple(source.keys), source.materials, source.file)
        self.design = replace(typed, overrides=source.overrides)

    def dependents(self, keys: Sequence[str]) -> set[str]:
        """The keys whose values follow from these by formulas, these among them."""
        found, front = set(keys), list(keys)
        while front:
            new = self._readers.get(front.pop(), set()) - found
            found |= new
            front += new
        return found

    def with_number(self, key: str, value: float) -> Design:
        """The design with one number changed, in the unit of its attribute."""
        return self.changed({key: value})

    def changed(self, values: Mapping[str, float | str | bool], origin: str = "assumed: changed") -> Design:
        """The design with other values; what follows from them by formulas changes with them.

        Args:
            values: by key: numbers in the unit of the attribute, or texts and truth values.
            origin: of the changed values.

        Raises:
            InputError: a value outside of its bounds, or a formula without a value.
        """
        given = dict(self._source.given)
        for key, value in values.items():
            unit = self._source.keys[key].unit
            number = isinstance(value, int | float) and not isinstance(value, bool)
            text = f"{value!r} {unit}".strip() if number else value
            tolerance = self._entries[key].tolerance
            given[key] = FileEntry(text, f"{self._source.file}: {key}", tolerance, origin)
        return self._of(replace(self._source, given=given), list(values))

    def of(self, source: Source) -> Design:
        """The design of other entries of the same keys, as with one more override.

        Raises:
            InputError: an invalid value or formula, or a key that is missing.
        """
        before = self._source.given
        return self._of(source, [key for key in self._source.keys if source.given.get(key) != before.get(key)])

    def _of(self, source: Source, changed: Sequence[str]) -> Design:
        """The design of a source that differs in the given entries of some keys."""
        touched = self.dependents(changed)
        resolver = Resolver(source.given, source.keys, source.materials, source.file)
        resolver.entries.update((key, entry) for key, entry in self._entries.items() if key not in touched)
        for key in touched:
            resolver.entry(key)
        return self._replaced(resolver.entries, touched, source)

    def _replaced(self, entries: Mapping[str, Entry], touched: set[str], source: Source) -> Design:
        new: dict[str, dict[str, Any]] = {}
        for key in touched:
            table, _, name = key.rpartition(".")
            new.setdefault(table, {})[name] = entries[key].value
        tables = {item.name: getattr(self.design, item.name) for item in fields(Tables)}
        named = dict(self.design.materials)
        for table, values in new.items():
            top, _, below = table.partition(".")
            if top == MATERIALS:
                named[below] = replace(named[below], **values)
            else:
                tables[top] = _with(tables[top], below, values)
        ordered = tuple(entries[key] for key in source.keys)
        materials = Materials(tuple(named.items()))
        return Design(**tables, materials=materials, entries=ordered, file=source.file, overrides=source.overrides)


def _with(table: Any, below: str, values: Mapping[str, Any]) -> Any:
    """A table with values replaced in it, or in the table below it of that dotted name."""
    if not below:
        return replace(table, **values)
    name, _, rest = below.partition(".")
    return replace(table, **{name: _with(getattr(table, name), rest, values)})


def _typed(entries: Mapping[str, Entry], keys: Sequence[str], materials: Sequence[str], file: str) -> Design:
    def table(kind: type, prefix: str) -> Any:
        if declared := declarations(kind):
            return kind(**{name: entries[f"{prefix}.{name}"].value for name in declared})
        hints = get_type_hints(kind)
        return kind(**{item.name: table(hints[item.name], f"{prefix}.{item.name}") for item in fields(kind)})

    hints = get_type_hints(Tables)
    tables = {item.name: table(hints[item.name], item.name) for item in fields(Tables)}
    named = tuple((name, table(Material, f"{MATERIALS}.{name}")) for name in materials)
    return Design(**tables, materials=Materials(named), entries=tuple(entries[key] for key in keys), file=file)
