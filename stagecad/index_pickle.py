"""Pickles in which some objects, which both sides have, stand by their index."""

from __future__ import annotations

import io
import pickle
from collections.abc import Sequence
from typing import Any


class IndexPickler(pickle.Pickler):
    """Writes the index of an object in `identical` instead of the object."""

    def __init__(self, file: io.BytesIO, identical: Sequence[object]) -> None:
        super().__init__(file, pickle.HIGHEST_PROTOCOL)
        self._places = {id(one): place for place, one in enumerate(identical)}

    def persistent_id(self, obj: Any) -> int | None:
        return self._places.get(id(obj))


class IndexUnpickler(pickle.Unpickler):
    """Reads the output of `IndexPickler`."""

    def __init__(self, file: io.BytesIO, identical: Sequence[object]) -> None:
        super().__init__(file)
        self._identical = identical

    def persistent_load(self, pid: int) -> object:
        return self._identical[pid]
