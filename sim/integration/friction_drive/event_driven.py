"""Event-driven simulation of a stage driven by friction along one axis: pads and contact stick or slip.

Pads resist up to their friction limit; the contact is a spring and a dashpot up to its own. Between two events the
stage is an oscillator on the contact, a body under constant-rate forces, or at rest. Each regime is solved in closed
form while tip, limits and other forces run linearly from row to row, and by the classical Runge-Kutta method of order
four, with steps of a fifth of a radian, where friction depends on the velocity. Events are located by the Illinois
variant of regula falsi (Dowell and Jarratt, BIT 11 (1971) 168). The result depends smoothly on every parameter.
"""

from typing import NamedTuple

import numpy as np

from sim.integration.friction_drive.inputs import (
    DrivenStage,
    FrictionLimit,
    Nudging,
    TipMotion,
    VelocityTable,
    resolved_stage,
)
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


LONGEST_PHASE = 0.6
"""rad of the oscillation on the contact between two event checks."""

CHECKS_WITH_TABLES = 3
"""Event checks in place of one, each a Runge-Kutta step, where friction depends on the velocity: as the limit rises
while a slip slows down, a contact may slip and stick again within less than a row."""

MOST_EVENTS = 40
MOST_ITERATIONS = 60
PADS_SWITCH, CONTACT_SLIPS, CONTACT_STICKS, SPRING_AT_LIMIT, SPRING_BELOW_LIMIT = 1, 2, 3, 4, 5


class Event(NamedTuple):
    """Motion up to an event, or to the end of a segment where `happened` is false."""

    x: float
    v: float
    spring: float
    time: float
    kind: int
    happened: bool


def simulate_event_driven(
    tip: TipMotion,
    push: np.ndarray,  # other forces on the stage, N, (n,)
    contact: FrictionLimit,  # while it touches; infinite where it never slips
    pads: FrictionLimit,
    stage: DrivenStage,
    nudging: Nudging | None = None,  # towards a measured position after every row; none for a free simulation
) -> np.ndarray:
    """Position (n,) of the stage from rest at the first row, m."""
    stage = resolved_stage(stage)
    checks = max(1, int(np.ceil(np.sqrt(stage.stiffness / stage.mass) * stage.step / LONGEST_PHASE)))
    tables = contact.table, pads.table
    tabulated = any(table.values.shape[1] > 0 for table in tables)
    checks *= CHECKS_WITH_TABLES if tabulated else 1
    regular = stage.step / checks
    decay = 0.5 * stage.damping / stage.mass
    square = stage.stiffness / stage.mass - decay * decay
    frequency = float(np.sqrt(max(abs(square), 1e-12 * stage.stiffness / stage.mass)))
    constants = Constants(
        *(stage.stiffness, stage.damping, stage.mass, *tables, tabulated, decay, square, frequency),
        *(regular * 1.000001, 1e-3 * regular, 1e-10 * stage.step),
    )
    nudged = Nudging(tip.along, 0.0, 0.0) if nudging is None else nudging
    return _simulate(constants, tip, push, contact, pads, nudged, stage.step, checks)


@inlined
def _side(force: float) -> float:
    return 1.0 if force > 0.0 else -1.0


@inlined
def _entered(constants: Constants, now: Inputs, state: State) -> State:
    """State where a segment begins: inputs that change their slope may change the regime."""
    spring, slip_side, below, pad_side = state.spring, state.slip_side, state.below, state.pad_side
    if state.touching:
        sliding = now.tip_velocity - state.v
        elastic = spring + constants.damping * sliding
        side = slip_side if slip_side != 0.0 else _side(elastic)
        limit = contact_limit_at(constants, now, side, sliding)
        if slip_side == 0.0 and abs(elastic) > limit:
            slip_side, below = side, True
        elif slip_side * sliding < 0.0:
            # A tip that reverses from row to row ends the slip immediately.
            spring, slip_side, below = side * min(side * spring, limit), 0.0, True
        elif slip_side != 0.0:
            # A limit that rises immediately, because the slip slows down, is not followed by the spring.
            below = below or side * spring < limit * (1.0 - 1e-12)
            slip_side = 0.0 if below and side * elastic <= limit else slip_side
    state = State(state.x, state.v, spring, pad_side, slip_side, below, state.touching)
    force, other = contact_force(constants, now, state, state.v, spring)
    pull = force + other + now.push
    if pad_side == 0.0 and abs(pull) > pad_limit_at(constants, now, _side(pull), 0.0):
        pad_side = _side(pull)
    return State(state.x, state.v, spring, pad_side, slip_side, below, state.touching)


@compiled(_nrt=False)
def _limit_rise(constants: Constants, now: Inputs, state: State, v: float, spring: float) -> float:
    """Rate, N/s, at which the limit of a slipping contact changes by its load and by its velocity."""
    if not constants.tabulated:
        return now.limit_rate
    sliding, soon = now.tip_velocity - v, constants.soon
    later = sliding
    if state.pad_side != 0.0:
        later -= rates(constants, now, state, v, spring)[0] * soon
    limit = contact_limit_at(constants, now, state.slip_side, sliding)
    return (contact_limit_at(constants, inputs_after(now, soon), state.slip_side, later) - limit) / soon


@inlined
def _overshoot(constants: Constants, now: Inputs, state: State, v: float, spring: float) -> tuple[float, float, int]:
    """Spring force, N, how far (m) the motion is past the next event, and which event that is."""
    k = constants.stiffness
    natural = np.sqrt(k / constants.mass)
    past, kind = -1.0, 0
    sliding = now.tip_velocity - v
    force, other = contact_force(constants, now, state, v, spring)
    if state.touching and state.slip_side == 0.0:
        past, kind = (abs(force) - contact_limit_at(constants, now, _side(force), sliding)) / k, CONTACT_SLIPS
    elif state.touching and state.below:
        elastic = spring + constants.damping * sliding
        past, kind = state.slip_side * (force - elastic) / k, CONTACT_STICKS
        over = state.slip_side * (spring - force) / k
        if over > past:
            past, kind = over, SPRING_AT_LIMIT
    elif state.touching:
        spring = force
        rise = _limit_rise(constants, now, state, v, spring)
        past, kind = (rise - state.slip_side * k * sliding) / (k * natural), SPRING_BELOW_LIMIT
        if constants.contact.values.shape[1] > 0:
            # A slip ends before it reverses, however its limit falls with the velocity; one whose limit falls with the
            # load may reverse slipping.
            past = max(past, -state.slip_side * sliding / natural)
    pull = force + other + now.push
    over = -state.pad_side * v / natural
    if state.pad_side == 0.0:
        over = (abs(pull) - pad_limit_at(constants, now, _side(pull), 0.0)) / k
    if over > past:
        past, kind = over, PADS_SWITCH
    return spring, past, kind


@inlined
def _next_event(constants: Constants, now: Inputs, state: State, left: float, regular: Transition) -> Event:
    """The motion up to the first event within a time `left`, located by regula falsi, or over all of it; `regular`:
    propagator of the free oscillation over `left`."""
    low, high, t = 0.0, left, left
    past_low, past_high, weight = 0.0, 0.0, 0
    free, found = regular, Event(state.x, state.v, state.spring, 0.0, 0, False)
    for iteration in range(MOST_ITERATIONS):
        if iteration > 0:
            free = free_transition(constants, t)
        x, v, spring = motion_after(constants, now, state, t, free)
        spring, past, kind = _overshoot(constants, inputs_after(now, t), state, v, spring)
        found = Event(x, v, spring, t, kind, past > 1e-18 or iteration > 0)
        if iteration == 0:
            if not found.happened:
                break
            past_high = past
        elif past > 0.0:
            high, past_high = t, past
            past_low *= 0.5 if weight == 1 else 1.0
            weight = 1
        else:
            low, past_low = t, past
            past_high *= 0.5 if weight == -1 else 1.0
            weight = -1
        if high - low <= constants.resolution or 0.0 < past < 1e-16:
            if t == high:
                break
            t = high
        elif past_low < 0.0:
            t = low + (high - low) * past_low / (past_low - past_high)
            t = min(max(t, low + 0.02 * (high - low)), high - 0.02 * (high - low))
        else:
            t = 0.5 * (low + high)
    return found


@compiled(_nrt=False)
def _switched(constants: Constants, now: Inputs, state: State, event: Event) -> State:
    """State in the regime that follows an event."""
    v, pad_side, slip_side, below = event.v, state.pad_side, state.slip_side, state.below
    if event.kind == PADS_SWITCH:
        force, other = contact_force(constants, now, state, 0.0, event.spring)
        pull = force + other + now.push
        sticks = pad_side != 0.0 and abs(pull) <= pad_limit_at(constants, now, _side(pull), 0.0)
        v = v if pad_side == 0.0 else 0.0
        pad_side = 0.0 if sticks else _side(pull)
    elif event.kind == CONTACT_SLIPS:
        slip_side, below = _side(event.spring + constants.damping * (now.tip_velocity - v)), True
    elif event.kind == CONTACT_STICKS:
        slip_side = 0.0
    elif event.kind == SPRING_AT_LIMIT:
        below = False
    elif event.kind == SPRING_BELOW_LIMIT:
        below = True
    return State(event.x, v, event.spring, pad_side, slip_side, below, state.touching)


@inlined
def _advanced(
    constants: Constants, row: Inputs, state: State, now: float, until: float, regular: Transition, evenly: bool
) -> State:
    """State at `until`, s after the row, from that at `now`, from event to event; `regular`: propagator over one
    regular interval between event checks, which the first interval is where it is `evenly` spaced."""
    for number in range(MOST_EVENTS):
        left = until - now
        if left <= 0.0:
            break
        here = inputs_after(row, now)
        state = _entered(constants, here, state)
        free = regular if evenly and number == 0 else free_transition(constants, left)
        event = _next_event(constants, here, state, left, free)
        now += event.time
        if not event.happened:
            return State(event.x, event.v, event.spring, state.pad_side, state.slip_side, state.below, state.touching)
        state = _switched(constants, inputs_after(here, event.time), state, event)
    return state


@inlined
def _row_inputs(tip: TipMotion, push: np.ndarray, contact: FrictionLimit, pads: FrictionLimit, i: int, step: float):
    """Inputs at row i - 1 and their rates until row i, and whether the contact can slip."""
    slips = contact.at_rest[i] < np.inf and contact.at_rest[i - 1] < np.inf
    inputs = Inputs(
        (tip.along[i] - tip.along[i - 1]) / step,
        push[i - 1],
        (push[i] - push[i - 1]) / step,
        contact.at_rest[i - 1] if slips else np.inf,
        (contact.at_rest[i] - contact.at_rest[i - 1]) / step if slips else 0.0,
        contact.factor[i - 1],
        (contact.factor[i] - contact.factor[i - 1]) / step,
        pads.at_rest[i - 1],
        (pads.at_rest[i] - pads.at_rest[i - 1]) / step,
        pads.factor[i - 1],
        (pads.factor[i] - pads.factor[i - 1]) / step,
    )
    return inputs, slips


@compiled
def _simulate(
    constants: Constants,
    tip: TipMotion,
    push: np.ndarray,
    contact: FrictionLimit,
    pads: FrictionLimit,
    nudging: Nudging,
    step: float,
    checks: int,
) -> np.ndarray:
    """Positions (n,) of `simulate_event_driven`, with so many event `checks` in a row."""
    load, out = tip.load, np.zeros(tip.along.size)
    regular = free_transition(constants, step / checks)
    state = State(0.0, 0.0, 0.0, 0.0, 0.0, False, load[0] > 0.0)
    for i in range(1, out.size):
        row, slips = _row_inputs(tip, push, contact, pads, i, step)
        lifts = load[i - 1] * load[i] < 0.0
        change = step * load[i - 1] / (load[i - 1] - load[i]) if lifts else step
        now = 0.0
        for segment in range(2 if lifts else 1):
            end = step if segment == 1 or not lifts else change
            touching = (load[i - 1] if segment == 0 and lifts else load[i]) > 0.0
            again = touching and not state.touching
            spring, slip_side = (0.0, 0.0) if again else (state.spring, state.slip_side)
            state = State(state.x, state.v, spring, state.pad_side, slip_side, state.below, touching)
            begin = now
            for check in range(checks):
                until = end if check == checks - 1 else begin + (end - begin) * (check + 1) / checks
                state = _advanced(constants, row, state, now, until, regular, not lifts)
                now = until
        out[i] = state.x
        if nudging.position_gain > 0.0:
            miss = nudging.measured[i] - state.x
            x = state.x + nudging.position_gain * miss
            v = state.v + (nudging.velocity_gain * miss / step if state.pad_side != 0.0 else 0.0)
            # A contact that never slips carries the displacement between tip and stage.
            wound = constants.stiffness * nudging.position_gain * miss if state.touching and not slips else 0.0
            state = State(x, v, state.spring - wound, state.pad_side, state.slip_side, state.below, state.touching)
    return out
