"""Screws of the machine: their preload, and the wedge of the height adjustment that the set screw moves."""

from __future__ import annotations

from designcalc.bearing.fastener import preload_of_torque
from designcalc.checks.inputs import DesignInputs
from designcalc.drive.height_adjustment import WedgeDrive, wedge_drive


def screw_preload(r: DesignInputs, screw: str) -> float:
    """Force of one screw at its torque, N; `screw` is a table of `screws`."""
    return float(preload_of_torque(*(r(f"screws.{screw}.{name}") for name in ("torque", "diameter", "nut_factor"))))


def wedge(r: DesignInputs) -> WedgeDrive:
    """The set screw that moves height pin 1 under height pin 2."""
    return wedge_drive(r("set_screw.pitch"), r("height_pin_1.slope"), r("height_pin_1.stroke"))
