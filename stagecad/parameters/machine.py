"""What a machine states of itself for its parameter file; the packaged one is found by its name alone.

A machine has a folder of one name in each package that has content of it: `stagecad.NAME` has tables, rules, parts and
assembly, `designcalc.NAME` its checks, `drawings.NAME` its sheets. The tool finds them by this name (`content`). The
folder of the packaged machine is `PACKAGED`; machines of the user's own (`[machine]`) have that of `DECLARED`.
"""

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field, fields
from functools import cache
from importlib import import_module
from pathlib import Path
from typing import Any, get_type_hints

from stagecad.parameters.project_tables import Kind
from stagecad.parameters.schema import Declaration, FileEntry, declarations
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
    """A kind of part."""

    key: str  # name in the machine
    file: str  # of a part of the user's own, in the folder of the parameter file; empty for a packaged part
    part: str  # name of the packaged part, or the `NAME` that the user's file states
    parameters: Mapping[str, str]  # values that differ from the file's defaults, or from those of the parameter file
    description: str  # for the list of parts; empty for that of the part itself
    purchased: bool = False  # whether a part of the user's own is bought: its file states a `PART_NUMBER`


@dataclass(frozen=True)
class Mate:
    """An instance of a part, or several, and where they are put."""

    name: str  # of the instance; of several with a number after it
    part: str  # key of its kind
    datum: str = ""  # of the part; empty for the fixed instance
    # instance that it is put on, and that one's datum; empty for the fixed instance. A datum with a `*` is each one of
    # such a name
    on: tuple[str, str] = ("", "")
    # along x, y and normal of the datum it is put on: lengths or formulas, as written
    offset: tuple[str, str, str] = ("0 mm", "0 mm", "0 mm")
    turn: str = "0 deg"  # about this normal: angle or formula, as written

    @property
    def is_pattern(self) -> bool:
        """Whether it is put on several datums."""
        return "*" in self.on[1]


@dataclass(frozen=True)
class MachineDeclaration:
    """A machine of the user's own; `mates` in an order in which each follows the one that it is put on."""

    file: str  # the parameter file, for messages
    folder: Path  # of the parameter file
    description: str
    parts: tuple[DeclaredPart, ...]  # in their order
    mates: tuple[Mate, ...]  # in their order
    overlaps: frozenset[frozenset[str]]  # pairs of kinds of part that may share volume
    chains: Mapping[str, str] = field(default_factory=dict)  # formulas of functional distances, by name
    # table of the parameters of each own part, by its key: this key, or the part's `NAME` where a packaged table has it
    tables: Mapping[str, str] = field(default_factory=dict)

    def part(self, key: str) -> DeclaredPart:
        """The part of a key."""
        return next(part for part in self.parts if part.key == key)

    def has(self, name: str) -> bool:
        """Whether a name that has a mass is that of a part, or of the whole machine."""
        return name == "machine" or any(part.key == name for part in self.parts)


@dataclass(frozen=True)
class Machine:
    """The tables of a machine's parameter file, and the rules between their values."""

    name: str  # of its folder in each package
    tables: type  # dataclass with one attribute for each table
    material: type  # the table of one material
    design: type  # class of its designs, with the tables as attributes (`stagecad.parameters.design.Design`)
    computed: Mapping[str, Computed]  # formulas of keys that the file may leave out
    bounded: Callable[[str, Declaration], Declaration]  # a declaration with the physical range of its key
    kinds: Callable[[], Mapping[str, Kind]]  # kinds of the project's tables of hardware, by name
    rules: tuple[str, ...]  # names of the modules with rules
    # parts that a table of the parameter file belongs to; a table without one belongs to no part
    owners: Mapping[str, tuple[str, ...]]
    file: Path  # packaged parameter file
    declaration: MachineDeclaration | None = None  # of a machine of the user's own
    # declarations of the parameters of its own parts, and their values, by key
    own: Mapping[str, tuple[Declaration, FileEntry]] = field(default_factory=dict)
    threads: Mapping[str, Thread] = field(default_factory=dict)  # of the project's own table, by name

    def schema(self, materials: tuple[str, ...] = ("NAME",)) -> dict[str, Declaration]:
        """Every key that a parameter file with these materials may contain, with its declaration."""
        keys = _schema(self.tables, self.material, self.bounded, materials)
        return {**keys, **{key: declaration for key, (declaration, _) in self.own.items()}} if self.own else keys

    def own_key(self, name: str) -> str:
        """A table or key as the entries have it: a part of the user's own may have the key of a packaged one."""
        table, dot, last = name.partition(".")
        return f"{self.declaration.tables.get(table, table) if self.declaration else table}{dot}{last}"

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
    for name, part in get_type_hints(table).items():
        yield from _tables(part, f"{prefix}.{name}" if prefix else name)
