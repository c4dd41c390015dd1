"""What is wrong in the rows of a record, before any fit: clipped, frozen, dropped, held and released values.

The sensors of the measured channels are looked at, since an input may well stand at its limit or at rest. Rows without
a value of their own are gaps afterwards: they take part in no fit, and a warning states how many there are and where.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from stagecad.parameters.units import SYMBOLS, format_quantity, unit_dimension
from sysid.signals import dilated, runs

EQUAL = 3
"""Equal values in a row from which a run of them is one: noise of some steps repeats a value twice, seldom thrice."""
FROZEN = 10
"""Equal values in a row that are a standing sensor, where hardly any others repeat."""
PILE = 5.0
"""Rows at the largest value over those at the next one, from which it is a limit: at the turn of a smooth motion,
sampled by a sensor of coarse steps, there are 1 / (sqrt 2 - 1) = 2.4 times as many."""
SELDOM = 0.1
"""Share of the other rows in such runs up to which a sensor resolves its noise, so that a run of equals tells."""
BESIDE = 5
"""Rows on both sides of a clipped one that are left out with it: near the limit each row's own noise decides whether it
is clipped, so those that are not are too small on average."""
FAR = 10.0
"""Distance of a dropped value from its neighbours, over the robust deviation of the steps from row to row."""
ALIKE = 0.2
"""Difference of those neighbours, over their distance from the dropped value, up to which they agree."""
FEW = 3
"""Largest number of dropped rows in a row."""
HELD = 20
"""Changes that lie a multiple of the same number of rows apart, from which they do so for a reason: of as many at any
rows this is the case once in 2^19."""
MOVES = 0.1
"""Part of the largest velocity from which an axis moves."""
KEPT = 0.5
"""Force at rest over that with which sliding ends, below which it is released: halfway between none and all of it."""


@dataclass(frozen=True)
class Fault:
    """Rows (n,) of a channel that hold no value of their own, `clipped`, `frozen`, `dropped`, `held`, what the file has
    there, SI, and one line for the user."""

    channel: str
    kind: str
    rows: np.ndarray
    logged: np.ndarray
    text: str

    def within(self, part: slice) -> Fault:
        """The fault in a part of the record."""
        return Fault(self.channel, self.kind, self.rows[part], self.logged[part], self.text)


def faults_of(
    time: np.ndarray, values: Mapping[str, np.ndarray], units: Mapping[str, str], measured: Collection[str]
) -> list[Fault]:
    """The faults of a record: channels (n,), SI, with gaps as NaN, and their units. All are looked for in `measured`
    channels; in other positions, dropped values."""
    faults: list[Fault] = []
    moving = _moving(values)
    # A force balance needs neighbouring rows of what is measured.
    imposed = bool({"position", "velocity"} & (values.keys() - set(measured)))
    for channel, signal in values.items():
        in_place = "position" in channel
        if not (channel in measured or in_place) or np.isfinite(signal).sum() < 4 * FROZEN:
            continue
        found = {"dropped": _dropped(signal)}
        # An axis may rest, at an end of its travel too: only its logged velocity shows that a position is wrong.
        velocity = np.abs(values.get("velocity", np.zeros(signal.size)))
        moves = velocity > MOVES * np.nanmax(velocity) if in_place else moving
        if channel in measured:
            clipped = _clipped(signal)
            found |= {"clipped": clipped & (moves | (not in_place)), "frozen": _frozen(signal, moves) & ~clipped}
            found |= {"held": _held(signal), "unloaded": _unloaded(signal, values)} if imposed else {}
        for kind, rows in found.items():
            if rows.any():
                text = _text(channel, kind, rows, time, signal, units[channel])
                reach = BESIDE if kind == "clipped" else 0
                faults.append(Fault(channel, kind, dilated(rows, reach) & np.isfinite(signal), signal, text))
    return faults


def without_faults(values: Mapping[str, np.ndarray], faults: Sequence[Fault]) -> dict[str, np.ndarray]:
    """The channels (n,) with gaps in the rows of the faults."""
    kept = dict(values)
    for fault in faults:
        kept[fault.channel] = np.where(fault.rows, np.nan, kept[fault.channel])
    return kept


def _text(channel: str, kind: str, rows: np.ndarray, time: np.ndarray, signal: np.ndarray, unit: str) -> str:
    first, count = int(np.flatnonzero(rows)[0]), int(rows.sum())
    place = f"{count} row{'s' * (count > 1)}, the first at {time[first]:.6g} s"
    ends = " and ".join(format_quantity(end, unit, 4) for end in sorted({signal[rows].min(), signal[rows].max()}))
    what = {
        "clipped": f"is clipped at {ends} ({place}): the sensor or its amplifier saturates",
        "frozen": f"stands still while the axis moves ({place}): the sensor or the logger froze",
        "held": f"has a new value in {np.mean(~rows):.3g} of the rows only, and repeats it in the others",
        "unloaded": f"is released while the axis rests ({place}), where friction has any value up to break-away",
        "dropped": f"drops to {format_quantity(float(signal[first]), unit, 4)} for single rows ({place})",
    }[kind]
    beside = f" and {BESIDE} on each side" * (kind == "clipped")
    return f"'{channel}' {what}; {f'these rows{beside} are' if count > 1 else 'this row is'} left out"


def _equal_runs(signal: np.ndarray) -> np.ndarray:
    """Length of the run of equal values that each row (n,) stands in."""
    lengths = np.ones(signal.size, dtype=int)
    same = np.concatenate([[False], np.diff(signal) == 0.0])
    for start, stop in runs(same):
        lengths[max(start - 1, 0) : stop] = stop - max(start - 1, 0)
    return lengths


def _clipped(signal: np.ndarray) -> np.ndarray:
    """Rows at the largest or the smallest value where runs of it are common, but hardly any other value repeats."""
    long = _equal_runs(signal) >= EQUAL
    levels, counts = np.unique(signal[np.isfinite(signal)], return_counts=True)
    ends = [signal == levels[0], signal == levels[-1]]
    others = np.isfinite(signal) & ~np.logical_or(*ends)
    piled = [counts[0] > PILE * counts[1:2].sum(), counts[-1] > PILE * counts[-2:-1].sum()]
    clipped = np.logical_or(*(end & (pile and np.sum(end & long) >= FROZEN) for end, pile in zip(ends, piled)))
    if not clipped.any() or others.sum() < FROZEN or np.mean(long[others]) >= SELDOM * np.mean(long[~others]):
        return np.zeros(signal.size, dtype=bool)
    return clipped


def _moving(values: Mapping[str, np.ndarray]) -> np.ndarray:
    """Rows (n,) in which a position or velocity, or another channel where none is recorded, changes."""
    names = [name for name in values if "position" in name or name == "velocity"] or [*values]
    return np.logical_or.reduce([np.abs(np.diff(values[name], prepend=values[name][:1])) > 0.0 for name in names])


def _frozen(signal: np.ndarray, moving: np.ndarray) -> np.ndarray:
    """Rows after the first of a long run of equal values while the axis moves, where hardly any other value repeats."""
    lengths = _equal_runs(signal)
    long = lengths >= FROZEN
    if not long.any() or long.mean() > 0.5 or np.mean(lengths[~long] >= EQUAL) > SELDOM:
        return np.zeros(signal.size, dtype=bool)
    frozen = np.zeros(signal.size, dtype=bool)
    steps = np.abs(np.diff(signal))
    quantum = float(np.nanquantile(steps[steps > 0.0], 0.05)) if np.any(steps > 0.0) else 0.0
    for start, stop in runs(long & np.isfinite(signal)):
        # At its turn, the value of a sensor of coarse steps comes and goes by one of them.
        beside = max(steps[max(start - 1, 0)], steps[min(stop, steps.size) - 1])
        if np.mean(moving[start:stop]) > 0.5 and beside > 1.5 * quantum:
            frozen[start + 1 : stop] = True
    return frozen


def _held(signal: np.ndarray) -> np.ndarray:
    """Rows between the samples of a slower sensor, whose values change every so many rows, and not by one step only."""
    steps = np.abs(np.diff(signal))
    changes = np.flatnonzero(steps > 0.0)
    if changes.size <= HELD or np.sum(steps[changes] > 1.5 * np.min(steps[changes])) < HELD:
        return np.zeros(signal.size, dtype=bool)
    return (np.arange(signal.size) - changes[0] - 1) % np.gcd.reduce(np.diff(changes)) != 0


def _unloaded(force: np.ndarray, values: Mapping[str, np.ndarray]) -> np.ndarray:
    """Rows (n,) at rest, if the force there is far below that with which sliding ends, as of a drive that is switched
    off; what depends on the velocity falls before."""
    path, good = values.get("position", force), np.isfinite(force)
    rate = values.get("velocity", np.diff(path, prepend=path[:1]))
    rest = good & (rate == 0.0) & (_equal_runs(rate) >= FROZEN)
    last = dilated(np.diff(rest, append=False) & ~rest, FROZEN) & good & (rate != 0.0)
    # Before the first motion no friction may have been built up.
    later = np.abs(force[rest & np.maximum.accumulate(rate != 0.0)])
    return rest & (last.any() and np.median(later) < KEPT * np.median(np.abs(force[last])))


def _dropped(signal: np.ndarray) -> np.ndarray:
    """Rows, at most `FEW` in a row, with one value far from the rows before and after them, which agree."""
    dropped = np.zeros(signal.size, dtype=bool)
    steps = np.abs(np.diff(signal))
    scale = 1.4826 * float(np.nanmedian(steps)) if np.isfinite(steps).any() else 0.0
    if scale == 0.0:
        return dropped
    with np.errstate(invalid="ignore"):
        jumps = np.flatnonzero(steps > FAR * scale) + 1
    # One value that returns is a mark of the logger; zero is one at its first appearance.
    levels, counts = np.unique(signal[jumps], return_counts=True)
    for level in {0.0, *levels[counts >= EQUAL].tolist()}:
        # Of coarse steps the usual size may be that of the rounding of what is printed.
        elsewhere = steps[(signal[1:] != level) & (signal[:-1] != level)]
        coarse = np.sum(elsewhere > FAR * scale) > SELDOM * elsewhere.size
        for start, stop in () if coarse else runs(signal == level):
            if start > 0 and stop < signal.size and stop - start <= FEW:
                before, after = signal[start - 1], signal[stop]
                far = min(abs(level - before), abs(level - after)) > FAR * scale
                dropped[start:stop] |= far and abs(after - before) < ALIKE * abs(level - 0.5 * (before + after))
    return dropped


def begins_anew(signal: np.ndarray) -> tuple[np.ndarray, float]:
    """Rows at which a position (n,) may begin anew, as a counter or an angle within a turn does, and the period; none
    else. It jumps by nearly its whole range against its motion, and its other steps are below a quarter of the range.
    """
    kept = np.flatnonzero(np.isfinite(signal))
    steps = np.diff(signal[kept])
    span = float(np.ptp(signal[kept])) if kept.size else 0.0
    far = np.abs(steps) > 0.5 * span
    jumps = np.flatnonzero(far[1:-1]) + 1
    before, after = steps[jumps - 1], steps[jumps + 1]
    periods = np.abs(steps[jumps]) + 0.5 * np.abs(before + after)
    against = (before * steps[jumps] < 0.0) & (after * steps[jumps] < 0.0) & (periods > 0.99 * span)
    if not jumps.size or not against.all() or np.abs(steps[~far]).max(initial=0.0) > 0.25 * span:
        return kept[:0], 0.0
    return kept[jumps + 1], float(np.median(periods))


OTHER_SCALE = 100.0
"""Ratio of the ranges of a channel in two records from which a wrong unit is asked for."""
LEAST_SCALE, SAME_SCALE = 2.0, 0.01
"""Least ratio that may be that of two units, and relative difference up to which it is: another ratio between 2 and 100
is so by chance in 3 % of cases."""


def scale_warnings(records: Sequence[tuple[str, Mapping[str, np.ndarray], Mapping[str, str]]]) -> list[str]:
    """Channels whose ranges in two records differ as units do, and positions that begin anew at the end of their range;
    `records` are name, channels and units."""
    found = []
    for name, channel, signal, unit in (
        (name, key, values[key], units[key]) for name, values, units in records for key in values if "position" in key
    ):
        rows, period = begins_anew(signal)
        if rows.size:
            found.append(
                f"'{channel}' in '{name}' jumps {rows.size} times by its whole range against its motion: if it begins "
                f"anew after {format_quantity(period, unit, 3)}, write that in the unit of its column: [channels] "
                f"{channel} = {{column = ..., period = ...}}"
            )
    for channel in sorted({channel for _, values, _ in records for channel in values}):
        ranges = {
            name: (float(np.nanpercentile(values[channel], 99) - np.nanpercentile(values[channel], 1)), units[channel])
            for name, values, units in records
            if channel in values and np.isfinite(values[channel]).any()
        }
        moving = {name: entry for name, entry in ranges.items() if entry[0] > 0.0}
        if len(moving) < 2:
            continue
        least, most = min(moving, key=lambda n: moving[n][0]), max(moving, key=lambda n: moving[n][0])
        ratio = moving[most][0] / moving[least][0]
        (low, unit), (high, _) = moving[least], moving[most]
        if ratio >= OTHER_SCALE or _is_of_units(ratio, unit):
            found.append(
                f"'{channel}' ranges over {format_quantity(high, unit, 3)} in '{most}' and "
                f"{format_quantity(low, unit, 3)} in '{least}', {ratio:.3g} times as much: is the unit of one wrong?"
            )
    return found


def _is_of_units(ratio: float, unit: str) -> bool:
    """Whether a ratio is that of two units of a dimension, such as 4.448 of pounds and newtons; a whole one is that
    of two motions, too."""
    sizes = np.array([size for size, dimension in SYMBOLS.values() if dimension == unit_dimension(unit)])
    ratios = np.divide.outer(sizes, sizes)
    ratios = ratios[np.abs(ratios - np.round(ratios)) > SAME_SCALE * ratios]
    return ratio >= LEAST_SCALE and bool((np.abs(ratios - ratio) < SAME_SCALE * ratio).any())
