"""A design that records which values are read from it, so that a cached result depends only on these parameters.

`TrackedDesign(design, reads)` behaves like the design. Each number, text or tuple reached through it is recorded with
its access path. Later the same paths are followed in another design and the values compared as their `repr` (exact for
floats), to decide whether a cached result is valid for that design.
"""

from collections.abc import Iterable, Mapping
from typing import Any

AccessPath = tuple[tuple[Any, ...], ...]
"""Steps to a value: ("attribute", name), ("item", key) or ("call", positional, ((name, value), ...)), in order."""

LEAVES = (bool, int, float, str, tuple, list, frozenset)
"""Types that are recorded as a whole, by their `repr`; other objects are tracked in turn."""


UNTRACKED = "machine"
"""Attribute of a design that is no value: what the machine makes depends on its modules."""


class TrackedDesign:
    """Proxy of a design, or of a table in it, that records what is read: access path -> `repr` of the value in
    `reads`."""

    __slots__ = ("_tracked_path", "_tracked_reads", "_tracked_target")

    def __init__(self, target: Any, reads: dict[AccessPath, str], path: AccessPath = ()) -> None:
        self._tracked_target = target
        self._tracked_reads = reads
        self._tracked_path = path

    def _tracked_value(self, value: Any, step: tuple[Any, ...]) -> Any:
        path = (*self._tracked_path, step)
        if value is None or isinstance(value, LEAVES):
            self._tracked_reads[path] = repr(value)
            return value
        return TrackedDesign(value, self._tracked_reads, path)

    def _tracked_whole(self) -> Any:
        """The target itself, recorded as a whole: for operations that read all of a table."""
        self._tracked_reads[self._tracked_path] = repr(self._tracked_target)
        return self._tracked_target

    def __getattr__(self, name: str) -> Any:
        if name.startswith("__"):
            raise AttributeError(name)
        target = self._tracked_target
        if name == UNTRACKED:
            return getattr(target, name)
        if isinstance(target, Mapping):
            return getattr(self._tracked_whole(), name)
        return self._tracked_value(getattr(target, name), ("attribute", name))

    def __getitem__(self, key: Any) -> Any:
        return self._tracked_value(self._tracked_target[key], ("item", key))

    def __call__(self, *positional: Any, **named: Any) -> Any:
        value = self._tracked_target(*positional, **named)
        return self._tracked_value(value, ("call", positional, tuple(sorted(named.items()))))

    def __iter__(self) -> Any:
        return iter(self._tracked_whole())

    def __len__(self) -> int:
        return len(self._tracked_whole())

    def __contains__(self, key: object) -> bool:
        return key in self._tracked_whole()

    def __eq__(self, other: object) -> bool:
        return self._tracked_whole() == (other._tracked_whole() if isinstance(other, TrackedDesign) else other)

    def __hash__(self) -> int:
        return hash(self._tracked_whole())

    def __repr__(self) -> str:
        return repr(self._tracked_whole())


def value_at(design: Any, path: Iterable[Iterable[Any]]) -> str | None:
    """`repr` of the value that `design` has at the end of `path`; None where the path does not exist."""
    value = design
    try:
        for kind, *rest in path:
            if kind == "attribute":
                value = getattr(value, rest[0])
            elif kind == "item":
                value = value[rest[0]]
            else:
                value = value(*rest[0], **dict(rest[1]))
    except (AttributeError, KeyError, IndexError, TypeError, ValueError):
        return None
    return repr(value)


def path_text(path: AccessPath) -> str:
    """An access path as Python source: ``stage.thickness``, ``screws['way'].length``."""
    text = ""
    for kind, *rest in path:
        if kind == "attribute":
            text += f".{rest[0]}"
        elif kind == "item":
            text += f"[{rest[0]!r}]"
        else:
            words = [*(repr(value) for value in rest[0]), *(f"{name}={value!r}" for name, value in rest[1])]
            text += f"({', '.join(words)})"
    return text.removeprefix(".")
