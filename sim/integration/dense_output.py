"""Dense output of an accepted step, the delayed speed read off it, and the events that end a step early; compiled.

Within a step every law is continued smoothly past a reversal and past an edge of the backlash (`Branch`). The step is
valid up to the first of these events only, which is located on its dense output.
"""

from typing import NamedTuple

from sim.integration.problem import POSITION, VELOCITY, inlined
from sim.integration.right_hand_side import drive_at

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
