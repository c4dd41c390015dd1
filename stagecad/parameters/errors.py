"""The error for invalid input of the user."""

from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import contextmanager
from difflib import get_close_matches
from functools import cached_property
from typing import Any

LONGEST = 1200
"""Largest length of a message."""
LONGEST_NAME = 200
"""Longest name that is compared with others to find the nearest."""


def one_line(message: str) -> str:
    """`message` on one line of bounded length, with characters that a terminal would obey or hide as escapes."""
    text = " ".join(line.strip() for line in message.expandtabs(1).splitlines())
    if not text.isprintable():
        text = "".join(c if c.isprintable() else c.encode("unicode_escape").decode() for c in text)
    return text if len(text) <= LONGEST else f"{text[: LONGEST // 2]} ... {text[-LONGEST // 3 :]}"


class InputError(ValueError):
    """Invalid input: the message is one line with place, value and what is allowed."""

    def __init__(self, message: str) -> None:
        super().__init__(one_line(message))


def require(condition: object, message: str) -> None:
    """Refuse input that does not satisfy a condition."""
    if not condition:
        raise InputError(message)


@contextmanager
def at_place(place: str) -> Iterator[None]:
    """Put a place before the message of an error for invalid input that is raised in here."""
    try:
        yield
    except InputError as error:
        raise InputError(f"{place}: {error}") from None


def require_known(name: str, allowed: Iterable[str], message: str) -> None:
    """Refuse a name that is not among those allowed; the message names the nearest of them."""
    if name not in allowed:
        raise InputError(f"{message}{nearest(name, allowed)}")


class ViolationsError(InputError):
    """Several violated rules of one design. `str` is the line of the first, sufficient by itself.

    `explain` computes the violations as JSON documents; those with a change that satisfies the rule have it under
    `satisfied_by`. It takes up to a second, and runs only when the error is shown. In another process it is a plain
    InputError.
    """

    def __init__(self, lines: Sequence[str], explain: Callable[[], list[dict[str, Any]]]) -> None:
        super().__init__(lines[0])
        self.lines = tuple(lines)
        self._explain = explain

    @cached_property
    def documents(self) -> list[dict[str, Any]]:
        """The violations as JSON documents, in the order of the lines."""
        return self._explain()

    def explained(self) -> list[str]:
        """The lines, each with a change that satisfies the rule where one was found."""
        found = []
        for line, document in zip(self.lines, self.documents, strict=True):
            best = next((one for one in document["satisfied_by"] if not one["new_violations"]), None)
            found.append(f"{line}; {best['key']} = {best['value']} satisfies it" if best else line)
        return found

    def __reduce__(self) -> tuple[Any, ...]:
        return InputError, (str(self),)


class PartError(ValueError):
    """A part of a design of which the CAD kernel makes no valid solid, with the kernel's reason."""

    def __init__(self, part: str, design: Any, reason: str) -> None:
        super().__init__(f"part '{part}': {reason}")
        self.part, self.design, self.reason = part, design, reason

    def __reduce__(self) -> tuple[Any, ...]:
        return PartError, (self.part, self.design, self.reason)


class LostProcessError(RuntimeError):
    """A process that ended without a result, twice, while it worked on `item`: as by a segmentation fault, or for lack
    of memory."""

    def __init__(self, message: str, item: Any = None) -> None:
        super().__init__(message)
        self.item = item


def nearest(name: str, allowed: Iterable[str]) -> str:
    """Ending of an error message that names the nearest valid name, or all of them when none is near."""
    names = sorted(allowed)
    # Comparison with a very long text, or of one, takes seconds, and finds nothing.
    short = [one for one in names if len(one) <= LONGEST_NAME]
    close = get_close_matches(name, short, n=1, cutoff=0.6) if len(name) <= LONGEST_NAME else []
    return f"; did you mean '{close[0]}'?" if close else f"; allowed: {', '.join(names)}"
