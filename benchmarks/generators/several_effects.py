"""Experiments in which one to three effects act at once, with laws and an integrator of their own.

Nothing is shared with the library that is judged, nor with the other generators. The laws are neighbours of those of
the library, not the same: a Stribeck curve (1 + u) exp(-u), a spring that hardens, cogging with a third harmonic, a
waviness with flattened crests, Andrade's law of viscosity, Iwan's elements with stretches over a decade. The motion is
imposed (`velocity-drive`) or that of a mass under a drive with feedback (`force-drive`), integrated with a set-valued
friction in implicit time steps:

    m (v' - v) = h (F - f_x(x) - c v') - P,   P in h level sign(v') (|P| <= h level at v' = 0).

Every effect is brought to a size by the share of the measured force that the stated model and the other effects, by
their own laws and linear least squares, leave of it: at least `LEAST_VISIBLE` deviations of the noise each.
"""

import json
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

CLASSES = {"named": 0.22, "two": 0.22, "chain": 0.26, "none": 0.15, "unlisted": 0.15}
VISIBLE = (4.0, 30.0)
LEAST_VISIBLE = 3.0
ATTEMPTS = 60
SUBSTEP = 2e-4
"""Time step of the driven mass, s."""

Row = dict[str, np.ndarray]
Law = Callable[[Any], Any]
"""Force (n,) of an effect of unit size along a record; `side` is the direction of motion."""


@dataclass
class Machine:
    """One machine: how it is driven, its travel (m or rad), speed, friction, rows a second and mass (kg or kg m^2)."""

    driven: bool
    rotary: bool
    travel: float
    speed: float
    level: float
    drag: float
    mass: float
    rate: float
    seconds: float
    laws: dict[str, Law] = field(default_factory=dict)


def draw_machine(rng: np.random.Generator, names: tuple[str, ...]) -> Machine:
    """A machine on which effects of these names can act."""
    driven, rotary = rng.random() < 0.5, "gravity_torque" in names or rng.random() < 0.25
    travel = rng.uniform(2.0, 5.0) if rotary else 10 ** rng.uniform(-2.0, -0.5)
    speed, level = travel * rng.uniform(0.4, 1.5), 10 ** rng.uniform(-0.5, 1.5)
    mass = level / (speed * rng.uniform(5.0, 30.0))
    drag = level / speed * rng.uniform(0.1, 0.5)
    rate = float(rng.choice([400.0, 500.0, 1000.0]))
    return Machine(driven, rotary, travel, speed, level, drag, mass, rate, rng.uniform(8.0, 14.0))


def draw_law(rng: np.random.Generator, m: Machine, name: str) -> Law:
    """The law of an effect of unit size."""
    at, width, phase = rng.uniform(-0.3, 0.3) * m.travel, m.travel * rng.uniform(0.05, 0.16), rng.uniform(0, 6.28)
    slow, power = m.speed * rng.uniform(0.03, 0.12), rng.uniform(0.9, 1.1)

    def wave(r: Row) -> np.ndarray:
        return 2.0 * np.pi * r["position"] / width + phase

    laws: dict[str, Law] = {
        "viscous": lambda r: r["velocity"],
        "quadratic_drag": lambda r: r["velocity"] * np.abs(r["velocity"]) ** power,
        "stribeck": lambda r: r["side"] * (1 + np.abs(r["velocity"]) / slow) * np.exp(-np.abs(r["velocity"]) / slow),
        "direction_asymmetry": lambda r: np.abs(r["side"]) + 0.3 * np.abs(r["velocity"]) / m.speed,
        "constant_bias": lambda r: np.ones_like(r["position"]),
        "cable_spring": lambda r: (r["position"] - at) * (1 + 0.15 * ((r["position"] - at) / m.travel) ** 2),
        "gravity_torque": lambda r: np.sin(r["position"] + phase),
        "magnetic_cogging": lambda r: np.sin(wave(r)) + 0.12 * np.sin(3.0 * wave(r)),
        "position_dependent_friction": lambda r: r["side"] * np.tanh(1.2 * np.sin(wave(r))),
        "load_dependent_friction": lambda r: r["side"] * ((r["normal_load"] / 50.0) ** power - 1.0),
        "temperature_dependent_friction": lambda r: (
            r["side"] * np.expm1(900.0 * power * (1 / (r["temperature"] + 273) - 1 / 298))
        ),
        "presliding": lambda r: iwan(r["position"], 2e-3 * m.travel * power) - r["side"],
        # No library has these: knocks at random instants, another axis, a wandering friction, a shaking floor.
        "UNKNOWN_knocks": lambda r: np.sum(
            [np.exp(-0.5 * ((r["time"] - t) / 0.02) ** 2) for t in 1.7 + 2.3 * np.arange(4)], axis=0
        ),
        "UNKNOWN_other_axis": lambda r: np.sin(2.1 * r["time"] + phase + r["start"]) ** 3,
        "UNKNOWN_wander": lambda r: r["side"] * r["wander"],
        "UNKNOWN_floor": lambda r: np.sin(2 * np.pi * 5.3 * r["time"] + 1.5 * np.sin(0.9 * r["time"] + r["start"])),
    }
    return laws[name]


def iwan(position: np.ndarray, stretch: float) -> np.ndarray:
    """Friction (n,) over its level of 30 elements in parallel that slide from stretches over a decade."""
    limits = stretch * np.geomspace(0.1, 1.0, 30)
    held, out = np.zeros(30), np.empty(position.size)
    for k, step in enumerate(np.diff(position, prepend=position[0])):
        held = np.clip(held + step, -limits, limits)
        out[k] = float(np.mean(held / limits))
    return out


NAMED = (
    *("viscous", "quadratic_drag", "stribeck", "direction_asymmetry", "constant_bias", "cable_spring"),
    *("gravity_torque", "magnetic_cogging", "position_dependent_friction", "load_dependent_friction"),
    *("temperature_dependent_friction", "presliding"),
)
UNLISTED = ("UNKNOWN_knocks", "UNKNOWN_other_axis", "UNKNOWN_wander", "UNKNOWN_floor")
ALIKE = (
    {"constant_bias", "direction_asymmetry"},
    {"gravity_torque", "cable_spring", "constant_bias"},
    {"viscous", "quadratic_drag"},
    {"presliding", "stribeck"},
)
"""Effects of which two are not hidden at once: their laws differ by less than an ordinary motion shows."""


def path(rng: np.random.Generator, m: Machine) -> tuple[Callable[[Any], Any], np.ndarray]:
    """A motion as a function of time, and its instants (n,): three sines of unlike periods, or strokes of changing
    length and speed that are rounded at their ends."""
    time = np.arange(int(m.seconds * m.rate)) / m.rate
    if rng.random() < 0.5:
        parts = [(rng.uniform(0.5, 1.0), k * rng.uniform(0.8, 1.2)) for k in (0.5, 1.1, 2.3)]
        size = sum(a for a, _ in parts)
        turn = m.speed / m.travel * 2.0
        shifts = rng.uniform(0.0, 6.28, 3)
        return (
            lambda t: (
                0.5
                * m.travel
                / size
                * sum(a * np.sin(turn * w * t + s) for (a, w), s in zip(parts, shifts, strict=True))
            ),
            time,
        )
    ends, at, t = [0.0], [0.0], 0.0
    while t < m.seconds + 2.0:
        goal = rng.uniform(0.25, 0.5) * m.travel * (-1.0 if at[-1] > 0 else 1.0)
        t += abs(goal - at[-1]) / (m.speed * rng.choice([0.25, 0.6, 1.0]))
        ends.append(t)
        at.append(goal)
    grid = np.arange(0.0, m.seconds + 1.0, 1e-3)
    window = np.hanning(201)
    smooth = np.convolve(np.pad(np.interp(grid, ends, at), 100, mode="edge"), window / window.sum(), "valid")
    return lambda t: np.interp(t, grid, smooth), time


def run(seed: int, m: Machine, amounts: dict[str, float]) -> Row:
    """A record without noise: time, position, velocity, direction and force, and what acts on the body besides."""
    rng = np.random.default_rng(seed)
    target, time = path(rng, m)
    start = rng.uniform(0.0, 6.28)
    row: Row = {"time": time, "start": np.full(time.size, start)}
    row["normal_load"] = 50.0 + 25.0 * np.sin(0.7 * time + start)
    row["temperature"] = 25.0 + 12.0 * np.sin(0.31 * time + 1.0 + start)
    row["wander"] = np.convolve(rng.normal(size=time.size), np.hanning(int(m.rate)), "same") / np.sqrt(m.rate / 2.7)
    if m.driven:
        _driven(m, target, row, amounts)
        return row
    row["position"] = np.asarray(target(time), dtype=float)
    row["velocity"] = np.gradient(row["position"], time)
    row["side"] = np.sign(row["velocity"])
    others = [a * m.laws[name](row) for name, a in amounts.items()]
    row["force"] = sum(others, m.level * row["side"] + m.drag * row["velocity"])
    return row


def _driven(m: Machine, target: Callable[[Any], Any], row: Row, amounts: dict[str, float]) -> None:
    """Motion and force of a mass under a drive with feedback, by implicit steps of set-valued friction."""
    every = max(1, round(1.0 / (m.rate * SUBSTEP)))
    step = 1.0 / (m.rate * every)
    stiff = m.mass * (2 * np.pi * 8.0) ** 2
    damp = 1.4 * np.sqrt(stiff * m.mass)
    at = np.asarray(target(np.arange(row["time"].size * every) * step), dtype=float)
    want = np.gradient(at, step)
    lead = m.level * np.tanh(want / (0.01 * m.speed))
    out, x, v = np.zeros((4, row["time"].size)), float(at[0]), float(want[0])
    outside = ("time", "start", "normal_load", "temperature", "wander")
    for k in range(row["time"].size):
        here: dict[str, Any] = {name: float(row[name][k]) for name in outside}
        for j in range(k * every, (k + 1) * every):
            here.update(position=x, velocity=v)
            forward, backward = (
                sum(float(a * m.laws[name]({**here, "side": side})) for name, a in amounts.items())
                for side in (1.0, -1.0)
            )
            extra, level = 0.5 * (forward + backward), max(0.0, m.level + 0.5 * (forward - backward))
            force = stiff * (at[j] - x) + damp * (want[j] - v) + lead[j]
            if j == k * every:
                out[:, k] = x, v, np.sign(v), force
            free = m.mass * v + step * (force - extra)
            v = float(np.sign(free)) * max(0.0, abs(free) - step * level) / (m.mass + step * m.drag)
            x += step * v
    row["position"], row["velocity"], row["side"], row["force"] = out


def left(m: Machine, row: Row, laws: tuple[str, ...]) -> float:
    """Rms of the force of a record that friction, drag and these laws leave, by linear least squares."""
    moving = row["side"] != 0.0
    inertia = m.mass * np.gradient(row["velocity"], row["time"]) if m.driven else 0.0
    base = [row["side"], row["velocity"]] if m.drag > 0.0 else [row["side"]]
    shapes = np.column_stack([*base, *(m.laws[name](row) for name in laws)])[moving]
    force = (row["force"] - inertia)[moving]
    shapes = shapes / np.linalg.norm(shapes, axis=0)
    rest = force - shapes @ np.linalg.lstsq(shapes, force, rcond=1e-9)[0]
    return float(np.sqrt(np.mean(rest**2)))


class UnfitError(Exception):
    """A draw in which an effect does not show."""


def draw_case(rng: np.random.Generator, klass: str) -> tuple[str, dict[str, Row], dict[str, Any]]:
    """Text of the experiment file, both tables, and the entry of the key; raises UnfitError."""
    count = {"named": 1, "two": 2, "chain": 3, "none": 0, "unlisted": 1}[klass]
    names = tuple(str(n) for n in rng.choice(UNLISTED if klass == "unlisted" else NAMED, count, replace=False))
    if any(len(group & set(names)) > 1 for group in ALIKE):
        raise UnfitError(names)
    m = draw_machine(rng, names)
    if m.driven and {"presliding", "UNKNOWN_wander"} & set(names):
        raise UnfitError(names)
    m.laws = {name: draw_law(rng, m, name) for name in names}
    if "viscous" in names:
        m.drag = 0.0
    noise = m.level * 10 ** rng.uniform(-3.0, -2.0)
    seeds = [int(rng.integers(1 << 31)) for _ in range(2)]
    imposed = [run(seed, Machine(**{**m.__dict__, "driven": False}), {}) for seed in seeds]
    amounts = {}
    for name in names:
        shapes = [{**row, "force": m.laws[name](row)} for row in imposed]
        others = tuple(other for other in names if other != name)
        free = Machine(**{**m.__dict__, "driven": False})
        shown = min(left(free, row, others) for row in shapes)
        amounts[name] = float(np.exp(rng.uniform(*np.log(VISIBLE)))) * noise / max(shown, 1e-12)
        if max(float(np.ptp(amounts[name] * row["force"])) for row in shapes) > 3.0 * m.level:
            raise UnfitError("it would be larger than the friction")
    rows = [run(seed, m, amounts) for seed in seeds]
    if any(np.mean(row["side"] == 0.0) > 0.3 or np.ptp(row["position"]) < 0.2 * m.travel for row in rows):
        raise UnfitError("it hardly moves")
    each = {n: min(left(m, row, tuple(o for o in names if o != n)) for row in rows) / noise for n in names}
    if any(not LEAST_VISIBLE <= value < 5.0 * VISIBLE[1] for value in each.values()):
        raise UnfitError(each)
    length, turn = ("rad", "N*m") if m.rotary else ("m", "N")
    force, base = "drive_force" if m.driven else "friction_force", ["coulomb"] + ["viscous"] * (m.drag > 0.0)
    jitter = (1e-7 if m.driven else 1e-6) * m.travel
    text = [f'schema = 1\n[rig]\nkind = "{"force-drive" if m.driven else "velocity-drive"}"']
    if m.driven:
        known = f'inertia = "{m.mass:.6g} kg*m^2"' if m.rotary else f'mass = "{m.mass:.6g} kg"'
        text.append(f"[rig.known]\n{known}")
    text.append(f"[model]\neffects = {json.dumps(base)}")
    if rng.random() < 0.5:
        text.append(f'[noise]\nposition = "{jitter:.4g} {length}"\n{force} = "{noise:.4g} {turn}"')
    tables: dict[str, Row] = {}
    for role, row in zip(("fit", "validate"), rows, strict=True):
        n = row["time"].size
        columns = {"time [s]": row["time"], f"position [{length}]": row["position"] + jitter * rng.normal(size=n)}
        columns[f"{force} [{turn}]"] = row["force"] + noise * rng.normal(size=n)
        if "load_dependent_friction" in names:
            columns["normal_load [N]"] = row["normal_load"]
        if "temperature_dependent_friction" in names:
            columns["temperature [degC]"] = row["temperature"]
        tables[role] = columns
        text.append(f'[[record]]\nfile = "{role}.csv"\nrole = "{role}"')
    accept = [names[0], "unexplained"] if klass == "unlisted" else sorted(names) or ["adequate"]
    key = {"effect": "+".join(names) or "none", "hidden": list(names), "klass": klass, "accept": accept, "base": base}
    key |= {"rig": "force-drive" if m.driven else "velocity-drive", "rotary": m.rotary, "vis_each": each}
    return "\n".join(text) + "\n", tables, key | {"visible": max(each.values(), default=0.0), "amounts": amounts}


def make_cases(folder: Path, seed: int, cases: int, jobs: int = 1, only: int | None = None) -> None:
    """Write `cases` cases, or one of them, and key.json in `folder`; the same arguments give the same cases."""
    ends = np.cumsum(list(CLASSES.values())) * cases
    keys = {}
    for index in range(cases) if only is None else (only,):
        klass = list(CLASSES)[int(np.searchsorted(ends, index + 0.5))]
        for attempt in range(ATTEMPTS):
            try:
                text, tables, keys[f"case{index:03d}"] = draw_case(np.random.default_rng([seed, index, attempt]), klass)
            except UnfitError:
                continue
            place = folder / f"case{index:03d}"
            place.mkdir(parents=True, exist_ok=True)
            (place / "experiment.toml").write_text(text, encoding="utf-8")
            for role, columns in tables.items():
                rows, head = np.column_stack(list(columns.values())), ",".join(columns)
                np.savetxt(place / f"{role}.csv", rows, "%.10g", ",", header=head, comments="")
            break
    (folder / "key.json").write_text(json.dumps(keys, indent=1), encoding="utf-8")
