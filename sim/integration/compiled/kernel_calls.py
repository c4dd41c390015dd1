"""Calls of kernels through their addresses, for compiled code: an effect's, and a group of elements'.

Arrays are passed by the address of an entry; `sim.integration.compiled.kernels` describes what each kernel reads and
writes. Importing this module imports numba.
"""

from __future__ import annotations

from typing import Any

from llvmlite import ir
from numba import types
from numba.core import cgutils
from numba.extending import intrinsic

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
