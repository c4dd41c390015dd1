"""The suspensions that the thesis considers, compared with the same requirements and ranked by its criteria."""

from functools import lru_cache, partial

import numpy as np
from numpy.typing import NDArray

from designcalc.bearing.porous_air import stiffness_of_gap
from designcalc.bearing.sliding import averaged_roughness
from designcalc.checks.check import Check, CheckFunction, DesignInputs, at_least, at_most, show
from designcalc.contact.hertz import contact_modulus, load_at_pressure, load_at_stiffness, point_contact
from designcalc.contact.hertz_stress import peak_mises
from designcalc.drive.suspension import Suspension, dipole_hessian, rank_sum
from designcalc.friction_stage.physics.loads import load, weight
from designcalc.friction_stage.physics.pads import film, heaviest_pad, pads_stiffness
from designcalc.friction_stage.quantities import stated
from stagecad.parameters.design import Design

_AIR_SOURCE = "thesis 2.4.1, catalogue point of a 1 in porous pad"
_BALL_SOURCE = "thesis 2.4.3 and appendix A; Johnson (1985), section 4.2"
_BALLS = {"steel": "materials.steel", "ceramic": "materials.alumina", "polymer": "materials.ptfe"}


def checks(design: Design) -> list[CheckFunction]:
    """Suspensions that the thesis rejects: a check passes where the reason is valid for this design."""
    return [
        air_model,
        air_surface,
        air_height,
        earnshaw,
        *(partial(small_ball, label=label) for label in _BALLS),
        *(partial(ball_stiffness, label=label) for label in _BALLS),
        ball_smoothness,
    ]


def _air_stiffness(r: DesignInputs) -> float:
    """Stiffness of one pad at its catalogue point, from its load there, N/m."""
    gap, load = r("candidates.air_bearing.gap"), r("candidates.air_bearing.load")
    diameter, supply = r("candidates.air_bearing.diameter"), r("candidates.air_bearing.supply")
    return float(stiffness_of_gap(gap, gap, load, diameter, supply))


def air_model(r: DesignInputs) -> Check:
    found, stated = _air_stiffness(r), r("candidates.air_bearing.stiffness")
    load = heaviest_pad(r)
    return Check(
        "air bearing: computed stiffness against the catalogue's",
        at_most(abs(found / stated - 1), 0.15, ""),
        source="porous disc fed everywhere, isothermal viscous film; its feed fixed by the catalogue's load alone",
        formula="|K_model/K_catalogue - 1|, K = -dW/dh",
        substituted=f"{show(found, 'N/m')} against {show(stated, 'N/m')}",
        proposal="ask the maker: load and stiffness of the catalogue point are not consistent",
        note=f"{_AIR_SOURCE}; load of a pad of the stage {show(load, 'N')}",
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
    largest = float(np.abs(values).max())
    return Check(
        "passive magnets, not chosen: softest direction",
        at_most(float(values[0]) / largest, 0.0, ""),
        source="Earnshaw: the Laplacian of a magnet's energy is zero outside its sources",
        formula="K_x + K_y + K_z = 0, so the smallest eigenvalue of K lies below 0: unstable",
        substituted=f"trace over largest {np.trace(total) / largest:.1e}; eigenvalues over largest "
        + ", ".join(f"{v / largest:.3f}" for v in values),
    )


def _ball_modulus(r: DesignInputs, label: str) -> float:
    ball = _BALLS[label]
    return float(
        contact_modulus(
            r(f"{ball}.youngs_modulus"),
            r(f"{ball}.poisson_ratio"),
            r.material("stage", "youngs_modulus"),
            r.material("stage", "poisson_ratio"),
        )
    )


def small_ball(r: DesignInputs, label: str) -> Check:
    radius, modulus = r("candidates.ball_spring.small_diameter") / 2, _ball_modulus(r, label)
    load = weight(r) / 3
    pressure = float(point_contact(load, radius, np.inf, modulus).peak_pressure)
    # Whichever body yields first: the aluminium stage, or a soft ball.
    limits = {
        "the stage": r.material("stage", "strength") / float(peak_mises(1.0, r.material("stage", "poisson_ratio"))),
        "the ball": r(f"{_BALLS[label]}.strength") / float(peak_mises(1.0, r(f"{_BALLS[label]}.poisson_ratio"))),
    }
    first = min(limits, key=lambda name: limits[name])
    stated = r("candidates.ball_spring.stated_pressure")
    giga = float(load_at_pressure(stated, radius, np.inf, modulus))
    return Check(
        f"ball on spring, not chosen: pressure of a 5 mm {label} ball",
        at_least(pressure, limits[first], "Pa"),
        source=_BALL_SOURCE + "; first yield, section 6.1",
        formula="p0 above Sy/(largest von Mises stress over p0): ball or stage yields",
        substituted=f"F = {show(load, 'N')} a ball: {show(pressure, 'Pa')} against {show(limits[first], 'Pa')}, where "
        f"{first} yields; {show(stated, 'Pa')} at {show(giga, 'N')}",
        proposal="a small ball would suffice: reconsider it",
        thesis=(f"1 GPa is stated without a load: it is reached at {show(giga, 'N')}" if label == "steel" else ""),
    )


def ball_stiffness(r: DesignInputs, label: str) -> Check:
    radius, modulus = r("candidates.ball_spring.large_diameter") / 2, _ball_modulus(r, label)
    load = weight(r) / 3
    contact = point_contact(load, radius, np.inf, modulus)
    stiffness = 3 * float(contact.stiffness)
    slide = pads_stiffness(r).normal
    claimed = r("candidates.ball_spring.stated_stiffness")
    at = float(load_at_stiffness(claimed, radius, np.inf, modulus))
    return Check(
        f"ball on spring, not chosen: stiffness of three 50 mm {label} balls",
        at_most(stiffness, slide, "N/m"),
        source=_BALL_SOURCE,
        formula="3 dF/ddelta of a ball below the stiffness of the sliding pads",
        substituted=f"F = {show(load, 'N')} a ball: {show(stiffness / 3, 'N/m')} each, "
        f"{show(float(contact.peak_pressure), 'Pa')}; pads {show(slide, 'N/m')}",
        proposal="balls would be stiffer than the pads: reconsider them",
        thesis=(
            f"30 N/um is stated without a load: with a {label} ball it takes {show(at, 'N')}"
            if label != "polymer"
            else ""
        ),
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
    steel = _ball_modulus(r, "steel")
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
