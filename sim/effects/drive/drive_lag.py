"""The drive follows its command with a first-order lag."""

from dataclasses import replace

from sim.effects.effect import FirstOrderLag
from sim.effects.sensor import sensor_lag

_SENSOR, _SENSOR_OF_STEPS = sensor_lag.EFFECT, sensor_lag.EFFECT.variants[0]
_TIME_CONSTANT = replace(_SENSOR.parameters[0], source="amplifier or piezo charging lag")

_OF_STEPS = replace(
    _SENSOR_OF_STEPS,
    name="drive_lag:of_steps",
    meaning="the drive follows, with a first-order lag, a command that is held from row to row",
    equation="as drive_lag; u is held, and changes to a row's value the part `early` of a step before that row",
    acts_on="drive",
    parameters=(_TIME_CONSTANT, *_SENSOR_OF_STEPS.parameters[1:]),
)

EFFECT = replace(
    _SENSOR,
    name="drive_lag",
    meaning="the drive follows its command with a first-order lag",
    acts_on="drive",
    parameters=(_TIME_CONSTANT,),
    time_domain=lambda p: FirstOrderLag(p.time_constant),
    variants=(_OF_STEPS,),
)
