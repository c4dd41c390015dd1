"""Vibration of the stage as a plate: at rest on pads and pressed tip, and on its pads under the pulses of the tip.

At rest, by modal superposition with masses of 1 kg: vibration of the floor under pads and tip moves the payload
relative to it by ``sum_m phi_m(payload) Gamma_m r_m^2 H_m``, ``Gamma_m = sum k phi_m/omega_m^2`` over the springs
(since a rigid translation bends nothing), ``r_m = f/f_m``, ``H = 1/(1 - r^2 + 2 i zeta r)``; the tip moves it by its
stiffness times the static compliance plus the contribution of each mode,
``phi_m(tip) phi_m(payload) (H_m - 1)/omega_m^2``.

Driven: the tip carries its mean load N in pulses. Their mean bends the stage as a static force does; their parts F_k
at the multiples k f of the drive's frequency excite it: ``u(t) = G(0) N + sum_k F_k Re(G(k f) exp(2 pi i k f t))``,
with the static compliance and the contribution of each mode in G. The pulses are those against a stage at rest; only
the simulation computes how its vibration changes them.

Source: Meirovitch, Fundamentals of Vibrations (2001), chapter 7; mode acceleration for the modes left out.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from designcalc.bearing.plate import Modes
from designcalc.checks.check import DesignInputs, remembered
from designcalc.contact.pulsed import pulse_harmonics
from designcalc.errors.dynamic_budget import Response, resonant_response
from designcalc.friction_stage.physics.loads import load
from designcalc.friction_stage.physics.pads import pad_positions, pad_spring_stiffness
from designcalc.friction_stage.physics.stage_plate import (
    TIP,
    give_at,
    modal_damping,
    payload_feet,
    payload_places,
    stage_modes,
    stage_plate,
)
from designcalc.friction_stage.physics.tip_dynamics import PIEZOS, contact_stiffness, stack_stiffness, usable_ellipse

Array = NDArray[np.float64]

MODES = 20
"""Number of modes of the plate on its springs, up to some 4 kHz."""


@dataclass(frozen=True)
class HeldPlate:
    """Modes of the stage on pads and tip."""

    frequency: Array  # Hz, shape (m,)
    damping: Array  # ratio
    tip: Array  # deflection there of modes of mass 1 kg, kg^-1/2, shape (m,)
    payload: Array  # the same at the places of the payload, shape (places, m)
    participation: Array  # Gamma of a translation of the floor, kg^1/2, shape (m,)
    push: float  # stiffness of stacks and contact of the tip, N/m
    compliance: Array  # static deflection of the places by a unit force at the tip, m/N, shape (places,)

    def responses(self, f: Array) -> tuple[Response, Response]:
        """At frequencies in Hz, shape (n,): motion of the places relative to the floor over that of the floor, and
        motion of the places over that of the free tip, each of shape (n, places)."""
        resonances = resonant_response(f[:, None], self.frequency, self.damping)
        floor = resonances * (f[:, None] / self.frequency) ** 2 @ (self.payload * self.participation).T
        shares = self.tip * self.payload / (2 * np.pi * self.frequency) ** 2
        return floor, self.push * (self.compliance + (resonances - 1.0) @ shares.T)

    def ring_down(self, force: float, limit: float) -> float:
        """Time (s) after which the vibration by a force (N) that leaves the tip is below a limit (m) everywhere.

        The envelope ``sum_m |phi_m(tip) phi_m(payload)| F/omega_m^2 exp(-zeta_m omega_m t)``: all modes add up.
        """
        rates = 2 * np.pi * self.frequency
        sizes, decays = force * np.abs(self.tip * self.payload) / rates**2, self.damping * rates
        low, high = 0.0, float(np.log(max(sizes.sum(axis=1).max() / limit, 1.0)) / decays.min())
        for _ in range(60):
            middle = 0.5 * (low + high)
            low, high = (middle, high) if float((sizes @ np.exp(-decays * middle)).max()) > limit else (low, middle)
        return high


@remembered
def held_plate(r: DesignInputs) -> HeldPlate:
    """Modes of the stage at rest; each is damped by pads and plate in proportion to the energy that they store."""
    push = 1 / (1 / (PIEZOS * stack_stiffness(r)) + 1 / contact_stiffness(r, load(r)).normal)
    plate, pads, places = stage_plate(r, tip=push), pad_positions(r), payload_places(r)
    modes = plate.modes(MODES, [TIP, *places, *pads.tolist()])
    tip, payload, at_pads = modes.shapes[0], modes.shapes[1 : 1 + len(places)], modes.shapes[1 + len(places) :]
    stiffness, rates = pad_spring_stiffness(r)[:, None], (2 * np.pi * modes.frequency) ** 2
    damping = modal_damping(r, modes.frequency, at_pads)
    pulled = (stiffness * at_pads).sum(axis=0) + push * tip
    compliance = plate.compliance([TIP], places)[:, 0]
    return HeldPlate(modes.frequency, damping, tip, payload, pulled / rates, push, compliance)


DRIVEN_MODES = 40
"""Number of modes of the plate on its pads; for a plate of this size they reach beyond 10 kHz."""
HARMONICS = 3
"""Number of harmonics of the pulses; the stage hardly follows higher ones."""
PHASES = 256
"""Instants of a period at which the vibration is evaluated."""


@remembered
def driven_modes(r: DesignInputs) -> Modes:
    """Modes of the stage on its pads: at the tip, the places of the payload, and the pads."""
    places = [TIP, *payload_places(r), *pad_positions(r).tolist()]
    return stage_modes(r, DRIVEN_MODES, places)


@dataclass(frozen=True)
class Shaken:
    """Displacement of places on the stage by a tip that presses in pulses."""

    static: Array  # by the mean of the force, m, shape (n,)
    # amplitudes at the multiples of the drive's frequency, m, the phase from the peak of the force, shape (harmonics,
    # n)
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
    """G at a frequency, m/N: at the tip and the places of the payload, shape (1 + places,)."""
    modes, pads = driven_modes(r), len(pad_positions(r))
    shapes, at_pads = modes.shapes[:-pads], modes.shapes[-pads:]
    damping = modal_damping(r, modes.frequency, at_pads)
    answers = resonant_response(np.array(frequency), modes.frequency, damping) - 1
    shares = shapes * shapes[0] / (2 * np.pi * modes.frequency) ** 2
    return _static(r) + shares @ answers


def _static(r: DesignInputs) -> Array:
    places: ArrayLike = [TIP, *payload_places(r)]
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
    found, feet = _shaken(r, mean), len(payload_feet(r))
    return Shaken(found.static[-feet:], found.parts[:, -feet:])


def at_payload(r: DesignInputs, mean: float) -> Shaken:
    """The feet of the payload and the corners of its pattern of holes, as `payload_places`, shape (places,)."""
    found = _shaken(r, mean)
    return Shaken(found.static[1:], found.parts[:, 1:])
