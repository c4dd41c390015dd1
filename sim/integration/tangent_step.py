"""Sensitivities of the motion to parameters, carried along step by step beside the integration, in compiled code.

S = dy/dp follows S' = J(t) S + df/dp(t), linear, with J and df/dp exact on the dense output of the step just accepted.
One step of an L-stable SDIRK method, of order 4 with five stages, or of order 3 with three where the steps are shorter
than they need be; J is the arrowhead of `sim.integration.integrator`, so a stage costs O(states) for each parameter,
without iteration. What is found is the derivative of the solution itself, not of the steps that were taken.

Source: Hairer and Wanner, Solving ODEs II (1996), table IV.6.5 (SDIRK4, gamma = 1/4); Alexander, SIAM J. Numer. Anal.
14 (1977) 1006.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from sim.integration.axis_forces import OUT, axis_forces
from sim.integration.kernel_calls import call_effect, call_elements
from sim.integration.right_hand_side import drive_at
from sim.integration.step_output import at_part
from sim.numerics.compilation import INLINED, compile_function

OF_EFFECT, OF_MASS, OF_STIFFNESS, OF_MEMORY_LENGTH = 0, 1, 2, 3
STAGES = 5
EASY = 1e-6
"""Below this error of the integrator's own step, in units of its tolerance, three stages do for the derivatives."""
_G = 0.43586652150845967
# Row 0: SDIRK4; row 1: Alexander's method of order 3, in the first three stages.
GAMMA_OF = np.array([0.25, _G])
A_OF = np.zeros((2, STAGES, STAGES))
A_OF[0] = [
    [1 / 4, 0.0, 0.0, 0.0, 0.0],
    [1 / 2, 1 / 4, 0.0, 0.0, 0.0],
    [17 / 50, -1 / 25, 1 / 4, 0.0, 0.0],
    [371 / 1360, -137 / 2720, 15 / 544, 1 / 4, 0.0],
    [25 / 24, -49 / 48, 125 / 16, -85 / 12, 1 / 4],
]
A_OF[1, :3, :3] = [
    [_G, 0.0, 0.0],
    [(1.0 - _G) / 2.0, _G, 0.0],
    [-(6.0 * _G**2 - 16.0 * _G + 1.0) / 4.0, (6.0 * _G**2 - 20.0 * _G + 5.0) / 4.0, _G],
]
C_OF = np.array([[1 / 4, 3 / 4, 11 / 20, 1 / 2, 1.0], [_G, (1.0 + _G) / 2.0, 1.0, 0.0, 0.0]])


def _slopes_at(
    share, step, sizes, drive, body, laws_of, tangent, work, row, by_head, into, own, ages,
):  # fmt: skip
    """The arrowhead and df/dp (parameters, states) at a part `share` of the step."""
    t, h, y, fresh, dense, direction = step
    head, n, cores, beside = sizes
    knots, values, rates, wave, segment = drive
    base, effects, groups = laws_of
    parameters, by_effect, by_group, derived, fp = tangent[0], tangent[1], tangent[2], tangent[3], tangent[8]
    axis, laws, elements, here, slope, stage = work
    per_mass, spring, feedback, memory_length = body[0], body[1], body[2], body[3]
    size = head + n
    at = t + share * h
    for j in range(size):
        stage[j] = at_part(share, y[j], fresh[j], dense[j, 0], dense[j, 1], dense[j, 2])
    axis_forces(
        at, stage, head, direction, 0.0, 0.0, 1, base, effects, groups, cores, beside, axis, laws, elements, here, slope
    )
    v = stage[1]
    for j in range(head):
        row[j] = -feedback * (slope[1, j] + slope[2, j] + slope[3, j]) * per_mass
    row[0] -= spring * per_mass
    ages[0], ages[1] = 0.0, 0.0
    if head > 2:
        ages[0], ages[1] = -direction * stage[3] / memory_length, -direction * v / memory_length
    for k in range(n):
        own[k] = elements[k, 2]
        into[k] = -feedback * elements[k, 5] * per_mass
        for j in range(head):
            by_head[k, j] = elements[k, 4] * slope[0, j]
        by_head[k, 1] += elements[k, 3]
    pushed = drive_at(at, knots, values, rates, wave, segment)[0] - spring * stage[0]
    force_g = 0.0
    for k in range(n):
        force_g += elements[k, 7]
    # Derivatives of every law by its own parameters, and what a change of a level or factor does to the whole level.
    total = base[1]
    for i in range(effects.shape[0]):
        derived[i] = 1.0
        if by_effect[i, 3] != 0:
            call_effect(effects[i, 0], axis, effects[i, 1], laws, 0, 0)
            total *= laws[OUT]
            derived[i] = laws[OUT]
        if by_effect[i, 0] != 0:
            call_effect(by_effect[i, 0], axis, effects[i, 1], derived, by_effect[i, 1], by_effect[i, 2])
    for i in range(groups.shape[0]):
        if by_group[i, 0] != 0 and groups[i, 3] > 0:
            call_elements(
                by_group[i, 0], stage, head + groups[i, 2], v, direction, here[0], groups[i, 1], derived,
                by_group[i, 1], groups[i, 3], by_group[i, 2],
            )  # fmt: skip
    for q in range(parameters.shape[0]):
        for j in range(size):
            fp[q, j] = 0.0
        kind, i, group, own_j, own_size = (
            parameters[q, 0], parameters[q, 1], parameters[q, 2], parameters[q, 3], parameters[q, 4],
        )  # fmt: skip
        if kind == OF_MASS:
            fp[q, 1] = -feedback * per_mass * per_mass * (pushed - here[1] - here[2] - here[3])
            continue
        if kind == OF_STIFFNESS:
            fp[q, 1] = per_mass * pushed / spring
            continue
        if kind == OF_MEMORY_LENGTH:
            fp[q, 3] = direction * v * stage[3] / (memory_length * memory_length)
            continue
        if i >= 0:
            out = by_effect[i, 1]
            dg, df = 0.0, 0.0
            if effects[i, 2] & 1:
                dg = total * derived[out + own_j] + here[0] / derived[i] * derived[out + own_size + own_j]
            if effects[i, 2] & 2:
                df = derived[out + 2 * own_size + own_j]
            fp[q, 1] -= feedback * per_mass * (force_g * dg + df)
            for k in range(n):
                fp[q, head + k] += elements[k, 4] * dg
        if group >= 0:
            out = by_group[group, 1]
            first = groups[group, 2]
            for k in range(groups[group, 3]):
                fp[q, head + first + k] += derived[out + 2 * k * own_size + own_j]
                fp[q, 1] -= feedback * per_mass * derived[out + (2 * k + 1) * own_size + own_j]


slopes_at: Any = compile_function(_slopes_at, **INLINED)


def _rate(w, q, head, n, direction, row, by_head, into, own, ages, fp, out):
    """out = J w + df/dp of parameter q."""
    out[0] = w[1]
    total = fp[q, 1]
    for j in range(head):
        total += row[j] * w[j]
    for k in range(n):
        total += into[k] * w[head + k]
        change = fp[q, head + k] + own[k] * w[head + k]
        for j in range(head):
            change += by_head[k, j] * w[j]
        out[head + k] = change
    out[1] = total
    if head > 2:
        out[2] = direction * w[1]
        out[3] = fp[q, 3] + ages[0] * w[1] + ages[1] * w[3]


rate: Any = compile_function(_rate, **INLINED)


def _advance(
    part, step, sizes, drive, body, laws_of, tangent, work, row, by_head, into, own, ages, ratio, effective, inner, easy
):  # fmt: skip
    """Carry S (parameters, states) to the part of the step that was accepted; K[:, 4] is S' there.

    step = (t, h, y, fresh, dense, direction); sizes = (head, n, cores, beside); drive = (knots, values, rates, wave,
    segment); laws_of = (base, effects, groups); work = (axis, laws, elements, here, slope, stage).
    With `inner`, `before` (parameters, 4) holds S of position and velocity at the start of the step, and S' there.
    """
    h, direction = step[1], step[5]
    head, n = sizes[0], sizes[1]
    parameters, S, K, before, u, fp = tangent[0], tangent[4], tangent[5], tangent[6], tangent[7], tangent[8]
    stage = work[5]
    size = head + n
    count = parameters.shape[0]
    length = part * h
    which, stages = (1, 3) if easy else (0, STAGES)
    s, over_s = 1.0 / (GAMMA_OF[which] * length), GAMMA_OF[which] * length
    # What comes before the stages is S' at the start of the step.
    for i in range(-1 if inner else 0, stages):
        share = C_OF[which, i] * part if i >= 0 else 0.0
        slopes_at(share, step, sizes, drive, body, laws_of, tangent, work, row, by_head, into, own, ages)
        pivot, over_age = s - row[1], 0.0
        if i >= 0:
            for j in range(head):
                effective[j] = row[j]
            for k in range(n):
                ratio[k] = 1.0 / (s - own[k])
                for j in range(head):
                    effective[j] += into[k] * by_head[k, j] * ratio[k]
            pivot = s - effective[1] - effective[0] * over_s
            if head > 2:
                over_age = 1.0 / (s - ages[1])
                pivot -= effective[2] * direction * over_s + effective[3] * ages[0] * over_age
        over_pivot = 1.0 / pivot
        for q in range(count):
            for j in range(size):
                total = 0.0
                for m in range(i):
                    total += A_OF[which, i, m] * K[q, m, j]
                stage[j] = S[q, j] + length * total
            rate(stage, q, head, n, direction, row, by_head, into, own, ages, fp, u)
            if i < 0:
                before[q, 0], before[q, 1], before[q, 2], before[q, 3] = S[q, 0], S[q, 1], u[0], u[1]
                continue
            for j in range(size):
                u[j] *= s
            right = u[1] + effective[0] * u[0] * over_s
            if head > 2:
                right += effective[2] * u[2] * over_s + effective[3] * u[3] * over_age
            for k in range(n):
                right += into[k] * u[head + k] * ratio[k]
            kv = right * over_pivot
            u[1] = kv
            u[0] = (u[0] + kv) * over_s
            if head > 2:
                u[2] = (u[2] + direction * kv) * over_s
                u[3] = (u[3] + ages[0] * kv) * over_age
            for k in range(n):
                total = u[head + k]
                for j in range(head):
                    total += by_head[k, j] * u[j]
                u[head + k] = total * ratio[k]
            for j in range(size):
                K[q, i, j] = u[j]
    for q in range(count):
        for j in range(size):
            total = 0.0
            for i in range(stages):
                total += A_OF[which, stages - 1, i] * K[q, i, j]
            S[q, j] += length * total
            K[q, STAGES - 1, j] = K[q, stages - 1, j]


def _spread(tangent, instants, t, length, first, last):
    """S of position and velocity at instants within the step, rows `first` to `last`, by Hermite's cubic."""
    S, K, before, found = tangent[4], tangent[5], tangent[6], tangent[9]
    over = 1.0 / length
    for q in range(S.shape[0]):
        for w in range(2):
            start, end = before[q, w], S[q, w]
            rise = end - start
            early, late = length * before[q, 2 + w] - rise, rise - length * K[q, STAGES - 1, w]
            into = found[w, q, first:last]
            for o in range(instants.size):
                part = (instants[o] - t) * over
                rest = 1.0 - part
                into[o] = start + part * (rise + rest * (early * rest + late * part))
            if instants[instants.size - 1] >= t + length:
                into[instants.size - 1] = end


spread: Any = compile_function(_spread, _nrt=False, fastmath={"contract"})
advance: Any = compile_function(_advance, **INLINED)
