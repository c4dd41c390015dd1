"""Designs that differ from one design in a few values: only what depends on these values is computed again."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, fields, replace
from functools import lru_cache
from types import SimpleNamespace
from typing import Any, get_type_hints

from stagecad.parameters.design import Design, Materials
from stagecad.parameters.errors import InputError, at_place, nearest
from stagecad.parameters.file import attribute_value, bounds_text, in_bounds, read_entry, read_formula
from stagecad.parameters.formula import SIGN, FormulaError, Value, is_formula, parse_formula
from stagecad.parameters.machine import MATERIALS, Computed, Machine
from stagecad.parameters.project_tables import NO_ROW
from stagecad.parameters.schema import ByRow, Declaration, Entry, FileEntry, declarations, nearest_key
from stagecad.parameters.units import quoted, to_si, unit_dimension

DEEPEST = 40
"""Formulas that are open at a time, each of which needs the next one."""


class _TooDeepError(Exception):
    """A chain of formulas is longer than `DEEPEST`; `key` is the next one."""

    def __init__(self, key: str) -> None:
        super().__init__(key)
        self.key = key


class Resolver:
    """Computes entries by key, each after those that it reads, from those of the file (`given`, overrides among them)
    and the formulas of keys that it may leave out (`computed`). `reads` has, for each key with a formula, the keys that
    it reads, in the order of computation."""

    def __init__(
        self,
        given: Mapping[str, FileEntry],
        keys: Mapping[str, Declaration],
        computed: Mapping[str, Computed],
        materials: Sequence[str],
        file: str,
    ) -> None:
        self._given, self._keys, self._materials, self._file = given, keys, tuple(materials), file
        self._formulas = computed
        self.entries: dict[str, Entry] = {}
        self.reads: dict[str, set[str]] = {}
        self._open: list[str] = []

    def all(self) -> dict[str, Entry]:
        """Every entry of the design."""
        for key in self._keys:
            self.entry(key)
        return self.entries

    def entry(self, key: str) -> Entry:
        """The entry of a key; in a long chain of formulas, those that the first ones need come first."""
        wanted = [key]
        while wanted:
            try:
                self._entry(wanted[-1])
                wanted.pop()
            except _TooDeepError as error:
                self._open.clear()
                if error.key in wanted:
                    raise InputError(f"{self._file}: {error.key}: its formula depends on itself") from None
                wanted.append(error.key)
        return self.entries[key]

    def _entry(self, key: str) -> Entry:
        if key in self.entries:
            return self.entries[key]
        if len(self._open) >= DEEPEST and key not in self._open:
            raise _TooDeepError(key)
        if key in self._open:
            circle = [*self._open[self._open.index(key) :], key]
            raise InputError(f"{self._file}: {key}: its formula depends on itself: {' -> '.join(circle)}")
        self._open.append(key)
        found = self._resolved(key)
        self._open.pop()
        self.entries[key] = found
        return found

    def read(self, key: str) -> Entry:
        """The entry of a key, recorded as read by the formula that is being evaluated."""
        self.reads.setdefault(self._open[-1], set()).add(key)
        return self._entry(key)

    def _resolved(self, key: str) -> Entry:
        declaration, given = self._keys[key], self._given.get(key)
        if given is not None and isinstance(given.value, ByRow):
            given = self._of_row(given.value)
        if given is not None:
            if is_formula(given.value):
                return self._from_formula(key, given, declaration)
            if isinstance(given.value, str):
                return _read_text(key, given, declaration, self._materials)
            return read_entry(key, given, declaration, self._materials)
        if not declaration.computed:
            raise InputError(
                f"{self._file}: {key} is missing ({declaration.meaning or 'see the packaged design'}); add it, "
                'or begin the file with extends = "thesis" to take missing values from the packaged design'
            )
        return self._computed(key, declaration)

    def _of_row(self, value: ByRow) -> FileEntry | None:
        """The entry that the chosen row of a project's table has, or else that of the file."""
        row = str(self.read(value.key).value)
        if row == NO_ROW:
            return value.otherwise
        if row not in value.rows:
            place = self._given[value.key].place
            raise InputError(f"{place} = {quoted(row)}: no such row in {value.file}{nearest(row, value.rows)}")
        return value.rows[row] or value.otherwise

    def _from_formula(self, key: str, given: FileEntry, declaration: Declaration) -> Entry:
        if declaration.kind not in ("number", "count"):
            raise InputError(f"{given.place} = '{given.value}': is not a number, so it cannot be a formula")
        with at_place(f"{given.place} = '{given.value}'"):
            formula = parse_formula(given.value)

        unit = declaration.unit
        value = attribute_value(formula.value(self._number, unit, given.place), unit)
        return read_formula(key, given, f"{SIGN}{formula.text}", value, declaration)

    def _computed(self, key: str, declaration: Declaration) -> Entry:
        """Entry of a key that the file leaves out, from the formula of the key."""
        formula, unit = self._formulas[key], declaration.unit
        number = parse_formula(formula.text).value(self._number, unit, f"{self._file}: {key}")
        value = int(number) if declaration.kind == "count" else attribute_value(number, unit)
        text = f"{value:.10g} {unit}".strip()
        if not in_bounds(value, declaration):
            raise InputError(
                f"{self._file}: {key} becomes {text}, from {formula.text}; it {bounds_text(declaration, value)}"
            )
        return Entry(key, text, value, unit, formula.tolerance, f"computed: {formula.text}", declaration.meaning)

    def _number(self, key: str) -> Value:
        """The number of a key that a formula reads."""
        if key not in self._keys:
            raise FormulaError(f"no parameter '{key}'{nearest_key(key, self._keys)}")
        entry = self.read(key)
        if isinstance(entry.value, bool | str):
            raise FormulaError(f"parameter '{key}' = '{entry.text}' is not a number")
        return Value(to_si(float(entry.value), entry.unit), unit_dimension(entry.unit))


@lru_cache(maxsize=4096)
def _read_text(key: str, given: FileEntry, declaration: Declaration, materials: tuple[str, ...]) -> Entry:
    """`read_entry` of a text. A program reads most texts of a design many times, with few of them changed."""
    return read_entry(key, given, declaration, materials)


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
