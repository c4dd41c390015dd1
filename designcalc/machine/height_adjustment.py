"""Wedge of the height adjustment."""

from __future__ import annotations

from designcalc.drive.height_adjustment import WedgeDrive, wedge_drive
from designcalc.machine.inputs import DesignInputs


def wedge(r: DesignInputs) -> WedgeDrive:
    """The set screw that moves height pin 1 under height pin 2."""
    return wedge_drive(r("set_screw.pitch"), r("height_pin_1.slope"), r("height_pin_1.stroke"))
