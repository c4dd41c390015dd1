"""Feedforward of fine motion by the lean of the pressed tip.

The lean for a wanted motion x balances the pads: lean = g (x + F(x)/k), k of tip and contact in series, F of the pads'
presliding elements, 1/g the gain of the stacks. Their hysteresis is inverted: the voltage whose play operators give
the stretch (Kuhnen, European J. Control 9 (2003) 407).
"""

import math

import numpy as np

from sim.numerics.elasto_plastic import elements_along, force_along
from sim.stage.constants import make_constants, piezo_response
from sim.stage.machine import Piezo, StageMachine
from sim.stage.slip_elements import KNOTS, parabola
from sim.stage.state import Constants
from sim.stage.statics import Rest

FEEDFORWARD: tuple[str, ...] = ("none", "gain", "inverse", "friction", "hysteresis")
"""Feedforward of the lean: none; by the static gain; with the inverse of the stacks' hysteresis; with the pads'
friction; with both."""


def static_stiffnesses(constants: Constants, rest: Rest) -> tuple[float, float]:
    """Stiffnesses along the travel of tip and contact in series, and of the pads against them, N/m.

        1/k = 1/k_contact + h^2/k_tilt + 1/k_sway

    k_tilt = (stiffness of a piezo) sum p_x^2, k_sway that of the bending stacks, k_contact = (tangential ratio) (normal
    stiffness at the load), k_pads = sum of (pad load) (bristle stiffness per load).
    """
    depth = (float(rest.tip_loads.sum()) / constants.contact.rate) ** (2.0 / 3.0)
    contact = constants.contact.tangential_ratio * 1.5 * constants.contact.rate * math.sqrt(depth)
    tilt = constants.tip.stiffness * float(np.sum(constants.tip.piezo_places[:, 0] ** 2)) / constants.tip.height**2
    sway = 1.0 / constants.tip.sway_stiffness if constants.tip.sway_stiffness > 0.0 else 0.0
    return 1.0 / (1.0 / contact + 1.0 / tilt + sway), constants.pad_bristle * float(rest.pad_loads.sum())


def inverse_hysteresis(piezo: Piezo, stretch: np.ndarray) -> np.ndarray:
    """Voltages about the bias (n,) that give stretches (n,), m, in turn, from rest at the bias."""
    response = piezo_response(piezo)
    play, out = np.zeros(response.thresholds.size), np.empty(stretch.size)
    for n, wanted in enumerate(stretch / response.gain):
        low, high = -0.5 * piezo.highest_voltage, 0.5 * piezo.highest_voltage
        for _ in range(40):
            # The sum of the operators rises with the voltage.
            volts = 0.5 * (low + high)
            moved = np.clip(play, volts - response.thresholds, volts + response.thresholds)
            short = volts + response.strength * float(response.weights @ (moved - volts)) < wanted
            low, high = (volts, high) if short else (low, volts)
        play, out[n] = moved, volts
    return out


def feedforward(machine: StageMachine, rest: Rest, kind: str, wanted: np.ndarray) -> np.ndarray:
    """Lean (n,) to command for a wanted motion (n,), m, from rest; `kind`: one of `FEEDFORWARD`."""
    if kind == "none":
        return np.zeros_like(wanted)
    series, pads = static_stiffnesses(make_constants(machine, rest), rest)
    mean = machine.piezo.stroke / machine.piezo.highest_voltage
    friction = pads * wanted
    if kind in ("friction", "hysteresis"):
        limit = machine.pads.static_friction * float(rest.pad_loads.sum())
        elements = elements_along(KNOTS * machine.pads.presliding, parabola(KNOTS), limit)
        # A first row at rest leaves the elements without force.
        friction = force_along(np.append([0.0, 0.0], wanted), np.full(wanted.size + 2, limit), elements)[2:]
    lean = wanted + friction / series
    if kind in ("gain", "friction"):
        return lean * mean / piezo_response(machine.piezo).small_signal_gain
    lever = float(machine.tip.piezo_places[1, 0]) / machine.tip.height
    return inverse_hysteresis(machine.piezo, lean * lever) * mean / lever
