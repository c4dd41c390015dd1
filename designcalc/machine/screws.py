"""Preload of the machine's screws."""

from __future__ import annotations

from designcalc.bearing.fastener import preload_of_torque
from designcalc.machine.inputs import DesignInputs


def screw_preload(r: DesignInputs, screw: str) -> float:
    """Force of one screw at its torque, N; `screw` is a table of `screws`."""
    return float(preload_of_torque(*(r(f"screws.{screw}.{name}") for name in ("torque", "diameter", "nut_factor"))))
