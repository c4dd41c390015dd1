"""What a rung of the ladder changed, in words."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any


def change_words(rung: Mapping[str, Any], first: str) -> str:
    """Effects that came and went on a rung: `stribeck`, `magnetic_cogging, without viscous`.

    Args:
        rung: of `ladder --json`: `rung`, `added`, `removed`.
        first: what to call the rung before anything was added.
    """
    if rung["rung"] == 0:
        return first
    removed = " and ".join(rung.get("removed") or ())
    words = [*(rung.get("added") or ()), *([f"without {removed}"] if removed else [])]
    return ", ".join(words) or "[model] edited by hand"
