"""Stick phases of a body, and its presliding displacement in them: zero by rigid friction, elastic with bristles.

A contact that yields by a few standard deviations of the position's noise does not show in a force balance: there that
noise, times the bristles' stiffness, is far larger than the noise of the force. The displacement itself is well
determined: the force on the sticking body is known, so is the displacement of a bristle model under it, and the
position measures it.
"""

from dataclasses import dataclass, replace
from functools import lru_cache
from typing import Any

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view

from sim.effects.friction_state_model import FrictionStateModel
from sim.numerics.compilation import compiled
from sim.numerics.elasto_plastic import Elements, Springs, displace_to, elements_along, springs_of
from sysid.signals import runs

STICK_DISPLACEMENT = "rest"
"""Name under which displacements at rest are predicted and scored, in addition to the measured channels."""

LEAST_SAMPLES = 10
"""Least scored samples of a stick phase."""

NEAR_SLIP = 0.8
USUAL = 0.95
"""Part of the largest force while sticking, its 95 % quantile, up to which displacements are scored: beyond it they
depend on the last per cent of the friction level."""

FULLY_AT_REST = 0.999

WINDOWS = (32, 128, 512)
"""Samples over which a slip is detected that is too slow to show in the velocity: motion under a constant force."""

SLIPS_BY = 7.0
STEADY = 0.02
"""Such a motion exceeds so many standard deviations, and the force changes by less than this part of the largest."""

FARTHEST = 100.0
"""Standard deviations beyond which a displacement shows in the force balance too."""


@dataclass(frozen=True)
class StickPhases:
    """Phases of a record in which friction holds the body."""

    spans: tuple[tuple[int, int], ...]  # rows (start, stop) of each, without its edges and rows close to slip
    side: tuple[float, ...]  # direction in which the body came to rest before each, or was last close to slip, 1 or -1
    displacement: np.ndarray  # (n,) from its mean over the scored samples of the phase, m; 0 elsewhere
    scored: np.ndarray  # samples (n,) that are compared
    noise: float  # standard deviation of `displacement`, m
    force: np.ndarray  # on the body, filtered, N, (n,)
    # of the spring, m/N, where the position follows from the spring force alone; 0 where it was measured
    compliance: float = 0.0

    def centred(self, values: np.ndarray) -> np.ndarray:
        """`values` (n,) less their mean over the scored samples of each phase; 0 outside."""
        starts, stops = np.array(self.spans).T
        return _centred(np.ascontiguousarray(values, dtype=float), self.scored, starts, stops)


@compiled
def _centred(values: np.ndarray, scored: np.ndarray, starts: np.ndarray, stops: np.ndarray) -> np.ndarray:
    out = np.zeros(values.size)
    for k in range(starts.size):
        total, count = 0.0, 0
        for i in range(starts[k], stops[k]):
            if scored[i]:
                total += values[i]
                count += 1
        mean = total / count if count else 0.0
        for i in range(starts[k], stops[k]):
            out[i] = values[i] - mean
    return out


def find_stick_phases(
    position: np.ndarray,
    force: np.ndarray,
    stuck: np.ndarray,
    direction: np.ndarray,
    usable: np.ndarray,
    edge: int,
    noise: float,
    compliance: float = 0.0,
) -> StickPhases | None:
    """The stick phases of a record that are long enough to be scored; none where there are none."""
    spans, side = [], []
    scored = np.zeros(position.size, dtype=bool)
    still = stuck > FULLY_AT_REST
    # Slow slip that does not show in the velocity, or a faulty log, gives forces beyond the friction level.
    largest = float(np.quantile(np.abs(force[still]), USUAL)) if still.any() else 0.0
    slips = np.zeros(position.size, dtype=bool)
    for start, stop in runs(still):
        slips[start:stop] = _slipping(position[start:stop], force[start:stop], SLIPS_BY * noise, STEADY * largest)
    found = runs(still & ~slips)
    found = [(a + edge, b - edge) for a, b in found if b - a > 2 * edge + LEAST_SAMPLES]
    near_slip = np.abs(force) > NEAR_SLIP * largest
    for first, last in found:
        for start, stop in runs(~near_slip[first:last]):
            start, stop = start + first, stop + first
            low = usable[start:stop]
            if low.sum() < LEAST_SAMPLES or np.ptp(position[start:stop][low]) > FARTHEST * noise:
                continue
            scored[start:stop] = low
            spans.append((start, stop))
            # Close to slip the displacement is uncertain; its direction is that of the force.
            side.append(float(np.sign(force[start - 1]) if start > first else direction[start]))
    if not spans:
        return None
    stick_phases = StickPhases(tuple(spans), tuple(side), np.zeros(position.size), scored, noise, force, compliance)
    return replace(stick_phases, displacement=stick_phases.centred(position))


def _slipping(position: np.ndarray, force: np.ndarray, distance: float, change: float) -> np.ndarray:
    """Samples (n,) around which the position changes by more than `distance`, and the force by less than `change`."""
    out = np.zeros(position.size, dtype=bool)
    for window in WINDOWS:
        if position.size > window:
            moved = np.abs(position[window:] - position[:-window]) > distance
            covered = sliding_window_view(force, window + 1)
            steady = np.max(covered, axis=1) - np.min(covered, axis=1) < change if moved.any() else moved
            for start, stop in runs(moved & steady):
                out[start : stop + window] = True
    return out


@compiled
def _spring_displacement(
    starts: np.ndarray, stops: np.ndarray, sides: np.ndarray, friction: np.ndarray, level: np.ndarray, springs: Springs
) -> np.ndarray:
    """Displacement (n,) of bristles in each stick phase, all slipped to its side before, under the force to be held."""
    out = np.zeros(friction.size)
    for rest in range(starts.size):
        held = max(level[starts[rest]], 1e-12)
        springs.force[:] = sides[rest] * held * springs.limit
        total, x = np.sum(springs.force), 0.0
        for i in range(starts[rest], stops[rest]):
            moved, total = displace_to(springs, total, min(held, max(-held, friction[i])), held)
            x += moved
            out[i] = x
    return out


TAIL = 5.0
"""Displacement over level / stiffness up to which a model without a yield point is approximated."""

POINTS = 24
"""Ideal springs of that approximation."""


@lru_cache(32)
def bristles_of(core: FrictionStateModel, p: Any, level: float, points: int = POINTS) -> Elements:
    """Elements that approximate a friction state model at a friction level, N, or those that it consists of. The arrays
    are cached: do not write to them."""
    if core.springs is not None:
        return core.springs(p)
    longest = TAIL * level / max(float(p.stiffness), 1e-300)
    knots = longest * (np.arange(points + 1) / points) ** 2
    # Masing's rule: half of the unloading curve is the curve of first loading.
    path = np.concatenate([[-20.0 * longest, 0.0], -2.0 * knots[1:]])
    time = 1e6 * np.arange(path.size)
    force = core.along_record(path, np.zeros(path.size), time, np.full(path.size, level), p)[1:]
    curve = 0.5 * (1.0 - force / level)
    slope = np.maximum.accumulate(np.maximum(np.diff(curve), 0.0)[::-1] / np.diff(knots)[::-1])[::-1]
    elements = elements_along(knots[1:], np.cumsum(slope * np.diff(knots)), level)
    return elements._replace(weights=elements.weights / max(float(np.sum(elements.weights)), 1e-300))


def presliding_displacement(
    stick_phases: StickPhases, friction: np.ndarray, level: np.ndarray, core: FrictionStateModel, p: Any
) -> np.ndarray:
    """Displacement (n,) of the body on its bristles while sticking, centred as `StickPhases.displacement`, m."""
    springs = springs_of(bristles_of(core, p, max(median_level(level), 1e-12)))
    starts, stops = np.array(stick_phases.spans).T
    moved = _spring_displacement(
        starts, stops, np.array(stick_phases.side), np.ascontiguousarray(friction), np.ascontiguousarray(level), springs
    )
    return stick_phases.centred(moved)


LEVELS = 2000
"""Samples of which the median level of a record is computed, if there are so many."""


def median_level(level: np.ndarray) -> float:
    """Median of a friction level (n,), N, at samples all along it."""
    return float(np.median(level[:: max(1, level.size // LEVELS)]))
