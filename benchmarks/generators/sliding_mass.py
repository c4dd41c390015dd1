"""A mass that slides against friction, in code of its own: the laws as published, integrated in steps of 2 us.

Bristles follow from Runge-Kutta's method of fourth order, elements of Maxwell-slip from the leapfrog method, and rigid
friction from event to event: the mass slides one way until its velocity is zero, and rests until the force on it is
more than friction holds. Nothing of the program is imported.
"""

import math
from typing import NamedTuple

import numpy as np
from numba import njit

STEP = 2e-6
LEAD = 0.2
"""Time before the first row, s: the record begins in the middle of a motion."""
ELEMENTS = 12

LAWS = (
    *("coulomb", "presliding", "lugre", "lugre_causal", "dahl", "lugre_undamped", "elasto_plastic", "rate_and_state"),
)
COULOMB, PRESLIDING, LUGRE, CAUSAL, DAHL, UNDAMPED, ELASTO_PLASTIC, RATE_AND_STATE = range(len(LAWS))
DRIVES = ("imposed", "controlled", "open loop", "spring")
IMPOSED, CONTROLLED, OPEN_LOOP, SPRING = range(len(DRIVES))


class Friction(NamedTuple):
    """Friction of a mass, SI: its law by its place in LAWS, level, drag, Stribeck's force and velocity, and what the
    law has besides: stiffness, damping, break-away stretch, curvature, direct effect, evolution, memory."""

    law: int
    level: float
    drag: float
    stribeck: float = 0.0
    stribeck_velocity: float = 1.0
    stiffness: float = 1e5
    damping: float = 0.0
    breakaway: float = 0.7
    curvature: float = 2.0
    direct: float = 0.01
    evolution: float = 0.0
    memory: float = 1e-5
    reference_velocity: float = 1e-3


class Drive(NamedTuple):
    """What moves the mass, by its place in DRIVES, along or with a sum of sines: rates (rad/s), phases and sizes (m; N
    in an open loop), each (k,); the gains of a controller, and the stiffness and dashpot of a spring."""

    kind: int
    rates: np.ndarray
    phases: np.ndarray
    sizes: np.ndarray
    stiffness: float = 4e4
    damping: float = 300.0


@njit(cache=True)
def _path(drive, t, order):
    total = 0.0
    for k in range(drive.rates.size):
        angle = drive.rates[k] * t + drive.phases[k] + 0.5 * math.pi * order
        total += drive.sizes[k] * drive.rates[k] ** order * math.sin(angle)
    return total


@njit(cache=True)
def _push(drive, t, x, v):
    """Force of the drive, N."""
    if drive.kind == OPEN_LOOP:
        return _path(drive, t, 0)
    damped = drive.damping * (_path(drive, t, 1) - v) if drive.damping != 0.0 else 0.0
    return drive.stiffness * (_path(drive, t, 0) - x) + damped


@njit(cache=True)
def _level(f, v, age):
    if f.law == RATE_AND_STATE:
        return f.level * (1.0 + f.evolution * math.log(1.0 + f.reference_velocity * age / f.memory))
    return f.level + f.stribeck * math.exp(-((v / f.stribeck_velocity) ** 2))


@njit(cache=True)
def _bristles(f, v, z, age):
    """Rate of the deflection, m/s, and force, N, of one set of bristles."""
    g = _level(f, v, age)
    if f.law == RATE_AND_STATE:
        reach = f.direct * g
        force = f.stiffness * z
        slip = f.reference_velocity * (math.exp((force - g) / reach) - math.exp((-force - g) / reach))
        return v - slip, force
    if f.law == ELASTO_PLASTIC:
        relative = abs(z) * f.stiffness / g
        plastic = 0.0
        if z * v > 0.0 and relative > f.breakaway:
            middle = 0.5 * (1.0 + f.breakaway)
            part = min((relative - middle) / (1.0 - f.breakaway), 0.5)
            plastic = 0.5 * (1.0 + math.sin(math.pi * part))
        rate = v * (1.0 - plastic * relative)
    else:
        rate = v - f.stiffness * abs(v) / g * z
        if f.law == CAUSAL:
            rate /= 1.0 + f.damping * abs(v) / g
    return rate, f.stiffness * z + f.damping * rate


@njit(cache=True)
def _slopes(f, drive, mass, t, x, v, z, age):
    speed = _path(drive, t, 1) if drive.kind == IMPOSED else v
    rate, force = _bristles(f, speed, z, age)
    gained = 0.0
    if drive.kind != IMPOSED:
        gained = (_push(drive, t, x, v) - force - f.drag * v) / mass
    return speed, gained, rate, 1.0 - abs(speed - rate) * age / f.memory


@njit(cache=True)
def _with_bristles(f, drive, mass, start, rows, sample, per):
    """Position, and force of the drive, or of friction along an imposed motion, (rows,) each."""
    x, v, z, age = start[0], start[1], 0.0, 0.0
    out, force = np.empty(rows), np.empty(rows)
    lead, h = round(LEAD / sample), sample / per
    for i in range(lead + rows):
        t = (i - lead) * sample
        if i >= lead:
            speed = _path(drive, t, 1) if drive.kind == IMPOSED else v
            own = _bristles(f, speed, z, age)[1] + f.drag * speed
            out[i - lead], force[i - lead] = x, own if drive.kind == IMPOSED else _push(drive, t, x, v)
        for j in range(per):
            s = t + j * h
            a = _slopes(f, drive, mass, s, x, v, z, age)
            m = 0.5 * h
            b = _slopes(f, drive, mass, s + m, x + m * a[0], v + m * a[1], z + m * a[2], age + m * a[3])
            c = _slopes(f, drive, mass, s + m, x + m * b[0], v + m * b[1], z + m * b[2], age + m * b[3])
            d = _slopes(f, drive, mass, s + h, x + h * c[0], v + h * c[1], z + h * c[2], age + h * c[3])
            x += h / 6.0 * (a[0] + 2.0 * (b[0] + c[0]) + d[0])
            v += h / 6.0 * (a[1] + 2.0 * (b[1] + c[1]) + d[1])
            z += h / 6.0 * (a[2] + 2.0 * (b[2] + c[2]) + d[2])
            age += h / 6.0 * (a[3] + 2.0 * (b[3] + c[3]) + d[3])
    return out, force


@njit(cache=True)
def _with_elements(f, drive, mass, start, rows, sample, per):
    """As `_with_bristles`, with ideal springs in parallel that slip one after the other."""
    # The virgin curve 1 - (1 - u)^c at u = 1/N .. 1 is the sum of elements of these parts and reaches.
    reach = f.level * f.curvature / f.stiffness
    heights = 1.0 - (1.0 - np.arange(ELEMENTS + 2) / ELEMENTS) ** f.curvature
    heights[-1] = heights[-2]
    steep = np.diff(heights) * ELEMENTS
    parts = (steep[:-1] - steep[1:]) * np.arange(1, ELEMENTS + 1) / ELEMENTS
    springs = f.level * parts / (reach * np.arange(1, ELEMENTS + 1) / ELEMENTS)
    forces = np.zeros(ELEMENTS)
    x, v = start[0], start[1]
    out, force = np.empty(rows), np.empty(rows)
    lead, h = round(LEAD / sample), sample / per
    for i in range(lead + rows):
        t = (i - lead) * sample
        if i >= lead:
            speed = _path(drive, t, 1) if drive.kind == IMPOSED else v
            own = forces.sum() + f.drag * speed
            out[i - lead], force[i - lead] = x, own if drive.kind == IMPOSED else _push(drive, t, x, v)
        for j in range(per):
            s = t + j * h
            if drive.kind == IMPOSED:
                moved, v = _path(drive, s + h, 0) - x, _path(drive, s + h, 1)
            else:
                v += 0.5 * h * (_push(drive, s, x, v) - forces.sum() - f.drag * v) / mass
                moved = v * h
            x += moved
            g = _level(f, v, 0.0)
            for k in range(ELEMENTS):
                forces[k] = min(max(forces[k] + springs[k] * moved, -parts[k] * g), parts[k] * g)
            if drive.kind != IMPOSED:
                # The forces that depend on the velocity are those of the end of the step.
                one = 0.5 * h / mass
                trial = v + one * (_push(drive, s + h, x, v) - forces.sum() - f.drag * v)
                v += one * (_push(drive, s + h, x, trial) - forces.sum() - f.drag * trial)
    return out, force


@njit(cache=True)
def _slid(f, drive, mass, side, t, x, v, h):
    """Position and velocity after sliding one way for a time."""
    xs, vs = np.empty(4), np.empty(4)
    a, b = 0.0, 0.0
    for k in range(4):
        part = (0.0, 0.5, 0.5, 1.0)[k] * h
        xs[k] = v + part * b
        there = x + part * a
        level = _level(f, xs[k], 0.0)
        vs[k] = (_push(drive, t + part, there, xs[k]) - side * level - f.drag * xs[k]) / mass
        a, b = xs[k], vs[k]
    return (
        x + h / 6.0 * (xs[0] + 2.0 * (xs[1] + xs[2]) + xs[3]),
        v + h / 6.0 * (vs[0] + 2.0 * (vs[1] + vs[2]) + vs[3]),
    )


@njit(cache=True)
def _rigid(f, drive, mass, start, rows, sample, per):
    """As `_with_bristles`, with friction that holds the mass entirely, or not at all."""
    x, v = start[0], start[1]
    side = 1.0 if v > 0.0 else (-1.0 if v < 0.0 else 0.0)
    out, force = np.empty(rows), np.empty(rows)
    lead, h = round(LEAD / sample), sample / per
    most = _level(f, 0.0, 0.0)
    for i in range(lead + rows):
        t = (i - lead) * sample
        if i >= lead:
            out[i - lead], force[i - lead] = x, _push(drive, t, x, v)
        for j in range(per):
            s, left = t + j * h, h
            while left > 0.0:
                if side == 0.0:
                    now, then = _push(drive, s, x, 0.0), _push(drive, s + left, x, 0.0)
                    if abs(then) <= most:
                        break
                    used = 0.0 if abs(now) >= most else left * (most - abs(now)) / (abs(then) - abs(now))
                    used = min(max(used, 0.0), left)
                    s, left = s + used, left - used
                    side = 1.0 if then > 0.0 else -1.0
                    if left <= 1e-9 * h:
                        break
                there, faster = _slid(f, drive, mass, side, s, x, v, left)
                if side * faster >= 0.0:
                    x, v = there, faster
                    break
                low, high = 0.0, left
                for _ in range(50):
                    middle = 0.5 * (low + high)
                    if side * _slid(f, drive, mass, side, s, x, v, middle)[1] > 0.0:
                        low = middle
                    else:
                        high = middle
                x = _slid(f, drive, mass, side, s, x, v, high)[0]
                v, s, left = 0.0, s + high, left - high
                push = _push(drive, s, x, 0.0)
                if abs(push) <= most:
                    side = 0.0
                else:
                    side = 1.0 if push > 0.0 else -1.0
    return out, force


def slide(
    friction: Friction, drive: Drive, mass: float, rows: int, sample: float
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Position (m), force of the drive, or of friction where the motion is imposed (N), and the path that is followed,
    such as that of the end of the pulling spring (m), each (rows,)."""
    path, rate = (np.array([_path(drive, sample * k, order) for k in range(rows)]) for order in (0, 1))
    if drive.kind == IMPOSED and friction.law == COULOMB:
        level = np.array([_level(friction, v, 0.0) for v in rate])
        return path, np.sign(rate) * level + friction.drag * rate, path
    start = np.array([_path(drive, -LEAD, order) for order in (0, 1)])
    if drive.kind == OPEN_LOOP:
        start[:] = 0.0
    elif drive.kind == SPRING:
        start[1] = 0.0
    move = {COULOMB: _rigid, PRESLIDING: _with_elements}.get(friction.law, _with_bristles)
    x, force = move(friction, drive, mass, start, rows, sample, max(1, round(sample / STEP)))
    return x, force, path
