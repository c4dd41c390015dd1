"""Compile with numba, at first use, into a cache on disk that is keyed by the source it was compiled from.

numba itself checks only the time stamp of the file that defines a function, so an edit of a law in another file would
leave old machine code in use. Here the folder's name is a hash of every source file that the function depends on.
The cache is in a private folder (`stagecad.private`), never in the package, which may be read-only.
"""

import contextlib
import functools
import hashlib
import os
import shutil
import sys
import time
import types
from collections.abc import Callable, Iterable, Iterator
from pathlib import Path
from typing import Any, overload

from stagecad.parameters.atomic import atomic_write_text
from stagecad.private import cache_root, make_private

KEPT_DAYS = 60


@functools.cache
def cache_folder() -> Path:
    """The folder for compiled kernels; only this user can change it, since what is in it runs."""
    return make_private(cache_root() / "kernels")


def _hash_of(path: str) -> str:
    return hashlib.sha256(Path(path).read_bytes()).hexdigest()


_digest = functools.cache(_hash_of)


def key_folder(files: Iterable[str]) -> Path:
    """The cache folder of functions that depend on these source files; those unused for `KEPT_DAYS` are removed."""
    root = cache_folder()
    import numba

    text = "\n".join([numba.__version__, sys.version, *(_digest(file) for file in sorted(set(files)))])
    folder = root / hashlib.sha256(text.encode()).hexdigest()[:20]
    with contextlib.suppress(OSError):
        new = not folder.exists()
        folder.mkdir(parents=True, exist_ok=True)
        os.utime(folder)
        if new:
            oldest = time.time() - KEPT_DAYS * 86400.0
            for other in root.iterdir():
                if other.stat().st_mtime < oldest:
                    shutil.rmtree(other, ignore_errors=True)
    return folder


@contextlib.contextmanager
def _caching_in(folder: Path) -> Iterator[None]:
    # numba chooses the cache folder while it decorates the function: the setting is changed for that time only.
    from numba.core import config

    before = config.CACHE_DIR  # type: ignore[attr-defined]
    config.CACHE_DIR = str(folder)  # type: ignore[attr-defined]
    try:
        yield
    finally:
        config.CACHE_DIR = before  # type: ignore[attr-defined]


@functools.cache
def _numba_parts() -> Any:
    import numba
    from numba.core import caching

    class CheckedFile(caching.IndexDataCacheFile):
        """Files of numba's cache with their hashes beside them: a damaged one would end the process as it runs."""

        # A signature names the types of its arguments by their modules, which a newer version may have moved.
        def _load_index(self) -> Any:
            with contextlib.suppress(ImportError, AttributeError):
                return super()._load_index() if _is_intact(self._index_path) else {}  # type: ignore[misc]
            return {}

        def _load_data(self, name: str) -> Any:
            with contextlib.suppress(ImportError, AttributeError):
                if _is_intact(self._data_path(name)):
                    return super()._load_data(name)  # type: ignore[misc]
            raise OSError  # numba then compiles anew

        @contextlib.contextmanager
        def _open_for_write(self, filepath: str) -> Iterator[Any]:
            with super()._open_for_write(filepath) as file:  # type: ignore[misc]
                yield file
            with contextlib.suppress(OSError):
                atomic_write_text(f"{filepath}{HASH}", _hash_of(filepath))

    caching.IndexDataCacheFile = CheckedFile  # type: ignore[misc]
    return numba


HASH = ".sha256"
"""Ends the name of the file with the hash of one of numba's."""


def _is_intact(path: str) -> bool:
    try:
        return Path(f"{path}{HASH}").read_text("utf-8") == _hash_of(path)
    except (OSError, UnicodeDecodeError):
        return False


SUMS_IN_ANY_ORDER = {"reassoc", "contract"}
"""Reassociation of sums and fused multiply-add; infinities and NaN are kept."""

INLINED: dict[str, Any] = {
    "cache": False,
    "forceinline": True,
    "_nrt": False,
    "fastmath": {"contract"},
    "no_cpython_wrapper": True,
    "no_cfunc_wrapper": True,
}
"""Options of a function that LLVM inlines into the compiled function that calls it, without a cache file or wrappers of
its own. numba's `inline="always"` takes twice as long to compile."""


_depends_on: dict[int, tuple[Any, frozenset[str]]] = {}
"""Each compiled function, kept so that its identity stays its own, and its source files."""


def _called(function: Callable[..., Any]) -> set[str]:
    """Source files of the compiled functions that a function refers to."""
    named = (function.__globals__.get(name) for name in function.__code__.co_names)
    return {file for value in named if id(value) in _depends_on for file in _depends_on[id(value)][1]}


def compile_function(function: Callable[..., Any], also: Iterable[str] = (), **options: Any) -> Any:
    """`function` compiled by `numba.njit`, cached on disk.

    It is recompiled when its file changes, that of a compiled function it calls, or one of `also`.
    """
    numba = _numba_parts()
    files = frozenset([function.__code__.co_filename, __file__, *also, *_called(function)])
    with _caching_in(key_folder(files)):
        made = numba.njit(**{"cache": True, "error_model": "numpy", **options})(function)
    _depends_on[id(made)] = made, files
    return made


def compile_callback(function: Callable[..., Any], signature: Any, also: Iterable[str] = (), **options: Any) -> Any:
    """`function` compiled to a C callback (`.address`) with `signature`, cached on disk; `options` are numba's.

    It is recompiled as by `compile_function`.
    """
    numba = _numba_parts()
    chosen = {"cache": True, "error_model": "numpy", "forceinline": True, **options}
    with _caching_in(_callback_folder(function, also)):
        return numba.cfunc(signature, **chosen)(function)


def is_cached(function: Callable[..., Any], also: Iterable[str] = ()) -> bool:
    """Whether the disk has what `compile_callback` made of a function, for some signature and processor."""
    index = f"*.{function.__qualname__}-{function.__code__.co_firstlineno}.*.nbi"
    return any(_callback_folder(function, also).glob(f"*/{index}"))


def _callback_folder(function: Callable[..., Any], also: Iterable[str]) -> Path:
    return key_folder([function.__code__.co_filename, __file__, *also, *_called(function)])


@overload
def compiled(function: Callable[..., Any]) -> Callable[..., Any]: ...


@overload
def compiled(
    *, fastmath: set[str] = ..., forceinline: bool = ..., _nrt: bool = ...
) -> Callable[[Callable[..., Any]], Callable[..., Any]]: ...


def compiled(function: Callable[..., Any] | None = None, **options: Any) -> Callable[..., Any]:
    """Decorator: compile `function` when it is first called, so that importing its module costs nothing.

    Functions compiled in this way may call each other. `options` are numba's; `fastmath` names the liberties that sums
    may take, such as `SUMS_IN_ANY_ORDER`.
    """
    if function is None:
        return functools.partial(compiled, **options)
    ready: list[Any] = []

    def kernel() -> Any:
        if not ready:
            # numba finds the functions that are called among the globals: there each wrapper is replaced by its kernel.
            called: dict[str, Any] = {name: function.__globals__.get(name) for name in function.__code__.co_names}
            kernels = {name: value.kernel() for name, value in called.items() if hasattr(value, "kernel")}
            names = {**function.__globals__, **kernels}
            ready.append(compile_function(types.FunctionType(function.__code__, names, function.__name__), **options))
        return ready[0]

    @functools.wraps(function)
    def call(*arguments: Any) -> Any:
        return kernel()(*arguments)

    call.kernel = kernel  # type: ignore[attr-defined]
    return call


def inlined(function: Callable[..., Any]) -> Callable[..., Any]:
    """Decorator: `compiled`, for a function that allocates nothing and becomes part of the compiled ones calling it."""
    return compiled(forceinline=True, _nrt=False)(function)
