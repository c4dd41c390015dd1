"""Physical effects, the model composed of them, integrators and the thesis's experiments."""

from sim.integration import drive
from sim.integration.simulate import Simulation, SimulationError, simulate
from sim.library.catalogue import find, library
from sim.library.custom import load_all_custom, load_custom
from sim.library.effect import Axis, Effect, Parameter, Scan, rotary_unit
from sim.library.model import Model, compose

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
