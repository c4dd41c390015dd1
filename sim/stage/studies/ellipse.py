"""The best phase between the piezos and height of the tip: which ellipse drives fastest, with and without lift."""

import math
from dataclasses import dataclass, field
from functools import partial

import numpy as np

from sim.stage.drive_setting import SETTLED, Ellipse, Setting, Steady, TipDrive, steady, two_piezo_ellipse
from sim.stage.studies import RunAll
from sim.stage.studies.travel_map import LIFTED

PHASES = tuple(math.radians(degrees) for degrees in (30, 50, 70, 90, 110, 130, 150))
HEIGHTS = (0.0, 0.25, 0.5, 0.75, 1.0)
"""Heights of the apex at mid-stroke over the drive surface, in amplitudes of the ellipse's height."""


@dataclass(frozen=True)
class EllipseSearch:
    """Steady speeds over phase and height."""

    frequency: float  # Hz
    phases: np.ndarray  # rad, shape (n,)
    heights: np.ndarray  # in amplitudes of the ellipse's height, shape (m,)
    ellipses: list[Ellipse]  # commanded at each phase
    points: list[list[Steady]] = field(repr=False)  # rows by height, columns by phase

    @property
    def speed(self) -> np.ndarray:
        """m/s, shape (m, n)."""
        return np.array([[point.velocity[0] for point in row] for row in self.points])

    @property
    def lifted(self) -> np.ndarray:
        """Part of the time that a pad is off its way, shape (m, n)."""
        return np.array([[point.lifted_share for point in row] for row in self.points])

    @property
    def is_steady(self) -> np.ndarray:
        """Whether the speed is steady, or was still changing after the longest run, shape (m, n)."""
        changed = np.array([[abs(point.changed) for point in row] for row in self.points])
        travels = np.array([2.0 * path.along for path in self.ellipses])
        return changed <= SETTLED * travels * self.frequency

    def best(self, clean: bool) -> tuple[int, int] | None:
        """Row and column of the greatest steady speed; `clean`: among those that lift no pad."""
        speed = np.where(self.is_steady & (self.lifted <= (LIFTED if clean else np.inf)), self.speed, -np.inf)
        row, column = np.unravel_index(int(np.argmax(speed)), speed.shape)
        return (int(row), int(column)) if np.isfinite(speed[row, column]) else None

    def features(self) -> dict[str, tuple[float, str] | None]:
        found: dict[str, tuple[float, str] | None] = {}
        for name, clean in (("fastest", False), ("fastest_without_lift", True)):
            place = self.best(clean)
            if place is None:
                found[f"{name}_phase"] = None
                continue
            row, column = place
            path = self.ellipses[column]
            found[f"{name}_phase"] = (float(self.phases[column]), "rad")
            found[f"{name}_height"] = (float(self.heights[row]) * path.normal, "m")
            found[f"{name}_speed"] = (float(self.speed[row, column]), "m/s")
            found[f"{name}_travel_along"] = (2.0 * path.along, "m")
            found[f"{name}_travel_normal"] = (2.0 * path.normal, "m")
            found[f"{name}_largest_tip_force"] = (self.points[row][column].largest_tip_force, "N")
        return found


def ellipse_search(drive: TipDrive, run_all: RunAll) -> EllipseSearch:
    """Steady speed over phase and height at one frequency."""
    ellipses = [two_piezo_ellipse(drive.machine, drive.amplitude, phase) for phase in PHASES]
    cases = [Setting(path, drive.frequency, height * path.normal) for height in HEIGHTS for path in ellipses]
    found = run_all(partial(steady, drive.machine, shortest=0.15), cases)
    count = len(PHASES)
    rows = [found[i * count : (i + 1) * count] for i in range(len(HEIGHTS))]
    return EllipseSearch(drive.frequency, np.array(PHASES), np.array(HEIGHTS), ellipses, rows)
