"""How far an effect stands above the noise, the strength that brings it to its level, and which answers are right."""

import numpy as np

from .axis import SAMPLE, AxisRun
from .drawn import Record, Rig
from .hidden import Draw, Hidden
from .running import Settings, on_position, run_axis, run_tip, settings
from .sensors import rounded, same_on, sense
from .tip import BIAS, HEIGHT, SPACING
from .visible import base_columns, filled, left_over, rival_columns, steady

LEVELS = {"strong": (10.0, 60.0), "moderate": (3.0, 10.0), "weak": (1.0, 3.0)}
LATE = {"sensor_lag", "sensor_delay", "drive_lag", "drive_delay"}


def _axis_left(
    rig: Rig, record: Record, run: AxisRun, set_: Settings, texture_seed: int
) -> tuple[float, dict[str, float]]:
    """Left over noise, and what each possible rival would still leave."""
    sensor = set_.sensor
    force = run.force
    position, velocity, acceleration = run.position, run.velocity, run.acceleration
    if on_position(rig):
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
        plain = run_axis(rig, record, settings([], []), texture_seed).force
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
        signal, sigma = (run.position, rig.noise_position) if on_position(rig) else (force, rig.noise_force)
        left = max(left, float(np.std(rounded(signal, sensor.step) - signal)) / sigma)
    return left, also


def _tip_left(rig: Rig, record: Record, out: tuple[np.ndarray, np.ndarray], set_: Settings) -> tuple[float, dict]:
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


def visible_of(rig: Rig, record: Record, set_: Settings, texture_seed: int) -> tuple[float, dict[str, float]]:
    """What the base model would leave of a record, over noise, and what rivals would."""
    if rig.plan.rig == "actuator-tip":
        return _tip_left(rig, record, run_tip(rig, record, set_), set_)
    return _axis_left(rig, record, run_axis(rig, record, set_, texture_seed), set_, texture_seed)


def to_size(
    rng: np.random.Generator, rig: Rig, record: Record, draw: Draw, level: str, texture_seed: int
) -> tuple[float, float]:
    """Strength that brings one effect into its level, and what is then visible; the strength is 0 if none does."""
    low, high = LEVELS[level]
    target = float(np.exp(rng.uniform(np.log(low * 1.1), np.log(high * 0.9))))
    floor, ceiling = draw.least, draw.limit
    strength = min(1.0, draw.limit)
    for _ in range(9):
        left, _ = visible_of(rig, record, settings([draw], [strength]), texture_seed)
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
    left, _ = visible_of(rig, record, settings([draw], [strength]), texture_seed)
    return (strength, left) if left >= low else (0.0, left)


def visible_beside(
    rig: Rig, record: Record, hidden: list[Hidden], draws: list[Draw], strengths: list[float], texture_seed: int
) -> list[float]:
    """What is visible of each of two effects once the other is known: of an effect smaller than the other's steps, or
    that the other may imitate, nothing is.
    """
    found = []
    for one, other in ((0, 1), (1, 0)):
        alone = settings([draws[one]], [strengths[one]])
        left, also = visible_of(rig, record, alone, texture_seed)
        left = min(left, also.get(hidden[other].name, left))
        step = settings([draws[other]], [strengths[other]]).sensor.step
        on_motion = on_position(rig) or rig.plan.rig == "actuator-tip"
        noise = rig.noise_position if on_motion else rig.noise_force
        found.append(left / float(np.hypot(1.0, step / np.sqrt(12.0) / noise)))
    return found


def acceptable(rig: Rig, hidden: list[Hidden], visible: float, also: dict[str, float]) -> list[str]:
    """Names that count as right."""
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
