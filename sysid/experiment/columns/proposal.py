"""A proposal of an experiment from its files: kind of rig, channels and units, with questions where they are uncertain.

A column is assigned by its name and unit; the numbers identify only the time (it increases) and a velocity (the
derivative of another column). What is uncertain has a question, which the written file shows.
"""

from __future__ import annotations

import re
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from stagecad.parameters.errors import InputError
from stagecad.parameters.units import unit_dimension
from sysid.experiment.channels import parse_label
from sysid.experiment.columns.units import column_unit
from sysid.experiment.readers.open import RecordFile
from sysid.experiment.rig_kinds.declaration import find_rig
from sysid.experiment.rigs import CHANNELS, RigKind

WORDS: dict[str, str] = {
    "time": "time t zeit timestamp stamp sec secs seconds datetime clock",
    "pull_position": "pull puller",
    "velocity": "velocity vel v speed dq qd qdot xdot omega geschwindigkeit",
    "position": "position pos x q qm angle theta phi displacement disp encoder enc weg stroke laser lvdt winkel",
    "spring_force": "spring",
    "friction_force": "friction tangential reibung reibkraft",
    "drive_force": "drive motor current command cmd actuator strom",
    "normal_load": "normal fn fz load preload pressure druck normalkraft",
    "temperature": "temperature temp temperatur",
    "force": "force f torque tau moment kraft ft fx",
    "voltage": "voltage volt u spannung piezo",
}
"""Words in the names of columns by what they are taken for, the more specific first. `force` and `voltage` are not yet
channels: which ones they are depends on the kind of rig."""

LABVIEW_TIME = "x_value"
"""Name of the time column in a measurement file of LabVIEW (.lvm)."""

_UNITS = {
    "s": "time",
    "m": "position",
    "rad": "position",
    "m/s": "velocity",
    "rad/s": "velocity",
    "N": "force",
    "N*m": "force",
    "Pa": "normal_load",
    "A": "drive_force",
    "V": "voltage",
    "degC": "temperature",
}
"""Channel of a column by its dimension, where its name gives no indication."""

_SCALES = {("drive_force", "A"): "{si}/A", ("drive_force", "V"): "{si}/V", ("normal_load", "Pa"): "mm^2"}
"""Unit of the scale from a dimension to a channel of another one, `{si}` that of the channel."""

DERIVATIVE = 0.98
"""Correlation with the derivative of another column from which a column is its velocity."""

SAMPLE = 20_000
"""Rows that are compared."""


@dataclass(frozen=True)
class Proposal:
    """One column and what it is taken for.

    Args:
        number: of the column, from 1.
        label: as written.
        channel: what it is taken for; None if it is left out.
        unit: as it will be written; None if the header has it in brackets, `?` if it is not known.
        scale: unit of the scale that is needed; None if the unit is that of the channel.
        question: what the user should decide; empty if it is certain.
        increments: whether each cell is the change from the row before.
    """

    number: int
    label: str
    channel: str | None
    unit: str | None = None
    scale: str | None = None
    question: str = ""
    increments: bool = False


@dataclass(frozen=True)
class ExperimentProposal:
    """Kind of rig with its question to the user, and the columns."""

    kind: str
    question: str
    columns: tuple[Proposal, ...]
    rotary: bool


def propose(opened: RecordFile, columns: Mapping[int, np.ndarray], kind: str | None = None) -> ExperimentProposal:
    """A guess of the experiment by one of its files.

    Args:
        opened: the file.
        columns: its columns of numbers (n,) by index; others are left out.
        kind: of rig, where the user states it.
    """
    header = opened.header
    known = CHANNELS if kind is None else find_rig(kind, "--kind").all_channels
    guesses: dict[int, tuple[str, str, str | None]] = {}
    for index in columns:
        column = parse_label(index, header.labels[index])
        stated = header.units.get(column.label, column.unit)
        unit = column_unit(stated) if stated else None
        if unit is None and not header.numbered:
            unit = _unit_of_name(column.name)
        guesses[index] = (*_meaning(column.name, unit, header.numbered, known), unit)
    _by_numbers(guesses, columns)
    chosen, question = (kind, "") if kind else _kind({meaning for meaning, _, _ in guesses.values()})
    rig = find_rig(chosen, "--kind")
    found = _channels(guesses, rig)
    units = [unit for index, (_, _, unit) in guesses.items() if found.get(index, (None,))[0] is not None]
    rotary = any(_is_rotary(unit) for unit in units if unit) if rig.rotary is None else rig.rotary
    proposals = [
        _proposal(index, opened, found.get(index, (None, "")), guesses.get(index, ("", "", None))[2], rig, rotary)
        for index in range(len(header.labels))
    ]
    if _holds_intervals(columns, proposals):
        why = "is it the time from pulse to pulse, each of them a row?"
        question = "; ".join(part for part in (why, "what is its unit?" if guesses[0][2] is None else "") if part)
        proposals = [Proposal(1, proposals[0].label, "time", guesses[0][2] or "?", None, question, True)]
    return ExperimentProposal(chosen, question, tuple(proposals), rotary)


def _holds_intervals(columns: Mapping[int, np.ndarray], proposals: Sequence[Proposal]) -> bool:
    """Whether the only column may be the time from pulse to pulse: above zero, now longer, now shorter."""
    if len(proposals) != 1 or proposals[0].channel not in (None, "time") or 0 not in columns:
        return False
    values = columns[0][:SAMPLE]
    return bool(values.size > 2 and np.all(values > 0.0) and np.any(np.diff(values) <= 0.0))


def _meaning(name: str, unit: str | None, numbered: bool, known: Collection[str]) -> tuple[str, str]:
    """Proposed channel of a column, and the question to the user."""
    plain = name.strip().casefold()
    if plain in known:
        return plain, ""
    if plain == LABVIEW_TIME and unit is None:
        return "time", "by its name"
    words = [word for word in re.split(r"[^a-zäöüß]+", plain) if word]
    by_unit = _by_dimension(unit)
    if not numbered:
        for meaning, spoken in WORDS.items():
            fits = by_unit in (None, meaning) or {by_unit, meaning} in _ALIKE
            if fits and any(word in spoken.split() for word in words):
                return meaning, "" if meaning == "time" and by_unit == "time" else "by its name"
    return (by_unit, "by its unit") if by_unit else ("", "")


_ALIKE = (
    {"force", "drive_force"},
    {"force", "friction_force"},
    {"force", "spring_force"},
    {"force", "normal_load"},
    {"position", "pull_position"},
    {"voltage", "drive_force"},
)


def _unit_of_name(name: str) -> str | None:
    """The unit at the end of a name such as `position_mm`; none where a channel has no such unit."""
    parts = re.split(r"[\s_]+", name.strip())
    for k in range(1, len(parts)):
        unit = column_unit("/".join(part for part in parts[k:] if part != "per"))
        if unit is not None and (_by_dimension(unit) or any(_fits(unit, si) for si in ("m/s", "rad/s"))):
            return unit
    return None


def _by_dimension(unit: str | None) -> str | None:
    if unit is None:
        return None
    for si, meaning in _UNITS.items():
        if unit_dimension(unit) == unit_dimension(si):
            return meaning
    return None


def _is_rotary(unit: str) -> bool:
    return any(unit_dimension(unit) == unit_dimension(si) for si in ("rad", "rad/s", "N*m"))


def _by_numbers(guesses: dict[int, tuple[str, str, str | None]], columns: Mapping[int, np.ndarray]) -> None:
    """Tell time by its increase, and a velocity by its being the derivative of a position."""
    if not any(meaning == "time" for meaning, _, _ in guesses.values()):
        for index, (meaning, _, unit) in guesses.items():
            values = columns[index][:SAMPLE]
            if not meaning and values.size > 2 and np.all(np.diff(values) > 0.0):
                guesses[index] = ("time", "it increases from row to row", unit)
                break
    time = next((columns[i][:SAMPLE] for i, (meaning, _, _) in guesses.items() if meaning == "time"), None)
    if time is None or np.any(np.diff(time) <= 0.0):
        return
    unknown = [index for index, (meaning, _, _) in guesses.items() if meaning in ("", "position")]
    for one in unknown:
        for other in unknown:
            if one != other and not guesses[other][0] and _is_derivative(columns[one], columns[other], time):
                guesses[other] = ("velocity", f"it follows the derivative of column {one + 1}", guesses[other][2])
                if not guesses[one][0]:
                    guesses[one] = ("position", f"column {other + 1} follows its derivative", guesses[one][2])


def _is_derivative(position: np.ndarray, other: np.ndarray, time: np.ndarray) -> bool:
    position, other = position[:SAMPLE], other[:SAMPLE]
    if not (np.isfinite(position).all() and np.isfinite(other).all() and np.ptp(position) and np.ptp(other)):
        return False
    velocity = np.gradient(position, time)
    if not np.ptp(velocity):
        return False
    return abs(float(np.corrcoef(velocity, other)[0, 1])) > DERIVATIVE


_FORCES = ("force", "friction_force", "spring_force", "drive_force")


def _kind(meanings: set[str]) -> tuple[str, str]:
    """Kind of rig from the channels proposed for its columns, and the question to the user."""
    if {"tip_x", "tip_y", "voltage_1", "voltage_2"} <= meanings:
        return "actuator-tip", ""
    if "pull_position" in meanings:
        return "spring-pull", "" if "spring_force" in meanings else "does a spring of known stiffness pull the axis?"
    if {"voltage_1", "voltage_2", "position"} <= meanings:
        return "friction-drive", ""
    if "drive_force" in meanings:
        return (
            "force-drive",
            "does this force or current alone drive the axis, so that mass x acceleration = it - friction?",
        )
    if meanings & {"voltage", "voltage_1"} and "position" in meanings and not meanings & {"velocity", *_FORCES}:
        return "piezo", (
            "is it the displacement of a piezo under its voltage (piezo)? or does the voltage drive a motor "
            "(motor-voltage), or an amplifier with a force (force-drive)?"
        )
    if "friction_force" in meanings:
        return "velocity-drive", "is the motion imposed, and the friction measured by a load cell?"
    return "velocity-drive", (
        "is the motion imposed, and the force measured (velocity-drive)? or does the force drive the axis "
        "(force-drive), or a spring pull it (spring-pull)?"
    )


def _channels(guesses: Mapping[int, tuple[str, str, str | None]], rig: RigKind) -> dict[int, tuple[str, str]]:
    """Channel and question by index; each channel once, the more certain column first."""
    force = next((name for name in ("friction_force", "spring_force", "drive_force") if name in rig.channels), None)
    found: dict[int, tuple[str, str]] = {}
    own_voltages = [name for name in rig.own if _fits(rig.own[name].unit, "V")]
    voltages = iter(own_voltages or [name for name in rig.channels if name.startswith("voltage_")])
    for index, (meaning, why, _) in sorted(guesses.items(), key=lambda item: (bool(item[1][1]), item[0])):
        channel = force if meaning in ("force", "drive_force") and meaning not in rig.channels else meaning
        if meaning == "voltage":
            channel = next(voltages, "drive_force" if "drive_force" in rig.channels else None)
        if not channel or channel not in rig.channels:
            continue
        taken = [number for number, (other, _) in found.items() if other == channel]
        if not taken:
            found[index] = (channel, why)
        else:
            first = taken[0]
            found[first] = (channel, f"or is column {index + 1} '{channel}'?")
    for index, (_, _, unit) in guesses.items():
        left = [name for name in rig.own if name not in {channel for channel, _ in found.values()}]
        own = next((name for name in left if unit and _fits(unit, rig.own[name].unit)), None)
        if index not in found and own is not None:
            found[index] = (own, "by its unit")
    return found


def _proposal(
    index: int, opened: RecordFile, found: tuple[str | None, str], unit: str | None, rig: RigKind, rotary: bool
) -> Proposal:
    header, (channel, why) = opened.header, found
    label = header.labels[index].strip()
    if channel is None:
        return Proposal(index + 1, label, None)
    declared = rig.declared(channel)
    # A unit that the file has in brackets is read from there.
    written = None if parse_label(index, label).unit is not None or label in header.units else "?"
    question = f"taken for '{channel}' {why}" if why.startswith("by") else why
    if written == "?" and unit is not None and _unit_of_name(label) == unit:
        question = "; ".join(part for part in (question, f"its unit '{unit}' by its name") if part)
    if unit is None:
        question = "; ".join(part for part in (question, "what is its unit?") if part)
        return Proposal(index + 1, label, channel, "?", None, question)
    if _fits(unit, declared.unit) or _fits(unit, declared.rotary_unit):
        return Proposal(index + 1, label, channel, written if written is None else unit, None, question)
    scale = next((s for (name, si), s in _SCALES.items() if name == channel and _fits(unit, si)), "?")
    scale = scale.format(si=declared.si_unit(rotary))
    question = "; ".join(part for part in (question, f"what is its scale in {scale}?") if part)
    return Proposal(index + 1, label, channel, None, scale, question)


def _fits(unit: str, si: str) -> bool:
    return unit_dimension(unit) == unit_dimension(si)


def number_columns(opened: RecordFile) -> dict[int, np.ndarray]:
    """The columns of a file that hold numbers, by index."""
    found: dict[int, np.ndarray] = {}
    indices: Sequence[int] = [index for index, label in enumerate(opened.header.labels) if label.strip()]
    try:
        return dict(zip(indices, (column.values for column in opened.columns(indices)), strict=True))
    except InputError:
        for index in indices:
            try:
                found[index] = opened.columns([index])[0].values
            except InputError:
                continue
    return found
