"""Physical effects, the model composed of them, integrators and the thesis's experiments."""

from sim.effects.catalogue import Model, compose, find, library
from sim.effects.custom import load_all_custom, load_custom
from sim.effects.effect import Axis, Effect, Parameter, Scan, rotary_unit
from sim.integration import drive
from sim.integration.simulate import Simulation, SimulationError, simulate

__all__ = [
    "Axis",
    "Effect",
    "Model",
    "Parameter",
    "Scan",
    "Simulation",
    "SimulationError",
    "compose",
    "drive",
    "find",
    "library",
    "load_all_custom",
    "load_custom",
    "rotary_unit",
    "simulate",
]
