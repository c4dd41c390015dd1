"""Designs that differ from one design in a few values: only what depends on these values is computed again."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cache, lru_cache
from types import SimpleNamespace
from typing import Any, get_type_hints

from stagecad.parameters.design import Design, Materials
from stagecad.parameters.errors import InputError, at_place, nearest, require
from stagecad.parameters.file import attribute_value, bounds_text, in_bounds, read_entry, read_formula
from stagecad.parameters.formula import SIGN, Formula, Value, is_formula, parse_formula
from stagecad.parameters.machine import MATERIALS, Machine
from stagecad.parameters.project_tables import NO_ROW
from stagecad.parameters.schema import ByRow, Declaration, Entry, FileEntry, declarations, nearest_key
from stagecad.parameters.units import quoted, unit_dimension


@dataclass(frozen=True)
class Source:
    """Entries of a file, overrides among them, with the declarations of all keys."""

    machine: Machine
    given: Mapping[str, FileEntry]
    keys: Mapping[str, Declaration]
    materials: tuple[str, ...]
    file: str
    overrides: tuple[str, ...] = ()  # keys replaced by `--set`


class Resolver:
    """Computes entries by key, each after those that its formula reads (`reads`), from those of a file and the formulas
    of keys that it may leave out."""

    def __init__(self, source: Source) -> None:
        self._source = source
        self.entries: dict[str, Entry] = {}
        self.reads: dict[str, tuple[str, ...]] = {}

    def all(self) -> dict[str, Entry]:
        """Every entry of the design."""
        for key in self._source.keys:
            self.entry(key)
        return self.entries

    def entry(self, key: str) -> Entry:
        """The entry of a key; those that its formula reads, and those that these read, come first."""
        chain = [] if key in self.entries else [key]
        while chain:
            missing = next((other for other in self._read_by(chain[-1]) if other not in self.entries), None)
            if missing is None:
                last = chain.pop()
                self.entries[last] = self._resolved(last)
            elif missing in chain:
                circle = " -> ".join([*chain[chain.index(missing) :], missing])
                raise InputError(f"{self._source.file}: {missing}: its formula depends on itself: {circle}")
            else:
                chain.append(missing)
        return self.entries[key]

    def _read_by(self, key: str) -> tuple[str, ...]:
        """The keys that the formula of a key reads, and that of the row that it is in."""
        given = self._source.given.get(key)
        row = (given.value.key,) if given is not None and isinstance(given.value, ByRow) else ()
        if all(one in self.entries for one in row):
            formula = self._formula(key)
            read = (*row, *(one for one in (formula.keys if formula else ()) if one in self._source.keys))
            if read:
                self.reads[key] = read
            return read
        return row

    def _given(self, key: str) -> FileEntry | None:
        """The entry of the file, or that of the chosen row of a project's table."""
        given = self._source.given.get(key)
        if given is None or not isinstance(given.value, ByRow):
            return given
        value = given.value
        row = str(self.entries[value.key].value)
        if row == NO_ROW:
            return value.otherwise
        if row not in value.rows:
            place = self._source.given[value.key].place
            raise InputError(f"{place} = {quoted(row)}: no such row in {value.file}{nearest(row, value.rows)}")
        return value.rows[row] or value.otherwise

    def _formula(self, key: str) -> Formula | None:
        """The formula of a key, of the file or where it leaves the key out."""
        declaration, given = self._source.keys[key], self._given(key)
        if given is None:
            return parse_formula(self._source.machine.computed[key].text) if declaration.computed else None
        if not is_formula(given.value):
            return None
        place = f"{given.place} = '{given.value}'"
        require(declaration.kind in ("number", "count"), f"{place}: is not a number, so it cannot be a formula")
        with at_place(place):
            return parse_formula(given.value)

    def _resolved(self, key: str) -> Entry:
        declaration, given, formula = self._source.keys[key], self._given(key), self._formula(key)
        if given is None:
            return self._computed(key, declaration, formula)
        if formula is not None:
            value = attribute_value(formula.value(self._number, declaration.unit, given.place), declaration.unit)
            return read_formula(key, given, f"{SIGN}{formula.text}", value, declaration)
        if isinstance(given.value, str):
            return _read_text(key, given, declaration, self._source.materials)
        return read_entry(key, given, declaration, self._source.materials)

    def _computed(self, key: str, declaration: Declaration, formula: Formula | None) -> Entry:
        """Entry of a key that the file leaves out, from the formula of the key."""
        file, unit = self._source.file, declaration.unit
        if formula is None:
            raise InputError(
                f"{file}: {key} is missing ({declaration.meaning or 'see the packaged design'}); add it, "
                'or begin the file with extends = "thesis" to take missing values from the packaged design'
            )
        stated = self._source.machine.computed[key]
        number = formula.value(self._number, unit, f"{file}: {key}")
        value = int(number) if declaration.kind == "count" else attribute_value(number, unit)
        text = f"{value:.10g} {unit}".strip()
        if not in_bounds(value, declaration):
            raise InputError(f"{file}: {key} becomes {text}, from {stated.text}; it {bounds_text(declaration, value)}")
        return Entry(key, text, value, unit, stated.tolerance, f"computed: {stated.text}", declaration.meaning)

    def _number(self, key: str) -> Value:
        """The number of a key that a formula reads."""
        if key not in self._source.keys:
            raise InputError(f"no parameter '{key}'{nearest_key(key, self._source.keys)}")
        entry = self.entries[key]
        return Value(entry.si, unit_dimension(entry.unit))


_read_text = lru_cache(maxsize=4096)(read_entry)
"""Of a text: a program reads most texts of a design many times, with few of them changed."""


class Variations:
    """The entries of a file as a design without regard to rules (`design`), and its changes."""

    def __init__(self, source: Source) -> None:
        self._source = source
        resolver = Resolver(source)
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

    def changed(self, values: Mapping[str, float | str | bool], origin: str = "assumed: changed") -> Design:
        """The design with other values; what follows from them by formulas changes with them."""
        given = dict(self._source.given)
        for key, value in values.items():
            unit = self._source.keys[key].unit
            number = isinstance(value, int | float) and not isinstance(value, bool)
            text = f"{value!r} {unit}".strip() if number else value
            given[key] = FileEntry(text, f"{self._source.file}: {key}", self._entries[key].tolerance, origin)
        return self._of(replace(self._source, given=given), list(values))

    def of(self, source: Source) -> Design:
        """The design of other entries of the same keys, as with one more override."""
        before = self._source.given
        return self._of(source, [key for key in self._source.keys if source.given.get(key) != before.get(key)])

    def _of(self, source: Source, changed: Sequence[str]) -> Design:
        """The design of a source that differs in the given entries of some keys."""
        touched = self.dependents(changed)
        resolver = Resolver(source)
        resolver.entries.update((key, entry) for key, entry in self._entries.items() if key not in touched)
        for key in touched:
            resolver.entry(key)
        return _typed(resolver.entries, source)


_parts = cache(get_type_hints)


def _typed(entries: Mapping[str, Entry], source: Source) -> Design:
    def table(kind: type, prefix: str) -> Any:
        if declared := declarations(kind):
            return kind(**{name: entries[f"{prefix}{name}"].value for name in declared})
        return kind(**{name: table(part, f"{prefix}{name}.") for name, part in _parts(kind).items()})

    machine = source.machine
    own: dict[str, dict[str, Any]] = {}
    for key in machine.own:
        name, _, last = key.rpartition(".")
        own.setdefault(name, {})[last] = entries[key].value
    return machine.design(
        **vars(table(machine.tables, "")),
        machine=machine,
        materials=Materials((name, table(machine.material, f"{MATERIALS}.{name}.")) for name in source.materials),
        entries=tuple(entries[key] for key in source.keys),
        file=source.file,
        overrides=source.overrides,
        own=tuple((name, SimpleNamespace(**values)) for name, values in own.items()),
        # Only a machine of the user's own changes values for one of its parts.
        source=source if machine.declaration else None,
    )
