"""Common properties of all prepared records."""

from abc import ABC, abstractmethod
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any, NamedTuple, Protocol, Self

import numpy as np

from sysid.prediction.force_balance.stick_phases import STICK_DISPLACEMENT, StickPhases
from sysid.signals import GaussianFilter

LONGEST_START = 0.1
"""Largest part of a record that is left out at its start."""


class PredictsChannels(Protocol):
    """What a prepared record knows of its rig (`sysid.prediction.rig_model.RigModel`)."""

    @property
    def predict(self) -> Callable[..., dict[str, Any]]: ...


class Scored(NamedTuple):
    """A signal compared with a model: values (n,), the samples that count (n,), and the standard deviation of their
    noise."""

    values: np.ndarray
    valid: np.ndarray
    noise: float


@dataclass(eq=False, kw_only=True)
class PreparedRecord(ABC):
    """One record, prepared. Arrays have shape (n,), SI units, on a uniform time grid."""

    # name, role, step: of the record as read; s
    name: str
    role: str
    rig: PredictsChannels  # that predicts its channels
    step: float
    measured: dict[str, np.ndarray]  # scored channels
    valid: dict[str, np.ndarray]  # rows of each that count
    noise: dict[str, float]  # standard deviation that sensor noise leaves in the residual of each
    force_channel: str = ""  # the channel of a force balance
    timing_uncertainty: float = 0.0  # standard deviation of the times of reversals, s
    acceleration: np.ndarray | None = None  # of a driven mass, filtered, m/s^2
    stick_fraction: np.ndarray | None = None  # part of each step in which a driven mass rests
    full_filter: GaussianFilter | None = None  # that the channels of a driven mass have passed through
    # displacements of a driven mass while friction holds it, scored in addition to the channels
    stick_phases: StickPhases | None = None
    # the record prepared from the same log with noise of its sensors added, where a prediction uses a measured motion,
    # and of further draws of this noise
    redrawn: tuple[Self, ...] = ()

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

    @property
    @abstractmethod
    def size(self) -> int:
        """Number of samples."""

    @property
    def time(self) -> np.ndarray:
        """s, (n,)."""
        return self.step * np.arange(self.size)

    @property
    @abstractmethod
    def settled_from(self) -> int:
        """First row whose prediction does not depend on a state that was not recorded.

        The initial state of bristles, plays and creep results from the motion before the first row. It has no influence
        after a reversal, or after a driven mass has slid far beyond the stretch of bristles.
        """

    @abstractmethod
    def scales(self) -> dict[str, float]:
        """Scales of the record, by their names in `Scales`."""

    @property
    def settled_rows(self) -> np.ndarray:
        """Rows (n,) from `settled_from` on; at most a tenth of the rows is left out."""
        return np.arange(self.size) >= min(self.settled_from, int(LONGEST_START * self.size))

    def without_start(self) -> Self:
        """The record without the rows before `settled_from` in any comparison, the same for all models."""
        rows, phases = self.settled_rows, self.stick_phases
        if phases is not None:
            phases = replace(phases, scored=phases.scored & rows)
            phases = replace(phases, displacement=phases.centred(phases.displacement))
        valid = {channel: scored & rows for channel, scored in self.valid.items()}
        return replace(self, valid=valid, stick_phases=phases)
