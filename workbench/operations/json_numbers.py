"""Numbers of JSON documents, in files and on their way to the page: not rounded, null where one is not finite."""

import json
import math
from typing import Any


def finite(value: Any) -> Any:
    """`value` with numbers that JSON cannot hold (infinite, not a number) as null, and numpy scalars as plain ones."""
    if isinstance(value, dict):
        return {str(key): finite(item) for key, item in value.items()}
    if isinstance(value, list | tuple):
        return [finite(item) for item in value]
    if hasattr(value, "tolist"):
        return finite(value.tolist())
    if isinstance(value, float) and not math.isfinite(value):
        return None
    return value


def json_text(value: Any, indent: int | None = None, ensure_ascii: bool = True) -> str:
    """A document as JSON, its numbers by `finite`."""
    return json.dumps(finite(value), indent=indent, ensure_ascii=ensure_ascii, allow_nan=False)
