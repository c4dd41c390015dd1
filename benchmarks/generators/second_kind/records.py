"""One case's records: motions drawn, simulated without noise, and written as the logger gives them."""

from dataclasses import dataclass, replace

import numpy as np

from . import refit
from .axis import Motion, run_axis
from .friction_laws import Bristles, Curve
from .hidden import Hidden, Setting
from .loggers import Logger, Table, counted, logged_noise, time_stamps
from .machines import Machine
from .motions import MOTIONS, OPEN_LOOP, VOLTAGES, channels, open_loop, reference, voltage
from .tip import tip

FORCE = {"velocity-drive": "friction_force", "spring-pull": "spring_force", "force-drive": "drive_force"}
POSITION_PART = 0.7
"""Noise that the position's second difference adds to a force balance, over the noise of the force."""
Logged = dict[str, np.ndarray]


@dataclass(frozen=True)
class Inputs:
    """Inputs of one record: its motion (an axis) or two voltages, and the names of both kinds of motion."""

    kind: tuple[str, ...]
    motion: Motion | None
    volts: np.ndarray | None


def draw_inputs(rng: np.random.Generator, m: Machine, effects: list[Hidden]) -> list[Inputs]:
    """Inputs of the fitted and of the held-out record."""
    every = VOLTAGES if m.rig == "actuator-tip" else MOTIONS
    shows = [k for k in every if all(not h.motions or k in h.motions for h in effects)] or list(effects[0].motions)
    drawn = []
    for _ in range(2):
        if m.rig == "actuator-tip":
            kind = (str(rng.choice(shows)), str(rng.choice(every)))
            kind = kind if rng.random() < 0.5 else kind[::-1]
            kind = kind if len(shows) == len(every) else (kind[0], str(rng.choice(shows)))
            drawn.append(Inputs(kind, None, np.array([voltage(rng, k, m) for k in kind])))
            continue
        left = [k for k in shows if not drawn or k != drawn[0].kind[0]] or shows
        kind = (str(rng.choice(left if rng.random() < 0.8 else shows)),)
        motion = Motion(*reference(rng, kind[0], m), *channels(rng, m))
        if m.rig == "force-drive" and kind == ("chirp",) and rng.random() < 0.5:
            kind, motion = (OPEN_LOOP,), replace(motion, command=open_loop(rng, m))
        drawn.append(Inputs(kind, motion, None))
    return drawn


def simulate(m: Machine, inputs: Inputs, setting: Setting) -> Logged:
    """Every channel of one record without noise, as its sensor gives it."""
    if m.rig == "actuator-tip":
        assert inputs.volts is not None
        acting = inputs.volts.copy()
        for chain in setting.piezos:
            acting = np.array([signal(u, m.step) for signal, u in zip(chain, acting, strict=True)])
        xy = tip(m, acting)
        logged = {"tip_x": xy[0], "tip_y": xy[1]}
        logged = {n: setting.sensors.get(n, lambda y, _: y)(y, m.step) for n, y in logged.items()}
        return logged | {"voltage_1": inputs.volts[0], "voltage_2": inputs.volts[1]}
    assert inputs.motion is not None
    laws = list(setting.laws)
    if m.curve and not any(isinstance(law, Curve) for law in laws):
        laws.append(Curve(m.curve, m.curve_speed, f"power_{m.curve_power:.0f}"))
    if m.stretch:
        laws.append(Bristles(m.stretch))
    run = run_axis(m, inputs.motion, laws, setting.chain)
    logged = {"position": run.position, "force": run.force, "velocity": run.velocity, "side": run.side}
    for name, signal in setting.sensors.items():
        name = name if name in logged else "force"
        logged[name] = signal(logged[name], m.step)
    return logged | {
        "normal_load": inputs.motion.load,
        "temperature": inputs.motion.temperature,
        "pull_position": inputs.motion.position,
    }


def problem(m: Machine, logged: Logged, sigma: float, rows: float, mass_known: bool) -> refit.Problem:
    """What the base model is refitted to, over the noise `sigma` (of the force, or of the tip)."""
    if m.rig == "actuator-tip":
        return refit.tip_problem(m, logged, sigma)
    driven = m.rig != "velocity-drive"
    found = refit.axis_problem(m, logged, sigma * (np.hypot(1.0, POSITION_PART) if driven else 1.0), rows, mass_known)
    return found


def closure(m: Machine, logged: Logged, sigma: float) -> float:
    """Spring force against spring stretch (rms over the noise), which a spring's gap or a sensor violates."""
    if m.rig != "spring-pull":
        return 0.0
    rest = logged["force"] - m.stiffness * (logged["pull_position"] - logged["position"])
    best = np.sort(np.abs(rest))[: int(refit.BEST * rest.size)]
    return float(np.sqrt(np.mean(best**2)) / sigma)


def noise_levels(m: Machine, sigma: float, rows: float) -> dict[str, float]:
    """Standstill rms of every measured channel; `rows` is the smoothing that the position's noise calls for."""
    if m.rig == "actuator-tip":
        return {"tip_x": sigma, "tip_y": sigma}
    levels = {FORCE[m.rig]: sigma}
    if m.rig != "velocity-drive":
        # Second difference of white noise after a Gaussian window: s^2 * 3 / (8 sqrt(pi) rows^5) per step^4.
        balance = POSITION_PART * sigma / np.sqrt(2.0 * np.sqrt(np.pi) * rows)
        second = np.sqrt(3.0 / (8.0 * np.sqrt(np.pi) * rows**5)) / m.step**2
        position = balance / (m.mass * second)
        levels["position"] = min(position, 0.3 * sigma / m.stiffness) if m.stiffness else position
    return levels


def table(
    rng: np.random.Generator, m: Machine, logged: Logged, how: Logger, levels: dict[str, float], said: set[str],
    counts: dict[str, float],
) -> Table:  # fmt: skip
    """The columns of one record in SI; `said` names the channels logged beside, `counts` the steps over the noise."""
    t = np.arange(m.rows) * m.step
    stamps = time_stamps(rng, m, how)
    length, force = ("rad", "N*m") if m.rotary else ("m", "N")
    units = {"position": length, "pull_position": length, "velocity": length + "/s", "tip_x": "m", "tip_y": "m"}
    units |= {"voltage_1": "V", "voltage_2": "V", "normal_load": "N", "temperature": "degC"}
    names = {
        "velocity-drive": ["position", "velocity", "friction_force"],
        "spring-pull": ["pull_position", "position", "spring_force"],
        "force-drive": ["drive_force", "position"],
        "actuator-tip": ["voltage_1", "voltage_2", "tip_x", "tip_y"],
    }[m.rig]
    if how.few:
        names = [name for name in names if name != "velocity"]
    columns: Table = {"time": ("s", stamps)}
    for name in [*names, *sorted(said)]:
        y = np.interp(stamps, t, logged["force" if name == FORCE.get(m.rig) else name])
        if name in levels:
            quiet = name == "position"
            counting = counts.get(name, 0.0)
            own = replace(how, lsb=0.0, hum=0.0, outliers=0.0) if counting else how
            y = counted(logged_noise(rng, y, levels[name], own, m.rate, plain=quiet), counting * levels[name])
        elif name == "normal_load":
            y = y + 2e-3 * m.load * rng.standard_normal(y.size)
        elif name == "temperature":
            y = np.round(y + 0.02 * rng.standard_normal(y.size), 2)
        columns[name] = (units.get(name, force), y)
    return columns
