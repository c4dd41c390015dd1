"""A feature of a simulation as text for a person."""

from __future__ import annotations

from typing import Any


def feature_text(feature: dict[str, Any] | None) -> str:
    """A quantity in the unit that suits its size; a dash where there is none."""
    if feature is None:
        return "-"
    value, unit = feature["value"], feature["unit"]
    if unit == "m" and abs(value) < 1e-7:
        return f"{value * 1e9:.3f} nm"
    if unit == "m" and abs(value) < 1e-3:
        return f"{value * 1e6:.3f} um"
    if unit == "1":
        return f"{value:.4f}"
    return f"{value:.4f} {unit}" if abs(value) >= 1e-3 or value == 0.0 else f"{value:.3e} {unit}"
