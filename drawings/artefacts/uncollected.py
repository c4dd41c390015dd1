"""Work that is done without Python's search for reference cycles.

Drawing makes many small objects that live until the sheet is written, and hardly a cycle. Looking through all of them
again and again, and through the modules that are loaded, takes a seventh of the time, and finds nothing.
"""

from __future__ import annotations

import gc
from collections.abc import Iterator
from contextlib import contextmanager


@contextmanager
def uncollected() -> Iterator[None]:
    """No search for reference cycles within; after it as before."""
    before = gc.isenabled()
    gc.disable()
    try:
        yield
    finally:
        if before:
            gc.enable()
