"""Fitted values written back to the parameter file, with their deviation, and the experiment as their origin."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from math import isfinite, sqrt
from pathlib import Path
from typing import Any

import numpy as np

from stagecad.parameters.errors import InputError, nearest, require, require_known
from stagecad.parameters.file import packaged_path
from stagecad.parameters.load import check_values, write_values
from stagecad.parameters.units import attributes, from_si, si_unit, unit_dimension
from sysid.documents import parameter_unit
from sysid.estimation.covariance import intervals, public_key
from sysid.estimation.fit import FittedModel
from sysid.experiment.ladder import file_lock
from sysid.prediction.force_balance.record import ForceBalanceRecord
from sysid.prediction.problem import Problem
from workbench.operations.design import Design
from workbench.operations.result import finite

LOCK_SECONDS = 10.0

Terms = Mapping[str, float]
"""A linear combination of fitted values: factor by public key."""


@dataclass(frozen=True)
class Written:
    """One value written back. SI units."""

    key: str  # of the parameter file
    value: float  # as measured
    std: float  # as measured
    unit: str  # SI unit
    text: str  # in the file now
    before: tuple[str, str]  # text that stood there, and where it came from
    origin: str  # of the value, as written in the file


@dataclass(frozen=True)
class WriteBack:
    """Fitted values to be written into a parameter file: all of them, or none."""

    # of the parameter file, each alone, or as `KEY=FITTED` where the fit's value has another name there
    keys: tuple[str, ...]
    design: Design  # of the user's own parameter file, perhaps with overrides

    def __post_init__(self) -> None:
        user_file(self.design)

    @property
    def path(self) -> Path:
        """The file."""
        return user_file(self.design)

    def check(self, problem: Problem, fitted: FittedModel, rung: int | None = None) -> list[Written]:
        """The values that `write` would write, checked together with the rest of the file; nothing is written."""
        origin = f"measured: {problem.experiment.folder.resolve().name}"
        origin += "" if rung is None else f", rung {rung:03d}"
        measured = _Measured(problem, fitted)
        terms = parameter_terms(self.design, problem)
        written = [_value(self.design, item, measured, terms, origin) for item in self.keys]
        check_values(self.path, {value.key: (value.text, value.origin) for value in written})
        return written

    def write(self, problem: Problem, fitted: FittedModel, rung: int | None = None) -> WrittenBack:
        """Write the values, with the experiment and the rung of its ladder as their origin; errors as of `check`."""
        target = self.path.resolve()
        with file_lock(target.with_name(f".{target.name}.lock"), LOCK_SECONDS, str(self.path)):
            written = self.check(problem, fitted, rung)
            write_values(self.path, {value.key: (value.text, value.origin) for value in written})
        return WrittenBack(self.path, tuple(written))


@dataclass(frozen=True)
class WrittenBack:
    """Values written into a parameter file."""

    path: Path
    values: tuple[Written, ...]
    document: Mapping[str, Any] = field(default_factory=dict)  # on the fit, where nothing was added

    def to_json(self) -> dict[str, Any]:
        """The file, and the values by key."""
        values = {}
        for value in self.values:
            before = dict(zip(("text", "origin"), value.before, strict=True))
            values[value.key] = {**attributes(value, "value", "unit", "std", "origin"), "before": before}
        return finite({**self.document, "parameter_file": str(self.path), "written_back": values})

    def lines(self) -> list[str]:
        """A line for each value, with what stood there before."""
        return [
            f"{self.path}: {v.key} = {v.text} ({v.origin}); it was {v.before[0]} ({v.before[1]})" for v in self.values
        ]


def user_file(design: Design) -> Path:
    """The user's own parameter file, which values are written to."""
    advice = "'stagecad params --write stage.toml' makes a file of your own; then give --params stage.toml"
    if design.path is None:
        raise InputError(f"--write-back: no stage.toml here, and the packaged design is not written to; {advice}")
    if design.path.resolve() == packaged_path().resolve():
        raise InputError(f"--write-back: {design.path}: the packaged design is not written to; {advice}")
    return design.path


def parameter_terms(design: Design, problem: Problem) -> dict[str, list[Terms]]:
    """Each key of the parameter file in terms of fitted values; the first entry that the model has is used."""
    friction = ("coulomb.force", "presliding.force")
    terms: dict[str, list[Terms]] = {
        "friction.coulomb": [{force: 1.0} for force in friction],
        "friction.breakaway": [{force: 1.0, "stribeck.force": 1.0} for force in friction],
        "friction.viscous": [{"viscous.coefficient": 1.0}],
        "friction.stribeck_velocity": [{"stribeck.velocity": 1.0}],
        "friction.bristle_stiffness": [{"presliding.stiffness": 1.0}],
        "friction.bristle_damping": [{"presliding.damping": 1.0}, {"bristle_damping.damping": 1.0}],
        "friction.mass": [{"rig.mass": 1.0}],
        "piezo.stroke": [{"rig.gain": design.si("piezo.highest_voltage")}],
    }
    loads = [r.axis.load for r in problem.fit_records if isinstance(r, ForceBalanceRecord)]
    if any("normal_load" in record.channels for record in problem.records) and loads:
        load = float(np.mean(np.concatenate(loads)))
        terms["bearing.dynamic_friction"] = [{force: 1.0 / load} for force in friction]
    return terms


class _Measured:
    """Fitted values by public key with units, their covariance, and those that the records do not determine."""

    def __init__(self, problem: Problem, fitted: FittedModel) -> None:
        computed = intervals(fitted, problem.fit_records)
        self.names, self.correlation = [public_key(key) for key in computed.keys], computed.correlation
        self.units = {public_key(key): parameter_unit(problem, key) for key in computed.keys}
        self.intervals = {public_key(key): interval for key, interval in computed.by_key.items()}
        self.values = {name: interval.value for name, interval in self.intervals.items()}
        self.untold = {
            name: "ended at its bound" if interval.at_bound else "is not identifiable from these records"
            for name, interval in self.intervals.items()
            if interval.at_bound or not isfinite(interval.std)
        }

    def covariance(self, a: str, b: str) -> float:
        together = 1.0 if a == b else float(self.correlation[self.names.index(a), self.names.index(b)])
        return together * self.intervals[a].std * self.intervals[b].std


def _value(design: Design, item: str, measured: _Measured, known: Mapping[str, list[Terms]], origin: str) -> Written:
    key, given, name = (part.strip() for part in item.partition("="))
    entry = design.values.entry(key)
    require(not isinstance(entry.value, bool | str), f"--write-back {item}: {key} is not a number")
    if given:
        require_known(name, measured.values, f"--write-back {item}: the fit has no '{name}'")
        terms: Terms | None = {name: 1.0}
    else:
        options = known.get(key, [])
        terms = next((option for option in options if all(part in measured.values for part in option)), None)
        if terms is None and options:
            raise InputError(
                f"--write-back {key}: the model has no {' and '.join(options[0])}, which it corresponds to"
            )
        if terms is None:
            near = nearest(key, known)
            raise InputError(f"--write-back {key}: no fitted value corresponds to it{near}; or write {key}=FITTED")
    assert terms is not None
    for part in terms:
        if part in measured.untold:
            raise InputError(f"--write-back {item}: {part} {measured.untold[part]}; nothing is written")
        unit = measured.units[part]
        if given and unit_dimension(unit) != unit_dimension(entry.unit):
            raise InputError(f"--write-back {item}: {name} is in {unit or '1'}, {key} in {entry.unit or '1'}")
    value = sum(factor * measured.values[part] for part, factor in terms.items())
    variance = sum(f * g * measured.covariance(a, b) for a, f in terms.items() for b, g in terms.items())
    unit = measured.units[next(iter(terms))]
    if unit_dimension(unit) != unit_dimension(entry.unit):
        unit = si_unit(unit_dimension(entry.unit))
    std = sqrt(max(variance, 0.0))
    shown = _unit_of(entry.text, entry.unit)
    return Written(key, value, std, unit, _text(value, std, shown), (entry.text, entry.origin), origin)


def _unit_of(text: str, unit: str) -> str:
    """The unit a quantity is written in, so that `1 mm/s` stays in mm/s; `unit` where it is unknown."""
    last = text.rpartition(" ")[2]
    try:
        return last if unit and unit_dimension(last) == unit_dimension(unit) else unit
    except InputError:
        return unit


def _text(value: float, std: float, unit: str) -> str:
    """`0.3127 +- 0.0041 N`: two digits of the deviation, and the value to the same place."""
    shown, deviation = (from_si(v, unit) if unit else v for v in (value, std))
    size = np.floor(np.log10(deviation)) if deviation > 0.0 else np.floor(np.log10(abs(shown) or 1.0)) - 8
    digits = int(max(np.floor(np.log10(abs(shown) or 1.0)) - size + 2, 2))
    return f"{shown:.{digits}g} +- {deviation:.2g} {unit}".rstrip()
