"""The heat of the stacks: temperatures of stacks, tip, holder and base over a duty cycle, and the growth they cause.

A stack loses its heat through its ends (conduction over half its length, and a bonded joint) to tip and holder, and
across the air in its bore to the holder; the holder through the film of air in its pocket to the base, base and tip
to the surroundings. Contact of clamp and stage, and radiation in the bores, are neglected.
"""

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from designcalc.checks.check import DesignInputs, remembered
from designcalc.drive.piezo_stack import stack_heat
from designcalc.drive.thermal_network import ThermalNetwork
from designcalc.friction_stage.physics.loads import tip_mass
from designcalc.friction_stage.physics.tip_dynamics import PIEZOS, driven_capacitance, speed_frequency

Array = NDArray[np.float64]

BODIES = ("stacks", "tip", "holder", "base")


def network(r: DesignInputs) -> ThermalNetwork:
    """The three stacks of an actuator as one body, tip, holder, base."""
    area, length, capacity = r("piezo.element_area"), r("piezo.length"), r("heat.capacity")
    end = 1 / (length / 2 / (r("heat.conductivity") * area) + 1 / (r("heat.joint_conductance") * area))
    air, bore = r("heat.air_conductivity"), (r("holder.bore_diameter") - r("piezo.diameter")) / 2
    inside = r("holder.height") - r("holder.floor")
    across = air * math.pi * r("piezo.diameter") * inside / bore
    diameter, height = r("holder.diameter"), r("holder.height")
    pocket = air * math.pi * diameter * height / ((r("base.pocket_diameter") - diameter) / 2)
    block = r("base.length"), r("base.width"), r("base.height")
    faces = 2 * (block[0] * block[1] + block[0] * block[2] + block[1] * block[2])
    star = r("tip.arm_width") * r("actuator.piezo_spacing") * 2 * math.sqrt(3)
    between = np.zeros((4, 4))
    between[0, 1], between[0, 2], between[2, 3] = PIEZOS * end, PIEZOS * (end + across), pocket
    stacks, tip = PIEZOS * area * length, tip_mass(r) / r.material("tip", "density")
    volumes = np.array([stacks, tip, math.pi / 4 * diameter**2 * height, math.prod(block)])
    outside = r("heat.convection") * np.array([0.0, star, 0.0, faces])
    return ThermalNetwork(capacity * volumes, between + between.T, outside)


@dataclass(frozen=True)
class Warmed:
    """Rise over the surroundings of `BODIES`, K, shape (4,), once all periods are alike."""

    hottest: Array  # as the drive stops
    coolest: Array  # as it begins


@remembered
def warmed(r: DesignInputs) -> Warmed:
    """Full speed for `heat.moving` of each `heat.period`; two stacks move, and heat all three on the mean."""
    voltage, loss = r("piezo.highest_voltage"), r("piezo.loss_factor")
    power = 2 * float(stack_heat(driven_capacitance(r), voltage, speed_frequency(r), loss))
    return Warmed(*network(r).cycle(np.array([power, 0.0, 0.0, 0.0]), r("heat.moving"), r("heat.period")))


@remembered
def growth(r: DesignInputs) -> tuple[float, float]:
    """Rise of the tip's apex by its heat at the end of a move, and the part of it that comes and goes in a period, m.

    The height of stacks, tip and the holder's floor; the base carries ways and holder alike.
    """
    members = [
        r.material("piezo", "expansion") * r("piezo.length"),
        r.material("tip", "expansion") * r("actuator.tip_height"),
        r.material("holder", "expansion") * r("holder.floor"),
        0.0,
    ]
    found = warmed(r)
    return float(members @ found.hottest), float(members @ (found.hottest - found.coolest))
