"""Small records of every rig kind, by Euler steps of their own, in any units."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

ROWS, STEP, MASS, SPRING = 1500, 1e-3, 1.5, 4000.0
BIAS = 60.0
SIGNED = (
    *("position", "velocity", "friction_force", "pull_position", "spring_force", "drive_force"),
    *("tip_x", "tip_y", "tip_z"),
)
"""Channels that change sign with the direction of the axis."""

NOISE = {
    "position": 2e-7,
    "velocity": 1e-4,
    "friction_force": 0.02,
    "spring_force": 0.01,
    "drive_force": 0.01,
    "tip_x": 2e-9,
    "tip_y": 2e-9,
    "tip_z": 2e-9,
}
UNITS = {"position": "m", "velocity": "m/s", "pull_position": "m", "normal_load": "N", "temperature": "degC"} | {
    name: "N" for name in SIGNED if name.endswith("force")
}


@dataclass(frozen=True)
class Rig:
    """A rig kind with the channels that are recorded of it."""

    kind: str
    channels: tuple[str, ...]
    known: Mapping[str, str] = field(default_factory=dict)
    rotary: bool = False


_MASS = {"mass": f"{MASS} kg"}
_PULL = {**_MASS, "pull_stiffness": f"{SPRING} N/m"}
_TIP = {"piezo_spacing": "46 mm", "tip_height": "20 mm", "bias_voltage": f"{BIAS} V"}
RIGS = {
    "velocity drive, position": Rig("velocity-drive", ("position", "friction_force")),
    "velocity drive, both": Rig("velocity-drive", ("position", "velocity", "friction_force")),
    "spring pull, force": Rig("spring-pull", ("pull_position", "spring_force"), _PULL),
    "spring pull, position": Rig("spring-pull", ("pull_position", "position"), _PULL),
    "spring pull, both": Rig("spring-pull", ("pull_position", "position", "spring_force"), _PULL),
    "force drive, position": Rig("force-drive", ("drive_force", "position"), {"inertia": f"{MASS} kg*m^2"}, True),
    "force drive, velocity": Rig("force-drive", ("drive_force", "velocity"), _MASS),
    "two piezos": Rig("actuator-tip", ("voltage_1", "voltage_2", "tip_x", "tip_y"), _TIP),
    "three piezos": Rig("actuator-tip", ("voltage_1", "voltage_2", "voltage_3", "tip_x", "tip_y", "tip_z"), _TIP),
    "friction drive": Rig("friction-drive", ("voltage_1", "voltage_2", "position"), {**_MASS, **_TIP}),
}


def _slide(push: np.ndarray, spring: float, friction: float) -> tuple[np.ndarray, np.ndarray]:
    """Position and velocity (n,) of the mass under a force, or pulled through a spring by the motion `push`, with
    Coulomb friction, by Euler steps of a twentieth of a row."""
    x = v = 0.0
    fine = np.interp(np.arange(20 * push.size) / 20.0, np.arange(push.size), push)
    dt, out = STEP / 20.0, []
    for i, u in enumerate(fine.tolist()):
        if i % 20 == 0:
            out.append((x, v))
        free = v + dt * ((spring * (u - x) if spring else u) - 0.5 * v) / MASS
        lost = dt * friction / MASS
        v = free - lost if free > lost else free + lost if free < -lost else 0.0
        x += dt * v
    position, velocity = np.array(out).T
    return position, velocity


def _channels(rig: Rig, seed: int) -> dict[str, np.ndarray]:
    """Channels (n,) of a record that is not symmetric itself: other strokes and levels in either direction."""
    rng = np.random.default_rng(seed)
    time, turns = STEP * np.arange(ROWS), rng.uniform(0.0, 2.0 * np.pi, 4)
    wave = sum(a * np.sin(2 * np.pi * f * time + p) for a, f, p in zip((1.0, 0.6, 0.4), (1.3, 3.1, 6.7), turns))
    wave = wave + 0.2 * np.sin(2 * np.pi * 1.3 * time + turns[3]) ** 2
    out: dict[str, np.ndarray] = {}
    if rig.kind == "velocity-drive":
        velocity = 0.02 * np.asarray(wave)
        out |= {"velocity": velocity, "position": STEP * np.cumsum(velocity)}
        out["friction_force"] = np.sign(velocity) * (1.5 + 5.0 * np.abs(velocity)) + 0.1
    elif rig.kind == "spring-pull":
        pull = 0.004 * (np.asarray(wave) - np.asarray(wave)[0])
        position, _ = _slide(pull, SPRING, 4.0)
        out |= {"pull_position": pull, "position": position, "spring_force": SPRING * (pull - position)}
    elif rig.kind == "force-drive":
        force = 4.0 * np.asarray(wave)
        position, velocity = _slide(force, 0.0, 2.0)
        out |= {"drive_force": force, "position": position, "velocity": velocity}
    else:
        lean, up = 10.0 * np.asarray(wave), 4.0 * np.roll(np.asarray(wave), 37)
        volts = {"voltage_1": BIAS + up - lean, "voltage_2": BIAS + up + lean, "voltage_3": BIAS + 2.0 * up}
        out |= {k: u for k, u in volts.items() if k in rig.channels}
        d = [1e-7 * (u - BIAS) * (1.0 + 1e-3 * (u - BIAS)) for u in out.values()]
        out |= {"tip_x": -20 / 46 * (d[1] - d[0]), "tip_y": np.mean(d, axis=0), "tip_z": -20 / 46 * (d[-1] - d[0])}
        out["position"] = out["tip_x"] - out["tip_x"][0]
    if rig.kind != "actuator-tip":
        out |= {"normal_load": 20.0 + 3.0 * np.sin(5.0 * time), "temperature": 20.0 + 4.0 * time}
    kept = (*rig.channels, "normal_load", "temperature")
    return {k: u + NOISE.get(k, 0.0) * rng.standard_normal(ROWS) for k, u in out.items() if k in kept}


def unit_of(rig: Rig, channel: str) -> str:
    """SI unit of a channel on that rig."""
    unit = "V" if channel.startswith("voltage") else UNITS.get(channel, "m")
    if rig.rotary and channel != "normal_load":
        return {"m": "rad", "m/s": "rad/s", "N": "N*m"}.get(unit, unit)
    return unit


def write(
    folder: Path, rig: Rig, effects: Sequence[str], seed: int, units: Mapping[str, tuple[str, float]] | None = None
) -> Path:
    """An experiment with one record to fit and one to hold out, in SI units or the `units` of some channels: name, and
    the value of one SI unit in it."""
    listed = ", ".join(f'"{name}"' for name in effects)
    text = f'schema = 1\n[rig]\nkind = "{rig.kind}"\n[rig.known]\n'
    text += "".join(f'{key} = "{value}"\n' for key, value in rig.known.items())
    text += f"[model]\neffects = [{listed}]\n[noise]\n"
    text += "".join(f'{k} = "{v} {unit_of(rig, k)}"\n' for k, v in NOISE.items() if k in rig.channels)
    folder.mkdir(parents=True, exist_ok=True)
    for k, role in enumerate(("fit", "validate")):
        channels = {"time": STEP * np.arange(ROWS), **_channels(rig, seed + k)}
        units = {c: ("s" if c == "time" else unit_of(rig, c), 1.0) for c in channels} | dict(units or {})
        header = ",".join(f"{c} [{units[c][0]}]" for c in channels)
        rows = np.column_stack([u * units[c][1] for c, u in channels.items()])
        np.savetxt(folder / f"{role}.csv", rows, "%.15g", ",", header=header, comments="")
        text += f'[[record]]\nfile = "{role}.csv"\nrole = "{role}"\n'
    (folder / "experiment.toml").write_text(text)
    return folder
