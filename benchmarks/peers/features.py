"""A library of features made by hand for a regression: one force balance, and columns named by effect."""

import tomllib
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pandas as pd
from scipy.ndimage import gaussian_filter1d
from scipy.signal import lfilter

from .regression import coefficients

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


def _known(known: dict, *keys: str) -> float:
    """The first of `keys` that is known, SI (the benchmark's files are); NaN where none is."""
    return next((float(str(known[key]).split()[0]) for key in keys if key in known), float("nan"))


def _late(signal: np.ndarray, step: float) -> dict[str, list[np.ndarray]]:
    """What a lag or a delay of `signal` takes from it, on a grid of times."""
    grid = (0.002, 0.004, 0.008, 0.016)
    time = step * np.arange(signal.size)
    return {
        "lag": [_low_pass(signal, constant, step) - signal for constant in grid],
        "delay": [np.interp(time - delay, time, signal) - signal for delay in grid],
    }


def _low_pass(signal: np.ndarray, constant: float, step: float) -> np.ndarray:
    a = np.exp(-step / constant)
    start = [a * signal[0]]
    return np.asarray(lfilter([1 - a], [1, -a], signal, zi=start)[0])


def _axis(data: dict[str, np.ndarray], kind: str, known: dict, base: list[str]) -> Problem:
    step = float(data["time"][1] - data["time"][0])
    mass = _known(known, "mass", "inertia")
    x = data.get("position")
    if x is None and kind == "spring-pull":
        x = data["pull_position"] - data["spring_force"] / _known(known, "pull_stiffness")
    elif x is None:
        x = np.cumsum(data["velocity"]) * step
    filtered = kind != "velocity-drive"
    if not filtered:
        v = data.get("velocity", np.gradient(x, step))
        a = np.gradient(v, step)
        raw = data["friction_force"]
    else:
        v, a = _smooth(x, step, 1), _smooth(x, step, 2)
        raw = data["spring_force" if kind == "spring-pull" else "drive_force"]
        if kind == "force-drive":
            # A command is held from row to row: half a step late on average.
            raw = np.interp(data["time"] - 0.5 * step, data["time"], raw)
    s = np.sign(v)
    span, top = float(np.ptp(x)), float(np.quantile(np.abs(v), 0.99))
    one, t = np.ones_like(v), data["time"] - data["time"][0]
    travelled = np.cumsum(np.abs(v)) * step
    turned = np.concatenate([[True], s[1:] != s[:-1]])
    away = _since(turned, np.abs(v) * step)
    rested = _since(np.abs(v) > 0.002 * top, np.full_like(v, step))
    # Strengthening by rest shows at the next break-away, and decays as the axis moves on.
    began = np.concatenate([[False], (rested[1:] == 0.0) & (rested[:-1] > 0.02)])
    moved = _since(began, np.abs(v) * step) + np.where(np.cumsum(began) > 0, 0.0, span)
    shapes: dict[str, list[np.ndarray]] = {
        "coulomb": [s],
        "viscous": [v],
        "stribeck": [s * np.exp(-((v / w) ** 2)) for w in top * np.geomspace(0.01, 0.5, 7)],
        "quadratic_drag": [v * np.abs(v)],
        "constant_bias": [one],
        "cable_spring": [x],
        "position_dependent_friction": [
            s * wave(2 * np.pi * x / p) for p in span * np.geomspace(0.08, 1.0, 8) for wave in (np.sin, np.cos)
        ],
        "magnetic_cogging": [
            wave(2 * np.pi * x / p) for p in span * np.geomspace(0.04, 0.4, 14) for wave in (np.sin, np.cos)
        ],
        "run_in": [s * np.exp(-travelled / d) for d in span * np.geomspace(0.3, 10, 4)],
        "presliding": [s * np.exp(-away / d) for d in span * np.geomspace(1e-4, 1e-2, 5)],
        "dwell_strengthening": [s * np.exp(-moved / d) for d in span * np.geomspace(1e-4, 1e-2, 3)],
        "frictional_lag": [a * np.abs(v) * np.exp(-((v / w) ** 2)) for w in top * np.geomspace(0.03, 0.5, 3)],
        "sensor_drift": [t, t * t],
    }
    base_names = ["coulomb" if name == "presliding" else name for name in base]
    inertia = [a] if filtered else []
    if kind == "force-drive":
        shapes |= {f"drive_{name}": columns for name, columns in _late(raw, step).items()}
    else:
        # What the sensor should have read: of the measurement itself a column would fit the noise.
        own = np.column_stack([column for name in base_names for column in shapes[name]] + inertia)
        read = own @ coefficients(own, raw)
        shapes |= {f"sensor_{name}": columns for name, columns in _late(read, step).items()}
        shapes["sensor_nonlinearity"] = [read**2, read**3]
    if filtered:
        shapes["flexible_mode"] = [_smooth(x, step, 4)]
    if "normal_load" in data:
        shapes["load_dependent_friction"] = [s * data["normal_load"]]
    if "temperature" in data:
        shapes["temperature_dependent_friction"] = [s * data["temperature"]]
    if known.get("inertia") or "kg*m^2" in str(known.get("mass", "")):
        shapes["gravity_torque"] = [np.sin(x), np.cos(x)]
    if filtered:
        # The same filter on force, acceleration and every feature: what is left is not filtering.
        shapes = {
            name: columns if name == "flexible_mode" else [_smooth(column, step) for column in columns]
            for name, columns in shapes.items()
        }
        raw, a = _smooth(raw, step), _smooth(a, step)
    fitted_mass = filtered and not np.isfinite(mass)
    target = raw - (mass * a if filtered and not fitted_mass else 0.0)
    keep = np.abs(v) > 0.01 * top
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
        "piezo_creep": np.column_stack([both(*(_low_pass(u[i], w, step) for i in (0, 1))) for w in (0.3, 1.0, 4.0)]),
        "sensor_nonlinearity": np.column_stack([linear**2, linear**3]),
        "sensor_drift": np.column_stack([np.concatenate([t, zero]), np.concatenate([zero, t])]),
    }
    base = np.column_stack([linear, np.concatenate([one, zero]), np.concatenate([zero, one])])
    return Problem(y, base, candidates)


def read_problems(folder: Path) -> tuple[Problem, Problem] | None:
    """The regression on the fit record and on the held-out record of an experiment; none where no channel is a sum of
    terms in the others, as of a stage driven by its tip."""
    spec = tomllib.loads((folder / "experiment.toml").read_text(encoding="utf-8"))
    kind, known, base = spec["rig"]["kind"], spec["rig"].get("known", {}), spec["model"]["effects"]
    if kind == "friction-drive":
        return None
    problems = []
    for role in ("fit", "validate"):
        data = read_record(folder / next(r["file"] for r in spec["record"] if r["role"] == role))
        problems.append(_tip(data) if kind == "actuator-tip" else _axis(data, kind, known, base))
    return problems[0], problems[1]
