"""All laws of a model in one kernel: what an integration needs at every stage, which is values and no slopes.

A call through an address costs as much as a simple law, and there are two for every effect and element. Where the laws
are many, one function that calls them all is worth its compilation; it is generated from the list of laws and kept on
disk as every kernel is.

    model(t, y, direction, lagged, base, p, elements, out): elements[k] = rate, force of each element;
        out = [level, force of the core, of the effects, of elements beside the core], as `sim.integration.axis_forces`
        has them
"""

from __future__ import annotations

import functools
import hashlib
from dataclasses import dataclass

from sim.effects.catalogue import find
from sim.integration.generated_kernels import LAW_OPTIONS, Kernel, generated_kernel, source_files, values_text
from sim.library.effect import Effect
from sim.library.friction_state import FrictionStateModel

FEWEST = 6
"""Effects and groups of elements from which on one kernel is compiled for all of them."""


@dataclass(frozen=True)
class Law:
    """What a model takes of one built-in effect.

    Args:
        name: of the effect.
        held: whether its held parameters have their defaults, which are then written in.
        laws: those of level, factor and force that are taken.
        lagged: whether its level and factor see the lagged speed.
        elements: of its core or element; zero where it has none, or none that is taken.
        beside: whether its elements stand beside the core.
    """

    name: str
    held: bool
    laws: tuple[str, ...]
    lagged: bool = False
    elements: int = 0
    beside: bool = False


_TEXT = """\
import math

from numba import carray, njit

from sim.library.effect import Axis
from sim.effects.catalogue import find

{functions}


def kernel(t, y, direction, lagged, base, p, elements, out):
    s = carray(y, ({states},))
    b = carray(base, (5,))
    q = carray(p, ({parameters},))
    e = carray(elements, ({rows}, 8))
    r = carray(out, (4,))
    v = s[1]
    here = Axis(t, s[0], v, math.nan, b[3], b[4], {age}, math.nan, {travelled}, direction)
    seen = Axis(t, s[0], direction * lagged, math.nan, b[3], b[4], {age}, math.nan, {travelled}, direction)
    level, factor, force, core, others = b[0], b[1], b[2], 0.0, 0.0
{lines}
    g = level * factor
{elements}
    r[0], r[1], r[2], r[3] = g, core, force, others
"""

_TAKEN = {"level": "level += {}", "factor": "factor *= {}", "force": "force += {}"}


def _text(laws: tuple[Law, ...], head: int) -> str:
    functions, lines, elements = [], [], []
    parameters, count = 0, 0
    for i, law in enumerate(laws):
        effect = find(law.name)
        functions.append(f"E{i} = find({law.name!r})")
        values = f"E{i}_values({values_text(effect, law.held, parameters)})"
        functions.append(f"E{i}_values = E{i}.values_type")
        parameters += len(effect.parameters)
        for taken in law.laws:
            functions.append(f"{taken}_{i} = njit({LAW_OPTIONS})(E{i}.{taken})")
            axis = "seen" if law.lagged and taken != "force" else "here"
            lines.append("    " + _TAKEN[taken].format(f"{taken}_{i}({axis}, {values})"))
        if law.elements:
            functions.append(f"law_{i} = njit({LAW_OPTIONS})((E{i}.friction_state or E{i}.parallel_element).law)")
            elements += [
                f"    w = {values}",
                f"    for k in range({law.elements}):",
                f"        e[{count} + k, 0], e[{count} + k, 1] = law_{i}(k, s[{head + count} + k], v, direction, g, w)",
                f"        {'others' if law.beside else 'core'} += e[{count} + k, 1]",
            ]
            count += law.elements
    return _TEXT.format(
        functions="\n".join(functions),
        states=head + count,
        parameters=max(parameters, 1),
        rows=max(count, 1),
        age="s[3]" if head > 2 else "0.0",
        travelled="s[2]" if head > 2 else "0.0",
        lines="\n".join(lines),
        elements="\n".join(elements),
    )


@functools.cache
def model_kernel(laws: tuple[Law, ...], head: int) -> Kernel | None:
    """One kernel for these laws, the core first, and `head` states before the elements; None where numba cannot.

    Its parameters `p` are those of every effect, in this order.
    """
    from numba import types

    files: list[str] = []
    for law in laws:
        effect: Effect = find(law.name)
        core: FrictionStateModel | None = effect.friction_state or effect.parallel_element
        files += source_files([effect.level, effect.factor, effect.force, core.law if core is not None else None])
    text = _text(laws, head)
    number, pointer = types.double, types.CPointer(types.double)
    signature = types.void(number, pointer, number, number, *[pointer] * 4)
    name = f"model_{hashlib.sha256(text.encode()).hexdigest()[:16]}"
    return generated_kernel(text, name, signature, files)
