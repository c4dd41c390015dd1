"""Calls of kernels through their addresses, for compiled code: an effect's, and that of a group of elements.

Arrays are handed over by the addresses of their first entries; `sim.kernels` says what each kernel reads and writes.
Importing this module imports numba.
"""

from __future__ import annotations

from typing import Any

from llvmlite import ir
from numba import types
from numba.extending import intrinsic

_NUMBER, _INTEGER = ir.DoubleType(), ir.IntType(64)
_POINTER = _NUMBER.as_pointer()


def _effect_call(context: Any, address: Any, axis: Any, p: Any, out: Any, slopes: Any) -> Any:
    def generate(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        kind = ir.FunctionType(ir.VoidType(), [_POINTER] * 3 + [_INTEGER])
        function = builder.inttoptr(arguments[0], kind.as_pointer())
        builder.call(function, [*(builder.inttoptr(a, _POINTER) for a in arguments[1:4]), arguments[4]])
        return context.get_dummy_value()

    return types.void(*[types.int64] * 5), generate


def _elements_call(
    context: Any, address: Any, z: Any, v: Any, direction: Any, g: Any, p: Any, out: Any, n: Any, slopes: Any
) -> Any:
    def generate(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        kind = ir.FunctionType(ir.VoidType(), [_POINTER] + [_NUMBER] * 3 + [_POINTER] * 2 + [_INTEGER] * 2)
        function = builder.inttoptr(arguments[0], kind.as_pointer())
        z, p, out = (builder.inttoptr(arguments[i], _POINTER) for i in (1, 5, 6))
        builder.call(function, [z, *arguments[2:5], p, out, *arguments[7:]])
        return context.get_dummy_value()

    return types.void(*[types.int64] * 2, *[types.float64] * 3, *[types.int64] * 4), generate


call_effect: Any = intrinsic(_effect_call)
"""`call_effect(address, axis, p, out, slopes)`."""

call_elements: Any = intrinsic(_elements_call)
"""`call_elements(address, z, v, direction, g, p, out, n, slopes)`."""
