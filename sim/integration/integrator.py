"""Adaptive stiff integration of one axis: Rodas5P with the exact Jacobian, in compiled code.

Two measures keep kinks of the laws from spoiling the order. A drive that is linear in pieces is stepped from knot to
knot. And within a step the direction of the motion and the side of the backlash are kept (`Branch`), so that every law
is smooth; the step is then accepted up to the reversal alone, located on its dense output.

Step size: Gustafsson, ACM Trans. Math. Software 20 (1994) 496 (predictive controller).

This module imports numba: import it only when something is integrated.
"""

import functools
import math
from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from sim.integration.arrowhead import assemble
from sim.integration.compiled.views import OverViews, Part, Zeros
from sim.integration.dense_output import (
    HISTORY,
    KEPT_STEPS,
    Margins,
    delayed_speed,
    forget_before,
    interpolate,
    keep_velocity,
    part_on_branch,
    side_of_backlash,
    state_at,
)
from sim.integration.problem import (
    AXIS_FIELDS,
    BRANCH,
    COLUMNS,
    POSITION,
    SLOPES,
    SOURCES,
    VELOCITY,
    WITH_SLOPES,
    WORKS,
    Branch,
    Jacobian,
    Output,
    Problem,
    Terms,
    Tolerance,
    Workspace,
    inlined,
)
from sim.integration.right_hand_side import drive_at, friction_terms, rates_of_change
from sim.integration.rodas5p import STAGES, STEP, dense_coefficients, evaluate
from sim.numerics.compilation import INLINED

DONE, STEP_TOO_SMALL, NOT_FINITE, TOO_MANY_STEPS = 0, 1, 2, 3
REPORT_HEAD = 4
"""Numbers of the report before the state."""

_take_step = STEP.call


class _Attempt(NamedTuple):
    """An accepted step, or the reason why there is none."""

    outcome: int  # `DONE` where a step is accepted
    h: float  # length, s
    part: float  # of the step that is accepted
    next_h: float  # length that the next step need not fall below, s
    gain: float  # ratio of the step length that meets the tolerance to h
    rejected: int  # attempts that failed
    lands: bool  # whether the step ends where a segment of the drive does


def _linearise_part(memory, arguments):
    """Write laws, rates and Jacobian at the start `t` of a step to `work`; returns the direction of the motion, which
    at a reversal is that of the acceleration.

    moves: whether the direction of the branch is that of the motion already.
    """
    t, branch, moves = arguments
    problem, _, _, work, _ = memory[0]
    y, delayed, acting, turned = work.y, (0.0, 0.0), (0.0, 0.0), False
    if problem.body.friction_delay > 0.0:
        delayed = delayed_speed(t - problem.body.friction_delay, work)
        forget_before(t - problem.body.friction_delay, work)
    for _ in range(2):
        friction_terms(t, y, branch.direction, delayed, WITH_SLOPES, problem, work.terms)
        acting = rates_of_change(t, y, branch, problem, work.terms, work.rates)
        if moves or turned or work.rates[1] * branch.direction >= 0.0:
            break
        branch = Branch(-branch.direction, branch.engaged, branch.edge, branch.segment)
        turned = True
    assemble(t, y, branch, acting, problem, work.terms, work.jacobian)
    return branch.direction


LINEARISE = Part(_linearise_part, (0.0, BRANCH, 0))
_linearise = LINEARISE.call


@inlined
def _start_step(t, segment, direction, margins, memory):
    """Branch of the step that begins at `t`; the rates and the Jacobian there go to `work`."""
    problem, _, _, work, parts = memory[0]
    layout, body, y = problem.layout, problem.body, work.y
    engaged, edge = 1.0, 0.0
    if body.half_gap > 0.0:
        command, rate = drive_at(t, problem.drive, segment)
        if layout.lag >= 0:
            command, rate = y[layout.lag], (command - y[layout.lag]) / body.drive_lag
        stretched, opening = command - body.spring * y[0], rate - body.spring * y[1]
        engaged, edge = side_of_backlash(stretched, opening, body.half_gap, margins.force)
    moves = abs(y[1]) > 2.0 * margins.speed
    if moves:
        direction = 1.0 if y[1] > 0.0 else -1.0
    direction = _linearise(parts[0], memory, (t, Branch(direction, engaged, edge, segment), moves))
    return Branch(direction, engaged, edge, segment)


@inlined
def _part_accepted(t, h, branch, margins, problem, work):
    """Part of the step within which its branch is valid."""
    dense_coefficients(VELOCITY, work)
    margins = Margins(3.0 * margins.speed, margins.force)
    if problem.body.half_gap > 0.0:
        dense_coefficients(POSITION, work)
        if problem.layout.lag >= 0:
            dense_coefficients(problem.layout.lag, work)
    return part_on_branch(t, h, branch, margins, problem, work)


@inlined
def _attempt(t, h, limit, attempts, branch, margins, memory):
    """Try steps from `t`, of length `h` or shorter and up to `limit`, until one is accepted or no attempts are left."""
    problem, _, _, work, parts = memory[0]
    next_h, lands = h, t + 1.0001 * h >= limit
    if lands:
        h = limit - t
    rejected, shortened = 0, 0
    while True:
        error = _take_step(parts[1], memory, (t, h, branch))
        finite = error >= 0.0
        if not finite:
            error = math.inf
        # The error is squared; the length that meets the tolerance goes with its fifth root.
        gain = max(error, 1e-12) ** -0.1
        if error <= 1.0:
            part = _part_accepted(t, h, branch, margins, problem, work)
            lands = lands and part == 1.0
            if part == 1.0 or shortened == 4 or part > 0.9:
                return _Attempt(DONE, h, part, next_h, gain, rejected, lands)
            # Dense output is not as accurate as the step itself where the step is long for the stiffness.
            h *= 1.01 * part
            shortened += 1
            continue
        rejected += 1
        lands = False
        h *= 0.25 if error == math.inf else max(0.2, 0.9 * gain)
        next_h = h
        outcome = DONE
        if h < 1e-14 * max(1.0, abs(t)) or not h > 0.0:
            outcome = STEP_TOO_SMALL if finite else NOT_FINITE
        elif rejected >= attempts:
            outcome = TOO_MANY_STEPS
        if outcome != DONE:
            return _Attempt(outcome, h, 0.0, next_h, gain, rejected, False)


def _write_outputs(memory, arguments):
    """Write states and forces at the output's rows from `first` to before `end`, which lie within the step."""
    t, h, first, end, branch = arguments
    problem, _, output, work, _ = memory[0]
    inverse_h = 1.0 / h
    for j in range(output.states.shape[0]):
        state = output.states[j]
        before, after = work.y[j], work.fresh[j]
        d0, d1, d2 = work.dense[j, 0], work.dense[j, 1], work.dense[j, 2]
        for o in range(first, end):
            state[o] = interpolate((output.time[o] - t) * inverse_h, before, after, d0, d1, d2)
    if output.forces.shape[0] == 0:
        return 0.0
    for o in range(first, end):
        for j in range(problem.layout.size):
            work.point[j] = output.states[j, o]
        evaluate(output.time[o], work.point, branch, problem, work, work.rates)
        command, _ = drive_at(output.time[o], problem.drive, branch.segment)
        if problem.layout.lag >= 0:
            command = work.point[problem.layout.lag]
        total = work.terms.total
        output.forces[o, 0], output.forces[o, 1], output.forces[o, 2] = total[0], total[1], total[2] + total[3]
        stretched = command - problem.body.spring * work.point[0]
        output.forces[o, 3] = branch.engaged * (stretched - branch.edge)
    return 0.0


OUTPUTS = Part(_write_outputs, (0.0, 0.0, 0, 0, BRANCH))
_write = OUTPUTS.call


@inlined
def _finish_step(t, after, step, next_output, branch, memory):
    """Write the outputs up to `after`, and put the state there; returns the first output beyond, or -1 where the
    history of the speed is full."""
    problem, _, output, work, parts = memory[0]
    due = next_output
    while due < output.time.shape[0] and output.time[due] <= after:
        due += 1
    needed = 0
    if step.part < 1.0:
        needed = problem.layout.size
    elif due > next_output:
        needed = output.states.shape[0]
    for j in range(needed):
        if j != VELOCITY:
            dense_coefficients(j, work)
    _write(parts[2], memory, (t, step.h, next_output, due, branch))
    if problem.body.friction_delay > 0.0 and not keep_velocity(t, step.h, work):
        return -1
    for j in range(problem.layout.size):
        work.y[j] = state_at(step.part, j, work) if step.part < 1.0 else work.fresh[j]
    return due


def _steps(memory):
    """The integration, in arrays that are given."""
    problem, tolerance, output, work, _ = memory[0]
    segments = problem.drive.rates.shape[0]
    t, end = output.time[0], output.time[output.time.shape[0] - 1]
    # Of a type that does not change: a literal zero would compile what it is passed to once more.
    next_output, segment, steps, rejected, outcome = np.int64(0), np.int64(0), 0, 0, DONE
    while segment + 1 < segments and problem.drive.knots[segment + 1] <= t:
        segment += 1
    direction = 1.0 if work.y[1] >= 0.0 else -1.0
    margins = Margins(1e-3 * tolerance.absolute[1], 1e-3 * tolerance.absolute[0] * problem.body.spring)
    longest = tolerance.longest_step
    if problem.body.friction_delay > 0.0:
        longest = min(longest, problem.body.friction_delay)
    h = min(longest, max((end - t) * 1e-6, 1e-12))
    last_h, last_gain = 0.0, 1.0
    while t < end:
        if steps + rejected >= tolerance.most_steps:
            outcome = TOO_MANY_STEPS
            break
        limit = end
        if segment + 1 < segments and problem.drive.knots[segment + 1] < end:
            limit = problem.drive.knots[segment + 1]
        branch = _start_step(t, segment, direction, margins, memory)
        direction = branch.direction
        attempts = tolerance.most_steps - steps - rejected
        step = _attempt(t, h, limit, attempts, branch, margins, memory)
        rejected += step.rejected
        if step.outcome != DONE:
            outcome = step.outcome
            break
        steps += 1
        after = limit if step.lands else t + step.part * step.h
        next_output = _finish_step(t, after, step, next_output, branch, memory)
        if next_output < 0:
            outcome = TOO_MANY_STEPS
            break
        t = after
        factor = min(6.0, 0.9 * step.gain)
        if last_h > 0.0:
            # A rise of the error over the last two steps is expected to continue.
            factor = min(factor, 0.9 * step.h / last_h * step.gain * step.gain / last_gain)
        last_h, last_gain = step.h, min(step.gain, 2.5)
        if step.rejected > 0:
            factor = min(factor, 1.0)
        h = min(longest, max(step.h * factor, step.next_h if factor >= 1.0 else 0.0))
        if step.lands and segment + 1 < segments and problem.drive.knots[segment + 1] <= t:
            segment += 1
    output.report[0], output.report[1], output.report[2], output.report[3] = outcome, t, steps, rejected
    for j in range(problem.layout.size):
        output.report[REPORT_HEAD + j] = work.y[j]


_compiled_steps = OverViews(_steps, SOURCES, INLINED["fastmath"], [LINEARISE, STEP, OUTPUTS])


@functools.lru_cache(maxsize=64)
def _workspace(size: int, keeps_history: bool) -> Workspace:
    """The arrays of an integration with `size` states; those whose values are given are empty."""
    m = max(size - 2, 1)
    jacobian = Jacobian(
        velocity_by_head=Zeros((4,)),
        element_by_self=Zeros((m,)),
        velocity_by_element=Zeros((m,)),
        element_by_head=Zeros((m, 4)),
        age=Zeros((3,)),
        work_by_head=Zeros((WORKS, 4)),
        work_by_element=Zeros((m,)),
        time=Zeros((size,)),
        inverse=Zeros((m,)),
        effective=Zeros((4,)),
    )
    return Workspace(
        y=np.empty(0),
        fresh=Zeros((size,)),
        rates=Zeros((size,)),
        point=Zeros((size,)),
        coupling=Zeros((size,)),
        increments=Zeros((STAGES, size)),
        dense=Zeros((size, 3)),
        history=Zeros((KEPT_STEPS if keeps_history else 1, HISTORY)),
        ring=Zeros((2,), int),
        initial_speed=0.0,
        terms=Terms(Zeros((AXIS_FIELDS,)), Zeros((4 * COLUMNS,)), Zeros((m, 8)), Zeros((4,)), Zeros((4, SLOPES))),
        jacobian=jacobian,
    )


def begin_compilation(arguments: Callable[[], tuple[Problem, Tolerance, Output]]) -> None:
    """Let another process begin to compile the integrator where the disk lacks it; `arguments` gives those of
    `integrate` for any model, such as one without laws."""
    if not _compiled_steps.is_compiled:
        problem, tolerance, output = arguments()
        start = np.zeros(problem.layout.size)
        _compiled_steps.begin_parts(problem, tolerance, output, _workspace_from(start, problem))


def integrate(problem: Problem, start: np.ndarray, tolerance: Tolerance, output: Output) -> None:
    """Integrate from the first to the last instant of `output`; the report is [outcome, time, accepted steps, rejected
    attempts, *state]."""
    _compiled_steps(problem, tolerance, output, _workspace_from(start, problem))


def _workspace_from(start: np.ndarray, problem: Problem) -> Workspace:
    work = _workspace(problem.layout.size, problem.body.friction_delay > 0.0)
    return work._replace(y=start.copy(), initial_speed=abs(start[1]))
