"""What is known before a fit, and the unknowns: `[rig.known]`, with uncertainty or from the design, and priors."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any, Literal

from stagecad.parameters.errors import InputError, nearest, require
from stagecad.parameters.units import parse_uncertain
from sysid.experiment.column_settings import RATED
from sysid.experiment.rigs import LISTED, RigKind
from sysid.experiment.toml_table import TomlTable, check_value, quantity_text


@dataclass(frozen=True)
class Prior:
    """Prior knowledge of a value before the fit: its value and standard deviation."""

    value: float
    std: float


@dataclass(frozen=True)
class Unknown:
    """One unknown of a fit: key, start, bounds, typical size, and prior."""

    key: str
    start: float
    low: float
    high: float
    size: float
    prior: Prior | None = None


@dataclass(frozen=True)
class DesignValue:
    """A value from the design, SI, its standard deviation if the design states one, and its bounds there."""

    value: float
    std: float | None = None
    low: float | None = None
    high: float | None = None


DesignValues = Mapping[str, float | DesignValue] | Callable[[str], float | DesignValue]
"""SI values of settings given as `"design"`, by the name of the known quantity or by `effect.parameter`."""


@dataclass(frozen=True)
class Known:
    """A known quantity of the rig, SI, with its standard deviation if given, from the file or from the design."""

    value: float
    std: float | None = None
    origin: Literal["given", "design"] = "given"


def known_axes(table: TomlTable, kind: RigKind) -> list[tuple[str, bool]]:
    """Whether the axis is rotary according to the unit of each known value that determines it, by place in the file."""
    table.allow((*kind.known, *(RATED + channel for channel in kind.channels)), LISTED)
    if "mass" in table.data and "inertia" in table.data:
        raise InputError(f"{table.where()}: 'mass' and 'inertia' are both given; one of them is required")
    axes = []
    for key, value in _quantities(table):
        declared = kind.known[key]
        if value == "design" or declared.unit == declared.rotary_unit:
            continue
        text = quantity_text(table, key, declared.unit)
        try:
            parse_uncertain(text, declared.unit, table.where(key))
            axes.append((f"rig.known.{key}", False))
        except InputError as linear:
            try:
                parse_uncertain(text, declared.rotary_unit, table.where(key))
            except InputError:
                raise linear from None
            axes.append((f"rig.known.{key}", True))
    return axes


def _quantities(table: TomlTable) -> list[tuple[str, Any]]:
    """The entries without the rated values of channels (`columns.settings.rated_values`)."""
    return [(key, value) for key, value in table.data.items() if not key.startswith(RATED)]


def read_known(table: TomlTable, kind: RigKind, rotary: bool, design: DesignValues | None) -> dict[str, Known]:
    """The known values in SI; `inertia` is filed under `mass`."""
    known: dict[str, Known] = {}
    for key, value in _quantities(table):
        declared = kind.known[key]
        if key == "inertia" and not rotary:
            raise InputError(f"{table.where(key)}: the axis is linear; write mass = '1 kg'")
        unit = declared.si_unit(rotary)
        filed = "mass" if key == "inertia" else key
        if value == "design":
            found = design_value(design, filed, rotary, table.where(key))
            known[filed] = Known(found.value, found.std, "design")
            continue
        number, std = parse_uncertain(quantity_text(table, key, unit), unit, table.where(key))
        check_value(number, declared.positive, table, key)
        if std is not None and not std > 0.0:
            raise InputError(f"{table.where(key)}: '{value}': the uncertainty must be above zero")
        known[filed] = Known(number, std)
    return known


def design_value(design: DesignValues | None, key: str, rotary: bool, where: str) -> DesignValue:
    """The value of `key` in the design; `where` names its place in the file."""
    if design is None:
        raise InputError(f"{where}: 'design' needs a parameter file, and none is given; write the quantity")
    require(not rotary, f"{where}: the design is of a linear axis; write the quantity")
    if callable(design):
        try:
            found = design(key)
        except InputError as error:
            # An error about a key of this file names the file.
            file = where.partition(": ")[0] + ": " if str(error).startswith(("rig.", "model.")) else ""
            raise InputError(f"{file}{error}") from None
    elif key not in design:
        raise InputError(f"{where}: the design has no '{key}'{nearest(key, design)}")
    else:
        found = design[key]
    return found if isinstance(found, DesignValue) else DesignValue(float(found))
