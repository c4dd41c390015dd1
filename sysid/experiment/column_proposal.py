"""A proposal of an experiment from its files: kind of rig, channels and units, with questions where they are uncertain.

A column is assigned by its name and unit; the numbers identify only the time (it increases) and a velocity (the
derivative of another column). What is uncertain has a question, which the written file shows.
"""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Collection, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, field, replace
from typing import NamedTuple

import numpy as np

from stagecad.parameters.errors import InputError
from sysid.experiment.channels import parse_label, same_dimension
from sysid.experiment.column_settings import PARTS, WORDS, column_unit, unit_endings
from sysid.experiment.readers.base import Header
from sysid.experiment.readers.numbers import is_hexadecimal
from sysid.experiment.readers.open import RecordFile, open_record_file
from sysid.experiment.rig_kinds.declaration import find_rig
from sysid.experiment.rigs import CHANNELS, RigKind

_FORCE_SENSOR = re.compile(
    r"load[\s_-]*cell|kraft(mess)?dose|wägezelle|capteur de force|cella di carico|célula de carga"
)
_COMPOUND = re.compile(r"^(?:soll|ist)(?=\w{3})|(?<=\w{3})(?:soll|ist)(?:wert)?$|(?<=^\w)(?:cmd|ref|fb|fbk|act|set)$")
LONG_WORD = 5
"""Letters from which a word is looked for at the end of a compound, too, such as `Motorstrom`."""

_LEAF = re.compile(r".*[./\\:](?=[^\W\d])")
"""What stands before the last part of a path, such as `"Axis".` or `plant/`."""
_OF_AXIS = re.compile(r"^\w*\d_(?=[^\W\d])")
"""The axis before a quantity of it, such as `q2_` of `q2_tau`."""

LABVIEW_TIME = "x_value"
"""Name of the time column in a measurement file of LabVIEW (.lvm)."""

_SCALES = {"A": "{si}/A", "V": "{si}/V", "Pa": "mm^2", "N*m": "1/m", "N": "m", "rad": "m/rad", "m": "rad/m"}
_SCALES |= {"rad/s": "m/rad", "m/s": "rad/m"}
"""Unit of the scale from a dimension to a channel of another one, `{si}` that of the channel; from a rotation to a
displacement and back, as of a ball screw or a lever."""

TRANSDUCER_WORD = 3
"""Letters from which a word names the quantity that a voltage or a current stands for."""

DERIVATIVE = 0.98
"""Correlation with the derivative of another column from which a column is its velocity."""

SAMPLE = 20_000
"""Rows that are compared."""


@dataclass(frozen=True)
class Proposal:
    """One column and what it is taken for.

    `number` counts from 1; `channel` is None if it is left out, for the stated `reason`. `unit` is as it will be
    written, None if the header has it in brackets, `?` if it is not known; `scale` is the unit of a needed scale, of
    which the cells may be `percent`. `question` is what the user should decide. Cells may be `increments` from row to
    row. The `fraction` of each second may stand in another column, of a unit."""

    number: int
    label: str
    channel: str | None
    unit: str | None = None
    scale: str | None = None
    question: str = ""
    increments: bool = False
    reason: str = ""
    percent: bool = False
    fraction: tuple[str | int, str] | None = None


@dataclass(frozen=True)
class ExperimentProposal:
    """Kind of rig with its question to the user, the columns, and the cells that are taken for marks of a gap."""

    kind: str
    question: str
    columns: tuple[Proposal, ...]
    rotary: bool
    missing: tuple[str, ...] = ()


_MULTIPLE = re.compile(r'[x×*]?\s*(?P<number>\d+(?:\.\d+)?(?:[eE]-?\d+)?)\s*[*·]?\s*(?P<unit>[A-Za-zµμ°"].*)')
"""A unit with a number before it, of which the column holds counts."""


class Guess(NamedTuple):
    """What a column is taken for (a channel, `force`, `voltage`, or empty), a question to the user where it is not
    certain, its unit, and its rank: 0 for a value that is measured, 2 for one that is asked for, 1 if the name does not
    say. A `count` of the column is so much, such as `0.1 mm`; its numbers may all be `whole`. Its name has `words`: of
    alike names, the plain one (`x` beside `x_d`) is what is measured. One of the `moving` axis comes before those of
    the others, and one in the `own` unit of its channel before those that need a scale."""

    meaning: str
    why: str
    unit: str | None
    rank: int = 1
    count: str = ""
    whole: bool = False
    words: int = 0
    moving: bool = True
    own: bool = True


def propose(opened: RecordFile, numbers: Numbers, kind: str | None = None) -> ExperimentProposal:
    """A guess of the experiment by one of its files."""
    header, columns = opened.header, numbers.columns
    known = CHANNELS if kind is None else find_rig(kind, "--kind").all_channels
    guesses: dict[int, Guess] = {}
    reasons = dict(numbers.reasons)
    for index, values in columns.items():
        guess = _guess(header, index, values, numbers.origins.get(index, 0.0), known)
        if isinstance(guess, str):
            reasons[index] = guess
        else:
            guesses[index] = guess
    if any(guess.meaning == "time" for guess in guesses.values()):
        for index in [
            k for k, guess in guesses.items() if guess.meaning != "time" and np.all(np.diff(columns[k]) == 1)
        ]:
            reasons[index] = "it counts the rows"
            del guesses[index]
    _tell_axis_and_unit(guesses, columns, header.labels)
    _by_numbers(guesses, columns)
    chosen, question = (kind, "") if kind else _kind({guess.meaning for guess in guesses.values()})
    rig = find_rig(chosen, "--kind")
    found = _channels(guesses, rig, reasons)
    by_channel = {channel: index for index, (channel, _) in found.items()}
    if _of_another_axis(guesses, columns, by_channel):
        found.pop(by_channel["position"])
        reasons[by_channel["position"]] = f"column {by_channel['velocity'] + 1} 'velocity' is not its derivative"
    fraction = _fraction(opened, columns, found)
    if fraction is not None:
        found.pop(fraction[0], None)
        reasons[fraction[0]] = "it is added to the time"
        why = f"with the fraction of each second in column {fraction[0] + 1}"
        found = {k: ("time", why) if channel == "time" else (channel, asked) for k, (channel, asked) in found.items()}
    units = [guess.unit for index, guess in guesses.items() if index in found]
    # The motion tells the kind of axis before a torque, which may be that of a motor.
    rotary, sliding, torque = (
        any(same_dimension(unit, si) for unit in units if unit for si in dimensions)
        for dimensions in (("rad", "rad/s"), ("m", "m/s"), ("N*m",))
    )
    rotary = rotary or (torque and not sliding) if rig.rotary is None else rig.rotary
    proposals = [
        _proposal(index, opened, *found[index], guesses[index], rig, rotary)
        if index in found
        else Proposal(index + 1, header.labels[index].strip(), None, reason=reasons.get(index, ""))
        for index in range(len(header.labels))
        if header.labels[index].strip() or index in found
    ]
    if fraction is not None:
        key = header.labels[fraction[0]].strip() if not header.numbered else fraction[0] + 1
        proposals = [replace(p, fraction=(key, fraction[1])) if p.channel == "time" else p for p in proposals]
    if 0 in guesses and _holds_intervals(columns, proposals):
        why, unit = "is it the time from pulse to pulse, each of them a row?", guesses[0].unit
        why = why if unit else f"{why}; what is its unit?"
        proposals = [Proposal(1, proposals[0].label, "time", unit or "?", None, why, True)]
    return ExperimentProposal(chosen, question, tuple(proposals), rotary, numbers.missing)


def _guess(header: Header, index: int, values: np.ndarray, origin: float, known: Collection[str]) -> Guess | str:
    """What a column of numbers (n,), less `origin`, is taken for by its label and numbers; why it is no quantity."""
    if np.isnan(values).all():
        return "it is empty"
    column = parse_label(index, header.labels[index])
    stated = header.units.get(column.label, column.unit)
    multiple = _MULTIPLE.fullmatch(stated or "")
    unit = column_unit(multiple["unit"] if multiple else stated) if stated else None
    if unit is None and not header.numbered:
        unit = _unit_of_name(column.name)
    counted, why = ("", "") if unit else counted_unit(column.name, values, origin)
    name = column.name.strip().casefold()
    unit = counted or unit or ("s" if name == LABVIEW_TIME else None)
    guess = _meaning(column.name, unit, header.numbered, known)
    if name not in known and (reason := _is_flag(column.name, values + origin)):
        return reason
    force = guess.meaning in (*_FORCES, "normal_load") and unit is not None and same_dimension(unit, "kg")
    meant = f"{unit}f" if force and column_unit(f"{unit}f") else _MEANT.get((guess.meaning, unit or ""), unit)
    guess = guess._replace(unit=meant)
    kept = values[np.isfinite(values)]
    unchanging = kept.size > 0 and np.ptp(kept) == 0.0
    guess = guess._replace(rank=2) if unchanging and guess.rank == 1 and guess.meaning not in _STEADY else guess
    if multiple and unit and unit not in PARTS:
        guess = guess._replace(count=f"{multiple['number']} {unit}")
    guess = guess._replace(whole=bool(np.all(kept == np.round(kept))), words=len(_words(column.name)))
    return guess._replace(why=why) if why else guess


_MEANT = {("temperature", "C"): "degC", ("temperature", "F"): "degF", ("velocity", "Hz"): "rev/s"}
"""What the symbol of another unit stands for under the name of a channel."""

_STEADY = ("normal_load", "temperature", "voltage")
"""Channels that may be the same in all rows."""

DATES_IN_DAYS = {"as spreadsheets write dates": (25569.0, 73050.0), "as MATLAB writes dates": (719529.0, 767010.0)}
"""Days of the years 1970 to 2099, counted from the end of 1899 and from year 0."""
UNIX_TIMES = {"s": 1.0, "ms": 1e3, "us": 1e6, "ns": 1e9}
"""Units of a time counted from 1970, per second; of the years 2001 to 2099 there is one for each number."""


def counted_unit(name: str, values: np.ndarray, origin: float) -> tuple[str, str]:
    """The unit of a date that is counted in days or from 1970, by its numbers (n,), less `origin`, and what was found;
    empty for another column."""
    if (
        values.size < 3
        or not _any(_words(name), f"{WORDS['channels']['time']} {WORDS['dates']}")
        or np.any(np.diff(values) < 0.0)
    ):
        return "", ""
    first, last, step = origin + values[0], origin + values[-1], float(np.median(np.diff(values)))
    for how, (low, high) in DATES_IN_DAYS.items():
        if low <= first <= last <= high and 0.0 < step < 0.5:
            return "day", f"by its numbers: days, {how}"
    unit = next((unit for unit, size in UNIX_TIMES.items() if 1e9 * size <= first <= last <= 4.1e9 * size), "")
    return unit, f"by its numbers: counted from 1970 in {unit}" if unit else ""


def _is_flag(name: str, values: np.ndarray) -> str:
    """Why a column is a state and no quantity; empty if it may be one."""
    kept = values[np.isfinite(values)]
    if kept.size and np.all((kept == 0.0) | (kept == 1.0)):
        return "0 or 1 in every row: a state, no quantity" if kept.any() else "0 in every row"
    if _any(_words(name), WORDS["flags"]) and kept.size and np.all(kept == np.round(kept)):
        return "whole numbers under the name of a state"
    return ""


def _fraction(
    opened: RecordFile, columns: Mapping[int, np.ndarray], found: Mapping[int, tuple[str, str]]
) -> tuple[int, str] | None:
    """Column and unit of the fraction of a second beside a time that repeats: whole numbers under the name of the
    unit, less than a second."""
    time = next((index for index, (channel, _) in found.items() if channel == "time"), None)
    if time is None or not np.any(np.diff(columns[time]) == 0.0):
        return None
    for index, values in columns.items():
        unit = _unit_of_name(parse_label(index, opened.header.labels[index]).name)
        whole = np.all(values == np.round(values)) and index != time
        if whole and unit in SUBSECONDS and values.min() >= 0.0 and values.max() < SUBSECONDS[unit]:
            return index, unit
    return None


SUBSECONDS = {"ms": 1e3, "us": 1e6, "ns": 1e9}
"""Units of a fraction of a second, and how many there are in one."""


def _holds_intervals(columns: Mapping[int, np.ndarray], proposals: Sequence[Proposal]) -> bool:
    """Whether the only column may be the time from pulse to pulse: above zero, now longer, now shorter."""
    if len(proposals) != 1 or proposals[0].channel not in (None, "time") or 0 not in columns:
        return False
    values = columns[0][:SAMPLE]
    return bool(values.size > 2 and np.all(values > 0.0) and np.any(np.diff(values) <= 0.0))


def _words(name: str) -> list[str]:
    """The words of a name, in small letters: `posCmd`, `Sollweg` and `pos_cmd` have two."""
    parts = re.sub(r"(?<=[a-zäöü])(?=[A-ZÄÖÜ])", " ", name.strip())
    words = [word for word in re.split(r"[\W\d_]+", parts.casefold()) if word]
    return [part for word in words for part in _COMPOUND.sub(r" \g<0> ", word).split()]


def _any(words: Sequence[str], spoken: str) -> bool:
    """Whether one of the words, or the end of a compound, is in a text of words."""
    known = spoken.split()
    long = tuple(word for word in known if len(word) >= LONG_WORD)
    return any(word in known or word.endswith(long) for word in words)


def _meaning(name: str, unit: str | None, numbered: bool, known: Collection[str]) -> Guess:
    """What a column is taken for by its name and unit."""
    plain = name.strip().casefold()
    if plain in known:
        return Guess(plain, "", unit)
    if plain == LABVIEW_TIME:
        return Guess("time", "by its name", unit)
    words = _words(_FORCE_SENSOR.sub("force", plain) if _FORCE_SENSOR.search(plain) else name)
    rank = 2 if _any(words, f"{WORDS['setpoint']} {WORDS['derived']}") else 0 if _any(words, WORDS["measured"]) else 1
    by_unit = _by_dimension(unit)
    # The output of a transducer, such as `Force [V]`, but for `motor force [V]` and `piezo x [V]`.
    electric = by_unit in ("voltage", "drive_force") and not _any(words, WORDS["channels"][by_unit])
    long = [word for word in words if len(word) >= TRANSDUCER_WORD] if electric else []
    spoken_of = [c for c in known if c not in CHANNELS and {*c.split("_")} <= {*re.split(r"[\W_]+", plain)}]
    if spoken_of:
        return Guess(max(spoken_of, key=len), "by its name", unit, rank)
    # The last part of a path says it before the names of the parts above, such as of an axis.
    for own in () if numbered else (_words(_OF_AXIS.sub("", _LEAF.sub("", name))), words):
        for meaning, spoken in WORDS["channels"].items():
            fits = by_unit in (None, meaning) or sorted((by_unit, meaning)) in WORDS["alike"]
            if (fits and _any(own, spoken)) or (meaning != "time" and _any(long, spoken)):
                certain = meaning == "time" and by_unit == "time"
                return Guess(meaning, "" if certain else "by its name", unit, rank)
    return Guess(by_unit, "by its unit", unit, rank) if by_unit else Guess("", "", unit, rank)


def _unit_of_name(name: str) -> str | None:
    """The unit at the end of a name such as `position_mm`; none where a channel has no such unit."""
    leaf = _LEAF.sub("", name)
    if unit := next((unit for _, unit in unit_endings(leaf) if _by_dimension(unit)), None):
        return unit
    word = re.split(r"[\s_]", leaf.strip())[0]
    first = column_unit(word) if len(word) > 1 else None
    return first if first and same_dimension(first, "s") else None


def _by_dimension(unit: str | None) -> str | None:
    known = WORDS["dimensions"].items()
    return next((meaning for si, meaning in known if unit is not None and same_dimension(unit, si)), None)


def _by_numbers(guesses: dict[int, Guess], columns: Mapping[int, np.ndarray]) -> None:
    """Tell time by its increase, and a velocity by its being the derivative of a position."""
    if not any(guess.meaning == "time" for guess in guesses.values()):
        for index, guess in guesses.items():
            values = columns[index][:SAMPLE]
            if not guess.meaning and values.size > 2 and np.all(np.diff(values) > 0.0):
                guesses[index] = guess._replace(meaning="time", why="it increases from row to row")
                break
    time = next((columns[i][:SAMPLE] for i, guess in guesses.items() if guess.meaning == "time"), None)
    if time is None or np.any(np.diff(time) <= 0.0):
        return
    kept = {index: columns[index][:SAMPLE] for index, guess in guesses.items() if guess.meaning in ("", "position")}
    kept = {index: values for index, values in kept.items() if np.isfinite(values).all()}
    unknown = list(kept)
    if not unknown or time.size < 3:
        return
    table = np.stack([*kept.values()], axis=1)
    alike = np.abs(_unit_columns(np.gradient(table, time, axis=0)).T @ _unit_columns(table)) > DERIVATIVE
    for row, column in np.argwhere(alike & ~np.eye(len(unknown), dtype=bool)):
        one, other = unknown[row], unknown[column]
        if not guesses[other].meaning:
            why = f"it follows the derivative of column {one + 1}"
            guesses[other] = guesses[other]._replace(meaning="velocity", why=why)
            if not guesses[one].meaning:
                why = f"column {other + 1} follows its derivative"
                guesses[one] = guesses[one]._replace(meaning="position", why=why)


def _tell_axis_and_unit(guesses: dict[int, Guess], columns: Mapping[int, np.ndarray], labels: Sequence[str]) -> None:
    """Tell columns of the axis that moves most, by the numbers in alike names (`q.1`, `q.2`), and those in the unit of
    their channel, where another column of their meaning is not."""
    numbers = {index: re.findall(r"\d+", labels[index]) for index in guesses}
    alike = {index: (guess.meaning, re.sub(r"\d+", "#", labels[index])) for index, guess in guesses.items()}
    groups = [[k for k in guesses if alike[k] == name] for name in dict.fromkeys(alike.values())]
    axes = [group for motion in ("position", "velocity") for group in groups if alike[group[0]][0] == motion]
    if axes := next((group for group in axes if len(group) > 1), []):
        moving = numbers[max(axes, key=lambda k: np.ptp(columns[k][np.isfinite(columns[k])]))]
        for group in [group for group in groups if moving in [numbers[k] for k in group]]:
            guesses |= {k: guesses[k]._replace(moving=numbers[k] == moving) for k in group}
    fitting = {
        k for k, g in guesses.items() if g.unit and any(same_dimension(g.unit, si) for si in _si_units(g.meaning))
    }
    for index, guess in guesses.items():
        rivals = {k for k, other in guesses.items() if (other.meaning, other.rank) == (guess.meaning, guess.rank)}
        guesses[index] = guess._replace(own=index in fitting or not fitting & rivals)


def _si_units(meaning: str) -> tuple[str, ...]:
    """SI units of a channel, or of a force; none of a voltage, of which there may be several."""
    declared = CHANNELS.get("friction_force" if meaning == "force" else meaning)
    return (declared.unit, declared.rotary_unit) if declared else ()


def _of_another_axis(
    guesses: Mapping[int, Guess], columns: Mapping[int, np.ndarray], by_channel: Mapping[str, int]
) -> bool:
    """Whether a displacement beside the velocity of a rotation, or the reverse, is of another axis: the velocity is not
    its derivative."""
    if not by_channel.keys() >= {"time", "position", "velocity"}:
        return False
    time, position, velocity = (by_channel[name] for name in ("time", "position", "velocity"))
    pair = [guesses[position].unit or "", guesses[velocity].unit or ""]
    if not any(all(map(same_dimension, pair, unlike)) for unlike in (("m", "rad/s"), ("rad", "m/s"))):
        return False
    step, moved = (np.diff(columns[index][:SAMPLE]) for index in (time, position))
    rates = np.stack([moved, columns[velocity][1:SAMPLE] * step], axis=1)[step > 0.0]
    one, other = _unit_columns(rates[np.isfinite(rates).all(axis=1)]).T
    return abs(one @ other) <= DERIVATIVE


def _unit_columns(table: np.ndarray) -> np.ndarray:
    """Columns (n, k) less their means, of length one; zero where a column is constant."""
    centred = table - table.mean(axis=0)
    length = np.linalg.norm(centred, axis=0)
    return centred / np.where(length > 1e-12 * np.abs(table).max(axis=0) * np.sqrt(len(table)), length, np.inf)


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


def _channels(guesses: Mapping[int, Guess], rig: RigKind, reasons: dict[int, str]) -> dict[int, tuple[str, str]]:
    """Channel and question by index; each channel once: the measured column before one that is asked for, then the
    more certain one. Why the others are left out is put into `reasons`."""
    force = next((name for name in ("friction_force", "spring_force", "drive_force") if name in rig.channels), None)
    found: dict[int, tuple[str, str]] = {}
    own_voltages = [name for name in rig.own if same_dimension(rig.own[name].unit, "V")]
    voltages = iter(own_voltages or [name for name in rig.channels if name.startswith("voltage_")])
    certainty = {
        index: (guess.rank, not guess.own, not guess.moving, bool(guess.why), guess.words, index)
        for index, guess in guesses.items()
    }
    others: dict[int, list[int]] = {}
    for index, guess in sorted(guesses.items(), key=lambda item: certainty[item[0]]):
        meaning = guess.meaning
        channel = force if meaning in ("force", "drive_force") and meaning not in rig.channels else meaning
        if meaning == "voltage":
            channel = next(voltages, "drive_force" if "drive_force" in rig.channels else None)
        if not channel or channel not in rig.channels:
            wanted = channel or meaning
            reasons[index] = f"a {rig.name} has no {wanted}" if wanted else "neither its name nor its unit is known"
            continue
        taken = [number for number, (other, _) in found.items() if other == channel]
        if not taken:
            question = "it is no measured value; is it measured anywhere?" if guess.rank == 2 else guess.why
            found[index] = (channel, question)
            continue
        first = taken[0]
        reasons[index] = f"column {first + 1} is taken for '{channel}'"
        if guess.rank <= guesses[first].rank and guess.own >= guesses[first].own:
            others.setdefault(first, []).append(index + 1)
            *before, last = sorted(others[first])
            both = f", or their sum ([{first + 1}, {last}])" if channel in _FORCES and not before else ""
            either = f"{', '.join(map(str, before))} or " if before else ""
            found[first] = (channel, f"or is column {either}{last} '{channel}'{both}?")
    load = next((k for k, (channel, _) in found.items() if channel == "normal_load" and guesses[k].why), None)
    if force in rig.measured_channels and load is not None and force not in [channel for channel, _ in found.values()]:
        found[load] = (force, "it is the only force: or is it the normal load?")
    for index, guess in sorted(guesses.items(), key=lambda item: (item[1].rank, item[0])):
        left = [name for name in rig.own if name not in {channel for channel, _ in found.values()}]
        own = next((name for name in left if guess.unit and same_dimension(guess.unit, rig.own[name].unit)), None)
        if index not in found and own is not None:
            found[index] = (own, "by its unit")
    return found


def _proposal(
    index: int, opened: RecordFile, channel: str, why: str, guess: Guess, rig: RigKind, rotary: bool
) -> Proposal:
    header, unit = opened.header, guess.unit
    label = header.labels[index].strip()
    declared = rig.declared(channel)
    # A unit that the file has in brackets is read from there.
    stated = header.units.get(label, parse_label(index, label).unit)
    written = None if stated is not None else "?"
    asked = [f"taken for '{channel}' {why}" if why.startswith("by") else why] if why else []
    if written == "?" and unit is not None and _unit_of_name(label) == unit:
        asked.append(f"its unit '{unit}' by its name")
    if guess.count:
        asked.append(f"one count is taken for {guess.count}")
        return Proposal(index + 1, label, channel, "count", guess.count, "; ".join(asked))
    if unit is not None and written is None and unit != column_unit(stated or ""):
        asked, written = [*asked, f"its unit is taken for '{unit}'"], unit
    if unit is None:
        count = f", or how much is one count, such as '0.5 {declared.si_unit(rotary)}'" if guess.whole else ""
        return Proposal(index + 1, label, channel, "?", None, "; ".join([*asked, f"what is its unit{count}?"]))
    # A load on a rotary axis may be a force.
    fitting = (declared.unit, declared.rotary_unit) if channel == "normal_load" else (declared.si_unit(rotary),)
    if any(same_dimension(unit, si) for si in fitting):
        return Proposal(index + 1, label, channel, written if written is None else unit, None, "; ".join(asked))
    scale = next((s for si, s in _SCALES.items() if same_dimension(unit, si)), "{si}")
    scale = scale.format(si=declared.si_unit(rotary))
    asked.append(f"what is its {'rated value (100 %)' if unit in PARTS else 'scale'} in {scale}?")
    named = unit if written == "?" else None
    return Proposal(index + 1, label, channel, named, scale, "; ".join(asked), percent=unit in PARTS)


@dataclass(frozen=True)
class Numbers:
    """Columns of numbers (n,) by index, why a column holds none, the cells that are taken for marks of a gap, and notes
    on rows that are left out; `origins` are the numbers that were subtracted from columns of long ones."""

    columns: Mapping[int, np.ndarray]
    reasons: Mapping[int, str]
    missing: tuple[str, ...] = ()
    notes: tuple[str, ...] = ()
    origins: Mapping[int, float] = field(default_factory=dict)


MOST_MARKS = 20
"""Largest number of different words in a column of numbers that are taken for marks of a gap."""


def read_numbers(opened: RecordFile) -> Numbers:
    """The columns of a file that hold numbers; words without a digit among the numbers are taken for gaps."""
    columns: dict[int, np.ndarray] = {}
    reasons = dict.fromkeys(opened.header.dates, "read with the time of day in another column")
    missing: list[str] = []
    origins: dict[int, float] = {}
    indices = [index for index, label in enumerate(opened.header.labels) if label.strip() and index not in reasons]
    for index in [index for index in indices if opened.header.labels[index] in opened.header.texts]:
        cell = opened.header.texts[opened.header.labels[index]]
        hint = "; if these are time stamps, name their form: [format] time_format" if re.search(r"\d\D", cell) else ""
        hint = "; counts in hexadecimal digits are not read" if is_hexadecimal(cell) else hint
        if re.search(r"[^\W\d_][\w. ]*[:=]\s*[-+.]?\d", cell):
            hint = "; names stand in the cells: numbers alone below a header are required"
        reasons[index] = f"holds text, such as '{cell}'{hint}"
        indices.remove(index)
    notes: tuple[str, ...] = ()
    with suppress(InputError):
        found = opened.columns(indices)
        notes = tuple(dict.fromkeys(note for column in found for note in column.notes))
        origins = {index: column.origin for index, column in zip(indices, found)}
        columns = dict(zip(indices, (column.values for column in found), strict=True))
    for index in indices if not columns else ():
        trial, marks = opened, list(missing)
        while index not in columns and index not in reasons:
            try:
                column = trial.columns([index])[0]
                columns[index], origins[index] = column.values, column.origin
                missing = marks
            except InputError as error:
                mark = re.search(r'\[format\] missing = \["(.*?)"\]', str(error))
                if mark is None or mark[1] in marks or len(marks) >= MOST_MARKS:
                    reasons[index] = str(error).removeprefix(f"{opened.name}: ")
                    continue
                marks.append(mark[1])
                settings = replace(opened.settings, missing=(*opened.settings.missing, *marks))
                trial = open_record_file(opened.path, opened.name, settings)
    if len(columns) == 2 and np.any(np.diff(columns[min(columns)]) <= 0.0):
        # Time repeats, or starts again with each word.
        time, value = (opened.header.labels[index] for index in columns)
        for index, label in enumerate(opened.header.labels):
            if index in reasons and label in opened.header.texts:
                reasons[index] += (
                    "; if its words say what each row holds, write a column for each of them: pandas.DataFrame.pivot("
                    f"index='{time}', columns='{label}', values='{value}')"
                )
    sizes = Counter(values.size for values in columns.values())
    usual = max(sizes, key=lambda size: (sizes[size], size), default=0)
    for index in [index for index, values in columns.items() if values.size != usual]:
        reasons[index] = f"has {columns.pop(index).size} values, others {usual}: a file of its own is required"
    return Numbers(columns, reasons, tuple(missing), notes, origins)
