"""Code of the user's own: whatever ends it, `sys.exit` too, is an error in one line and no success."""

import os
import sys
import traceback
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from stagecad.parameters.errors import InputError


class OwnCodeError(InputError):
    """An error in a Python file of the user's own."""


@contextmanager
def own_code(path: Path) -> Iterator[None]:
    """Run code of a file of the user's own.

    Raises:
        OwnCodeError: file, line and error, of any class. Ctrl-C and an `InputError` pass as they are.
    """
    process, leave = os.getpid(), os._exit

    # A process that the code has forked ends as it should.
    os._exit = lambda status: sys.exit(status) if os.getpid() == process else leave(status)
    try:
        yield
    except (InputError, KeyboardInterrupt):
        raise
    except BaseException as error:
        line = line_of(path, error)
        raise OwnCodeError(f"{path}: {f'line {line}: ' if line else ''}{told(error)}") from None
    finally:
        os._exit = leave


def line_of(path: Path, error: BaseException) -> int | None:
    """Line of the file in which an error occurred; None if it did not occur in it."""
    if isinstance(error, SyntaxError):
        return error.lineno
    lines = [frame.lineno for frame in traceback.extract_tb(error.__traceback__) if frame.filename == str(path)]
    return lines[-1] if lines else None


def told(error: BaseException) -> str:
    """Class and message of an error in one line."""
    text = " ".join(str(error).split())
    return f"{type(error).__name__}: {text}" if text else type(error).__name__
