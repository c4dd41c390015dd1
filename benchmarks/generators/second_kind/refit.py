"""What a refit of the base model leaves on records without noise, alone and with one effect of a library beside it.

The base model is linear in its parameters (Coulomb, viscous, Stribeck about its true curve, mass): least squares on the
rows that move, best 97 % of them, over the noise.
"""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from .friction_laws import Bristles, State
from .machines import Machine
from .tip import tip

BEST = 0.97
MOST = 4000
LATE_ROWS, MEMORY_ROWS = (1, 2, 3, 5, 8), (1, 2, 4, 7, 12, 20, 35, 60)
STRETCHES = np.geomspace(1e-3, 0.2, 10)
PARAMETERS = {
    "viscous": 1, "quadratic_drag": 1, "constant_bias": 1, "load_dependent_friction": 1, "sensor_lag": 1,
    "temperature_dependent_friction": 1, "drive_lag": 1, "gain_mismatch": 1, "rate": 1, "magnetic_cogging": 3,
    "position_dependent_friction": 3,
}  # fmt: skip
"""How many parameters each effect has beside the base model's; two where not listed."""
CHANNEL = {"load_dependent_friction": "normal_load", "temperature_dependent_friction": "temperature"}


@dataclass(frozen=True)
class Problem:
    """Least squares of one record: `target` over the noise, `base` columns (rows, n), `signals` for further columns."""

    target: np.ndarray
    base: np.ndarray
    signals: dict[str, np.ndarray]


def _left(target: np.ndarray, base: np.ndarray) -> float:
    """Root mean square over the best 97 % of rows after least squares on the columns of `base`."""
    if base.shape[1]:
        scale = np.linalg.norm(base, axis=0)
        a = base / np.where(scale > 0.0, scale, 1.0)
        target = target - a @ np.linalg.lstsq(a, target, rcond=1e-9)[0]
    best = np.sort(np.abs(target))[: max(1, int(BEST * target.size))]
    return float(np.sqrt(np.mean(best**2)))


def left(problems: list[Problem], columns: list[np.ndarray] | None = None) -> list[float]:
    """What the base model leaves of each problem, with further columns of each where given."""
    more = columns or [np.empty((p.target.size, 0)) for p in problems]
    return [_left(p.target, np.column_stack([p.base, c])) for p, c in zip(problems, more, strict=True)]


def smooth(y: np.ndarray, rows: float) -> np.ndarray:
    """`y` after a Gaussian window of standard deviation `rows`."""
    half = int(4 * rows) + 1
    window = np.exp(-0.5 * (np.arange(-half, half + 1) / rows) ** 2)
    return np.convolve(np.pad(y, half, "edge"), window / window.sum(), "valid")


def unit_bristles(m: Machine, x: np.ndarray) -> np.ndarray:
    """Force (rows,) of the base model's bristles at a level of one, along positions `x`."""
    bristles, out = Bristles(m.stretch), np.empty(x.size)
    for k, dx in enumerate(np.diff(x, prepend=x[0])):
        bristles.moved(dx)
        out[k] = bristles.value(State())
    return out


def stops(x: np.ndarray, stretches: np.ndarray) -> np.ndarray:
    """Mean of six elasto-plastic elements of unit force, for each stretch along positions `x`: (rows, stretches)."""
    limits = np.outer(stretches, (np.arange(6) + 0.5) / 3.0)
    z, out = np.zeros_like(limits), np.empty((x.size, stretches.size))
    for k, dx in enumerate(np.diff(x, prepend=x[0])):
        z += dx
        np.minimum(z, limits, out=z)
        np.maximum(z, -limits, out=z)
        out[k] = (z / limits).sum(axis=1)
    return out / 6.0


def axis_problem(m: Machine, logged: dict[str, np.ndarray], noise: float, rows: float, mass_known: bool) -> Problem:
    """The force balance of a record of an axis: friction against direction, velocity (and acceleration)."""
    force, x = logged["force"], logged["position"]
    driven = m.rig != "velocity-drive"
    v = np.gradient(x, m.step) if driven else logged["velocity"]
    a = np.gradient(v, m.step)
    if driven:
        a[1:-1] = np.diff(x, 2) / m.step**2
        mean = force.copy()
        if m.rig == "force-drive":
            mean[1:] = 0.5 * (force[1:] + force[:-1])
        force, v, a = (smooth(y, rows) for y in (mean, v, a))
        noise = noise / np.sqrt(2.0 * np.sqrt(np.pi) * rows)
    known = m.mass if m.rig == "spring-pull" or mass_known else 0.0
    side = np.sign(logged["side"])
    order = np.where(side != 0.0, np.arange(side.size), 0)
    filled = side[np.maximum.accumulate(order)]
    reach = int(4 * rows) + 1 if driven else 1
    keep = (side != 0.0) if driven else (filled != 0.0)
    for shift in range(1, reach + 1):
        keep[shift:] &= filled[shift:] == filled[:-shift]
        keep[:-shift] &= filled[:-shift] == filled[shift:]
        if driven:
            keep[shift:] &= side[:-shift] != 0.0
            keep[:-shift] &= side[shift:] != 0.0
    keep[:reach] = keep[-reach:] = False
    base = [unit_bristles(m, x) if m.stretch else filled, v]
    if m.curve:
        power = (np.abs(v) / m.curve_speed) ** m.curve_power
        base += [filled * np.exp(-power), filled * power * np.exp(-power)]
    if driven and not known:
        base.append(a)
    t = np.arange(x.size) * m.step
    way = np.concatenate([[0.0], np.cumsum(np.abs(np.diff(x)))])
    signals = {"d": filled, "v": v, "x": x, "t": t, "way": way}
    signals |= {f"stop_{k}": y for k, y in enumerate(stops(x, m.reach * STRETCHES).T)}
    if m.curve:
        # The Stribeck curve of the base model, after pure delays of its speed.
        for k in MEMORY_ROWS:
            late = np.concatenate([np.full(k, v[0]), v[:-k]])
            signals[f"memory_{k}"] = filled * np.exp(-((np.abs(late) / m.curve_speed) ** m.curve_power))
    signals |= {f"late_{k}": force - np.concatenate([np.full(k, force[0]), force[:-k]]) for k in LATE_ROWS}
    signals |= {name: logged[name] for name in ("normal_load", "temperature")}
    thin = np.flatnonzero(keep)
    thin = thin[:: max(1, thin.size // MOST)]
    target, columns = ((force - known * a) / noise)[thin], np.column_stack(base)[thin]
    signals = {name: y[thin] for name, y in signals.items()}
    # A sensor's curve acts on the force that the base model gives: on the force itself it would explain anything.
    signals["model"] = columns @ np.linalg.lstsq(columns, target, rcond=1e-12)[0] if thin.size else target
    return Problem(target, columns, signals)


def tip_problem(m: Machine, logged: dict[str, np.ndarray], noise: float) -> Problem:
    """Both tip coordinates against the geometry with one common gain and an offset each."""
    volts = np.array([logged["voltage_1"], logged["voltage_2"]])
    every = max(1, 2 * volts.shape[1] // MOST)
    plain = (tip(m, volts) / noise)[:, ::every]
    y = np.array([logged["tip_x"], logged["tip_y"]])[:, ::every] / noise
    n = y.shape[1]
    one, zero = np.ones(n), np.zeros(n)
    t = np.arange(volts.shape[1])[::every] * m.step
    rate = (np.gradient(tip(m, volts), axis=1) / noise)[:, ::every]
    signals = {"plain": plain, "rate": rate, "u2": (volts[1, ::every] - m.bias), "t": t}
    base = np.column_stack([plain.ravel(), np.concatenate([one, zero]), np.concatenate([zero, one])])
    return Problem(y.ravel(), base, signals)


def _tip_shapes(s: dict[str, np.ndarray], m: Machine) -> Iterator[tuple[str, np.ndarray]]:
    yield "rate", np.column_stack([s["rate"].ravel()])
    zero = np.zeros_like(s["t"])
    yield "gain_mismatch", np.column_stack([np.concatenate([-m.height / m.spacing * s["u2"], 0.5 * s["u2"]])])
    x, y = s["plain"] / np.max(np.abs(s["plain"]), axis=1, keepdims=True)
    bent = [np.concatenate(p) for p in ((x**2, zero), (x**3, zero), (zero, y**2), (zero, y**3))]
    yield "sensor_nonlinearity", np.column_stack(bent)
    for time in np.geomspace(0.1, 2.0, 5) * s["t"][-1]:
        settled = -np.expm1(-s["t"] / time)
        yield "sensor_drift", np.column_stack([np.concatenate([settled, zero]), np.concatenate([zero, settled])])


def _axis_shapes(s: dict[str, np.ndarray], m: Machine) -> Iterator[tuple[str, np.ndarray]]:
    d, v, x, t = s["d"], s["v"], s["x"], s["t"]
    one = np.ones_like(v)
    yield "viscous", np.column_stack([v])
    yield "quadratic_drag", np.column_stack([v * np.abs(v)])
    yield "constant_bias", np.column_stack([one])
    yield "direction_asymmetry", np.column_stack([one, np.abs(v)])
    yield "cable_spring", np.column_stack([one, x])
    yield "load_dependent_friction", np.column_stack([d * s["normal_load"]])
    yield "temperature_dependent_friction", np.column_stack([d * s["temperature"]])
    if m.rotary:
        yield "gravity_torque", np.column_stack([np.sin(x), np.cos(x)])
    for late in (name for name in s if name.startswith("late")):
        yield "drive_lag" if m.rig == "force-drive" else "sensor_lag", np.column_stack([s[late]])
    if m.rig != "force-drive":
        yield "sensor_nonlinearity", np.column_stack([s["model"] ** 2, s["model"] ** 3])
    for speed in m.speed * np.geomspace(0.01, 0.5, 9):
        yield "stribeck", np.column_stack([d * np.exp(-((v / speed) ** 2))])
        yield "stribeck", np.column_stack([d * np.exp(-np.abs(v) / speed)])
    for memory in (name for name in s if name.startswith("memory")):
        yield "frictional_lag", np.column_stack([s[memory]])
    for k in range(len(STRETCHES) - 1):
        yield "presliding", np.column_stack([s[f"stop_{k}"], s[f"stop_{k + 1}"]])
    for way in m.reach * np.geomspace(0.3, 30.0, 8):
        yield "run_in", np.column_stack([d * np.exp(-s["way"] / way)])
    for time in np.geomspace(0.1, 2.0, 5) * t[-1]:
        yield "sensor_drift", np.column_stack([-np.expm1(-t / time)])
    for cycles in np.arange(0.4, 20.0, 0.25):
        phase = 2 * np.pi * cycles * x / m.reach
        wave = np.column_stack([np.sin(phase), np.cos(phase)])
        yield "magnetic_cogging", wave
        yield "position_dependent_friction", d[:, None] * wave


def rivals(m: Machine, problems: list[Problem], logged: set[str]) -> dict[str, float]:
    """For each effect of a library, what it leaves in its best shape beside the base model (the smaller record's)."""
    shapes = _tip_shapes if m.rig == "actuator-tip" else _axis_shapes
    found: dict[str, float] = {}
    for rows in zip(*(shapes(p.signals, m) for p in problems), strict=True):
        name = rows[0][0]
        if CHANNEL.get(name, "") not in logged | {""}:
            continue
        remains = max(left(problems, [columns for _, columns in rows]))
        found[name] = min(found.get(name, np.inf), remains)
    return found


def both(m: Machine, problems: list[Problem], names: tuple[str, str]) -> float:
    """What the best shapes of two effects together leave."""
    shapes = _tip_shapes if m.rig == "actuator-tip" else _axis_shapes
    chosen: list[list[list[np.ndarray]]] = []
    for name in names:
        options = [[columns for n, columns in shapes(p.signals, m) if n == name] for p in problems]
        if not options[0]:
            return np.inf
        ranked = sorted(zip(*options, strict=True), key=lambda columns: max(left(problems, list(columns))))
        chosen.append([list(columns) for columns in ranked[:4]])
    pairs = ([np.column_stack(c) for c in zip(a, b, strict=True)] for a in chosen[0] for b in chosen[1])
    return min(max(left(problems, columns)) for columns in pairs)
