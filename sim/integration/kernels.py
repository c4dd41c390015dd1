"""Every effect and core behind one signature each: a C function that an integrator calls through its address.

A built-in law is compiled by numba, once (`sim.integration.generated_kernels`). A user's own law, or one that numba
cannot compile, is called back in Python through the same signature.

    effect(axis, p, out, slopes):  for the laws level, factor, force: out[law, 0] value, out[law, 1..5] slopes by
                                   position, velocity, travelled, contact age and time
    core(z, v, direction, g, p, out, n, slopes): out[k] = rate, force, rate_z, rate_v, rate_g, force_z, force_v, force_g
"""

from __future__ import annotations

import contextlib
import ctypes
import functools
import math
import weakref
from collections.abc import Callable
from typing import Any, Generic, TypeVar

import numpy as np

from sim.effects.catalogue import find, library
from sim.integration.generated_kernels import BY, DIFFERENCE, LAWS, OUT, Kernel, SlopePlan, compile_core, compile_effect
from sim.library.effect import Axis, Effect, Parameter
from sim.library.friction_state import FrictionStateModel
from stagecad.parameters.errors import InputError

T = TypeVar("T")

_DOUBLES = ctypes.POINTER(ctypes.c_double)
EFFECT_TYPE = ctypes.CFUNCTYPE(None, _DOUBLES, _DOUBLES, _DOUBLES, ctypes.c_int64)
CORE_TYPE = ctypes.CFUNCTYPE(None, _DOUBLES, *[ctypes.c_double] * 3, _DOUBLES, _DOUBLES, ctypes.c_int64, ctypes.c_int64)


class _ByIdentity(Generic[T]):
    """What a function of an effect gave, kept as long as the effect lives: its hash would cost more than the answer."""

    def __init__(self, function: Callable[[Effect], T]) -> None:
        functools.update_wrapper(self, function)
        self.function = function
        self.kept: dict[int, tuple[weakref.ref[Effect], T]] = {}

    def __call__(self, effect: Effect) -> T:
        found = self.kept.get(id(effect))
        if found is None or found[0]() is not effect:
            key, kept = id(effect), self.kept
            found = (weakref.ref(effect, lambda _: kept.pop(key, None)), self.function(effect))
            kept[key] = found
        return found[1]


def depends_on(effect: Effect, law: str, quantity: str) -> bool:
    """Whether a law's value changes with a quantity of the axis, found by trying it at a few dozen points."""
    function = getattr(effect, law)
    return function is not None and quantity in _tried(function, effect.parameters)


@functools.lru_cache(maxsize=1024)
def _tried(law: Callable[..., Any], parameters: tuple[Parameter, ...]) -> frozenset[str]:
    """The quantities of the axis that a law's value changes with."""
    random = np.random.default_rng(7)
    n = 24
    x, v, a = (random.uniform(-1.0, 1.0, n) * 10.0 ** random.uniform(-6.0, 1.0, n) for _ in range(3))
    t, age, way, back = (10.0 ** random.uniform(-6.0, 2.0, n) for _ in range(4))
    columns = Axis(t, x, v, a, 1.0 + t, 20.0 + t, age, back, way, np.sign(v))
    # An amplitude whose default is zero would hide what its law depends on.
    p = Effect("tried", "", parameters=parameters).values(
        **{q.name: min(max(1.0, q.low), q.high) for q in parameters if q.default == 0.0}
    )
    found = set()
    with np.errstate(all="ignore"):
        for instant in (Axis(*map(float, row)) for row in zip(*columns)):
            for quantity in (*BY, "direction", "acceleration", "reversal_distance"):
                moved = instant._replace(**{quantity: getattr(instant, quantity) * 1.37 + 1e-6})
                # A user's law may be good for some instants only: an integration that meets the others will say so.
                with contextlib.suppress(Exception):
                    here, there = float(law(instant, p)), float(law(moved, p))
                    if here != there and not (math.isnan(here) and math.isnan(there)):
                        found.add(quantity)
    return frozenset(found)


@_ByIdentity
def carried(effect: Effect) -> frozenset[str]:
    """The quantities of the axis that an effect's level, factor and force depend on."""
    if not any(takes(effect)):
        return frozenset()
    return frozenset(
        quantity
        for quantity in (*BY, "acceleration", "reversal_distance")
        for law in LAWS
        if depends_on(effect, law, quantity)
    )


@_ByIdentity
def takes(effect: Effect) -> tuple[bool, bool]:
    """Whether an integration takes a level or factor, and a force, from the effect's laws at one instant."""
    whole = effect.parallel_element is not None or effect.time_domain is not None
    return effect.level is not None or effect.factor is not None, effect.force is not None and not whole


@_ByIdentity
def is_constant(effect: Effect) -> bool:
    """Whether none of a built-in effect's laws changes in the course of a simulation."""
    moving = (*BY, "direction", "acceleration", "reversal_distance")
    return is_built_in(effect) and not any(depends_on(effect, law, by) for law in LAWS for by in moving)


@_ByIdentity
def unsupported(effect: Effect) -> str | None:
    """Why an effect cannot be integrated in time, or None."""
    if effect.parallel_element is not None or effect.time_domain is not None:
        return None
    if effect.memory is not None and not any(takes(effect)):
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
            return f"has a {law} that cannot be had at one instant ({type(error).__name__}: {error})"
    for quantity in sorted(carried(effect) & {"acceleration", "reversal_distance"}):
        return f"depends on {quantity}, which a simulation does not carry"
    return None


def _slope_plan(effect: Effect) -> SlopePlan:
    plan = []
    for i, law in enumerate(LAWS):
        for j, by in enumerate(BY):
            if f"{law}.{by}" in effect.slopes:
                plan.append((i, 1 + j, "declared"))
            elif depends_on(effect, law, by):
                plan.append((i, 1 + j, "difference"))
    return plan


@_ByIdentity
def is_built_in(effect: Effect) -> bool:
    base = effect.name.removeprefix("contact.").partition("@")[0].partition(":")[0]
    built_in = library().get(base)
    if built_in is None:
        return False
    laws = [(e.level, e.factor, e.force, e.friction_state, e.parallel_element) for e in (built_in, *built_in.variants)]
    return (effect.level, effect.factor, effect.force, effect.friction_state, effect.parallel_element) in laws


@functools.cache
def _compiled_effect(name: str, held: bool) -> Kernel | None:
    effect = find(name)
    return compile_effect(effect, held, _slope_plan(effect))


@functools.cache
def _compiled_core(name: str) -> Kernel | None:
    return compile_core(find(name))


def is_held(effect: Effect, p: Any) -> bool:
    """Whether every parameter that is held has its default."""
    fixed = [q for q in effect.parameters if q.fixed]
    return bool(fixed) and all(getattr(p, q.name) == q.default for q in fixed)


def effect_kernel(effect: Effect, p: Any = None) -> Kernel:
    """The kernel of one effect; see the head of this file for its signature.

    With parameter values `p` in which every one that is held has its default, the kernel has those written into it: a
    square is much cheaper than a power.
    """
    if is_built_in(effect):
        compiled = _compiled_effect(effect.name, p is not None and is_held(effect, p))
        if compiled is not None:
            return compiled
    plan = _slope_plan(effect)
    laws = [(i, getattr(effect, law)) for i, law in enumerate(LAWS)]
    fields = len(Axis._fields)
    size = len(effect.parameters)
    errors: list[BaseException] = []

    def value(law: Callable[..., Any], axis: Axis, p: Any) -> float:
        return float(law(axis, p))

    def kernel(axis_at: Any, p_at: Any, out: Any, slopes: int) -> None:
        try:
            axis = Axis(*axis_at[:fields])
            p = effect.values_type(*p_at[:size])
            for i, law in laws:
                out[i * OUT] = value(law, axis, p) if law is not None else (1.0 if LAWS[i] == "factor" else 0.0)
            if slopes:
                for i, column, kind in plan:
                    by = BY[column - 1]
                    if kind == "declared":
                        slope = value(effect.slopes[f"{LAWS[i]}.{by}"], axis, p)
                    else:
                        here = getattr(axis, by)
                        step = DIFFERENCE[by] * (1.0 + abs(here))
                        ahead = value(laws[i][1], axis._replace(**{by: here + step}), p)
                        behind = value(laws[i][1], axis._replace(**{by: here - step}), p)
                        slope = (ahead - behind) / (2.0 * step)
                    out[i * OUT + column] = slope
        except Exception as error:  # it cannot pass through compiled code: kept, and raised when the step fails
            errors.append(error)
            for i in range(len(LAWS)):
                out[i * OUT] = math.nan

    callback = EFFECT_TYPE(kernel)
    address = ctypes.cast(callback, ctypes.c_void_p).value
    assert address is not None
    return Kernel(address, False, callback, errors)


def core_kernel(effect: Effect) -> Kernel:
    """The kernel of the core or element that `effect` brings; see the head of this file for its signature."""
    core: FrictionStateModel = effect.friction_state or effect.parallel_element
    if core is None:
        raise InputError(f"effect '{effect.name}' has no core: it does not turn a friction level into a force")
    if is_built_in(effect):
        compiled = _compiled_core(effect.name)
        if compiled is not None:
            return compiled
    size = len(effect.parameters)
    errors: list[BaseException] = []

    def kernel(z: Any, v: float, direction: float, g: float, p_at: Any, out: Any, n: int, slopes: int) -> None:
        try:
            p = effect.values_type(*p_at[:size])
            for k in range(n):
                out[8 * k], out[8 * k + 1] = core.law(k, z[k], v, direction, g, p)
                if slopes:
                    for i, slope in enumerate(core.slopes(k, z[k], v, direction, g, p)):
                        out[8 * k + 2 + i] = slope
        except Exception as error:
            errors.append(error)
            for k in range(n):
                out[8 * k] = math.nan

    callback = CORE_TYPE(kernel)
    address = ctypes.cast(callback, ctypes.c_void_p).value
    assert address is not None
    return Kernel(address, False, callback, errors)
