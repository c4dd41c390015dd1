"""The table `[machine]` of a parameter file: parts and mates of a machine of the user's own.

```toml
[machine]
description = "ball-screw slide"
overlaps = [["screw", "nut"]]                     # pairs that may share volume, such as threads

[machine.parts]
base = {file = "slide_base.py", parameters = {length = "400.0 mm"}}
way = {part = "bearing_way", parameters = {"bearing_way.length" = "300 mm"}}      # a packaged part

[machine.mates]
base = {}                                         # the one that is fixed
way_1 = {part = "way", datum = "bottom", on = "base.top", offset = ["0 mm", "40 mm", "0 mm"], turn = "90 deg"}
```

A mate puts the datum of a part on a datum of another one: origins together, normals opposed, x directions parallel. The
offset moves it along x, y and the normal of the datum that it is put on, and `turn` turns it about this normal. Lengths
and angles may be formulas of parameters.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import PurePath
from typing import TYPE_CHECKING, Any

from stagecad.parameters.errors import InputError, nearest
from stagecad.parameters.formula import FormulaError, Value, is_formula, parse_formula
from stagecad.parameters.units import from_si, parse_quantity, to_si, unit_dimension

if TYPE_CHECKING:
    from stagecad.parameters.design import Design

_PART_FIELDS = ("file", "part", "parameters", "description")
_MATE_FIELDS = ("part", "datum", "on", "offset", "turn")


@dataclass(frozen=True)
class DeclaredPart:
    """A kind of part.

    Args:
        key: name in the machine.
        file: of a part of the user's own, in the folder of the parameter file; empty for a packaged part.
        part: name of the packaged part; empty for one of the user's own.
        parameters: values that differ from the file's defaults, or from those of the parameter file.
        description: for the list of parts; empty for that of the part itself.
    """

    key: str
    file: str
    part: str
    parameters: Mapping[str, str]
    description: str


@dataclass(frozen=True)
class Mate:
    """One instance of a part, and where it is put.

    Args:
        name: of the instance.
        part: key of its kind.
        datum: of the part; empty for the fixed instance.
        on: instance that it is put on, and that one's datum; empty for the fixed instance.
        offset: along x, y and normal of the datum it is put on, mm.
        turn: about this normal, deg.
    """

    name: str
    part: str
    datum: str = ""
    on: tuple[str, str] = ("", "")
    offset: tuple[float, float, float] = (0.0, 0.0, 0.0)
    turn: float = 0.0


@dataclass(frozen=True)
class MachineDeclaration:
    """A machine of the user's own; `mates` in an order in which each follows the one that it is put on."""

    description: str
    parts: tuple[DeclaredPart, ...]
    mates: tuple[Mate, ...]
    overlaps: frozenset[frozenset[str]]
    """pairs of kinds of part that may share volume"""


def read_machine(table: Mapping[str, Any], file: str, design: Design) -> MachineDeclaration:
    """Read the table `[machine]`.

    Args:
        table: as parsed.
        file: for messages.
        design: of the file, for formulas.

    Raises:
        InputError: what is wrong, with file, key and what is allowed.
    """
    place = f"{file}: machine"
    _known(table, ("description", "overlaps", "parts", "mates"), place)
    parts = {key: _part(key, value, place) for key, value in _table(table, "parts", place).items()}
    written = {key: _mate(key, value, parts, place, design) for key, value in _table(table, "mates", place).items()}
    overlaps = table.get("overlaps", [])
    if not isinstance(overlaps, list) or any(not isinstance(pair, list) or len(pair) != 2 for pair in overlaps):
        raise InputError(f'{place}.overlaps: write pairs of parts, like [["screw", "nut"]]')
    for pair in overlaps:
        for key in pair:
            _one_of(str(key), parts, f"{place}.overlaps", "part")
    allowed = frozenset(frozenset(map(str, pair)) for pair in overlaps)
    return MachineDeclaration(
        str(table.get("description", "")), tuple(parts.values()), _ordered(written, place), allowed
    )


def _table(table: Mapping[str, Any], key: str, place: str) -> Mapping[str, Any]:
    found = table.get(key)
    if not isinstance(found, dict) or not found:
        raise InputError(f"{place}.{key} is missing; write a table [machine.{key}]")
    return found


def _known(table: Mapping[str, Any], known: tuple[str, ...], place: str) -> None:
    for key in table:
        _one_of(key, known, place, "key")


def _one_of(word: str, known: Any, place: str, what: str) -> None:
    if word not in known:
        raise InputError(f"{place}: no {what} '{word}'{nearest(word, list(known))}")


def _part(key: str, value: Any, place: str) -> DeclaredPart:
    place = f"{place}.parts.{key}"
    if not isinstance(value, dict) or ("file" in value) == ("part" in value):
        raise InputError(f'{place}: write {{file = "my_part.py"}}, or {{part = "bearing_way"}} for a packaged part')
    _known(value, _PART_FIELDS, place)
    file = str(value.get("file", ""))
    if file and (PurePath(file).is_absolute() or ".." in PurePath(file).parts):
        raise InputError(f"{place}.file = '{file}': is outside the folder of the parameter file; copy it there")
    parameters = value.get("parameters", {})
    if not isinstance(parameters, dict) or not all(isinstance(text, str) for text in _flat(parameters).values()):
        raise InputError(f'{place}.parameters: write {{length = "80.0 mm"}}')
    description = str(value.get("description", ""))
    return DeclaredPart(key, file, str(value.get("part", "")), _flat(parameters), description)


def _flat(table: Mapping[str, Any], prefix: str = "") -> dict[str, Any]:
    """Dotted keys of nested tables: TOML reads an unquoted `bearing_way.length` as a table in a table."""
    found: dict[str, Any] = {}
    for key, value in table.items():
        found.update(_flat(value, f"{prefix}{key}.") if isinstance(value, dict) else {f"{prefix}{key}": value})
    return found


def _mate(name: str, value: Any, parts: Mapping[str, DeclaredPart], place: str, design: Design) -> Mate:
    place = f"{place}.mates.{name}"
    if not isinstance(value, dict):
        raise InputError(f'{place}: write {{datum = "bottom", on = "base.top"}}, or {{}} for the fixed part')
    _known(value, _MATE_FIELDS, place)
    part = str(value.get("part", name))
    _one_of(part, parts, place, "part")
    if "on" not in value:
        if set(value) - {"part"}:
            raise InputError(f'{place}: has no "on"; write on = "PART.DATUM"')
        return Mate(name, part)
    on, dot, datum = str(value["on"]).rpartition(".")
    if not dot or "datum" not in value:
        raise InputError(f'{place}: write datum = "bottom" and on = "PART.DATUM"')
    offset = value.get("offset", ["0 mm"] * 3)
    if not isinstance(offset, list) or len(offset) != 3:
        raise InputError(f'{place}.offset: write three lengths, like ["0 mm", "20 mm", "0 mm"]')
    x, y, z = (_number(text, "mm", f"{place}.offset", design) for text in offset)
    turn = _number(value.get("turn", "0 deg"), "deg", f"{place}.turn", design)
    return Mate(name, part, str(value["datum"]), (on, datum), (x, y, z), turn)


def _number(text: Any, unit: str, place: str, design: Design) -> float:
    """A length or an angle in a unit, possibly a formula of parameters."""
    if not is_formula(text):
        return from_si(parse_quantity(text, unit, place), unit)

    def parameter(key: str) -> Value:
        try:
            entry = design.entry(key)
        except InputError as error:
            raise FormulaError(str(error)) from None
        if isinstance(entry.value, bool | str):
            raise FormulaError(f"parameter '{key}' = '{entry.text}' is not a number")
        return Value(to_si(float(entry.value), entry.unit), unit_dimension(entry.unit))

    try:
        formula = parse_formula(text)
    except FormulaError as error:
        raise InputError(f"{place} = '{text}': {error}") from None
    return from_si(formula.value(parameter, unit, place), unit)


def _ordered(mates: Mapping[str, Mate], place: str) -> tuple[Mate, ...]:
    """Each after the one that it is put on; exactly one is fixed."""
    fixed = [mate.name for mate in mates.values() if not mate.datum]
    if len(fixed) != 1:
        raise InputError(f"{place}.mates: one part is fixed, written NAME = {{}}; here {', '.join(fixed) or 'none'} is")
    found: dict[str, Mate] = {fixed[0]: mates[fixed[0]]}
    while len(found) < len(mates):
        ready = [mate for mate in mates.values() if mate.name not in found and mate.on[0] in found]
        if not ready:
            left = next(mate for mate in mates.values() if mate.name not in found)
            _one_of(left.on[0], mates, f"{place}.mates.{left.name}.on", "part")
            raise InputError(f"{place}.mates.{left.name}: is put on parts that are put on it")
        found.update((mate.name, mate) for mate in ready)
    return tuple(found.values())
