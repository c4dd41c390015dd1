"""What `"design"` stands for in an experiment: numbers of the rig taken from the parameter file."""

from __future__ import annotations

from collections.abc import Callable

from stagecad.parameters.errors import InputError
from workbench.options import Run
from workbench.simulation_inputs import design_mass, tip_dimensions

NAMES = ("mass", "piezo_spacing", "tip_height")


def design_values(run: Run) -> Callable[[str], float]:
    """A function that gives the SI value of a known quantity from the design, asked only for what a file names."""

    def value(name: str) -> float:
        if name == "mass":
            return design_mass(run)
        if name == "piezo_spacing":
            return tip_dimensions(run)[0]
        if name == "tip_height":
            return tip_dimensions(run)[1]
        raise InputError(f"rig.known.{name} = 'design': the design has no such number; allowed: {', '.join(NAMES)}")

    return value
