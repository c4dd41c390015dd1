"""Every effect and friction state model behind one C signature each, which the integrator calls by address.

A built-in law is compiled by numba, once, as a small generated module that unpacks pointers into its arguments. A
user's own law, or one that numba cannot compile, is called back in Python through the same signature.

    effect(axis, p, out, slopes):  for the laws level, factor, force: out[law, 0] value, out[law, 1..5] slopes by
                                   position, velocity, travelled, contact age and time
    state(z, v, direction, g, p, out, n, slopes):
                                   out[k] = rate, force, rate_z, rate_v, rate_g, force_z, force_v, force_g
"""

import contextlib
import ctypes
import functools
import importlib.util
import inspect
import math
import sys
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from sim.effects.catalogue import find, library
from sim.effects.effect import Axis, Effect, Parameter
from sim.effects.friction_state_model import FrictionStateModel
from sim.numerics import compilation
from sim.numerics.elasto_plastic import smooth_element
from stagecad.parameters.atomic import atomic_write_text
from stagecad.parameters.errors import InputError

LAWS = ("level", "factor", "force")
QUANTITIES = ("position", "velocity", "travelled", "contact_age", "time")
"""Quantities of the axis by which the laws are differentiated."""
COLUMNS = 1 + len(QUANTITIES)

DIFFERENCE = {"position": 1e-9, "velocity": 1e-9, "travelled": 1e-9, "contact_age": 1e-7, "time": 1e-7}
"""Steps of the central differences by which a slope that is not declared is taken, relative to 1 + |value|."""

SlopePlan = list[tuple[int, int, bool]]
"""(law, column, whether it is declared) of every slope that is not zero; one that is not is taken by differences."""


@dataclass(frozen=True)
class Kernel:
    """A law behind its C signature; keep it while its address is in use."""

    address: int  # of the C function
    compiled: bool  # by numba, else called back in Python
    callback: Any  # owner of the C function
    # raised by a law in Python; an exception cannot pass through compiled code
    errors: list[BaseException] = field(default_factory=list)


_EFFECT_TEXT = """\
from numba import carray, njit
from sim.effects.effect import Axis
from sim.effects.catalogue import find

EFFECT = find({name!r})
Values = EFFECT.values_type
{functions}


def kernel(axis, p, out, slopes):
    a = carray(axis, ({axis},))
    q = carray(p, ({size},))
    r = carray(out, ({out},))
    here = Axis({here})
    values = Values({values})
{lines}
"""

_STATE_TEXT = """\
from numba import carray, njit
from sim.effects.catalogue import find

EFFECT = find({name!r})
Values = EFFECT.values_type
law = njit({options})((EFFECT.friction_state or EFFECT.parallel_element).law)
element_slopes = njit({options})((EFFECT.friction_state or EFFECT.parallel_element).slopes)


def kernel(z, v, direction, g, p, out, n, slopes):
    state = carray(z, (n,))
    q = carray(p, ({size},))
    r = carray(out, (n, 8))
    values = Values({values})
    for k in range(n):
        r[k, 0], r[k, 1] = law(k, state[k], v, direction, g, values)
        if slopes:
            r[k, 2], r[k, 3], r[k, 4], r[k, 5], r[k, 6], r[k, 7] = element_slopes(
                k, state[k], v, direction, g, values
            )
"""

_ELEMENTS_TEXT = """\
from numba import carray, njit
from sim.numerics.elasto_plastic import smooth_element

element = njit({options})(smooth_element)


def kernel(z, v, direction, g, p, out, n, slopes):
    state = carray(z, (n,))
    table = carray(p, (n, 4))
    r = carray(out, (n, 8))
    for k in range(n):
        terms = element(state[k], v, direction, g, table[k, 0], table[k, 1], table[k, 2], table[k, 3])
        for i in range(8):
            r[k, i] = terms[i]
"""

_LAW_OPTIONS = "error_model='numpy', no_cpython_wrapper=True, no_cfunc_wrapper=True"
"""Options of a law within its kernel: wrappers for calls from outside take as long to compile as the law."""


def _values_text(effect: Effect) -> str:
    return ", ".join(f"q[{i}]" for i in range(len(effect.parameters)))


def _effect_text(effect: Effect, slopes: SlopePlan) -> str:
    functions, lines, sloped = [], [], []
    for i, law in enumerate(LAWS):
        if getattr(effect, law) is not None:
            functions.append(f"{law} = njit({_LAW_OPTIONS})(EFFECT.{law})")
            lines.append(f"    r[{i * COLUMNS}] = {law}(here, values)")
        else:
            lines.append(f"    r[{i * COLUMNS}] = {1.0 if law == 'factor' else 0.0}")
    for i, column, declared in slopes:
        law, by = LAWS[i], QUANTITIES[column - 1]
        target = f"        r[{i * COLUMNS + column}] = "
        if declared:
            functions.append(f"{law}_{by} = njit({_LAW_OPTIONS})(EFFECT.slopes['{law}.{by}'])")
            sloped.append(f"{target}{law}_{by}(here, values)")
        else:
            step = f"({DIFFERENCE[by]!r} * (1.0 + abs(here.{by})))"
            ahead, behind = (
                ", ".join(f"here.{f} {sign} {step}" if f == by else f"here.{f}" for f in Axis._fields) for sign in "+-"
            )
            difference = f"{law}(Axis({ahead}), values) - {law}(Axis({behind}), values)"
            sloped.append(f"{target}({difference}) / (2.0 * {step})")
    if sloped:
        lines += ["    if slopes:", *sloped]
    return _EFFECT_TEXT.format(
        name=effect.name,
        functions="\n".join(functions),
        axis=len(Axis._fields),
        size=max(len(effect.parameters), 1),
        out=len(LAWS) * COLUMNS,
        here=", ".join(f"a[{i}]" for i in range(len(Axis._fields))),
        values=_values_text(effect),
        lines="\n".join(lines),
    )


def compile_effect(effect: Effect, slopes: SlopePlan) -> Kernel | None:
    """The kernel of a built-in effect; None where numba cannot compile it."""
    from numba import types

    files = _source_files([effect.level, effect.factor, effect.force, *effect.slopes.values()])
    signature = types.void(*[types.CPointer(types.double)] * 3, types.int64)
    return _compile(_effect_text(effect, slopes), f"effect_{effect.values_type.__name__}", signature, files)


@functools.cache
def _compiled_elements() -> Kernel:
    """The kernel of parallel elasto-plastic elements; its `p` is `FrictionStateModel.table`."""
    text = _ELEMENTS_TEXT.format(options=_LAW_OPTIONS)
    kernel = _compile(text, "parallel_elements", _state_signature(), _source_files([smooth_element]))
    assert kernel is not None
    return kernel


def _state_signature() -> Any:
    from numba import types

    pointer = types.CPointer(types.double)
    return types.void(pointer, *[types.double] * 3, pointer, pointer, types.int64, types.int64)


def _source_files(functions: list[Callable[..., Any] | None]) -> list[str]:
    return [f.__code__.co_filename for f in functions if f is not None and inspect.isfunction(f)]


def _compile(text: str, name: str, signature: Any, files: list[str]) -> Kernel | None:
    """The function `kernel` of a module's source, compiled; `files` contain its laws."""
    try:
        callback = compilation.compile_callback(_load_generated(text, name, files).kernel, signature, files)
    except Exception as error:
        if not type(error).__module__.startswith("numba"):
            raise
        return None
    return Kernel(callback.address, True, callback)


def _load_generated(text: str, name: str, files: list[str]) -> Any:
    """Write a generated module into the cache folder, keyed by all it depends on, and import it."""
    path = compilation.key_folder([*files, __file__, compilation.__file__]) / f"{name}.py"
    if path.is_symlink():
        # It would be written through, to the file it names.
        path.unlink()
    if not path.exists() or path.read_bytes() != text.encode("utf-8"):
        atomic_write_text(path, text)
    spec = importlib.util.spec_from_file_location(f"sim_kernel_{name}", path)
    assert spec is not None
    module = importlib.util.module_from_spec(spec)
    # numba finds the module of a kernel it has cached by its name.
    sys.modules[spec.name] = module
    # The text itself is run, not what a file in the cache holds; numba takes the file's name and time stamp only.
    exec(compile(text, str(path), "exec"), vars(module))
    return module


_DOUBLES = ctypes.POINTER(ctypes.c_double)
_EFFECT_TYPE = ctypes.CFUNCTYPE(None, _DOUBLES, _DOUBLES, _DOUBLES, ctypes.c_int64)
_STATE_TYPE = ctypes.CFUNCTYPE(None, _DOUBLES, *[ctypes.c_double] * 3, _DOUBLES, _DOUBLES, *[ctypes.c_int64] * 2)
_MISSING = ("acceleration", "reversal_distance")
"""Quantities of the axis that a simulation does not have."""


@functools.lru_cache(maxsize=1024)
def _dependence(law: Callable[..., Any], parameters: tuple[Parameter, ...]) -> frozenset[str]:
    """Quantities of the axis with which the value of a law changes, found by evaluating it at 24 random points. A
    user's law need not declare them, and a law may name a quantity only to take its shape (`0 * axis.velocity`)."""
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
    effect = find(name)
    model: FrictionStateModel = effect.friction_state or effect.parallel_element
    size = max(len(effect.parameters), 1)
    text = _STATE_TEXT.format(name=effect.name, size=size, values=_values_text(effect), options=_LAW_OPTIONS)
    files = _source_files([model.law, model.slopes])
    return _compile(text, f"state_{effect.values_type.__name__}", _state_signature(), files)


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
