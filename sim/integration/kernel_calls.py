"""Calls of kernels through their addresses, for compiled code: an effect's, a group of elements', a whole model's.

Arrays are handed over by the addresses of their entries; `sim.integration.kernels` and `sim.integration.model_kernel`
say what each kernel reads and writes. Importing this module imports numba.
"""

from __future__ import annotations

from typing import Any

from llvmlite import ir
from numba import types
from numba.core import cgutils
from numba.extending import intrinsic

_NUMBER, _INTEGER = ir.DoubleType(), ir.IntType(64)
_POINTER = _NUMBER.as_pointer()


def _call(builder: Any, address: Any, arguments: list[Any]) -> None:
    kind = ir.FunctionType(ir.VoidType(), [a.type for a in arguments])
    builder.call(builder.inttoptr(address, kind.as_pointer()), arguments)


def _entry(context: Any, builder: Any, kind: Any, array: Any, first: Any = None) -> Any:
    """Pointer to an array's first entry, or to the one `first` entries on."""
    data = cgutils.create_struct_proxy(kind)(context, builder, value=array).data
    return data if first is None else builder.gep(data, [first])


def _effect_call(context: Any, address: Any, axis: Any, p: Any, out: Any, first: Any, slopes: Any) -> Any:
    def generate(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        address, axis, p, out, first, slopes = arguments
        axis = _entry(context, builder, signature.args[1], axis)
        out = _entry(context, builder, signature.args[3], out, first)
        _call(builder, address, [axis, builder.inttoptr(p, _POINTER), out, slopes])
        return context.get_dummy_value()

    return types.void(types.int64, axis, types.int64, out, types.int64, types.int64), generate


def _elements_call(
    context: Any, address: Any, y: Any, first: Any, v: Any, direction: Any, g: Any, p: Any, out: Any, row: Any, n: Any,
    slopes: Any,
) -> Any:  # fmt: skip
    def generate(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        address, y, first, v, direction, g, p, out, row, n, slopes = arguments
        z = _entry(context, builder, signature.args[1], y, first)
        out = _entry(context, builder, signature.args[7], out, row)
        _call(builder, address, [z, v, direction, g, builder.inttoptr(p, _POINTER), out, n, slopes])
        return context.get_dummy_value()

    number, integer = types.float64, types.int64
    return types.void(integer, y, integer, *[number] * 3, integer, out, *[integer] * 3), generate


def _model_call(
    context: Any, address: Any, t: Any, y: Any, direction: Any, lagged: Any, base: Any, p: Any, elements: Any, out: Any
) -> Any:
    def generate(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        address, t, y, direction, lagged, base, p, elements, out = arguments
        y, base, elements, out = (
            _entry(context, builder, signature.args[i], a) for i, a in ((2, y), (5, base), (7, elements), (8, out))
        )
        _call(builder, address, [t, y, direction, lagged, base, builder.inttoptr(p, _POINTER), elements, out])
        return context.get_dummy_value()

    number = types.float64
    return types.void(types.int64, number, y, number, number, base, types.int64, elements, out), generate


call_effect: Any = intrinsic(_effect_call)
"""`call_effect(address, axis, p, out, first, slopes)`: writes to `out` from entry `first` on; `p` is an address."""

call_elements: Any = intrinsic(_elements_call)
"""`call_elements(address, y, first, v, direction, g, p, out, row, n, slopes)`: the states stand in `y` from `first` on,
and what is found goes to `out` from its entry `row` on, counted in numbers; `p` is an address."""

call_model: Any = intrinsic(_model_call)
"""`call_model(address, t, y, direction, lagged, base, p, elements, out)`; `p` is an address."""
