"""Physical effects, the model composed of them, integrators and the thesis's experiments."""

from sim.custom import load_all_custom, load_custom
from sim.effect import Axis, Effect, Parameter, Scan, rotary_unit
from sim.library import find, library

__all__ = ["Axis", "Effect", "Parameter", "Scan", "find", "library", "load_all_custom", "load_custom", "rotary_unit"]
