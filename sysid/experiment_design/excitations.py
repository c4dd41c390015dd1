"""Excitations: motions that are sensitive to different effects, within travel, speed and voltages of the records."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True)
class Envelope:
    """Ranges of the motion in the records of an axis, SI: ends of the travel, highest speed, high quantile of the
    acceleration, smallest useful amplitude of a reversal (well above the position's noise), and range of the normal
    load if it was varied."""

    low: float
    high: float
    speed: float
    acceleration: float
    fine: float
    load: tuple[float, float] | None = None


@dataclass(frozen=True)
class Motion:
    """A motion to run: its name, the effects to which it is sensitive as text, signals (n,) in SI (`position`, or
    `voltage_1`, `voltage_2`, ..., and `normal_load` if it is to be varied), and sampling step, s."""

    name: str
    reason: str
    signals: dict[str, np.ndarray]
    step: float

    @property
    def seconds(self) -> float:
        """Duration, s."""
        return self.step * (next(iter(self.signals.values())).size - 1)


def axis_motions(envelope: Envelope, step: float, longest: float = 40.0, most: int = 4000) -> list[Motion]:
    """Excitations of an axis, sampled at `step` (s), or more coarsely if a motion would exceed `most` samples.

    The last one is space-filling: targets, speeds and rests from a low-discrepancy sequence.
    """
    e = envelope
    middle, span = 0.5 * (e.low + e.high), e.high - e.low
    speeds = e.speed * np.array([1.0, 0.3, 0.1, 0.03, 0.01])
    made = []

    def add(name: str, reason: str, legs: Iterable[tuple[float, float, float]], load: bool = False) -> None:
        listed, seconds = _within(legs, middle, longest)
        if not listed:
            return
        own = max(step, seconds / most)
        position = _track(listed, middle, own, e)
        signals = {"position": position}
        if load and e.load is not None:
            t = np.arange(position.size) * own
            swing = np.sin(2.0 * np.pi * 3.0 * t / max(t[-1], own))
            signals["normal_load"] = 0.5 * sum(e.load) + 0.5 * (e.load[1] - e.load[0]) * swing
        made.append(Motion(name, reason, signals, own))

    strokes = [(v, min(0.8 * span, 1.2 * v)) for v in speeds]
    sides = (1.0, -1.0)
    legs = [(middle + 0.5 * side * stroke, v, 0.0) for v, stroke in strokes for side in 2 * sides]
    add("triangle sweeps", "steady-state friction against speed, in both directions", legs)
    amplitudes = np.geomspace(max(e.fine, 1e-4 * span), 0.05 * span, 5)
    legs = [(middle + side * a, min(0.05 * e.speed, 4.0 * a), 0.0) for a in amplitudes for side in 3 * sides]
    add("presliding reversals", "reversals of increasing amplitude, from the presliding range on", legs)
    stroke = min(0.1 * span, 0.2 * e.speed)
    rests = (0.05, 0.15, 0.5, 1.5, 4.0)
    legs = [(middle + 0.5 * side * stroke, 0.1 * e.speed, rest) for rest in rests for side in sides]
    add("dwell ladder", "starts after rests of increasing duration, in both directions", legs)
    slow = max(0.03 * e.speed, span / 12.0)
    legs = [(place, slow, 0.0) for place in (e.high, e.low, middle)]
    add("slow full travel", "effects of position and direction, at one speed", legs)
    legs = [(place, e.speed, 0.0) for place in 8 * (e.high, e.low)]
    add("fast full strokes", "effects of speed, acceleration and distance travelled", legs)
    if e.load is not None:
        legs = [(middle + 0.3 * side * span, 0.2 * e.speed, 0.0) for side in 6 * sides]
        add("strokes under a varied load", "effects of the normal load", legs, load=True)
    made.append(_multisine(e, step, most))
    reason = "any effect: positions, speeds and rests of a low-discrepancy sequence"
    add("space-filling", reason, _space_filling(e), load=e.load is not None)
    return made


def _within(
    legs: Iterable[tuple[float, float, float]], start: float, longest: float
) -> tuple[list[tuple[float, float, float]], float]:
    """Legs (target, speed, subsequent rest) up to the longest duration, and their duration, s."""
    kept, total, at = [], 0.0, start
    for target, speed, rest in legs:
        seconds = abs(target - at) / speed + rest
        if total + seconds > longest:
            break
        kept.append((target, speed, rest))
        total, at = total + seconds, target
    return kept, total


def _track(legs: Sequence[tuple[float, float, float]], start: float, step: float, e: Envelope) -> np.ndarray:
    """Position (n,) along the legs, its corners rounded so that the highest speed is reached at the acceleration."""
    times, places = [0.0], [start]
    for target, speed, rest in legs:
        times.append(times[-1] + abs(target - places[-1]) / speed)
        places.append(target)
        if rest > 0.0:
            times.append(times[-1] + rest)
            places.append(target)
    t = np.arange(0.0, times[-1], step)
    position = np.interp(t, times, places)
    half = max(2, int(np.ceil(min(0.1, e.speed / max(e.acceleration, 1e-9)) / step)))
    window = np.hanning(2 * half + 1)
    return np.convolve(np.pad(position, half, mode="edge"), window / window.sum(), mode="valid")


def _multisine(e: Envelope, step: float, most: int) -> Motion:
    """Sum of sines at eight geometrically spaced frequencies with Schroeder phases, scaled to speed and travel."""
    seconds = 10.0
    own = max(step, seconds / most)
    t = np.arange(0.0, seconds, own)
    frequencies = np.round(np.geomspace(0.2, min(12.0, 0.05 / own), 8) * seconds) / seconds
    wave = np.zeros(t.size)
    for k, f in enumerate(np.unique(frequencies)):
        wave += np.cos(2.0 * np.pi * f * t - np.pi * k * (k + 1) / 8.0) / f
    wave -= wave.mean()
    by_speed = 0.8 * e.speed / float(np.max(np.abs(np.gradient(wave, own))))
    by_travel = 0.4 * (e.high - e.low) / float(np.max(np.abs(wave)))
    wave *= min(by_speed, by_travel)
    middle = 0.5 * (e.low + e.high)
    return Motion("multisine", "dynamics: lags, delays, flexible modes", {"position": middle + wave}, own)


def _halton(index: int, base: int) -> float:
    value, factor = 0.0, 1.0 / base
    while index:
        value += factor * (index % base)
        index //= base
        factor /= base
    return value


def _space_filling(e: Envelope, count: int = 24) -> list[tuple[float, float, float]]:
    legs, at = [], 0.5 * (e.low + e.high)
    for k in range(1, count + 1):
        speed = e.speed * 10.0 ** (-2.0 * _halton(k, 3))
        target = e.low + (e.high - e.low) * (0.05 + 0.9 * _halton(k, 2))
        # Legs are limited to two seconds, so that a slow leg covers only part of the travel.
        target = at + float(np.clip(target - at, -2.0 * speed, 2.0 * speed))
        rest = 0.0 if k % 3 else 0.05 * 30.0 ** _halton(k, 5)
        legs.append((target, speed, rest))
        at = target
    return legs


def tip_motions(low: Sequence[float], high: Sequence[float], step: float, most: int = 6000) -> list[Motion]:
    """Excitations of an actuator's tip: voltages of each piezo within `low` and `high` (V); the last is
    space-filling."""
    count = len(low)
    middle = [0.5 * (a + b) for a, b in zip(low, high, strict=True)]
    reach = [0.45 * (b - a) for a, b in zip(low, high, strict=True)]

    def made(name: str, reason: str, waves: Sequence[np.ndarray], own: float) -> Motion:
        signals = {f"voltage_{k + 1}": middle[k] + reach[k] * waves[k] for k in range(count)}
        return Motion(name, reason, signals, own)

    def grid(seconds: float) -> tuple[np.ndarray, float]:
        own = max(step, seconds / most)
        return np.arange(0.0, seconds, own), own

    motions = []
    t, own = grid(12.0)
    steps = np.array([0.0, 1.0, -1.0, 0.5, -0.5, 0.0])[np.minimum((t / 2.0).astype(int), 5)]
    motions.append(made("steps, then rest", "creep, lag, delay", [steps] * count, own))
    t, own = grid(16.0)
    ramp = _triangle(t, 4.0) * np.array([1.0, 0.7, 0.4, 0.2])[np.minimum((t / 4.0).astype(int), 3)]
    motions.append(made("slow ramps of falling height", "hysteresis and nonlinearity", [ramp] * count, own))
    t, own = grid(6.0)
    top = min(200.0, 0.1 / own)
    phase = 2.0 * np.pi * 0.5 * 6.0 / np.log(top / 0.5) * ((top / 0.5) ** (t / 6.0) - 1.0)
    motions.append(made("sine of rising frequency", "lag and delay, flexible modes", [np.sin(phase)] * count, own))
    t, own = grid(8.0)
    alone = [
        _triangle(t, 8.0 / count / 2.0) * ((t >= 8.0 * k / count) & (t < 8.0 * (k + 1) / count)) for k in range(count)
    ]
    motions.append(made("one piezo at a time", "gains that differ between the piezos", alone, own))
    t, own = grid(15.0)
    waves = []
    for k in range(count):
        index = np.minimum((t / 0.5).astype(int), 29)
        levels = np.array([2.0 * _halton(i + 1, (2, 3, 5)[k % 3]) - 1.0 for i in range(30)])
        tone = np.sin(2.0 * np.pi * np.array([0.0, 3.0, 0.0, 11.0, 40.0])[index % 5] * t)
        waves.append(np.clip(0.8 * levels[index] + 0.2 * tone, -1.0, 1.0))
    motions.append(
        made("space-filling", "any effect: levels, frequencies and rests of a low-discrepancy sequence", waves, own)
    )
    return motions


def _triangle(t: np.ndarray, period: float) -> np.ndarray:
    return 2.0 / np.pi * np.arcsin(np.sin(2.0 * np.pi * t / period))
