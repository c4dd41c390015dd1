"""One step of Rodas5P, an L-stable Rosenbrock method of order 5 in 8 stages with dense output of order 4; compiled.

In the form that needs no matrix products (Hairer and Wanner, Solving ODEs II, IV.7): with W = I/(gamma h) - J

    W k_i = f(t + c_i h, y + sum_j A_ij k_j) + sum_j C_ij k_j / h + h d_i df/dt

The last three stages share the point t + h; y_new adds k_6, k_7 and k_8 in turn, and k_8 is the error estimate.
Dense output: y(s) = (1 - s) y + s (y_new + (1 - s) (D_1 + s (D_2 + s D_3))), D_i = sum_j H_ij k_j.

Source: Steinebach 2023, BIT Numerical Mathematics 63:27, Construction of Rosenbrock-Wanner method Rodas5P.

The states after the head depend on the rest through position, velocity and friction level alone, and act on it through
the velocity alone. So W = I/(gamma h) - J is an arrowhead: all states but the velocity are eliminated in one pass, and
one solve costs O(number of states).

Within a step every law is continued smoothly past a reversal and past an edge of the backlash (`Branch`). The step is
valid up to the first of these events only, which is located on its dense output.
"""

import math
import tomllib
from pathlib import Path
from typing import NamedTuple

import numpy as np

from sim.integration.compiled.views import Part
from sim.integration.problem import (
    BRANCH,
    POSITION,
    VALUES,
    VELOCITY,
    WORKS,
    drive_at,
    friction_terms,
    inlined,
    rates_of_change,
)

HEAD = 4
"""Columns kept for the states of the head; those that a model lacks are zero."""


class Factors(NamedTuple):
    """Scalars of the elimination: s = 1/(gamma h), and the inverses of s and of the pivots."""

    s: float
    inverse_s: float
    inverse_pivot: float
    inverse_age: float
    by_first: float  # share of the first element's entry in that of the age
    inverse_lag: float


@inlined
def assemble(t, y, branch, acting, problem, terms, jacobian):
    """Entries of J and df/dt at the start of a step; `acting`: forces that `rates_of_change` returned there."""
    layout, body = problem.layout, problem.body
    slope, elements, ft = terms.slope, terms.elements, jacobian.time
    v = y[1]
    _, drive_rate = drive_at(t, problem.drive, branch.segment)
    for j in range(layout.size):
        ft[j] = 0.0
    for j in range(HEAD):
        jacobian.velocity_by_head[j] = -body.feedback * (slope[1, j] + slope[2, j] + slope[3, j]) * body.inverse_mass
    jacobian.velocity_by_head[0] -= branch.engaged * body.spring * body.inverse_mass
    ft[1] = -body.feedback * (slope[1, 4] + slope[2, 4] + slope[3, 4]) * body.inverse_mass
    if layout.head > 2:
        slip, side, jacobian.age[2] = branch.direction * v, branch.direction, 0.0
        if body.ages_by_slip:
            slip = abs(v - elements[0, 0])
            side = 1.0 if v >= elements[0, 0] else -1.0
            jacobian.age[2] = side * y[3] / body.memory_length
        jacobian.age[0] = -side * y[3] / body.memory_length
        jacobian.age[1] = -slip / body.memory_length
    for k in range(layout.elements):
        jacobian.element_by_self[k] = elements[k, 2]
        jacobian.velocity_by_element[k] = -body.feedback * elements[k, 5] * body.inverse_mass
        for j in range(HEAD):
            jacobian.element_by_head[k, j] = elements[k, 4] * slope[0, j]
        jacobian.element_by_head[k, 1] += elements[k, 3]
        ft[layout.head + k] = elements[k, 4] * slope[0, 4]
    if layout.head > 2 and body.ages_by_slip:
        ft[3] = jacobian.age[2] * ft[layout.head]
    if layout.lag >= 0:
        ft[layout.lag] = drive_rate / body.drive_lag
        drive_rate = 0.0
    ft[1] += branch.engaged * drive_rate * body.inverse_mass
    if layout.works >= 0:
        _assemble_works(v, branch, acting[0], acting[1], problem, terms, jacobian)
        ft[layout.works] = slope[1, 4] * v
        ft[layout.works + 1] = (slope[2, 4] + slope[3, 4]) * v
        ft[layout.works + 2] = branch.engaged * drive_rate * v


@inlined
def _assemble_works(v, branch, push, reaction, problem, terms, jacobian):
    by_head, slope = jacobian.work_by_head, terms.slope
    for j in range(HEAD):
        by_head[0, j] = slope[1, j] * v
        by_head[1, j] = (slope[2, j] + slope[3, j]) * v
        by_head[2, j] = 0.0
    by_head[0, 1] += terms.total[1]
    by_head[1, 1] += terms.total[2] + terms.total[3] + reaction
    by_head[2, 1] += push
    by_head[2, 0] = -branch.engaged * problem.body.spring * v
    for o in range(problem.layout.oscillators):
        by_head[1, 0] += problem.laws.oscillators[o, 2] * problem.laws.oscillators[o, 0] * v
    for k in range(problem.layout.elements):
        jacobian.work_by_element[k] = terms.elements[k, 5] * v


@inlined
def factorise(gamma_h, branch, problem, jacobian):
    """Eliminate all states but the velocity from W."""
    layout, body, oscillators = problem.layout, problem.body, problem.laws.oscillators
    inverse, effective = jacobian.inverse, jacobian.effective
    s, inverse_age, by_first = 1.0 / gamma_h, 0.0, 0.0
    if layout.head > 2:
        # Where the slip of the first element ages the contacts, its row times age[2] is subtracted from that of the
        # age, k_3 = (f_3 - age[2] f_4 + age[0] k_1 + age[2] s k_4) inverse_age, and k_4 stands in both.
        inverse_age = 1.0 / (s - jacobian.age[1])
        by_first = jacobian.age[2] * s * inverse_age
    for j in range(HEAD):
        effective[j] = jacobian.velocity_by_head[j]
    for k in range(layout.elements):
        first = by_first if k == 0 else 0.0
        inverse[k] = 1.0 / (s - jacobian.element_by_self[k] - first * jacobian.element_by_head[k, 3])
        by_element = jacobian.velocity_by_element[k] + first * jacobian.velocity_by_head[3]
        for j in range(HEAD):
            effective[j] += by_element * jacobian.element_by_head[k, j] * inverse[k]
    for o in range(layout.oscillators):
        back = oscillators[o, 0] * gamma_h + oscillators[o, 1]
        at = layout.elements + o
        inverse[at] = 1.0 / (s + back)
        coupled = oscillators[o, 2] * body.inverse_mass * oscillators[o, 0]
        effective[0] -= body.feedback * coupled * (1.0 - back * inverse[at])
    pivot = s - effective[1] - effective[0] * gamma_h
    if layout.head > 2:
        pivot -= effective[2] * branch.direction * gamma_h + effective[3] * jacobian.age[0] * inverse_age
    inverse_lag = 1.0 / (s + 1.0 / body.drive_lag) if layout.lag >= 0 else 0.0
    return Factors(s, gamma_h, 1.0 / pivot, inverse_age, by_first, inverse_lag)


@inlined
def solve(f, v, branch, factors, problem, jacobian):
    """Solve W k = f in place; returns the velocity's entry."""
    layout, body, oscillators = problem.layout, problem.body, problem.laws.oscillators
    inverse, effective, over_s = jacobian.inverse, jacobian.effective, factors.inverse_s
    head, n = layout.head, layout.elements
    right = f[1] + effective[0] * f[0] * over_s
    if head > 2:
        if n > 0:
            f[3] -= jacobian.age[2] * f[head]
        right += effective[2] * f[2] * over_s + effective[3] * f[3] * factors.inverse_age
    for k in range(n):
        right += jacobian.velocity_by_element[k] * f[head + k] * inverse[k]
    if n > 0:
        right += factors.by_first * jacobian.velocity_by_head[3] * f[head] * inverse[0]
    for o in range(layout.oscillators):
        at = head + n + 2 * o
        spring = oscillators[o, 0] * over_s
        back = spring + oscillators[o, 1]
        moved = (f[at + 1] - spring * f[at]) * inverse[n + o]
        right += body.feedback * oscillators[o, 2] * body.inverse_mass * (spring * f[at] + back * moved)
    if layout.lag >= 0:
        f[layout.lag] *= factors.inverse_lag
        right += branch.engaged * f[layout.lag] * body.inverse_mass
    kv = right * factors.inverse_pivot
    f[1] = kv
    f[0] = (f[0] + kv) * over_s
    if head > 2:
        f[2] = (f[2] + branch.direction * kv) * over_s
        f[3] = (f[3] + jacobian.age[0] * kv) * factors.inverse_age
    for k in range(n):
        total = f[head + k]
        for j in range(head):
            total += jacobian.element_by_head[k, j] * f[j]
        f[head + k] = total * inverse[k]
    if head > 2 and n > 0:
        f[3] += factors.by_first * f[head]
    for o in range(layout.oscillators):
        at = head + n + 2 * o
        velocity = (f[at + 1] + oscillators[o, 0] * (f[0] - over_s * f[at])) * inverse[n + o]
        f[at + 1] = velocity
        f[at] = (f[at] + velocity) * over_s
    if layout.works >= 0:
        _solve_works(f, v, branch, factors, problem, jacobian)
    return kv


@inlined
def _solve_works(f, v, branch, factors, problem, jacobian):
    layout, oscillators = problem.layout, problem.laws.oscillators
    for w in range(WORKS):
        total = f[layout.works + w]
        for j in range(layout.head):
            total += jacobian.work_by_head[w, j] * f[j]
        if w == 0:
            for k in range(layout.state_elements):
                total += jacobian.work_by_element[k] * f[layout.head + k]
        elif w == 1:
            for k in range(layout.state_elements, layout.elements):
                total += jacobian.work_by_element[k] * f[layout.head + k]
            for o in range(layout.oscillators):
                at = layout.head + layout.elements + 2 * o
                force = oscillators[o, 0] * f[at] + oscillators[o, 1] * f[at + 1]
                total -= v * oscillators[o, 2] * force
        elif layout.lag >= 0:
            total += branch.engaged * v * f[layout.lag]
        f[layout.works + w] = total * factors.inverse_s


HISTORY = 7
"""Numbers kept of a step: start, 1/length, and the polynomial coefficients of the velocity over the step."""
KEPT_STEPS = 1 << 17
"""Steps kept for the delayed speed. A power of two, since rows of the ring buffer are found by a bit mask."""


class Margins(NamedTuple):
    """Speed below which a motion against the branch is not a reversal, m/s, and accuracy of the spring's force, N."""

    speed: float
    force: float


@inlined
def interpolate(part, before, after, d0, d1, d2):
    """Dense output at a part of a step."""
    return (1.0 - part) * before + part * (after + (1.0 - part) * (d0 + part * (d1 + part * d2)))


@inlined
def state_at(part, j, work):
    """Dense output of state `j` at a part of the step."""
    dense = work.dense
    return interpolate(part, work.y[j], work.fresh[j], dense[j, 0], dense[j, 1], dense[j, 2])


@inlined
def keep_velocity(t, h, work):
    """Append the velocity of an accepted step to the history; False when the ring buffer is full."""
    ring, rows = work.ring, work.history.shape[0]
    if ring[1] - ring[0] == rows:
        return False
    kept, dense = work.history[ring[1] & (rows - 1)], work.dense
    kept[0], kept[1], kept[2] = t, 1.0 / h, work.y[1]
    kept[3] = work.fresh[1] - work.y[1] + dense[1, 0]
    kept[4], kept[5], kept[6] = dense[1, 1] - dense[1, 0], dense[1, 2] - dense[1, 1], -dense[1, 2]
    ring[1] += 1
    return True


@inlined
def delayed_speed(t, work):
    """Speed at the past time `t` and its rate; before the first step, the initial speed."""
    history, ring = work.history, work.ring
    k, newest, mask = ring[0], ring[1], history.shape[0] - 1
    if newest == 0 or t <= history[k & mask, 0]:
        return work.initial_speed, 0.0
    while k + 1 < newest and history[(k + 1) & mask, 0] <= t:
        k += 1
    at = history[k & mask]
    part = (t - at[0]) * at[1]
    v = at[2] + part * (at[3] + part * (at[4] + part * (at[5] + part * at[6])))
    rate = (at[3] + part * (2.0 * at[4] + part * (3.0 * at[5] + part * (4.0 * at[6])))) * at[1]
    return abs(v), rate if v >= 0.0 else -rate


@inlined
def forget_before(t, work):
    """Drop the steps of the history that end before `t`."""
    history, ring, mask = work.history, work.ring, work.history.shape[0] - 1
    while ring[0] + 1 < ring[1] and history[(ring[0] + 1) & mask, 0] <= t:
        ring[0] += 1


@inlined
def side_of_backlash(stretched, opening, gap, slack):
    """Whether the backlash transmits force at the spring force `stretched` (its rate `opening`), and the edge, N."""
    if stretched > gap + 2.0 * slack or (stretched > gap - 2.0 * slack and opening > 0.0):
        return 1.0, gap
    if stretched < -gap - 2.0 * slack or (stretched < -gap + 2.0 * slack and opening < 0.0):
        return 1.0, -gap
    return 0.0, 0.0


@inlined
def spring_force(part, t, h, branch, problem, work):
    """Force that the spring would have without backlash, at a part of the step, N."""
    if problem.layout.lag >= 0:
        command = state_at(part, problem.layout.lag, work)
    else:
        command, _ = drive_at(t + part * h, problem.drive, branch.segment)
    return command - problem.body.spring * state_at(part, POSITION, work)


@inlined
def _leaves_branch(part, t, h, branch, margins, problem, work):
    """Whether the motion has reversed, or the backlash changed sides, at a part of the step."""
    slack = margins.force
    if branch.direction * state_at(part, VELOCITY, work) < -margins.speed:
        return True
    gap = problem.body.half_gap
    if gap == 0.0:
        return False
    force = spring_force(part, t, h, branch, problem, work)
    if branch.engaged == 0.0:
        return abs(force) > gap + 3.0 * slack
    return force < gap - 3.0 * slack if branch.edge > 0.0 else force > -gap + 3.0 * slack


@inlined
def _bulge(j, work):
    """Largest deviation of the dense output of state `j` from a line between the ends of the step."""
    dense = work.dense
    return 0.25 * (abs(dense[j, 0]) + abs(dense[j, 1]) + abs(dense[j, 2]))


@inlined
def _stays_on_branch(t, h, branch, problem, work):
    """Whether bounds of the dense output rule out a reversal and a change of sides of the backlash."""
    lag, gap = problem.layout.lag, problem.body.half_gap
    if min(branch.direction * work.y[1], branch.direction * work.fresh[1]) <= _bulge(VELOCITY, work):
        return False
    if gap == 0.0:
        return True
    bulge = problem.body.spring * _bulge(POSITION, work)
    if lag >= 0:
        bulge += _bulge(lag, work)
    elif problem.drive.amplitude != 0.0:
        return False
    before = spring_force(0.0, t, h, branch, problem, work)
    after = spring_force(1.0, t, h, branch, problem, work)
    if branch.engaged == 0.0:
        room = gap - max(abs(before), abs(after))
    else:
        side = 1.0 if branch.edge > 0.0 else -1.0
        room = min(side * before, side * after) - gap
    return room > bulge


@inlined
def part_on_branch(t, h, branch, margins, problem, work):
    """Part of the step up to which the motion neither reverses nor changes sides of the backlash; 1 for all of it."""
    if _stays_on_branch(t, h, branch, problem, work):
        return 1.0
    good, bad = 0.0, 1.0
    searching = True
    for probe in range(1, 55):
        if bad - good < 1e-13:
            break
        # Four probes along the step, then bisection.
        part = 0.25 * probe if searching else 0.5 * (good + bad)
        if _leaves_branch(part, t, h, branch, margins, problem, work):
            bad, searching = part, False
        else:
            good = part
            if searching and probe == 4:
                return 1.0
    return bad


STAGES = 8
_TABLEAU = tomllib.loads(Path(__file__).with_suffix(".toml").read_text(encoding="utf-8"))
GAMMA: float = _TABLEAU["gamma"]
TIME, TIME_SLOPE, H = (np.array(_TABLEAU[name]) for name in ("time", "time_slope", "H"))


def _lower(rows: list[list[float]]) -> np.ndarray:
    full = np.zeros((STAGES, STAGES))
    for i, row in enumerate(rows):
        full[i, : len(row)] = row
    return full


A, C = _lower(_TABLEAU["A"]), _lower(_TABLEAU["C"])
# Stages 7 and 8 start from stage 6's point, with k_6 and then k_7 added.
A[6, :5] = A[5, :5]
A[6, 5] = 1.0
A[7, :5] = A[5, :5]
A[7, 5:7] = 1.0


@inlined
def _stage_point(i, size, inverse_h, work):
    """Point y + sum_j A_ij k_j of stage `i`, and its coupling sum_j C_ij k_j / h to the earlier stages."""
    increments = work.increments
    for j in range(size):
        point, coupling = 0.0, 0.0
        for m in range(i):
            point += A[i, m] * increments[m, j]
            coupling += C[i, m] * increments[m, j]
        work.point[j] = work.y[j] + point
        work.coupling[j] = coupling * inverse_h


@inlined
def evaluate(t, y, branch, problem, work, f):
    """Rates f at one instant, without slopes."""
    delayed = (0.0, 0.0)
    if problem.body.friction_delay > 0.0:
        delayed = delayed_speed(t - problem.body.friction_delay, work)
    friction_terms(t, y, branch.direction, delayed, VALUES, problem, work.terms)
    rates_of_change(t, y, branch, problem, work.terms, f)


@inlined
def _squared_error(size, tolerance, work):
    """Mean square of the error estimate, the last increment, over the tolerance of each state."""
    error = 0.0
    for j in range(size):
        scale = tolerance.absolute[j] + tolerance.relative * max(abs(work.y[j]), abs(work.fresh[j]))
        off = work.increments[STAGES - 1, j] / scale
        error += off * off
    error /= tolerance.counted
    return error if math.isfinite(error) else math.inf


def _step(memory, arguments):
    """The increments of all stages, and the state after the step, into `work`; returns the error estimate, as
    `_squared_error`, or -1 where a number is not finite."""
    t, h, branch = arguments
    problem, tolerance, _, work, _ = memory[0]
    size, v = problem.layout.size, work.y[1]
    factors = factorise(GAMMA * h, branch, problem, work.jacobian)
    for i in range(STAGES):
        k = work.increments[i]
        late = h * TIME_SLOPE[i]
        if i == 0:
            for j in range(size):
                k[j] = work.rates[j] + late * work.jacobian.time[j]
        else:
            at = t + TIME[i] * h
            _stage_point(i, size, 1.0 / h, work)
            evaluate(at, work.point, branch, problem, work, k)
            for j in range(size):
                k[j] += work.coupling[j] + late * work.jacobian.time[j]
        if not math.isfinite(solve(k, v, branch, factors, problem, work.jacobian)):
            return -1.0
    for j in range(size):
        work.fresh[j] = work.point[j] + work.increments[STAGES - 1, j]
    return _squared_error(size, tolerance, work)


STEP = Part(_step, (0.0, 0.0, BRANCH))
"""One step from `t` of length `h` on a branch."""


@inlined
def dense_coefficients(j, work):
    """Coefficients D of the dense output of state `j`."""
    for i in range(3):
        total = 0.0
        for m in range(STAGES):
            total += H[i, m] * work.increments[m, j]
        work.dense[j, i] = total
