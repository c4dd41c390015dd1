"""Working numbers of the machine that several checks need, read through a `Reading` so that each check shows them."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from designcalc.bearing.bolted_rail import Rail
from designcalc.bearing.sliding import (
    FilmContact,
    PadStiffness,
    confined_modulus,
    film_contact,
    pad_loads,
    pad_stiffness,
)
from designcalc.checks.inputs import Reading
from designcalc.contact.hertz import PointContact, contact_modulus, point_contact, tangential_stiffness
from designcalc.drive.friction_drive import GRAVITY, TipEllipse, piezo_stiffness, resonance, tip_ellipse
from designcalc.drive.magnetic_teeth import MagnetCircuit, MagnetWorkingPoint, TeethField, teeth_field, working_point
from designcalc.drive.piezo_stack import rocking_stiffness, tip_inertia

Array = NDArray[np.float64]

PIEZOS = 3
"""Under one tip."""


def weight(r: Reading) -> float:
    """Weight of stage and payload, N: the load of the bearing without preload."""
    return (r.mass() + r("payload.mass")) * GRAVITY


def moved_mass(r: Reading) -> float:
    """Mass the drive accelerates: stage and payload, kg."""
    return r.mass() + r("payload.mass")


def preload_ratio(r: Reading) -> float:
    """Preload over weight."""
    return r("preload.force") / weight(r)


def tip_load(r: Reading) -> float:
    """Largest force the tip can press with: the whole of weight and preload, N, as the stage is about to lift off."""
    return r.given("tip load at lift-off", weight(r) + r("preload.force"), "N", "weight and preload")


def tip_contact(r: Reading, load: float) -> PointContact:
    """Nose of the tip on the stage's underside."""
    modulus = contact_modulus(
        r.material("tip", "youngs_modulus"),
        r.material("tip", "poisson_ratio"),
        r.material("stage", "youngs_modulus"),
        r.material("stage", "poisson_ratio"),
    )
    return point_contact(load, r("tip.nose_radius"), np.inf, modulus)


def usable_ellipse(r: Reading) -> tuple[float, float]:
    """X and Y of the ellipse at what the piezo has, or at the drive's own stroke where that is less, m."""
    amplitude = min(r("piezo.stroke") / 2, r("actuator.stroke_amplitude"))
    path = tip_ellipse(amplitude, r("actuator.phase"), r("actuator.piezo_spacing"), r("actuator.tip_height"))
    return float(path.along), float(path.normal)


def swinging_mass(r: Reading) -> float:
    """What moves on the piezos: the tip and a share of each stack, kg."""
    return r.tip_mass() + PIEZOS * r("piezo.moving_mass")


def tip_resonances(r: Reading) -> tuple[float, float]:
    """Resonances of the free tip on its piezos, Hz: up and down on all three, rocking on the two along the travel."""
    mass, stack = swinging_mass(r), stack_stiffness(r)
    circle = r("actuator.piezo_spacing") / np.sqrt(3)
    inertia = tip_inertia(mass, circle, r("actuator.tip_height"))
    turn = rocking_stiffness(stack, r("actuator.piezo_spacing"))
    return float(resonance(PIEZOS * stack, mass)), float(resonance(turn, inertia))


def tip_resonance(r: Reading) -> float:
    """The lower one of `tip_resonances`, Hz."""
    return min(tip_resonances(r))


def holding_stiffness(r: Reading) -> float:
    """With which a tip that does not slip holds the stage along its travel, N/m: rocking on its piezos, and the
    shear of the contact, in series."""
    rocking = rocking_stiffness(stack_stiffness(r), r("actuator.piezo_spacing")) / r("actuator.tip_height") ** 2
    contact = tip_contact(r, tip_load(r))
    shear = tangential_stiffness(
        contact,
        r.material("tip", "youngs_modulus"),
        r.material("tip", "poisson_ratio"),
        r.material("stage", "youngs_modulus"),
        r.material("stage", "poisson_ratio"),
    )
    return 1 / (1 / float(rocking) + 1 / float(shear))


def stroke_ellipse(r: Reading) -> TipEllipse:
    """Path of the tip at the drive's own stroke and phase."""
    return tip_ellipse(
        r("actuator.stroke_amplitude"), r("actuator.phase"), r("actuator.piezo_spacing"), r("actuator.tip_height")
    )


def stack_stiffness(r: Reading) -> float:
    """Stiffness of one piezo, N/m."""
    return float(piezo_stiffness(r("piezo.blocking_force"), r("piezo.stroke")))


def pads(r: Reading) -> Array:
    """Pad centres (n, 2), x along the travel and y across, from the middle of the stage, m."""
    along, across, count = r("pads.spacing_along") / 2, r("pads.spacing_across") / 2, r("pads.count")
    far = [(0.0, -across)] if count == 3 else [(-along, -across), (along, -across)]
    return np.array([(-along, across), (along, across), *far])


def film(r: Reading, load: float, crown_radius: float | None = None) -> FilmContact:
    """One crowned pad on the way, the PTFE film between them; the crown of the design when left out."""
    modulus = confined_modulus(r("materials.ptfe.youngs_modulus"), r("materials.ptfe.poisson_ratio"))
    bodies = contact_modulus(
        r.material("stage", "youngs_modulus"),
        r.material("stage", "poisson_ratio"),
        r.material("bearing_way", "youngs_modulus"),
        r.material("bearing_way", "poisson_ratio"),
    )
    return film_contact(
        load, crown_radius or r("pads.crown_radius"), r("bearing.film_thickness"), modulus, float(bodies)
    )


def pad_forces(r: Reading) -> Array:
    """Load of each pad under weight and preload, N."""
    return pad_loads(pads(r), weight(r) + r("preload.force"), r.centre())


def heaviest_pad(r: Reading) -> float:
    """Load of the pad that bears most, N."""
    return r.given("heaviest pad load", float(np.max(pad_forces(r))), "N", "statics of weight and preload on the pads")


def pads_stiffness(r: Reading) -> PadStiffness:
    """Normal, pitch and roll stiffness of the stage on its pads, each at its own load."""
    loads = pad_forces(r)
    # A pad about to lift has next to no stiffness; a load of zero is out of its formula's range.
    return pad_stiffness(pads(r), np.array([float(film(r, max(float(n), 1e-3)).stiffness) for n in loads]))


def normal_stiffness(r: Reading) -> float:
    """Of the stage on all its pads, N/m."""
    return pads_stiffness(r).normal


def rail(r: Reading) -> Rail:
    """The bearing way on the base, with its real materials."""
    edge, width = r("bearing_way.bolt_edge"), r("bearing_way.width")
    return Rail(
        length=r("bearing_way.length"),
        overhang_a=edge,
        overhang_b=width - edge,
        height=r("bearing_way.height"),
        bolt_diameter=r("screws.way.diameter"),
        rail_modulus=r.material("bearing_way", "youngs_modulus"),
        bed_modulus=r.material("base", "youngs_modulus"),
        bolt_modulus=r("materials.alloy_steel.youngs_modulus"),
        poisson=r.material("bearing_way", "poisson_ratio"),
        joint_ratio=r("bearing_way.joint_ratio"),
    )


@dataclass(frozen=True)
class TeethWork:
    """The tooth field of the design, and what one magnet (of two, one over each bar) makes of it."""

    field: TeethField
    circuit: MagnetCircuit
    point: MagnetWorkingPoint
    pitch: float
    width: float
    gap: float
    depth: float


def teeth(r: Reading) -> TeethWork:
    """Field and forces of the toothed irons of the design."""
    pitch, width, gap, depth = (r(f"teeth.{name}") for name in ("pitch", "width", "gap", "groove_depth"))
    field = teeth_field(pitch, width, gap, depth)
    circuit = MagnetCircuit(
        remanence=r("magnet.remanence"),
        thickness=r("magnet.thickness"),
        area=r("magnet.length") * r("magnet.height"),
        recoil_permeability=r("magnet.recoil_permeability"),
        gap_area=r("tooth_iron.length") * r("teeth.per_iron") * pitch,
        gaps=2,  # down through one iron of a pocket, along the bar, up through the other
    )
    return TeethWork(field, circuit, working_point(field, circuit, pitch, width), pitch, width, gap, depth)
