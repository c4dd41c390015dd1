"""Tables of reference values and of cases: the TOML files of this folder."""

import tomllib
from pathlib import Path
from typing import Any


def reference(name: str) -> dict[str, Any]:
    return tomllib.loads((Path(__file__).parent / f"{name}.toml").read_text("utf-8"))


def cases(name: str, key: str) -> list[Any]:
    """The rows of one table of a file, each a tuple; values alone stay as they are."""
    return [tuple(row) if isinstance(row, list) else row for row in reference(name)[key]]
