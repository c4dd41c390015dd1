"""Bending modes of the stage: interpolation over its drive surface, and their steps in time.

A shape is given at the nodes of a regular grid. Between them it is the product of cubics through four nodes each
(Catmull-Rom), continuous with its slopes; its deflection and both slopes are consistent, so that a tip which slides
under a bent stage does the work that it receives.
"""

from typing import Any

import numpy as np

from sim.numerics.compilation import compiled, inlined
from sim.stage.state import Constants, State


@inlined
def _weights(t: float) -> tuple[float, float, float, float]:
    """Weights of four nodes at a part t of the middle interval."""
    return (
        0.5 * t * (-1.0 + t * (2.0 - t)),
        0.5 * (2.0 + t * t * (3.0 * t - 5.0)),
        0.5 * t * (1.0 + t * (4.0 - 3.0 * t)),
        0.5 * t * t * (t - 1.0),
    )


@inlined
def _slopes(t: float) -> tuple[float, float, float, float]:
    """Derivatives of `_weights`."""
    return (
        0.5 * (-1.0 + t * (4.0 - 3.0 * t)),
        0.5 * t * (9.0 * t - 10.0),
        0.5 * (1.0 + t * (8.0 - 9.0 * t)),
        0.5 * t * (3.0 * t - 2.0),
    )


@compiled
def shapes_at(
    grid: np.ndarray, origin: np.ndarray, spacing: np.ndarray, place: tuple[float, float], out: np.ndarray
) -> None:
    """Write deflection and slopes along x and y of every mode (modes, across, along) at a place (x, y) on the stage, m,
    to `out` (3, modes); beyond the grid its edge holds."""
    rows, columns = grid.shape[1], grid.shape[2]
    u = min(max((place[0] - origin[0]) / spacing[0], 0.0), columns - 1.0)
    v = min(max((place[1] - origin[1]) / spacing[1], 0.0), rows - 1.0)
    i, j = min(int(u), columns - 2), min(int(v), rows - 2)
    along, across = _weights(u - i), _weights(v - j)
    along_slope, across_slope = _slopes(u - i), _slopes(v - j)
    for m in range(grid.shape[0]):
        value, by_x, by_y = 0.0, 0.0, 0.0
        for b in range(4):
            row = min(max(j - 1 + b, 0), rows - 1)
            line, slope = 0.0, 0.0
            for a in range(4):
                node = grid[m, row, min(max(i - 1 + a, 0), columns - 1)]
                line += along[a] * node
                slope += along_slope[a] * node
            value += across[b] * line
            by_x += across[b] * slope
            by_y += across_slope[b] * line
        out[0, m], out[1, m], out[2, m] = value, by_x / spacing[0], by_y / spacing[1]


@inlined
def surface(
    c: Constants, s: State, k: int, place: tuple[float, float], refresh: bool
) -> tuple[float, float, float, float, float, float]:
    """Bending of the drive surface above tip `k` at a place (x, y) on the stage: deflection, rate at the middle of the
    step, slopes along x and y; also the offset of the place from where the modes were evaluated."""
    half = 0.5 * c.step
    shapes, at = s.tip_shapes[k], s.tip_shapes_at[k]
    if refresh:
        at[0], at[1] = place
        shapes_at(c.bend_grid, c.bend_corner, c.bend_spacing, place, shapes)
    dx, dy = place[0] - at[0], place[1] - at[1]
    lift, rate, slope_x, slope_y = 0.0, 0.0, 0.0, 0.0
    for m in range(c.bend_rates.shape[0]):
        shape = shapes[0, m] + shapes[1, m] * dx + shapes[2, m] * dy
        lift += shape * s.bend[m]
        rate += shape * (s.bend_velocity[m] + half * s.bend_acceleration[m])
        slope_x += shapes[1, m] * s.bend[m]
        slope_y += shapes[2, m] * s.bend[m]
    return lift, rate, slope_x, slope_y, dx, dy


@inlined
def advance_modes(c: Constants, s: State, writes: bool, loads: Any) -> None:
    """Advance the bending modes by one step."""
    h, half = c.step, 0.5 * c.step
    for m in range(c.bend_rates.shape[0]):
        speed = s.bend_velocity[m] + half * s.bend_acceleration[m]
        s.bend_acceleration[m] = loads.bend[m] - c.bend_rates[m] * s.bend[m] - c.bend_damping[m] * speed
        s.totals[3] += c.bend_damping[m] * speed * speed * h
        before = s.bend_velocity[m]
        s.bend_velocity[m] += h * s.bend_acceleration[m]
        if writes:
            middle = 0.5 * (before + s.bend_velocity[m])
            loads.energy[0] += 0.5 * middle * middle + 0.5 * c.bend_rates[m] * s.bend[m] * s.bend[m]
            loads.energy[0] += c.bend_preload[m] * s.bend[m]
        s.bend[m] += half * s.bend_velocity[m]
