"""The suspensions that the thesis considers, compared with the same requirements and ranked by its criteria."""

from functools import lru_cache, partial

import numpy as np
from numpy.typing import NDArray

from designcalc.bearing.porous_air import stiffness_of_gap
from designcalc.bearing.sliding import averaged_roughness
from designcalc.checks.check import DesignInputs, Quantities
from designcalc.contact.hertz import contact_modulus, peak_mises, point_contact
from designcalc.drive.suspension import Suspension, dipole_hessian, rank_sum
from designcalc.friction_stage.physics.loads import load
from designcalc.friction_stage.physics.pads import film, heaviest_pad, pads_stiffness

_BALLS = {"steel": "materials.steel", "ceramic": "materials.alumina", "polymer": "materials.ptfe"}


def _air_stiffness(r: DesignInputs) -> float:
    """Stiffness of one pad at its catalogue point, from its load there, N/m."""
    gap, load = r("candidates.air_bearing.gap"), r("candidates.air_bearing.load")
    diameter, supply = r("candidates.air_bearing.diameter"), r("candidates.air_bearing.supply")
    return float(stiffness_of_gap(gap, gap, load, diameter, supply))


@lru_cache(maxsize=64)
def _over_base(side: float, moment: float, height: float, reach: float) -> NDArray[np.float64]:
    """Stiffness matrix of a magnet over a square of magnets on the base, of opposite moment, N/m."""
    base = np.arange(-reach, reach + side / 2, side)
    total = np.zeros((3, 3))
    for x in base:
        for y in base:
            total += dipole_hessian((0, 0, moment), (0, 0, -moment), (side / 5 - x, -y, height))
    return total


def earnshaw(r: DesignInputs) -> Quantities:
    side, moment = r("candidates.magnetic_levitation.pitch"), r("candidates.magnetic_levitation.moment")
    height = r("candidates.magnetic_levitation.flying_height")
    total = _over_base(side, moment, height, r("stage.travel"))
    values = np.linalg.eigvalsh(total)
    names = ("stiffness.softest", "stiffness.middle", "stiffness.hardest")
    return {name: (float(value), "N/m") for name, value in zip(names, values, strict=True)}


def _modulus(ball: str, r: DesignInputs) -> float:
    """Of the contact of a ball with the stage, Pa."""
    own = (r(f"{ball}.youngs_modulus"), r(f"{ball}.poisson_ratio"))
    return float(contact_modulus(*own, r.material("stage", "youngs_modulus"), r.material("stage", "poisson_ratio")))


QUANTITIES: Quantities = {"stiffness.of_air_pad": (_air_stiffness, "N/m")}
OF_BALLS: dict[str, Quantities] = {
    f"{label} ball": {
        "modulus.of_ball": (partial(_modulus, ball), "Pa"),
        "mises.ball": (lambda r, ball=ball: float(peak_mises(1.0, r(f"{ball}.poisson_ratio"))), ""),
    }
    for label, ball in _BALLS.items()
}
"""Quantities of the checks of balls of a material."""


def ranking(r: DesignInputs) -> list[Suspension]:
    """The suspensions by the criteria of thesis 2.3.2: stiffness, smoothness, resolution, repeatability, cost.

    Ranks are summed; unstable suspensions (Earnshaw) and those incompatible with the drive come last.
    """
    force, count = load(r), int(r("pads.count"))
    spot = film(r, heaviest_pad(r)).radius
    correlation = r("bearing.roughness_correlation")
    slide = float(averaged_roughness(r("bearing.proposed_way_roughness"), correlation, spot, count))
    steel = _modulus(_BALLS["steel"], r)
    ball = float(point_contact(force / 3, r("candidates.ball_spring.large_diameter") / 2, np.inf, steel).stiffness)
    air, balls = "candidates.air_bearing", "candidates.ball_spring"
    rubs, rolls = r("bearing.static_friction") * force, r(f"{balls}.rolling_friction") * force
    smooth = r(f"{air}.gap") * r(f"{air}.averaging")

    def entry(name: str, key: str, why: str, stiffness: float, smoothness: float, friction: float) -> Suspension:
        """A suspension; without stiffness it is not stable."""
        stable, fits, cost = stiffness > 0.0, key == "sliding_pads", int(r(f"candidates.{key}.cost_rank"))
        repeatability = r(f"candidates.{key}.repeatability") if stable else np.inf
        return Suspension(name, stiffness, smoothness, friction, repeatability, cost, stable, fits, why)

    sliding = "way lapped as proposed; friction limits its resolution"
    floating = "no friction; 1 in thick pads clash with magnets and tip"
    rolling = "tilts as the load moves; its balls are not round"
    levitating = "Earnshaw: unstable in a direction"
    entries = [
        entry("sliding pads", "sliding_pads", sliding, pads_stiffness(r).normal, slide, rubs),
        entry("porous air bearing", "air_bearing", floating, count * r(f"{air}.stiffness"), smooth, 0.0),
        entry("ball on spring", "ball_spring", rolling, 3 * ball, r(f"{balls}.roundness"), rolls),
        entry("passive magnets", "magnetic_levitation", levitating, 0.0, np.inf, 0.0),
    ]
    scores = [(-c.stiffness, c.smoothness, c.friction, c.repeatability, c.cost) for c in entries]
    placed = [Suspension(**{**vars(c), "places": float(p)}) for c, p in zip(entries, rank_sum(scores), strict=True)]
    return sorted(placed, key=lambda c: (not c.stable, not c.fits_drive, c.places))
