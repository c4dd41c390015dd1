"""Level and forces of a model at one instant, from the kernels of its effects and of its elements, in compiled code."""

from __future__ import annotations

import math
from typing import Any

from sim.integration import kernel_calls
from sim.integration.kernel_calls import call_effect, call_elements, call_model
from sim.numerics.compilation import INLINED, compile_function

BY = 5
"""Slopes are by position, velocity, travelled, contact age, time: a kernel's columns 1 to 5 of `OUT`."""
OUT = 1 + BY
NAXIS = 10
FRICTION, FORCE = 1, 2
"""What is taken from a kernel: what it adds to and multiplies in the level, its force, or both."""


def _axis_forces(
    t, y, head, direction, lagged, lagged_rate, slopes, base, effects, groups, cores, beside, axis, laws, elements, out,
    slope,
):  # fmt: skip
    """Level and forces at one instant of a motion in `direction`.

    base = [level, factor, force, load, temperature] with what never changes; effects[i] = [kernel, its parameters, what
    is taken of it, whether it sees the lagged speed]; groups[i] = [kernel, its parameters, first element, elements], of
    which the first is the core, with `cores` elements, and `beside` more follow. out = [level, force of the core, of
    the effects, of elements beside the core]. Slopes by (position, velocity, travelled, age, time): of the level, of
    the core's and of the other elements' force at constant states, of the effects' force.
    """
    x, v = y[0], y[1]
    axis[0], axis[1], axis[2] = t, x, v
    axis[3], axis[7] = math.nan, math.nan
    axis[4], axis[5] = base[3], base[4]
    if head > 2:
        axis[6], axis[8] = y[3], y[2]
    else:
        axis[6], axis[8] = 0.0, 0.0
    axis[9] = direction
    level, factor, other = base[0], base[1], base[2]
    own = 3 * OUT
    if slopes:
        for j in range(BY):
            slope[0, j], slope[1, j], slope[2, j], slope[3, j] = 0.0, 0.0, 0.0, 0.0
            laws[own + j] = 0.0
    for i in range(effects.shape[0]):
        takes = effects[i, 2]
        if slopes:
            # A kernel writes only the slopes it has.
            for j in range(3 * OUT):
                laws[j] = 0.0
        if effects[i, 3]:
            axis[2] = direction * lagged
        call_effect(effects[i, 0], axis, effects[i, 1], laws, 0, slopes)
        if effects[i, 3]:
            axis[2] = v
            if slopes:
                # The speed it sees is a known function of time.
                laws[5] += laws[2] * direction * lagged_rate
                laws[OUT + 5] += laws[OUT + 2] * direction * lagged_rate
                laws[2], laws[OUT + 2] = 0.0, 0.0
        if takes & 1:
            level += laws[0]
            if slopes:
                for j in range(BY):
                    slope[0, j] += laws[1 + j]
                    laws[own + j] = laws[own + j] * laws[OUT] + factor * laws[OUT + 1 + j]
            factor *= laws[OUT]
        if takes & 2:
            other += laws[2 * OUT]
            if slopes:
                for j in range(BY):
                    slope[3, j] += laws[2 * OUT + 1 + j]
    g = level * factor
    if slopes:
        for j in range(BY):
            slope[0, j] = slope[0, j] * factor + level * laws[own + j]
    core_force, others = 0.0, 0.0
    if cores > 0:
        call_elements(groups[0, 0], y, head, v, direction, g, groups[0, 1], elements, 0, cores, slopes)
        for k in range(cores):
            core_force += elements[k, 1]
            if slopes:
                for j in range(BY):
                    slope[1, j] += elements[k, 7] * slope[0, j]
                slope[1, 1] += elements[k, 6]
    for i in range(1, 1 + beside):
        first, count = groups[i, 2], groups[i, 3]
        call_elements(groups[i, 0], y, head + first, v, direction, g, groups[i, 1], elements, 8 * first, count, slopes)
        for k in range(first, first + count):
            others += elements[k, 1]
            if slopes:
                for j in range(BY):
                    slope[2, j] += elements[k, 7] * slope[0, j]
                slope[2, 1] += elements[k, 6]
    out[0], out[1], out[2], out[3] = g, core_force, other, others


axis_forces: Any = compile_function(_axis_forces, [kernel_calls.__file__], **INLINED)


def _values_at(
    t, y, head, direction, lagged, base, effects, groups, at_once, cores, beside, axis, laws, elements, out, slope
):
    """The same without slopes: by one kernel of the whole model, where there is one: at_once = [kernel, parameters]."""
    if at_once[0] != 0:
        call_model(at_once[0], t, y, direction, lagged, base, at_once[1], elements, out)
    else:
        axis_forces(
            t, y, head, direction, lagged, 0.0, 0, base, effects, groups, cores, beside, axis, laws, elements, out,
            slope,
        )  # fmt: skip


values_at: Any = compile_function(_values_at, [kernel_calls.__file__], **INLINED)
