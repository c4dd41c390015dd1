"""Physical effects, the model composed of them, integrators and the thesis's experiments."""

from sim import drive
from sim.custom import load_all_custom, load_custom
from sim.effect import Axis, Effect, Parameter, Scan, rotary_unit
from sim.library import find, library
from sim.model import Model, compose
from sim.simulation import Simulation, SimulationError, simulate

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
