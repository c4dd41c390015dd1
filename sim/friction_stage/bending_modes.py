"""Bending modes of the simulated stage, from its plate."""

import numpy as np

from designcalc.checks.check import DesignInputs
from designcalc.friction_stage.physics.stage_plate import bending_modes
from sim.stage.machine import Bending

BENDING_MODES = 40
"""Natural ones of the plate, up to some 15 kHz; residual modes complete them. Speeds with 40 and with 60 agree within
half a percent (docs/convergence.md)."""

HIGHEST_MODE = 24e3
"""Hz: modes above have their stiffness alone, with the mass that brings them down to it, as the step of the simulation
would have to be shorter. The static deflection remains exact, and an impact of 0.1 ms hardly excites them."""


def bending(r: DesignInputs, count: int, added: float | None = None) -> Bending:
    """The `count` lowest modes of the plate, with a mass `added` in its middle, kg."""
    modes = bending_modes(r, count, added)
    frequency = np.minimum(modes.frequency, HIGHEST_MODE)
    # Of unit modal mass: the deflection phi^2/omega^2 under a static force is kept.
    shapes = modes.shapes * (frequency / modes.frequency)
    return Bending(
        frequency,
        r("stage.damping_ratio"),
        np.ascontiguousarray(np.moveaxis(shapes, 2, 0)),
        -0.5 * np.array([r("stage.length"), r("stage.width")]),
    )
