"""The table `[machine]` of a parameter file: parts and mates of a machine of the user's own.

```toml
[machine]
description = "ball-screw slide"
overlaps = [["screw", "nut"]]                     # pairs that may share volume, such as threads

[machine.parts]
base = {file = "slide_base.py", parameters = {length = "400.0 mm"}}
way = {part = "bearing_way", parameters = {"bearing_way.length" = "300 mm"}}      # a packaged part
screw = {part = "ISO 4762 M6x20"}                 # a standard part (`stagecad.declared.standard_part`)

[machine.mates]
base = {}                                         # the one that is fixed
way_1 = {part = "way", datum = "bottom", on = "base.top", offset = ["0 mm", "40 mm", "0 mm"], turn = "90 deg"}
screws = {part = "screw", datum = "seat", on = "base.hole_*"}                     # one on each datum of this name
```

A mate puts the datum of a part on a datum of another one: origins together, normals opposed, x directions parallel. The
offset moves it along x, y and the normal of the datum that it is put on, and `turn` turns it about this normal. Lengths
and angles may be formulas of parameters. The `PARAMETERS` of a part's file are keys of the parameter file too:
`base.length`.
"""

import ast
import re
from collections.abc import Mapping
from contextlib import suppress
from dataclasses import dataclass, replace
from pathlib import Path, PurePath
from typing import Any

from stagecad.parameters.design import Design
from stagecad.parameters.errors import InputError, at_place, require, require_known
from stagecad.parameters.file import written_entry
from stagecad.parameters.formula import Value, is_formula, parse_formula
from stagecad.parameters.input_file import read_named
from stagecad.parameters.machine import DECLARED, DeclaredPart, Machine, MachineDeclaration, Mate
from stagecad.parameters.names import identifier
from stagecad.parameters.schema import Declaration, FileEntry
from stagecad.parameters.units import from_si, parse_any, parse_quantity, si_unit, unit_dimension

_PART_FIELDS = ("file", "part", "parameters", "description")
_MATE_FIELDS = ("part", "datum", "on", "offset", "turn")
_ANGLE, _LENGTH = unit_dimension("deg"), unit_dimension("mm")
_FIT = re.compile(r"(\d+(?:\.\d+)?)(?: mm)? ([A-Za-z]{1,2}\d{1,2})")


def declared_machine(base: Machine, table: Mapping[str, Any], file: str, folder: Path) -> Machine:
    """The machine that a table `[machine]` states, with the parameters of its own parts."""
    declaration = read_machine(table, file, folder)
    own: dict[str, tuple[Declaration, FileEntry]] = {}
    packaged, parts, tables = base.table_names, [], {}
    for part in declaration.parts:
        if not part.file:
            parts.append(part)
            continue
        stated = stated_parameters(folder / part.file)
        if stated is None:
            parts.append(part)
            continue
        name, parameters = stated.name, stated.parameters
        parts.append(replace(part, part=name, purchased=stated.purchased))
        tables[part.key] = name if part.key in packaged else part.key
        for key in part.parameters:
            if key not in parameters:
                raise InputError(
                    f"machine.parts.{part.key}.parameters: {part.file} has no '{key}': {', '.join(parameters)}"
                )
        values = parameter_entries(tables[part.key], {**parameters, **part.parameters}, folder / part.file)
        own.update((f"{tables[part.key]}.{last}", value) for last, value in values.items())
    declaration = replace(declaration, parts=tuple(parts), tables=tables)
    return replace(base, name=DECLARED, declaration=declaration, own=own)


@dataclass(frozen=True)
class Stated:
    """`NAME` and `PARAMETERS` of a part's file, and whether it has a `PART_NUMBER`."""

    name: str
    parameters: dict[str, Any]
    purchased: bool


def stated_parameters(path: Path) -> Stated | None:
    """What a part's file states, read without running it; None where it is not Python, or lacks these words."""
    data = read_named(path)
    try:
        tree = ast.parse(data)
    except (SyntaxError, ValueError, RecursionError, MemoryError):
        # The message names the line when the file is run.
        return None
    found: dict[str, Any] = {}
    for node in tree.body:
        if isinstance(node, ast.Assign) and isinstance(node.targets[0], ast.Name):
            word = node.targets[0].id
            if word == "PART_NUMBER":
                found[word] = True
            if word in ("NAME", "PARAMETERS"):
                try:
                    found[word] = ast.literal_eval(node.value)
                except (ValueError, TypeError, RecursionError, MemoryError):
                    raise InputError(f"{path}: line {node.lineno}: write {word} as plain text, not computed") from None
    name, parameters = found.get("NAME"), found.get("PARAMETERS")
    if not isinstance(name, str) or not isinstance(parameters, dict):
        return None
    return Stated(name, parameters, "PART_NUMBER" in found)


def parameter_entries(
    table: str, parameters: Mapping[str, Any], path: Path
) -> dict[str, tuple[Declaration, FileEntry]]:
    """Declarations and values of a part's own parameters by name: lengths, angles and whole numbers of its solid, and
    quantities that its checks read, such as `"0.35 kg"`, kept in SI.

    Each is a quantity; a length possibly with a fit (`"60.0 mm"`, `"25 k6"`), an angle (`"30 deg"`), a formula of
    parameters and of those before it (`"= 2*width + 5 mm"`), a whole number, or a table with `value`, `tolerance` and
    `origin`.
    """
    found: dict[str, tuple[Declaration, FileEntry]] = {}
    for key, written in parameters.items():
        place = f"{path}: PARAMETERS[{key!r}]"
        value = written.get("value") if isinstance(written, dict) else written
        whole = isinstance(value, int) and not isinstance(value, bool)
        if not (isinstance(key, str) and key.isidentifier() and key.islower() and (whole or isinstance(value, str))):
            raise InputError(f"{place}: write a name and a length, like 'width': '40.0 mm'")
        if isinstance(value, str) and value.strip().isdigit():
            raise InputError(f"{place}: '{value}' has no unit; write '{value.strip()} mm', or a count without quotes")
        entry = written_entry(place, written) if isinstance(written, dict) else FileEntry(written, place)
        if isinstance(value, str):
            entry = replace(entry, value=_named(value, table, found))
            if fit := _FIT.fullmatch(value.strip()):
                entry = replace(entry, value=f"{fit[1]} mm", tolerance=fit[2])
        found[key] = (_declaration(entry.value, f"of {table}", place), entry)
    return found


def _named(text: str, table: str, known: Mapping[str, Any]) -> str:
    """A formula with the names of parameters before it as their keys; any other text as it is."""
    if not is_formula(text):
        return text
    return re.sub(r"(?<![\w.])([a-z]\w*)(?![\w.(])", lambda m: f"{table}.{m[1]}" if m[1] in known else m[1], text)


def _declaration(value: str | int, meaning: str, place: str) -> Declaration:
    if isinstance(value, int):
        return Declaration("count", meaning, low=0, high=100_000)
    dimension = _LENGTH
    if not is_formula(value):
        with suppress(InputError):
            dimension = parse_any(value)[2]
    if dimension == _ANGLE:
        return Declaration("number", meaning, "deg", low=-360.0, high=360.0)
    if dimension in (_LENGTH, unit_dimension("")):
        return Declaration("number", meaning, "mm", low=0.0, closed=False)
    return Declaration("number", meaning, si_unit(dimension))


def read_machine(table: Mapping[str, Any], file: str, folder: Path) -> MachineDeclaration:
    """Read the table `[machine]`, without the parts' files."""
    place = f"{file}: machine"
    _known(table, ("description", "overlaps", "parts", "mates", "chains"), place)
    parts = {key: _part(key, value, place) for key, value in _table(table, "parts", place).items()}
    written = {key: _mate(key, value, parts, place) for key, value in _table(table, "mates", place).items()}
    overlaps = table.get("overlaps", [])
    if not isinstance(overlaps, list) or any(not isinstance(pair, list) or len(pair) != 2 for pair in overlaps):
        raise InputError(f'{place}.overlaps: write pairs of parts, like [["screw", "nut"]]')
    for pair in overlaps:
        for key in pair:
            require_known(str(key), parts, f"{place}.overlaps: no part '{key}'")
    allowed = frozenset(frozenset(map(str, pair)) for pair in overlaps)
    description = str(table.get("description", ""))
    chains = _table(table, "chains", place) if "chains" in table else {}
    formulas = {name: _checked(text, "mm", f"{place}.chains.{name}") for name, text in chains.items()}
    mates = _ordered(written, place)
    for key in parts.keys() - {mate.part for mate in mates}:
        raise InputError(f"{place}.parts.{key}: no mate puts it into the machine; write one in [machine.mates]")
    return MachineDeclaration(file, folder, description, tuple(parts.values()), mates, allowed, formulas)


def _table(table: Mapping[str, Any], key: str, place: str) -> Mapping[str, Any]:
    found = table.get(key)
    if not isinstance(found, dict) or not found:
        raise InputError(f"{place}.{key} is missing; write a table [machine.{key}]")
    return found


def _known(table: Mapping[str, Any], known: tuple[str, ...], place: str) -> None:
    for key in table:
        require_known(key, known, f"{place}: no key '{key}'")


def _part(key: str, value: Any, place: str) -> DeclaredPart:
    place = f"{place}.parts.{key}"
    identifier(key, place)
    if not isinstance(value, dict) or ("file" in value) == ("part" in value):
        raise InputError(f'{place}: write {{file = "my_part.py"}}, or {{part = "bearing_way"}} for a packaged part')
    _known(value, _PART_FIELDS, place)
    file = str(value.get("file", ""))
    if file and (PurePath(file).is_absolute() or ".." in PurePath(file).parts):
        raise InputError(f"{place}.file = '{file}': is outside the folder of the parameter file; copy it there")
    if file and PurePath(file).suffix != ".py":
        raise InputError(
            f"{place}.file = '{file}': is no Python file; `stagecad drawings --part {file}` writes one for a STEP file"
        )
    parameters = value.get("parameters", {})
    if not isinstance(parameters, dict) or not all(isinstance(text, str) for text in _flat(parameters).values()):
        raise InputError(f'{place}.parameters: write {{length = "80.0 mm"}}')
    return DeclaredPart(key, file, str(value.get("part", "")), _flat(parameters), str(value.get("description", "")))


def _flat(table: Mapping[str, Any], prefix: str = "") -> dict[str, Any]:
    """Dotted keys of nested tables: TOML reads an unquoted `bearing_way.length` as a table in a table."""
    found: dict[str, Any] = {}
    for key, value in table.items():
        found.update(_flat(value, f"{prefix}{key}.") if isinstance(value, dict) else {f"{prefix}{key}": value})
    return found


def _mate(name: str, value: Any, parts: Mapping[str, DeclaredPart], place: str) -> Mate:
    place = f"{place}.mates.{name}"
    identifier(name, place)
    if not isinstance(value, dict):
        raise InputError(f'{place}: write {{datum = "bottom", on = "base.top"}}, or {{}} for the fixed part')
    _known(value, _MATE_FIELDS, place)
    part = str(value.get("part", name))
    require_known(part, parts, f"{place}: no part '{part}'")
    if "on" not in value:
        if set(value) - {"part"}:
            raise InputError(f'{place}: has no "on"; write on = "PART.DATUM"')
        return Mate(name, part)
    on, dot, datum = str(value["on"]).rpartition(".")
    require(dot and "datum" in value, f'{place}: write datum = "bottom" and on = "PART.DATUM"')
    offset = value.get("offset", ["0 mm"] * 3)
    if not isinstance(offset, list) or len(offset) != 3:
        raise InputError(f'{place}.offset: write three lengths, like ["0 mm", "20 mm", "0 mm"]')
    texts = [_checked(text, "mm", f"{place}.offset") for text in offset]
    turn = _checked(value.get("turn", "0 deg"), "deg", f"{place}.turn")
    return Mate(name, part, str(value["datum"]), (on, datum), (texts[0], texts[1], texts[2]), turn)


def _checked(text: Any, unit: str, place: str) -> str:
    """A length, an angle or a formula as written."""
    if not is_formula(text):
        parse_quantity(text, unit, place)
    else:
        with at_place(f"{place} = '{text}'"):
            parse_formula(text)
    return str(text)


def placed_values(design: Design, mate: Mate) -> tuple[tuple[float, float, float], float]:
    """Offset, mm, and turn, deg, of a mate in a design."""
    place = f"{design.file}: machine.mates.{mate.name}"
    x, y, z = (declared_number(text, "mm", f"{place}.offset", design) for text in mate.offset)
    return (x, y, z), declared_number(mate.turn, "deg", f"{place}.turn", design)


def declared_number(text: str, unit: str, place: str, design: Design, shifted: str = "", by: float = 0.0) -> float:
    """A length or an angle in a unit, possibly a formula of parameters, of which one is shifted, SI."""
    if not is_formula(text):
        return from_si(parse_quantity(text, unit, place), unit)

    def parameter(key: str) -> Value:
        entry = design.entry(key)
        return Value(entry.si + (by if key == shifted else 0.0), unit_dimension(entry.unit))

    return from_si(parse_formula(text).value(parameter, unit, place), unit)


def require_mates(design: Design) -> None:
    """Check that every formula of a mate has a value."""
    for mate in design.machine.declaration.mates if design.machine.declaration else ():
        placed_values(design, mate)


def _ordered(mates: Mapping[str, Mate], place: str) -> tuple[Mate, ...]:
    """Each after the one that it is put on; exactly one is fixed."""
    fixed = [mate.name for mate in mates.values() if not mate.datum]
    if len(fixed) != 1:
        raise InputError(f"{place}.mates: one part is fixed, written NAME = {{}}; here {', '.join(fixed) or 'none'} is")
    found: dict[str, Mate] = {fixed[0]: mates[fixed[0]]}
    while len(found) < len(mates):
        ready = [mate for mate in mates.values() if mate.name not in found and _parent(mate.on[0], found)]
        if not ready:
            left = next(mate for mate in mates.values() if mate.name not in found)
            if _parent(left.on[0], mates) is None:
                known = [f"{mate.name}_1" if mate.is_pattern else mate.name for mate in mates.values()]
                require_known(left.on[0], known, f"{place}.mates.{left.name}.on: no part '{left.on[0]}'")
            raise InputError(f"{place}.mates.{left.name}: is put on parts that are put on it")
        found.update((mate.name, mate) for mate in ready)
    return tuple(found.values())


def _parent(name: str, mates: Mapping[str, Mate]) -> Mate | None:
    """The mate that gives an instance: of this name, or the pattern whose numbered instance it is."""
    if name in mates and not mates[name].is_pattern:
        return mates[name]
    pattern, _, number = name.rpartition("_")
    return mates[pattern] if pattern in mates and mates[pattern].is_pattern and number.isdigit() else None
