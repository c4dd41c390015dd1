"""Designs that differ from one design in a few values: only what depends on these values is computed again."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, fields, replace
from types import SimpleNamespace
from typing import Any, get_type_hints

from stagecad.parameters.design import Design, Materials
from stagecad.parameters.entry import Entry, FileEntry
from stagecad.parameters.machine import MATERIALS, Machine
from stagecad.parameters.resolve import Resolver
from stagecad.parameters.schema import Declaration, declarations


@dataclass(frozen=True)
class Source:
    """Entries of a file, overrides among them, with the declarations of all keys."""

    machine: Machine
    given: Mapping[str, FileEntry]
    keys: Mapping[str, Declaration]
    materials: tuple[str, ...]
    file: str
    overrides: tuple[str, ...] = ()  # keys replaced by `--set`


class Variations:
    """The entries of a file as a design without regard to rules (`design`), and its changes."""

    def __init__(self, source: Source) -> None:
        self._source = source
        resolver = _resolver(source)
        self._entries = resolver.all()
        self._readers: dict[str, set[str]] = {}
        for key, read in resolver.reads.items():
            for other in read:
                self._readers.setdefault(other, set()).add(key)
        self.design = _typed(self._entries, source)

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
        """The design with other values; what follows from them by formulas changes with them."""
        given = dict(self._source.given)
        for key, value in values.items():
            unit = self._source.keys[key].unit
            number = isinstance(value, int | float) and not isinstance(value, bool)
            text = f"{value!r} {unit}".strip() if number else value
            tolerance = self._entries[key].tolerance
            given[key] = FileEntry(text, f"{self._source.file}: {key}", tolerance, origin)
        return self._of(replace(self._source, given=given), list(values))

    def of(self, source: Source) -> Design:
        """The design of other entries of the same keys, as with one more override."""
        before = self._source.given
        return self._of(source, [key for key in self._source.keys if source.given.get(key) != before.get(key)])

    def _of(self, source: Source, changed: Sequence[str]) -> Design:
        """The design of a source that differs in the given entries of some keys."""
        touched = self.dependents(changed)
        resolver = _resolver(source)
        resolver.entries.update((key, entry) for key, entry in self._entries.items() if key not in touched)
        for key in touched:
            resolver.entry(key)
        return self._replaced(resolver.entries, touched, source)

    def _replaced(self, entries: Mapping[str, Entry], touched: set[str], source: Source) -> Design:
        new: dict[str, dict[str, Any]] = {}
        for key in touched:
            table, _, name = key.rpartition(".")
            new.setdefault(table, {})[name] = entries[key].value
        kinds = fields(source.machine.tables)
        tables = {item.name: getattr(self.design, item.name) for item in kinds}
        named, own = dict(self.design.materials), dict(self.design.own)
        for table, values in new.items():
            top, _, below = table.partition(".")
            if top == MATERIALS:
                named[below] = replace(named[below], **values)
            elif top in own:
                own[top] = SimpleNamespace(**{**vars(own[top]), **values})
            else:
                tables[top] = _with(tables[top], below, values)
        return _design(source, tables, named, own, entries)


def _resolver(source: Source) -> Resolver:
    return Resolver(source.given, source.keys, source.machine.computed, source.materials, source.file)


def _with(table: Any, below: str, values: Mapping[str, Any]) -> Any:
    """A table with values replaced in it, or in the table below it of that dotted name."""
    if not below:
        return replace(table, **values)
    name, _, rest = below.partition(".")
    return replace(table, **{name: _with(getattr(table, name), rest, values)})


def _typed(entries: Mapping[str, Entry], source: Source) -> Design:
    def table(kind: type, prefix: str) -> Any:
        if declared := declarations(kind):
            return kind(**{name: entries[f"{prefix}.{name}"].value for name in declared})
        hints = get_type_hints(kind)
        return kind(**{item.name: table(hints[item.name], f"{prefix}.{item.name}") for item in fields(kind)})

    machine = source.machine
    hints = get_type_hints(machine.tables)
    tables = {item.name: table(hints[item.name], item.name) for item in fields(machine.tables)}
    named = {name: table(machine.material, f"{MATERIALS}.{name}") for name in source.materials}
    own: dict[str, dict[str, Any]] = {}
    for key in machine.own:
        name, _, last = key.rpartition(".")
        own.setdefault(name, {})[last] = entries[key].value
    return _design(source, tables, named, {name: SimpleNamespace(**values) for name, values in own.items()}, entries)


def _design(
    source: Source,
    tables: Mapping[str, Any],
    materials: Mapping[str, Any],
    own: Mapping[str, Any],
    entries: Mapping[str, Entry],
) -> Design:
    return source.machine.design(
        **tables,
        machine=source.machine,
        materials=Materials(materials),
        entries=tuple(entries[key] for key in source.keys),
        file=source.file,
        overrides=source.overrides,
        own=tuple(own.items()),
        # Only a machine of the user's own changes values for one of its parts.
        source=source if source.machine.declaration else None,
    )
