"""Voltages of a friction drive: leaning, leaning while the tip rises and falls, stepping, resting, and sawteeth."""

import numpy as np

from .truth import BIAS


def _sines(random: np.random.Generator, time: np.ndarray, most: float) -> np.ndarray:
    total = np.zeros(time.size)
    for frequency in (random.uniform(0.8, 1.6), random.uniform(2.5, 4.0), random.uniform(6, 9), random.uniform(11, 16)):
        total += random.uniform(0.5, 1.0) * np.sin(2 * np.pi * frequency * time + random.uniform(0, 6.28))
    return most * (total - total[0]) / np.max(np.abs(total - total[0]))


def _eased(time: np.ndarray, signal: np.ndarray) -> np.ndarray:
    return signal * np.minimum(time / 0.1, 1.0)


def lean(random: np.random.Generator, time: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Leans of many sizes and speeds, at one height."""
    side = _eased(time, _sines(random, time, 40.0))
    return BIAS - side, BIAS + side


def lift(random: np.random.Generator, time: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The same, the tip rising and falling besides, never off the stage."""
    side, up = _eased(time, _sines(random, time, 35.0)), _eased(time, _sines(random, time, 20.0))
    return BIAS + up - side, BIAS + up + side


def walk(random: np.random.Generator, time: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Steps: the tip goes round an ellipse, forward and back, faster and slower, at sizes of its own."""
    side, up = np.zeros(time.size), np.zeros(time.size)
    start, phase = 0.15, 0.0
    while start < time[-1]:
        frequency, size = random.uniform(5.0, 25.0), random.uniform(20.0, 40.0)
        turns = int(random.integers(3, 9))
        way = random.choice([-1.0, 1.0])
        end = start + turns / frequency
        on = (time >= start) & (time < end)
        phase = 2 * np.pi * frequency * (time[on] - start)
        window = np.sin(np.pi * (time[on] - start) / (end - start)) ** 0.5
        side[on] = size * np.sin(phase) * window
        up[on] = way * 0.8 * size * np.cos(phase) * window
        start = end + random.uniform(0.02, 0.12)
    return BIAS + up - side, BIAS + up + side


def rests(random: np.random.Generator, time: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Leans to one place after another, with rests of many lengths between."""
    side = np.zeros(time.size)
    start, at = 0.1, 0.0
    while start < time[-1]:
        to, move = random.uniform(-40.0, 40.0), random.uniform(0.01, 0.06)
        on = time >= start
        side[on] = at + (to - at) * np.clip((time[on] - start) / move, 0.0, 1.0)
        at, start = to, start + move + float(np.exp(random.uniform(np.log(0.003), np.log(0.3))))
    return BIAS - side, BIAS + side


def sawtooth(random: np.random.Generator, time: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Slow one way and quick the other: the stage stays behind the quick stroke."""
    return _teeth(random, time, False)


def there_and_back(random: np.random.Generator, time: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Sawteeth, the quick strokes of one burst against those of the burst before."""
    return _teeth(random, time, True)


def _teeth(random: np.random.Generator, time: np.ndarray, turned: bool) -> tuple[np.ndarray, np.ndarray]:
    side = np.zeros(time.size)
    start, way = 0.1, 1.0
    while start < time[-1] - 0.4:
        period, size, quick = random.uniform(0.03, 0.12), random.uniform(20.0, 40.0), random.uniform(1.5e-3, 6e-3)
        way = -way if turned else random.choice([-1.0, 1.0])
        for _ in range(int(random.integers(2, 6))):
            corners = np.array([start, start + period - quick, start + period])
            on = (time >= start) & (time < start + period)
            side[on] = way * np.interp(time[on], corners, np.array([0.0, size, 0.0]))
            start += period
        start += random.uniform(0.02, 0.1)
    return BIAS - side, BIAS + side


MOTIONS = {
    "lean": lean, "lift": lift, "walk": walk, "rests": rests, "sawtooth": sawtooth, "there_and_back": there_and_back
}  # fmt: skip
