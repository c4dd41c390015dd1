"""Parameter files read into a `Design`, compared, and changed."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, fields, replace
from pathlib import Path
from typing import Any, get_type_hints

from stagecad.parameters.atomic import atomic_write_text
from stagecad.parameters.derived import COMPUTED
from stagecad.parameters.design import Design, Materials
from stagecad.parameters.errors import InputError
from stagecad.parameters.file import (
    Entry,
    FileEntry,
    ParameterFile,
    attribute_value,
    bounds_text,
    in_bounds,
    parse_parameter_text,
    read_entry,
    read_parameter_file,
    require_origin,
)
from stagecad.parameters.rules.registry import require
from stagecad.parameters.schema import Declaration, declarations
from stagecad.parameters.tables.machine import MATERIALS, Tables, nearest_key, schema
from stagecad.parameters.tables.physics import Material
from stagecad.parameters.units import to_si


def load_design(path: str | Path | None = None, overrides: Sequence[str] = (), *, rules: bool = True) -> Design:
    """Read a parameter file into a design.

    Args:
        path: the file; the packaged thesis design when left out.
        overrides: `KEY=VALUE` texts that replace values of the file, as in `--set`.
        rules: whether the design must satisfy the rules across values; each value is checked in any case.

    Raises:
        InputError: one line with file, key, value, and what is allowed.
    """
    return _design(read_parameter_file(path), overrides, rules)


def design_from_text(text: str, name: str, overrides: Sequence[str] = (), *, rules: bool = True) -> Design:
    """As `load_design`, from the text of a parameter file; `name` is the file's name in messages."""
    return _design(parse_parameter_text(text, name), overrides, rules)


def _design(file: ParameterFile, overrides: Sequence[str], rules: bool) -> Design:
    given = dict(file.entries)
    if file.extends is not None:
        given = {**read_parameter_file().entries, **given}
    materials = sorted({key.split(".")[1] for key in given if key.startswith(f"{MATERIALS}.")})
    keys = schema(tuple(materials))
    for key in given:
        if key not in keys:
            raise InputError(f"{file.name}: no parameter '{key}'{nearest_key(key, keys)}")
    for text in overrides:
        key, entry = _override(text, keys, given)
        given[key] = entry
    entries: dict[str, Entry] = {}
    for key, declaration in keys.items():
        if key in given:
            entries[key] = read_entry(key, given[key], declaration, materials)
        elif not declaration.computed:
            raise InputError(
                f"{file.name}: {key} is missing ({declaration.meaning or 'see the packaged design'}); add it, "
                'or begin the file with extends = "thesis" to take missing values from the packaged design'
            )
    for key in COMPUTED:
        if key not in entries:
            entries[key] = _computed(key, entries, file.name)
    design = _typed(entries, tuple(keys), materials, file.name)
    if rules:
        require(design)
    return design


def _override(text: str, keys: Mapping[str, Declaration], given: Mapping[str, FileEntry]) -> tuple[str, FileEntry]:
    if not text.isprintable():
        raise InputError(f"--set {text!r}: contains characters that cannot be printed")
    key, equals, value = (part.strip() for part in text.partition("="))
    if not equals or not key or not value:
        raise InputError(f"--set '{text}': write KEY=VALUE, like stage.length=240mm")
    if key not in keys:
        raise InputError(f"--set: no parameter '{key}'{nearest_key(key, keys)}")
    source = given.get(key) or COMPUTED.get(key)
    return key, FileEntry(value, f"--set {key}", source.tolerance if source else None, "assumed: given by --set")


class _PartialDesign:
    """Tables that are not complete yet: attributes by dotted key."""

    def __init__(self, entries: Mapping[str, Entry], prefix: str = "") -> None:
        self._entries, self._prefix = entries, prefix

    def __getattr__(self, name: str) -> Any:
        key = f"{self._prefix}{name}"
        return self._entries[key].value if key in self._entries else _PartialDesign(self._entries, f"{key}.")


def _computed(key: str, entries: Mapping[str, Entry], file: str) -> Entry:
    """Entry of a key that the file leaves out, from the formula of the key."""
    formula, declaration = COMPUTED[key], schema()[key]
    value = formula.value(_PartialDesign(entries))
    unit = declaration.unit
    value = int(value) if declaration.kind == "count" else attribute_value(to_si(value, unit), unit)
    text = f"{value:.10g} {unit}".strip()
    if not in_bounds(value, declaration):
        raise InputError(f"{file}: {key} becomes {text}, from {formula.text}; it {bounds_text(declaration)}")
    return Entry(key, text, value, unit, formula.tolerance, f"computed: {formula.text}", declaration.meaning)


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


@dataclass(frozen=True)
class Difference:
    """A key in which two designs differ; None where a design lacks the key."""

    key: str
    before: Entry | None
    after: Entry | None


def diff(design_a: Design, design_b: Design) -> tuple[Difference, ...]:
    """Keys whose value, tolerance or origin differ, in the order of the first design."""

    def without_text(entry: Entry | None) -> Entry | None:
        # The same length written as 1 in and as 25.4 mm is no difference.
        return replace(entry, text="") if entry else None

    a_by_key, b_by_key = ({entry.key: entry for entry in design.entries} for design in (design_a, design_b))
    keys = [*a_by_key, *(key for key in b_by_key if key not in a_by_key)]
    pairs = [(key, a_by_key.get(key), b_by_key.get(key)) for key in keys]
    return tuple(Difference(key, a, b) for key, a, b in pairs if without_text(a) != without_text(b))


def write_values(path: str | Path, changes: Mapping[str, tuple[str | float | bool, str]]) -> None:
    """Write values into a parameter file, with their origins; comments, order and all other entries stay.

    Args:
        path: the parameter file.
        changes: by dotted key (`bearing.dynamic_friction`): the value to be written (`"12.05 mm"`; a number
            or truth value is written as such) and its origin (`measured: EXPERIMENT`).

    Raises:
        InputError: the file or a value is invalid; then the file is left unchanged.
    """
    atomic_write_text(path, check_values(path, changes))


def check_values(path: str | Path, changes: Mapping[str, tuple[str | float | bool, str]]) -> str:
    """The text that `write_values` would write, checked as a whole; arguments and errors as there."""
    read_parameter_file(path)
    with Path(path).open(encoding="utf-8-sig", newline="") as stream:
        text = stream.read()
    return changed_text(text, str(path), changes)


def changed_text(text: str, name: str, changes: Mapping[str, tuple[str | float | bool, str]]) -> str:
    """Text of a parameter file with values and origins replaced, checked as a whole; `name` is for messages."""
    import tomlkit
    from tomlkit.items import InlineTable

    document = tomlkit.parse(text)
    for key, (value, origin) in changes.items():
        place = f"{name}: {key}"
        require_origin(origin, place)
        *tables, last = key.split(".")
        if not tables:
            raise InputError(f"{place}: a key is written TABLE.NAME, like stage.length")
        parent: Any = document
        for table in tables:
            if table not in parent:
                parent[table] = tomlkit.table()
            parent = parent[table]
        if not isinstance(parent.get(last), InlineTable):
            parent[last] = tomlkit.inline_table()
        parent[last]["value"] = value
        parent[last]["origin"] = origin
    changed = tomlkit.dumps(document)
    design_from_text(changed, name)
    return changed
