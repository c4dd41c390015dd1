"""Every effect and friction state model behind one C signature each, which the integrator calls by address.

A built-in law is compiled by numba, once (`kernel_source`). A user's own law, or one that numba cannot compile, is
called back in Python through the same signature.

    effect(axis, p, out, slopes):  for the laws level, factor, force: out[law, 0] value, out[law, 1..5] slopes by
                                   position, velocity, travelled, contact age and time
    state(z, v, direction, g, p, out, n, slopes):
                                   out[k] = rate, force, rate_z, rate_v, rate_g, force_z, force_v, force_g
"""

import contextlib
import ctypes
import functools
import math
from collections.abc import Callable
from typing import Any

import numpy as np

from sim.effects.catalogue import find, library
from sim.effects.effect import Axis, Effect, Parameter
from sim.effects.friction_state_model import FrictionStateModel
from sim.integration.compiled.kernel_source import (
    COLUMNS,
    DIFFERENCE,
    LAWS,
    QUANTITIES,
    Kernel,
    SlopePlan,
    compile_effect,
    compile_elements,
    compile_state,
)
from stagecad.parameters.errors import InputError

_DOUBLES = ctypes.POINTER(ctypes.c_double)
_EFFECT_TYPE = ctypes.CFUNCTYPE(None, _DOUBLES, _DOUBLES, _DOUBLES, ctypes.c_int64)
_STATE_TYPE = ctypes.CFUNCTYPE(None, _DOUBLES, *[ctypes.c_double] * 3, _DOUBLES, _DOUBLES, *[ctypes.c_int64] * 2)
_MISSING = ("acceleration", "reversal_distance")
"""Quantities of the axis that a simulation does not have."""


@functools.lru_cache(maxsize=1024)
def _dependence(law: Callable[..., Any], parameters: tuple[Parameter, ...]) -> frozenset[str]:
    """Quantities of the axis with which the value of a law changes, found by evaluating it at 24 random points.

    A user's law need not declare them, and a law may name a quantity only to take its shape (`0 * axis.velocity`).
    """
    random = np.random.default_rng(7)
    n = 24
    x, v, a = (random.uniform(-1.0, 1.0, n) * 10.0 ** random.uniform(-6.0, 1.0, n) for _ in range(3))
    t, age, distance, since_reversal = (10.0 ** random.uniform(-6.0, 2.0, n) for _ in range(4))
    columns = Axis(t, x, v, a, 1.0 + t, 20.0 + t, age, since_reversal, distance, np.sign(v))
    # An amplitude whose default is zero would hide the dependence.
    p = Effect("probe", "", parameters=parameters).values(
        **{q.name: min(max(1.0, q.low), q.high) for q in parameters if q.default == 0.0}
    )
    found = set()
    with np.errstate(all="ignore"):
        for instant in (Axis(*map(float, row)) for row in zip(*columns)):
            for quantity in (*QUANTITIES, *_MISSING, "direction"):
                moved = instant._replace(**{quantity: getattr(instant, quantity) * 1.37 + 1e-6})
                # A law may be defined at some instants only: an integration that meets the others reports it.
                with contextlib.suppress(Exception):
                    here, there = float(law(instant, p)), float(law(moved, p))
                    if here != there and not (math.isnan(here) and math.isnan(there)):
                        found.add(quantity)
    return frozenset(found)


def dependence(effect: Effect, *laws: str) -> frozenset[str]:
    """Quantities of the axis with which the named laws of an effect change."""
    functions = [getattr(effect, law) for law in laws]
    return frozenset().union(*(_dependence(law, effect.parameters) for law in functions if law is not None))


def required_quantities(effect: Effect) -> frozenset[str]:
    """Quantities of the axis that a simulation must have for the level, factor and force of an effect."""
    return dependence(effect, *LAWS) - {"direction"} if any(instantaneous_terms(effect)) else frozenset()


def instantaneous_terms(effect: Effect) -> tuple[bool, bool]:
    """Whether a simulation takes a level or factor, and a force, from the laws of an effect at one instant."""
    replaced = effect.parallel_element is not None or effect.time_domain is not None
    return effect.level is not None or effect.factor is not None, effect.force is not None and not replaced


def is_constant(effect: Effect) -> bool:
    """Whether none of the laws of a built-in effect changes in the course of a simulation."""
    return is_built_in(effect) and not dependence(effect, *LAWS)


def is_built_in(effect: Effect) -> bool:
    """Whether the laws of an effect are those of the library's effect of that name."""
    base = effect.name.removeprefix("contact.").partition("@")[0].partition("#")[0].partition(":")[0]
    built_in = library().get(base)
    return built_in is not None and _laws(effect) in [_laws(e) for e in (built_in, *built_in.variants)]


def _laws(effect: Effect) -> tuple[Any, ...]:
    return effect.level, effect.factor, effect.force, effect.friction_state, effect.parallel_element


def unsupported(effect: Effect) -> str | None:
    """Why an effect cannot be integrated in time, or None."""
    if effect.parallel_element is not None or effect.time_domain is not None:
        return None
    if effect.memory is not None and not any(instantaneous_terms(effect)):
        return "changes the motion along a whole record, and has no law at one instant"
    if effect.signal is not None and effect.acts_on == "drive":
        return "depends on the rows of a record, which a simulation in time does not have"
    if effect.signal is not None and effect.acts_on != "sensor":
        return f"acts on the signal of a {effect.acts_on}, which one axis does not have; see: stagecad simulate stage"
    if effect.signal is not None:
        return None
    instant = Axis(0.1, 1e-3, 1e-3, 0.0, 1.0, 20.0, 0.1, 1e-3, 1e-3, 1.0)
    for law in LAWS:
        function = getattr(effect, law)
        try:
            if function is not None:
                float(function(instant, effect.values()))
        except Exception as error:
            return f"has a {law} that cannot be evaluated at one instant ({type(error).__name__}: {error})"
    for quantity in sorted(required_quantities(effect).intersection(_MISSING)):
        return f"depends on {quantity}, which a simulation does not have"
    return None


def _slope_plan(effect: Effect) -> SlopePlan:
    plan = []
    for i, law in enumerate(LAWS):
        needed = dependence(effect, law)
        for j, by in enumerate(QUANTITIES):
            declared = f"{law}.{by}" in effect.slopes
            if declared or by in needed:
                plan.append((i, 1 + j, declared))
    return plan


@functools.cache
def _compiled_effect(name: str) -> Kernel | None:
    effect = find(name)
    return compile_effect(effect, _slope_plan(effect))


@functools.cache
def _compiled_state(name: str) -> Kernel | None:
    return compile_state(find(name))


_compiled_elements = functools.cache(compile_elements)


def effect_kernel(effect: Effect) -> Kernel:
    """The kernel of one effect; see the head of this file for its signature."""
    compiled = _compiled_effect(effect.name) if is_built_in(effect) else None
    return compiled if compiled is not None else _effect_callback(effect)


def state_kernel(effect: Effect) -> Kernel:
    """The kernel of the friction elements of an effect; see the head of this file for its signature.

    Raises:
        InputError: an effect without any.
    """
    if effect.friction_state is None and effect.parallel_element is None:
        raise InputError(f"effect '{effect.name}' has no friction state model: it does not turn a level into a force")
    if (effect.friction_state or effect.parallel_element).table is not None:
        return _compiled_elements()
    compiled = _compiled_state(effect.name) if is_built_in(effect) else None
    return compiled if compiled is not None else _state_callback(effect)


def _effect_callback(effect: Effect) -> Kernel:
    plan, laws = _slope_plan(effect), [getattr(effect, law) for law in LAWS]
    size = len(effect.parameters)
    errors: list[BaseException] = []

    def slope(axis: Axis, p: Any, i: int, by: str, declared: bool) -> float:
        if declared:
            return float(effect.slopes[f"{LAWS[i]}.{by}"](axis, p))
        here = getattr(axis, by)
        step = DIFFERENCE[by] * (1.0 + abs(here))
        ahead, behind = (laws[i](axis._replace(**{by: here + way}), p) for way in (step, -step))
        return (float(ahead) - float(behind)) / (2.0 * step)

    def kernel(axis_at: Any, p_at: Any, out: Any, slopes: int) -> None:
        try:
            axis, p = Axis(*axis_at[: len(Axis._fields)]), effect.values_type(*p_at[:size])
            for i, law in enumerate(laws):
                out[i * COLUMNS] = float(law(axis, p)) if law is not None else float(LAWS[i] == "factor")
            if slopes:
                for i, column, declared in plan:
                    out[i * COLUMNS + column] = slope(axis, p, i, QUANTITIES[column - 1], declared)
        except Exception as error:
            errors.append(error)
            for i in range(len(LAWS)):
                out[i * COLUMNS] = math.nan

    return _python_kernel(_EFFECT_TYPE(kernel), errors)


def _state_callback(effect: Effect) -> Kernel:
    model: FrictionStateModel = effect.friction_state or effect.parallel_element
    size = len(effect.parameters)
    errors: list[BaseException] = []

    def kernel(z: Any, v: float, direction: float, g: float, p_at: Any, out: Any, n: int, slopes: int) -> None:
        try:
            p = effect.values_type(*p_at[:size])
            for k in range(n):
                out[8 * k], out[8 * k + 1] = model.law(k, z[k], v, direction, g, p)
                if slopes:
                    for i, slope in enumerate(model.slopes(k, z[k], v, direction, g, p)):
                        out[8 * k + 2 + i] = slope
        except Exception as error:
            errors.append(error)
            for k in range(n):
                out[8 * k] = math.nan

    return _python_kernel(_STATE_TYPE(kernel), errors)


def _python_kernel(callback: Any, errors: list[BaseException]) -> Kernel:
    address = ctypes.cast(callback, ctypes.c_void_p).value
    assert address is not None
    return Kernel(address, False, callback, errors)
