"""Jacobian of an axis and the linear solve of a Rosenbrock stage, in compiled code.

The states after the head depend on the rest through position, velocity and friction level alone, and act on it through
the velocity alone. So W = I/(gamma h) - J is an arrowhead: all states but the velocity are eliminated in one pass, and
one solve costs O(number of states).
"""

from typing import NamedTuple

from sim.integration.problem import WORKS, inlined
from sim.integration.right_hand_side import drive_at

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
