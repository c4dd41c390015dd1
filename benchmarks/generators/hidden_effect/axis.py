"""One axis with rigid or bristled friction, in steps of 50 us: at a given velocity, on a spring, or under a servo."""

from typing import Any, NamedTuple

import numpy as np
from numba import njit

VELOCITY, SPRING, SERVO = 0, 1, 2
SAMPLE = 1e-3
SUBSTEPS = 20


class AxisTruth(NamedTuple):
    """What the axis really does; SI, zero switches a law off.

    Units: forces N, distances m, velocities m/s, times s; `load_share`, `asymmetry`, `run_in`, `position_wave`,
    `flexible_share`, `flexible_damping` and `texture` are pure numbers, `temperature_rate` is 1/K.
    """

    mass: float = 1.5
    pull_stiffness: float = 3000.0
    coulomb: float = 2.0
    viscous: float = 0.0
    stribeck: float = 0.0
    stribeck_velocity: float = 3e-3
    stribeck_lorentzian: float = 0.0
    stribeck_delay: float = 0.0
    presliding: float = 0.0
    bristle_damping: float = 0.0
    dwell: float = 0.0
    dwell_time: float = 0.05
    dwell_distance: float = 2e-5
    asymmetry: float = 0.0
    position_wave: float = 0.0
    position_pitch: float = 0.02
    position_phase: float = 0.0
    load_share: float = 0.0
    load_reference: float = 10.0
    temperature_rate: float = 0.0
    temperature_reference: float = 21.0
    run_in: float = 0.0
    run_in_distance: float = 0.05
    quadratic: float = 0.0
    bias: float = 0.0
    spring: float = 0.0
    cubic: float = 0.0
    cogging: float = 0.0
    cogging_pitch: float = 4e-3
    cogging_phase: float = 0.0
    gravity: float = 0.0
    gravity_radius: float = 0.023
    backlash: float = 0.0
    flexible_share: float = 0.0
    flexible_frequency: float = 60.0
    flexible_damping: float = 0.03
    drive_lag: float = 0.0
    drive_delay: float = 0.0
    texture: float = 0.0


class AxisRun(NamedTuple):
    """What came out, at every sample: arrays of shape (n,), SI."""

    position: np.ndarray
    velocity: np.ndarray
    acceleration: np.ndarray
    direction: np.ndarray
    force: np.ndarray
    deflection: np.ndarray


@njit(cache=True)
def _level(p, x, v_seen, aged, load, warmth, travelled, factor, pitches, phases):
    """Friction level in N before its direction is chosen."""
    a = abs(v_seen) / p.stribeck_velocity
    shape = 1.0 / (1.0 + a * a) if p.stribeck_lorentzian > 0.5 else np.exp(-a * a)
    level = p.coulomb + p.stribeck * shape + aged
    if p.load_share != 0.0:
        # A part of the friction is an elastic contact that adheres with a fifth of the usual load.
        pressed = (max(load, 0.0) / p.load_reference + 0.2) / 1.2
        level *= 1.0 - p.load_share + p.load_share * pressed ** (2.0 / 3.0)
    if p.temperature_rate != 0.0:
        level *= np.exp(-p.temperature_rate * (warmth - p.temperature_reference))
    if p.position_wave != 0.0:
        s = np.sin(2.0 * np.pi * x / p.position_pitch + p.position_phase)
        level *= 1.0 + p.position_wave * (s + 0.15 * s * s)
    if p.texture != 0.0:
        wave = 0.0
        for i in range(pitches.size):
            wave += np.sin(2.0 * np.pi * x / pitches[i] + phases[i])
        level *= 1.0 + p.texture * wave
    if p.run_in != 0.0:
        level *= 1.0 + p.run_in / (1.0 + travelled / p.run_in_distance)
    return max(level * factor, 0.0)


@njit(cache=True)
def _position_force(p, x):
    force = p.bias + p.spring * x + p.cubic * x * x * x
    if p.cogging != 0.0:
        force += p.cogging * np.sin(2.0 * np.pi * x / p.cogging_pitch + p.cogging_phase)
    if p.gravity != 0.0:
        force += p.gravity * np.sin(x / p.gravity_radius)
    return force


@njit(cache=True)
def _run(mode, p, gains, guide, guide_speed, feed, gain, load, warmth, factor, extra, pitches, phases, substeps):
    n = guide.size
    h = SAMPLE / substeps
    out = np.zeros((6, n))
    command = np.zeros(n)
    seen = np.zeros(n * substeps + 1)
    delay = round(p.stribeck_delay / h)
    late = round(p.drive_delay / h)
    # Eight stop operators: break-away distances spread geometrically, equal shares of the level.
    elements = 8
    stops = np.zeros(elements)
    widths = np.zeros(elements)
    for i in range(elements):
        widths[i] = p.presliding * 0.12 * 1.55**i
    x = guide[0] if mode == VELOCITY else 0.0
    v = guide_speed[0] if mode == VELOCITY else 0.0
    q, qv = x, v
    own = p.mass * (1.0 - p.flexible_share) if mode != VELOCITY else p.mass
    riding = p.mass * p.flexible_share
    w = 2.0 * np.pi * p.flexible_frequency
    direction = 1.0
    held = -1.0
    rested, aged, travelled, integral, actual = 0.0, 0.0, 0.0, 0.0, 0.0
    peak, slid = 0.0, 0.0
    for k in range(n):
        if mode == SERVO:
            error = guide[k] - x
            # Held softly, the guide keeps its damping and forgets its integral: nothing winds up, nothing swings up.
            if gain[k] > 0.5:
                integral += gains[2] * error * SAMPLE
            else:
                integral *= 1.0 - SAMPLE / 0.3
            command[k] = gain[k] * gains[0] * error + np.sqrt(gain[k]) * gains[1] * (guide_speed[k] - v) + integral
            command[k] += feed[k]
            if k == 0:
                actual = command[0]
        for j in range(substeps):
            step = k * substeps + j
            part = j / substeps
            nxt = min(k + 1, n - 1)
            fac = factor[k] + part * (factor[nxt] - factor[k])
            push = extra[k] + part * (extra[nxt] - extra[k])
            seen[step] = v
            v_seen = seen[max(step - delay, 0)]
            level = _level(p, x, v_seen, aged, load[k], warmth[k], travelled, fac, pitches, phases)
            passive = p.viscous * v + p.quadratic * abs(v) * v + _position_force(p, x) + push
            drive = 0.0
            flex = 0.0
            if mode == SPRING:
                target = guide[k] + part * (guide[nxt] - guide[k])
                stretch = target - x
                half = 0.5 * p.backlash
                if stretch > half:
                    drive = p.pull_stiffness * (stretch - half)
                elif stretch < -half:
                    drive = p.pull_stiffness * (stretch + half)
            elif mode == SERVO:
                now = max(step - late, 0) // substeps
                if p.drive_lag > 0.0:
                    actual += (command[now] - actual) * (1.0 - np.exp(-h / p.drive_lag))
                else:
                    actual = command[now]
                drive = actual
            if riding > 0.0 and mode != VELOCITY:
                flex = riding * (w * w * (q - x) + 2.0 * p.flexible_damping * w * (qv - v))
            if mode == VELOCITY:
                new = guide_speed[k] + (part + 1.0 / substeps) * (guide_speed[nxt] - guide_speed[k])
                trend = v if v != 0.0 else new
            else:
                new = 0.0
                trend = v + h / own * (drive + flex - passive)
            if trend > 0.0:
                side = 1.0
            elif trend < 0.0:
                side = -1.0
            else:
                side = direction
            level *= 1.0 + p.asymmetry * side
            if p.presliding > 0.0:
                friction, stuck = 0.0, 0.0
                for i in range(elements):
                    friction += stops[i] / widths[i] / elements
                    if abs(stops[i]) < widths[i]:
                        stuck += 1.0 / elements
                friction *= level
                friction += p.bristle_damping * stuck * v
                if mode != VELOCITY:
                    new = v + h / own * (drive + flex - passive - friction)
            elif mode == VELOCITY:
                # At rest the force stays what it was when motion stopped, whatever the level could hold.
                if v == 0.0 and new == 0.0:
                    held = level if held < 0.0 else min(held, level)
                    friction = held * side
                else:
                    held = -1.0
                    friction = level * side
            else:
                # Rigid friction, exactly: it takes away what speed it can, and no more.
                lost = h * level / own
                new = trend - side * lost if abs(trend) > lost else 0.0
                friction = (trend - new) * own / h
            if j == 0:
                out[0, k] = x
                out[1, k] = v
                out[2, k] = (new - v) / h
                out[3, k] = side if (v != 0.0 or new != 0.0) else 0.0
                for i in range(elements):
                    out[5, k] += stops[i] / elements
                out[4, k] = friction + passive if mode == VELOCITY else drive
            if mode == VELOCITY:
                dx = 0.5 * h * (v + new)
            else:
                dx = h * new
            for i in range(elements):
                if p.presliding > 0.0:
                    stops[i] = min(max(stops[i] + dx, -widths[i]), widths[i])
            x += dx
            travelled += abs(dx)
            if riding > 0.0 and mode != VELOCITY:
                # The same force as on the body, at the same moment: else a drag of riding * w^2 * h comes of the steps.
                qv -= h * flex / riding
                q += h * qv
            if new != 0.0:
                direction = 1.0 if new > 0.0 else -1.0
            if p.dwell > 0.0:
                if abs(new) < 1e-7:
                    rested += h
                    aged = p.dwell * np.log(1.0 + rested / p.dwell_time)
                    peak, slid = aged, 0.0
                else:
                    # What a rest brought is worn off by a power of the way, not at a constant rate.
                    slid += abs(dx)
                    aged = peak / (1.0 + (slid / p.dwell_distance) ** 1.5)
                    rested = p.dwell_time * (np.exp(aged / p.dwell) - 1.0)
            v = new
    if mode == SERVO:
        out[4] = command
    return out


def simulate_axis(
    mode: int,
    truth: AxisTruth,
    motion: Any,
    *,
    load: np.ndarray,
    temperature: np.ndarray,
    factor: np.ndarray,
    extra: np.ndarray,
    pitches: np.ndarray,
    phases: np.ndarray,
    substeps: int = SUBSTEPS,
) -> AxisRun:
    """Run one record of `motion` (see motions); channels have one value per millisecond.

    `force` is friction_force (prescribed velocity), spring force, or the servo's command, before any sensor.
    `direction` is 0 while the axis is stuck.
    """
    gains = np.array(motion.gains(truth.mass))
    out = _run(
        mode,
        AxisTruth(*(float(value) for value in truth)),
        gains,
        motion.guide,
        motion.speed,
        motion.feed,
        motion.gain,
        load,
        temperature,
        factor,
        extra,
        pitches,
        phases,
        substeps,
    )
    return AxisRun(*out)
