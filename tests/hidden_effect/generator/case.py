"""One experiment with something hidden in it: planned, simulated, brought to its size, spoilt, written, and its key."""

from __future__ import annotations

import json
from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np
import pandas as pd

from .axis import SAMPLE, SERVO, SPRING, VELOCITY, AxisRun, AxisTruth, simulate_axis
from .hidden import HIDDEN, Draw, Hidden
from .motions import Motion, pull_motion, servo_motion, velocity_motion, voltages
from .nuisance import Nuisance, as_logged, channel_load, channel_temperature, draw_nuisance, draw_units, noise
from .sensors import SensorTruth, rounded, same_on, sense
from .tip import BIAS, HEIGHT, SPACING, TipTruth, simulate_tip
from .visible import base_columns, filled, left_over, rival_columns, steady

LEVELS = {"strong": (10.0, 60.0), "moderate": (3.0, 10.0), "weak": (1.0, 3.0)}
MODES = {"velocity-drive": VELOCITY, "spring-pull": SPRING, "force-drive": SERVO}
FORCE = {"velocity-drive": "friction_force", "spring-pull": "spring_force", "force-drive": "drive_force"}
LATE = {"sensor_lag", "sensor_delay", "drive_lag", "drive_delay"}
_TIP_SPAN = 2.5e-6
_REACH = 0.024


@dataclass(frozen=True)
class Plan:
    """What to make. `effects` is empty for nothing hidden, one name, or two; `level` a key of LEVELS.

    With `same_form` a hidden Stribeck curve is a Gaussian, as a model library writes it, in place of a Lorentzian.
    """

    rig: str
    effects: tuple[str, ...] = ()
    level: str = "strong"
    nuisance: str = "plain"
    hard: bool = False
    idle: bool | None = None
    rows: int = 20000
    same_form: bool = False


@dataclass(frozen=True)
class Case:
    """A finished experiment: two tables, the text of experiment.toml, and the entry of the key."""

    fit: pd.DataFrame
    validate: pd.DataFrame
    toml: str
    key: dict

    def write(self, folder: Path) -> None:
        """experiment.toml, fit.csv and validate.csv in `folder`, which is made."""
        folder.mkdir(parents=True, exist_ok=True)
        self.fit.to_csv(folder / "fit.csv", index=False, float_format="%.9g")
        self.validate.to_csv(folder / "validate.csv", index=False, float_format="%.9g")
        (folder / "experiment.toml").write_text(self.toml, encoding="utf-8")


@dataclass(frozen=True)
class _Rig:
    plan: Plan
    base: tuple[str, ...]
    numbers: dict
    how: Nuisance
    radius: float | None
    axis: AxisTruth = field(default_factory=AxisTruth)
    tip: TipTruth = field(default_factory=TipTruth)
    noise_force: float = 0.0
    noise_position: float = 0.0
    channels: tuple[str, ...] = ()
    channel_seed: int = 0


@dataclass(frozen=True)
class _Record:
    """What is given to a record before the effect acts: motion, channels, and the random events of its own."""

    motion: Motion | None
    voltage: tuple[np.ndarray, np.ndarray] | None
    load: np.ndarray
    temperature: np.ndarray
    seed: int


def _draw_base(rng: np.random.Generator, plan: Plan, hidden: list[Hidden]) -> tuple[str, ...]:
    if plan.rig == "actuator-tip":
        return ()
    for entry in hidden:
        if entry.base is not None:
            base = entry.base
            if entry.name == "quadratic_drag" and rng.random() < 0.3:
                base = (*base, "stribeck")
            names = {other.name for other in hidden}
            return tuple(name for name in base if name not in names)
    u = rng.random()
    if u < 0.12:
        return ("coulomb",)
    return ("coulomb", "viscous") if u < 0.75 else ("coulomb", "viscous", "stribeck")


def _draw_rig(rng: np.random.Generator, plan: Plan) -> _Rig:
    hidden = [HIDDEN[name] for name in plan.effects]
    base = _draw_base(rng, plan, hidden)
    how = draw_nuisance(rng, plan.rig, plan.nuisance, hard=plan.hard)
    coulomb = float(np.exp(rng.uniform(np.log(0.6), np.log(4.0))))
    rotary = plan.rig != "actuator-tip" and (
        any(entry.rotary_only for entry in hidden) or (plan.hard and rng.random() < 0.35)
    )
    radius = float(rng.uniform(0.016, 0.03)) if rotary else None
    names = set(plan.effects)
    axis = AxisTruth(
        mass=float(np.exp(rng.uniform(np.log(0.45), np.log(2.5)))),
        pull_stiffness=float(np.exp(rng.uniform(np.log(1500), np.log(5500)))),
        coulomb=coulomb,
        viscous=float(np.exp(rng.uniform(np.log(3), np.log(20)))) if "viscous" in base else 0.0,
        stribeck=coulomb * float(rng.uniform(0.15, 0.4)) if "stribeck" in base else 0.0,
        stribeck_velocity=float(np.exp(rng.uniform(np.log(1.5e-3), np.log(8e-3)))),
        gravity_radius=radius or 0.023,
        presliding=float(np.exp(rng.uniform(np.log(1e-5), np.log(8e-5)))) if "presliding" in base else 0.0,
    )
    if "coulomb" in names:
        axis = axis._replace(coulomb=0.0)
    force = coulomb * float(np.exp(rng.uniform(np.log(0.0012), np.log(0.006))))
    position = {"spring-pull": 2e-7, "force-drive": 5e-7}.get(plan.rig, 0.0)
    tip = TipTruth(
        gain=float(rng.uniform(3.5e-8, 5.5e-8)),
        offset_x=float(rng.normal(0, 2e-7)),
        offset_y=float(rng.normal(0, 2e-7)),
    )
    if plan.rig == "actuator-tip":
        position = float(rng.uniform(5e-9, 1.3e-8))
    needed = [entry.needs for entry in hidden if entry.needs]
    idle = plan.idle
    channels = []
    for name, need in (("normal_load", "load"), ("temperature", "temperature")):
        wanted = idle if idle is not None else bool(rng.random() < 0.42)
        if need in needed or (wanted and plan.rig != "actuator-tip"):
            channels.append(name)
    floor = {"velocity-drive": force, "spring-pull": force}.get(plan.rig, position)
    if how.few_columns and (names & {"backlash", "sensor_lag", "sensor_delay", "sensor_quantisation"}):
        how = replace(how, few_columns=False)
    if plan.rig == "force-drive" and any(key.startswith("sensor_") for key in names):
        how = replace(how, few_columns=False)
    return _Rig(
        plan, base, {"coulomb": coulomb, "noise": floor}, how, radius, axis, tip, force, position, tuple(channels)
    )


def _draw_record(rng: np.random.Generator, rig: _Rig) -> _Record:
    rows = rig.plan.rows
    load, warmth = channel_load(rng, rows), channel_temperature(rng, rows)
    seed = int(rng.integers(2**31))
    if rig.plan.rig == "actuator-tip":
        return _Record(None, voltages(rng, rows, BIAS), load, warmth, seed)
    if rig.plan.rig == "velocity-drive":
        return _Record(velocity_motion(rng, rows), None, load, warmth, seed)
    if rig.plan.rig == "spring-pull":
        return _Record(pull_motion(rng, rows), None, load, warmth, seed)
    for _ in range(12):
        motion = servo_motion(rng, rows, max(rig.axis.coulomb, 0.4 * rig.numbers["coulomb"]), rig.axis.mass)
        record = _Record(motion, None, load, warmth, seed)
        if np.abs(_run_axis(rig, record, _settings([], []), 0).position).max() < _REACH:
            return record
    raise ValueError("no motion of the servo stays within the travel")


@dataclass(frozen=True)
class _Settings:
    """All drawn effects at their strengths, sorted by what they change."""

    law: dict[str, float]
    sensor: SensorTruth
    time: dict[str, float]


def _settings(draws: list[Draw], strengths: list[float]) -> _Settings:
    law: dict[str, float] = {}
    sensor: dict[str, float] = {}
    time: dict[str, float] = {}
    for draw, strength in zip(draws, strengths):
        for source, factor in ((draw.scaled, strength), (draw.fixed, 1.0)):
            for key, value in source.items():
                kind, _, name = key.rpartition(".")
                {"": law, "sensor": sensor, "time": time}[kind][name] = value * factor
    return _Settings(law, SensorTruth(**sensor), time)


def _in_time(rng: np.random.Generator, rows: int, time: dict[str, float]) -> tuple[np.ndarray, np.ndarray]:
    """A factor on the friction level and a push (in units of the Coulomb force), both (rows,), for unlisted events."""
    t = np.arange(rows) * SAMPLE
    factor, push = np.ones(rows), np.zeros(rows)
    start = rng.uniform(0.25, 0.75) * t[-1]
    sign = rng.choice([-1.0, 1.0])
    if "level" in time:
        factor += time["level"] * (t > start)
    if "step" in time:
        push += sign * time["step"] * (t > start)
    if "bump" in time:
        push += sign * time["bump"] * np.exp(-(((t - start) / rng.uniform(0.4, 1.6)) ** 2))
    if "vibration" in time:
        f = np.exp(rng.uniform(np.log(6), np.log(45)))
        swell = 1.0 + 0.4 * np.sin(2 * np.pi * rng.uniform(0.05, 0.3) * t + rng.uniform(0, 6.28))
        push += time["vibration"] * swell * np.sin(2 * np.pi * f * t + rng.uniform(0, 6.28))
    if "wander" in time:
        spectrum = np.fft.rfftfreq(rows, SAMPLE)
        shape = np.where(spectrum > 0.0, 1.0 / (1.0 + (spectrum / 0.25) ** 4), 0.0)
        wave = np.fft.irfft(shape * (rng.standard_normal(shape.size) + 1j * rng.standard_normal(shape.size)), rows)
        push += time["wander"] * wave / max(wave.std(), 1e-12)
    if "sticking" in time:
        for _ in range(int(rng.integers(10, 25))):
            begin, length = rng.uniform(0.3, t[-1]), np.exp(rng.uniform(np.log(0.03), np.log(0.3)))
            factor += time["sticking"] * rng.uniform(0.5, 1.0) * ((t > begin) & (t < begin + length))
    return factor, push


def _texture(seed: int) -> tuple[np.ndarray, np.ndarray]:
    rng = np.random.default_rng(seed)
    count = int(rng.integers(2, 6))
    pitches = 6e-3 * np.cumprod(rng.uniform(0.45, 0.75, count))
    return pitches, rng.uniform(0, 6.28, count)


def _run_axis(rig: _Rig, record: _Record, set_: _Settings, texture_seed: int) -> AxisRun:
    assert record.motion is not None
    rows = rig.plan.rows
    factor, push = _in_time(np.random.default_rng(record.seed), rows, set_.time)
    pitches, phases = _texture(texture_seed)
    return simulate_axis(
        MODES[rig.plan.rig],
        rig.axis._replace(**set_.law),
        record.motion,
        load=record.load,
        temperature=record.temperature,
        factor=factor,
        extra=push * rig.numbers["coulomb"],
        pitches=pitches,
        phases=phases,
    )


def _run_tip(rig: _Rig, record: _Record, set_: _Settings) -> tuple[np.ndarray, np.ndarray]:
    assert record.voltage is not None
    x, y = simulate_tip(*record.voltage, rig.tip._replace(**set_.law))
    rng = np.random.default_rng(record.seed)
    _, push = _in_time(rng, rig.plan.rows, set_.time)
    along = rng.uniform(0.4, 1.0, 2) * rng.choice([-1.0, 1.0], 2)
    span = 0.2 * _TIP_SPAN
    return (
        sense(x + along[0] * span * push, set_.sensor, _TIP_SPAN),
        sense(y + along[1] * span * push, set_.sensor, _TIP_SPAN),
    )


def _on_position(rig: _Rig) -> bool:
    """Whether the sensor effects of this rig act on the position."""
    return rig.plan.rig == "force-drive"


def _axis_left(
    rig: _Rig, record: _Record, run: AxisRun, set_: _Settings, texture_seed: int
) -> tuple[float, dict[str, float]]:
    """Left over noise, and what each possible rival would still leave."""
    sensor = set_.sensor
    force = run.force
    position, velocity, acceleration = run.position, run.velocity, run.acceleration
    if _on_position(rig):
        position, velocity, acceleration = (same_on(s, sensor) for s in (position, velocity, acceleration))
    else:
        force = sense(force, sensor, 3.0 * rig.numbers["coulomb"])
    inertial = 0.0 if rig.plan.rig == "velocity-drive" else rig.axis.mass
    # A bristled axis creeps where a rigid one sticks: leave that to its deflection, below.
    creeping = np.where(np.abs(velocity) > 1e-4, np.sign(velocity), 0.0)
    direction = creeping if set_.law.get("presliding") else run.direction
    rests = rig.plan.rig == "velocity-drive"
    keep = steady(direction if not rests else run.direction, rests=rests)
    d = filled(run.direction)
    base = base_columns(
        rig.base,
        d,
        velocity,
        rig.axis.stribeck_velocity,
        acceleration if rig.how.mass == "absent" and rig.plan.rig == "force-drive" else None,
    )
    if "presliding" in rig.base:
        plain = _run_axis(rig, record, _settings([], []), texture_seed).force
        base[0] = plain - rig.axis.viscous * run.velocity
    apparent = force - inertial * acceleration
    left = left_over(apparent, base, keep) / rig.noise_force
    also = {}
    if left > 0.3:
        channels = {"normal_load": record.load, "temperature": record.temperature}
        rivals = rival_columns(
            d, velocity, position, {name: channels[name] for name in rig.channels}, rig.radius, force
        )
        for name, shapes in rivals.items():
            also[name] = min(left_over(apparent, base + shape, keep) for shape in shapes) / rig.noise_force
    if rig.plan.rig == "spring-pull" and record.motion is not None:
        k = rig.axis.pull_stiffness
        stretch = left_over(force - k * (record.motion.guide - position), [], np.ones(force.size, bool))
        left = max(left, stretch / float(np.hypot(rig.noise_force, k * rig.noise_position)))
    if set_.law.get("presliding") and rig.noise_position > 0.0:
        left = max(left, float(run.deflection[np.abs(run.velocity) < 1e-3].std()) / rig.noise_position)
    if sensor.step > 0.0:
        signal, sigma = (run.position, rig.noise_position) if _on_position(rig) else (force, rig.noise_force)
        left = max(left, float(np.std(rounded(signal, sensor.step) - signal)) / sigma)
    return left, also


def _tip_left(rig: _Rig, record: _Record, out: tuple[np.ndarray, np.ndarray], set_: _Settings) -> tuple[float, dict]:
    assert record.voltage is not None
    one, two = record.voltage[0] - BIAS, record.voltage[1] - BIAS
    n = one.size
    zero, ones = np.zeros(n), np.ones(n)
    target = np.concatenate(out)
    base = [
        np.concatenate([-HEIGHT * (two - one) / SPACING, 0.5 * (one + two)]) * rig.tip.gain,
        np.concatenate([ones, zero]) * 1e-6,
        np.concatenate([zero, ones]) * 1e-6,
    ]
    keep = np.ones(2 * n, bool)
    keep[[0, n]] = False
    left = left_over(target, base, keep) / rig.noise_position
    if set_.sensor.step > 0.0:
        rounding = np.std(rounded(out[0], set_.sensor.step) - out[0])
        left = max(left, float(rounding) / rig.noise_position)
    rate = np.concatenate([np.gradient(channel, SAMPLE) for channel in out])
    also = {"lag_or_delay": left_over(target, [*base, rate], keep) / rig.noise_position} if left > 0.3 else {}
    return left, also


def _left(rig: _Rig, record: _Record, set_: _Settings, texture_seed: int) -> tuple[float, dict[str, float]]:
    if rig.plan.rig == "actuator-tip":
        return _tip_left(rig, record, _run_tip(rig, record, set_), set_)
    return _axis_left(rig, record, _run_axis(rig, record, set_, texture_seed), set_, texture_seed)


def _to_size(
    rng: np.random.Generator, rig: _Rig, record: _Record, draw: Draw, level: str, texture_seed: int
) -> tuple[float, float]:
    """Strength that brings one effect into its level, and what is then visible; the strength is 0 if none does."""
    low, high = LEVELS[level]
    target = float(np.exp(rng.uniform(np.log(low * 1.1), np.log(high * 0.9))))
    floor, ceiling = draw.least, draw.limit
    strength = min(1.0, draw.limit)
    for _ in range(9):
        left, _ = _left(rig, record, _settings([draw], [strength]), texture_seed)
        if low <= left <= high and abs(np.log(left / target)) < 0.5:
            return strength, left
        if strength <= draw.least and left >= target:
            return strength, left
        if left < target:
            floor = strength
        else:
            ceiling = strength
        guess = strength * float(np.clip(target / max(left, 1e-9), 0.05, 20.0))
        if not floor < guess < ceiling:
            guess = float(np.sqrt(max(floor, 1e-4 * ceiling) * ceiling)) if ceiling < draw.limit else ceiling
        if draw.least > 0.0 and guess < 1.2 * draw.least:
            guess = draw.least
        if abs(guess - strength) < 1e-6 * strength:
            break
        strength = guess
    left, _ = _left(rig, record, _settings([draw], [strength]), texture_seed)
    return (strength, left) if left >= low else (0.0, left)


def _accept(rig: _Rig, hidden: list[Hidden], visible: float, also: dict[str, float]) -> list[str]:
    if not hidden:
        return ["adequate"]
    right = {name for entry in hidden for name in entry.accept}
    # Without any Coulomb friction in the base, every effect that scales with it would pass: the plain name is right.
    if len(hidden) == 1 and not hidden[0].unlisted and hidden[0].name != "coulomb":
        right |= {name for name, left in also.items() if left < 0.3 and name not in rig.base and left < 0.2 * visible}
        if "lag_or_delay" in right:
            right |= LATE
    if not LATE & {entry.name for entry in hidden}:
        right -= LATE
    right -= {"lag_or_delay"}
    if rig.plan.rig == "velocity-drive":
        right -= {"drive_lag", "drive_delay"}
    return sorted(right)


def _quantity(value: float, unit: str, digits: int = 6) -> str:
    return f'"{value:.{digits}g} {unit}"'


def _toml(rig: _Rig, known: dict[str, str], noises: dict[str, tuple[float, str]]) -> str:
    lines = ["schema = 1", "", "[rig]", f'kind = "{rig.plan.rig}"', "", "[rig.known]"]
    lines += [f"{name} = {value}" for name, value in known.items()]
    lines += ["", "[model]", f"effects = {json.dumps(list(rig.base))}"]
    for role in ("fit", "validate"):
        lines += ["", "[[record]]", f'file = "{role}.csv"', f'role = "{role}"']
    if rig.how.noise_given:
        lines += ["", "[noise]"]
        lines += [f"{name} = {_quantity(value, unit, 2)}" for name, (value, unit) in noises.items()]
    return "\n".join(lines) + "\n"


def _columns(
    rng: np.random.Generator,
    rig: _Rig,
    record: _Record,
    set_: _Settings,
    texture_seed: int,
) -> tuple[dict[str, tuple[str, np.ndarray]], list[str], dict[str, tuple[float, str]]]:
    """SI columns with their noise, the measured ones, and each one's noise."""
    rows, how, kind = rig.plan.rows, rig.how, rig.plan.rig
    time = np.arange(rows) * SAMPLE
    if kind == "actuator-tip":
        assert record.voltage is not None
        x, y = _run_tip(rig, record, set_)
        s = rig.noise_position
        x, y = (rounded(channel + noise(rng, rows, s, how), set_.sensor.step) for channel in (x, y))
        columns = {"time": ("s", time), "voltage_1": ("V", record.voltage[0]), "voltage_2": ("V", record.voltage[1])}
        columns |= {"tip_x": ("m", x), "tip_y": ("m", y)}
        return columns, ["tip_x", "tip_y"], {"tip_x": (s, "m"), "tip_y": (s, "m")}
    assert record.motion is not None
    run = _run_axis(rig, record, set_, texture_seed)
    r = rig.radius or 1.0
    length, torque = ("rad", "N*m") if rig.radius else ("m", "N")
    force, position = run.force, run.position
    if _on_position(rig):
        position = sense(position, set_.sensor, 0.02)
    else:
        force = sense(force, set_.sensor, 3.0 * rig.numbers["coulomb"])
    force = force + noise(rng, rows, rig.noise_force, how)
    if rig.noise_position:
        position = position + noise(rng, rows, rig.noise_position, how)
    if _on_position(rig):
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


def _known(rng: np.random.Generator, rig: _Rig) -> dict[str, str]:
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


def make_case(plan: Plan, rng: np.random.Generator, tries: int = 12) -> Case:
    """Make one case; the same plan and generator state give the same case.

    Raises ValueError when the effect cannot be brought to the level on this rig in `tries` draws.
    """
    hidden = [HIDDEN[name] for name in plan.effects]
    for _ in range(tries):
        rig = _draw_rig(rng, plan)
        fit, validate = _draw_record(rng, rig), _draw_record(rng, rig)
        texture_seed = int(rng.integers(2**31))
        draws = [entry.draw(rng, rig.numbers) for entry in hidden]
        if plan.same_form:
            draws = [replace(d, fixed={k: v for k, v in d.fixed.items() if k != "stribeck_lorentzian"}) for d in draws]
        strengths: list[float] = []
        for draw in draws:
            strength, _ = _to_size(rng, rig, fit, draw, plan.level, texture_seed)
            strengths.append(strength)
        if all(strengths):
            break
    else:
        raise ValueError(f"{'+'.join(plan.effects)} cannot be made {plan.level} on {plan.rig}")
    set_ = _settings(draws, strengths)
    if plan.rig == "force-drive" and any(
        np.abs(_run_axis(rig, record, set_, texture_seed).position).max() > 1.5 * _REACH for record in (fit, validate)
    ):
        raise ValueError(f"{'+'.join(plan.effects)} drives the axis out of its travel")
    visible, also = _left(rig, fit, set_, texture_seed)
    tables = []
    units: dict[str, tuple[str, float]] | None = None
    noises: dict[str, tuple[float, str]] = {}
    for record in (fit, validate):
        columns, measured, noises = _columns(rng, rig, record, set_, texture_seed)
        if units is None:
            units = draw_units(rng, {name: unit for name, (unit, _) in columns.items()}, rig.how)
        tables.append(as_logged(rng, columns, measured, rig.how, units))
    size = plan.level
    if len(hidden) == 1:
        size = next((name for name, (low, _) in LEVELS.items() if visible >= low), "faint")
    where = sorted({name for entry in hidden for name in entry.where})
    key = {
        "rig": plan.rig,
        "base": list(rig.base),
        "effect": "+".join(plan.effects) or "none",
        "accept": _accept(rig, hidden, visible, also),
        "size": size,
        "visible": visible,
        "strength": strengths[0] if len(strengths) == 1 else strengths,
        "nuisance": plan.nuisance,
        "hard": plan.hard,
        "rotary": rig.radius is not None,
        "idle": list(rig.channels),
        "nuisances": rig.how.__dict__ | {},
        "truth": {**rig.axis._replace(**set_.law)._asdict()}
        if plan.rig != "actuator-tip"
        else {**rig.tip._replace(**set_.law)._asdict()},
        "sensor": set_.sensor._asdict(),
        "rivals_left": {name: round(left, 3) for name, left in also.items()},
    }
    if where:
        key["where"] = where
    return Case(tables[0], tables[1], _toml(rig, _known(rng, rig), noises), key)
