"""What lies within a step: stage sums, dense output, the speed some time ago, and how far a step holds. Compiled."""

from __future__ import annotations

from typing import Any

from sim import axis_rates as axis_rates_module
from sim import rodas5p
from sim.axis_rates import drive_at
from sim.compilation import compile_function
from sim.rodas5p import STAGES, H

HISTORY = 7
"""Numbers kept of a step to look back on: start, length, velocity at both ends, dense output of the velocity."""
PAST_STEPS = 100_000
"""Steps kept to look back on, of a lag; more in one lag are too many."""
_SOURCES = [rodas5p.__file__, axis_rates_module.__file__]


def _weighted(table, i, K, j):
    """sum_m table[i, m] K[m, j], of fixed length so that it is unrolled: the table is zero where K is still unknown."""
    total = 0.0
    for m in range(STAGES):
        total += table[i, m] * K[STAGES * j + m]
    return total


weighted: Any = compile_function(_weighted, _SOURCES, inline="always")


def _at_part(part, before, after, d0, d1, d2):
    """Dense output at a part of a step."""
    return (1.0 - part) * before + part * (after + (1.0 - part) * (d0 + part * (d1 + part * d2)))


at_part: Any = compile_function(_at_part, _SOURCES, _nrt=False)


def _dense(K, which, dense):
    """Coefficients of one state's dense output."""
    for m in range(3):
        dense[which, m] = weighted(H, m, K, which)


dense_of: Any = compile_function(_dense, _SOURCES, _nrt=False)


def _past_speed(history, oldest, newest, t, start_velocity, found):
    """Speed and its rate at a past time `t`, from the dense outputs kept; found = [speed, rate, entry]."""
    k, room = oldest, history.shape[0]
    if newest == 0 or t <= history[oldest % room, 0]:
        found[0], found[1], found[2] = abs(start_velocity), 0.0, oldest
        return
    while k + 1 < newest and history[(k + 1) % room, 0] <= t:
        k += 1
    at = k % room
    h = history[at, 1]
    part = (t - history[at, 0]) / h
    v0, v1, d0, d1, d2 = history[at, 2], history[at, 3], history[at, 4], history[at, 5], history[at, 6]
    v = at_part(part, v0, v1, d0, d1, d2)
    bend = d0 + part * (d1 + part * d2)
    rate = (v1 - v0 + (1.0 - 2.0 * part) * bend + part * (1.0 - part) * (d1 + 2.0 * part * d2)) / h
    found[0] = abs(v)
    found[1] = rate if v >= 0.0 else -rate
    found[2] = k


past_speed: Any = compile_function(_past_speed, _SOURCES, _nrt=False)


def _left(
    part, t, h, y, fresh, dense, lag_at, drive_lag, knots, values, rates, wave, segment, spring, zone, edge, gap, slack
):
    """Whether the spring has left its side of the play at a part of a step."""
    if drive_lag > 0.0:
        pull = at_part(part, y[lag_at], fresh[lag_at], dense[lag_at, 0], dense[lag_at, 1], dense[lag_at, 2])
    else:
        pull, _ = drive_at(t + part * h, knots, values, rates, wave, segment)
    stretched = pull - spring * at_part(part, y[0], fresh[0], dense[0, 0], dense[0, 1], dense[0, 2])
    if zone == 0.0:
        return abs(stretched) > gap + 3.0 * slack
    return stretched < gap - 3.0 * slack if edge > 0.0 else stretched > -gap + 3.0 * slack


_left = compile_function(_left, _SOURCES, _nrt=False)


def _holds(
    K, dense, t, h, y, fresh, direction, still, lag_at, drive_lag, knots, values, rates, wave, segment, spring, zone,
    edge, gap, slack,
):  # fmt: skip
    """Part of the step up to which the motion neither reverses nor leaves its side of the play; 1 for all of it."""
    dense_of(K, 1, dense)
    # Between its ends the velocity bulges by no more than this.
    bulge = 0.25 * (abs(dense[1, 0]) + abs(dense[1, 1]) + abs(dense[1, 2]))
    if gap == 0.0 and min(direction * y[1], direction * fresh[1]) > bulge:
        return 1.0
    if gap > 0.0:
        dense_of(K, 0, dense)
        if drive_lag > 0.0:
            dense_of(K, lag_at, dense)
    good, bad = 0.0, 1.0
    search = 0
    for probe in range(1, 55):
        # Four looks along the step, then bisection.
        part = 0.25 * probe if search == 0 else 0.5 * (good + bad)
        out_of = direction * at_part(part, y[1], fresh[1], dense[1, 0], dense[1, 1], dense[1, 2]) < -still
        if gap > 0.0:
            out_of = out_of or _left(
                part, t, h, y, fresh, dense, lag_at, drive_lag, knots, values, rates, wave, segment, spring, zone, edge,
                gap, slack,
            )  # fmt: skip
        if out_of:
            bad, search = part, 1
        else:
            good = part
            if search == 0 and probe == 4:
                return 1.0
    return bad


holds: Any = compile_function(_holds, _SOURCES, _nrt=False)
