"""TOML documents of bounded depth, with integers of 64 bits (TOML 1.0.0) and no number that a float cannot hold."""

import tomllib
from typing import Any

from stagecad.parameters.errors import InputError

DEEPEST = 20
"""Largest depth of tables and lists."""
LARGEST = 2**63


def load_toml(text: str, name: str) -> dict[str, Any]:
    """The content of a TOML document; `name` is the file's name in messages."""
    try:
        document = tomllib.loads(text)
    except tomllib.TOMLDecodeError:
        raise
    except RecursionError:
        raise InputError(f"{name}: has tables nested too deeply; at most {DEEPEST} levels are read") from None
    except ValueError:
        # Python converts no integer of more than 4300 digits.
        raise InputError(f"{name}: has a whole number of thousands of digits; at most 64 bits are read") from None
    _check(document, name)
    return document


def _check(document: dict[str, Any], name: str) -> None:
    pending: list[tuple[str, Any, int]] = [("", document, 0)]
    while pending:
        place, value, depth = pending.pop()
        if depth > DEEPEST:
            raise InputError(f"{name}: {place}: is nested too deeply; at most {DEEPEST} levels are read")
        if isinstance(value, dict):
            pending += [(f"{place}.{key}".removeprefix("."), item, depth + 1) for key, item in value.items()]
        elif isinstance(value, list):
            pending += [(place, item, depth + 1) for item in value]
        elif isinstance(value, int) and not -LARGEST <= value < LARGEST:
            raise InputError(f"{name}: {place}: is a whole number of more than 64 bits; write it as 1e30")
