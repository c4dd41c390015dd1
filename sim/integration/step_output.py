"""What lies within a step: stage sums, dense output, the speed some time ago, and how far a step holds. Compiled."""

from __future__ import annotations

from typing import Any

from sim.integration import right_hand_side as axis_rates_module
from sim.integration import rodas5p, stage_sums
from sim.integration.right_hand_side import drive_at
from sim.integration.stage_sums import bends
from sim.numerics.compilation import INLINED, compile_function

HISTORY = 7
"""Numbers kept of a step to look back on: start, 1/length, and the velocity by powers of the part of the step."""
PAST_STEPS = 1 << 17
"""Steps kept to look back on, of a lag; more in one lag are too many. A power of two: places in the ring are masked."""
_SOURCES = [str(module.__file__) for module in (rodas5p, axis_rates_module, stage_sums)]


def _at_part(part, before, after, d0, d1, d2):
    """Dense output at a part of a step."""
    return (1.0 - part) * before + part * (after + (1.0 - part) * (d0 + part * (d1 + part * d2)))


at_part: Any = compile_function(_at_part, **INLINED)


def _keep(kept, t, over_h, before, after, d0, d1, d2):
    """Keep a step's dense output of the velocity, by powers of the part of the step, to look back on."""
    kept[0], kept[1], kept[2] = t, over_h, before
    kept[3], kept[4], kept[5], kept[6] = after - before + d0, d1 - d0, d2 - d1, -d2


keep: Any = compile_function(_keep, **INLINED)


def _past_speed(history, oldest, newest, t, start_velocity, rated, found):
    """Speed at a past time `t`, from the dense outputs kept, and its rate if `rated`; found = [speed, rate, entry]."""
    k, ring = oldest, history.shape[0] - 1
    if newest == 0 or t <= history[oldest & ring, 0]:
        found[0], found[1], found[2] = abs(start_velocity), 0.0, oldest
        return
    while k + 1 < newest and history[(k + 1) & ring, 0] <= t:
        k += 1
    at = history[k & ring]
    part = (t - at[0]) * at[1]
    v = at[2] + part * (at[3] + part * (at[4] + part * (at[5] + part * at[6])))
    found[0] = abs(v)
    found[2] = k
    if rated:
        rate = (at[3] + part * (2.0 * at[4] + part * (3.0 * at[5] + part * (4.0 * at[6])))) * at[1]
        found[1] = rate if v >= 0.0 else -rate


past_speed: Any = compile_function(_past_speed, **INLINED)


def _side_of_play(stretched, opening, gap, slack):
    """Which side of the play the spring rests on, and the edge there; at an edge, the side the motion turns to."""
    zone, edge = 0.0, 0.0
    if stretched > gap + 2.0 * slack or (stretched > gap - 2.0 * slack and opening > 0.0):
        zone, edge = 1.0, gap
    elif stretched < -gap - 2.0 * slack or (stretched < -gap + 2.0 * slack and opening < 0.0):
        zone, edge = 1.0, -gap
    return zone, edge


side_of_play: Any = compile_function(_side_of_play, _nrt=False)


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


def _edge_of_play(
    K, dense, size, t, h, y, fresh, direction, still, lag_at, drive_lag, knots, values, rates, wave, segment, spring,
    zone, edge, gap, slack,
):  # fmt: skip
    """Part of the step up to which the motion neither reverses nor leaves its side of the play; 1 for all of it."""
    bends(K, size, 0, dense)
    if drive_lag > 0.0:
        bends(K, size, lag_at, dense)
    if wave[0] == 0.0 or drive_lag > 0.0:
        # Between the ends of the step neither velocity nor stretch bulges by more than this.
        turn = 0.25 * (abs(dense[1, 0]) + abs(dense[1, 1]) + abs(dense[1, 2]))
        bulge = 0.25 * spring * (abs(dense[0, 0]) + abs(dense[0, 1]) + abs(dense[0, 2]))
        before = drive_at(t, knots, values, rates, wave, segment)[0]
        after = drive_at(t + h, knots, values, rates, wave, segment)[0]
        if drive_lag > 0.0:
            before, after = y[lag_at], fresh[lag_at]
            bulge += 0.25 * (abs(dense[lag_at, 0]) + abs(dense[lag_at, 1]) + abs(dense[lag_at, 2]))
        before -= spring * y[0]
        after -= spring * fresh[0]
        if zone == 0.0:
            room = gap - max(abs(before), abs(after))
        else:
            side = 1.0 if edge > 0.0 else -1.0
            room = min(side * before, side * after) - gap
        if room > bulge and min(direction * y[1], direction * fresh[1]) > turn:
            return 1.0
    good, bad = 0.0, 1.0
    search = 0
    for probe in range(1, 55):
        # Four looks along the step, then bisection.
        part = 0.25 * probe if search == 0 else 0.5 * (good + bad)
        out_of = direction * at_part(part, y[1], fresh[1], dense[1, 0], dense[1, 1], dense[1, 2]) < -still
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


edge_of_play: Any = compile_function(_edge_of_play, _SOURCES, _nrt=False)


def _reversal(v0, v1, d0, d1, d2, direction, still):
    """Part of the step up to which the motion does not reverse, just past it where it does; 1 for all of it.

    v0, v1, d0, d1, d2 are the dense output of the velocity. A reversal is a speed of more than `still` the other way.
    """
    # Between its ends the velocity bulges by no more than this.
    bulge = 0.25 * (abs(d0) + abs(d1) + abs(d2))
    if min(direction * v0, direction * v1) > bulge:
        return 1.0
    good, bad, above, below = 0.0, 1.0, direction * v0 + still, 0.0
    for probe in range(1, 5):
        part = 0.25 * probe
        found = direction * at_part(part, v0, v1, d0, d1, d2) + still
        if found < 0.0:
            bad, below = part, found
            break
        good, above = part, found
    if below == 0.0:
        return 1.0
    above, over = max(above, 0.0), below
    # Regula falsi, a stale end halved (Illinois), with a bisection now and then, until just past the reversal.
    side = 0
    for probe in range(60):
        if over > -0.1 * still or bad - good < 1e-15:
            break
        # Aimed just past the reversal.
        part = good + (bad - good) * min((above + 0.05 * still) / (above - below), 0.999)
        if probe % 8 == 7 or not good < part < bad:
            part = 0.5 * (good + bad)
        found = direction * at_part(part, v0, v1, d0, d1, d2) + still
        if found < 0.0:
            bad, below, over = part, found, found
            if side == 1:
                above *= 0.5
            side = 1
        else:
            good, above = part, found
            if side == -1:
                below *= 0.5
            side = -1
    return bad


reversal: Any = compile_function(_reversal, _SOURCES, _nrt=False)


def _fill(found, instants, t, over_h, before, end, d0, d1, d2):
    """Dense output at instants of a step that began at `t`, by powers of the part of the step."""
    c1, c2, c3 = end - before + d0, d1 - d0, d2 - d1
    for o in range(instants.size):
        part = (instants[o] - t) * over_h
        found[o] = before + part * (c1 + part * (c2 + part * (c3 - part * d2)))


fill: Any = compile_function(_fill, _nrt=False, fastmath={"contract"})


def _due_by(outputs, first, after):
    """The first output, from `first` on, that lies beyond `after`: by doubling, then halving."""
    count = outputs.size
    if first >= count or outputs[first] > after:
        return first
    low, stride = first, 1
    while low + stride < count and outputs[low + stride] <= after:
        low += stride
        stride *= 2
    high = min(low + stride, count)
    while high - low > 1:
        middle = (low + high) // 2
        if outputs[middle] <= after:
            low = middle
        else:
            high = middle
    return high


due_by: Any = compile_function(_due_by, _nrt=False)
