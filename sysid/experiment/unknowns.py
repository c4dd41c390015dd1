"""The unknowns of a fit: key, starting value, bounds, typical size and prior of each fitted value."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Prior:
    """Prior knowledge of a value before the fit: its value and standard deviation."""

    value: float
    std: float


@dataclass(frozen=True)
class Unknown:
    """One unknown of a fit: key, start, bounds, typical size, and prior."""

    key: str
    start: float
    low: float
    high: float
    size: float
    prior: Prior | None = None
