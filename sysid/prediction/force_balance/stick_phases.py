"""What a body does while friction holds it: rigid friction keeps it where it is, bristles give way with the force.

A contact that gives way by a few widths of the position's noise shows nothing in a force balance: there the noise of
the position, times the bristles' stiffness, is far more than that of the force. The other way round it is plain: the
force on the resting body is known, so is how far a bristle model lets it move, and the position says how far it went.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import lru_cache
from typing import Any

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view

from sim.library.friction_state import FrictionStateModel
from sim.numerics.compilation import SUMS_IN_ANY_ORDER, compiled
from sysid.signals.masks import runs

STICK_DISPLACEMENT = "rest"
"""Name under which displacements at rest are predicted and scored, beside the measured channels."""

LEAST_SAMPLES = 10
"""Samples of a rest, and of all rests together per parameter worth knowing, below which they say nothing."""

NEAR_SLIP = 0.8
USUAL = 0.95
"""Part of the largest force at rest, its 95 % quantile, up to which displacements are scored: beyond, a per cent of the
level is all."""

FULLY_AT_REST = 0.999

WINDOWS = (32, 128, 512)
"""Samples over which a body that moves while the force stays the same is seen to slip, too slowly to tell by speed."""

SLIPS_BY = 7.0
STEADY = 0.02
"""That is a motion by so many deviations, under a force that changes by less than this part of the largest."""

FARTHEST = 100.0
"""Deviations beyond which a displacement is plain in the force balance too."""


@dataclass(frozen=True)
class StickPhases:
    """Stretches of a record in which friction holds the body.

    Args:
        spans: rows (start, stop) of each, its edges and what is close to slip left out.
        side: direction in which the body came to each rest, or was last close to slip, 1 or -1.
        displacement: displacement (n,) from its mean over the scored samples of its rest, m; 0 elsewhere.
        scored: samples (n,) that are compared.
        noise: standard deviation of `displacement`, m.
        force: on the body, filtered, N, (n,).
        compliance: of the spring, m/N, where the position is told by the spring's force alone; 0 where it was measured.
    """

    spans: tuple[tuple[int, int], ...]
    side: tuple[float, ...]
    displacement: np.ndarray
    scored: np.ndarray
    noise: float
    force: np.ndarray
    compliance: float = 0.0

    def centred(self, values: np.ndarray) -> np.ndarray:
        """`values` (n,) less their mean over the scored samples of each rest; 0 outside."""
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
    """The rests of a record that are long enough to tell anything; none where there are none.

    Args:
        position: lightly filtered, m, (n,).
        force: on the body, filtered, N, (n,).
        stuck: part of each step spent at rest, (n,).
        direction: sign of the motion, that of the last one while at rest, (n,).
        usable: samples without gaps near, (n,).
        edge: samples left out at both ends of a rest.
        noise: standard deviation of `position`, m.
        compliance: as in `StickPhases`.
    """
    spans, side = [], []
    scored = np.zeros(position.size, dtype=bool)
    still = stuck > FULLY_AT_REST
    # Where it slips too slowly to tell, or is logged amiss, the force at rest is more than friction can hold.
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
            # Close to slip it gave way by who knows how much, to the side it was pushed to.
            side.append(float(np.sign(force[start - 1]) if start > first else direction[start]))
    if not spans:
        return None
    stick_phases = StickPhases(tuple(spans), tuple(side), np.zeros(position.size), scored, noise, force, compliance)
    return replace(stick_phases, displacement=stick_phases.centred(position))


def _slipping(position: np.ndarray, force: np.ndarray, distance: float, change: float) -> np.ndarray:
    """Samples (n,) around which the position moves on by more than `distance` under a force that hardly changes."""
    out = np.zeros(position.size, dtype=bool)
    for window in WINDOWS:
        if position.size > window:
            moved = np.abs(position[window:] - position[:-window]) > distance
            covered = sliding_window_view(force, window + 1)
            steady = np.max(covered, axis=1) - np.min(covered, axis=1) < change if moved.any() else moved
            for start, stop in runs(moved & steady):
                out[start : stop + window] = True
    return out


@compiled(fastmath=SUMS_IN_ANY_ORDER)
def _given_way(
    starts: np.ndarray,
    stops: np.ndarray,
    sides: np.ndarray,
    friction: np.ndarray,
    level: np.ndarray,
    stretches: np.ndarray,
    weights: np.ndarray,
) -> np.ndarray:
    """Displacement (n,) of bristles in each rest, all slipped to its side before, under the force to be held.

    Each element is an ideal spring up to its own slip: the sum is piecewise linear, and inverted exactly.
    """
    elements = stretches.size
    out, z = np.zeros(friction.size), np.empty(elements)
    for rest in range(starts.size):
        z[:] = sides[rest]
        total, x = sides[rest] * np.sum(weights), 0.0
        held = max(level[starts[rest]], 1e-12)
        for i in range(starts[rest], stops[rest]):
            wanted = min(1.0, max(-1.0, friction[i] / held))
            sign = 1.0 if wanted > total else -1.0
            for _ in range(elements + 1):
                slope, reach = 0.0, np.inf
                for k in range(elements):
                    if z[k] * sign < 1.0:
                        slope += weights[k] / stretches[k]
                        reach = min(reach, (1.0 - z[k] * sign) * stretches[k])
                left = (wanted - total) * sign
                if slope <= 0.0 or left <= 0.0:
                    break
                move = min(left / slope, reach)
                for k in range(elements):
                    if z[k] * sign < 1.0:
                        z[k] += sign * move / stretches[k]
                        if move >= (1.0 - 1e-12) * reach and (1.0 - z[k] * sign) * stretches[k] < 1e-9 * stretches[k]:
                            z[k] = sign
                total += sign * move * slope
                x += sign * move
                if move >= left / slope:
                    break
            out[i] = x
    return out


TAIL = 5.0
"""Stretches, of the level over the stiffness, up to which a core without a sharp end is followed."""

POINTS = 24
"""Ideal springs that stand for such a core."""


@lru_cache(32)
def bristles_of(core: FrictionStateModel, p: Any, level: float, points: int = POINTS) -> tuple[np.ndarray, np.ndarray]:
    """Stretches (N,), m, and shares (N,) of the level of ideal springs side by side that yield as the core does.

    They are kept for whoever asks again, and not to be written to.
    """
    if core.springs is not None:
        return core.springs(p)
    longest = TAIL * level / max(float(p.stiffness), 1e-300)
    knots = longest * (np.arange(points + 1) / points) ** 2
    # Slipped one way, then pushed back: half of the way back is the curve of a fresh contact (Masing).
    path = np.concatenate([[-20.0 * longest, 0.0], -2.0 * knots[1:]])
    time = 1e6 * np.arange(path.size)
    force = core.along_record(path, np.zeros(path.size), time, np.full(path.size, level), p)[1:]
    curve = 0.5 * (1.0 - force / level)
    slope = np.maximum.accumulate(np.maximum(np.diff(curve), 0.0)[::-1] / np.diff(knots)[::-1])[::-1]
    shares = (slope - np.append(slope[1:], 0.0)) * knots[1:]
    return knots[1:], shares / np.sum(shares)


def presliding_displacement(
    stick_phases: StickPhases, friction: np.ndarray, level: np.ndarray, core: FrictionStateModel, p: Any
) -> np.ndarray:
    """Displacement (n,) that bristles let the body make at rest, centred as `StickPhases.displacement`, m.

    Args:
        stick_phases: of the record.
        friction: what has to be held, N, (n,).
        level: friction level, N, (n,).
        core: the bristles that the level acts through.
        p: their parameter values.
    """
    stretches, weights = bristles_of(core, p, max(usual_level(level), 1e-12))
    starts, stops = np.array(stick_phases.spans).T
    moved = _given_way(
        starts, stops, np.array(stick_phases.side), np.ascontiguousarray(friction), np.ascontiguousarray(level),
        stretches, weights,
    )  # fmt: skip
    return stick_phases.centred(moved)


LEVELS = 2000
"""Samples of which the usual level of a record is taken, if there are so many."""


def usual_level(level: np.ndarray) -> float:
    """Median of a friction level (n,), N, at samples all along it."""
    return float(np.median(level[:: max(1, level.size // LEVELS)]))
