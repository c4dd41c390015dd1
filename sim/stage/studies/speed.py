"""Speed against frequency, with the three laws of the ellipse: X f stopping, 2 X f coasting, pi X f at the apex."""

import math
from dataclasses import dataclass, field
from functools import partial

import numpy as np

from sim.stage.drive_setting import SETTLED, Setting, Steady, TipDrive, steady
from sim.stage.studies import RunAll

LAWS = {"stopping": 1.0, "coasting": 2.0, "apex": math.pi}
NEAR = 0.15
"""A law is met where the speed is within this part of it."""
FREQUENCIES = (20.0, 50.0, 100.0, 200.0, 500.0, 1000.0, 2000.0, 3000.0, 4000.0, 5000.0, 6000.0, 7000.0, 8000.0)
HEIGHTS = {"level": 0.0, "raised": 0.5, "high": 1.0}
"""Height of the apex at mid-stroke over the drive surface, in amplitudes of the ellipse's height."""
HALF = "raised"
"""Height at which the tip touches for about half of each turn: the bent stage comes down on it."""
SECOND_GUESS, SUDDEN = 0.5, 0.5
"""Speed over X f, and cycles of growth of the ellipse, of a second run at that height: slow, and with an impact."""
APART = 0.1
"""Two limit cycles, or an irregular motion: the speeds differ by more than this part of X f."""


@dataclass(frozen=True)
class SpeedStudy:
    """Steady speeds."""

    travel: float  # X, peak to peak, of the commanded ellipse, m
    drive_frequency: float  # the design's, Hz
    frequencies: np.ndarray  # Hz, shape (n,)
    points: dict[str, list[Steady]] = field(repr=False)  # by height, each shape (n,)
    again: list[Steady] = field(repr=False)  # with the height `HALF` and from another initial state, shape (n,)

    def speed(self, height: str) -> np.ndarray:
        """m/s, shape (n,)."""
        return np.array([point.velocity[0] for point in self.points[height]])

    @property
    def scatter(self) -> np.ndarray:
        """Difference of the speeds at the height `HALF` from two initial states over X f, shape (n,)."""
        other = np.array([point.velocity[0] for point in self.again])
        return np.abs(self.speed(HALF) - other) / (self.travel * self.frequencies)

    def swing(self, height: str) -> np.ndarray:
        """X that the tip makes, m, shape (n,): more than commanded near its resonance, less at the current limit."""
        return np.array([point.swing for point in self.points[height]])

    def ratio(self, height: str) -> np.ndarray:
        """Speed over X f, with the X that the tip makes, shape (n,)."""
        return self.speed(height) / (self.swing(height) * self.frequencies)

    def is_steady(self, height: str) -> np.ndarray:
        """Whether the speed is steady, or was still changing after the longest run, shape (n,)."""
        changed = np.array([abs(point.changed) for point in self.points[height]])
        return changed <= SETTLED * self.travel * self.frequencies

    def reached(self, law: str) -> np.ndarray:
        """Frequencies at which the tip, which touches for half of each turn, is at least as fast as a law."""
        return self.frequencies[self.ratio(HALF) >= (1.0 - NEAR) * LAWS[law]]

    def features(self) -> dict[str, tuple[float, str] | None]:
        found: dict[str, tuple[float, str] | None] = {"ellipse_travel": (self.travel, "m")}
        for law in LAWS:
            where = self.reached(law)
            found[f"{law}_reached_from"] = (float(where.min()), "Hz") if where.size else None
            found[f"{law}_reached_to"] = (float(where.max()), "Hz") if where.size else None
        near = np.abs(self.ratio(HALF) - 1.0) <= NEAR
        stopping = float(self.frequencies[int(np.argmin(near)) - 1 if not near.all() else -1]) if near[0] else None
        found["stopping_obeyed_to"] = None if stopping is None else (stopping, "Hz")
        ratios, speeds = (max(map(of, self.points), key=np.max) for of in (self.ratio, self.speed))
        for name, values, unit in (("ratio", ratios, "1"), ("speed", speeds, "m/s"), ("scatter", self.scatter, "1")):
            at = int(np.argmax(values))
            found[f"largest_{name}"] = (float(values[at]), unit)
            found[f"largest_{name}_at"] = (float(self.frequencies[at]), "Hz")
        found["frequencies_of_two_cycles"] = (float(np.sum(self.scatter > APART)), "1")
        for height in self.points:
            at_drive = float(np.interp(self.drive_frequency, self.frequencies, self.speed(height)))
            found[f"speed_at_drive_frequency_{height}"] = (at_drive, "m/s")
            swing = float(np.interp(self.drive_frequency, self.frequencies, self.swing(height)))
            found[f"swing_at_drive_frequency_{height}"] = (swing, "m")
        return found


def speed_study(drive: TipDrive, run_all: RunAll) -> SpeedStudy:
    """Steady speed over frequency and height of the tip, at one height from two initial states."""
    ellipse = drive.path
    cases = [
        Setting(ellipse, frequency, height * ellipse.normal) for height in HEIGHTS.values() for frequency in FREQUENCIES
    ]
    found = run_all(partial(steady, drive.machine, shortest=0.2), cases)
    count = len(FREQUENCIES)
    points = {name: found[i * count : (i + 1) * count] for i, name in enumerate(HEIGHTS)}
    half = list(HEIGHTS).index(HALF) * count
    slow = partial(steady, drive.machine, shortest=0.2, guess=SECOND_GUESS, cycles=SUDDEN)
    again = run_all(slow, cases[half : half + count])
    return SpeedStudy(2.0 * ellipse.along, drive.frequency, np.array(FREQUENCIES), points, again)
