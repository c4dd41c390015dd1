"""What the simulations take from the design: friction values, the tip's dimensions, the moving mass."""

from __future__ import annotations

import dataclasses

from sim.experiments.friction_models import Friction
from stagecad.parameters.errors import InputError
from workbench.options import Run


def tip_dimensions(run: Run) -> tuple[float, float]:
    """Piezo spacing D and tip height h of the design, m."""
    actuator = run.design.actuator
    return actuator.piezo_spacing * 1e-3, actuator.tip_height * 1e-3


def friction_of(run: Run) -> Friction:
    """The design's table `friction` (the thesis's Table 3 unless set otherwise), SI."""
    table = run.design.friction
    return Friction(**{field.name: getattr(table, field.name) for field in dataclasses.fields(Friction)})


def moving_mass(run: Run, given: str | None) -> float:
    """Mass of the body in the friction experiments, kg.

    Args:
        run: the command's run.
        given: None for `friction.mass` (the thesis's 1 kg), `design` for the design's moving body, or a quantity.
    """
    if given is None:
        return run.design.friction.mass
    return design_mass(run) if given == "design" else mass_given(given)


def mass_given(text: str) -> float:
    """Mass written as a quantity, kg.

    Raises:
        InputError: no mass, or none above zero.
    """
    from stagecad.parameters.units import parse_quantity

    mass = parse_quantity(text, "kg", "--mass")
    if not 0.0 < mass < float("inf"):
        raise InputError(f"--mass {text}: must be positive and finite")
    return mass


def design_mass(run: Run) -> float:
    """Mass of the design's moving body (stage, irons, magnets), kg, from the cached solids; made when missing."""
    from workbench.machine.machine import made_machine

    return made_machine(run).moving_body.mass
