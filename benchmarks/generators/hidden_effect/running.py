"""Records of a rig with effects at given strengths: what the axis or the tip does."""

from dataclasses import dataclass

import numpy as np

from .axis import SAMPLE, SERVO, SPRING, VELOCITY, AxisRun, simulate_axis
from .drawn import Record, Rig
from .hidden import Draw
from .motions import pull_motion, servo_motion, velocity_motion, voltages
from .nuisance import channel_load, channel_temperature
from .sensors import SensorTruth, sense
from .tip import BIAS, simulate_tip

MODES = {"velocity-drive": VELOCITY, "spring-pull": SPRING, "force-drive": SERVO}
REACH = 0.024
_TIP_SPAN = 2.5e-6


@dataclass(frozen=True)
class Settings:
    """All drawn effects at their strengths, sorted by what they change."""

    law: dict[str, float]
    sensor: SensorTruth
    time: dict[str, float]


def settings(draws: list[Draw], strengths: list[float]) -> Settings:
    """Draws at their strengths, sorted by what they change."""
    law: dict[str, float] = {}
    sensor: dict[str, float] = {}
    time: dict[str, float] = {}
    for draw, strength in zip(draws, strengths):
        for source, factor in ((draw.scaled, strength), (draw.fixed, 1.0)):
            for key, value in source.items():
                kind, _, name = key.rpartition(".")
                {"": law, "sensor": sensor, "time": time}[kind][name] = value * factor
    return Settings(law, SensorTruth(**sensor), time)


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


def run_axis(rig: Rig, record: Record, set_: Settings, texture_seed: int) -> AxisRun:
    """The axis on a record."""
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


def run_tip(rig: Rig, record: Record, set_: Settings) -> tuple[np.ndarray, np.ndarray]:
    """The channels of the tip on a record, m."""
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


def on_position(rig: Rig) -> bool:
    """Whether the sensor effects of this rig act on the position."""
    return rig.plan.rig == "force-drive"


def draw_record(rng: np.random.Generator, rig: Rig) -> Record:
    """Motion or voltages of a record, its channels, and a seed for its events."""
    rows = rig.plan.rows
    load, warmth = channel_load(rng, rows), channel_temperature(rng, rows)
    seed = int(rng.integers(2**31))
    if rig.plan.rig == "actuator-tip":
        return Record(None, voltages(rng, rows, BIAS), load, warmth, seed)
    if rig.plan.rig == "velocity-drive":
        return Record(velocity_motion(rng, rows), None, load, warmth, seed)
    if rig.plan.rig == "spring-pull":
        return Record(pull_motion(rng, rows), None, load, warmth, seed)
    for _ in range(12):
        motion = servo_motion(rng, rows, max(rig.axis.coulomb, 0.4 * rig.numbers["coulomb"]), rig.axis.mass)
        record = Record(motion, None, load, warmth, seed)
        if np.abs(run_axis(rig, record, settings([], []), 0).position).max() < REACH:
            return record
    raise ValueError("no motion of the servo stays within the travel")
