"""Cases: what may be hidden in a driven stage, the motions that show it, and the experiment as a user writes it."""

from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from .truth import BIAS, HEIGHT, SPACING, Truth, motion
from .voltages import MOTIONS

SAMPLE = 5e-4
NOISE = 2e-9
PADS_LOAD = 30.0

Change = dict[str, float]
Draw = Callable[[np.random.Generator], Change]


@dataclass(frozen=True)
class Hidden:
    """Something to hide.

    Args:
        draw: values of the truth, drawn; keys with `sensor.` and `time.` are of sensor and record.
        accept: every right name; none where nothing is hidden, `unexplained` where no library has it.
        motions: that show it.
        effects: of the model as the user states it.
        given: of the truth, what the rig does anyway.
    """

    draw: Draw
    accept: tuple[str, ...]
    motions: tuple[str, ...] = ("lean", "lift", "walk")
    effects: tuple[str, ...] = ("coulomb",)
    given: Change = field(default_factory=dict)


def _between(low: float, high: float) -> Callable[[np.random.Generator], float]:
    return lambda r: float(np.exp(r.uniform(np.log(low), np.log(high))))


def _sign(r: np.random.Generator) -> float:
    return float(r.choice([-1.0, 1.0]))


AT_ONE_PLACE = ("lean", "lift")
SLIPS = ("coulomb", "contact.coulomb")
WALKS = ("coulomb", "contact.coulomb", "contact.load_dependent_friction")

HIDDEN: dict[str, Hidden] = {
    "nothing": Hidden(lambda r: {}, (), ("lean", "lift", "walk")),
    "nothing_slipping": Hidden(lambda r: {}, (), ("sawtooth",), SLIPS, {"slip": 4.0}),
    "nothing_walking": Hidden(lambda r: {}, (), ("walk",), WALKS, {"slip": 5.0, "load_exponent": 1.0}),
    "piezo_hysteresis": Hidden(
        lambda r: {"hysteresis": r.uniform(0.08, 0.3), "hysteresis_width": r.uniform(6, 30)}, ("piezo_hysteresis",)
    ),
    "piezo_creep": Hidden(
        lambda r: {"creep": _between(0.02, 0.1)(r), "creep_time": _between(0.1, 1.0)(r)}, ("piezo_creep",)
    ),
    "gain_mismatch": Hidden(lambda r: {"mismatch": _sign(r) * r.uniform(0.02, 0.12)}, ("gain_mismatch",), ("lift",)),
    "contact.coulomb": Hidden(
        lambda r: {"slip": r.uniform(2.0, 5.0)}, ("contact.coulomb", "contact.presliding"), ("sawtooth",)
    ),
    "contact.coulomb_soft": Hidden(
        lambda r: {"slip": r.uniform(1.505, 1.56)}, ("contact.coulomb", "contact.presliding"), ("lean",),
        given={"pads": 1.5},
    ),
    "contact.load_dependent_friction": Hidden(
        lambda r: {"slip": r.uniform(2.0, 5.0), "load_exponent": r.uniform(0.7, 1.0)},
        ("contact.load_dependent_friction",), ("walk", "lift"), SLIPS, {"slip": 2.2},
    ),
    "contact.stribeck": Hidden(
        lambda r: {"contact_stribeck": r.uniform(0.4, 1.2), "contact_stribeck_velocity": _between(3e-4, 1.5e-3)(r)},
        ("contact.stribeck",), ("sawtooth",), SLIPS, {"slip": 3.5},
    ),
    "contact.viscous": Hidden(
        lambda r: {"contact_viscous": _between(100.0, 400.0)(r)}, ("contact.viscous",), ("sawtooth",), SLIPS,
        {"slip": 3.5},
    ),
    "contact.direction_asymmetry": Hidden(
        lambda r: {"contact_asymmetry": _sign(r) * r.uniform(0.05, 0.2)}, ("contact.direction_asymmetry",),
        ("there_and_back",), SLIPS, {"slip": 3.5},
    ),
    "contact.presliding": Hidden(
        lambda r: {"contact_presliding": _between(3e-7, 1.5e-6)(r)}, ("contact.presliding",), ("walk", "sawtooth"),
        SLIPS, {"slip": 3.5},
    ),
    "drive_lag": Hidden(lambda r: {"drive_lag": _between(5e-4, 5e-3)(r)}, ("drive_lag", "sensor_lag")),
    "drive_delay": Hidden(lambda r: {"drive_delay": _between(5e-4, 5e-3)(r)}, ("drive_delay", "sensor_delay")),
    "sensor_lag": Hidden(lambda r: {"sensor.lag": _between(5e-4, 5e-3)(r)}, ("drive_lag", "sensor_lag")),
    "sensor_nonlinearity": Hidden(
        lambda r: {"sensor.bend": r.uniform(0.01, 0.05)}, ("sensor_nonlinearity",), AT_ONE_PLACE
    ),
    "sensor_drift": Hidden(
        lambda r: {"sensor.drift": _sign(r) * r.uniform(2e-7, 1e-6)}, ("sensor_drift",), AT_ONE_PLACE
    ),
    "sensor_quantisation": Hidden(lambda r: {"sensor.step": NOISE * _between(10, 40)(r)}, ("sensor_quantisation",)),
    "flexible_mode": Hidden(
        lambda r: {"ring_share": r.uniform(0.05, 0.3), "ring_frequency": r.uniform(40, 150)}, ("flexible_mode",)
    ),
    "viscous": Hidden(lambda r: {"viscous": _between(500.0, 3000.0)(r)}, ("viscous",), ("walk",)),
    "stribeck": Hidden(
        lambda r: {"stribeck": r.uniform(0.3, 1.0), "stribeck_velocity": _between(2e-5, 8e-5)(r)}, ("stribeck",)
    ),
    "presliding": Hidden(lambda r: {"presliding": _between(1e-7, 1e-6)(r)}, ("presliding",), ("walk",)),
    "direction_asymmetry": Hidden(
        lambda r: {"asymmetry": _sign(r) * r.uniform(0.05, 0.25)}, ("direction_asymmetry", "constant_bias")
    ),
    "position_dependent_friction": Hidden(
        lambda r: {
            "wave": r.uniform(0.08, 0.3), "wave_pitch": r.uniform(0.8e-6, 2.2e-6), "wave_phase": r.uniform(0, 6)
        },
        ("position_dependent_friction",),
    ),
    "magnetic_cogging": Hidden(
        lambda r: {
            "cogging": r.uniform(0.1, 0.4), "cogging_pitch": r.uniform(0.8e-6, 2.2e-6), "cogging_phase": r.uniform(0, 6)
        },
        ("magnetic_cogging",),
    ),
    "cable_spring": Hidden(
        lambda r: {"spring": _between(5e4, 3e5)(r)}, ("cable_spring",), ("walk",), given={"press": 1.5e-6}
    ),
    "piezo_hysteresis_of_plays": Hidden(
        lambda r: {"loop": r.uniform(0.08, 0.3), "loop_width": r.uniform(6, 30)}, ("piezo_hysteresis",)
    ),
    "bristle_damping": Hidden(
        lambda r: {"bristle_damping": _between(2e3, 8e3)(r)}, ("bristle_damping",), ("lean",),
        ("presliding",), {"presliding": 1e-6},
    ),
    "frictional_lag": Hidden(
        lambda r: {"memory": _between(5e-3, 2e-2)(r)}, ("frictional_lag",), ("lean",), ("coulomb", "stribeck"),
        {"stribeck": 1.0, "stribeck_velocity": 1e-4},
    ),
    "dwell_strengthening": Hidden(
        lambda r: {"dwell": r.uniform(0.3, 1.0), "dwell_time": _between(0.01, 0.05)(r)}, ("dwell_strengthening",),
        ("rests",),
    ),
    "load_dependent_friction": Hidden(
        lambda r: {"pads_unloaded": r.uniform(0.7, 1.0), "record.load": 1.0}, ("load_dependent_friction",),
        AT_ONE_PLACE,
    ),
    "temperature_dependent_friction": Hidden(
        lambda r: {"warmth": _between(0.02, 0.08)(r), "record.temperature": 1.0},
        ("temperature_dependent_friction",), AT_ONE_PLACE,
    ),
    "nothing_recorded_besides": Hidden(
        lambda r: {"record.load": 1.0, "record.temperature": 1.0}, (), AT_ONE_PLACE
    ),
    "run_in": Hidden(
        lambda r: {"run_in": r.uniform(0.3, 1.0), "run_in_distance": _between(2e-5, 8e-5)(r)}, ("run_in",),
        AT_ONE_PLACE,
    ),
    "quadratic_drag": Hidden(lambda r: {"quadratic": _between(2e7, 1e8)(r)}, ("quadratic_drag",), AT_ONE_PLACE),
    "constant_bias": Hidden(
        lambda r: {"bias_force": _sign(r) * r.uniform(0.1, 0.5)}, ("constant_bias", "direction_asymmetry")
    ),
    "sensor_delay": Hidden(lambda r: {"sensor.delay": _between(5e-4, 5e-3)(r)}, ("drive_delay", "sensor_delay")),
    "UNKNOWN_slew": Hidden(lambda r: {"slew": r.uniform(400.0, 800.0)}, ("unexplained",), AT_ONE_PLACE),
    "UNKNOWN_event": Hidden(
        lambda r: {"time.event": _sign(r) * r.uniform(1e-7, 4e-7)}, ("unexplained",), AT_ONE_PLACE
    ),
    "UNKNOWN_vibration": Hidden(
        lambda r: {"time.vibration": r.uniform(5e-8, 2e-7)}, ("unexplained",), AT_ONE_PLACE
    ),
    "UNKNOWN_wander": Hidden(lambda r: {"time.wander": r.uniform(5e-8, 2e-7)}, ("unexplained",), AT_ONE_PLACE),
}  # fmt: skip


def _sensed(x: np.ndarray, change: Change, random: np.random.Generator) -> np.ndarray:
    lag = change.get("sensor.lag", 0.0)
    if lag > 0.0:
        out, state = np.empty_like(x), x[0]
        for i, value in enumerate(x):
            state += (value - state) * (1.0 - np.exp(-SAMPLE / lag))
            out[i] = state
        x = out
    late = change.get("sensor.delay", 0.0) / SAMPLE
    if late > 0.0:
        rows = np.arange(x.size)
        x = np.interp(rows - late, rows, x)
    span = float(np.max(np.abs(x)))
    bend = change.get("sensor.bend", 0.0)
    x = x + bend * x * (x / span) ** 2 + change.get("sensor.drift", 0.0) * (np.arange(x.size) / x.size) ** 0.8
    t = np.arange(x.size) * SAMPLE
    if "time.event" in change:
        x = x + change["time.event"] * (t > random.uniform(0.3, 0.7) * t[-1])
    if "time.vibration" in change:
        x = x + change["time.vibration"] * np.sin(2 * np.pi * random.uniform(25, 60) * t + random.uniform(0, 6))
    if "time.wander" in change:
        steps = np.cumsum(random.standard_normal(x.size))
        x = x + change["time.wander"] * (steps - steps.mean()) / steps.std()
    x = x + NOISE * random.standard_normal(x.size)
    step = change.get("sensor.step", 0.0)
    return step * np.round(x / step) if step > 0.0 else x


def write_case(
    folder: Path, name: str, kind: str, seed: int, rows: int = 6000, known: tuple[str, ...] = ()
) -> dict[str, float]:
    """An experiment with one record to fit and one held out; what is hidden is returned.

    Args:
        folder: made, and written to.
        name: of HIDDEN.
        kind: of the motion.
        seed: of all that is drawn.
        rows: of each record.
        known: numbers the user knows besides mass and geometry: `gain`, `stiffness`, `press`.
    """
    hidden = HIDDEN[name]
    random = np.random.default_rng(seed)
    change = hidden.draw(random)
    drawn = {k: v for k, v in {**hidden.given, **change}.items() if k in Truth._fields}
    truth = Truth(
        mass=random.uniform(1.5, 4.0), gain=random.uniform(0.9e-7, 1.3e-7),
        stiffness=float(np.exp(random.uniform(15.2, 16.5))), press=random.uniform(2e-6, 5e-6),
        pads=random.uniform(0.8, 1.5),
    )._replace(**drawn)  # fmt: skip
    truth = truth._replace(damping=0.05 * 2.0 * np.sqrt(truth.stiffness * truth.mass))
    folder.mkdir(parents=True, exist_ok=True)
    entries = []
    for role in ("fit", "validate"):
        time = np.arange(rows) * SAMPLE
        first, second = MOTIONS[kind](random, time)
        columns = {"time [s]": time, "voltage_1 [V]": first, "voltage_2 [V]": second}
        load, warm = np.ones(rows), np.zeros(rows)
        if "record.load" in change:
            load = 1.0 + 0.35 * np.sin(2 * np.pi * random.uniform(1.0, 2.5) * time + random.uniform(0, 6))
            columns["normal_load [N]"] = PADS_LOAD * load
        if "record.temperature" in change:
            warm = 12.0 * (1.0 - np.exp(-time / (0.4 * time[-1])))
            columns["temperature [degC]"] = 21.0 + warm
        x = _sensed(motion(truth, SAMPLE, first, second, np.zeros(rows), load, warm), change, random)
        table = np.column_stack([*columns.values(), x])
        header = ",".join([*columns, "position [m]"])
        np.savetxt(folder / f"{role}.csv", table, delimiter=",", header=header, comments="", fmt="%.10g")
        entries.append(f'[[record]]\nfile = "{role}.csv"\nrole = "{role}"\n')
    lines = [
        f'mass = "{truth.mass} kg"', f'piezo_spacing = "{SPACING} m"', f'tip_height = "{HEIGHT} m"',
        f'bias_voltage = "{BIAS} V"',
    ]  # fmt: skip
    if "gain" in known:
        lines.append(f'piezo_gain = "{truth.gain} +- {0.05 * truth.gain} m/V"')
    if "stiffness" in known:
        lines.append(f'contact_stiffness = "{truth.stiffness} N/m"')
    if "press" in known:
        lines.append(f'press = "{truth.press} +- {0.1 * truth.press} m"')
    listed = ", ".join(f'"{effect}"' for effect in hidden.effects)
    (folder / "experiment.toml").write_text(
        'schema = 1\n\n[rig]\nkind = "friction-drive"\n\n[rig.known]\n' + "\n".join(lines)
        + f"\n\n[model]\neffects = [{listed}]\n\n" + "\n".join(entries) + f'\n[noise]\nposition = "{NOISE} m"\n'
    )  # fmt: skip
    return {**truth._asdict(), **change}
