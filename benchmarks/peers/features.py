"""A library of features made by hand for a regression: one force balance, and columns named by effect."""

from __future__ import annotations

import tomllib
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pandas as pd
from scipy.ndimage import gaussian_filter1d
from scipy.signal import lfilter

_UNITS = {
    "s": 1.0,
    "ms": 1e-3,
    "m": 1.0,
    "mm": 1e-3,
    "um": 1e-6,
    "nm": 1e-9,
    "rad": 1.0,
    "mrad": 1e-3,
    "deg": np.pi / 180,
    "N": 1.0,
    "mN": 1e-3,
    "N*m": 1.0,
    "mN*m": 1e-3,
    "V": 1.0,
    "degC": 1.0,
    "m/s": 1.0,
    "mm/s": 1e-3,
    "rad/s": 1.0,
    "deg/s": np.pi / 180,
}
WIDTH = 6.0


@dataclass(frozen=True)
class Problem:
    """A regression: target (n,), base columns (n, b), candidate columns by effect (each (n, k))."""

    target: np.ndarray
    base: np.ndarray
    candidates: dict[str, np.ndarray]


def read_record(path: Path) -> dict[str, np.ndarray]:
    """Columns in SI on the record's mean sampling step; gaps are bridged by straight lines."""
    table = pd.read_csv(path)
    raw = {}
    for header in table.columns:
        name, unit = header.rstrip("]").split(" [")
        raw[name] = table[header].to_numpy(float) * _UNITS[unit]
    time = raw.pop("time")
    grid = np.arange(time[0], time[-1], np.median(np.diff(time)))
    out = {"time": grid}
    for name, values in raw.items():
        good = np.isfinite(values)
        out[name] = np.interp(grid, time[good], values[good])
    return out


def _smooth(x: np.ndarray, step: float, order: int = 0) -> np.ndarray:
    return gaussian_filter1d(x, WIDTH, order=order, truncate=8.0, mode="nearest") / step**order


def _since(mask: np.ndarray, amount: np.ndarray) -> np.ndarray:
    """Running sum of `amount` that starts again wherever `mask` is true."""
    total = np.cumsum(amount)
    start = np.maximum.accumulate(np.where(mask, np.arange(mask.size), 0))
    return total - total[start]


def _axis(data: dict[str, np.ndarray], kind: str, known: dict, base: list[str]) -> Problem:
    step = float(data["time"][1] - data["time"][0])
    mass = float(str(known.get("mass", "nan")).split()[0])
    if "position" in data:
        x = data["position"]
    else:
        x = data["pull_position"] - data["spring_force"] / float(known["pull_stiffness"].split()[0])
    if kind == "velocity-drive":
        v = data.get("velocity", np.gradient(x, step))
        a = np.zeros_like(v)
        force = data["friction_force"]
    else:
        v, a = _smooth(x, step, 1), _smooth(x, step, 2)
        raw = data["spring_force" if kind == "spring-pull" else "drive_force"]
        if kind == "force-drive":
            raw = np.interp(data["time"] - 0.5 * step, data["time"], raw)
        force = _smooth(raw, step)
    fitted_mass = not np.isfinite(mass) and kind != "velocity-drive"
    target = force if fitted_mass else force - np.nan_to_num(mass) * a
    s = np.sign(v)
    span = float(np.ptp(x))
    top = float(np.quantile(np.abs(v), 0.99))
    one, t = np.ones_like(v), data["time"] - data["time"][0]
    travelled = np.cumsum(np.abs(v)) * step
    turned = np.concatenate([[True], s[1:] != s[:-1]])
    away = _since(turned, np.abs(v) * step)
    rested = _since(np.abs(v) > 0.002 * top, np.full_like(v, step))
    age = np.maximum.accumulate(np.where(rested > 0.05, t, -1.0))
    shapes: dict[str, list[np.ndarray]] = {
        "coulomb": [s],
        "viscous": [v],
        "stribeck": [s * np.exp(-((v / w) ** 2)) for w in top * np.geomspace(0.01, 0.5, 7)],
        "quadratic_drag": [v * np.abs(v)],
        "constant_bias": [one],
        "direction_asymmetry": [np.abs(v)],
        "cable_spring": [x],
        "position_dependent_friction": [
            s * wave(2 * np.pi * x / p) for p in span * np.geomspace(0.08, 1.0, 8) for wave in (np.sin, np.cos)
        ],
        "magnetic_cogging": [
            wave(2 * np.pi * x / p) for p in span * np.geomspace(0.04, 0.4, 14) for wave in (np.sin, np.cos)
        ],
        "run_in": [s * np.exp(-travelled / d) for d in span * np.geomspace(0.3, 10, 4)],
        "presliding": [s * np.exp(-away / d) for d in span * np.geomspace(1e-4, 1e-2, 5)],
        "dwell_strengthening": [s * np.exp(-np.maximum(t - age, 0.0) / w) for w in (0.003, 0.03)],
        "sensor_drift": [t, t * t],
        "sensor_lag": [np.gradient(force, step)],
        "flexible_mode": [np.gradient(np.gradient(a, step), step)],
    }
    if "normal_load" in data:
        shapes["load_dependent_friction"] = [s * data["normal_load"]]
    if "temperature" in data:
        shapes["temperature_dependent_friction"] = [s * data["temperature"]]
    keep = np.abs(v) > 0.01 * top
    base_names = ["coulomb" if name == "presliding" else name for name in base]
    columns = [column for name in base_names for column in shapes[name]] + ([a] if fitted_mass else [])
    empty = np.zeros((int(keep.sum()), 0))
    return Problem(
        target[keep],
        np.column_stack([column[keep] for column in columns]) if columns else empty,
        {name: np.column_stack([c[keep] for c in group]) for name, group in shapes.items() if name not in base_names},
    )


def _tip(data: dict[str, np.ndarray]) -> Problem:
    step = float(data["time"][1] - data["time"][0])
    u = np.stack([data["voltage_1"] - 50.0, data["voltage_2"] - 50.0])
    ratio = 20.0 / 46.0

    def both(one: np.ndarray, two: np.ndarray) -> np.ndarray:
        return np.concatenate([ratio * (one - two), 0.5 * (one + two)])

    def low_pass(signal: np.ndarray, constant: float) -> np.ndarray:
        a = np.exp(-step / constant)
        return np.asarray(lfilter([1 - a], [1, -a], signal))

    n = u.shape[1]
    one, zero = np.ones(n), np.zeros(n)
    t = data["time"] - data["time"][0]
    rate = np.stack([np.gradient(one_u, step) for one_u in u])
    y = np.concatenate([data["tip_x"], data["tip_y"]])
    linear = both(*u)
    candidates = {
        "gain_mismatch": both(u[0], -u[1])[:, None],
        "drive_lag": both(rate[0], rate[1])[:, None],
        "piezo_hysteresis": both(40.0 * np.sign(rate[0]) - u[0], 40.0 * np.sign(rate[1]) - u[1])[:, None],
        "piezo_creep": np.column_stack([both(*(low_pass(u[i], w) for i in (0, 1))) for w in (0.3, 1.0, 4.0)]),
        "sensor_nonlinearity": np.column_stack([linear**2, linear**3]),
        "sensor_drift": np.column_stack([np.concatenate([t, zero]), np.concatenate([zero, t])]),
    }
    base = np.column_stack([linear, np.concatenate([one, zero]), np.concatenate([zero, one])])
    return Problem(y, base, candidates)


def read_problems(folder: Path) -> tuple[Problem, Problem]:
    """The regression on the fit record and on the held-out record of an experiment."""
    spec = tomllib.loads((folder / "experiment.toml").read_text(encoding="utf-8"))
    kind, known, base = spec["rig"]["kind"], spec["rig"].get("known", {}), spec["model"]["effects"]
    problems = []
    for role in ("fit", "validate"):
        data = read_record(folder / next(r["file"] for r in spec["record"] if r["role"] == role))
        problems.append(_tip(data) if kind == "actuator-tip" else _axis(data, kind, known, base))
    return problems[0], problems[1]
