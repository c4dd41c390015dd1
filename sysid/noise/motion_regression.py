"""Residual of a channel after regression on smooth functions of the recorded motion.

A measured force is regressed on hat functions of every other recorded channel, of its rate and of the rate's rate,
separately for each direction of motion and at rest: these represent any force law without memory, and the inertia.
Effects with memory, on a scale finer than the hats, or that change in time remain; so does the noise, less the part
along the hat functions, which is small for all but the slowest noise. The regression is not a model of the machine, and
its coefficients are not used elsewhere.
"""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from sysid.experiment.record import Record
from sysid.signals.masks import filled

KNOTS = 10
"""Hat functions of each coordinate."""

SHARP = np.concatenate([-(0.45 ** np.arange(9.0)), [0.0], 0.45 ** np.arange(8.0, -1.0, -1.0)])
"""Knots of a rate over its largest size: friction changes sharply at low velocity."""

OUTPUTS = ("friction_force", "drive_force", "spring_force", "tip_x", "tip_y")
"""Channels that are regressed on the others, but not on each other."""

MOVES = ("velocity", "position", "pull_position", "voltage_1", "voltage_2")
"""Channels whose rates are coordinates, too."""

AT_REST = 1e-4
"""Part of the highest rate up to which a channel is at rest."""

RIDGE = 1e-7
"""Relative to the mean of the diagonal: hat functions without samples."""

SURE = 0.02
"""Part of the rate's scatter up to which the noise of a smoothed rate is small."""


@dataclass(frozen=True)
class MotionResidual:
    """Residual of the regression."""

    values: np.ndarray  # (n,), NaN in gaps
    removed: np.ndarray  # part of the power of noise that the regression removes, (m,) from frequency zero to Nyquist's


def motion_residual(record: Record, values: np.ndarray, channel: str) -> MotionResidual | None:
    """Residual of `values` (n,) of a channel; None if the channel is not an output or nothing else was recorded."""
    if channel not in OUTPUTS:
        return None
    known = {
        name: filled(column)[0]
        for name, column in record.channels.items()
        if name not in OUTPUTS and np.nanmax(column, initial=-np.inf) > np.nanmin(column, initial=np.inf)
    }
    hats = _hat_functions(known, record.time / record.step)
    good = np.isfinite(values)
    if hats is None or good.sum() < 4 * hats.shape[0]:
        return None
    hats[:, ~good] = 0.0
    inner = hats @ hats.T
    root = np.linalg.cholesky(inner + RIDGE * np.trace(inner) / inner.shape[0] * np.eye(inner.shape[0]))
    basis = np.linalg.inv(root) @ hats  # (p, n)
    centred = np.where(good, values - np.mean(values[good]), 0.0)
    residual = centred - (basis @ centred) @ basis
    power = np.zeros(basis.shape[1] // 2 + 1)
    for row in basis:
        power += np.abs(np.fft.rfft(row)) ** 2
    return MotionResidual(np.where(good, residual, np.nan), power / basis.shape[1])


def _hat_functions(known: Mapping[str, np.ndarray], time: np.ndarray) -> np.ndarray | None:
    """Hat functions (p, n) of all coordinates; time in rows."""
    found: list[np.ndarray] = []
    for name, values in known.items():
        if name not in MOVES:
            found.append(hats_of(values))
            continue
        rate = known.get("velocity") if name in ("position", "velocity") else None
        rate = _rate(values, time) if rate is None else rate
        rest = AT_REST * float(np.max(np.abs(rate)))
        ways = [rate > rest, rate < -rest, np.abs(rate) <= rest]
        if name != "velocity":
            hats = hats_of(values)
            found += [hats * way for way in ways]
        if name == "position" and "velocity" in known:
            continue
        found += [hats_of(rate, SHARP)]
        hats = hats_of(_rate(rate, time))
        found += [hats * way for way in ways]
    if not found:
        return None
    return np.concatenate([hats[np.any(hats, axis=1)] for hats in found])


def hats_of(values: np.ndarray, places: np.ndarray | None = None) -> np.ndarray:
    """Hat functions (k, n): on knots at `places` times the largest size, else halfway between even spacing and even
    population."""
    if places is not None:
        knots = places * float(np.max(np.abs(values)))
        knots[[0, -1]] = values.min(), values.max()
        knots = np.unique(np.clip(knots, values.min(), values.max()))
    else:
        shares = np.linspace(0.0, 1.0, KNOTS)
        knots = 0.5 * (np.quantile(values, shares) + values.min() + shares * np.ptp(values))
        knots = knots[np.concatenate([[True], np.diff(knots) > 1e-9 * float(np.max(np.abs(knots)))])]
    if knots.size < 2:
        return np.ones((1, values.size))
    left = np.clip(np.searchsorted(knots, values, side="right") - 1, 0, knots.size - 2)
    part = (values - knots[left]) / (knots[left + 1] - knots[left])
    out = np.zeros((knots.size, values.size))
    rows = np.arange(values.size)
    out[left, rows], out[left + 1, rows] = 1.0 - part, part
    return out


def _rate(values: np.ndarray, time: np.ndarray) -> np.ndarray:
    """Rate (n,) of `values`, smoothed over as many rows as its noise demands."""
    noise = 1.4826 * float(np.median(np.abs(np.diff(values, 3)))) / np.sqrt(20.0)
    width = 1
    while True:
        rate = np.gradient(_smoothed(_smoothed(values, width), width), time)
        if 1.5 * noise <= SURE * float(np.std(rate)) * (2 * width - 1) ** 1.5 or width > values.size // 40:
            return rate
        width *= 2


def _smoothed(values: np.ndarray, width: int) -> np.ndarray:
    """Running mean (n,) over 2 width - 1 rows."""
    if width == 1:
        return values
    padded = np.pad(values, (width, width - 1), mode="reflect", reflect_type="odd")
    total = np.cumsum(padded)
    return (total[2 * width - 1 :] - total[: -(2 * width - 1)]) / (2 * width - 1)
