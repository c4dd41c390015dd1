"""Friction terms, drive, and rates of change of all states of an axis, in compiled code."""

import math
from typing import Any

from llvmlite import ir
from numba import types
from numba.core import cgutils
from numba.extending import intrinsic

from sim.integration.problem import COLUMNS, FORCE, FRICTION, SLOPES, VALUES, inlined

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
