"""A design that notes what is read of it, so that a result depends on just the parameters it was made from.

`Reading(design, notes)` looks like the design. Each number, text or tuple reached through it is noted with the way to
it; the notes later tell whether another design would give the same: every step is walked again, and the values compared
as their `repr` (exact for floats).
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Any

Steps = tuple[tuple[Any, ...], ...]
"""Way to a value: ("attribute", name), ("item", key) or ("call", positional, ((name, value), ...)), in order."""

LEAVES = (bool, int, float, str, tuple, list, frozenset)
"""Types whose `repr` says all there is to them; anything else is looked into."""


class Reading:
    """Stand-in for a design, or for a table of it, that notes what is read.

    Args:
        target: the design.
        notes: filled with way -> `repr` of the value found there.
    """

    __slots__ = ("_reading_notes", "_reading_steps", "_reading_target")

    def __init__(self, target: Any, notes: dict[Steps, str], steps: Steps = ()) -> None:
        self._reading_target = target
        self._reading_notes = notes
        self._reading_steps = steps

    def _reading_found(self, value: Any, step: tuple[Any, ...]) -> Any:
        steps = (*self._reading_steps, step)
        if value is None or isinstance(value, LEAVES):
            self._reading_notes[steps] = repr(value)
            return value
        return Reading(value, self._reading_notes, steps)

    def _reading_whole(self) -> Any:
        """The bare value, noted as a whole: for what looks at a table in full."""
        self._reading_notes[self._reading_steps] = repr(self._reading_target)
        return self._reading_target

    def __getattr__(self, name: str) -> Any:
        if name.startswith("__"):
            raise AttributeError(name)
        target = self._reading_target
        if isinstance(target, Mapping):
            return getattr(self._reading_whole(), name)
        return self._reading_found(getattr(target, name), ("attribute", name))

    def __getitem__(self, key: Any) -> Any:
        return self._reading_found(self._reading_target[key], ("item", key))

    def __call__(self, *positional: Any, **named: Any) -> Any:
        value = self._reading_target(*positional, **named)
        return self._reading_found(value, ("call", positional, tuple(sorted(named.items()))))

    def __iter__(self) -> Any:
        return iter(self._reading_whole())

    def __len__(self) -> int:
        return len(self._reading_whole())

    def __contains__(self, key: object) -> bool:
        return key in self._reading_whole()

    def __eq__(self, other: object) -> bool:
        return self._reading_whole() == (other._reading_whole() if isinstance(other, Reading) else other)

    def __hash__(self) -> int:
        return hash(self._reading_whole())

    def __repr__(self) -> str:
        return repr(self._reading_whole())


def walk(design: Any, steps: Iterable[Iterable[Any]]) -> str | None:
    """`repr` of what `design` has at the end of `steps`; None where the way ends early."""
    value = design
    try:
        for kind, *rest in steps:
            if kind == "attribute":
                value = getattr(value, rest[0])
            elif kind == "item":
                value = value[rest[0]]
            else:
                value = value(*rest[0], **dict(rest[1]))
    except (AttributeError, KeyError, IndexError, TypeError, ValueError):
        return None
    return repr(value)


def noted(steps: Steps) -> str:
    """A way as a person would write it: ``stage.thickness``, ``screws['way'].length``."""
    text = ""
    for kind, *rest in steps:
        if kind == "attribute":
            text += f".{rest[0]}"
        elif kind == "item":
            text += f"[{rest[0]!r}]"
        else:
            words = [*(repr(value) for value in rest[0]), *(f"{name}={value!r}" for name, value in rest[1])]
            text += f"({', '.join(words)})"
    return text.removeprefix(".")
