"""The equations of an axis as named tuples of numbers and arrays, which compiled functions receive.

State y = [position, velocity, (distance travelled, contact age) | internal friction states z_1 .. z_n | position and
velocity of each added oscillator | lagged drive | works of friction state, other forces, drive]. The two in brackets,
the lagged drive and the works are present only where the model or the user needs them.

Importing this module imports numba.
"""

import math
from collections.abc import Callable
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from llvmlite import ir
from numba import types
from numba.core import cgutils
from numba.extending import intrinsic

from sim.integration import compiled
from sim.integration.compiled.kernels import QUANTITIES
from sim.integration.compiled.views import Zeros
from sim.numerics.compilation import INLINED, compile_function

SOURCES = [
    str(path)
    for path in [
        *sorted(Path(__file__).parent.glob("*.py")),
        *sorted(Path(__file__).parent.glob("*.toml")),
        *sorted(Path(compiled.__file__).parent.glob("*.py")),
    ]
]
"""Files that the compiled integrator depends on."""

SLOPES = len(QUANTITIES)
COLUMNS = 1 + SLOPES
"""Numbers that the kernel of an effect writes for each of its laws: the value, then the slopes."""
AXIS_FIELDS = 10
WORKS = 3
"""Integrated works: of the friction state model, of the other forces, of the drive."""

# Not Python's integers: with each of those that a compiled function is called with, numba compiles it once more.
POSITION, VELOCITY = np.int64(0), np.int64(1)
"""Indices of the first states."""
VALUES, WITH_SLOPES = np.int64(0), np.int64(1)
"""Whether the laws are evaluated with their slopes."""


def inlined(function: Callable[..., Any]) -> Any:
    """Decorator: compile a function that becomes part of the compiled function that calls it."""
    return compile_function(function, SOURCES, **INLINED)


class Layout(NamedTuple):
    """Order of the states."""

    head: int  # 2, or 4 where a law depends on the distance travelled or on the contact age
    elements: int  # internal states of all friction elements
    state_elements: int  # those of the friction state model, which come first
    oscillators: int  # added oscillators
    lag: int  # index of the lagged drive, or -1
    works: int  # index of the first work, or -1
    size: int  # number of states


class Body(NamedTuple):
    """Constants of the axis, SI."""

    inverse_mass: float  # of what moves with the axis itself, 1/kg; 1 where the motion is imposed
    feedback: float  # 1, or 0 where the motion is imposed and the forces do not act on it
    spring: float  # stiffness between drive and axis, N/m
    memory_length: float  # of the contact age, m
    ages_by_slip: float  # 1 where the contacts age by the slip of the first element, 0 by the motion of the axis
    half_gap: float  # half the backlash times the spring stiffness, N
    drive_lag: float  # time constant of the drive, s; zero without
    friction_delay: float  # delay of the speed that the friction level depends on, s


class Input(NamedTuple):
    """The drive, linear from knot to knot, plus amplitude cos(frequency t + phase)."""

    knots: np.ndarray  # s, (m,)
    values: np.ndarray  # N, (m,)
    rates: np.ndarray  # N/s, (m,)
    amplitude: float
    frequency: float
    phase: float


class Laws(NamedTuple):
    """The laws of a model."""

    # address of the kernel, address of its parameters, terms taken (`FRICTION` + `FORCE`), and whether the laws depend
    # on the delayed speed; (effects, 4)
    effects: np.ndarray
    # address of the kernel, address of its parameters, first element and number of elements; the first row is the
    # friction state model, the others are elements parallel to it; (groups, 4)
    groups: np.ndarray
    base: np.ndarray  # level, factor and force of all that stays constant, (3,)
    # normal load (N) and temperature (degC), (m, 2); linear between instants that begin at `begin` (s) and are `step`
    # (s) apart, or constant for m = 1
    surroundings: np.ndarray
    begin: float
    step: float
    oscillators: np.ndarray  # w^2, 2 damping w, and mass of each added oscillator; (oscillators, 3)


FRICTION, FORCE = 1, 2
"""Terms taken from an effect: summand and factor of the friction level, force, or both."""


class Problem(NamedTuple):
    layout: Layout
    body: Body
    drive: Input
    laws: Laws


class Tolerance(NamedTuple):
    """Accuracy and limits of an integration."""

    relative: float  # of the error of one step
    absolute: np.ndarray  # of each state, (size,); infinite for a state whose error does not count
    counted: int  # number of states whose error counts
    longest_step: float  # s
    most_steps: int  # attempts, accepted or not


class Output(NamedTuple):
    """Results of an integration, written in place."""

    time: np.ndarray  # instants of the output, s, (n,)
    states: np.ndarray  # the first rows of the state at these instants, (k, n)
    # level, force of the friction state model, other forces, drive at these instants, N, (n or 0, 4)
    forces: np.ndarray
    report: np.ndarray  # outcome, time reached, accepted and rejected steps, then the state there, (4 + size,)


class Branch(NamedTuple):
    """The smooth branch of the equations that one step follows."""

    direction: float  # of the motion: 1 or -1
    engaged: float  # 1 where the backlash transmits force, 0 within the gap
    edge: float  # force of the spring at which the backlash engages, N
    segment: int  # of the drive


BRANCH = Branch(1.0, 1.0, 0.0, 0)
"""Example of a branch, for its type."""


class Terms(NamedTuple):
    """Values of the laws at one instant, written in place."""

    axis: Zeros  # arguments of the effects' laws, in the order of `sim.effects.effect.Axis`
    laws: Zeros  # value and slopes of level, factor and force of one effect, then slopes of the product of the factors
    elements: Zeros  # rate, force, rate_z, rate_v, rate_g, force_z, force_v, force_g of each element, (elements, 8)
    total: Zeros  # level, force of the friction state model, of the effects, of the parallel elements, (4,)
    slope: Zeros  # of these four by `QUANTITIES`, at constant internal states, (4, 5)


class Jacobian(NamedTuple):
    """Entries of the Jacobian that are not zero; `rodas5p.py` has the structure."""

    velocity_by_head: Zeros  # (4,)
    # element_by_self, velocity_by_element: (elements,)
    element_by_self: Zeros
    velocity_by_element: Zeros
    element_by_head: Zeros  # (elements, 4)
    age: Zeros  # slopes of the contact age's rate by velocity, by itself, and by the rate of the first element, (3,)
    work_by_head: Zeros  # (3, 4)
    work_by_element: Zeros  # (elements,)
    time: Zeros  # partial derivatives of the rates by time, (size,)
    inverse: Zeros  # of the eliminated pivots: of each element, then of each oscillator
    effective: Zeros  # velocity by head once the elements are eliminated, (4,)


class Workspace(NamedTuple):
    """Arrays of an integration, written in place."""

    # y, fresh: state before and after a step, (size,)
    y: np.ndarray
    fresh: Zeros
    rates: Zeros  # at the start of the step, (size,)
    point: Zeros  # state at which a stage evaluates the rates, (size,)
    coupling: Zeros  # sum of the earlier stages' increments in a stage's right-hand side, (size,)
    increments: Zeros  # of the stages, (stages, size)
    dense: Zeros  # coefficients of the dense output, (size, 3)
    # of the velocity over the friction delay, one step a row (`rodas5p.py`); its ends in `ring`, (2,)
    history: Zeros
    ring: Zeros
    initial_speed: float  # m/s
    terms: Terms
    jacobian: Jacobian


_DOUBLE = ir.DoubleType().as_pointer()


def _call(builder: Any, address: Any, arguments: list[Any]) -> None:
    kind = ir.FunctionType(ir.VoidType(), [a.type for a in arguments])
    builder.call(builder.inttoptr(address, kind.as_pointer()), arguments)


def _entry(context: Any, builder: Any, kind: Any, array: Any) -> Any:
    """Pointer to an array's first entry."""
    return cgutils.create_struct_proxy(kind)(context, builder, value=array).data


def _entry_at(context: Any, builder: Any, kind: Any, pair: Any, width: int) -> Any:
    """Pointer into the array of a pair (array, row), whose rows have `width` entries."""
    array, row = cgutils.unpack_tuple(builder, pair)
    first = _entry(context, builder, kind.types[0], array)
    return builder.gep(first, [builder.mul(row, context.get_constant(types.int64, width))])


def _effect_call(context: Any, address: Any, axis: Any, p: Any, out: Any, slopes: Any) -> Any:
    def generate(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        address, axis, p, out, slopes = arguments
        axis = _entry(context, builder, signature.args[1], axis)
        out = _entry(context, builder, signature.args[3], out)
        _call(builder, address, [axis, builder.inttoptr(p, _DOUBLE), out, slopes])
        return context.get_dummy_value()

    return types.void(types.int64, axis, types.int64, out, types.int64), generate


def _elements_call(context: Any, address: Any, states: Any, motion: Any, p: Any, out: Any, n: Any, slopes: Any) -> Any:
    def generate(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        address, states, motion, p, out, n, slopes = arguments
        z = _entry_at(context, builder, signature.args[1], states, 1)
        out = _entry_at(context, builder, signature.args[4], out, 8)
        _call(
            builder, address, [z, *cgutils.unpack_tuple(builder, motion), builder.inttoptr(p, _DOUBLE), out, n, slopes]
        )
        return context.get_dummy_value()

    return types.void(types.int64, states, motion, types.int64, out, types.int64, types.int64), generate


call_effect: Any = intrinsic(_effect_call)
"""`call_effect(address, axis, p, out, slopes)`; `p` is an address."""

call_elements: Any = intrinsic(_elements_call)
"""`call_elements(address, (y, first state), (v, direction, level), p, (elements, first row), n, slopes)`: `p` is an
address."""


@inlined
def drive_at(t, drive, segment):
    """Value and rate of the drive, N and N/s."""
    value = drive.values[segment] + drive.rates[segment] * (t - drive.knots[segment])
    rate = drive.rates[segment]
    if drive.amplitude != 0.0:
        value += drive.amplitude * math.cos(drive.frequency * t + drive.phase)
        rate -= drive.amplitude * drive.frequency * math.sin(drive.frequency * t + drive.phase)
    return value, rate


@inlined
def _set_surroundings(t, laws, axis):
    """Write load and temperature at one instant."""
    table = laws.surroundings
    axis[4], axis[5] = table[0, 0], table[0, 1]
    if table.shape[0] > 1:
        place = (t - laws.begin) / laws.step
        i = min(max(int(place), 0), table.shape[0] - 2)
        axis[4] = table[i, 0] + (place - i) * (table[i + 1, 0] - table[i, 0])
        axis[5] = table[i, 1] + (place - i) * (table[i + 1, 1] - table[i, 1])


@inlined
def _add_slope_by_surroundings(row, problem, axis, laws):
    """Add, to the slopes by time of one effect's laws, those by load and temperature: forward differences."""
    t, ahead = axis[0], 1e-4 * problem.laws.step
    level, factor, force = laws[0], laws[COLUMNS], laws[2 * COLUMNS]
    _set_surroundings(t + ahead, problem.laws, axis)
    call_effect(row[0], axis, row[1], laws, VALUES)
    _set_surroundings(t, problem.laws, axis)
    laws[5] += (laws[0] - level) / ahead
    laws[COLUMNS + 5] += (laws[COLUMNS] - factor) / ahead
    laws[2 * COLUMNS + 5] += (laws[2 * COLUMNS] - force) / ahead
    laws[0], laws[COLUMNS], laws[2 * COLUMNS] = level, factor, force


@inlined
def _set_axis(t, y, direction, problem, axis):
    """Write the arguments of the effects' laws; NaN for quantities that the simulation lacks."""
    axis[0], axis[1], axis[2] = t, y[0], y[1]
    axis[3], axis[7] = math.nan, math.nan
    _set_surroundings(t, problem.laws, axis)
    axis[6], axis[8] = 0.0, 0.0
    if problem.layout.head > 2:
        axis[6], axis[8] = y[3], y[2]
    axis[9] = direction


@inlined
def _add_effects(direction, delayed, with_slopes, problem, terms):
    """Sum the laws of all effects: level, product of the factors, force. `delayed`: past speed and its rate."""
    effects, base = problem.laws.effects, problem.laws.base
    axis, laws, slope = terms.axis, terms.laws, terms.slope
    v = axis[2]
    level, factor, force = base[0], base[1], base[2]
    product = 3 * COLUMNS
    for i in range(effects.shape[0]):
        if with_slopes:
            # A kernel writes only the slopes that are not zero.
            for j in range(3 * COLUMNS):
                laws[j] = 0.0
        if effects[i, 3]:
            axis[2] = direction * delayed[0]
        call_effect(effects[i, 0], axis, effects[i, 1], laws, with_slopes)
        if with_slopes and problem.laws.surroundings.shape[0] > 1:
            _add_slope_by_surroundings(effects[i], problem, axis, laws)
        if effects[i, 3]:
            axis[2] = v
            if with_slopes:
                # The delayed speed is a known function of time.
                laws[5] += laws[2] * direction * delayed[1]
                laws[COLUMNS + 5] += laws[COLUMNS + 2] * direction * delayed[1]
                laws[2], laws[COLUMNS + 2] = 0.0, 0.0
        if effects[i, 2] & FRICTION:
            level += laws[0]
            if with_slopes:
                for j in range(SLOPES):
                    slope[0, j] += laws[1 + j]
                    laws[product + j] = laws[product + j] * laws[COLUMNS] + factor * laws[COLUMNS + 1 + j]
            factor *= laws[COLUMNS]
        if effects[i, 2] & FORCE:
            force += laws[2 * COLUMNS]
            if with_slopes:
                for j in range(SLOPES):
                    slope[2, j] += laws[2 * COLUMNS + 1 + j]
    if with_slopes:
        for j in range(SLOPES):
            slope[0, j] = slope[0, j] * factor + level * laws[product + j]
    return level * factor, force


@inlined
def _add_elements(i, y, direction, with_slopes, problem, terms):
    """Rates and forces of the elements of group `i`; returns the sum of the forces."""
    groups, head = problem.laws.groups, problem.layout.head
    elements, slope = terms.elements, terms.slope
    first, count = groups[i, 2], groups[i, 3]
    call_elements(
        groups[i, 0],
        (y, head + first),
        (y[1], direction, terms.total[0]),
        groups[i, 1],
        (elements, first),
        count,
        with_slopes,
    )
    row = 1 if i == 0 else 3
    force = 0.0
    for k in range(first, first + count):
        force += elements[k, 1]
        if with_slopes:
            for j in range(SLOPES):
                slope[row, j] += elements[k, 7] * slope[0, j]
            slope[row, 1] += elements[k, 6]
    return force


@inlined
def friction_terms(t, y, direction, delayed, with_slopes, problem, terms):
    """Level and forces at one instant of a motion in `direction`, into `terms`; `delayed`: past speed and its rate."""
    _set_axis(t, y, direction, problem, terms.axis)
    if with_slopes:
        for i in range(4):
            for j in range(SLOPES):
                terms.slope[i, j] = 0.0
        for j in range(SLOPES):
            terms.laws[3 * COLUMNS + j] = 0.0
    total = terms.total
    total[0], total[2] = _add_effects(direction, delayed, with_slopes, problem, terms)
    total[1], total[3] = 0.0, 0.0
    for i in range(problem.laws.groups.shape[0]):
        if problem.laws.groups[i, 3] > 0:
            total[1 if i == 0 else 3] += _add_elements(i, y, direction, with_slopes, problem, terms)


@inlined
def rates_of_change(t, y, branch, problem, terms, f):
    """Rates f of all states, after `friction_terms`; returns the force of the drive and that of the oscillators, N."""
    layout, body, oscillators = problem.layout, problem.body, problem.laws.oscillators
    total = terms.total
    v = y[1]
    f[0] = v
    if layout.head > 2:
        f[2] = branch.direction * v
        slip = abs(v - terms.elements[0, 0]) if body.ages_by_slip else branch.direction * v
        f[3] = 1.0 - slip * y[3] / body.memory_length
    for k in range(layout.elements):
        f[layout.head + k] = terms.elements[k, 0]
    reaction = 0.0
    at = layout.head + layout.elements
    for o in range(layout.oscillators):
        acceleration = oscillators[o, 0] * (y[0] - y[at]) - oscillators[o, 1] * y[at + 1]
        f[at], f[at + 1] = y[at + 1], acceleration
        reaction += oscillators[o, 2] * acceleration
        at += 2
    command, _ = drive_at(t, problem.drive, branch.segment)
    if layout.lag >= 0:
        f[layout.lag] = (command - y[layout.lag]) / body.drive_lag
        command = y[layout.lag]
    push = branch.engaged * (command - body.spring * y[0] - branch.edge)
    others = total[2] + total[3] + reaction
    f[1] = (push - body.feedback * (total[1] + others)) * body.inverse_mass
    if layout.works >= 0:
        at = layout.works
        f[at], f[at + 1], f[at + 2] = total[1] * v, others * v, push * v
    return push, reaction
