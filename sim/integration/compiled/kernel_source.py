"""Source of the kernels of built-in laws: small generated modules that unpack pointers into a law's named arguments.

`sim.integration.compiled.kernels` describes what each kernel reads and writes.
"""

import importlib.util
import inspect
import sys
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

from sim.effects.effect import Axis, Effect
from sim.effects.friction_state_model import FrictionStateModel
from sim.numerics import compilation
from sim.numerics.elasto_plastic import smooth_element
from stagecad.parameters.atomic import atomic_write_text

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


def compile_state(effect: Effect) -> Kernel | None:
    """The kernel of the friction elements of a built-in effect; None where numba cannot compile it."""
    model: FrictionStateModel = effect.friction_state or effect.parallel_element
    size = max(len(effect.parameters), 1)
    text = _STATE_TEXT.format(name=effect.name, size=size, values=_values_text(effect), options=_LAW_OPTIONS)
    files = _source_files([model.law, model.slopes])
    return _compile(text, f"state_{effect.values_type.__name__}", _state_signature(), files)


def compile_elements() -> Kernel:
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
        module = _load_generated(text, name, files)
        callback = compilation.compile_callback(module.kernel, signature, files)
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
