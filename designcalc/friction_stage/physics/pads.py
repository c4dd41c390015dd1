"""The sliding bearing of the design: pad positions and loads, film contact, stiffness; and the bolted way below."""

import numpy as np
from numpy.typing import NDArray

from designcalc.bearing.bolted_rail import Rail
from designcalc.bearing.sliding import PadStiffness, pad_loads, pad_stiffness
from designcalc.checks.check import DesignInputs, remembered
from designcalc.contact.film import FilmContact, confined_modulus, film_contact
from designcalc.contact.hertz import PointContact, contact_modulus, point_contact
from designcalc.friction_stage.physics.loads import load, load_centre
from designcalc.friction_stage.physics.tip_dynamics import elastic_constants

Array = NDArray[np.float64]


@remembered
def pad_positions(r: DesignInputs) -> Array:
    """Pad centres (n, 2), x along the travel and y across, from the middle of the stage, m."""
    for key in ("pads.spacing_along", "pads.spacing_across", "pads.count"):
        r(key)
    return np.array(r.design.derived.pad_places) * 1e-3


@remembered
def film(r: DesignInputs, load: float, crown_radius: float | None = None) -> FilmContact:
    """One crowned pad on the way under `load`, N, the PTFE film between them; by default with the design's crown."""
    modulus = confined_modulus(r("materials.ptfe.youngs_modulus"), r("materials.ptfe.poisson_ratio"))
    bodies = contact_modulus(*elastic_constants(r, "stage", "bearing_way"))
    return film_contact(
        load, crown_radius or r("pads.crown_radius"), r("bearing.film_thickness"), modulus, float(bodies)
    )


def pad_contact(r: DesignInputs, load: float) -> PointContact:
    """One crowned pad on the way under `load`, N, without its film."""
    return point_contact(
        load, r("pads.crown_radius"), np.inf, contact_modulus(*elastic_constants(r, "stage", "bearing_way"))
    )


@remembered
def mean_film(r: DesignInputs) -> FilmContact:
    """Contact of a pad under the mean of the pads' loads."""
    return film(r, load(r) / len(pad_positions(r)))


@remembered
def pad_forces(r: DesignInputs) -> Array:
    """Load of each pad under weight and preload, N."""
    return pad_loads(pad_positions(r), load(r), load_centre(r))


@remembered
def heaviest_pad(r: DesignInputs) -> float:
    """Largest pad load, N."""
    return r.given("heaviest pad load", float(np.max(pad_forces(r))), "N", "statics of weight and preload on the pads")


@remembered
def pad_spring_stiffness(r: DesignInputs) -> Array:
    """Normal stiffness of each pad at its own load, N/m."""
    # A pad about to lift has next to no stiffness; a load of zero is out of its formula's range.
    return np.array([float(film(r, max(float(n), 1e-3)).stiffness) for n in pad_forces(r)])


@remembered
def pads_stiffness(r: DesignInputs) -> PadStiffness:
    """Normal, pitch and roll stiffness of a rigid stage on its pads."""
    return pad_stiffness(pad_positions(r), pad_spring_stiffness(r))


def rail(r: DesignInputs) -> Rail:
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
        bed_poisson=r.material("base", "poisson_ratio"),
        joint_ratio=r("bearing_way.joint_ratio"),
    )
