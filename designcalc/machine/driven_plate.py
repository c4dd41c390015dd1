"""The stage on its pads as the pulses of the tip bend and shake it.

The tip carries its mean load N in pulses. Their mean bends the stage as a static force does; their parts F_k at the
multiples k f of the drive's frequency shake it, as the modes answer:
``u(t) = G(0) N + sum_k F_k Re(G(k f) exp(2 pi i k f t))``, ``G(f)`` the static compliance and what each mode adds to
it, ``phi_m(tip) phi_m(place) (H_m - 1)/w_m^2``, ``H = 1/(1 - r^2 + 2 i zeta r)``, ``r = f/f_m``. The pulses are those
against a stage that stays where it is; how its vibration changes them takes the simulation.

Source: Meirovitch, Fundamentals of Vibrations (2001), chapter 7; mode acceleration for the modes left out.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from designcalc.bearing.plate import Modes
from designcalc.contact.pulsed import pulse_harmonics
from designcalc.errors.dynamic_budget import Response, resonant_response
from designcalc.machine.inputs import DesignInputs, remembered
from designcalc.machine.pads import pad_positions
from designcalc.machine.stage_plate import TIP, give_at, modal_damping, payload_feet, payload_place, stage_modes
from designcalc.machine.tip_contact import contact_stiffness
from designcalc.machine.tip_dynamics import PIEZOS, stack_stiffness, usable_ellipse

Array = NDArray[np.float64]

MODES = 40
"""Calculated; for a plate of this size they reach beyond 10 kHz."""
HARMONICS = 3
"""Of the pulses, which the stage hardly follows beyond."""
PHASES = 256
"""Instants of a period at which the vibration is evaluated."""


@remembered
def driven_modes(r: DesignInputs) -> Modes:
    """Modes of the stage on its pads: at the tip, the payload's feet, its corner, and the pads."""
    places = [TIP, *payload_feet(r), payload_place(r)[:2], *pad_positions(r).tolist()]
    return stage_modes(r, MODES, places)


@dataclass(frozen=True)
class Shaken:
    """Displacement of places on the stage by a tip that presses in pulses.

    Args:
        static: by the mean of the force, m, shape (n,).
        parts: amplitudes at the multiples of the drive's frequency, m, the phase from the peak of the force, shape
            (harmonics, n).
    """

    static: Array
    parts: Response

    @property
    def vibration(self) -> Array:
        """Peak of the vibration about the mean, m, shape (n,)."""
        turns = np.exp(2j * np.pi * np.outer(np.arange(PHASES) / PHASES, np.arange(1, len(self.parts) + 1)))
        return np.abs((turns @ self.parts).real).max(axis=0)

    @property
    def at_peak_force(self) -> Array:
        """Displacement at the instant of the largest force, m, shape (n,)."""
        return self.static + self.parts.real.sum(axis=0)


def compliance(r: DesignInputs, frequency: float) -> Response:
    """G at a frequency, m/N: at the tip, the payload's feet and its corner, shape (places,)."""
    modes, pads = driven_modes(r), len(pad_positions(r))
    shapes, at_pads = modes.shapes[:-pads], modes.shapes[-pads:]
    damping = modal_damping(r, modes.frequency, at_pads)
    answers = [
        resonant_response(np.array([frequency]), float(first), float(zeta))[0] - 1
        for first, zeta in zip(modes.frequency, damping, strict=True)
    ]
    shares = shapes * shapes[0] / (2 * np.pi * modes.frequency) ** 2
    return _static(r) + shares @ np.array(answers)


def _static(r: DesignInputs) -> Array:
    places: ArrayLike = [TIP, *payload_feet(r), payload_place(r)[:2]]
    return give_at(r, places)


@remembered
def _shaken(r: DesignInputs, mean: float) -> Shaken:
    rate = contact_stiffness(r, mean).rate
    forces = pulse_harmonics(mean, usable_ellipse(r)[1], rate, PIEZOS * stack_stiffness(r), HARMONICS)
    drive = r("actuator.frequency")
    parts = np.array([force * compliance(r, (k + 1) * drive) for k, force in enumerate(forces)])
    return Shaken(_static(r) * mean, parts)


def above_tip(r: DesignInputs, mean: float) -> Shaken:
    """The drive surface above the tip, shape (1,); `mean` of the tip's force, N."""
    found = _shaken(r, mean)
    return Shaken(found.static[:1], found.parts[:, :1])


def at_feet(r: DesignInputs, mean: float) -> Shaken:
    """The feet of the payload, shape (feet,)."""
    found = _shaken(r, mean)
    return Shaken(found.static[1:-1], found.parts[:, 1:-1])


def at_payload(r: DesignInputs, mean: float) -> Shaken:
    """The corner of the payload's pattern of holes, shape (1,)."""
    found = _shaken(r, mean)
    return Shaken(found.static[-1:], found.parts[:, -1:])
