"""What all prepared records have in common."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from sysid.prediction.force_balance.stick_phases import STICK_DISPLACEMENT, StickPhases
from sysid.signals.gaussian_filter import GaussianFilter


class Scored(NamedTuple):
    """A signal compared with a model: values (n,), the samples that count (n,), and the standard deviation of their
    noise."""

    values: np.ndarray
    valid: np.ndarray
    noise: float


@dataclass(eq=False, kw_only=True)
class CommonRecord:
    """One record, prepared. Arrays have shape (n,), SI units, on a uniform time grid.

    Args:
        name, role, step: of the record as read; s.
        kind: of the rig.
        measured: scored channels.
        valid: rows of each that count.
        noise: standard deviation that sensor noise leaves in the residual of each.
        force_channel: the channel of a force balance.
        timing_uncertainty: standard deviation of the times of reversals, s.
        acceleration: of a driven mass, filtered, m/s^2.
        stick_fraction: part of each step in which a driven mass rests.
        full_filter: that the channels of a driven mass have passed through.
        stick_phases: displacements of a driven mass while friction holds it, scored in addition to the channels.
    """

    name: str
    role: str
    kind: str
    step: float
    measured: dict[str, np.ndarray]
    valid: dict[str, np.ndarray]
    noise: dict[str, float]
    force_channel: str = ""
    timing_uncertainty: float = 0.0
    acceleration: np.ndarray | None = None
    stick_fraction: np.ndarray | None = None
    full_filter: GaussianFilter | None = None
    stick_phases: StickPhases | None = None

    @property
    def filter_width(self) -> float:
        """Width of the filter, s; zero where there is none."""
        return self.full_filter.width if self.full_filter is not None else 0.0

    @property
    def scored(self) -> dict[str, Scored]:
        """Signals compared with a model, by name."""
        out = {channel: Scored(y, self.valid[channel], self.noise[channel]) for channel, y in self.measured.items()}
        if self.stick_phases is not None:
            phases = self.stick_phases
            out[STICK_DISPLACEMENT] = Scored(phases.displacement, phases.scored, phases.noise)
        return out
