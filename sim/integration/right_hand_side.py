"""The drive's force, and the rates of change of all states of an axis, in compiled code."""

from __future__ import annotations

import math
from typing import Any

from sim.numerics.compilation import INLINED, compile_function


def _drive_at(t, knots, values, rates, wave, segment):
    """The drive's value and rate of change."""
    value = values[segment] + rates[segment] * (t - knots[segment])
    rate = rates[segment]
    if wave[0] != 0.0:
        value += wave[0] * math.cos(wave[1] * t + wave[2])
        rate -= wave[0] * wave[1] * math.sin(wave[1] * t + wave[2])
    return value, rate


drive_at: Any = compile_function(_drive_at, **INLINED)


def _right_side(
    t, y, direction, head, n, riders, drive_lag, here, elements, modes, body, knots, values, rates, wave, segment, zone,
    edge, worked, f,
):  # fmt: skip
    """Rates f of all states, once `axis_forces` has been called; gives the drive's push and the riders' force."""
    per_mass, spring, feedback, memory_length = body[0], body[1], body[2], body[3]
    at = head + n
    v = y[1]
    f[0] = v
    if head > 2:
        f[2] = direction * v
        f[3] = 1.0 - direction * v * y[3] / memory_length
    for k in range(n):
        f[head + k] = elements[k, 0]
    reaction = 0.0
    for o in range(riders):
        pulled = modes[o, 0] * (y[0] - y[at]) - modes[o, 1] * y[at + 1]
        f[at], f[at + 1] = y[at + 1], pulled
        reaction += modes[o, 2] * pulled
        at += 2
    pull, _ = drive_at(t, knots, values, rates, wave, segment)
    if drive_lag > 0.0:
        f[at] = (pull - y[at]) / drive_lag
        pull = y[at]
        at += 1
    push = zone * (pull - spring * y[0] - edge)
    f[1] = (push - feedback * (here[1] + here[2] + here[3] + reaction)) * per_mass
    if worked:
        f[at], f[at + 1], f[at + 2] = here[1] * v, (here[2] + here[3] + reaction) * v, push * v
    return push, reaction


right_side: Any = compile_function(_right_side, **INLINED)
