"""What can be hidden in a record: for each effect the rigs, right answers, coordinates, motions, and its draw.

A draw fixes the shape of an effect on a machine; the result builds fresh laws for a strength, 1 being strong.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np

from . import friction_laws as fl
from .axis import Chain
from .machines import AXIS_RIGS, RIGS, Machine, log_uniform
from .tip import Signal, creep, delayed, relays, second_order


@dataclass
class Setting:
    """Everything hidden in one case: laws of the axis, drive chain, piezo voltages, sensors, counts over the noise."""

    laws: list[fl.Law] = field(default_factory=list)
    chain: Chain = field(default_factory=Chain)
    piezos: list[tuple[Signal, Signal]] = field(default_factory=list)
    sensors: dict[str, Signal] = field(default_factory=dict)
    counts: dict[str, float] = field(default_factory=dict)

    def join(self, other: Setting) -> None:
        """Add what another effect hides."""
        self.laws += other.laws
        self.piezos += other.piezos
        self.sensors |= other.sensors
        self.counts |= other.counts
        if other.chain != Chain():
            self.chain = other.chain


Draw = Callable[[np.random.Generator, Machine], Callable[[float], Setting]]


@dataclass(frozen=True)
class Hidden:
    """One effect.

    `motions`, `channel`, `curve` (a Stribeck curve in the base model, `curve_speed` its speed over the highest) and
    `rotary` are what it needs to show; `pairs` says whether it may occur beside another.
    """

    name: str
    rigs: tuple[str, ...]
    draw: Draw
    accept: tuple[str, ...] = ()
    where: tuple[str, ...] = ()
    motions: tuple[str, ...] = ()
    channel: str = ""
    curve: bool | None = None
    curve_speed: tuple[float, float] | None = None
    rotary: bool | None = None
    pairs: bool = False


def _wrap(make: Callable[..., Callable[[float], list[fl.Law]]]) -> Draw:
    """A draw of axis laws."""

    def draw(rng: np.random.Generator, m: Machine) -> Callable[[float], Setting]:
        build = make(rng, m)
        return lambda s: Setting(laws=build(s))

    return draw


def _stribeck(r: np.random.Generator, m: Machine) -> Callable[[float], list[fl.Law]]:
    form = str(r.choice(["lorentzian", "power_1", "power_law", "hyperbolic"]))
    speed, part = m.speed * log_uniform(r, 0.04, 0.35), r.uniform(0.3, 0.8)
    return lambda s: [fl.Curve(s * part * m.coulomb, speed, form)]


def _memory(r: np.random.Generator, m: Machine) -> Callable[[float], list[fl.Law]]:
    form, by_way = f"power_{m.curve_power:.0f}", r.random() < 0.5
    delay = r.uniform(0.5, 2.0) * m.curve_speed / m.acceleration
    way = {"way": 0.5 * delay * m.curve_speed} if by_way else {"delay": delay}
    name, size = next(iter(way.items()))
    return lambda s: [fl.Curve(m.curve, m.curve_speed, form, **{name: s * size})]


def _dwell(r: np.random.Generator, m: Machine) -> Callable[[float], list[fl.Law]]:
    way = m.reach * r.uniform(0.01, 0.05)
    part, scale = r.uniform(0.1, 0.3), 3.0 * way / m.slow
    return lambda s: [fl.Ageing(s * part * m.coulomb, min(scale, 0.3), way)]


def _asymmetry(r: np.random.Generator, m: Machine) -> Callable[[float], list[fl.Law]]:
    a, b = r.uniform(0.08, 0.2) * r.choice([-1, 1]), r.uniform(-0.4, 0.4) * m.viscous
    return lambda s: [fl.Law("factor", lambda z: 1 + s * a * z.side), fl.Law("force", lambda z: s * b * abs(z.v))]


def _position(r: np.random.Generator, m: Machine) -> Callable[[float], list[fl.Law]]:
    shape, a = fl.waves(r.uniform(0, 6), m.reach * log_uniform(r, 0.12, 0.9), r.uniform(0, 0.4)), r.uniform(0.1, 0.3)
    return lambda s: [fl.Law("factor", lambda z: 1 + s * a * shape(z.x))]


def _load(r: np.random.Generator, m: Machine) -> Callable[[float], list[fl.Law]]:
    power, part = r.uniform(0.7, 1.0), r.uniform(0.5, 1.0)
    return lambda s: [fl.Law("factor", lambda z: 1 + s * part * (max(z.load / m.load, 0.0) ** power - 1))]


def _temperature(r: np.random.Generator, m: Machine) -> Callable[[float], list[fl.Law]]:
    rate = r.uniform(0.015, 0.05)
    return lambda s: [fl.Law("factor", lambda z: float(np.exp(-s * rate * (z.temperature - m.temperature))))]


def _run_in(r: np.random.Generator, m: Machine) -> Callable[[float], list[fl.Law]]:
    a, way, power = r.uniform(0.15, 0.5), m.reach * log_uniform(r, 0.5, 3.0), r.uniform(0.8, 1.3)
    return lambda s: [fl.Law("factor", lambda z: 1 + s * a * (1 + z.travelled / way) ** -power)]


def _drag(r: np.random.Generator, m: Machine) -> Callable[[float], list[fl.Law]]:
    power, a = r.uniform(1.85, 2.15), r.uniform(0.3, 1.0) * m.coulomb
    return lambda s: [fl.Law("force", lambda z: s * a * float(np.sign(z.v)) * (abs(z.v) / m.speed) ** power)]


def _bias(r: np.random.Generator, m: Machine) -> Callable[[float], list[fl.Law]]:
    a = r.uniform(0.05, 0.25) * m.coulomb * r.choice([-1, 1])
    return lambda s: [fl.Law("force", lambda z: s * a)]


def _cable(r: np.random.Generator, m: Machine) -> Callable[[float], list[fl.Law]]:
    half, rest, a = 0.5 * m.reach, m.reach * r.uniform(-0.3, 0.3), r.uniform(0.2, 0.6) * m.coulomb
    hard = r.uniform(0.0, 0.25)

    def pull(x: float) -> float:
        return (x - rest) / half + hard * ((x - rest) / half) ** 3

    return lambda s: [fl.Law("force", lambda z: s * a * pull(z.x))]


def _cogging(r: np.random.Generator, m: Machine) -> Callable[[float], list[fl.Law]]:
    shape, a = fl.harmonics(r, m.reach * log_uniform(r, 0.06, 0.4), m.reach), r.uniform(0.1, 0.35) * m.coulomb
    return lambda s: [fl.Law("force", lambda z: s * a * shape(z.x))]


def _gravity(r: np.random.Generator, m: Machine) -> Callable[[float], list[fl.Law]]:
    start, a = r.uniform(0, 6), r.uniform(0.2, 0.6) * m.coulomb
    return lambda s: [fl.Law("force", lambda z: s * a * float(np.sin(z.x + start)))]


def _presliding(r: np.random.Generator, m: Machine) -> Callable[[float], list[fl.Law]]:
    stretch, shape = m.reach * log_uniform(r, 0.02, 0.08), r.uniform(1.1, 1.8)
    return lambda s: [fl.Bristles(s * stretch, shape=shape)]


def _mode(r: np.random.Generator, m: Machine) -> Callable[[float], list[fl.Law]]:
    own = np.sqrt(m.stiffness / m.mass) if m.stiffness else m.bandwidth
    w, damping, share = min(own * r.uniform(1.5, 4.0), 0.5 * m.rate), r.uniform(0.01, 0.05), r.uniform(0.1, 0.3)
    return lambda s: [fl.Resonator(s * share * m.mass, w, damping)]


def _backlash(r: np.random.Generator, m: Machine) -> Callable[[float], Setting]:
    gap = m.coulomb / m.stiffness * r.uniform(0.2, 0.6)
    return lambda s: Setting(chain=Chain(gap=s * gap, soft=0.1 * s * gap))


def _late(kind: str, place: str) -> Draw:
    """A lag or delay of some rows, of the drive or of a sensor; strength is its time."""

    def draw(r: np.random.Generator, m: Machine) -> Callable[[float], Setting]:
        time, damping = m.step * log_uniform(r, 1.5, 6.0), r.uniform(0.6, 1.2)
        signal = (lambda s: second_order(s * time, damping)) if kind == "lag" else (lambda s: delayed(s * time))
        if m.rig == "actuator-tip" and place == "drive":
            return lambda s: Setting(piezos=[(signal(s), signal(s))])
        if place == "drive":
            return lambda s: Setting(chain=Chain(**{kind: s * time}))
        names = {"actuator-tip": ["tip_x", "tip_y"], "velocity-drive": ["friction_force"]}.get(m.rig, ["position"])
        return lambda s: Setting(sensors={name: signal(s) for name in names})

    return draw


def _sensor_channel(r: np.random.Generator, m: Machine) -> list[str]:
    if m.rig == "actuator-tip":
        return [["tip_x"], ["tip_y"], ["tip_x", "tip_y"]][int(r.integers(3))]
    return ["friction_force" if m.rig == "velocity-drive" else "spring_force"]


def _full_scale(m: Machine, name: str) -> float:
    scale = m.gain * 50.0
    return {"tip_x": scale * 2.0 * m.height / max(m.spacing, 1e-9), "tip_y": scale}.get(name, 2.0 * m.coulomb)


def _nonlinear(r: np.random.Generator, m: Machine) -> Callable[[float], Setting]:
    names, second, third = _sensor_channel(r, m), r.uniform(0.04, 0.15) * r.choice([-1, 1]), r.uniform(-0.08, 0.08)

    def bent(s: float, full: float) -> Signal:
        return lambda u, _: u + s * full * (second * np.sin(u / full) ** 2 + third * (u / full) ** 3)

    return lambda s: Setting(sensors={name: bent(s, _full_scale(m, name)) for name in names})


def _drift(r: np.random.Generator, m: Machine) -> Callable[[float], Setting]:
    names, a, end = _sensor_channel(r, m), r.uniform(0.1, 0.3), m.rows * m.step
    first, slow, mix = end * r.uniform(0.15, 0.5), end * r.uniform(0.6, 1.5), r.uniform(0.0, 0.4)

    def drifted(u: np.ndarray, dt: float, size: float) -> np.ndarray:
        t = np.arange(u.size) * dt
        return u + size * (-(1 - mix) * np.expm1(-t / first) - mix * np.expm1(-t / slow))

    def one(size: float) -> Signal:
        return lambda u, dt: drifted(u, dt, size)

    return lambda s: Setting(sensors={name: one(s * a * _full_scale(m, name)) for name in names})


def _counts(r: np.random.Generator, m: Machine) -> Callable[[float], Setting]:
    name = str(r.choice(["position", "spring_force"])) if m.rig == "spring-pull" else "position"
    names = _sensor_channel(r, m) if m.rig in ("actuator-tip", "velocity-drive") else [name]
    return lambda s: Setting(counts=dict.fromkeys(names, s))


def _on_both(make: Callable[[np.random.Generator, Machine], Callable[[float], Signal]]) -> Draw:
    def draw(r: np.random.Generator, m: Machine) -> Callable[[float], Setting]:
        build = make(r, m)
        return lambda s: Setting(piezos=[(build(s), build(s))])

    return draw


def _hysteresis(r: np.random.Generator, m: Machine) -> Callable[[float], Signal]:
    weight = r.uniform(6.0, 14.0)
    return lambda s: relays(24, -5.0, 125.0, s * weight)


def _creep(r: np.random.Generator, m: Machine) -> Callable[[float], Signal]:
    times, a = np.geomspace(log_uniform(r, 0.01, 0.05), log_uniform(r, 5.0, 30.0), int(r.integers(3, 6))), 0.04
    weights = a / times.size * r.uniform(0.7, 1.3, times.size) * 3.0
    return lambda s: creep(s * weights, times)


def _mismatch(r: np.random.Generator, m: Machine) -> Callable[[float], Setting]:
    part = r.uniform(0.03, 0.1) * r.choice([-1, 1])
    return lambda s: Setting(piezos=[(lambda u, _: u, lambda u, _: m.bias + (1 + s * part) * (u - m.bias))])


# Effects of no library.


def _end_stop(r: np.random.Generator, m: Machine) -> Callable[[float], list[fl.Law]]:
    at, side, a = m.reach * r.uniform(0.3, 0.42), int(r.choice([-1, 1])), r.uniform(0.3, 0.8) * m.coulomb
    return lambda s: [fl.Law("force", lambda z: s * a * side * (max(side * z.x - at, 0.0) / (0.1 * m.reach)) ** 1.5)]


def _inertial_friction(r: np.random.Generator, m: Machine) -> Callable[[float], list[fl.Law]]:
    a = r.uniform(0.15, 0.4)
    return lambda s: [fl.Law("factor", lambda z: 1 + s * a * float(np.tanh(abs(z.rate) / (0.4 * m.acceleration))))]


def _slip_events(r: np.random.Generator, m: Machine) -> Callable[[float], list[fl.Law]]:
    end = m.rows * m.step
    starts, last = np.sort(r.uniform(0, end, int(r.integers(5, 14)))), end * r.uniform(0.01, 0.03)
    depth = r.uniform(0.3, 0.7)

    def share(z: fl.State) -> float:
        k = int(np.searchsorted(starts, z.t)) - 1
        return 0.0 if k < 0 or z.t > starts[k] + last else float(np.exp(-3 * (z.t - starts[k]) / last))

    return lambda s: [fl.Law("factor", lambda z: 1 - min(s * depth, 0.95) * share(z))]


def _coupled_axis(r: np.random.Generator, m: Machine) -> Callable[[float], list[fl.Law]]:
    end, a = m.rows * m.step, r.uniform(0.1, 0.3) * m.coulomb
    f, first, count = r.uniform(0.2, 1.0), r.uniform(0, 6), r.uniform(3.0, 9.0)
    f = max(f, 6.0 / end)

    def pull(t: float) -> float:
        busy = 1.0 / (1.0 + np.exp(np.clip(-8.0 * np.sin(2 * np.pi * count * t / end + first), -40, 40)))
        return float(busy * np.sin(2 * np.pi * f * t + 3.0 * np.sin(2 * np.pi * 1.7 * t / end)))

    return lambda s: [fl.Law("force", lambda z: s * a * pull(z.t))]


def _texture(r: np.random.Generator, m: Machine) -> Callable[[float], list[fl.Law]]:
    grid = np.linspace(-1.0, 1.0, 2001) * m.reach
    # The phase wanders by about a radian within one pitch (120 points of the grid).
    phase = 2 * np.pi * grid / (0.12 * m.reach) + np.cumsum(0.12 * r.standard_normal(grid.size))
    values, a = np.sin(phase) * (1 + 0.5 * np.sin(3.1 * grid / m.reach)), r.uniform(0.1, 0.3)
    return lambda s: [fl.Law("factor", lambda z: 1 + s * a * float(np.interp(z.x, grid, values)))]


def _warming(r: np.random.Generator, m: Machine) -> Callable[[float], list[fl.Law]]:
    a = m.coulomb * r.uniform(0.1, 0.3) * m.rows * m.step / 10.0
    return lambda s: [fl.Law("force", lambda z: s * a * z.warming)]


def _turn_memory(r: np.random.Generator, m: Machine) -> Callable[[float], list[fl.Law]]:
    a, wide = r.uniform(0.1, 0.3), m.reach * r.uniform(0.05, 0.15)

    def bump(way: float) -> float:
        return (way / wide) ** 2 * float(np.exp(2 - 2 * way / wide))

    return lambda s: [fl.Law("factor", lambda z: 1 + s * a * bump(z.turned))]


def _leak(r: np.random.Generator, m: Machine) -> Callable[[float], Signal]:
    time, part = log_uniform(r, 0.5, 4.0), r.uniform(0.04, 0.12)
    return lambda s: creep([-s * part], [time])


def _cross(r: np.random.Generator, m: Machine) -> Callable[[float], Signal]:
    part = r.uniform(2.0, 6.0)
    return lambda s: lambda u, _: u + s * part * np.sin(u / 4.0)


def _neighbour(r: np.random.Generator, m: Machine) -> Callable[[float], Signal]:
    f, a, w = r.uniform(1.0, 6.0), r.uniform(1.0, 3.0), r.uniform(0.2, 0.6)

    def run(u: np.ndarray, dt: float, s: float) -> np.ndarray:
        t = np.arange(u.size) * dt
        return u + s * a * np.sin(2 * np.pi * f * t + 4 * np.sin(w * t)) * (1 + np.sin(1.3 * w * t))

    return lambda s: lambda u, dt: run(u, dt, s)


SPRING, FORCE, VELOCITY, TIP = "spring-pull", "force-drive", "velocity-drive", "actuator-tip"
RESTS = ("trapezoid", "random_steps", "day_log", "staircase")
LATE_SENSOR, LATE = ("sensor_delay", "sensor_lag"), ("drive_delay", "drive_lag", "sensor_delay", "sensor_lag")
OFFSET = ("constant_bias", "direction_asymmetry")

NAMED = (
    Hidden("stribeck", AXIS_RIGS, _wrap(_stribeck), curve=False),
    Hidden(
        "presliding", AXIS_RIGS, _wrap(_presliding), motions=("loops", "chirp", "triangle", "random_steps"), curve=False
    ),
    Hidden(
        "frictional_lag",
        (VELOCITY, FORCE),
        _wrap(_memory),
        motions=("chirp", "triangle", "loops"),
        curve=True,
        curve_speed=(0.2, 0.6),
    ),
    Hidden("dwell_strengthening", AXIS_RIGS, _wrap(_dwell), motions=RESTS, curve=False),
    Hidden("direction_asymmetry", AXIS_RIGS, _wrap(_asymmetry), OFFSET, pairs=True),
    Hidden("position_dependent_friction", AXIS_RIGS, _wrap(_position), pairs=True),
    Hidden("load_dependent_friction", AXIS_RIGS, _wrap(_load), channel="normal_load", pairs=True),
    Hidden("temperature_dependent_friction", AXIS_RIGS, _wrap(_temperature), channel="temperature", pairs=True),
    Hidden("run_in", AXIS_RIGS, _wrap(_run_in), pairs=True),
    Hidden(
        "quadratic_drag", AXIS_RIGS, _wrap(_drag), motions=("triangle", "chirp", "random_steps", "day_log"), pairs=True
    ),
    Hidden("constant_bias", AXIS_RIGS, _wrap(_bias), OFFSET, pairs=True),
    Hidden("cable_spring", AXIS_RIGS, _wrap(_cable), pairs=True),
    Hidden("magnetic_cogging", AXIS_RIGS, _wrap(_cogging), pairs=True),
    Hidden("gravity_torque", AXIS_RIGS, _wrap(_gravity), rotary=True),
    Hidden("backlash", (SPRING,), _backlash),
    Hidden("flexible_mode", (SPRING, FORCE), _wrap(_mode), motions=("chirp", "random_steps", "trapezoid")),
    Hidden("drive_lag", (FORCE,), _late("lag", "drive"), LATE, motions=("chirp", "random_steps", "trapezoid")),
    Hidden("drive_delay", (FORCE,), _late("delay", "drive"), LATE, motions=("chirp", "random_steps", "trapezoid")),
    Hidden("sensor_lag", (VELOCITY,), _late("lag", "sensor"), LATE_SENSOR),
    Hidden("sensor_lag", (FORCE,), _late("lag", "sensor"), LATE, motions=("chirp", "random_steps", "trapezoid")),
    Hidden("sensor_delay", (VELOCITY,), _late("delay", "sensor"), LATE_SENSOR),
    Hidden("sensor_nonlinearity", (VELOCITY, SPRING), _nonlinear),
    Hidden("sensor_drift", (VELOCITY, SPRING), _drift),
    Hidden("sensor_quantisation", AXIS_RIGS, _counts),
    Hidden("piezo_hysteresis", (TIP,), _on_both(_hysteresis)),
    Hidden("piezo_creep", (TIP,), _on_both(_creep), motions=("steps",)),
    Hidden("gain_mismatch", (TIP,), _mismatch, pairs=True),
    Hidden("drive_lag", (TIP,), _late("lag", "drive"), LATE, pairs=True),
    Hidden("drive_delay", (TIP,), _late("delay", "drive"), LATE),
    Hidden("sensor_lag", (TIP,), _late("lag", "sensor"), LATE),
    Hidden("sensor_drift", (TIP,), _drift, pairs=True),
    Hidden("sensor_nonlinearity", (TIP,), _nonlinear),
    Hidden("sensor_quantisation", (TIP,), _counts),
)
UNLISTED = (
    Hidden("UNKNOWN_end_stop", AXIS_RIGS, _wrap(_end_stop), where=("position",)),
    Hidden("UNKNOWN_inertial_friction", AXIS_RIGS, _wrap(_inertial_friction), where=("acceleration",)),
    Hidden("UNKNOWN_slip_events", AXIS_RIGS, _wrap(_slip_events), where=("time", "frequency")),
    Hidden("UNKNOWN_coupled_axis", AXIS_RIGS, _wrap(_coupled_axis), where=("time", "frequency")),
    Hidden("UNKNOWN_texture", AXIS_RIGS, _wrap(_texture), where=("position",)),
    Hidden("UNKNOWN_warming", AXIS_RIGS, _wrap(_warming), where=("temperature", "time"), channel="temperature"),
    Hidden("UNKNOWN_turn_memory", AXIS_RIGS, _wrap(_turn_memory), where=("distance_since_reversal", "position")),
    Hidden(
        "UNKNOWN_charge_leak",
        (TIP,),
        _on_both(_leak),
        where=("time", "frequency", "contact_age", "input", "distance_since_reversal"),
        motions=("steps", "scan"),
    ),
    Hidden("UNKNOWN_periodic_gain", (TIP,), _on_both(_cross), where=("input",)),
    Hidden("UNKNOWN_neighbour", (TIP,), _on_both(_neighbour), where=("time", "frequency")),
)
assert set(RIGS) == {rig for h in NAMED for rig in h.rigs}
