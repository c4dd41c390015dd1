"""Adaptive stiff integration of one axis: Rodas5P with the exact Jacobian, compiled once for every model.

State y = [position, velocity, travelled, contact age | z_1 .. z_n | works of the core, other forces, drive].
The states of a core meet the rest only through velocity and friction level, so W = I/(gamma h) - J is an arrowhead with
a small head: one linear solve costs O(number of states), and one stage O(number of effects).

Two things keep kinks from doing harm. A drive that is linear in pieces is stepped from knot to knot. A step across a
reversal is cut at the moment the velocity is zero, found from the dense output, since |v| has a kink there.

This module imports numba: import it only when something is integrated.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from llvmlite import ir
from numba import types
from numba.extending import intrinsic

from sim import rodas5p
from sim.compilation import compile_function
from sim.rodas5p import GAMMA, STAGES, TIME, TIME_SLOPE, A, C, H

DONE, STEP_TOO_SMALL, NOT_FINITE, TOO_MANY_STEPS = 0, 1, 2, 3
NHEAD, NWORK, NOUT, NAXIS = 4, 3, 6, 10


def _effect_call(context: Any, address: Any, axis: Any, p: Any, out: Any, slopes: Any) -> Any:
    """Call an effect's kernel at `address`; the arrays are given by the addresses of their first elements."""

    def generate(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        pointer = ir.DoubleType().as_pointer()
        kind = ir.FunctionType(ir.VoidType(), [pointer, pointer, pointer, ir.IntType(64)])
        function = builder.inttoptr(arguments[0], kind.as_pointer())
        builder.call(function, [*(builder.inttoptr(a, pointer) for a in arguments[1:4]), arguments[4]])
        return context.get_dummy_value()

    return types.void(*[types.int64] * 5), generate


def _core_call(context: Any, address: Any, z: Any, v: Any, g: Any, p: Any, out: Any, n: Any, slopes: Any) -> Any:
    """Call a core's kernel at `address`."""

    def generate(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        number, integer = ir.DoubleType(), ir.IntType(64)
        pointer = number.as_pointer()
        kind = ir.FunctionType(ir.VoidType(), [pointer, number, number, pointer, pointer, integer, integer])
        function = builder.inttoptr(arguments[0], kind.as_pointer())
        z, p, out = (builder.inttoptr(arguments[i], pointer) for i in (1, 4, 5))
        builder.call(function, [z, arguments[2], arguments[3], p, out, arguments[6], arguments[7]])
        return context.get_dummy_value()

    return types.void(*[types.int64] * 2, types.float64, types.float64, *[types.int64] * 4), generate


_call_effect: Any = intrinsic(_effect_call)
_call_core: Any = intrinsic(_core_call)


def _forces(
    t, y, z, direction, slopes, effects, p_at, core, core_p_at, n, surroundings, axis, laws, core_out, out, slope
):
    """Level and forces at one instant.

    out = [level, core force, other force]; slope rows by (position, velocity, travelled, age, time): of the level, of
    the core force at constant states, of the other force.
    """
    axis[0], axis[1], axis[2], axis[3] = t, y[0], y[1], math.nan
    axis[4], axis[5] = surroundings[0], surroundings[1]
    axis[6], axis[7], axis[8] = y[3], math.nan, y[2]
    axis[9] = direction
    if y[1] > 0.0:
        axis[9] = 1.0
    elif y[1] < 0.0:
        axis[9] = -1.0
    level, factor, other = 0.0, 1.0, 0.0
    by = NOUT - 1
    if slopes:
        slope[:] = 0.0
    factor_slope = laws[3 * NOUT :]
    factor_slope[:by] = 0.0
    for i in range(effects.size):
        if slopes:
            # A kernel writes only the slopes it has.
            laws[: 3 * NOUT] = 0.0
        _call_effect(effects[i], axis.ctypes.data, p_at[i], laws.ctypes.data, slopes)
        level += laws[0]
        other += laws[2 * NOUT]
        if slopes:
            for j in range(by):
                slope[0, j] += laws[1 + j]
                slope[2, j] += laws[2 * NOUT + 1 + j]
                factor_slope[j] = factor_slope[j] * laws[NOUT] + factor * laws[NOUT + 1 + j]
        factor *= laws[NOUT]
    g = level * factor
    force = 0.0
    if core != 0:
        _call_core(core, z.ctypes.data, y[1], g, core_p_at, core_out.ctypes.data, n, slopes)
        for k in range(n):
            force += core_out[k, 1]
    if slopes:
        for j in range(by):
            slope[0, j] = slope[0, j] * factor + level * factor_slope[j]
        for k in range(n):
            for j in range(by):
                slope[1, j] += core_out[k, 7] * slope[0, j]
            slope[1, 1] += core_out[k, 6]
    out[0], out[1], out[2] = g, force, other


def _integrate(
    start, t0, outputs, knots, values, rates, wave, body, effects, p_at, core, core_p_at, n, surroundings,
    relative, absolute, longest, most_steps, states, forces, report,
):  # fmt: skip
    """Integrate from `t0` to the last of `outputs`; see `sim.model` for what the arrays hold."""
    mass, spring, feedback, memory_length = body[0], body[1], body[2], body[3]
    size = start.size
    tail = NHEAD + n
    y = start.copy()
    fresh = np.empty(size)
    stage = np.empty(size)
    z = np.zeros(max(n, 1))
    K = np.zeros((STAGES, size))
    f = np.zeros(size)
    ft = np.zeros(size)
    dense = np.zeros((3, size))
    axis = np.zeros(NAXIS)
    laws = np.zeros(3 * NOUT + NOUT)
    core_out = np.zeros((max(n, 1), 8))
    here = np.zeros(3)
    slope = np.zeros((3, NOUT - 1))
    by_head = np.zeros((max(n, 1), NHEAD))
    own = np.zeros(max(n, 1))
    into = np.zeros(max(n, 1))
    ratio = np.zeros(max(n, 1))
    work_head = np.zeros((NWORK, NHEAD))
    work_z = np.zeros(max(n, 1))
    row = np.zeros(NHEAD)
    effective = np.zeros(NHEAD)

    t = t0
    end = outputs[outputs.size - 1]
    next_output = 0
    segment = 0
    while segment + 1 < rates.size and knots[segment + 1] <= t:
        segment += 1
    direction = 1.0 if y[1] >= 0.0 else -1.0
    h = min(longest, max((end - t0) * 1e-6, 1e-12))
    steps, rejected, cuts = 0, 0, 0
    was_rejected = False
    just_cut = False

    while next_output < outputs.size and outputs[next_output] <= t:
        for i in range(size):
            states[next_output, i] = y[i]
        next_output += 1

    while t < end:
        if steps + rejected >= most_steps:
            report[0], report[1] = TOO_MANY_STEPS, t
            report[2], report[3] = steps, rejected
            report[5:] = y
            return
        # The end of this stretch of smooth drive.
        stop = end
        if segment + 1 < rates.size and knots[segment + 1] < end:
            stop = knots[segment + 1]
        lands = False
        if t + 1.0001 * h >= stop:
            h = stop - t
            lands = True

        # Right side and Jacobian at the start of the step.
        for k in range(n):
            z[k] = y[NHEAD + k]
        drive = values[segment] + rates[segment] * (t - knots[segment]) + wave[0] * math.cos(wave[1] * t + wave[2])
        drive_t = rates[segment] - wave[0] * wave[1] * math.sin(wave[1] * t + wave[2])
        _forces(
            t, y, z, direction, 1, effects, p_at, core, core_p_at, n, surroundings, axis, laws, core_out, here, slope
        )
        acceleration = (drive - spring * y[0] - feedback * (here[1] + here[2])) / mass
        v = y[1]
        if abs(v) < 1e-3 * absolute[1]:
            # At a reversal the slopes are those of the side the motion turns to.
            v = math.copysign(max(abs(v), 1e-30), acceleration)
            keep = y[1]
            y[1] = v
            _forces(
                t,
                y,
                z,
                direction,
                1,
                effects,
                p_at,
                core,
                core_p_at,
                n,
                surroundings,
                axis,
                laws,
                core_out,
                here,
                slope,
            )
            y[1] = keep
        sign = 1.0 if v >= 0.0 else -1.0
        for j in range(NHEAD):
            row[j] = -feedback * (slope[1, j] + slope[2, j]) / mass
        row[0] -= spring / mass
        for i in range(size):
            ft[i] = 0.0
        ft[1] = (drive_t - feedback * (slope[1, 4] + slope[2, 4])) / mass
        for k in range(n):
            own[k] = core_out[k, 2]
            into[k] = -feedback * core_out[k, 5] / mass
            for j in range(NHEAD):
                by_head[k, j] = core_out[k, 4] * slope[0, j]
            by_head[k, 1] += core_out[k, 3]
            ft[NHEAD + k] = core_out[k, 4] * slope[0, 4]
        worked = size > tail
        if worked:
            for j in range(NHEAD):
                work_head[0, j] = slope[1, j] * v
                work_head[1, j] = slope[2, j] * v
                work_head[2, j] = 0.0
            work_head[0, 1] += here[1]
            work_head[1, 1] += here[2]
            work_head[2, 0] = -spring * v
            work_head[2, 1] = drive - spring * y[0]
            for k in range(n):
                work_z[k] = core_out[k, 5] * v
            ft[tail] = slope[1, 4] * v
            ft[tail + 1] = slope[2, 4] * v
            ft[tail + 2] = drive_t * v
        age_out = -sign * y[3] / memory_length
        age_own = -abs(v) / memory_length

        accepted = False
        while not accepted:
            s = 1.0 / (GAMMA * h)
            for j in range(NHEAD):
                effective[j] = row[j]
            for k in range(n):
                ratio[k] = 1.0 / (s - own[k])
                for j in range(NHEAD):
                    effective[j] += into[k] * by_head[k, j] * ratio[k]
            pivot = (
                s - effective[1] - effective[0] / s - effective[2] * sign / s - effective[3] * age_out / (s - age_own)
            )
            finite = True
            for i in range(STAGES):
                at = t + TIME[i] * h
                for j in range(size):
                    total = y[j]
                    for m in range(i):
                        total += A[i, m] * K[m, j]
                    stage[j] = total
                for k in range(n):
                    z[k] = stage[NHEAD + k]
                _forces(
                    at, stage, z, direction, 0, effects, p_at, core, core_p_at, n, surroundings, axis, laws, core_out,
                    here, slope,
                )  # fmt: skip
                push = (
                    values[segment]
                    + rates[segment] * (at - knots[segment])
                    + wave[0] * math.cos(wave[1] * at + wave[2])
                    - spring * stage[0]
                )
                f[0] = stage[1]
                f[1] = (push - feedback * (here[1] + here[2])) / mass
                f[2] = abs(stage[1])
                f[3] = 1.0 - abs(stage[1]) * stage[3] / memory_length
                for k in range(n):
                    f[NHEAD + k] = core_out[k, 0]
                if worked:
                    f[tail] = here[1] * stage[1]
                    f[tail + 1] = here[2] * stage[1]
                    f[tail + 2] = push * stage[1]
                for j in range(size):
                    total = 0.0
                    for m in range(i):
                        total += C[i, m] * K[m, j]
                    f[j] += total / h + h * TIME_SLOPE[i] * ft[j]
                right = f[1] + effective[0] * f[0] / s + effective[2] * f[2] / s + effective[3] * f[3] / (s - age_own)
                for k in range(n):
                    right += into[k] * f[NHEAD + k] * ratio[k]
                kv = right / pivot
                K[i, 1] = kv
                K[i, 0] = (f[0] + kv) / s
                K[i, 2] = (f[2] + sign * kv) / s
                K[i, 3] = (f[3] + age_out * kv) / (s - age_own)
                for k in range(n):
                    total = f[NHEAD + k]
                    for j in range(NHEAD):
                        total += by_head[k, j] * K[i, j]
                    K[i, NHEAD + k] = total * ratio[k]
                if worked:
                    for w in range(NWORK):
                        total = f[tail + w]
                        for j in range(NHEAD):
                            total += work_head[w, j] * K[i, j]
                        if w == 0:
                            for k in range(n):
                                total += work_z[k] * K[i, NHEAD + k]
                        K[i, tail + w] = total / s
                if not math.isfinite(kv):
                    finite = False
                    break
            error = math.inf
            if finite:
                error = 0.0
                counted = 0
                for j in range(size):
                    fresh[j] = stage[j] + K[STAGES - 1, j]
                    if absolute[j] < math.inf:
                        scale = absolute[j] + relative * max(abs(y[j]), abs(fresh[j]))
                        error += (K[STAGES - 1, j] / scale) ** 2
                        counted += 1
                error = math.sqrt(error / counted)
                if not math.isfinite(error):
                    error = math.inf
            if error <= 1.0:
                factor = 6.0 if error < 1e-6 else min(6.0, 0.9 * error**-0.2)
                if was_rejected:
                    factor = min(factor, 1.0)
                reverses = y[1] * fresh[1] < 0.0 and abs(y[1]) > 1e-3 * absolute[1]
                for m in range(3):
                    for j in range(size):
                        total = 0.0
                        for i in range(STAGES):
                            total += H[m, i] * K[i, j]
                        dense[m, j] = total
                if reverses and not just_cut:
                    # Bisect the dense output for the moment of rest, then take the step again up to it.
                    low, high = 0.0, 1.0
                    for _ in range(60):
                        middle = 0.5 * (low + high)
                        there = (1.0 - middle) * y[1] + middle * (
                            fresh[1] + (1.0 - middle) * (dense[0, 1] + middle * (dense[1, 1] + middle * dense[2, 1]))
                        )
                        if there * y[1] > 0.0:
                            low = middle
                        else:
                            high = middle
                    if low > 1e-6 and abs(fresh[1]) > 1e-3 * absolute[1]:
                        h = h * high
                        lands = False
                        just_cut = True
                        cuts += 1
                        continue
                accepted = True
                just_cut = False
            else:
                rejected += 1
                was_rejected = True
                just_cut = False
                lands = False
                h *= 0.25 if error == math.inf else max(0.2, 0.9 * error**-0.2)
                if h < 1e-14 * max(1.0, abs(t)) or not h > 0.0:
                    report[0], report[1] = (STEP_TOO_SMALL if finite else NOT_FINITE), t
                    report[2], report[3] = steps, rejected
                    report[5:] = y
                    return
                if steps + rejected >= most_steps:
                    report[0], report[1] = TOO_MANY_STEPS, t
                    report[2], report[3] = steps, rejected
                    report[5:] = y
                    return

        steps += 1
        was_rejected = False
        after = stop if lands else t + h
        while next_output < outputs.size and outputs[next_output] <= after:
            part = 1.0 if outputs[next_output] == after else (outputs[next_output] - t) / h
            for j in range(size):
                states[next_output, j] = (1.0 - part) * y[j] + part * (
                    fresh[j] + (1.0 - part) * (dense[0, j] + part * (dense[1, j] + part * dense[2, j]))
                )
            next_output += 1
        t = after
        if fresh[1] != 0.0:
            direction = 1.0 if fresh[1] > 0.0 else -1.0
        for j in range(size):
            y[j] = fresh[j]
        h = min(longest, h * factor)
        if lands and segment + 1 < rates.size and knots[segment + 1] <= t:
            segment += 1

    # Forces at the outputs, from the states there.
    segment = 0
    direction = 1.0 if start[1] >= 0.0 else -1.0
    for i in range(forces.shape[0]):
        at = outputs[i]
        while segment + 1 < rates.size and knots[segment + 1] <= at:
            segment += 1
        for j in range(size):
            stage[j] = states[i, j]
        for k in range(n):
            z[k] = stage[NHEAD + k]
        _forces(
            at, stage, z, direction, 0, effects, p_at, core, core_p_at, n, surroundings, axis, laws, core_out, here,
            slope,
        )  # fmt: skip
        if stage[1] != 0.0:
            direction = 1.0 if stage[1] > 0.0 else -1.0
        forces[i, 0], forces[i, 1], forces[i, 2] = here[0], here[1], here[2]
        forces[i, 3] = (
            values[segment]
            + rates[segment] * (at - knots[segment])
            + wave[0] * math.cos(wave[1] * at + wave[2])
            - spring * stage[0]
        )
    report[0], report[1], report[2], report[3], report[4] = DONE, t, steps, rejected, cuts
    report[5:] = y


_SOURCES = [rodas5p.__file__]
_forces = compile_function(_forces, _SOURCES)
integrate = compile_function(_integrate, _SOURCES)
"""The compiled integration; `report` = [outcome, time, steps, rejected, cuts at reversals, *state]."""
