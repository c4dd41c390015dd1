"""The stage as a plate that bends on its pads: compliance, sag and natural modes.

The plate is the plain one, its density such that it has the mass of the stage with irons and magnets; pockets and ribs
of the payload's holes neither weaken nor stiffen it. Each pad is a spring at its own load. The payload stands on four
feet, two pitches of its holes apart, as one rigid body; a ballast is a point in the middle.
"""

from functools import lru_cache

import numpy as np
from numpy.typing import ArrayLike, NDArray

from designcalc.bearing.plate import Modes, Place, Plate, StandingBody, SupportedPlate
from designcalc.checks.check import DesignInputs, remembered
from designcalc.friction_stage.physics.body import ballast, bare_stage
from designcalc.friction_stage.physics.loads import gravity, preload
from designcalc.friction_stage.physics.pads import pad_positions, pad_spring_stiffness

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
    springs = [(x, y, k) for (x, y), k in zip(pad_positions(r).tolist(), pad_spring_stiffness(r).tolist(), strict=True)]
    springs += [(*TIP, tip)] if tip > 0 else []
    carried = r("payload.mass")
    bodies = (StandingBody(tuple(payload_feet(r)), carried, payload_height(r)),) if carried > 0 else ()
    extra = ballast(r) if added is None else added
    return _supported(
        Plate(length, width, thickness, modulus, poisson, density),
        tuple(((x, y), k) for x, y, k in springs) if supported else (),
        ((TIP, extra),) if extra > 0 else (),
        bodies,
    )


@lru_cache(maxsize=32)
def _supported(
    plate: Plate,
    springs: tuple[tuple[Place, float], ...],
    masses: tuple[tuple[Place, float], ...],
    bodies: tuple[StandingBody, ...],
) -> SupportedPlate:
    return SupportedPlate(plate, springs, masses, bodies)


@remembered
def give_at_tip(r: DesignInputs) -> float:
    """Deflection of the drive surface above the tip by a unit force of the tip, bending and pads together, m/N."""
    return float(stage_plate(r).compliance([TIP])[0, 0])


def give_of_pads_at_tip(r: DesignInputs) -> float:
    """Compliance above the tip of a rigid stage on its pads, m/N."""
    rows = np.column_stack([np.ones(len(pad_positions(r))), pad_positions(r)])
    at = np.array([1.0, *TIP])
    return float(at @ np.linalg.solve(rows.T @ (pad_spring_stiffness(r)[:, None] * rows), at))


def give_at(r: DesignInputs, places: ArrayLike) -> Array:
    """Deflection at places, m, shape (n, 2), by a unit force of the tip, m/N, shape (n,)."""
    return stage_plate(r).compliance([TIP], places)[:, 0]


def stage_modes(r: DesignInputs, count: int, places: ArrayLike = (TIP,)) -> Modes:
    """The lowest natural modes of the stage on its pads, the rigid-body ones among them."""
    return stage_plate(r).modes(count, places)


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
