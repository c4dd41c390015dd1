"""The error for invalid input of the user."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from difflib import get_close_matches
from typing import Any


class InputError(ValueError):
    """Invalid input: the message is one line with place, value and what is allowed."""


class ViolationsError(InputError):
    """Several faults of one input. `str` is the line of the first, sufficient by itself.

    Args:
        lines: one line for each fault, the first with the number of the others.
        documents: the same as JSON documents.
    """

    def __init__(self, lines: Sequence[str], documents: Sequence[dict[str, Any]]) -> None:
        super().__init__(lines[0])
        self.lines = tuple(lines)
        self.documents = tuple(documents)

    def __reduce__(self) -> tuple[Any, ...]:
        return type(self), (self.lines, self.documents)


def nearest(name: str, allowed: Iterable[str]) -> str:
    """Ending of an error message that names the nearest valid name, or all of them when none is near.

    Args:
        name: as written by the user.
        allowed: the valid names.

    Returns:
        ``"; did you mean 'x'?"`` or ``"; allowed: a, b, c"``.
    """
    names = sorted(allowed)
    close = get_close_matches(name, names, n=1, cutoff=0.6)
    if close:
        return f"; did you mean '{close[0]}'?"
    return f"; allowed: {', '.join(names)}"
