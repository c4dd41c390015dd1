"""The drive acts on its command only after a delay."""

from dataclasses import replace

from sim.effects.effect import TransportDelay
from sim.effects.sensor import sensor_delay

_OF_CURVES = replace(
    sensor_delay.EFFECT.variants[0],
    name="drive_delay:of_curves",
    meaning="the drive acts after a delay on a command that is smooth between rows",
    acts_on="drive",
)

EFFECT = replace(
    sensor_delay.EFFECT,
    name="drive_delay",
    meaning="the drive acts on its command only after a delay",
    acts_on="drive",
    time_domain=lambda p: TransportDelay(p.delay),
    variants=(_OF_CURVES,),
)
