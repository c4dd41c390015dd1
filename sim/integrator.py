"""Adaptive stiff integration of one axis: Rodas5P with the exact Jacobian, compiled once for every model.

State y = [position, velocity, (travelled, contact age) | z_1 .. z_n | x, v of each rider | lagged drive | works of
core, other forces, drive]; the two in brackets only where a law depends on them. What follows the head meets the rest
only through position, velocity and friction level, so W = I/(gamma h) - J is an arrowhead with a small head: one
linear solve costs O(number of states), and one stage O(number of effects).

Two things keep kinks from doing harm. A drive that is linear in pieces is stepped from knot to knot. And within a step
every law is continued smoothly past a reversal (or past the edge of a play): the direction of the motion is held, so
that |v| stays smooth. The step is then accepted up to the moment of the reversal alone, found on its dense output.

This module imports numba: import it only when something is integrated.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from sim import axis_forces as axis_forces_module
from sim import axis_rates as axis_rates_module
from sim import kernel_calls, rodas5p
from sim import step_output as step_output_module
from sim import tangent_step as tangent_step_module
from sim.axis_forces import BY, NAXIS, OUT, axis_forces
from sim.axis_rates import drive_at, right_side
from sim.compilation import compile_function
from sim.rodas5p import GAMMA, STAGES, TIME, TIME_SLOPE, A, C
from sim.step_output import HISTORY, PAST_STEPS, at_part, dense_of, holds, past_speed
from sim.tangent_step import EASY, advance, spread

DONE, STEP_TOO_SMALL, NOT_FINITE, TOO_MANY_STEPS = 0, 1, 2, 3
NWORK = 3


def _steps(
    start, head, outputs, knots, values, rates, wave, body, modes, effects, groups, n, base, relative, absolute,
    longest, most_steps, states, forces, report, work, addresses, history, tangent,
):  # fmt: skip
    """All of the integration, in arrays that are given: `work` as `_integrate` makes it. Compiled without counting of
    references, which would cost more than the arithmetic."""
    (
        y, fresh, stage, earlier, z, K, dense, f, f_start, ft, axis, laws, elements, here, slope, by_head, own, into,
        ratio, work_head, work_z, row, effective, past,
    ) = work  # fmt: skip
    per_mass, spring, feedback, memory_length, gap, drive_lag, delay = body
    size = start.size
    first_mode = head + n
    lag_at = first_mode + 2 * modes.shape[0]
    tail = lag_at + (1 if drive_lag > 0.0 else 0)
    worked = size > tail
    kept = states.shape[0]
    oldest, newest = 0, 0
    core_count = groups[0, 3]
    counted = 0
    for j in range(size):
        if absolute[j] < math.inf:
            counted += 1

    t = outputs[0]
    end = outputs[outputs.size - 1]
    next_output = 0
    segment = 0
    while segment + 1 < rates.size and knots[segment + 1] <= t:
        segment += 1
    direction = 1.0 if y[1] >= 0.0 else -1.0
    quiet = 1e-3 * absolute[1]
    slack = 1e-3 * absolute[0] * spring
    if delay > 0.0:
        longest = min(longest, delay)
    h = min(longest, max((end - t) * 1e-6, 1e-12))
    steps, rejected, cuts = 0, 0, 0
    was_rejected = False
    taken, error_taken = 0.0, 1.0
    outcome = DONE

    while t < end:
        if steps + rejected >= most_steps:
            outcome = TOO_MANY_STEPS
            break
        # The end of this stretch of smooth drive.
        stop = end
        if segment + 1 < rates.size and knots[segment + 1] < end:
            stop = knots[segment + 1]
        wanted = h
        lands = False
        if t + 1.0001 * h >= stop:
            h = stop - t
            lands = True

        # Right side and Jacobian at the start of the step.
        for k in range(n):
            z[k] = y[head + k]
        v = y[1]
        s_here, s_rate = drive_at(t, knots, values, rates, wave, segment)
        pull = y[lag_at] if drive_lag > 0.0 else s_here
        pull_rate = (s_here - y[lag_at]) / drive_lag if drive_lag > 0.0 else s_rate
        zone = 1.0
        edge = 0.0
        if gap > 0.0:
            # Which side of the play the spring rests on; at an edge, the side the motion turns to.
            stretched = pull - spring * y[0]
            opening = pull_rate - spring * v
            if stretched > gap + 2.0 * slack or (stretched > gap - 2.0 * slack and opening > 0.0):
                zone, edge = 1.0, gap
            elif stretched < -gap - 2.0 * slack or (stretched < -gap + 2.0 * slack and opening < 0.0):
                zone, edge = 1.0, -gap
            else:
                zone, edge = 0.0, 0.0
        if delay > 0.0:
            past_speed(history, oldest, newest, t - delay, start[1], past)
            oldest = int(past[2])
        if abs(v) > 2.0 * quiet:
            direction = 1.0 if v > 0.0 else -1.0
        for turn in range(2):
            axis_forces(
                t,
                y,
                z,
                head,
                direction,
                past[0],
                past[1],
                1,
                base,
                effects,
                groups,
                addresses,
                axis,
                laws,
                elements,
                here,
                slope,
            )
            push, reaction = right_side(
                t, y, direction, head, n, here, elements, modes, body, knots, values, rates, wave, segment, zone, edge,
                worked, f_start,
            )  # fmt: skip
            # At a reversal the motion goes the way it is accelerated.
            if turn == 1 or abs(v) > 2.0 * quiet or f_start[1] * direction >= 0.0:
                break
            direction = -direction
        for j in range(head):
            row[j] = -feedback * (slope[1, j] + slope[2, j] + slope[3, j]) * per_mass
        row[0] -= zone * spring * per_mass
        for j in range(size):
            ft[j] = 0.0
        ft[1] = -feedback * (slope[1, 4] + slope[2, 4] + slope[3, 4]) * per_mass
        if drive_lag > 0.0:
            ft[lag_at] = s_rate / drive_lag
        else:
            ft[1] += zone * s_rate * per_mass
        for k in range(n):
            own[k] = elements[k, 2]
            into[k] = -feedback * elements[k, 5] * per_mass
            for j in range(head):
                by_head[k, j] = elements[k, 4] * slope[0, j]
            by_head[k, 1] += elements[k, 3]
            ft[head + k] = elements[k, 4] * slope[0, 4]
        if worked:
            for j in range(head):
                work_head[0, j] = slope[1, j] * v
                work_head[1, j] = (slope[2, j] + slope[3, j]) * v
                work_head[2, j] = 0.0
            work_head[0, 1] += here[1]
            work_head[1, 1] += here[2] + here[3] + reaction
            work_head[2, 1] += push
            work_head[2, 0] = -zone * spring * v
            for i in range(modes.shape[0]):
                work_head[1, 0] += modes[i, 2] * modes[i, 0] * v
            for k in range(n):
                work_z[k] = elements[k, 5] * v
            ft[tail] = slope[1, 4] * v
            ft[tail + 1] = (slope[2, 4] + slope[3, 4]) * v
            ft[tail + 2] = 0.0 if drive_lag > 0.0 else zone * s_rate * v
        age_out, age_own = 0.0, 0.0
        if head > 2:
            age_out = -direction * y[3] / memory_length
            age_own = -direction * v / memory_length

        part, shortened = 1.0, 0
        while True:
            s = 1.0 / (GAMMA * h)
            over_s, over_h = GAMMA * h, 1.0 / h
            for j in range(head):
                effective[j] = row[j]
            for k in range(n):
                ratio[k] = 1.0 / (s - own[k])
                for j in range(head):
                    effective[j] += into[k] * by_head[k, j] * ratio[k]
            pivot = s - effective[1]
            for i in range(modes.shape[0]):
                back = modes[i, 0] * over_s + modes[i, 1]
                effective[0] -= feedback * modes[i, 2] * per_mass * modes[i, 0] * (1.0 - back / (s + back))
            pivot -= effective[0] * over_s
            over_age = 0.0
            if head > 2:
                over_age = 1.0 / (s - age_own)
                pivot -= effective[2] * direction * over_s + effective[3] * age_out * over_age
            over_pivot = 1.0 / pivot
            over_lag = 1.0 / (s + 1.0 / drive_lag) if drive_lag > 0.0 else 0.0
            finite = True
            for i in range(STAGES):
                if i == 0:
                    for j in range(size):
                        f[j] = f_start[j] + h * TIME_SLOPE[0] * ft[j]
                else:
                    at = t + TIME[i] * h
                    for j in range(size):
                        past_a, past_c = 0.0, 0.0
                        for m in range(STAGES):
                            past_a += A[i, m] * K[STAGES * j + m]
                            past_c += C[i, m] * K[STAGES * j + m]
                        stage[j] = y[j] + past_a
                        earlier[j] = past_c * over_h
                    for k in range(n):
                        z[k] = stage[head + k]
                    if delay > 0.0:
                        past_speed(history, oldest, newest, at - delay, start[1], past)
                    axis_forces(
                        at, stage, z, head, direction, past[0], past[1], 0, base, effects, groups, addresses, axis,
                        laws, elements, here, slope,
                    )  # fmt: skip
                    right_side(
                        at, stage, direction, head, n, here, elements, modes, body, knots, values, rates, wave, segment,
                        zone, edge, worked, f,
                    )  # fmt: skip
                    late = h * TIME_SLOPE[i]
                    for j in range(size):
                        f[j] += earlier[j] + late * ft[j]
                # Solve W k = f: what is not the velocity is eliminated first.
                right = f[1] + effective[0] * f[0] * over_s
                if head > 2:
                    right += effective[2] * f[2] * over_s + effective[3] * f[3] * over_age
                for k in range(n):
                    right += into[k] * f[head + k] * ratio[k]
                for o in range(modes.shape[0]):
                    back = modes[o, 0] * over_s + modes[o, 1]
                    f2, g2 = f[first_mode + 2 * o], f[first_mode + 2 * o + 1]
                    moved = (g2 - modes[o, 0] * over_s * f2) / (s + back)
                    right += feedback * modes[o, 2] * per_mass * (modes[o, 0] * over_s * f2 + back * moved)
                if drive_lag > 0.0:
                    f[lag_at] *= over_lag
                    right += zone * f[lag_at] * per_mass
                kv = right * over_pivot
                f[1] = kv
                f[0] = (f[0] + kv) * over_s
                if head > 2:
                    f[2] = (f[2] + direction * kv) * over_s
                    f[3] = (f[3] + age_out * kv) * over_age
                for k in range(n):
                    total = f[head + k]
                    for j in range(head):
                        total += by_head[k, j] * f[j]
                    f[head + k] = total * ratio[k]
                for o in range(modes.shape[0]):
                    back = modes[o, 0] * over_s + modes[o, 1]
                    f2, g2 = f[first_mode + 2 * o], f[first_mode + 2 * o + 1]
                    v2 = (g2 + modes[o, 0] * (f[0] - over_s * f2)) / (s + back)
                    f[first_mode + 2 * o + 1] = v2
                    f[first_mode + 2 * o] = (f2 + v2) * over_s
                if worked:
                    for w in range(NWORK):
                        total = f[tail + w]
                        for j in range(head):
                            total += work_head[w, j] * f[j]
                        if w == 0:
                            for k in range(core_count):
                                total += work_z[k] * f[head + k]
                        elif w == 1:
                            for k in range(core_count, n):
                                total += work_z[k] * f[head + k]
                            for o in range(modes.shape[0]):
                                x2, v2 = f[first_mode + 2 * o], f[first_mode + 2 * o + 1]
                                total -= v * modes[o, 2] * (modes[o, 0] * x2 + modes[o, 1] * v2)
                        elif drive_lag > 0.0:
                            total += zone * v * f[lag_at]
                        f[tail + w] = total * over_s
                if not math.isfinite(kv):
                    finite = False
                    break
                for j in range(size):
                    K[STAGES * j + i] = f[j]
            error = math.inf
            if finite:
                error = 0.0
                for j in range(size):
                    fresh[j] = stage[j] + f[j]
                    scale = absolute[j] + relative * max(abs(y[j]), abs(fresh[j]))
                    off = f[j] / scale
                    error += off * off
                error = math.sqrt(error / counted)
                if not math.isfinite(error):
                    error = math.inf
            if error <= 1.0:
                part = holds(
                    K, dense, t, h, y, fresh, direction, 3.0 * quiet, lag_at, drive_lag, knots, values, rates, wave,
                    segment, spring, zone, edge, gap, slack,
                )  # fmt: skip
                if part == 1.0:
                    break
                lands = False
                if shortened == 4 or part > 0.9:
                    cuts += 1
                    break
                # Dense output alone is not good enough within a step that was long for its stiffness.
                h *= 1.01 * part
                shortened += 1
                continue
            if not finite:
                for j in range(size):
                    for m in range(STAGES):
                        K[STAGES * j + m] = 0.0
            rejected += 1
            was_rejected = True
            lands = False
            h *= 0.25 if error == math.inf else max(0.2, 0.9 * error**-0.2)
            wanted = h
            if h < 1e-14 * max(1.0, abs(t)) or not h > 0.0:
                outcome = STEP_TOO_SMALL if finite else NOT_FINITE
                break
            if steps + rejected >= most_steps:
                outcome = TOO_MANY_STEPS
                break
        if outcome != DONE:
            break

        steps += 1
        after = stop if lands else t + part * h
        due = next_output
        while due < outputs.size and outputs[due] <= after:
            due += 1
        if part < 1.0 or due > next_output or tangent is not None:
            for j in range(size if part < 1.0 or tangent is not None else kept):
                dense_of(K, j, dense)
        block = outputs[next_output:due]
        for j in range(kept):
            found = states[j, next_output:due]
            before, end_of, d0, d1, d2 = y[j], fresh[j], dense[j, 0], dense[j, 1], dense[j, 2]
            for o in range(block.size):
                share = (block[o] - t) * over_h
                rest = 1.0 - share
                found[o] = rest * before + share * (end_of + rest * (d0 + share * (d1 + share * d2)))
        if tangent is not None:
            parameters, by_effect, by_group, derived, derived_at, S, K5, before_step, u, fp, sensed = tangent
            inside = due > next_output and outputs[next_output] < after
            advance(
                t, h, part, y, fresh, dense, direction, head, n, body, base, effects, groups, addresses, axis, laws,
                elements, here, slope, stage, z, knots, values, rates, wave, segment, parameters, by_effect, by_group,
                derived, derived_at[0], row, by_head, into, own, past, ratio, effective, u, fp, S, K5, before_step,
                inside, error < EASY,
            )  # fmt: skip
            spread(S, K5, before_step, block, t, part * h, sensed[:, :, next_output:due])
        if forces.shape[0] > 0:
            for o in range(next_output, due):
                at = outputs[o]
                for k in range(n):
                    z[k] = states[head + k, o]
                if delay > 0.0:
                    past_speed(history, oldest, newest, at - delay, start[1], past)
                for j in range(size):
                    stage[j] = states[j, o]
                axis_forces(
                    at, stage, z, head, direction, past[0], past[1], 0, base, effects, groups, addresses, axis, laws,
                    elements, here, slope,
                )  # fmt: skip
                s_here, _ = drive_at(at, knots, values, rates, wave, segment)
                pull = states[lag_at, o] if drive_lag > 0.0 else s_here
                forces[o, 0], forces[o, 1] = here[0], here[1]
                forces[o, 2] = here[2] + here[3]
                forces[o, 3] = zone * (pull - spring * states[0, o] - edge)
        next_output = due
        if delay > 0.0:
            if newest - oldest == history.shape[0]:
                outcome = TOO_MANY_STEPS
                break
            k = newest % history.shape[0]
            history[k, 0], history[k, 1], history[k, 2], history[k, 3] = t, h, y[1], fresh[1]
            history[k, 4], history[k, 5], history[k, 6] = dense[1, 0], dense[1, 1], dense[1, 2]
            newest += 1
        for j in range(size):
            y[j] = at_part(part, y[j], fresh[j], dense[j, 0], dense[j, 1], dense[j, 2]) if part < 1.0 else fresh[j]
        t = after
        factor = min(6.0, 0.9 * max(error, 1e-6) ** -0.2)
        if taken > 0.0:
            # Gustafsson's controller: a rise of the error over the last two steps is expected to go on.
            factor = min(factor, 0.9 * h / taken * (error_taken / max(error, 1e-6) ** 2) ** 0.2)
        taken, error_taken = h, max(error, 1e-2)
        if was_rejected:
            factor = min(factor, 1.0)
        was_rejected = False
        h = min(longest, max(h * factor, wanted if factor >= 1.0 else 0.0))
        if lands and segment + 1 < rates.size and knots[segment + 1] <= t:
            segment += 1

    report[0], report[1], report[2], report[3], report[4] = outcome, t, steps, rejected, cuts
    for j in range(size):
        report[5 + j] = y[j]


_SOURCES = [
    str(module.__file__)
    for module in (
        rodas5p,
        kernel_calls,
        axis_forces_module,
        axis_rates_module,
        step_output_module,
        tangent_step_module,
    )
]
_compiled_steps = compile_function(_steps, _SOURCES, _nrt=False, fastmath={"contract"})


def _integrate(
    start, head, outputs, knots, values, rates, wave, body, modes, effects, groups, n, base, relative, absolute,
    longest, most_steps, states, forces, report, tangent,
):  # fmt: skip
    """Integrate from the first to the last of `outputs`; see `sim.plan` for what the arrays hold."""
    size, m = start.size, max(n, 1)
    axis, laws, z, elements = np.zeros(NAXIS), np.zeros(3 * OUT + OUT), np.zeros(m), np.zeros((m, 8))
    work = (
        start.copy(), np.zeros(size), np.zeros(size), np.zeros(size), z, np.zeros(STAGES * size), np.zeros((size, 3)),
        np.zeros(size), np.zeros(size), np.zeros(size), axis, laws, elements, np.zeros(4), np.zeros((4, BY)),
        np.zeros((m, 4)), np.zeros(m), np.zeros(m), np.zeros(m), np.zeros((NWORK, 4)), np.zeros(m), np.zeros(4),
        np.zeros(4), np.zeros(3),
    )  # fmt: skip
    addresses = (axis.ctypes.data, laws.ctypes.data, z.ctypes.data, elements.ctypes.data)
    history = np.zeros((PAST_STEPS if body[6] > 0.0 else 1, HISTORY))
    _compiled_steps(
        start, head, outputs, knots, values, rates, wave, body, modes, effects, groups, n, base, relative, absolute,
        longest, most_steps, states, forces, report, work, addresses, history, tangent,
    )  # fmt: skip


integrate: Any = compile_function(_integrate, _SOURCES, nogil=True)
"""The compiled integration; `report` = [outcome, time, steps, rejected, reversals cut to, *state]."""
