"""The Jacobian of an axis and its linear solve, in compiled code.

What follows the head (position, velocity, travelled, age) meets the rest through position, velocity and friction level
alone, so W = I/(gamma h) - J is an arrowhead: everything but the velocity is eliminated in one pass, and one solve
costs O(number of states).
"""

from __future__ import annotations

from typing import Any

from sim.numerics.compilation import INLINED, compile_function

NWORK = 3


def _assemble(
    y, direction, head, n, riders, drive_lag, worked, zone, s_rate, push, reaction, here, elements, slope, modes, body,
    row, own, into, by_head, work_head, work_z, ft,
):  # fmt: skip
    """The entries of J, and df/dt, at the start of a step: row (velocity by the head), own, into and by_head (elements
    by themselves, velocity by them, they by the head), and the works by head and elements."""
    per_mass, spring, feedback = body[0], body[1], body[2]
    v = y[1]
    tail = head + n + 2 * riders
    for j in range(head):
        row[j] = -feedback * (slope[1, j] + slope[2, j] + slope[3, j]) * per_mass
        ft[j] = 0.0
    row[0] -= zone * spring * per_mass
    ft[1] = -feedback * (slope[1, 4] + slope[2, 4] + slope[3, 4]) * per_mass
    for k in range(n):
        own[k] = elements[k, 2]
        into[k] = -feedback * elements[k, 5] * per_mass
        for j in range(head):
            by_head[k, j] = elements[k, 4] * slope[0, j]
        by_head[k, 1] += elements[k, 3]
        ft[head + k] = elements[k, 4] * slope[0, 4]
    for i in range(2 * riders):
        ft[head + n + i] = 0.0
    if drive_lag > 0.0:
        ft[tail] = s_rate / drive_lag
        tail += 1
    else:
        ft[1] += zone * s_rate * per_mass
    if worked:
        for j in range(head):
            work_head[0, j] = slope[1, j] * v
            work_head[1, j] = (slope[2, j] + slope[3, j]) * v
            work_head[2, j] = 0.0
        work_head[0, 1] += here[1]
        work_head[1, 1] += here[2] + here[3] + reaction
        work_head[2, 1] += push
        work_head[2, 0] = -zone * spring * v
        for i in range(riders):
            work_head[1, 0] += modes[i, 2] * modes[i, 0] * v
        for k in range(n):
            work_z[k] = elements[k, 5] * v
        ft[tail] = slope[1, 4] * v
        ft[tail + 1] = (slope[2, 4] + slope[3, 4]) * v
        ft[tail + 2] = 0.0 if drive_lag > 0.0 else zone * s_rate * v


def _factorise(
    h, gamma, direction, head, n, riders, drive_lag, age_out, age_own, modes, body, row, own, into, by_head, ratio,
    effective,
):  # fmt: skip
    """Eliminate all but the velocity from W; s = 1/(gamma h), 1/s, 1/pivot, 1/(s - age_own), 1/(s + 1/drive_lag).

    `ratio` is 1/pivot of each element, then of each rider's velocity.
    """
    per_mass, feedback = body[0], body[2]
    s, over_s = 1.0 / (gamma * h), gamma * h
    for j in range(head):
        effective[j] = row[j]
    for k in range(n):
        ratio[k] = 1.0 / (s - own[k])
        for j in range(head):
            effective[j] += into[k] * by_head[k, j] * ratio[k]
    pivot = s - effective[1]
    for i in range(riders):
        back = modes[i, 0] * over_s + modes[i, 1]
        ratio[n + i] = 1.0 / (s + back)
        effective[0] -= feedback * modes[i, 2] * per_mass * modes[i, 0] * (1.0 - back * ratio[n + i])
    pivot -= effective[0] * over_s
    over_age = 0.0
    if head > 2:
        over_age = 1.0 / (s - age_own)
        pivot -= effective[2] * direction * over_s + effective[3] * age_out * over_age
    over_lag = 1.0 / (s + 1.0 / drive_lag) if drive_lag > 0.0 else 0.0
    return s, over_s, 1.0 / pivot, over_age, over_lag


def _solve(
    f, v, direction, head, n, riders, cores, drive_lag, worked, zone, s, over_s, over_pivot, over_age, over_lag,
    age_out, modes, body, into, by_head, ratio, effective, work_head, work_z,
):  # fmt: skip
    """Solve W k = f in place."""
    per_mass, feedback = body[0], body[2]
    first_mode = head + n
    tail = first_mode + 2 * riders
    right = f[1] + effective[0] * f[0] * over_s
    if head > 2:
        right += effective[2] * f[2] * over_s + effective[3] * f[3] * over_age
    for k in range(n):
        right += into[k] * f[head + k] * ratio[k]
    for o in range(riders):
        back = modes[o, 0] * over_s + modes[o, 1]
        f2, g2 = f[first_mode + 2 * o], f[first_mode + 2 * o + 1]
        moved = (g2 - modes[o, 0] * over_s * f2) * ratio[n + o]
        right += feedback * modes[o, 2] * per_mass * (modes[o, 0] * over_s * f2 + back * moved)
    if drive_lag > 0.0:
        f[tail] *= over_lag
        right += zone * f[tail] * per_mass
    kv = right * over_pivot
    f[1] = kv
    f[0] = (f[0] + kv) * over_s
    if head > 2:
        f[2] = (f[2] + direction * kv) * over_s
        f[3] = (f[3] + age_out * kv) * over_age
    for k in range(n):
        total = f[head + k] + (by_head[k, 0] * f[0] + by_head[k, 1] * f[1])
        if head > 2:
            total += by_head[k, 2] * f[2] + by_head[k, 3] * f[3]
        f[head + k] = total * ratio[k]
    for o in range(riders):
        back = modes[o, 0] * over_s + modes[o, 1]
        f2, g2 = f[first_mode + 2 * o], f[first_mode + 2 * o + 1]
        v2 = (g2 + modes[o, 0] * (f[0] - over_s * f2)) * ratio[n + o]
        f[first_mode + 2 * o + 1] = v2
        f[first_mode + 2 * o] = (f2 + v2) * over_s
    if worked:
        lagged = 0.0
        if drive_lag > 0.0:
            lagged = f[tail]
            tail += 1
        for w in range(NWORK):
            total = f[tail + w]
            for j in range(head):
                total += work_head[w, j] * f[j]
            if w == 0:
                for k in range(cores):
                    total += work_z[k] * f[head + k]
            elif w == 1:
                for k in range(cores, n):
                    total += work_z[k] * f[head + k]
                for o in range(riders):
                    x2, v2 = f[first_mode + 2 * o], f[first_mode + 2 * o + 1]
                    total -= v * modes[o, 2] * (modes[o, 0] * x2 + modes[o, 1] * v2)
            else:
                total += zone * v * lagged
            f[tail + w] = total * over_s
    return kv


assemble: Any = compile_function(_assemble, **INLINED)
factorise: Any = compile_function(_factorise, **INLINED)
solve: Any = compile_function(_solve, **INLINED)
