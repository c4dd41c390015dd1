"""The error for invalid input of the user."""

from __future__ import annotations

from collections.abc import Iterable
from difflib import get_close_matches


class InputError(ValueError):
    """Invalid input: the message is one line with place, value and what is allowed."""


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
