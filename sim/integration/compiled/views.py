"""Arrays of compiled functions by address and shape alone.

numba represents an array by its owner, counts, shape and strides: a named tuple of 30 arrays is 250 numbers, which each
function it is passed to receives, and most of the compile time is spent on them. A view is an address and a shape: of
an array in C order of float64 or int64, whose owner is in Python. Its indices must not be negative. It has `shape`,
and is indexed by integers, of which fewer than its dimensions give a view of the rest.

Importing this module imports numba.
"""

import ctypes
import math
import operator
import struct
from collections.abc import Callable, Iterable, Sequence
from multiprocessing.process import BaseProcess
from typing import Any, NamedTuple

import numpy as np
from llvmlite import ir
from numba import types
from numba.core import cgutils
from numba.core.typing.templates import AbstractTemplate, infer_global, signature
from numba.extending import intrinsic, lower_builtin, make_attribute_wrapper, models, register_model

from sim.numerics.compilation import compile_callback, is_cached
from stagecad.processes import forked


class View(types.Type):
    """Type of a view: `dtype` of its entries, `ndim` dimensions."""

    def __init__(self, dtype: Any, ndim: int) -> None:
        self.dtype, self.ndim = dtype, ndim
        super().__init__(name=f"View({dtype}, {ndim})")


@register_model(View)
class _ViewModel(models.StructModel):
    def __init__(self, manager: Any, kind: View) -> None:
        members = [("data", types.CPointer(kind.dtype)), ("shape", types.UniTuple(types.int64, kind.ndim))]
        super().__init__(manager, kind, members)


make_attribute_wrapper(View, "shape", "shape")

_infer_global: Any = infer_global


def _indexed(view: Any, index: Any) -> tuple[Any, Any] | None:
    """Types of the entry and of the index; None where this index is not for this view."""
    if not isinstance(view, View):
        return None
    count = len(index) if isinstance(index, types.BaseTuple) else 1
    if count > view.ndim or not isinstance(index, types.BaseTuple | types.Integer):
        return None
    entry = view.dtype if count == view.ndim else View(view.dtype, view.ndim - count)
    return entry, types.UniTuple(types.int64, count) if isinstance(index, types.BaseTuple) else types.int64


@_infer_global(operator.getitem)
class _GetItem(AbstractTemplate):
    def generic(self, args: Any, kws: Any) -> Any:
        found = _indexed(*args)
        return None if found is None else signature(found[0], args[0], found[1])


@_infer_global(operator.setitem)
class _SetItem(AbstractTemplate):
    def generic(self, args: Any, kws: Any) -> Any:
        found = _indexed(args[0], args[1])
        if found is None or found[0] != args[0].dtype:
            return None
        return signature(types.none, args[0], found[1], args[0].dtype)


def _entry(context: Any, builder: Any, kind: Any, view: Any, index: Any) -> tuple[Any, list[Any]]:
    """Address of an entry, or of the first entry of a row; and the shape of the row."""
    struct_of_view = cgutils.create_struct_proxy(kind)(context, builder, value=view)
    shape = cgutils.unpack_tuple(builder, struct_of_view.shape)
    indices = [index] if index.type == context.get_value_type(types.int64) else cgutils.unpack_tuple(builder, index)
    place = indices[0]
    for axis in range(1, kind.ndim):
        place = builder.mul(place, shape[axis], flags=["nsw"])
        if axis < len(indices):
            place = builder.add(place, indices[axis], flags=["nsw"])
    return builder.gep(struct_of_view.data, [place], inbounds=True), shape[len(indices) :]


@lower_builtin(operator.getitem, View, types.Any)
def _get(context: Any, builder: Any, sig: Any, args: Any) -> Any:
    address, rest = _entry(context, builder, sig.args[0], *args)
    if not rest:
        return builder.load(address)
    row = cgutils.create_struct_proxy(sig.return_type)(context, builder)
    row.data, row.shape = address, cgutils.pack_array(builder, rest)
    return row._getvalue()


@lower_builtin(operator.setitem, View, types.Any, types.Any)
def _set(context: Any, builder: Any, sig: Any, args: Any) -> Any:
    address, _ = _entry(context, builder, sig.args[0], *args[:2])
    builder.store(args[2], address)
    return context.get_dummy_value()


_ADDRESS_CODE = {"d": "P", "l": "Q", "q": "Q"}
"""Code of an address in a packed structure, by the type of the array's entries: tells float64 from int64."""


class Zeros:
    """An array of zeros that compiled code alone uses: those of one call are allocated together."""

    def __init__(self, shape: tuple[int, ...], dtype: type = float) -> None:
        self.shape, self.length = shape, math.prod(shape)
        self.code = ("P" if dtype is float else "Q") + "q" * len(shape)


class Packed:
    """Arguments as eight-byte words: a tuple without `Zeros` may be packed once for several calls, with its numbers
    and the places of its arrays as they are now."""

    def __init__(self, arguments: Any) -> None:
        self.arguments = arguments
        self.codes: list[str] = []  # of the words, for module `struct`
        self.words: list[Any] = []  # numbers, addresses and lengths
        # index of the address among the words, and offset, of each array of zeros; their length together
        self.zeros: list[tuple[int, int]] = []
        self.length = 0
        self._add(arguments)

    @property
    def form(self) -> str:
        """Kinds of all words, one after the other."""
        return "".join(self.codes)

    def _add(self, value: Any) -> None:
        if isinstance(value, float):
            self.codes.append("d")
            self.words.append(value)
        elif isinstance(value, Zeros):
            self.zeros.append((len(self.words), self.length))
            self.length += value.length
            self.codes.append(value.code)
            self.words += (0, *value.shape)
        elif isinstance(value, np.ndarray):
            code = _ADDRESS_CODE.get(value.dtype.char)
            if code is None or value.itemsize != 8 or not value.flags.c_contiguous:
                raise TypeError(f"array of {value.dtype}, strides {value.strides}; must be float64 or int64 in C order")
            self.codes.append(code + "q" * value.ndim)
            self.words += (value.ctypes.data, *value.shape)
        elif isinstance(value, Packed):
            self.codes += value.codes
            self.words += value.words
        elif isinstance(value, tuple):
            for part in value:
                self._add(part)
        elif isinstance(value, int | np.integer):
            self.codes.append("q")
            self.words.append(value)
        else:
            raise TypeError(f"{type(value).__name__}; must be a float, an integer, an array or a tuple of these")


def _kind(value: Any) -> Any:
    """numba's type of what `Packed` has of a value."""
    if isinstance(value, Packed):
        return _kind(value.arguments)
    if isinstance(value, Zeros):
        return View(types.float64 if value.code[0] == "P" else types.int64, len(value.shape))
    if isinstance(value, tuple):
        parts = [_kind(part) for part in value]
        return types.NamedTuple(parts, type(value)) if hasattr(value, "_fields") else types.Tuple(parts)
    if isinstance(value, np.ndarray):
        return View(types.float64 if value.dtype.char == "d" else types.int64, value.ndim)
    return types.float64 if isinstance(value, float) else types.int64


class Part:
    """A function compiled on its own, which others call by its address instead of containing it.

    numba optimises a function again in each one that calls it: a large one is better compiled once. `call` is for
    compiled code: `call(address, memory, arguments)`, with an address that `OverViews` adds to the arguments.

    Args:
        function: of the memory of the function that calls it, and of a tuple of further arguments; it returns a float.
        example: such a tuple of floats and integers.
    """

    def __init__(self, function: Callable[[Any, Any], float], example: tuple[Any, ...]) -> None:
        self.function, self.arguments = function, _kind(example)
        self.call: Any = intrinsic(self._typed)

    def _typed(self, context: Any, address: Any, memory: Any, arguments: Any) -> Any:
        def generate(context: Any, builder: Any, sig: Any, args: Any) -> Any:
            address, *passed = args
            kind = ir.FunctionType(ir.DoubleType(), [value.type for value in passed])
            return builder.call(builder.inttoptr(address, kind.as_pointer()), passed)

        return types.float64(types.int64, memory, self.arguments), generate


class _Ready(NamedTuple):
    """A compiled function, the addresses of its parts, and what owns both."""

    call: Callable[[bytes], None]
    parts: list[int]
    owners: Any


LONGEST_COMPILATION = 60.0
"""Time after which the process that compiles parts is ended, s, and they are compiled here: a fork may have inherited a
lock that no thread of its own releases."""


class OverViews:
    """A function compiled to receive its arguments in memory, the arrays among them as views; cached on disk."""

    def __init__(
        self,
        function: Callable[[Any], None],  # of one argument `memory`: `memory[0]` is the tuple of the arguments
        also: Iterable[str] = (),  # further source files that it depends on
        fastmath: Iterable[str] = (),  # numba's
        parts: Sequence[Part] = (),  # that it calls; a tuple of their addresses follows the arguments in memory
    ) -> None:
        self._function, self._parts, self._files = function, parts, [__file__, *also]
        self._options = {"forceinline": False, "fastmath": set(fastmath), "_nrt": False}
        self._ready: dict[str, _Ready] = {}
        self._other_process: BaseProcess | None = None

    def __call__(self, *arguments: Any) -> None:
        """Call the function with floats, integers, arrays in C order of float64 or int64, `Zeros`, (named) tuples of
        these, which may be `Packed`, the same ones in each call. It is compiled when it is first called with a
        combination of kinds and numbers of dimensions. Other threads run meanwhile.

        Raises:
            TypeError: an argument of another kind.
        """
        packed = Packed(arguments)
        zeros = np.zeros(packed.length)
        begin = zeros.ctypes.data
        for at, offset in packed.zeros:
            packed.words[at] = begin + 8 * offset
        form = packed.form
        if form not in self._ready:
            self._ready[form] = self._compiled(arguments)
        found = self._ready[form]
        words = struct.pack("=" + form.replace("P", "Q") + "q" * len(self._parts), *packed.words, *found.parts)
        found.call(words)

    @property
    def is_compiled(self) -> bool:
        """Whether it has been called, so that it is compiled for the arguments of that call at least."""
        return bool(self._ready)

    def begin_parts(self, *arguments: Any) -> None:
        """Let another process begin to compile the parts that the disk lacks, for a call with such arguments to come.

        This process compiles the function itself meanwhile, and what else it needs.
        """
        if self._other_process is not None or all(is_cached(part.function, self._files) for part in self._parts):
            return
        memory = self._memory(arguments)
        self._other_process = forked(lambda: [self._compiled_part(part, memory) for part in self._parts])

    def _memory(self, arguments: tuple[Any, ...]) -> Any:
        return types.CPointer(_kind((*arguments, (0,) * len(self._parts)) if self._parts else arguments))

    def _compiled_part(self, part: Part, memory: Any) -> Any:
        return compile_callback(part.function, types.float64(memory, part.arguments), self._files, **self._options)

    def _compiled(self, arguments: tuple[Any, ...]) -> _Ready:
        memory = self._memory(arguments)
        main = compile_callback(self._function, types.void(memory), self._files, **self._options)
        if self._other_process is not None:
            self._other_process.join(LONGEST_COMPILATION)
            self._other_process.kill()
            self._other_process = None
        made = [self._compiled_part(part, memory) for part in self._parts]
        call = ctypes.CFUNCTYPE(None, ctypes.c_char_p)(main.address)
        return _Ready(call, [one.address for one in made], (main, made))
