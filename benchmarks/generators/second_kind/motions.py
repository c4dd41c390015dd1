"""Motions as people use them: references of an axis, voltages of two piezos, and the channels logged beside them."""

from collections.abc import Iterator

import numpy as np

from .machines import Machine

MOTIONS = ("triangle", "trapezoid", "chirp", "staircase", "loops", "random_steps", "day_log")
OPEN_LOOP = "open_loop"
VOLTAGES = ("sweep", "scan", "steps", "loops")
Move = tuple[float, float, float]


def _targets(rng: np.random.Generator, kind: str, m: Machine) -> Iterator[Move]:
    """Endless moves (target, speed, rest afterwards) of one kind."""
    speeds = m.slow * (m.speed / m.slow) ** np.linspace(0.0, 1.0, int(rng.integers(3, 6)))
    rest = m.reach / m.speed * rng.uniform(0.1, 0.8)
    sign, count, place = 1.0, 0, 0.0
    height = m.reach * rng.uniform(0.1, 0.2)
    while True:
        count += 1
        speed = float(speeds[count // 4 % speeds.size])
        stroke = min(m.reach, 0.06 * m.rows * m.step * speed)
        if kind == "triangle":
            yield sign * 0.5 * stroke, speed, 0.0
            sign = -sign
        elif kind == "trapezoid":
            yield sign * 0.5 * m.reach * rng.uniform(0.8, 1.0), float(rng.choice(speeds[-2:])), rest
            sign = -sign
        elif kind == "staircase":
            place += sign * height
            if abs(place) > 0.5 * m.reach:
                sign = -sign
                place += 2.0 * sign * height
            yield place, float(speeds[-1]), 1.5 * rest
        elif kind == "loops":
            shrink = 0.5 * m.reach * (1.0 - 0.85 * (count % 12) / 12.0)
            yield sign * shrink, float(speeds[-2]), 0.0
            sign = -sign
        elif kind == "random_steps":
            yield m.reach * rng.uniform(-0.5, 0.5), float(rng.choice(speeds[1:])), rest * rng.uniform(0.0, 2.0)
        else:
            long = count % int(rng.integers(4, 8)) == 0
            yield m.reach * rng.uniform(-0.5, 0.5), float(rng.choice(speeds[-3:])), (8.0 if long else 0.5) * rest


def reference(rng: np.random.Generator, kind: str, m: Machine) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Position, velocity and acceleration (each (rows,)) that a motion of `kind` prescribes; it begins at rest."""
    n, dt = m.rows, m.step
    if kind == "chirp":
        t = np.arange(n) * dt
        low = m.speed / (np.pi * m.reach)
        high = min(low * rng.uniform(4.0, 20.0), m.acceleration / (2 * np.pi * m.speed), 0.02 * m.rate)
        phase = 2 * np.pi * low * t[-1] / np.log(high / low) * ((high / low) ** (t / t[-1]) - 1.0)
        v = m.speed * rng.uniform(0.6, 1.0) * np.sin(phase) * np.minimum(1.0, t * m.acceleration / m.speed)
    else:
        v, start, place = np.zeros(n), 0.02 * n * dt * rng.random(), 0.0
        for target, speed, rest in _targets(rng, kind, m):
            distance = target - place
            speed = max(speed, abs(distance) / (0.07 * n * dt))
            top = min(speed, np.sqrt(abs(distance) * m.acceleration))
            if top > 0.0:
                ramp, whole = top / m.acceleration, abs(distance) / top + top / m.acceleration
                rows = np.arange(int(np.ceil(start / dt)), min(int((start + whole) / dt) + 1, n))
                t = rows * dt - start
                shape = np.minimum(1.0, np.minimum(t, whole - t) / ramp)
                v[rows] += np.sign(distance) * top * np.maximum(shape, 0.0)
                start += whole
            place, start = target, start + rest
            if start > n * dt:
                break
        width = max(3, int(0.2 * m.speed / m.acceleration * m.rate))
        window = np.hanning(width + 2)[1:-1]
        v = np.convolve(np.pad(v, width, "edge"), window / window.sum(), "same")[width:-width]
        v[np.abs(v) < 1e-9 * m.speed] = 0.0
    x = np.concatenate([[0.0], np.cumsum(0.5 * dt * (v[1:] + v[:-1]))])
    return x, v, np.gradient(v, dt)


def open_loop(rng: np.random.Generator, m: Machine) -> np.ndarray:
    """Command (rows,) of a drive without a controller: a force that sweeps about the frequency that uses the reach."""
    t = np.arange(m.rows) * m.step
    size = rng.uniform(1.4, 2.5)
    middle = np.sqrt(size * m.coulomb / (m.mass * 0.5 * m.reach)) / (2 * np.pi)
    low, high = middle * rng.uniform(0.7, 0.9), min(middle * rng.uniform(1.2, 2.0), 0.03 * m.rate)
    phase = 2 * np.pi * (low * t + 0.5 * (high - low) * t**2 / t[-1])
    return size * m.coulomb * np.sin(phase) * np.minimum(1.0, t * low)


def voltage(rng: np.random.Generator, kind: str, m: Machine) -> np.ndarray:
    """Voltage (rows,) of one piezo, between 0 and 120 V."""
    n = m.rows
    t = np.arange(n) * m.step
    middle, half = rng.uniform(50.0, 65.0), rng.uniform(20.0, 50.0)
    if kind == "sweep":
        low, high = rng.uniform(0.15, 0.5), rng.uniform(4.0, 15.0)
        phase = 2 * np.pi * low * t[-1] / np.log(high / low) * ((high / low) ** (t / t[-1]) - 1.0)
        return middle + half * np.sin(phase + rng.uniform(0.0, 6.0))
    if kind == "scan":
        slow = rng.uniform(0.3, 2.0)
        return middle + half * (2.0 / np.pi) * np.arcsin(0.995 * np.sin(2 * np.pi * slow * t + rng.uniform(0.0, 6.0)))
    if kind == "loops":
        slow = rng.uniform(0.4, 1.5)
        return middle + half * (1.0 - 0.8 * t / t[-1]) * np.sin(2 * np.pi * slow * t)
    hold = rng.uniform(0.4, 1.5, int(t[-1] / 0.4) + 2)
    levels = middle + half * rng.uniform(-1.0, 1.0, hold.size)
    v = levels[np.searchsorted(np.cumsum(hold), t)]
    width = max(3, int(0.01 * m.rate))
    window = np.hanning(width + 2)[1:-1]
    return np.convolve(np.pad(v, width, "edge"), window / window.sum(), "same")[width:-width]


def channels(rng: np.random.Generator, m: Machine) -> tuple[np.ndarray, np.ndarray]:
    """Normal load (N) and temperature (degC), each (rows,): a slow wave with steps, a warming up with a slow wave."""
    t = np.arange(m.rows) * m.step
    end = t[-1]
    load = 1.0 + 0.2 * np.sin(2 * np.pi * rng.uniform(1.5, 4.0) * t / end + rng.uniform(0.0, 6.0))
    for at in rng.uniform(0.0, end, 4):
        load += rng.uniform(-0.15, 0.15) / (1.0 + np.exp(np.clip((at - t) / (0.01 * end), -40.0, 40.0)))
    warm = rng.uniform(2.0, 6.0) * -np.expm1(-t / (end * rng.uniform(0.2, 0.6)))
    warm += rng.uniform(0.3, 1.0) * np.sin(2 * np.pi * rng.uniform(1.0, 3.0) * t / end)
    return m.load * load, m.temperature + warm
