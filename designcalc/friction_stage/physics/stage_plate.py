"""The stage as a plate that bends on its pads: compliance, sag and natural modes.

The plate is the plain one, its density such that it has the mass of the stage with irons and magnets; pockets and ribs
of the payload's holes neither weaken nor stiffen it. Each pad is a spring at its own load. The payload stands on four
feet, two pitches of its holes apart, as one rigid body; a ballast is a point in the middle.

Vibration of the stage as a plate: at rest on pads and pressed tip, and on its pads under the pulses of the tip.

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

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from designcalc.bearing.plate import Modes, Place, Plate, StandingBody, SupportedPlate
from designcalc.checks.check import DesignInputs, remembered
from designcalc.contact.pulsed import pulse_harmonics
from designcalc.errors.dynamic_budget import Response, resonant_response
from designcalc.friction_stage.physics.loads import ballast, bare_stage, gravity, load, preload
from designcalc.friction_stage.physics.pads import pad_positions, pad_spring_stiffness
from designcalc.friction_stage.physics.tip_dynamics import PIEZOS, contact_stiffness, stack_stiffness, usable_ellipse

Array = NDArray[np.float64]

TIP: Place = (0.0, 0.0)
"""Point at which the tip acts with the stage in the middle of its travel, m."""


def payload_feet(r: DesignInputs) -> list[Place]:
    """Places of the payload's feet, m."""
    half = r("stage.payload_pitch")
    return [(x, y) for x in (-half, half) for y in (-half, half)]


def payload_places(r: DesignInputs) -> list[Place]:
    """Places at which an error may reach the payload, m: its feet, and the corners of its pattern of holes, the corner
    at positive x and y first."""
    pitch = r("stage.payload_pitch")
    along, across = (r("stage.payload_columns") - 1) / 2 * pitch, (r("stage.payload_rows") - 1) / 2 * pitch
    return [*((x, y) for x in (along, -along) for y in (across, -across)), *payload_feet(r)]


def payload_height(r: DesignInputs) -> float:
    """Height of the payload's centre over the stage's middle plane, m."""
    return r("stage.thickness") / 2 + r("payload.height")


@remembered
def stage_plate(
    r: DesignInputs, supported: bool = True, tip: float = 0.0, added: float | None = None
) -> SupportedPlate:
    """The stage on its pads, or free; with `tip`, on a tip of that stiffness as well, N/m. `added` is a mass in the
    middle, kg, by default that of the ballast."""
    length, width, thickness = r("stage.length"), r("stage.width"), r("stage.thickness")
    density = bare_stage(r).mass / (length * width * thickness)
    modulus, poisson = r.material("stage", "youngs_modulus"), r.material("stage", "poisson_ratio")
    pads = zip(pad_positions(r).tolist(), pad_spring_stiffness(r).tolist(), strict=True)
    springs = [((x, y), k) for (x, y), k in pads] + ([(TIP, tip)] if tip > 0 else [])
    carried = r("payload.mass")
    bodies = (StandingBody(tuple(payload_feet(r)), carried, payload_height(r)),) if carried > 0 else ()
    extra = ballast(r) if added is None else added
    plate, masses = Plate(length, width, thickness, modulus, poisson, density), [(TIP, extra)] if extra > 0 else []
    return SupportedPlate(plate, springs if supported else (), masses, bodies)


@remembered
def give_at_tip(r: DesignInputs) -> float:
    """Deflection of the drive surface above the tip by a unit force of the tip, bending and pads together, m/N."""
    return float(stage_plate(r).compliance([TIP])[0, 0])


def give_of_pads_at_tip(r: DesignInputs) -> float:
    """Compliance above the tip of a rigid stage on its pads, m/N."""
    rows = np.column_stack([np.ones(len(pad_positions(r))), pad_positions(r)])
    at = np.array([1.0, *TIP])
    return float(at @ np.linalg.solve(rows.T @ (pad_spring_stiffness(r)[:, None] * rows), at))


def modal_damping(r: DesignInputs, frequency: Array, at_pads: Array) -> Array:
    """Damping ratio of modes of mass 1 kg and frequency (modes,), Hz: of pads, where they deflect by `at_pads` (pads,
    modes), kg^-1/2, and plate in proportion to the energy they store."""
    stored = (pad_spring_stiffness(r)[:, None] * at_pads**2).sum(axis=0) / (2 * np.pi * frequency) ** 2
    return stored * r("bearing.damping_ratio") + (1 - stored) * r("stage.damping_ratio")


RIGID_MODES = 3
"""Number of rigid modes of a free plate: heave, roll, pitch."""


TIP_PLACES = 5
"""Along the travel, at which the deflection under the tip is exact."""


def bending_modes(r: DesignInputs, count: int, added: float | None = None) -> Modes:
    """The lowest bending modes of the stage without pads, on a grid over the plate: (nodes along y, along x, modes).
    `added` as of `stage_plate`.

    Residual modes of the pads and of a tip along the travel complete them. With the motion of the rigid body they are
    the basis of a free body, on which pads and tips act as forces at points.
    """
    reach = r("stage.travel") / 2
    tips = [(x, 0.0) for x in np.linspace(-reach, reach, TIP_PLACES)]
    plate = stage_plate(r, supported=False, added=added)
    modes = plate.modes_on_grid(RIGID_MODES + count, [*tips, *pad_positions(r).tolist()])
    return Modes(modes.frequency[RIGID_MODES:], modes.shapes[:, :, RIGID_MODES:])


def sag(r: DesignInputs, places: ArrayLike) -> Array:
    """Deflection by weight, payload and the pull of the magnets, pads included, downwards, m, shape (n,)."""
    plate = stage_plate(r)
    found = plate.sag(gravity(r), places)
    if r.design.teeth.fitted:
        across = r("teeth.bar_spacing") / 2
        irons = [(0.0, across), (0.0, -across)]
        found = found + plate.compliance(irons, places) @ np.full(2, preload(r) / 2)
    return found


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
    return stage_plate(r).modes(DRIVEN_MODES, places)


@dataclass(frozen=True)
class Shaken:
    """Displacement of places on the stage by a tip that presses in pulses."""

    static: Array  # by the mean of the force, m, shape (n,)
    # amplitudes at the multiples of the drive's frequency, m, the phase from the peak of the force, shape (harmonics,
    # n)
    parts: Response

    def at(self, places: slice) -> Shaken:
        """Some of the places."""
        return Shaken(self.static[places], self.parts[:, places])

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
    return stage_plate(r).compliance([TIP], places)[:, 0]


@remembered
def _shaken(r: DesignInputs, mean: float) -> Shaken:
    rate = contact_stiffness(r, mean).rate
    forces = pulse_harmonics(mean, usable_ellipse(r)[1], rate, PIEZOS * stack_stiffness(r), HARMONICS)
    drive = r("actuator.frequency")
    parts = np.array([force * compliance(r, (k + 1) * drive) for k, force in enumerate(forces)])
    return Shaken(_static(r) * mean, parts)


def above_tip(r: DesignInputs, mean: float) -> Shaken:
    """The drive surface above the tip, shape (1,); `mean` of the tip's force, N."""
    return _shaken(r, mean).at(slice(1))


def at_feet(r: DesignInputs, mean: float) -> Shaken:
    """The feet of the payload, shape (feet,)."""
    return _shaken(r, mean).at(slice(-len(payload_feet(r)), None))


def at_payload(r: DesignInputs, mean: float) -> Shaken:
    """The feet of the payload and the corners of its pattern of holes, as `payload_places`, shape (places,)."""
    return _shaken(r, mean).at(slice(1, None))
