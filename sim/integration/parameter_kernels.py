"""Derivatives of every law by its own parameters, behind the same signatures as the laws (`sim.integration.kernels`).

    effect(axis, p, out, wanted):  out[law, j] = derivative of level, factor, force by parameter j
    core(z, v, direction, g, p, out, n, wanted): out[k, 0 or 1, j] = derivative of rate, force by parameter j

Bit j of `wanted` asks for parameter j; what is not asked for, or is zero throughout, is left as it was.

Those of a built-in law are exact, from its source (`sim.numerics.derivative`), and compiled; those of a law that cannot
be treated so, and of a user's own, are differences, taken in Python.
"""

from __future__ import annotations

import ctypes
import functools
import math
from collections.abc import Callable
from typing import Any

import numpy as np

from sim.integration import generated_kernels, kernels
from sim.integration.generated_kernels import LAW_OPTIONS, LAWS, Kernel, load_generated, source_files
from sim.library.effect import Axis, Effect
from sim.numerics import compilation, derivative
from sim.numerics.derivative import NotDifferentiableError, derivative_text

RELATIVE_STEP = 1e-6


def _functions(law: Callable[..., Any] | None, effect: Effect, prefix: str) -> tuple[list[str], list[str | None]]:
    """Texts of the derivatives of one law by each parameter, and their names; None where the derivative is zero."""
    texts: list[str] = []
    names: list[str | None] = []
    for parameter in effect.parameters:
        name = f"{prefix}_by_{parameter.name}"
        text = derivative_text(law, ("p", parameter.name), name) if law is not None else None
        names.append(name if text else None)
        if text:
            texts.append(text)
    return texts, names


_HEAD = """\
import math
import numpy as np
from numba import carray, njit
from sim.library.effect import Axis
from sim.library.catalogue import find

EFFECT = find({name!r})
Values = EFFECT.values_type
OF = {owner}


def compiled(text, name, law):
    names = dict(law.__globals__, np=np, math=math)
    exec(text, names)
    return njit({options})(names[name])


"""


def _effect_text(effect: Effect) -> str:
    size = len(effect.parameters)
    parts, lines = [], []
    for i, law in enumerate(LAWS):
        texts, names = _functions(getattr(effect, law), effect, law)
        of = iter(texts)
        for j, name in enumerate(names):
            if name:
                parts.append(f"{name} = compiled({next(of)!r}, {name!r}, OF.{law})")
                lines.append(f"    if wanted & {1 << j}:\n        r[{i * size + j}] = {name}(here, values)")
    fields = len(Axis._fields)
    return (
        _HEAD.format(name=effect.name, owner="EFFECT", options=LAW_OPTIONS)
        + "\n".join(parts)
        + f"""


def kernel(axis, p, out, wanted):
    a = carray(axis, ({fields},))
    q = carray(p, ({max(size, 1)},))
    r = carray(out, ({max(3 * size, 1)},))
    here = Axis({", ".join(f"a[{i}]" for i in range(fields))})
    values = Values({", ".join(f"q[{i}]" for i in range(size))})
"""
        + "\n".join(lines or ["    return"])
        + "\n"
    )


def _core_text(effect: Effect) -> str:
    size = len(effect.parameters)
    core = effect.core or effect.element
    texts, names = _functions(core.law, effect, "law")
    of = iter(texts)
    parts = [f"{name} = compiled({next(of)!r}, {name!r}, OF.law)" for name in names if name]
    lines = [
        f"        if wanted & {1 << j}:\n"
        f"            r[k, 0, {j}], r[k, 1, {j}] = {name}(k, state[k], v, direction, g, values)"
        for j, name in enumerate(names)
        if name
    ]
    return (
        _HEAD.format(name=effect.name, owner="EFFECT.core or EFFECT.element", options=LAW_OPTIONS)
        + "\n".join(parts)
        + f"""


def kernel(z, v, direction, g, p, out, n, wanted):
    state = carray(z, (n,))
    q = carray(p, ({max(size, 1)},))
    r = carray(out, (n, 2, {max(size, 1)}))
    values = Values({", ".join(f"q[{i}]" for i in range(size))})
    for k in range(n):
"""
        + "\n".join(lines or ["        pass"])
        + "\n"
    )


@functools.cache
def _compiled(name: str, what: str) -> Kernel | None:
    from numba import types

    from sim.library.catalogue import find

    effect = find(name)
    pointer = types.CPointer(types.double)
    files = [derivative.__file__, generated_kernels.__file__, __file__]
    try:
        if what == "effect":
            text = _effect_text(effect)
            signature = types.void(*[pointer] * 3, types.int64)
            laws = [effect.level, effect.factor, effect.force]
        else:
            text = _core_text(effect)
            signature = types.void(pointer, *[types.double] * 3, pointer, pointer, types.int64, types.int64)
            laws = [(effect.core or effect.element).law]
        files += source_files(laws)
        module = load_generated(text, f"by_parameter_{what}_{effect.values_type.__name__}", files)
        callback = compilation.compile_callback(module.kernel, signature, files)
    except NotDifferentiableError:
        return None
    except Exception as error:
        if not type(error).__module__.startswith("numba"):
            raise
        return None
    return Kernel(callback.address, True, callback)


def effect_by_parameter(effect: Effect) -> Kernel:
    """The kernel of an effect's derivatives; see the head of this file."""
    if kernels.is_built_in(effect):
        compiled = _compiled(effect.name, "effect")
        if compiled is not None:
            return compiled
    size, fields = len(effect.parameters), len(Axis._fields)
    errors: list[BaseException] = []

    def kernel(axis_at: Any, p_at: Any, out: Any, slopes: int) -> None:
        try:
            axis, p = Axis(*axis_at[:fields]), effect.values_type(*p_at[:size])
            for i, law in enumerate(getattr(effect, name) for name in LAWS):
                for j in range(size):
                    out[i * size + j] = _difference(lambda q, law=law: law(axis, q), p, j) if law is not None else 0.0
        except Exception as error:
            errors.append(error)
            for i in range(3 * size):
                out[i] = math.nan

    callback = kernels.EFFECT_TYPE(kernel)
    address = ctypes.cast(callback, ctypes.c_void_p).value
    assert address is not None
    return Kernel(address, False, callback, errors)


def core_by_parameter(effect: Effect) -> Kernel:
    """The kernel of the derivatives of a core's or element's law; see the head of this file."""
    if kernels.is_built_in(effect):
        compiled = _compiled(effect.name, "core")
        if compiled is not None:
            return compiled
    size, core = len(effect.parameters), effect.core or effect.element
    errors: list[BaseException] = []

    def kernel(z: Any, v: float, direction: float, g: float, p_at: Any, out: Any, n: int, slopes: int) -> None:
        try:
            p = effect.values_type(*p_at[:size])
            for k in range(n):
                for i in range(2):
                    for j in range(size):
                        out[(2 * k + i) * size + j] = _difference(
                            lambda q, k=k, i=i: core.law(k, z[k], v, direction, g, q)[i], p, j
                        )
        except Exception as error:
            errors.append(error)
            for i in range(2 * n * size):
                out[i] = math.nan

    callback = kernels.CORE_TYPE(kernel)
    address = ctypes.cast(callback, ctypes.c_void_p).value
    assert address is not None
    return Kernel(address, False, callback, errors)


def _difference(law: Callable[[Any], Any], p: Any, j: int) -> float:
    name = p._fields[j]
    step = RELATIVE_STEP * max(abs(p[j]), 1e-9)
    ahead, behind = law(p._replace(**{name: p[j] + step})), law(p._replace(**{name: p[j] - step}))
    return float(np.squeeze(ahead - behind)) / (2.0 * step)
