"""One step from row to row of each friction state model and of what it remembers, in scalars.

Each is the step that the model takes along a record (`along_record`), stated so that it can be translated to other
languages: assignments, conditions and arithmetic. `tests/sim/export` compares them with the models.
"""

import math

from sim.numerics.compilation import compiled

STATES = {"elasto_plastic_step": "stretch of the bristles, m"}
"""State of a step that is not the force of its bristles."""


@compiled
def coulomb_step(z: float, dx: float, level: float, stretch: float) -> tuple[float, float]:
    """Force of the stop operator; z is that force, N."""
    most = max(level, 0.0)
    z = min(max(z + most * dx / stretch, -most), most)
    return z, z


@compiled
def relax(z: float, dx: float, dt: float, mean: float, stiffness: float, damping: float) -> float:
    """Spring force of LuGre's bristles after a displacement at the mean level of the step, N."""
    if mean <= 0.0:
        return 0.0
    if dx == 0.0:
        return z
    end = mean if dx > 0.0 else -mean
    return end + (z - end) * math.exp(-stiffness * abs(dx) / (mean + damping * abs(dx) / dt))


def lugre_step(
    z: float, dx: float, dt: float, v: float, before: float, level: float, stiffness: float, damping: float
) -> tuple[float, float]:
    """Spring force z and force a0 z + a1 z' of LuGre's bristles, N."""
    z = relax(z, dx, dt, 0.5 * (level + before), stiffness, 0.0)
    rate = v - abs(v) * z / level if level > 0.0 else 0.0
    return z, z + damping * rate


def lugre_undamped_step(
    z: float, dx: float, dt: float, before: float, level: float, stiffness: float
) -> tuple[float, float]:
    """Spring force of LuGre's bristles without damping, N."""
    z = relax(z, dx, dt, 0.5 * (level + before), stiffness, 0.0)
    return z, z


def lugre_causal_step(
    z: float, dx: float, dt: float, v: float, before: float, level: float, stiffness: float, damping: float
) -> tuple[float, float]:
    """Spring force z and force of the causal bristles, N."""
    z = relax(z, dx, dt, 0.5 * (level + before), stiffness, damping)
    rate = (level * v - abs(v) * z) / (level + damping * abs(v)) if level > 0.0 else 0.0
    return z, z + damping * rate


@compiled
def dahl_step(
    z: float, dx: float, before: float, level: float, stiffness: float, exponent: float
) -> tuple[float, float]:
    """Force of Dahl's bristles, N."""
    mean = 0.5 * (level + before)
    if mean <= 0.0:
        return 0.0, 0.0
    if dx == 0.0:
        return z, z
    sign = 1.0 if dx > 0.0 else -1.0
    left = 1.0 - sign * z / mean
    way = stiffness * abs(dx) / mean
    if left <= 0.0 or exponent == 1.0:
        left = left * math.exp(-way)
    else:
        inner = left ** (1.0 - exponent) + (exponent - 1.0) * way
        left = inner ** (1.0 / (1.0 - exponent)) if inner > 0.0 else 0.0
    z = sign * mean * (1.0 - left)
    return z, z


@compiled
def plastic_slope(u: float, breakaway: float) -> float:
    """du/dxi of the elasto-plastic stretch u over its steady one, along a displacement xi over it."""
    if u >= 1.0:
        return 1.0 - u
    if u <= breakaway:
        return 1.0
    return 1.0 - u * (0.5 + 0.5 * math.sin(math.pi * (u - 0.5 * (1.0 + breakaway)) / (1.0 - breakaway)))


@compiled
def elasto_plastic_step(
    z: float, dx: float, v: float, level: float, stiffness: float, damping: float, breakaway: float
) -> tuple[float, float]:
    """Stretch z, m, and force of the elasto-plastic bristles, N, in Runge-Kutta steps of 0.05 of the steady stretch."""
    reach = level / stiffness
    if reach <= 0.0:
        return 0.0, 0.0
    if dx != 0.0:
        sign = 1.0 if dx > 0.0 else -1.0
        u = sign * z / reach
        left = abs(dx) / reach
        elastic = min(max(breakaway - u, 0.0), left)
        u = u + elastic
        left = left - elastic
        if left > 0.0 and u > 1.0:
            u = 1.0 + (u - 1.0) * math.exp(-left)
            left = 0.0
        while left > 0.0 and abs(1.0 - u) > 1e-12:
            h = min(0.05, left)
            one = plastic_slope(u, breakaway)
            two = plastic_slope(u + 0.5 * h * one, breakaway)
            three = plastic_slope(u + 0.5 * h * two, breakaway)
            u = u + h / 6.0 * (one + 2.0 * two + 2.0 * three + plastic_slope(u + h * three, breakaway))
            left = left - h
        z = sign * u * reach
    side = 1.0 if v > 0.0 else -1.0 if v < 0.0 else 0.0
    stress = side * z / reach
    alpha = 0.0
    if stress > breakaway:
        alpha = 0.5 + 0.5 * math.sin(math.pi * (min(stress, 1.0) - 0.5 * (1.0 + breakaway)) / (1.0 - breakaway))
    return z, stiffness * z + damping * v * (1.0 - alpha * stress)


def element_step(z: float, dx: float, level: float, stiffness: float, weight: float) -> float:
    """Force of one ideal element of Maxwell-slip, N."""
    most = max(level, 0.0) * weight
    return min(max(z + stiffness * dx, -most), most)


@compiled
def log_sum(a: float, b: float) -> float:
    """ln(e^a + e^b)."""
    most = max(a, b)
    return most + math.log1p(math.exp(min(a, b) - most))


@compiled
def creep(force: float, level: float, way: float, rest: float, width: float) -> float:
    """Force of rate-and-state after a displacement at constant velocity, N; what is below zero is left of it."""
    q = way / width
    gain = rest / width
    if abs(q) > 1e-9:
        gain = gain * -math.expm1(-q) / q
    start = (level - force) / width - q
    return level - width * (log_sum(start, math.log(gain)) if gain > 0.0 else start)


@compiled
def rate_and_state_step(
    z: float, dx: float, dt: float, level: float, stiffness: float, direct: float, speed: float
) -> tuple[float, float]:
    """Force of a contact of rate-and-state friction, N."""
    if level <= 0.0:
        return 0.0, 0.0
    way = stiffness * dx
    if z == 0.0 and way == 0.0:
        return 0.0, 0.0
    rest = stiffness * speed * dt
    side = 1.0 if z > 0.0 or (z == 0.0 and way >= 0.0) else -1.0
    end = creep(side * z, level, side * way, rest, direct * level)
    left = 0.0
    if end < 0.0:
        left = min(0.0, side * way + side * z) if side * way < 0.0 else 0.0
        end = 0.0
    z = side * end
    if left != 0.0:
        z = -side * max(creep(0.0, level, -left, rest * left / (side * way), direct * level), 0.0)
    return z, z


@compiled
def age_step(age: float, way: float, dt: float, memory_length: float) -> float:
    """Age of the contacts after a sliding distance, s: age' = 1 - |v| age/L, exact."""
    renewed = way / memory_length
    if renewed < 1e-9:
        return age + dt
    kept = math.exp(-renewed)
    return age * kept + dt * (1.0 - kept) / renewed


@compiled
def play_step(output: float, position: float, half: float) -> float:
    """Position behind a play of the half width, m."""
    if position - output > half:
        return position - half
    if output - position > half:
        return position + half
    return output


def lag_step(output: float, before: float, now: float, dt: float, time_constant: float) -> float:
    """First-order lag of an input that is linear over the step."""
    if dt <= 0.0:
        return output
    ratio = dt / time_constant
    decay = math.exp(-ratio)
    ramp = (1.0 - decay) / ratio
    return decay * output + (ramp - decay) * before + (1.0 - ramp) * now
