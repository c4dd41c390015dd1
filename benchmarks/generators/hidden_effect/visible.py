"""How much of a hidden effect is left, over the noise, once the base model has been refitted around it.

The record's force balance, free of noise, is regressed on the base model's terms along the motion that really took
place. Samples where rigid friction sticks say nothing (any force up to the level holds) and are left out, as is the
sample beside a reversal.
"""

from collections.abc import Mapping, Sequence

import numpy as np

from .axis import SAMPLE


def left_over(target: np.ndarray, columns: Sequence[np.ndarray], keep: np.ndarray) -> float:
    """Root mean square of `target` (n,) after least squares on `columns` (each (n,)), over the rows to keep."""
    y = target[keep]
    if y.size < 50:
        return 0.0
    if not columns:
        return float(np.sqrt(np.mean(y**2)))
    a = np.column_stack([column[keep] for column in columns])
    scale = np.sqrt(np.mean(a**2, axis=0))
    a = a / np.where(scale > 0.0, scale, 1.0)
    c, *_ = np.linalg.lstsq(a, y, rcond=1e-10)
    return float(np.sqrt(np.mean((y - a @ c) ** 2)))


def filled(direction: np.ndarray) -> np.ndarray:
    """The last direction of motion, carried through rests."""
    rows = np.where(direction != 0.0, np.arange(direction.size), 0)
    return np.where((out := direction[np.maximum.accumulate(rows)]) == 0.0, 1.0, out)


def steady(direction: np.ndarray, *, rests: bool) -> np.ndarray:
    """Rows away from a reversal by more than a sample; rows at rest only if `rests`."""
    d = filled(direction) if rests else direction
    same = np.ones(d.size, bool)
    same[1:] &= d[1:] == d[:-1]
    same[:-1] &= d[:-1] == d[1:]
    same[0] = False
    return same & (d != 0.0)


def base_columns(
    base: Sequence[str],
    direction: np.ndarray,
    velocity: np.ndarray,
    stribeck_velocity: float,
    acceleration: np.ndarray | None = None,
) -> list[np.ndarray]:
    """The base model's terms, linearised about its true Stribeck velocity; `acceleration` when the mass is fitted."""
    columns: list[np.ndarray] = []
    if "coulomb" in base or "presliding" in base:
        columns.append(direction)
    if "viscous" in base:
        columns.append(velocity)
    if "stribeck" in base:
        a = (velocity / stribeck_velocity) ** 2
        columns += [direction * np.exp(-a), direction * a * np.exp(-a)]
    if acceleration is not None:
        columns.append(acceleration)
    return columns


def rival_columns(
    direction: np.ndarray,
    velocity: np.ndarray,
    position: np.ndarray,
    channels: Mapping[str, np.ndarray],
    radius: float | None,
    force: np.ndarray,
) -> dict[str, list[list[np.ndarray]]]:
    """Terms by which another effect might pass for the hidden one: for each name, some shapes to choose from."""
    one = np.ones_like(velocity)
    t = np.arange(velocity.size) * SAMPLE
    travelled = np.concatenate([[0.0], np.cumsum(np.abs(np.diff(position)))])
    rate = np.gradient(force, SAMPLE)
    rivals: dict[str, list[list[np.ndarray]]] = {
        "viscous": [[velocity]],
        "quadratic_drag": [[velocity * np.abs(velocity)]],
        "constant_bias": [[one]],
        "direction_asymmetry": [[one, np.abs(velocity)]],
        "cable_spring": [[position]],
        "stribeck": [[direction * np.exp(-((velocity / s) ** 2))] for s in np.geomspace(5e-4, 0.05, 8)],
        "run_in": [[direction * np.exp(-travelled / s)] for s in np.geomspace(0.005, 0.5, 6)],
        "sensor_drift": [[-np.expm1(-t / s)] for s in np.geomspace(1.0, 60.0, 5)],
        "sensor_lag": [[rate]],
        "sensor_delay": [[rate]],
    }
    if "normal_load" in channels:
        rivals["load_dependent_friction"] = [[direction * channels["normal_load"]]]
    if "temperature" in channels:
        rivals["temperature_dependent_friction"] = [[direction * channels["temperature"]]]
    if radius is not None:
        rivals["gravity_torque"] = [[np.sin(position / radius)]]
    return rivals
