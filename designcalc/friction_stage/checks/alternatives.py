"""The suspensions that the thesis considers, compared with the same requirements and ranked by its criteria."""

from functools import lru_cache, partial

import numpy as np
from numpy.typing import NDArray

from designcalc.bearing.porous_air import stiffness_of_gap
from designcalc.bearing.sliding import averaged_roughness
from designcalc.checks.check import Check, CheckFunction, DesignInputs, FormulaCheck, Quantities
from designcalc.contact.hertz import contact_modulus, peak_mises, point_contact
from designcalc.drive.suspension import Suspension, dipole_hessian, rank_sum
from designcalc.friction_stage.physics.loads import load
from designcalc.friction_stage.physics.pads import film, heaviest_pad, pads_stiffness
from designcalc.friction_stage.quantities import stated
from stagecad.parameters.design import Design

_AIR_SOURCE = "thesis 2.4.1, catalogue point of a 1 in porous pad"
_BALL_SOURCE = "thesis 2.4.3 and appendix A; Johnson (1985), section 4.2"
_BALLS = {"steel": "materials.steel", "ceramic": "materials.alumina", "polymer": "materials.ptfe"}
_LOAD = "(load.weight/3)"
"""Of a ball."""


def checks(design: Design) -> list[CheckFunction]:
    """Suspensions that the thesis rejects: a check passes where the reason is valid for this design."""
    return [
        air_model,
        air_surface,
        air_height,
        earnshaw,
        *(small_ball(label) for label in _BALLS),
        *(ball_stiffness(label) for label in _BALLS),
        ball_smoothness,
    ]


def _air_stiffness(r: DesignInputs) -> float:
    """Stiffness of one pad at its catalogue point, from its load there, N/m."""
    gap, load = r("candidates.air_bearing.gap"), r("candidates.air_bearing.load")
    diameter, supply = r("candidates.air_bearing.diameter"), r("candidates.air_bearing.supply")
    return float(stiffness_of_gap(gap, gap, load, diameter, supply))


air_model = stated(
    "air bearing: computed stiffness against the catalogue's",
    "abs(stiffness.of_air_pad/candidates.air_bearing.stiffness - 1) <= 0.15",
    given={"stiffness.of_air_pad": (_air_stiffness, "N/m")},
    source="porous disc fed everywhere, isothermal viscous film, K = -dW/dh; its feed fixed by the catalogue's load "
    "alone",
    proposal="ask the maker: load and stiffness of the catalogue point are not consistent",
    note=_AIR_SOURCE + "; load of a pad of the stage {load.heaviest_pad}",
)


air_surface = stated(
    "air bearing: roughness of the lapped way",
    "4*bearing.proposed_way_roughness <= candidates.air_bearing.gap/4",
    source="Slocum (1992), chapter 9: peak to valley below a quarter of the gap",
    proposal="Ra of {check.limit/4}",
    note=_AIR_SOURCE + "; as drawn {4*bearing.way_roughness}",
)


air_height = stated(
    "air bearing, not chosen: height of its pads",
    "candidates.air_bearing.height >= pads.height",
    source="geometry: a pad an inch thick does not fit between way and stage, within reach of magnets and tip",
    proposal="the air bearing would fit: reconsider it",
)


@lru_cache(maxsize=64)
def _over_base(side: float, moment: float, height: float, reach: float) -> NDArray[np.float64]:
    """Stiffness matrix of a magnet over a square of magnets on the base, of opposite moment, N/m."""
    base = np.arange(-reach, reach + side / 2, side)
    total = np.zeros((3, 3))
    for x in base:
        for y in base:
            total += dipole_hessian((0, 0, moment), (0, 0, -moment), (side / 5 - x, -y, height))
    return total


def earnshaw(r: DesignInputs) -> Check:
    """Stage magnets repelled by base magnets: the three stiffnesses add up to zero, so one direction is unstable."""
    side, moment = r("candidates.magnetic_levitation.pitch"), r("candidates.magnetic_levitation.moment")
    height = r("candidates.magnetic_levitation.flying_height")
    total = _over_base(side, moment, height, r("stage.travel"))
    values = np.linalg.eigvalsh(total)
    names = ("stiffness.softest", "stiffness.middle", "stiffness.hardest")
    return stated(
        "passive magnets, not chosen: softest direction",
        "stiffness.softest/max(abs(stiffness.softest), abs(stiffness.hardest)) <= 0",
        given={name: (float(value), "N/m") for name, value in zip(names, values, strict=True)},
        source="Earnshaw: the Laplacian of a magnet's energy is zero outside its sources, so that the stiffnesses of "
        "three directions add up to zero",
        note="{stiffness.softest}, {stiffness.middle} and {stiffness.hardest} in three directions",
    )(r)


def _modulus(ball: str, r: DesignInputs) -> float:
    """Of the contact of a ball with the stage, Pa."""
    own = (r(f"{ball}.youngs_modulus"), r(f"{ball}.poisson_ratio"))
    return float(contact_modulus(*own, r.material("stage", "youngs_modulus"), r.material("stage", "poisson_ratio")))


def _ball_quantities(label: str) -> Quantities:
    ball = _BALLS[label]
    return {
        "modulus.of_ball": (partial(_modulus, ball), "Pa"),
        "mises.ball": (lambda r: float(peak_mises(1.0, r(f"{ball}.poisson_ratio"))), ""),
    }


def small_ball(label: str) -> FormulaCheck:
    radius, stated_pressure = "(candidates.ball_spring.small_diameter/2)", "candidates.ball_spring.stated_pressure"
    giga = f"{{{stated_pressure}^3*pi^3*{radius}^2/(6*modulus.of_ball^2)}}"
    return stated(
        f"ball on spring, not chosen: pressure of a 5 mm {label} ball",
        f"(6*{_LOAD}*modulus.of_ball^2/(pi^3*{radius}^2))^(1/3)"
        f" >= min(stage.material.strength/mises.stage, {_BALLS[label]}.strength/mises.ball)",
        given=_ball_quantities(label),
        source=_BALL_SOURCE + "; first yield of stage or ball, section 6.1",
        proposal="a small ball would suffice: reconsider it",
        thesis=f"1 GPa is stated without a load: it is reached at {giga}" if label == "steel" else "",
        note=f"{{{stated_pressure}}} at {giga}",
    )


def ball_stiffness(label: str) -> FormulaCheck:
    radius, claimed = "(candidates.ball_spring.large_diameter/2)", "candidates.ball_spring.stated_stiffness"
    at = f"{{(({claimed})/(2*modulus.of_ball))^3*4*modulus.of_ball/(3*{radius})}}"
    return stated(
        f"ball on spring, not chosen: stiffness of three 50 mm {label} balls",
        f"3*2*modulus.of_ball*(3*{_LOAD}*{radius}/(4*modulus.of_ball))^(1/3) <= stiffness.pads",
        given=_ball_quantities(label),
        source=_BALL_SOURCE,
        proposal="balls would be stiffer than the pads: reconsider them",
        thesis=f"30 N/um is stated without a load: with a {label} ball it takes {at}" if label != "polymer" else "",
        note="{check.value/3} each",
    )


ball_smoothness = stated(
    "ball on spring, not chosen: roundness of its balls",
    "candidates.ball_spring.roundness >= requirements.smoothness",
    source="ISO 3290, grade 5; a ball's deviation passes into the motion whole",
    proposal="such balls would be smooth enough: reconsider them",
    thesis="'44 um variation for 127 um balls' is garbled: it would be a third of the ball; grade 5 balls are round to "
    "{check.value}, and still too coarse",
    requirement="Table 1: smoothness",
)


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
    air = "candidates.air_bearing"
    pads = "candidates.sliding_pads"
    balls, magnets = "candidates.ball_spring", "candidates.magnetic_levitation"
    entries = [
        Suspension(
            name="sliding pads",
            stiffness=pads_stiffness(r).normal,
            smoothness=slide,
            friction=r("bearing.static_friction") * force,
            repeatability=r(f"{pads}.repeatability"),
            cost=int(r(f"{pads}.cost_rank")),
            stable=True,
            fits_drive=True,
            why="way lapped as proposed; friction limits its resolution",
        ),
        Suspension(
            name="porous air bearing",
            stiffness=count * r(f"{air}.stiffness"),
            smoothness=r(f"{air}.gap") * r(f"{air}.averaging"),
            friction=0.0,
            repeatability=r(f"{air}.repeatability"),
            cost=int(r(f"{air}.cost_rank")),
            stable=True,
            fits_drive=False,
            why="no friction; 1 in thick pads clash with magnets and tip",
        ),
        Suspension(
            name="ball on spring",
            stiffness=3 * ball,
            smoothness=r(f"{balls}.roundness"),
            friction=r(f"{balls}.rolling_friction") * force,
            repeatability=r(f"{balls}.repeatability"),
            cost=int(r(f"{balls}.cost_rank")),
            stable=True,
            fits_drive=False,
            why="tilts as the load moves; its balls are not round",
        ),
        Suspension(
            name="passive magnets",
            stiffness=0.0,
            smoothness=np.inf,
            friction=0.0,
            repeatability=np.inf,
            cost=int(r(f"{magnets}.cost_rank")),
            stable=False,
            fits_drive=False,
            why="Earnshaw: unstable in a direction",
        ),
    ]
    scores = [(-c.stiffness, c.smoothness, c.friction, c.repeatability, c.cost) for c in entries]
    placed = [Suspension(**{**vars(c), "places": float(p)}) for c, p in zip(entries, rank_sum(scores), strict=True)]
    return sorted(placed, key=lambda c: (not c.stable, not c.fits_drive, c.places))
