"""The drive acts on its command only after a delay."""

from __future__ import annotations

from dataclasses import replace

from sim.effects import sensor_delay
from sim.in_time import DriveDelay

EFFECT = replace(
    sensor_delay.EFFECT,
    name="drive_delay",
    meaning="the drive acts on its command only after a delay",
    acts_on="drive",
    in_time=lambda p: DriveDelay(p.delay),
)
