"""Motion of a driven stage within one regime of its friction, between two events.

The stage is an oscillator on the contact, a body under forces that change linearly, or at rest, each in closed form;
where friction depends on the velocity the classical Runge-Kutta method of order four integrates the motion.
"""

from typing import NamedTuple

import numpy as np

from sim.integration.driven_stage.inputs import VelocityTable
from sim.numerics.compilation import compiled, inlined


class Transition(NamedTuple):
    """Propagator of a free damped oscillation: displacement and velocity after a time from those before."""

    xx: float
    xv: float
    vx: float
    vv: float


class Constants(NamedTuple):
    """Constants of a simulation: the stage, its velocity tables, and the oscillation on the contact."""

    stiffness: float
    damping: float
    mass: float
    contact: VelocityTable
    pads: VelocityTable
    tabulated: bool
    decay: float
    square: float
    frequency: float
    longest: float
    soon: float
    resolution: float


class Inputs(NamedTuple):
    """Inputs of the simulation at an instant, SI, and the rates at which they change until the next row."""

    tip_velocity: float
    push: float
    push_rate: float
    limit: float
    limit_rate: float
    factor: float
    factor_rate: float
    pad_limit: float
    pad_limit_rate: float
    pad_factor: float
    pad_factor_rate: float


class State(NamedTuple):
    """State of the stage."""

    # x, v: position, m, and velocity, m/s
    x: float
    v: float
    spring: float  # force of the contact's spring, N
    # pad_side, slip_side: direction in which the pads slide and the contact slips, 0 while they stick
    pad_side: float
    slip_side: float
    # a contact that slips transmits its limit by spring and dashpot; whether its spring alone is below that
    below: bool
    touching: bool  # whether the tip touches the stage


@inlined
def _looked_up(curve: np.ndarray, speed: float, top: float) -> float:
    """Value of a curve (k,) over speeds that grow with the square of their index, at a speed, m/s."""
    place = np.sqrt(abs(speed) / top) * (curve.size - 1)
    k = min(int(place), curve.size - 2)
    low, high = (k / (curve.size - 1.0)) ** 2 * top, ((k + 1.0) / (curve.size - 1.0)) ** 2 * top
    part = min((abs(speed) - low) / (high - low), 1.0)
    return curve[k] + part * (curve[k + 1] - curve[k])


@inlined
def _limit(table: VelocityTable, limit: float, factor: float, side: float, velocity: float) -> float:
    """Friction limit, N, at a velocity; `side` is the direction of slip."""
    if table.values.shape[1] == 0:
        return limit
    row = 0 if side > 0.0 else 1
    total = limit * _looked_up(table.values[row], velocity, table.top)
    total += factor * _looked_up(table.values[2 + row], velocity, table.top)
    return max(total, 0.0)


@inlined
def velocity_force(table: VelocityTable, velocity: float) -> float:
    """Velocity-dependent force in addition to the friction limit, N."""
    if table.values.shape[1] == 0:
        return 0.0
    return _looked_up(table.values[4 if velocity > 0.0 else 5], velocity, table.top)


@inlined
def contact_limit_at(constants, now, side, velocity):  # type: ignore[no-untyped-def]
    return _limit(constants.contact, now.limit, now.factor, side, velocity)


@inlined
def pad_limit_at(constants, now, side, velocity):  # type: ignore[no-untyped-def]
    return _limit(constants.pads, now.pad_limit, now.pad_factor, side, velocity)


@inlined
def inputs_after(now: Inputs, t: float) -> Inputs:
    """Inputs a time t later, within the same row."""
    return Inputs(
        now.tip_velocity,
        now.push + now.push_rate * t,
        now.push_rate,
        now.limit + now.limit_rate * t,
        now.limit_rate,
        now.factor + now.factor_rate * t,
        now.factor_rate,
        now.pad_limit + now.pad_limit_rate * t,
        now.pad_limit_rate,
        now.pad_factor + now.pad_factor_rate * t,
        now.pad_factor_rate,
    )


@inlined
def free_transition(constants: Constants, t: float) -> Transition:
    """Propagator of the free oscillation on the contact over a time t."""
    decayed = np.exp(-constants.decay * t)
    phase = constants.frequency * t
    if constants.square > 0.0:
        cosine, sine = np.cos(phase), np.sin(phase) / constants.frequency
    else:
        cosine, sine = np.cosh(phase), np.sinh(phase) / constants.frequency
    return Transition(
        decayed * (cosine + constants.decay * sine),
        decayed * sine,
        -decayed * constants.stiffness / constants.mass * sine,
        decayed * (cosine - constants.decay * sine),
    )


@inlined
def _limited_spring(constants: Constants, now: Inputs, spring: float, sliding: float) -> float:
    """Spring force, N, cut at the friction limit: the dashpot may pull back what the spring has beyond it."""
    side = 1.0 if spring > 0.0 else -1.0
    return side * min(side * spring, contact_limit_at(constants, now, side, sliding))


@inlined
def contact_force(constants: Constants, now: Inputs, state: State, v: float, spring: float) -> tuple[float, float]:
    """Force of the contact's spring and dashpot, or its limit where it slips, and its velocity-dependent part, N."""
    if not state.touching:
        return 0.0, 0.0
    sliding = now.tip_velocity - v
    force = spring + constants.damping * sliding
    if state.slip_side != 0.0:
        force = state.slip_side * contact_limit_at(constants, now, state.slip_side, sliding)
    return force, velocity_force(constants.contact, sliding)


@compiled(_nrt=False)
def rates(constants: Constants, now: Inputs, state: State, v: float, spring: float) -> tuple[float, float]:
    """Acceleration, m/s^2, and rate of the spring force, N/s, where friction depends on the velocity."""
    sliding = now.tip_velocity - v
    sticks = state.touching and state.slip_side == 0.0
    limited = _limited_spring(constants, now, spring, sliding) if sticks else spring
    force, other = contact_force(constants, now, state, v, limited)
    friction = state.pad_side * pad_limit_at(constants, now, state.pad_side, v) + velocity_force(constants.pads, v)
    return (force + other + now.push - friction) / constants.mass, constants.stiffness * sliding if sticks else 0.0


@compiled(_nrt=False)
def _runge_kutta(constants: Constants, now: Inputs, state: State, t: float) -> tuple[float, float, float]:
    """Position, velocity and spring force after a time t within one regime, friction depending on the velocity."""
    count = max(1, int(np.ceil(t / constants.longest)))
    h = t / count
    x, v, q = state.x, state.v, state.spring
    sticks = state.touching and state.slip_side == 0.0
    if sticks:
        # A tip that reverses from row to row may lower the limit immediately.
        q = _limited_spring(constants, now, q, now.tip_velocity - v)
    for n in range(count):
        begin, middle, end = inputs_after(now, n * h), inputs_after(now, n * h + 0.5 * h), inputs_after(now, n * h + h)
        a1, w1 = rates(constants, begin, state, v, q)
        a2, w2 = rates(constants, middle, state, v + 0.5 * h * a1, q + 0.5 * h * w1)
        a3, w3 = rates(constants, middle, state, v + 0.5 * h * a2, q + 0.5 * h * w2)
        a4, w4 = rates(constants, end, state, v + h * a3, q + h * w3)
        x += h * (v + h / 6.0 * (a1 + a2 + a3))
        v += h / 6.0 * (a1 + 2.0 * a2 + 2.0 * a3 + a4)
        q += h / 6.0 * (w1 + 2.0 * w2 + 2.0 * w3 + w4)
        if sticks:
            q = _limited_spring(constants, end, q, now.tip_velocity - v)
    return x, v, q


@inlined
def motion_after(
    constants: Constants, now: Inputs, state: State, t: float, free: Transition
) -> tuple[float, float, float]:
    """Position, velocity and spring force after a time t within the regime of `state`; `free`: propagator over t."""
    k, wound = constants.stiffness, now.tip_velocity * t
    if state.pad_side == 0.0:
        x, v, q = state.x, 0.0, state.spring + k * now.tip_velocity * t
    elif constants.tabulated:
        x, v, q = _runge_kutta(constants, now, state, t)
    elif state.touching and state.slip_side == 0.0:
        # Particular solution: a constant velocity and offset.
        velocity = now.tip_velocity + (now.push_rate - state.pad_side * now.pad_limit_rate) / k
        loaded = state.spring + constants.damping * now.tip_velocity + now.push - state.pad_side * now.pad_limit
        offset = (loaded - constants.damping * velocity) / k
        y0, y1 = -offset, state.v - velocity
        moved = offset + velocity * t + free.xx * y0 + free.xv * y1
        x, v = state.x + moved, velocity + free.vx * y0 + free.vv * y1
        q = state.spring + k * (wound - moved)
    else:
        force, force_rate = 0.0, 0.0
        if state.touching:
            force, force_rate = state.slip_side * now.limit, state.slip_side * now.limit_rate
        a = (force + now.push - state.pad_side * now.pad_limit) / constants.mass
        jerk = (force_rate + now.push_rate - state.pad_side * now.pad_limit_rate) / constants.mass
        v = state.v + t * (a + 0.5 * jerk * t)
        x = state.x + t * (state.v + t * (0.5 * a + jerk * t / 6.0))
        q = state.spring
    if state.slip_side != 0.0:
        q = state.spring + k * (wound - (x - state.x))
    return x, v, q
