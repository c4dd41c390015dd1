"""Working numbers of the machine that several checks need, read through a `Reading` so that each check shows them."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from designcalc.bolted_rail import Rail
from designcalc.checks.reading import Reading
from designcalc.friction_drive import GRAVITY, TipEllipse, piezo_stiffness, tip_ellipse
from designcalc.hertz import PointContact, contact_modulus, point_contact
from designcalc.magnetic_teeth import MagnetCircuit, MagnetWorkingPoint, TeethField, teeth_field, working_point
from designcalc.sliding_bearing import FilmContact, confined_modulus, film_contact, pad_loads

Array = NDArray[np.float64]


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


def stroke_ellipse(r: Reading) -> TipEllipse:
    """Path of the tip at the drive's own stroke and phase."""
    return tip_ellipse(
        r("actuator.stroke_amplitude"), r("actuator.phase"), r("actuator.piezo_spacing"), r("actuator.tip_height")
    )


def stack_stiffness(r: Reading) -> float:
    """Stiffness of one piezo, N/m."""
    return piezo_stiffness(r("piezo.blocking_force"), r("piezo.stroke"))


def pads(r: Reading) -> Array:
    """Pad centres (n, 2), x along the travel and y across, from the middle of the stage, m."""
    along, across, count = r("pads.spacing_along") / 2, r("pads.spacing_across") / 2, r("pads.count")
    far = [(0.0, -across)] if count == 3 else [(-along, -across), (along, -across)]
    return np.array([(-along, across), (along, across), *far])


def film(r: Reading, load: float) -> FilmContact:
    """One crowned pad on the way, the PTFE film between them."""
    modulus = confined_modulus(r("materials.ptfe.youngs_modulus"), r("materials.ptfe.poisson_ratio"))
    bodies = contact_modulus(
        r.material("stage", "youngs_modulus"),
        r.material("stage", "poisson_ratio"),
        r.material("bearing_way", "youngs_modulus"),
        r.material("bearing_way", "poisson_ratio"),
    )
    return film_contact(load, r("pads.crown_radius"), r("bearing.film_thickness"), modulus, float(bodies))


def normal_stiffness(r: Reading) -> float:
    """Of the stage on all its pads, N/m, each at its own load."""
    loads = pad_loads(pads(r), weight(r) + r("preload.force"), (0.0, 0.0))
    return sum(float(film(r, max(float(n), 1e-3)).stiffness) for n in loads)


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
