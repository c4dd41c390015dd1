"""Parameter files read into a `Design`, compared, and changed."""

import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from stagecad.deferred import tomlkit
from stagecad.parameters.atomic import atomic_write_text
from stagecad.parameters.design import Design
from stagecad.parameters.errors import InputError, ViolationsError, require
from stagecad.parameters.file import (
    PACKAGED,
    ParameterFile,
    class_by_decimals,
    parameter_text,
    parse_parameter_text,
    read_entry,
    read_parameter_file,
    require_origin,
)
from stagecad.parameters.formula import is_formula
from stagecad.parameters.machine import MATERIALS, Computed, Machine, packaged_machine
from stagecad.parameters.machine_declaration import declared_machine, require_mates, stated_parameters
from stagecad.parameters.override import override
from stagecad.parameters.project_tables import HARDWARE, NO_ROW, ROW, ProjectTable
from stagecad.parameters.rules import by_part, violation_documents, violations
from stagecad.parameters.schema import TOLERANCE_CLASSES, ByRow, Declaration, Entry, FileEntry, nearest_key
from stagecad.parameters.threads import Thread, threads
from stagecad.parameters.units import quoted
from stagecad.parameters.variations import Source, Variations


def load_design(path: str | Path | None = None, overrides: Sequence[str] = (), *, rules: bool = True) -> Design:
    """Read a parameter file into a design.

    Args:
        path: the file; the packaged thesis design when left out.
        overrides: `KEY=VALUE` texts that replace values of the file, as in `--set`.
        rules: whether the design must satisfy the rules across values; each value is checked in any case.
    """
    return design_of(read_parameter_file(path), overrides, rules)


def design_from_text(
    text: str, name: str, overrides: Sequence[str] = (), *, rules: bool = True, folder: Path | None = None
) -> Design:
    """Like `load_design`, from the text of a parameter file; `name` and `folder` as in `parse_parameter_text`."""
    return design_of(parse_parameter_text(text, name, folder), overrides, rules)


def variations_of(file: ParameterFile, overrides: Sequence[str] = ()) -> Variations:
    """Like `design_of` without rules: the design, and fast changes of its values."""
    return Variations(_source(file, overrides))


def further_override(file: ParameterFile, overrides: Sequence[str] = ()) -> Callable[[str], Design]:
    """What gives the design with one more override, without regard to rules; only what depends on it is computed."""
    variations = variations_of(file, overrides)
    return lambda override: variations.of(_source(file, (*overrides, override)))


def design_of(file: ParameterFile, overrides: Sequence[str], rules: bool) -> Design:
    """Like `load_design`, of a file that is read."""
    variations = variations_of(file, overrides)
    require_mates(variations.design)
    if rules:
        design = variations.design
        found = by_part(violations(design))
        if found:
            more = f" (and {len(found) - 1} more)" if len(found) > 1 else ""
            lines = [f"{design.file}: {one.message}" for one in found]
            lines = [lines[0] + more, *lines[1:]]
            raise ViolationsError(lines, lambda: violation_documents(design, found, variations.changed))
    return variations.design


def part_design(file: ParameterFile, overrides: Sequence[str], path: Path) -> Design:
    """The design of a machine that is one part of the user's own, with its parameters beside those of a file."""
    stated = stated_parameters(path)
    name = stated.name if stated else path.stem
    if name in packaged_machine().table_names or not name.isidentifier():
        raise InputError(f"{path}: NAME = {name!r}; write small letters, digits and _, no name of the machine's own")
    machine = {"description": "-", "parts": {name: {"file": path.name}}, "mates": {name: {}}}
    # It has materials and drawing data of the packaged machine, and of a machine of one's own no values of other parts.
    packaged, others = file is read_parameter_file(), (file.machine or {}).get("parts", ())
    known = {f"{name}.{key}" for key in (stated.parameters if stated else ())}
    entries = {
        key: entry
        for key, entry in file.entries.items()
        if not packaged and (key.partition(".")[0] not in others or key in known)
    }
    # A formula of values of other parts is its value.
    reads = re.compile(rf"\b({'|'.join(other for other in others if other != name) or '$'})\s*\.")
    outside = [key for key, entry in entries.items() if is_formula(entry.value) and reads.search(str(entry.value))]
    whole = design_of(file, (), rules=False) if outside else None
    for found in (whole.entry(key) for key in outside) if whole else ():
        entries[found.key] = replace(entries[found.key], value=f"{found.value!r} {found.unit}".strip())
    extends = PACKAGED if packaged else file.extends
    own = replace(file, entries=entries, extends=extends, machine=machine, folder=path.parent)
    return design_of(own, overrides, rules=False)


def _source(file: ParameterFile, overrides: Sequence[str]) -> Source:
    machine = packaged_machine()
    if file.machine is not None:
        machine = declared_machine(machine, file.machine, file.name, file.folder)
    own = {key: entry for key, (_, entry) in machine.own.items()}
    # A value of the file keeps the class of the one in the file of the part, by its decimals where it states none.
    classes = {
        key: replace(entry, tolerance=entry.tolerance or class_by_decimals(str(entry.value)))
        for key, entry in own.items()
        if machine.own[key][0].unit == "mm" and not is_formula(entry.value)
    }
    given = {**own, **{key: _with_class(entry, classes.get(key), None) for key, entry in file.entries.items()}}
    if file.extends is not None:
        packaged = read_parameter_file().entries
        given = {
            **packaged,
            **{key: _with_class(entry, packaged.get(key), machine.computed.get(key)) for key, entry in given.items()},
        }
    given = {**given, **{key: entry for key, entry in _of_machine(machine, file).items() if key not in file.entries}}
    machine = replace(machine, threads=_own_threads(machine, file.tables))
    given.update(_plain_rows(file.tables, machine.schema()))
    materials = tuple(sorted({key.split(".")[1] for key in given if key.startswith(f"{MATERIALS}.")}))
    keys = machine.schema(materials)
    # Every cell, also of rows that are not chosen.
    for kind, row in ((table.kind, row) for table in file.tables for row in table.rows):
        for column, cell in row.cells.items():
            read_entry(column, cell, machine.kinds()[kind].columns[column], materials)
    for key in given:
        if key not in keys:
            raise InputError(f"{file.name}: no parameter '{key}'{nearest_key(key, keys)}")
    given.update(_chosen_rows(machine, file.tables, given))
    for text in overrides:
        key, entry = override(text, keys, given, machine)
        given[key] = entry
    for slot, kind in machine.slot_kinds.items():
        entry = given.get(f"{slot}.{ROW}")
        if entry and entry.value != NO_ROW and kind not in {table.kind for table in file.tables}:
            raise InputError(
                f"{entry.place} = {quoted(entry.value)}: there is no table of {kind.replace('_', ' ')}; "
                f'name its file in the parameter file: [{HARDWARE}] {kind} = "{kind}.csv"'
            )
    for key, declaration in keys.items():
        if key not in given and declaration.default is not None:
            given[key] = FileEntry(declaration.default, f"{file.name}: {key}", origin="assumed: default")
    overridden = tuple(text.partition("=")[0].strip() for text in overrides)
    return Source(machine, given, keys, materials, file.name, overridden)


def _with_class(entry: FileEntry, packaged: FileEntry | None, computed: Computed | None) -> FileEntry:
    """An entry with the packaged tolerance class, unless it states one, or a closer one by its decimals."""
    tolerance = (packaged and packaged.tolerance) or (computed and computed.tolerance) or None
    if tolerance is None or entry.tolerance is not None or not isinstance(entry.value, str):
        return entry
    bare = entry.origin is None and not is_formula(entry.value)
    # More decimals are a longer class: X, X.X, X.XX.
    if bare and tolerance in TOLERANCE_CLASSES and len(class_by_decimals(entry.value)) > len(tolerance):
        return entry
    return replace(entry, tolerance=tolerance)


def _of_machine(machine: Machine, file: ParameterFile) -> dict[str, FileEntry]:
    """Entries of the title block that follow from the name of a machine of the user's own."""
    if machine.declaration is None or file.extends is None:
        return {}
    texts = {"drawing.file_assembly": "assembly", "drawing.file_procedure": "procedure"}
    if machine.declaration.description:
        texts["drawing.title"] = machine.declaration.description
    return {key: FileEntry(text, f"{file.name}: machine", origin="assumed: [machine]") for key, text in texts.items()}


def _own_threads(machine: Machine, tables: Sequence[ProjectTable]) -> dict[str, Thread]:
    """Rows of the project's table of threads."""
    found: dict[str, Thread] = {}
    for row in (row for table in tables if table.kind == "threads" for row in table.rows):
        columns = machine.kinds()["threads"].columns
        values = {column: read_entry(column, cell, columns[column], ()).value for column, cell in row.cells.items()}
        known = threads().get(row.name, Thread(row.name, "", 0.0, 0.0, 0.0, ""))
        found[row.name] = replace(known, **values, source=row.origin)
    return found


def _plain_rows(tables: Sequence[ProjectTable], keys: Mapping[str, Declaration]) -> dict[str, FileEntry]:
    """Entries of the tables whose rows are all used: materials, and threads that the parameter file has keys for."""
    found: dict[str, FileEntry] = {}
    for table in tables:
        prefix, joint = {"materials": (MATERIALS, "."), "threads": ("threads", "_")}.get(table.kind, ("", ""))
        for row in table.rows if prefix else ():
            for column, cell in row.cells.items():
                key = f"{prefix}.{row.name}{joint}{column}"
                if prefix == MATERIALS or key in keys:
                    found[key] = cell
    return found


def _chosen_rows(
    machine: Machine, tables: Sequence[ProjectTable], given: Mapping[str, FileEntry]
) -> dict[str, FileEntry]:
    """Entries of the parts that choose a row; what no row has stays that of the file."""
    found: dict[str, FileEntry] = {}
    for table in tables:
        for slot in machine.kinds()[table.kind].slots:
            for column in {column: None for row in table.rows for column in row.cells}:
                key = f"{slot}.{column}"
                present = given.get(key) or machine.computed.get(key)
                tolerance = present.tolerance if present else None
                cells = {row.name: row.cells.get(column) for row in table.rows}
                rows = {name: cell and replace(cell, tolerance=tolerance) for name, cell in cells.items()}
                value = ByRow(f"{slot}.{ROW}", table.file, rows, given.get(key))
                found[key] = FileEntry(value, f"{table.file}: {key}", tolerance)
    return found


@dataclass(frozen=True)
class Difference:
    """A key in which two designs differ; None where a design lacks the key."""

    key: str
    before: Entry | None
    after: Entry | None


def diff(design_a: Design, design_b: Design) -> tuple[Difference, ...]:
    """Keys whose value, tolerance or origin differ, in the order of the first design."""

    def without_text(entry: Entry | None) -> Entry | None:
        # The same length written as 1 in, as 25.4 mm or as a formula is not a difference.
        return replace(entry, text="", formula="", free="") if entry else None

    a_by_key, b_by_key = ({entry.key: entry for entry in design.entries} for design in (design_a, design_b))
    keys = [*a_by_key, *(key for key in b_by_key if key not in a_by_key)]
    pairs = [(key, a_by_key.get(key), b_by_key.get(key)) for key in keys]
    return tuple(Difference(key, a, b) for key, a, b in pairs if without_text(a) != without_text(b))


def write_values(path: str | Path, changes: Mapping[str, tuple[str | float | bool, str]]) -> None:
    """Write values into a parameter file, with their origins; comments, order and all other entries stay."""
    atomic_write_text(path, check_values(path, changes))


def check_values(path: str | Path, changes: Mapping[str, tuple[str | float | bool, str]]) -> str:
    """The text that `write_values` would write, checked as a whole; arguments and errors as there."""
    read_parameter_file(path)
    return changed_text(parameter_text(path), str(path), changes)


def changed_text(
    text: str, name: str, changes: Mapping[str, tuple[str | float | bool, str]], folder: Path | None = None
) -> str:
    """Text of a parameter file with values and origins replaced, checked as a whole.

    `name` and `folder` as of `parse_parameter_text`.
    """
    from tomlkit.items import InlineTable

    document = tomlkit.parse(text)
    for key, (value, origin) in changes.items():
        place = f"{name}: {key}"
        require_origin(origin, place)
        *tables, last = key.split(".")
        require(tables, f"{place}: a key is written TABLE.NAME, like stage.length")
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
    design_from_text(changed, name, folder=folder)
    return changed
