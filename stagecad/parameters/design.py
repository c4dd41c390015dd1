"""The machine as a typed, frozen `Design`, read from a parameter file.

Units: an attribute of a table is in millimetres (or degrees) where it is geometry, and in SI otherwise; each table says
which. Geometry code reads attributes (`design.stage.length`, mm); calculators and simulation ask `design.si(key)`,
which is SI for every key. This is the one place where the two meet.
"""

from __future__ import annotations

import hashlib
import json
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, fields
from functools import cache, cached_property
from pathlib import Path
from typing import Any, get_type_hints

from stagecad.parameters.derived import COMPUTED, Derived
from stagecad.parameters.entry import Entry, bounds_text, kept, read_entry, within
from stagecad.parameters.errors import InputError, nearest
from stagecad.parameters.parameter_file import FileEntry, ParameterFile, parse_parameter_text, read_parameter_file
from stagecad.parameters.quantities import to_si
from stagecad.parameters.schema import Declaration, declarations
from stagecad.parameters.tables import alternatives, hardware, parts, physics

MATERIALS = "materials"


@dataclass(frozen=True)
class Materials(Mapping[str, physics.Material]):
    """Materials by name."""

    named: tuple[tuple[str, physics.Material], ...]

    def __getitem__(self, name: str) -> physics.Material:
        for known, material in self.named:
            if known == name:
                return material
        raise KeyError(name)

    def __iter__(self) -> Iterator[str]:
        return (name for name, _ in self.named)

    def __len__(self) -> int:
        return len(self.named)


@dataclass(frozen=True)
class Design:
    """Every number of the machine. One attribute per table of the parameter file, as the tables declare them."""

    stage: parts.Stage
    pads: parts.Pads
    sea: parts.Sea
    bearing_way: parts.BearingWay
    base: parts.Base
    actuator: physics.Actuator
    tip: parts.Tip
    holder: parts.Holder
    height_pin_1: parts.HeightPin1
    height_pin_2: parts.HeightPin2
    teeth: parts.Teeth
    tooth_bar: parts.ToothBar
    tooth_iron: parts.ToothIron
    magnet: parts.Magnet
    preload: physics.Preload
    payload: physics.Payload
    piezo: hardware.Piezo
    amplifier: physics.Amplifier
    screws: hardware.Screws
    set_screw: hardware.SetScrew
    spring: hardware.Spring
    shim: hardware.Shim
    threads: hardware.Threads
    making: parts.Making
    drive: physics.Drive
    bearing: physics.Bearing
    friction: physics.Friction
    sensors: physics.Sensors
    requirements: physics.Requirements
    environment: physics.Environment
    candidates: alternatives.Candidates
    drawing: physics.Drawing
    materials: Materials
    entries: tuple[Entry, ...] = field(repr=False)
    file: str = "thesis.toml"
    """Name of the file it was read from."""

    @cached_property
    def derived(self) -> Derived:
        """Heights, places and envelopes that follow from the parameters."""
        return Derived(self)

    @cached_property
    def _by_key(self) -> dict[str, Entry]:
        return {entry.key: entry for entry in self.entries}

    def entry(self, key: str) -> Entry:
        """The entry of a key.

        Raises:
            InputError: no such key; names the nearest.
        """
        try:
            return self._by_key[key]
        except KeyError:
            raise InputError(f"no parameter '{key}'{nearest_key(key, self._by_key)}") from None

    def value(self, key: str) -> Any:
        """Value of a key as its attribute keeps it: mm or degrees for geometry, SI for all else."""
        return self.entry(key).value

    def si(self, key: str) -> float:
        """A number in SI, whatever its attribute keeps.

        Raises:
            InputError: no such key, or it is no number.
        """
        entry = self.entry(key)
        if isinstance(entry.value, bool | str):
            raise InputError(f"parameter '{key}' = '{entry.text}' is no number")
        return to_si(float(entry.value), entry.unit)

    def tolerance(self, key: str) -> str | None:
        """Tolerance class of a dimension; none where it has none."""
        return self.entry(key).tolerance

    def plus_minus(self, key: str) -> float:
        """How far a dimension may deviate either way by its tolerance class, mm; 0 where it has none."""
        name = {"X": "tolerance_x", "X.X": "tolerance_x_x", "X.XX": "tolerance_x_xx"}.get(self.tolerance(key) or "")
        return getattr(self.drawing, name) if name else 0.0

    def material(self, key: str) -> physics.Material:
        """Properties of the material that `key` names (`base.material`)."""
        return self.materials[str(self.value(key))]

    @cached_property
    def digest(self) -> str:
        """Sha256 over all values and tolerances: the same for files that differ in text alone."""
        words = [[entry.key, repr(entry.value), entry.tolerance] for entry in sorted(self.entries, key=lambda e: e.key)]
        return hashlib.sha256(json.dumps(words).encode()).hexdigest()


@cache
def _tables() -> dict[str, type]:
    """Every table by its dotted name (`stage`, `screws.way`), materials left out."""
    found: dict[str, type] = {}

    def walk(prefix: str, table: type) -> None:
        if declarations(table):
            found[prefix] = table
            return
        hints = get_type_hints(table)
        for item in fields(table):
            walk(f"{prefix}.{item.name}", hints[item.name])

    hints = get_type_hints(Design)
    for item in fields(Design):
        if item.name not in (MATERIALS, "entries", "file"):
            walk(item.name, hints[item.name])
    return found


@cache
def schema() -> dict[str, Declaration]:
    """Every key a parameter file may have, with what it holds; those of a material as `materials.NAME.density`."""
    keys = {
        f"{prefix}.{name}": declaration
        for prefix, table in _tables().items()
        for name, declaration in declarations(table).items()
    }
    keys.update(
        (f"{MATERIALS}.NAME.{name}", declaration) for name, declaration in declarations(physics.Material).items()
    )
    return keys


def _declaration(key: str, known_materials: Iterable[str]) -> Declaration | None:
    parts = key.split(".")
    if parts[0] == MATERIALS:
        if len(parts) != 3 or parts[1] not in known_materials:
            return None
        return declarations(physics.Material).get(parts[2])
    return schema().get(key)


def nearest_key(key: str, known: Iterable[str]) -> str:
    """Ending of a message about an unknown key: the nearest one, or those of its table."""
    keys = sorted(known)
    hint = nearest(key, keys)
    if key in {item.split(".")[0] for item in keys}:
        return f"; [{key}] is a table: name a key in it, like '{next(item for item in keys if item.startswith(key))}'"
    table, _, name = key.rpartition(".")
    if table.startswith(f"{MATERIALS}."):
        materials = {item.split(".")[1] for item in keys if item.startswith(f"{MATERIALS}.")}
        if table.split(".")[1] not in materials:
            return nearest(table.split(".")[1], materials).replace("did you mean", "did you mean material")
    if "did you mean" in hint:
        return hint
    table, _, name = key.rpartition(".")
    siblings = [item for item in keys if item.rpartition(".")[0] == table]
    if siblings:
        return f"; keys of [{table}]: {', '.join(item.rpartition('.')[2] for item in siblings)}"
    same = [item for item in keys if item.rpartition(".")[2] == name]
    if same:
        return f"; did you mean '{same[0]}'?"
    return nearest(key.split(".")[0], {item.split(".")[0] for item in keys})


def load_design(path: str | Path | None = None, overrides: Sequence[str] = (), *, rules: bool = True) -> Design:
    """Read a parameter file into a design.

    Args:
        path: the file; the packaged thesis design when left out.
        overrides: `KEY=VALUE` texts that replace values of the file, as `--set` takes them.
        rules: whether the rules across values must hold; without, each value still must be good in itself.

    Raises:
        InputError: one line that names file, key, value, and what is allowed.
    """
    return _design(read_parameter_file(path), overrides, rules)


def design_from_text(text: str, name: str, overrides: Sequence[str] = (), *, rules: bool = True) -> Design:
    """As `load_design`, from the text of a parameter file; `name` is what messages call it."""
    return _design(parse_parameter_text(text, name), overrides, rules)


def _design(file: ParameterFile, overrides: Sequence[str], rules: bool) -> Design:
    written = dict(file.entries)
    if file.extends is not None:
        written = {**read_parameter_file().entries, **written}
    materials = sorted({key.split(".")[1] for key in written if key.startswith(f"{MATERIALS}.")})
    known = [key for key in schema() if not key.startswith(f"{MATERIALS}.")]
    properties = declarations(physics.Material)
    known += [f"{MATERIALS}.{name}.{item}" for name in materials for item in properties]
    for key in written:
        if _declaration(key, materials) is None:
            raise InputError(f"{file.name}: no parameter '{key}'{nearest_key(key, known)}")
    for text in overrides:
        key, entry = _override(text, known, written)
        written[key] = entry
    entries: dict[str, Entry] = {}
    for key in known:
        declaration = _declaration(key, materials)
        assert declaration is not None
        if key in written:
            entries[key] = read_entry(key, written[key], declaration, materials)
        elif not declaration.computed:
            raise InputError(
                f"{file.name}: {key} is missing ({declaration.meaning or 'see the packaged design'}); add it, "
                'or begin the file with extends = "thesis" to take what is missing from the packaged design'
            )
    _compute(entries, known, file.name)
    design = _build(entries, known, materials, file.name)
    if rules:
        from stagecad.parameters.rules.registry import require

        require(design)
    return design


def _override(text: str, known: Sequence[str], written: Mapping[str, FileEntry]) -> tuple[str, FileEntry]:
    if not text.isprintable():
        raise InputError(f"--set {text!r}: holds characters that cannot be printed")
    key, equals, value = (part.strip() for part in text.partition("="))
    if not equals or not key or not value:
        raise InputError(f"--set '{text}': write KEY=VALUE, like stage.length=240mm")
    if key not in known:
        raise InputError(f"--set: no parameter '{key}'{nearest_key(key, known)}")
    before = written.get(key)
    formula = COMPUTED.get(key)
    tolerance = before.tolerance if before else formula.tolerance if formula else None
    return key, FileEntry(value, f"--set {key}", tolerance, "assumed: given by --set")


class _Partial:
    """Tables while they are being filled: attributes by dotted key."""

    def __init__(self, entries: Mapping[str, Entry], prefix: str = "") -> None:
        self._entries, self._prefix = entries, prefix

    def __getattr__(self, name: str) -> Any:
        key = f"{self._prefix}{name}"
        return self._entries[key].value if key in self._entries else _Partial(self._entries, f"{key}.")


def _compute(entries: dict[str, Entry], known: Sequence[str], file: str) -> None:
    """Add the values that the file leaves out."""
    for key, formula in COMPUTED.items():
        if key in entries:
            continue
        declaration = schema()[key]
        value = formula.value(_Partial(entries))
        if declaration.kind == "count":
            value = int(value)
        else:
            value = kept(to_si(value, declaration.unit), declaration.unit)
        shown = f"{value:.10g} {declaration.unit}".strip()
        if not within(value, declaration):
            raise InputError(f"{file}: {key} comes out as {shown}, from {formula.text}; it {bounds_text(declaration)}")
        entries[key] = Entry(
            key, shown, value, declaration.unit, formula.tolerance, f"computed: {formula.text}", declaration.meaning
        )


def _build(entries: Mapping[str, Entry], known: Sequence[str], materials: Sequence[str], file: str) -> Design:
    def table(kind: type, prefix: str) -> Any:
        return kind(**{name: entries[f"{prefix}.{name}"].value for name in declarations(kind)})

    def group(kind: type, prefix: str) -> Any:
        if declarations(kind):
            return table(kind, prefix)
        hints = get_type_hints(kind)
        return kind(**{item.name: group(hints[item.name], f"{prefix}.{item.name}") for item in fields(kind)})

    hints = get_type_hints(Design)
    names = [item.name for item in fields(Design) if item.name not in (MATERIALS, "entries", "file")]
    tables = {name: group(hints[name], name) for name in names}
    named = tuple((name, table(physics.Material, f"{MATERIALS}.{name}")) for name in materials)
    ordered = tuple(entries[key] for key in known)
    return Design(**tables, materials=Materials(named), entries=ordered, file=file)
