"""What a machine states of itself for its parameter file; the packaged one is found by its name alone.

A machine has a folder of one name in each package that has content of it: `stagecad.NAME` has tables, rules, parts and
assembly, `designcalc.NAME` its checks, `drawings.NAME` its sheets. The tool finds them by this name (`content`). The
folder of the packaged machine is `PACKAGED`; machines of the user's own (`[machine]`) have that of `DECLARED`.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field, fields
from functools import cache
from importlib import import_module
from pathlib import Path
from typing import Any, get_type_hints

from stagecad.parameters.entry import FileEntry
from stagecad.parameters.project_tables import Kind
from stagecad.parameters.schema import Declaration, declarations
from stagecad.parameters.threads import Thread

PACKAGED = "friction_stage"
DECLARED = "declared"
MATERIALS = "materials"
"""The table that has one sub-table for each material; its names are free."""


@dataclass(frozen=True)
class Computed:
    """Value of a key that the file leaves out: a formula (`stagecad.parameters.formula`), and its tolerance class."""

    text: str
    tolerance: str | None = None


@dataclass(frozen=True)
class DeclaredPart:
    """A kind of part.

    Args:
        key: name in the machine.
        file: of a part of the user's own, in the folder of the parameter file; empty for a packaged part.
        part: name of the packaged part, or the `NAME` that the user's file states.
        parameters: values that differ from the file's defaults, or from those of the parameter file.
        description: for the list of parts; empty for that of the part itself.
        purchased: whether a part of the user's own is bought: its file states a `PART_NUMBER`.
    """

    key: str
    file: str
    part: str
    parameters: Mapping[str, str]
    description: str
    purchased: bool = False


@dataclass(frozen=True)
class Mate:
    """An instance of a part, or several, and where they are put.

    Args:
        name: of the instance; of several with a number after it.
        part: key of its kind.
        datum: of the part; empty for the fixed instance.
        on: instance that it is put on, and that one's datum; empty for the fixed instance. A datum with a `*` is each
            one of such a name.
        offset: along x, y and normal of the datum it is put on: lengths or formulas, as written.
        turn: about this normal: angle or formula, as written.
    """

    name: str
    part: str
    datum: str = ""
    on: tuple[str, str] = ("", "")
    offset: tuple[str, str, str] = ("0 mm", "0 mm", "0 mm")
    turn: str = "0 deg"

    @property
    def is_pattern(self) -> bool:
        """Whether it is put on several datums."""
        return "*" in self.on[1]


@dataclass(frozen=True)
class MachineDeclaration:
    """A machine of the user's own; `mates` in an order in which each follows the one that it is put on.

    Args:
        file: the parameter file, for messages.
        folder: of the parameter file.
        parts, mates: in their order.
        overlaps: pairs of kinds of part that may share volume.
        tables: table of the parameters of each own part, by its key: this key, or the part's `NAME` where a packaged
            table has it.
    """

    file: str
    folder: Path
    description: str
    parts: tuple[DeclaredPart, ...]
    mates: tuple[Mate, ...]
    overlaps: frozenset[frozenset[str]]
    tables: Mapping[str, str] = field(default_factory=dict)

    def part(self, key: str) -> DeclaredPart:
        """The part of a key."""
        return next(part for part in self.parts if part.key == key)


@dataclass(frozen=True)
class Machine:
    """The tables of a machine's parameter file, and the rules between their values.

    Args:
        name: of its folder in each package.
        tables: dataclass with one attribute for each table.
        material: the table of one material.
        design: class of its designs, with the tables as attributes (`stagecad.parameters.design.Design`).
        computed: formulas of keys that the file may leave out.
        bounded: a declaration with the physical range of its key.
        kinds: kinds of the project's tables of hardware, by name.
        rules: names of the modules with rules.
        owners: parts that a table of the parameter file belongs to; a table without one belongs to no part.
        declaration: of a machine of the user's own.
        own: declarations of the parameters of its own parts, and their values, by key.
        file: packaged parameter file.
        threads: of the project's own table, by name.
    """

    name: str
    tables: type
    material: type
    design: type
    computed: Mapping[str, Computed]
    bounded: Callable[[str, Declaration], Declaration]
    kinds: Callable[[], Mapping[str, Kind]]
    rules: tuple[str, ...]
    owners: Mapping[str, tuple[str, ...]]
    file: Path
    declaration: MachineDeclaration | None = None
    own: Mapping[str, tuple[Declaration, FileEntry]] = field(default_factory=dict)
    threads: Mapping[str, Thread] = field(default_factory=dict)

    def schema(self, materials: tuple[str, ...] = ("NAME",)) -> dict[str, Declaration]:
        """Every key that a parameter file with these materials may contain, with its declaration."""
        keys = _schema(self.tables, self.material, self.bounded, materials)
        return {**keys, **{key: declaration for key, (declaration, _) in self.own.items()}} if self.own else keys

    @property
    def table_names(self) -> frozenset[str]:
        """Names of the tables of the parameter file."""
        return frozenset(item.name for item in fields(self.tables)) | {MATERIALS}

    @property
    def slot_kinds(self) -> dict[str, str]:
        """The kind of table of each part that may choose a row."""
        return {slot: name for name, kind in self.kinds().items() for slot in kind.slots}


@cache
def packaged_machine() -> Machine:
    """The machine of the thesis."""
    return import_module(f"stagecad.{PACKAGED}").MACHINE


def content(package: str, machine: Machine, module: str = "") -> Any:
    """The module, or one below it, in which a package states what it has of a machine."""
    return import_module(".".join(word for word in (package, machine.name, module) if word))


@cache
def _schema(
    tables: type, material: type, bounded: Callable[[str, Declaration], Declaration], materials: tuple[str, ...]
) -> dict[str, Declaration]:
    every = {**dict(_tables(tables)), **{f"{MATERIALS}.{name}": material for name in materials}}
    return {
        f"{prefix}.{name}": bounded(f"{prefix}.{name}", declaration)
        for prefix, table in every.items()
        for name, declaration in declarations(table).items()
    }


def _tables(table: type, prefix: str = "") -> Iterator[tuple[str, type]]:
    """Every table by its dotted name (`stage`, `screws.way`), without materials."""
    if declarations(table):
        yield prefix, table
        return
    hints = get_type_hints(table)
    for item in fields(table):
        yield from _tables(hints[item.name], f"{prefix}.{item.name}" if prefix else item.name)
