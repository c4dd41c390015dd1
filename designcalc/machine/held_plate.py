"""The stage at rest as a plate on its pads and on the pressed tip: vibration of the payload normal to the motion.

Modal superposition with masses of 1 kg: a floor that shakes pads and tip moves the payload relative to it by
``sum_m phi_m(payload) Gamma_m r_m^2 H_m``, ``Gamma_m = sum k phi_m/omega_m^2`` over the springs (since a rigid
translation bends nothing), ``r_m = f/f_m``, ``H = 1/(1 - r^2 + 2 i zeta r)``; the tip moves it by its stiffness times
the static compliance and what each mode adds to it, ``phi_m(tip) phi_m(payload) (H_m - 1)/omega_m^2``.

Source: Meirovitch, Fundamentals of Vibrations (2001), chapter 7; mode acceleration for the modes left out.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from designcalc.errors.dynamic_budget import Response, resonant_response
from designcalc.machine.inputs import DesignInputs, remembered
from designcalc.machine.loads import load
from designcalc.machine.pads import pad_positions, pad_spring_stiffness
from designcalc.machine.stage_plate import TIP, modal_damping, payload_place, stage_plate
from designcalc.machine.tip_contact import contact_stiffness
from designcalc.machine.tip_dynamics import PIEZOS, stack_stiffness

Array = NDArray[np.float64]

MODES = 20
"""Of the plate on its springs, up to some 4 kHz."""


@dataclass(frozen=True)
class HeldPlate:
    """Modes of the stage on pads and tip.

    Args:
        frequency: Hz, shape (m,); damping: ratio.
        tip, payload: deflection there of modes of mass 1 kg, kg^-1/2, shape (m,).
        participation: Gamma of a translation of the floor, kg^1/2, shape (m,).
        push: stiffness of stacks and contact of the tip, N/m.
        compliance: static deflection of the payload by a unit force at the tip, m/N.
    """

    frequency: Array
    damping: Array
    tip: Array
    payload: Array
    participation: Array
    push: float
    compliance: float

    def floor_response(self, f: Array) -> Response:
        """Motion of the payload relative to the floor over that of the floor, at frequencies in Hz."""
        shares = self.payload * self.participation
        return self._resonances(f) * (f[:, None] / self.frequency) ** 2 @ shares

    def lift_response(self, f: Array) -> Response:
        """Motion of the payload over that of the free tip."""
        shares = self.tip * self.payload / (2 * np.pi * self.frequency) ** 2
        return self.push * (self.compliance + (self._resonances(f) - 1.0) @ shares)

    def ring_down(self, force: float, limit: float) -> float:
        """Time after which the vibration by a force that leaves the tip at once stays below a limit, s.

        The envelope ``sum_m |phi_m(tip) phi_m(payload)| F/omega_m^2 exp(-zeta_m omega_m t)``: all modes add up.

        Args:
            force: F, N.
            limit: m, > 0.
        """
        rates = 2 * np.pi * self.frequency
        sizes, decays = force * np.abs(self.tip * self.payload) / rates**2, self.damping * rates
        low, high = 0.0, float(np.log(max(sizes.sum() / limit, 1.0)) / decays.min())
        for _ in range(60):
            middle = 0.5 * (low + high)
            low, high = (middle, high) if float(sizes @ np.exp(-decays * middle)) > limit else (low, middle)
        return high

    def _resonances(self, f: Array) -> Response:
        pairs = zip(self.frequency, self.damping, strict=True)
        return np.stack([resonant_response(f, float(first), float(damping)) for first, damping in pairs], axis=-1)


@remembered
def held_plate(r: DesignInputs) -> HeldPlate:
    """Modes of the stage at rest; each is damped by pads and plate in proportion to the energy that they store."""
    push = 1 / (1 / (PIEZOS * stack_stiffness(r)) + 1 / contact_stiffness(r, load(r)).normal)
    plate, pads, at = stage_plate(r, tip=push), pad_positions(r), payload_place(r)[:2]
    modes = plate.modes(MODES, [TIP, at, *pads.tolist()])
    tip, payload, at_pads = modes.shapes[0], modes.shapes[1], modes.shapes[2:]
    stiffness, rates = pad_spring_stiffness(r)[:, None], (2 * np.pi * modes.frequency) ** 2
    damping = modal_damping(r, modes.frequency, at_pads)
    pulled = (stiffness * at_pads).sum(axis=0) + push * tip
    compliance = float(plate.compliance([TIP], [at])[0, 0])
    return HeldPlate(modes.frequency, damping, tip, payload, pulled / rates, push, compliance)
