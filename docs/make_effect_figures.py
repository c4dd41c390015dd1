"""Draw effects/NAME.svg, how each effect shows in a measurement: python docs/make_effect_figures.py [NAME...].

A friction effect is drawn for one synthetic record (an axis moved back and forth with pauses, with Coulomb and viscous
friction), against the first coordinate it declares; a signal effect as the signal before and after.
"""

from __future__ import annotations

import sys
from io import StringIO
from pathlib import Path

import matplotlib as mpl
import numpy as np

from sim.effects.catalogue import Model, compose, library
from sim.effects.effect import Axis, Effect
from stagecad.parameters.atomic import atomic_write_text

mpl.use("svg")

FOLDER = Path(__file__).parent / "effects"
SAMPLES = 1200
# Values at which an effect is clearly visible in this record; the others keep their defaults.
SHOWN = {
    "stribeck.velocity": 3e-3,
    "viscous.coefficient": 20.0,
    "quadratic_drag.coefficient": 2e3,
    "cable_spring.stiffness": 100.0,
    "magnetic_cogging.amplitude": 0.2,
    "magnetic_cogging.pitch": 2e-3,
    "gravity_torque.amplitude": 80.0,
    "constant_bias.force": 0.3,
    "direction_asymmetry.coulomb": 0.2,
    "position_dependent_friction.pitch": 3e-3,
    "dwell_strengthening.force": 0.15,
    "dwell_strengthening.memory_length": 5e-4,
    "run_in.excess": 0.5,
    "run_in.distance": 0.02,
    "load_dependent_friction.reference": 10.0,
    "temperature_dependent_friction.coefficient": -0.05,
    "temperature_dependent_friction.reference": 20.0,
    "frictional_lag.delay": 0.06,
    "backlash.gap": 2e-3,
    "bristle_damping.damping": 100.0,
    "bristle_damping.stretch": 5e-4,
    "maxwell_slip.stretch": 2e-3,
    "presliding.stretch": 2e-3,
    "free_maxwell_slip.stretch": 2e-3,
    "gain_mismatch.mismatch": 0.2,
    **{f"{name}.stiffness": 2e3 for name in ("dahl", "lugre", "lugre_undamped", "lugre_causal", "lugre_causal_as_run")},
    **{f"{name}.stiffness": 2e3 for name in ("elasto_plastic", "rate_and_state")},
    "rate_and_state.direct": 0.03,
    "rate_and_state.evolution": 0.1,
    "rate_and_state.memory_length": 2e-4,
    "drive_lag.time_constant": 0.1,
    "drive_delay.delay": 0.1,
    "sensor_lag.time_constant": 0.1,
    "sensor_delay.delay": 0.1,
    "flexible_mode.frequency": 4.0,
    "sensor_quantisation.step": 0.2,
    "sensor_nonlinearity.second_order": 0.15,
    "sensor_drift.amplitude": 0.5,
    "sensor_drift.time_constant": 2.0,
    "piezo_hysteresis.width": 0.8,
    "piezo_hysteresis.strength": 0.3,
    "piezo_creep.strength": 0.1,
}
COORDINATES = {
    "velocity": ("velocity, mm/s", lambda a: a.velocity * 1e3),
    "direction": ("velocity, mm/s", lambda a: a.velocity * 1e3),
    "acceleration": ("velocity, mm/s", lambda a: a.velocity * 1e3),
    "position": ("position, mm", lambda a: a.position * 1e3),
    "distance_since_reversal": ("position, mm", lambda a: a.position * 1e3),
    "distance_travelled": ("distance travelled, mm", lambda a: a.travelled * 1e3),
    "contact_age": ("time, s", lambda a: a.time),
    "time": ("time, s", lambda a: a.time),
    "normal_load": ("time, s (the load wanders by a third)", lambda a: a.time),
    "temperature": ("time, s (the temperature wanders by 5 K)", lambda a: a.time),
}


def record() -> Axis:
    """An axis moved to and fro over 10 mm, each cycle faster, with a pause at each end; its load and warmth wander."""
    pieces = []
    for half in range(8):
        sign = 1.0 if half % 2 == 0 else -1.0
        phase = np.linspace(0.0, np.pi, 120)
        pieces += [-5e-3 * sign * np.cos(phase), np.full(30, 5e-3 * sign)]
    x = np.concatenate(pieces)[:SAMPLES]
    t = np.linspace(0.0, 10.0, x.size)
    v = np.gradient(x, t)
    v[np.abs(v) < 1e-9] = 0.0
    moved = np.concatenate([[0.0], np.cumsum(np.abs(np.diff(x)))])
    direction = np.where(v >= 0.0, 1.0, -1.0)
    load, warm = 10.0 + 3.0 * np.sin(0.9 * t), 20.0 + 5.0 * np.sin(0.5 * t)
    return Axis(t, x, v, np.gradient(v, t), load, warm, np.zeros_like(t), np.zeros_like(t), moved, direction)


def friction_along(model: Model, axis: Axis) -> np.ndarray:
    """Friction force along a record, N, (n,), after the effects with a memory."""
    force = np.asarray(model.other_force(axis), dtype=float)
    for effect, p in zip(model.effects, model.values, strict=True):
        if effect.memory is not None:
            axis = effect.memory(axis, p)
    for effect, p in zip(model.effects, model.values, strict=True):
        if effect.friction_state is not None:
            level = np.broadcast_to(np.asarray(model.level(axis), dtype=float), axis.velocity.shape)
            force = force + effect.friction_state.along_record(axis.position, axis.velocity, axis.time, level, p)
    return force


def _model(names: list[str]) -> Model:
    known = {key: value for key, value in SHOWN.items() if key.rpartition(".")[0] in names}
    return compose(names, known)


def _signal(effect: Effect) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    t = np.linspace(0.0, 4.0, 800)
    if effect.name == "piezo_hysteresis":
        u = np.sin(2.0 * np.pi * t / 2.0) * (1.0 - 0.12 * t)
    elif effect.name in ("piezo_creep", "flexible_mode"):
        u = np.where((t > 0.5) & (t < 2.5), 1.0, 0.0)
    else:
        u = np.sin(2.0 * np.pi * t / 2.0)
    known = {key.rpartition(".")[2]: value for key, value in SHOWN.items() if key.rpartition(".")[0] == effect.name}
    assert effect.signal is not None
    return t, u, np.asarray(effect.signal(u, t[1], effect.values(**known)))


def _tip_path(mismatch: float) -> tuple[np.ndarray, np.ndarray]:
    """Path of a tip on two piezos a quarter of a period apart, of the piezos' stroke: h/D of the thesis's actuator."""
    angle = np.linspace(0.0, 2.0 * np.pi, 400)
    d1, d2 = np.sin(angle), (1.0 + mismatch) * np.sin(angle - np.pi / 2.0)
    return -20.0 / 46.0 * (d2 - d1), (d1 + d2) / 2.0


def figure(effect: Effect) -> str:
    """The figure of one effect as SVG."""
    from matplotlib.figure import Figure

    mpl.rcParams["svg.hashsalt"] = "stagecad"
    drawn = Figure(figsize=(4.6, 2.6), layout="constrained")
    plot = drawn.add_subplot()
    if effect.name == "gain_mismatch":
        plot.plot(*_tip_path(0.0), color="0.7", lw=1.0, label="without")
        plot.plot(*_tip_path(SHOWN["gain_mismatch.mismatch"]), color="C3", lw=1.2, label=effect.name)
        plot.set(xlabel="tip_x, of the stroke", ylabel="tip_y, of the stroke", aspect="equal")
    elif effect.signal is not None:
        t, u, y = _signal(effect)
        if effect.name == "piezo_hysteresis":
            plot.plot(u, u, color="0.7", lw=1.0, label="without")
            plot.plot(u, y, color="C3", lw=1.2, label=effect.name)
            plot.set(xlabel="voltage, of the range", ylabel="stretch, of the range")
        else:
            plot.plot(t, u, color="0.7", lw=1.0, label="without")
            plot.plot(t, y, color="C3", lw=1.2, label=effect.name)
            plot.set(xlabel="time, s", ylabel="signal, of its size")
    else:
        axis = record()
        base = {"viscous": ["coulomb"], "coulomb": ["viscous"]}.get(effect.name, ["coulomb", "viscous"])
        if effect.name == "frictional_lag":
            base.append("stribeck")
        names = [effect.name, "viscous"] if effect.friction_state is not None else [*base, effect.name]
        label, along = COORDINATES[effect.coordinates[0] if effect.coordinates else "velocity"]
        plot.plot(along(axis), friction_along(_model(base), axis), color="0.7", lw=1.0, label="without")
        plot.plot(along(axis), friction_along(_model(names), axis), color="C3", lw=1.0, label=effect.name)
        plot.set(xlabel=label, ylabel="friction, N")
    # Above the plot: within it a curve that goes to and fro leaves no place free.
    drawn.legend(loc="outside upper center", ncols=2, fontsize=8, frameon=False)
    plot.spines[["top", "right"]].set_visible(False)
    text = StringIO()
    drawn.savefig(text, format="svg", metadata={"Date": None, "Creator": None})
    return text.getvalue()


if __name__ == "__main__":
    FOLDER.mkdir(exist_ok=True)
    for each in library().values():
        if len(sys.argv) == 1 or each.name in sys.argv[1:]:
            atomic_write_text(FOLDER / f"{each.name}.svg", figure(each))
