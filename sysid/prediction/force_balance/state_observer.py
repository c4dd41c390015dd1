"""Friction of a driven mass along the motion of a state observer.

A filter wide enough for the noise of a position blurs the motion more than bristles stretch. A state observer needs no
filter of the motion: the model itself is integrated under the measured force, held to the measured position x_m,

    m v' = F - f(x, v, z) + m w^2 (x_m - x) + sqrt(2) m w (v_m - v),   x' = v

with the bandwidth w = sqrt(s_F / (m s_x)) of the steady Kalman filter of a mass with noise s_F of its force and s_x of
its position, and its damping. v_m is the velocity of the integrated motion, corrected by the derivative of the smoothed
x_m - x: it contains no blur of the model's own motion. The friction f is compared with the measured force as that
along a filtered motion is.

Source: Ljung, System Identification (1999), sections 4.3 and 7.5 (prediction with an observer); Kalata, IEEE Trans.
Aerosp. Electron. Syst. 20 (1984) 174 (steady gains of position and velocity).
"""

from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np

from sim.effects.catalogue import Model as SimulatedModel
from sim.effects.effect import Effect
from sim.effects.friction.viscous import EFFECT as DAMPER
from sim.integration.drive import Drive
from sim.integration.simulate import Simulation, simulate
from sysid.prediction.effect_terms import Values, values_of
from sysid.prediction.force_balance.record import ForceBalanceRecord, StateObserver

HIGHEST = 0.3
"""Largest bandwidth times the sampling step: a force is linear from row to row."""

SMOOTHING = 3.0
"""Bandwidth of the smoothed x_m - x over that of the observer: a mass that oscillates on its bristles is faster."""

TOLERANCE = 1e-5
"""Relative error of a step of the integration."""

PER_ROW = 4
"""Instants per row of the observer's motion."""

CONVERGED = 0.01
"""Change of the force against the observer from one pass to the next, filtered, over the noise of the force channel, at
which its motion has converged: the change falls by half in each pass or faster."""

MOST_STEPS = 100
"""Attempted steps per row, on average, after which an integration is given up."""


def can_be_observed(effects: Sequence[Effect]) -> bool:
    """Whether all effects act on the mass itself: the force that holds it to the measured position passes no drive."""
    return bool(effects) and all(effect.acts_on in ("friction", "axis", "memory") for effect in effects)


def observed(
    balance: ForceBalanceRecord,
    effects: Sequence[Effect],
    values: Values,
    first: float,
    passes: int,
    ideal_friction: Callable[[Simulation, ForceBalanceRecord], np.ndarray],
) -> ForceBalanceRecord:
    """The record with the state observer of a model, whose friction is `first` (N) at the first row; v_m converges in
    at most some `passes`, and so does the difference of the friction in the integration from the `ideal_friction` along
    it."""
    observer, position, full_filter = balance.observer, balance.raw_position, balance.full_filter
    assert position is not None and full_filter is not None
    if observer is None:
        bandwidth = float(np.sqrt(balance.acceleration_noise / max(balance.position_noise, 1e-300)))
        observer = StateObserver(min(bandwidth, HIGHEST / balance.step), balance.axis.velocity, first)
    found = replace(balance, observer=observer, stick_phases=None, half_width_variant=None)
    damping, channel = np.sqrt(2.0) * values["rig.mass"] * observer.bandwidth, balance.force_channel
    for _ in range(passes):
        motion = observed_motion(found, effects, values)
        late = smoothed(position - motion.position[::PER_ROW], SMOOTHING * observer.bandwidth * balance.step)
        velocity = motion.velocity[::PER_ROW] + np.gradient(late, balance.step)
        yields = at_rows(motion.friction) - ideal_friction(motion, balance)
        change = full_filter(damping * (velocity - observer.velocity) + yields - observer.yields)
        observer = replace(observer, velocity=velocity, yields=yields)
        found = replace(found, observer=observer)
        if np.std(change[balance.valid[channel]]) < CONVERGED * balance.noise[channel]:
            break
    return found


def at_rows(between: np.ndarray) -> np.ndarray:
    """Values (n,) at the rows from means between `PER_ROW` instants per row: friction jumps there, and a filter of the
    rows keeps the time of a jump only in the mean over a row. That mean is above a curve by 1/24 of its second
    difference."""
    rows = np.pad(between, PER_ROW // 2, mode="edge").reshape(-1, PER_ROW).mean(axis=1)
    return rows - np.pad(np.diff(rows, 2), 1) / 24.0


def observed_motion(balance: ForceBalanceRecord, effects: Sequence[Effect], values: Values) -> Simulation:
    """The observer's motion under a model at `PER_ROW` instants per row, and the force against it without its inertia
    between these, from the change of the momentum."""
    observer, axis, mass = balance.observer, balance.axis, values["rig.mass"]
    assert observer is not None and balance.applied is not None and balance.raw_position is not None
    stiffness, damping = mass * observer.bandwidth**2, np.sqrt(2.0) * mass * observer.bandwidth
    force = balance.applied + observer.yields + stiffness * balance.raw_position + damping * observer.velocity
    # A straight line from row to row is above a curved motion, by a twelfth of its second difference on average.
    change = np.gradient(observer.velocity)
    force -= (stiffness * balance.step * change + damping * np.gradient(change)) / 12.0
    rates = np.append(np.diff(force) / np.diff(axis.time), 0.0)
    core = next((effect for effect in effects if effect.friction_state is not None), None)
    laws = [*(values_of(effect, values) for effect in effects), DAMPER.values_type(damping)]
    step = balance.step / PER_ROW
    run = simulate(
        SimulatedModel((*effects, DAMPER), tuple(laws)),
        Drive(axis.time, force, rates, stiffness=stiffness),
        axis.time[0] + step * np.arange(PER_ROW * (balance.size - 1) + 1),
        mass=mass,
        position=float(balance.raw_position[0]),
        velocity=float(observer.velocity[0]),
        bristle=_first_state(core, observer, values),
        load=axis.load,
        temperature=axis.temperature,
        tolerance=TOLERANCE,
        most_steps=MOST_STEPS * balance.size,
    )
    push = run.drive - damping * run.velocity
    return replace(run, friction=0.5 * (push[1:] + push[:-1]) - mass * np.diff(run.velocity) / step)


def _first_state(core: Effect | None, observer: StateObserver, values: Values) -> np.ndarray | None:
    if core is None or core.friction_state.springs is not None:
        return None
    level = abs(values.get(f"{core.name}.force", observer.friction))
    force = min(max(observer.friction, -level), level)
    return state_of_force(core, values, force, float(observer.velocity[0]), level)


def state_of_force(core: Effect, values: Values, force: float, velocity: float, level: float) -> np.ndarray:
    """State (1,) of a friction state model of one element, whose force (N) is linear in it."""
    p = values_of(core, values)
    unit, side = core.friction_state.scale(p), 1.0 if velocity >= 0.0 else -1.0
    none, one = (core.friction_state.law(0, z, velocity, side, level, p)[1] for z in (0.0, unit))
    return np.array([unit * (force - none) / (one - none) if one != none else 0.0])


def smoothed(values: np.ndarray, cut_off: float) -> np.ndarray:
    """Cubic smoothing spline of `values` (n,): response 1/(1 + (w/w_0)^4), at a cut-off w_0 in rad per row."""
    from scipy.linalg import solveh_banded

    n = values.size
    bands = np.tile(np.array([[1.0], [-4.0], [6.0]]), n)
    bands[2, [0, -1]], bands[2, [1, -2]], bands[1, [1, -1]] = 1.0, 5.0, -2.0
    bands *= cut_off**-4.0
    bands[2] += 1.0
    return solveh_banded(bands, values)
