"""How an operation tells what it is doing: steps to a callback, remarks to the log `stagecad`."""

from __future__ import annotations

import logging
from collections.abc import Callable
from itertools import count

from stagecad.parameters.errors import one_line

ProgressCallback = Callable[[str, int, int], None]
"""Called with the name of a step, the steps done, and all steps (0: not known)."""


def silent(step: str, done: int, steps: int) -> None:
    """The progress callback that shows nothing."""


def remark(text: str) -> None:
    """Log a remark of one line; it may quote a file. Without any logging set up, it goes to standard error."""
    logging.getLogger("stagecad").warning("%s", one_line(text))


def counted(progress: ProgressCallback, step: str, steps: int) -> Callable[[object], None]:
    """What reports one step more each time it is called; an empty `step` is the name that it is called with."""
    done = count(1)

    def advance(item: object) -> None:
        progress(step or str(item), next(done), steps)

    return advance
