"""Adaptive stiff integration of one axis: Rodas5P with the exact Jacobian, in compiled code.

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

from sim.integration import arrowhead as arrowhead_module
from sim.integration import axis_forces as axis_forces_module
from sim.integration import kernel_calls, rodas5p
from sim.integration import right_hand_side as axis_rates_module
from sim.integration import stage_sums as stage_sums_module
from sim.integration import step_output as step_output_module
from sim.integration.arrowhead import NWORK, assemble, factorise, solve
from sim.integration.axis_forces import BY, NAXIS, OUT, axis_forces, values_at
from sim.integration.right_hand_side import drive_at, right_side
from sim.integration.rodas5p import GAMMA, STAGES, TIME, TIME_SLOPE
from sim.integration.stage_sums import bends, stage_sums
from sim.integration.step_output import (
    HISTORY,
    PAST_STEPS,
    at_part,
    due_by,
    edge_of_play,
    fill,
    keep,
    past_speed,
    reversal,
    side_of_play,
)
from sim.numerics.compilation import compile_function

DONE, STEP_TOO_SMALL, NOT_FINITE, TOO_MANY_STEPS = 0, 1, 2, 3


def _steps(
    start, outputs, knots, values, rates, wave, body, shape, modes, effects, groups, at_once, base, relative, absolute,
    longest, most_steps, states, forces, report, work, history,
):  # fmt: skip
    """All of the integration, in arrays that are given: `work` as `_integrate` makes it. Compiled without counting of
    references, which would cost more than the arithmetic; and once more for the plain axis, `shape` None, whose sizes
    are then known while it is compiled."""
    (
        y, fresh, stage, earlier, K, dense, f_start, ft, axis, laws, elements, here, slope, by_head, own, into,
        ratio, work_head, work_z, row, effective, past,
    ) = work  # fmt: skip
    spring, memory_length = body[1], body[3]
    if shape is None:
        head, n, riders, cores, beside, worked, size = 2, 1, 0, 1, 0, False, 3
        gap, drive_lag, delay = 0.0, 0.0, 0.0
    else:
        head, n = shape
        riders, cores, beside = modes.shape[0], groups[0, 3], groups.shape[0] - 1
        gap, drive_lag, delay = body[4], body[5], body[6]
        size = start.size
        worked = size > head + n + 2 * riders + (1 if drive_lag > 0.0 else 0)
    lag_at = head + n + 2 * riders
    kept = states.shape[0]
    oldest, newest = 0, 0
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
    taken, eased = 0.0, 1.0
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
        v = y[1]
        s_here, s_rate = drive_at(t, knots, values, rates, wave, segment)
        zone, edge = 1.0, 0.0
        if gap > 0.0:
            pull, pull_rate = s_here, s_rate
            if drive_lag > 0.0:
                pull, pull_rate = y[lag_at], (s_here - y[lag_at]) / drive_lag
            zone, edge = side_of_play(pull - spring * y[0], pull_rate - spring * v, gap, slack)
        if delay > 0.0:
            past_speed(history, oldest, newest, t - delay, start[1], True, past)
            oldest = int(past[2])
        if abs(v) > 2.0 * quiet:
            direction = 1.0 if v > 0.0 else -1.0
        push, reaction = 0.0, 0.0
        for turn in range(2):
            axis_forces(
                t, y, head, direction, past[0], past[1], 1, base, effects, groups, cores, beside, axis, laws, elements,
                here, slope,
            )  # fmt: skip
            push, reaction = right_side(
                t, y, direction, head, n, riders, drive_lag, here, elements, modes, body, knots, values, rates, wave,
                segment, zone, edge, worked, f_start,
            )  # fmt: skip
            # At a reversal the motion goes the way it is accelerated.
            if turn == 1 or abs(v) > 2.0 * quiet or f_start[1] * direction >= 0.0:
                break
            direction = -direction
        assemble(
            y, direction, head, n, riders, drive_lag, worked, zone, s_rate, push, reaction, here, elements, slope,
            modes, body, row, own, into, by_head, work_head, work_z, ft,
        )  # fmt: skip
        age_out, age_own = 0.0, 0.0
        if head > 2:
            age_out = -direction * y[3] / memory_length
            age_own = -direction * v / memory_length

        part, shortened = 1.0, 0
        while True:
            over_h = 1.0 / h
            s, over_s, over_pivot, over_age, over_lag = factorise(
                h, GAMMA, direction, head, n, riders, drive_lag, age_out, age_own, modes, body, row, own, into, by_head,
                ratio, effective,
            )  # fmt: skip
            finite = True
            for i in range(STAGES):
                # Solved where it is kept.
                f = K[i * size : (i + 1) * size]
                if i == 0:
                    for j in range(size):
                        f[j] = f_start[j] + h * TIME_SLOPE[0] * ft[j]
                else:
                    at = t + TIME[i] * h
                    stage_sums(i, size, y, K, over_h, stage, earlier)
                    if delay > 0.0:
                        past_speed(history, oldest, newest, at - delay, start[1], False, past)
                    values_at(
                        at, stage, head, direction, past[0], base, effects, groups, at_once, cores, beside, axis, laws,
                        elements, here, slope,
                    )  # fmt: skip
                    right_side(
                        at, stage, direction, head, n, riders, drive_lag, here, elements, modes, body, knots, values,
                        rates, wave, segment, zone, edge, worked, f,
                    )  # fmt: skip
                    late = h * TIME_SLOPE[i]
                    for j in range(size):
                        f[j] += earlier[j] + late * ft[j]
                kv = solve(
                    f, v, direction, head, n, riders, cores, drive_lag, worked, zone, s, over_s, over_pivot, over_age,
                    over_lag, age_out, modes, body, into, by_head, ratio, effective, work_head, work_z,
                )  # fmt: skip
                if not math.isfinite(kv):
                    finite = False
                    break
            error = math.inf
            if finite:
                error = 0.0
                f = K[(STAGES - 1) * size :]
                for j in range(size):
                    fresh[j] = stage[j] + f[j]
                    scale = absolute[j] + relative * max(abs(y[j]), abs(fresh[j]))
                    off = f[j] / scale
                    error += off * off
                error /= counted
                if not math.isfinite(error):
                    error = math.inf
            # The error so far is squared; the step that is wanted goes with its fifth root.
            ease = max(error, 1e-12) ** -0.1
            if error <= 1.0:
                bends(K, size, 1, dense)
                if gap > 0.0:
                    part = edge_of_play(
                        K, dense, size, t, h, y, fresh, direction, 3.0 * quiet, lag_at, drive_lag, knots, values, rates,
                        wave, segment, spring, zone, edge, gap, slack,
                    )  # fmt: skip
                else:
                    part = reversal(y[1], fresh[1], dense[1, 0], dense[1, 1], dense[1, 2], direction, 3.0 * quiet)
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
            rejected += 1
            was_rejected = True
            lands = False
            h *= 0.25 if error == math.inf else max(0.2, 0.9 * ease)
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
        due = due_by(outputs, next_output, after)
        # Nothing looks at the dense output of a whole step within which nothing is due.
        looked_at = size if part < 1.0 else kept if due > next_output else 0
        for j in range(looked_at):
            if j != 1:
                bends(K, size, j, dense)
        if due > next_output:
            for j in range(kept):
                fill(
                    states[j, next_output:due], outputs[next_output:due], t, over_h, y[j], fresh[j], dense[j, 0],
                    dense[j, 1], dense[j, 2],
                )  # fmt: skip
        if forces.shape[0] > 0:
            for o in range(next_output, due):
                at = outputs[o]
                if delay > 0.0:
                    past_speed(history, oldest, newest, at - delay, start[1], False, past)
                for j in range(size):
                    stage[j] = states[j, o]
                values_at(
                    at, stage, head, direction, past[0], base, effects, groups, at_once, cores, beside, axis, laws,
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
            keep(
                history[newest & (history.shape[0] - 1)], t, over_h, y[1], fresh[1], dense[1, 0], dense[1, 1],
                dense[1, 2],
            )  # fmt: skip
            newest += 1
        for j in range(size):
            y[j] = at_part(part, y[j], fresh[j], dense[j, 0], dense[j, 1], dense[j, 2]) if part < 1.0 else fresh[j]
        t = after
        factor = min(6.0, 0.9 * ease)
        if taken > 0.0:
            # Gustafsson's controller: a rise of the error over the last two steps is expected to go on.
            factor = min(factor, 0.9 * h / taken * ease * ease / eased)
        taken, eased = h, min(ease, 2.5)
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
        arrowhead_module,
        axis_forces_module,
        axis_rates_module,
        kernel_calls,
        rodas5p,
        stage_sums_module,
        step_output_module,
    )
]
_compiled_steps = compile_function(_steps, _SOURCES, _nrt=False, fastmath={"contract"})


def _integrate(
    start, outputs, knots, values, rates, wave, body, shape, modes, effects, groups, at_once, base, relative, absolute,
    longest, most_steps, states, forces, report,
):  # fmt: skip
    """Integrate from the first to the last of `outputs`; see `sim.integration.layout` for what the arrays hold."""
    size, m = start.size, max(start.size - 2, 1)
    axis, laws, elements = np.zeros(NAXIS), np.zeros(3 * OUT + OUT), np.zeros((m, 8))
    work = (
        start.copy(), np.zeros(size), np.zeros(size), np.zeros(size), np.zeros(STAGES * size), np.zeros((size, 3)),
        np.zeros(size), np.zeros(size), axis, laws, elements, np.zeros(4), np.zeros((4, BY)), np.zeros((m, 4)),
        np.zeros(m), np.zeros(m), np.zeros(m), np.zeros((NWORK, 4)), np.zeros(m), np.zeros(4), np.zeros(4), np.zeros(3),
    )  # fmt: skip
    history = np.empty((PAST_STEPS if body[6] > 0.0 else 1, HISTORY))
    _compiled_steps(
        start, outputs, knots, values, rates, wave, body, shape, modes, effects, groups, at_once, base, relative,
        absolute, longest, most_steps, states, forces, report, work, history,
    )  # fmt: skip


integrate: Any = compile_function(_integrate, _SOURCES, nogil=True)
"""The compiled integration; `report` = [outcome, time, steps, rejected, reversals cut to, *state]."""
