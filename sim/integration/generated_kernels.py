"""Kernels of built-in laws: small modules, generated, that unpack pointers into a law's named arguments, and compiled
once. `sim.integration.kernels` says what each kernel reads and writes.
"""

from __future__ import annotations

import importlib.util
import inspect
import sys
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

from sim.library.effect import Axis, Effect
from sim.library.friction_state import FrictionStateModel
from sim.numerics import compilation
from stagecad.parameters.atomic import atomic_write_text

LAWS = ("level", "factor", "force")
HEAD = ("position", "velocity", "travelled", "contact_age")
BY = (*HEAD, "time")
OUT = 1 + len(BY)

SlopePlan = list[tuple[int, int, str]]
"""(law, column, kind) of every slope that is not zero: `declared`, or by `difference`."""

# Sizes over which a quantity of the axis changes, for differences where a slope is not declared.
DIFFERENCE = {"position": 1e-9, "velocity": 1e-9, "travelled": 1e-9, "contact_age": 1e-7, "time": 1e-7}


@dataclass
class Kernel:
    """A law behind its signature: `address` to call, `compiled` or called back in Python; keep it while in use."""

    address: int
    compiled: bool
    keep: Any
    errors: list[BaseException] = field(default_factory=list)


def load_generated(text: str, name: str, files: list[str]) -> Any:
    """Write a generated module into the cache folder, keyed by all it depends on, and import it."""
    folder = compilation.key_folder([*files, __file__, compilation.__file__])
    path = folder / f"{name}.py"
    if not path.exists() or path.read_text(encoding="utf-8") != text:
        atomic_write_text(path, text)
    spec = importlib.util.spec_from_file_location(f"sim_kernel_{name}", path)
    assert spec is not None and spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    # numba finds the module of a kernel it has cached by its name.
    sys.modules[spec.name] = module
    spec.loader.exec_module(module)
    return module


_EFFECT_TEXT = """\
from numba import carray, njit
from sim.library.effect import Axis
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


LAW_OPTIONS = "error_model='numpy', no_cpython_wrapper=True, no_cfunc_wrapper=True"
"""How a law is compiled within its kernel: nothing calls it from outside, and wrappers take as long as the law."""


def values_text(effect: Effect, held: bool, first: int = 0) -> str:
    """The parameters for a kernel: read from its table `q` from `first` on, or, of those held at their defaults,
    written in as numbers."""
    return ", ".join(
        repr(float(p.default)) if held and p.fixed else f"q[{first + i}]" for i, p in enumerate(effect.parameters)
    )


def _effect_text(effect: Effect, held: bool, slopes: SlopePlan) -> str:
    functions, lines, sloped = [], [], []
    fields = list(Axis._fields)
    for i, law in enumerate(LAWS):
        if getattr(effect, law) is not None:
            functions.append(f"{law} = njit({LAW_OPTIONS})(EFFECT.{law})")
            lines.append(f"    r[{i * OUT}] = {law}(here, values)")
        else:
            lines.append(f"    r[{i * OUT}] = {1.0 if law == 'factor' else 0.0}")
    for i, column, kind in slopes:
        law, by = LAWS[i], BY[column - 1]
        if kind == "declared":
            functions.append(f"{law}_{by} = njit({LAW_OPTIONS})(EFFECT.slopes['{law}.{by}'])")
            sloped.append(f"        r[{i * OUT + column}] = {law}_{by}(here, values)")
        else:
            step = f"({DIFFERENCE[by]!r} * (1.0 + abs(here.{by})))"
            moved = [
                ", ".join(f"here.{f} {sign} {step}" if f == by else f"here.{f}" for f in fields) for sign in ("+", "-")
            ]
            sloped.append(
                f"        r[{i * OUT + column}] = "
                f"({law}(Axis({moved[0]}), values) - {law}(Axis({moved[1]}), values)) / (2.0 * {step})"
            )
    if sloped:
        lines += ["    if slopes:", *sloped]
    return _EFFECT_TEXT.format(
        name=effect.name,
        functions="\n".join(functions),
        axis=len(fields),
        size=max(len(effect.parameters), 1),
        out=len(LAWS) * OUT,
        here=", ".join(f"a[{i}]" for i in range(len(fields))),
        values=values_text(effect, held),
        lines="\n".join(lines),
    )


def source_files(functions: list[Callable[..., Any] | None]) -> list[str]:
    """The files that these functions stand in."""
    return [f.__code__.co_filename for f in functions if f is not None and inspect.isfunction(f)]


def generated_kernel(text: str, name: str, signature: Any, files: list[str]) -> Kernel | None:
    """The function `kernel` of a source text, compiled; None where numba cannot do it.

    Args:
        text: source of a module.
        name: of the module.
        signature: of the kernel, numba's.
        files: that the text takes its laws from; a change in one of them compiles anew.
    """
    try:
        module = load_generated(text, name, files)
        callback = compilation.compile_callback(module.kernel, signature, files)
    except Exception as error:
        if not type(error).__module__.startswith("numba"):
            raise
        return None
    return Kernel(callback.address, True, callback)


def compile_effect(effect: Effect, held: bool, slopes: SlopePlan) -> Kernel | None:
    """The kernel of a built-in effect, with parameters that are `held` written in; None where numba cannot do it."""
    from numba import types

    files = source_files([effect.level, effect.factor, effect.force, *effect.slopes.values()])
    signature = types.void(*[types.CPointer(types.double)] * 3, types.int64)
    text = _effect_text(effect, held, slopes)
    return generated_kernel(text, f"effect_{effect.values_type.__name__}{'_held' * held}", signature, files)


_CORE_TEXT = """\
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


def compile_core(effect: Effect) -> Kernel | None:
    """The kernel of a built-in core or element; None where numba cannot do it."""
    from numba import types

    core: FrictionStateModel = effect.friction_state or effect.parallel_element
    size = len(effect.parameters)
    text = _CORE_TEXT.format(
        name=effect.name, size=max(size, 1), values=values_text(effect, held=False), options=LAW_OPTIONS
    )
    files = source_files([core.law, core.slopes])
    pointer = types.CPointer(types.double)
    signature = types.void(pointer, *[types.double] * 3, pointer, pointer, types.int64, types.int64)
    return generated_kernel(text, f"core_{effect.values_type.__name__}", signature, files)
