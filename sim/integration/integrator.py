"""Adaptive stiff integration of one axis: Rodas5P with the exact Jacobian, in compiled code.

Two measures keep kinks of the laws from spoiling the order. A drive that is linear in pieces is stepped from knot to
knot. And within a step the direction of the motion and the side of the backlash are kept (`Branch`), so that every law
is smooth; the step is then accepted up to the reversal alone, located on its dense output.

Step size: Gustafsson, ACM Trans. Math. Software 20 (1994) 496 (predictive controller).

This module imports numba: import it only when something is integrated.
"""

from __future__ import annotations

import functools
import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any, NamedTuple

import numpy as np

from sim.effects.catalogue import Model
from sim.effects.effect import AddedOscillator, Axis, Backlash, DelayedSpeed, Effect, FirstOrderLag, TransportDelay
from sim.integration.compiled import kernels
from sim.integration.compiled.views import OverViews, Part, Zeros
from sim.integration.drive import Drive, compressed, delayed
from sim.integration.problem import (
    AXIS_FIELDS,
    BRANCH,
    COLUMNS,
    FORCE,
    FRICTION,
    POSITION,
    SLOPES,
    SOURCES,
    VELOCITY,
    WITH_SLOPES,
    WORKS,
    Body,
    Branch,
    Input,
    Jacobian,
    Laws,
    Layout,
    Output,
    Problem,
    Terms,
    Tolerance,
    Workspace,
    drive_at,
    friction_terms,
    inlined,
    rates_of_change,
)
from sim.integration.rodas5p import (
    HISTORY,
    KEPT_STEPS,
    STAGES,
    STEP,
    Margins,
    assemble,
    delayed_speed,
    dense_coefficients,
    evaluate,
    forget_before,
    interpolate,
    keep_velocity,
    part_on_branch,
    side_of_backlash,
    state_at,
)
from sim.numerics.compilation import INLINED
from stagecad.parameters.errors import InputError, require

SCALE = 1e-3
"""Scale of position and velocity, m and m/s: an error is kept below tolerance times (scale + value)."""


@dataclass(frozen=True)
class Plan:
    """A model with its drive, laid out for the integrator; keep it while its addresses are in use."""

    drive: Drive  # after delays
    laws: Laws  # kernels and constants
    # states before the friction elements: 2, or 4 where a law depends on the distance travelled or the contact age
    head: int
    scales: np.ndarray  # typical size of each element's state, (elements,)
    axis: _Mechanics  # realisation of the effects of drive, structure and memory
    memory_length: float  # of the contact age, m
    ages_by_slip: bool  # of the friction state model's first element
    required: frozenset[str]  # quantities of the axis that the laws depend on
    # kernels, tables: owners of the memory that `laws` has the addresses of
    kernels: list[kernels.Kernel]
    tables: list[np.ndarray]

    @property
    def elements(self) -> int:
        return self.scales.size

    def compressed(self, begin: float, end: float, tolerance: float) -> Plan:
        """The plan with segments of its drive joined where the tolerance allows it; not with a backlash, whose gap the
        force itself opens and closes."""
        if self.axis.half_gap > 0.0:
            return self
        drive = compressed(self.drive, begin, end, self.axis.mass, tolerance * SCALE)
        return self if drive is self.drive else replace(self, drive=drive)

    def problem(self, memory_length: float, energy: bool) -> Problem:
        """The equations for the compiled integrator; with `energy` the works are states too."""
        drive, axis = self.drive, self.axis
        oscillators = self.laws.oscillators.shape[0]
        size = self.head + self.elements + 2 * oscillators
        lag = size if axis.lag > 0.0 else -1
        size += int(axis.lag > 0.0)
        layout = Layout(
            head=self.head,
            elements=self.elements,
            state_elements=int(self.laws.groups[0, 3]),
            oscillators=oscillators,
            lag=lag,
            works=size if energy else -1,
            size=size + (WORKS if energy else 0),
        )
        body = Body(
            inverse_mass=1.0 if drive.prescribes else 1.0 / axis.mass,
            feedback=0.0 if drive.prescribes else 1.0,
            spring=float(drive.stiffness),
            memory_length=float(memory_length),
            ages_by_slip=float(self.ages_by_slip),
            half_gap=axis.half_gap,
            drive_lag=axis.lag,
            friction_delay=axis.friction_delay,
        )
        segments = Input(drive.knots, drive.values, drive.rates, *map(float, drive.wave))
        return Problem(layout, body, segments, self.laws)

    def start(self, layout: Layout, position: float, velocity: float, bristle: Any) -> np.ndarray:
        """Initial state, (size,); an added oscillator starts in step with the axis."""
        start = np.zeros(layout.size)
        start[0], start[1] = position, velocity
        at = self.head + self.elements
        if bristle is not None:
            given = np.atleast_1d(np.asarray(bristle, dtype=float))
            start[self.head : self.head + given.size] = given
        for square, damping, _ in self.laws.oscillators:
            start[at], start[at + 1] = position - damping / square * velocity, velocity
            at += 2
        if layout.lag >= 0:
            amplitude, _, phase = self.drive.wave
            start[layout.lag] = self.drive.values[0] + amplitude * math.cos(phase)
        return start

    def tolerance(self, layout: Layout, relative: float, longest_step: float, most_steps: int) -> Tolerance:
        """Accuracy of every state."""
        absolute = np.full(layout.size, relative * SCALE)
        if self.head > 2:
            absolute[2] = relative * SCALE if "travelled" in self.required else math.inf
            absolute[3] = relative if "contact_age" in self.required else math.inf
        absolute[self.head : self.head + self.elements] = relative * self.scales
        if layout.lag >= 0:
            absolute[layout.lag] = relative * max(float(np.abs(self.drive.values).max()), self.drive.wave[0], 1e-3)
        return Tolerance(relative, absolute, int(np.isfinite(absolute).sum()), float(longest_step), int(most_steps))


@dataclass(frozen=True)
class _Mechanics:
    """Time-domain realisation of the effects of drive, structure and memory."""

    mass: float  # that moves with the axis itself, kg
    half_gap: float = 0.0  # half the backlash times the spring stiffness, N
    lag: float = 0.0  # time constant of the drive, s
    friction_delay: float = 0.0  # of the speed that the friction level depends on, s


class Surroundings(NamedTuple):
    """Normal load (N) and temperature (degC), (m, 2), at instants that begin at `begin` (s), `step` (s) apart."""

    values: np.ndarray
    begin: float = 0.0
    step: float = 1.0


def plan_of(model: Model, drive: Drive, mass: float, surroundings: Surroundings) -> Plan:
    """Lay a model out for the integrator.

    Raises:
        InputError: an effect that cannot be integrated, or not with this drive.
    """
    for effect in model.effects:
        reason = kernels.unsupported(effect)
        require(not reason, f"simulation: effect '{effect.name}' {reason}")
    tables = [np.array(p if len(p) else (0.0,), dtype=float) for p in model.values]
    drive, axis, oscillators = _mechanics(model, drive, mass)
    groups, scales, kept = _groups(model, tables)
    base = np.array([0.0, 1.0, 0.0])
    varying = surroundings.values.shape[0] > 1
    rows: list[tuple[int, int, int, int]] = []
    required: set[str] = set()
    for effect, p, table in zip(model.effects, model.values, tables):
        friction, force = kernels.instantaneous_terms(effect)
        if not friction and not force:
            continue
        is_constant = kernels.is_built_in(effect) and not kernels.dependence(effect, *kernels.LAWS)
        if is_constant and not (varying and effect.needs):
            _add_constant(effect, p, base, surroundings)
            continue
        required |= kernels.required_quantities(effect)
        kernel = kernels.effect_kernel(effect)
        kept.append(kernel)
        row = (kernel.address, table.ctypes.data)
        # The friction level depends on the delayed speed, and the force does not.
        is_delayed = axis.friction_delay > 0.0 and "velocity" in kernels.dependence(effect, "level", "factor")
        if is_delayed and force:
            rows += [(*row, FRICTION, 1), (*row, FORCE, 0)]
        else:
            rows.append((*row, FRICTION * friction + FORCE * force, int(is_delayed)))
    return Plan(
        drive=drive,
        laws=Laws(np.array(rows, dtype=np.int64).reshape(-1, 4), groups, base, *surroundings, oscillators),
        head=4 if required & {"travelled", "contact_age"} else 2,
        scales=scales,
        axis=axis,
        memory_length=next((p.memory_length for p in model.values if hasattr(p, "memory_length")), math.inf),
        ages_by_slip=model.state_effect is not None and model.state_effect.friction_state.ages,
        required=frozenset(required),
        kernels=kept,
        tables=tables,
    )


def _mechanics(model: Model, drive: Drive, mass: float) -> tuple[Drive, _Mechanics, np.ndarray]:
    """Drive after delays, mechanics of the axis, and the rows of `Laws.oscillators`."""
    oscillators: list[tuple[float, float, float]] = []
    half_gap, lag, friction_delay, carried = 0.0, 0.0, 0.0, 0.0
    for effect, p in zip(model.effects, model.values):
        part = effect.time_domain(p) if effect.time_domain is not None else None
        if isinstance(part, Backlash | FirstOrderLag | TransportDelay) and drive.prescribes:
            raise InputError(
                f"simulation: effect '{effect.name}' acts on a drive, and here the motion itself is imposed"
            )
        if isinstance(part, Backlash):
            require(drive.stiffness > 0.0, f"simulation: effect '{effect.name}' needs a drive that pulls a spring")
            half_gap += 0.5 * part.gap * drive.stiffness
        elif isinstance(part, FirstOrderLag):
            if lag > 0.0:
                raise InputError("simulation: one lag of the drive at most")
            lag = part.time_constant
        elif isinstance(part, TransportDelay):
            drive = delayed(drive, part.delay)
        elif isinstance(part, DelayedSpeed):
            friction_delay += part.delay
        elif isinstance(part, AddedOscillator):
            w = 2.0 * math.pi * part.frequency
            oscillators.append((w * w, 2.0 * part.damping * w, part.mass_ratio * mass))
            carried += part.mass_ratio
    if carried >= 1.0:
        raise InputError(f"simulation: {carried:g} of the mass belongs to added oscillators; must be below 1")
    axis = _Mechanics(mass * (1.0 - carried), half_gap, lag, friction_delay)
    return drive, axis, np.array(oscillators, dtype=float).reshape(-1, 3)


def _groups(model: Model, tables: list[np.ndarray]) -> tuple[np.ndarray, np.ndarray, list[kernels.Kernel]]:
    """Rows of `Laws.groups`, scales of their elements, and their kernels; the friction state model comes first. Tables
    of elements are appended to `tables`, which own the memory."""
    first_row = [(0, 0, 0, 0)] if model.state_effect is None else []
    having = [i for i, e in enumerate(model.effects) if e.friction_state is not None or e.parallel_element is not None]
    rows, scales, kept = first_row, [], []
    for i in sorted(having, key=lambda i: model.effects[i].friction_state is None):
        effect, p = model.effects[i], model.values[i]
        declared = effect.friction_state or effect.parallel_element
        kernel, count = kernels.state_kernel(effect), int(declared.elements(p))
        kept.append(kernel)
        table = tables[i]
        if declared.table is not None:
            tables.append(table := np.ascontiguousarray(declared.table(p)))
        rows.append((kernel.address, table.ctypes.data, len(scales), count))
        scales += [float(declared.scale(p))] * count
    return np.array(rows, dtype=np.int64), np.array(scales), kept


def _add_constant(effect: Effect, p: Any, base: np.ndarray, surroundings: Surroundings) -> None:
    """Add an effect that stays constant to the constant terms."""
    load, temperature = surroundings.values[0]
    axis = Axis(0.0, 0.0, 0.0, math.nan, load, temperature, 0.0, math.nan, 0.0, 1.0)
    if effect.level is not None:
        base[0] += effect.level(axis, p)
    if effect.factor is not None:
        base[1] *= effect.factor(axis, p)
    if effect.force is not None:
        base[2] += effect.force(axis, p)


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
    at a reversal is that of the acceleration. moves: whether the direction of the branch is that of the motion
    already."""
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
