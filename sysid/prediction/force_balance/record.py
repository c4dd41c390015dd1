"""A record as a force balance: measured force on one side, motion that every effect is evaluated along on the other.

Force, acceleration and every term of the model pass through the same Gaussian filter, so that the residual contains
noise and missing physics, not filtering. The width of the filter follows from the position's noise: wide enough that
mass times acceleration is no noisier than the force.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from functools import cached_property
from typing import NamedTuple

import numpy as np

from sim.effects.effect import Axis
from sysid.prediction.force_balance.reversals import SlipPhases
from sysid.prediction.prepared_record import PreparedRecord
from sysid.signals import GaussianFilter, filled

PREFILTER_SHARE = 0.4
"""Part of the whole filter's width that is applied to the motion before a law is evaluated."""

EDGE_WIDTHS = 4.0
"""Samples this many filter widths from the ends or from a gap are not scored: they depend on the extrapolation."""

STROKE_START = 0.05
"""Part of its travel that is left out of the record of a driven mass, or of a record without a reversal."""

LEAST_FORCE = 1e-2
"""Median of a force over its standard deviation below which the log is at rest for most of its rows."""

INDEPENDENT_WIDTHS = 4.0
"""Widths of the filter by which the acceleration is smoothed where it is a coordinate. The residual contains the noise
of mass times acceleration: a curve over the same acceleration would explain up to half of the residual. The noise of
the second derivatives by two Gaussian filters, R times as wide one as the other, has the correlation
(2 R/(1 + R^2))^(5/2), 0.15 here: of the residual 1 % remains explained."""

ROUNDING = 1e-9
"""Noise over the largest value of a logged input that is exact but for its digits."""

REST_SIGMAS = 5.0
"""A velocity within this many standard deviations of its noise is zero."""


class VelocityAgreement(NamedTuple):
    """Derivative of the position over the logged velocity: `factor`, and the rows by which the velocity is late, not a
    number where the two have nothing in common."""

    factor: float
    late: float


@dataclass(frozen=True, eq=False)
class StateObserver:
    """Bandwidth, rad/s; velocity v_m (n,), m/s; friction at the first row, N; and friction in the integration less that
    of the model (n,), N (`sysid.prediction.force_balance.state_observer`)."""

    bandwidth: float
    velocity: np.ndarray
    friction: float
    yields: np.ndarray | float = 0.0


@dataclass(eq=False, kw_only=True)
class ForceBalanceRecord(PreparedRecord):
    """One record as a force balance.

    `measured` has the force channel, filtered (spring force, drive force or friction force), and, where the force of a
    pulling spring and the position are logged, both.

    `complementary_filter` is applied to a law's value for the lightly filtered motion, to match the measured
    channels. `full_filter` is that filter in one, for discontinuous terms: Coulomb friction of a driven mass, which
    flips with `direction` and at `reversals`, and equals `applied`, the unfiltered force, while the body rests
    (`stick_fraction`, the part of each step). Each of the `slip_phases` is put where the model's own momentum ends;
    `prefilter_samples` is the width of the light filter in samples. `velocity_sign` is the direction of an imposed
    motion at the sample; zero where it is not known. `stop_row` is the row itself, or at rest the first row of the
    rest, whose level the friction keeps. `undirected` marks rows whose force was measured, but that are not scored
    since they show no direction of motion. `velocity_noise` is the standard deviation of the axis's velocity, and
    `velocity_agreement` states a contradiction between a logged velocity and the position.
    `half_width_variant` makes the axis from a motion filtered half as much, and the rest of the filter: the
    difference is the error by filtering. The noise of the position is mostly that of steps of `encoder_step`, if above
    zero. `raw_position` is the logged position, gaps bridged where anything was
    `interpolated`. With an `observer` friction follows from the motion of the model, held to the measured position.
    """

    axis: Axis
    complementary_filter: GaussianFilter
    direction: np.ndarray | None = None
    reversals: np.ndarray | None = None
    slip_phases: SlipPhases | None = None
    prefilter_samples: float = 0.0
    velocity_sign: np.ndarray | None = None
    stop_row: np.ndarray | None = None
    undirected: np.ndarray | None = None
    velocity_noise: float = 0.0
    velocity_agreement: VelocityAgreement | None = None
    inputs: dict[str, np.ndarray] = field(default_factory=dict)
    applied: np.ndarray | None = None
    mass: float = 0.0
    acceleration_noise: float = 0.0
    position_noise: float = 0.0
    encoder_step: float = 0.0
    stretch: float = 0.0
    prefiltered_noise: float = 0.0
    pull_stiffness: float = 0.0
    half_width_variant: Callable[[], tuple[Axis, GaussianFilter]] | None = None
    raw_position: np.ndarray | None = None
    interpolated: np.ndarray | None = None
    observer: StateObserver | None = None

    @property
    def size(self) -> int:
        return self.axis.time.size

    @cached_property
    def largest_blur(self) -> float:
        """Largest difference of the filtered motion from the measured one, m; infinite where that is not known."""
        raw = self.raw_position
        return np.inf if raw is None else float(np.max(np.abs(raw - self.axis.position)))

    @property
    def settled_from(self) -> int:
        """First row after the first reversal; of a driven mass, which may turn at rest, and of one stroke, after a part
        of the travel."""
        turns = np.flatnonzero(np.diff(self.axis.direction))
        if turns.size and self.stick_fraction is None:
            return int(turns[0]) + 1
        return int(np.searchsorted(self.axis.travelled, STROKE_START * np.ptp(self.axis.position)))

    def scales(self) -> dict[str, float]:
        axis, force = self.axis, self.force
        y = force if self.is_free else self.measured[self.force_channel]
        # The force of rigid friction has two values: its median is one of them, and the middle lies between.
        middle = 0.0 if self.is_free else float(np.mean(np.quantile(force, [0.05, 0.95])))
        typical, spread = float(np.median(np.abs(force - middle))), float(np.std(force))
        return {
            "force": typical if typical > LEAST_FORCE * spread else spread,
            "channel": float(np.max(np.abs(y))),
            "position": float(np.ptp(axis.position)),
            "velocity": float(np.max(np.abs(axis.velocity))),
            "time": float(axis.time[-1]),
            "sample": self.step,
            "travelled": float(axis.travelled[-1]),
            "rest": float(np.max(axis.contact_age)),
            "load": float(np.ptp(axis.load)),
            "temperature": float(np.ptp(axis.temperature)),
            "load_mean": float(np.mean(axis.load)),
            "temperature_mean": float(np.mean(axis.temperature)),
        }

    @property
    def coordinate_width(self) -> float:
        """Width of the filter of the acceleration where it is a coordinate, s; zero for an imposed motion."""
        return INDEPENDENT_WIDTHS * self.full_filter.width if self.full_filter is not None else 0.0

    @property
    def force(self) -> np.ndarray:
        """Force of the balance, filtered, N, (n,): measured, or that of the pulling spring at the measured position; in
        a free motion, under a constant drive force, that of the inertia."""
        force = self.inputs.get("spring_force", self.measured[self.force_channel])
        return force - self.mass * self.acceleration if self.is_free and self.acceleration is not None else force

    @property
    def is_free(self) -> bool:
        """Whether the drive force is constant: a coast-down or a free oscillation."""
        return self.force_channel == "drive_force" and self.applied is not None and np.ptp(self.applied) == 0.0


def direction_of(velocity: np.ndarray, rest: float) -> np.ndarray:
    """Sign of the velocity (n,), that of the last motion held while |velocity| <= `rest`."""
    sign = np.where(np.abs(velocity) > rest, np.sign(velocity), 0.0)
    last = np.maximum.accumulate(np.where(sign != 0.0, np.arange(sign.size), -1))
    held = np.where(last >= 0, sign[np.maximum(last, 0)], 0.0)
    if not held.all():
        first = sign[np.argmax(sign != 0.0)] if sign.any() else 1.0
        held[held == 0.0] = first
    return held


def distance_since_reversal(position: np.ndarray, direction: np.ndarray) -> np.ndarray:
    """Distance (n,) since the last change of direction."""
    travelled = np.concatenate([[0.0], np.cumsum(np.abs(np.diff(position)))])
    turned = np.concatenate([[True], direction[1:] != direction[:-1]])
    return travelled - travelled[np.maximum.accumulate(np.where(turned, np.arange(turned.size), 0))]


def rest_age(time: np.ndarray, resting: np.ndarray) -> np.ndarray:
    """Time (n,) for which the contact that holds now has been held; zero while it moves."""
    moving_since = np.maximum.accumulate(np.where(resting, -1, np.arange(time.size)))
    start = np.where(moving_since >= 0, time[np.maximum(moving_since, 0)], time[0])
    return np.where(resting, time - start, 0.0)


def make_axis(
    time: np.ndarray,
    position: np.ndarray,
    velocity: np.ndarray,
    acceleration: np.ndarray,
    load: np.ndarray | None,
    temperature: np.ndarray | None,
    rest: float,
) -> Axis:
    """The named quantities of the axis along a record; a load or temperature not recorded is one and zero."""
    direction = direction_of(velocity, rest)
    return Axis(
        time=time,
        position=position,
        velocity=velocity,
        acceleration=acceleration,
        load=np.ones_like(time) if load is None else load,
        temperature=np.zeros_like(time) if temperature is None else temperature,
        contact_age=rest_age(time, np.abs(velocity) <= rest),
        reversal_distance=distance_since_reversal(position, direction),
        travelled=np.concatenate([[0.0], np.cumsum(np.abs(np.diff(position)))]),
        direction=direction,
    )


def integral(velocity: np.ndarray, step: float) -> np.ndarray:
    """Position (n,) from a velocity, by the trapezoidal rule."""
    return np.concatenate([[0.0], np.cumsum(0.5 * (velocity[1:] + velocity[:-1]) * step)])


def optional_channel(channels: Mapping[str, np.ndarray], name: str) -> np.ndarray | None:
    """A channel (n,) with its gaps bridged; none where it is not recorded."""
    values = channels.get(name)
    return None if values is None or not np.isfinite(values).any() else filled(values)[0]
