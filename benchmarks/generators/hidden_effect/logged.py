"""A record as it is logged, and the text of its experiment."""

import json

import numpy as np

from .axis import SAMPLE
from .drawn import Record, Rig
from .nuisance import noise
from .running import Settings, on_position, run_axis, run_tip
from .sensors import rounded, sense

FORCE = {"velocity-drive": "friction_force", "spring-pull": "spring_force", "force-drive": "drive_force"}


def _quantity(value: float, unit: str, digits: int = 6) -> str:
    return f'"{value:.{digits}g} {unit}"'


def experiment_text(rig: Rig, known: dict[str, str], noises: dict[str, tuple[float, str]]) -> str:
    """The text of experiment.toml."""
    lines = ["schema = 1", "", "[rig]", f'kind = "{rig.plan.rig}"', "", "[rig.known]"]
    lines += [f"{name} = {value}" for name, value in known.items()]
    lines += ["", "[model]", f"effects = {json.dumps(list(rig.base))}"]
    for role in ("fit", "validate"):
        lines += ["", "[[record]]", f'file = "{role}.csv"', f'role = "{role}"']
    if rig.how.noise_given:
        lines += ["", "[noise]"]
        lines += [f"{name} = {_quantity(value, unit, 2)}" for name, (value, unit) in noises.items()]
    return "\n".join(lines) + "\n"


def logged_columns(
    rng: np.random.Generator,
    rig: Rig,
    record: Record,
    set_: Settings,
    texture_seed: int,
) -> tuple[dict[str, tuple[str, np.ndarray]], list[str], dict[str, tuple[float, str]]]:
    """SI columns with their noise, the measured ones, and each one's noise."""
    rows, how, kind = rig.plan.rows, rig.how, rig.plan.rig
    time = np.arange(rows) * SAMPLE
    if kind == "actuator-tip":
        assert record.voltage is not None
        x, y = run_tip(rig, record, set_)
        s = rig.noise_position
        x, y = (rounded(channel + noise(rng, rows, s, how), set_.sensor.step) for channel in (x, y))
        columns = {"time": ("s", time), "voltage_1": ("V", record.voltage[0]), "voltage_2": ("V", record.voltage[1])}
        columns |= {"tip_x": ("m", x), "tip_y": ("m", y)}
        return columns, ["tip_x", "tip_y"], {"tip_x": (s, "m"), "tip_y": (s, "m")}
    assert record.motion is not None
    run = run_axis(rig, record, set_, texture_seed)
    r = rig.radius or 1.0
    length, torque = ("rad", "N*m") if rig.radius else ("m", "N")
    force, position = run.force, run.position
    if on_position(rig):
        position = sense(position, set_.sensor, 0.02)
    else:
        force = sense(force, set_.sensor, 3.0 * rig.numbers["coulomb"])
    force = force + noise(rng, rows, rig.noise_force, how)
    if rig.noise_position:
        position = position + noise(rng, rows, rig.noise_position, how)
    if on_position(rig):
        position = rounded(position, set_.sensor.step)
    else:
        force = rounded(force, set_.sensor.step)
    columns: dict[str, tuple[str, np.ndarray]] = {"time": ("s", time)}
    noises = {FORCE[kind]: (rig.noise_force * r, torque)}
    if kind == "velocity-drive":
        columns["position"] = (length, position / r)
        columns["velocity"] = (length + "/s", run.velocity / r)
        if how.few_columns:
            del columns["position" if how.velocity_only else "velocity"]
        columns["friction_force"] = (torque, force * r)
        measured = ["friction_force"]
    elif kind == "spring-pull":
        columns["pull_position"] = (length, record.motion.guide / r)
        columns["position"] = (length, position / r)
        noises = {"position": (rig.noise_position / r, length), **noises}
        measured = ["position", "spring_force"]
        columns["spring_force"] = (torque, force * r)
        if how.few_columns:
            del columns["position"], noises["position"]
            measured = ["spring_force"]
    else:
        columns["drive_force"] = (torque, force * r)
        columns["position"] = (length, position / r)
        noises = {"position": (rig.noise_position / r, length), **noises}
        measured = ["position", "drive_force"]
        if how.few_columns:
            sigma = 2e-4 / r
            columns["velocity"] = (length + "/s", run.velocity / r + noise(rng, rows, sigma, how))
            noises["velocity"] = (sigma, length + "/s")
            measured.append("velocity")
    values = {"normal_load": ("N", record.load, 0.02), "temperature": ("degC", record.temperature, 0.05)}
    for name in rig.channels:
        unit, signal, sigma = values[name]
        columns[name] = (unit, signal + sigma * rng.standard_normal(rows))
    return columns, measured, noises


def known_numbers(rng: np.random.Generator, rig: Rig) -> dict[str, str]:
    """What the user knows of the rig, as the file writes it."""
    kind = rig.plan.rig
    if kind == "actuator-tip":
        return {"piezo_spacing": '"46 mm"', "tip_height": '"20 mm"', "bias_voltage": '"50 V"'}
    r = rig.radius or 1.0
    known = {}
    mass, unit = rig.axis.mass * r * r, "kg*m^2" if rig.radius else "kg"
    if kind != "velocity-drive":
        if rig.how.mass == "uncertain":
            spread = 0.005 * mass
            known["mass"] = f'"{mass + spread * rng.standard_normal():.6g} +- {spread:.3g} {unit}"'
        elif rig.how.mass == "known":
            known["mass"] = _quantity(mass, unit)
    if kind == "spring-pull":
        known["pull_stiffness"] = _quantity(rig.axis.pull_stiffness * r * r, "N*m/rad" if rig.radius else "N/m")
    return known
