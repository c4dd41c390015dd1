"""What the rigs are told to do: steps of velocity, rests, slow creeping, sweeps, band-limited random motion."""

from dataclasses import dataclass

import numpy as np
from scipy.ndimage import gaussian_filter1d

from .axis import SAMPLE


@dataclass(frozen=True)
class Motion:
    """A guide (position m, its speed m/s), and for a servo a fed force (N) and how firmly it holds the guide (0..1)."""

    guide: np.ndarray
    speed: np.ndarray
    feed: np.ndarray
    gain: np.ndarray
    bandwidth: float = 4.0

    def gains(self, mass: float) -> tuple[float, float, float]:
        """Proportional, derivative and integral gain of a servo of the motion's bandwidth (Hz)."""
        w = 2.0 * np.pi * self.bandwidth
        return mass * w * w, 1.4 * mass * w, mass * w**3 / 2.5


def _noise(rng: np.random.Generator, count: int, top: float) -> np.ndarray:
    """Band-limited random signal of unit standard deviation, up to about `top` Hz."""
    width = 1.0 / (2.0 * np.pi * top * SAMPLE)
    signal = gaussian_filter1d(rng.standard_normal(count + 40), width, mode="wrap")[20 : 20 + count]
    signal = signal - signal.mean()
    ends = np.minimum(np.arange(count), np.arange(count)[::-1])
    return signal / max(signal.std(), 1e-12) * np.minimum(1.0, ends / 60)


def _segments(
    rng: np.random.Generator,
    rows: int,
    reach: float,
    slow: float,
    fast: float,
    *,
    random_share: float,
    rest_share: float,
) -> np.ndarray:
    """Speeds (m/s) of a motion that stays within +-reach (m): the first second runs the whole range both ways."""
    speed = np.zeros(rows)
    top = 0.6 * fast
    k, x = 0, 0.0
    opening = [(+1, 0.9 * reach / top), (-1, 1.8 * reach / top)]
    while k < rows:
        if opening:
            sign, seconds = opening.pop(0)
            part = np.full(int(seconds / SAMPLE), sign * top)
        else:
            kind = rng.random()
            seconds = rng.uniform(0.3, 1.6)
            if kind < rest_share:
                part = np.zeros(int(rng.choice([0.04, 0.15, 0.4, 1.1]) / SAMPLE))
            elif kind < rest_share + random_share:
                level = np.exp(rng.uniform(np.log(5.0 * slow), np.log(0.4 * fast)))
                part = level * _noise(rng, int(1.4 * seconds / SAMPLE), np.exp(rng.uniform(np.log(2), np.log(14))))
            else:
                level = np.exp(rng.uniform(np.log(slow), np.log(fast)))
                sign = rng.choice([-1.0, 1.0])
                if sign * x > 0.3 * reach:
                    sign = -sign
                room = (reach - sign * x) * 0.98
                part = np.full(int(max(min(seconds, room / level), 0.03) / SAMPLE), sign * level)
        part = part[: rows - k]
        path = x + np.cumsum(part) * SAMPLE
        if path.size and np.abs(path).max() > reach:
            part = np.zeros(min(100, rows - k))
            path = np.full(part.size, x)
        speed[k : k + part.size] = part
        k += part.size
        x = path[-1] if path.size else x
    return speed


def _smooth(speed: np.ndarray, rows_wide: int) -> np.ndarray:
    kernel = np.hanning(rows_wide + 2)[1:-1]
    return np.convolve(np.pad(speed, rows_wide, mode="edge"), kernel / kernel.sum(), mode="same")[rows_wide:-rows_wide]


def _path(speed: np.ndarray, start: float = 0.0) -> np.ndarray:
    return start + np.concatenate([[0.0], np.cumsum(0.5 * (speed[1:] + speed[:-1])) * SAMPLE])


def velocity_motion(rng: np.random.Generator, rows: int) -> Motion:
    """Prescribed velocity within +-9 mm, 0.05 to 36 mm/s, with rests and random stretches."""
    reach = 9e-3
    speed = _smooth(_segments(rng, rows, reach, 6e-5, 0.036, random_share=0.4, rest_share=0.12), 7)
    # The drive's resolution: slower than this it stands.
    speed[np.abs(speed) < 1e-6] = 0.0
    zero = np.zeros(rows)
    return Motion(_path(speed), speed, zero, zero)


def pull_motion(rng: np.random.Generator, rows: int) -> Motion:
    """The far end of the pulling spring within +-16.5 mm."""
    speed = _smooth(
        _segments(rng, rows, 16.5e-3, 1.5e-4, 0.05, random_share=0.1, rest_share=0.15), int(rng.integers(6, 40))
    )
    zero = np.zeros(rows)
    return Motion(_path(speed), speed, zero, zero)


def servo_motion(rng: np.random.Generator, rows: int, friction: float, mass: float) -> Motion:
    """A guide is followed for some 40 % of the record; then a random force is fed, the guide held softly."""
    tracked = int(rows * rng.uniform(0.35, 0.5))
    speed = np.zeros(rows)
    speed[:tracked] = _segments(rng, tracked, 15e-3, 3e-4, 0.06, random_share=0.12, rest_share=0.12)
    speed = _smooth(speed, 41)
    speed[tracked + 40 :] = 0.0
    gain = np.ones(rows)
    gain[tracked:] = rng.uniform(0.02, 0.08)
    gain = _smooth(gain, 301)
    feed = np.zeros(rows)
    count = rows - tracked
    centre, spread = rng.uniform(2.5, 7.0), rng.uniform(0.5, 2.5)
    # Enough to slide, not enough to leave the travel.
    swing = 0.7 * friction + mass * (2.0 * np.pi * centre) ** 2 * rng.uniform(1e-3, 3e-3)
    amplitude = min(friction * np.exp(rng.uniform(np.log(0.8), np.log(2.2))), swing)
    t = np.arange(count) * SAMPLE
    tones = rng.normal(centre, spread, 9).clip(1.5, 14.0)
    for f in tones:
        feed[tracked:] += amplitude * np.sqrt(2.0 / tones.size) * np.sin(2 * np.pi * f * t + rng.uniform(0, 2 * np.pi))
    feed[tracked:] *= np.minimum(1.0, np.arange(count) / 500.0)
    return Motion(_path(speed), speed, feed, gain)


def voltages(rng: np.random.Generator, rows: int, bias: float) -> tuple[np.ndarray, np.ndarray]:
    """Two piezo voltages (V): triangles, sines, steps and sweeps, changed independently of each other."""
    return _voltage(rng, rows, bias), _voltage(rng, rows, bias)


def _voltage(rng: np.random.Generator, rows: int, bias: float) -> np.ndarray:
    out = np.zeros(rows)
    k = 0
    while k < rows:
        count = min(int(rng.uniform(0.6, 2.8) / SAMPLE), rows - k)
        t = np.arange(count) * SAMPLE
        f = np.exp(rng.uniform(np.log(0.8), np.log(45.0)))
        size = rng.uniform(8.0, 40.0)
        kind = rng.random()
        if kind < 0.3:
            wave = (
                size
                * np.linspace(1.0, rng.uniform(0.1, 1.0), count)
                * (2.0 / np.pi * np.arcsin(np.sin(2 * np.pi * min(f, 12.0) * t + rng.uniform(0, 6.28))))
            )
        elif kind < 0.6:
            wave = size * np.sin(2 * np.pi * f * t + rng.uniform(0, 6.28))
        elif kind < 0.75:
            high = rng.uniform(10.0, 60.0)
            wave = size * np.sin(2 * np.pi * (0.5 * t + 0.5 * (high - 0.5) * t * t / max(t[-1], SAMPLE)))
        else:
            wave = np.full(count, rng.uniform(-40.0, 40.0))
        out[k : k + count] = wave
        k += count
    return bias + np.clip(out, -40.0, 40.0)
