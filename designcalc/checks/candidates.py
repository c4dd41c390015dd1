"""The suspensions the thesis weighed, held against the same needs, and ranked by its own criteria."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from functools import partial

import numpy as np

from designcalc.checks.check import Check
from designcalc.checks.machine import normal_stiffness, pads, weight
from designcalc.checks.reading import Reading, show
from designcalc.hertz import contact_modulus, load_at_pressure, load_at_stiffness, point_contact
from designcalc.suspension import AirBearing, dipole_hessian

_AIR = AirBearing(diameter=25.4e-3, load=90.0, stiffness=24.5e6, supply=413e3, gap=5e-6)
_AIR_SOURCE = "thesis 2.4.1, catalogue point of a 1 in porous pad"
_BALL_SOURCE = "thesis 2.4.3 and appendix A; Johnson (1985), section 4.2"
SMALL_BALL, LARGE_BALL = 2.5e-3, 25e-3  # radii, m


@dataclass(frozen=True)
class Candidate:
    """A way to hold the stage up, with the numbers its rank rests on."""

    name: str
    stiffness: float
    """normal stiffness of the whole suspension, N/m"""
    smoothness: float
    """error normal to the motion, m"""
    stable: bool
    fits_drive: bool
    """goes with a friction drive and its magnets in the space there is"""
    why: str


def checks(r: Reading) -> Iterator[partial[Check]]:
    """Each candidate passed over: a check passes where the reason to pass it over holds for this design."""
    yield partial(air_surface, r)
    yield partial(air_height, r)
    yield partial(earnshaw, r)
    yield partial(small_ball, r)
    yield partial(ball_stiffness, r, "steel", "materials.steel")
    yield partial(ball_stiffness, r, "ceramic", "materials.alumina")
    yield partial(ball_stiffness, r, "polymer", "materials.ptfe")


def air_surface(r: Reading) -> Check:
    """The way that the sliding pads need is smoother than an air bearing asks for: no reason against it, but noted."""
    rough = 4 * r("bearing.proposed_way_roughness")
    drawn = 4 * r("bearing.way_roughness")
    load = (weight(r) + r("preload.force")) / r("pads.count")
    return r.check(
        "air bearing: roughness of the lapped way",
        rough,
        _AIR.roughness_limit,
        "m",
        "at most",
        "Slocum (1992), chapter 9: peak to valley below a quarter of the gap",
        "4 Ra <= gap/4",
        f"{show(rough, 'm')} against {show(_AIR.roughness_limit, 'm')}; as drawn {show(drawn, 'm')}",
        f"Ra of {show(_AIR.roughness_limit / 4, 'm')}",
        note=f"{_AIR_SOURCE}: {show(load, 'N')} a pad of {show(_AIR.load, 'N')}; it carries {_AIR.load_ratio:.2f} of "
        f"supply x area, stiffness x gap/load = {_AIR.stiffness_ratio:.2f}",
    )


def air_height(r: Reading) -> Check:
    """The porous pad is an inch thick, and would lift the stage off the reach of magnets and tip."""
    room = r("pads.height")
    thick = r.given("porous pad", 25.4e-3, "m", _AIR_SOURCE + ": 1 in thick")
    return r.check(
        "air bearing passed over: height of its pads",
        thick,
        room,
        "m",
        "at least",
        "geometry",
        "pad thickness > height of the stage over the way: it does not fit between them",
        f"{show(thick, 'm')} against {show(room, 'm')}",
        "the air bearing would fit: weigh it again",
    )


def earnshaw(r: Reading) -> Check:
    """Stage magnets repelled by base magnets: the three stiffnesses add up to zero, so one direction is unstable."""
    side = r.given("pitch of the base's magnets", 0.05, "m", "assumed: any pattern gives the same sum")
    base = [(x, y) for x in np.arange(-0.2, 0.21, side) for y in np.arange(-0.2, 0.21, side)]
    total = np.zeros((3, 3))
    for x, y in base:
        total += dipole_hessian((0, 0, 1.0), (0, 0, -1.0), (0.01 - x, -y, 0.03))
    lowest = float(np.linalg.eigvalsh(total)[0])
    largest = float(np.abs(np.linalg.eigvalsh(total)).max())
    return r.check(
        "passive magnets passed over: softest direction",
        lowest / largest,
        0.0,
        "",
        "at most",
        "Earnshaw: the Laplacian of a magnet's energy is zero outside its sources",
        "K_x + K_y + K_z = 0, so the smallest eigenvalue of K lies below 0: unstable",
        f"trace over largest {np.trace(total) / largest:.1e}; eigenvalues over largest "
        + ", ".join(f"{v / largest:.3f}" for v in np.linalg.eigvalsh(total)),
    )


def _ball_modulus(r: Reading, ball: str) -> float:
    return float(
        contact_modulus(
            r(f"{ball}.youngs_modulus"),
            r(f"{ball}.poisson_ratio"),
            r.material("stage", "youngs_modulus"),
            r.material("stage", "poisson_ratio"),
        )
    )


def small_ball(r: Reading) -> Check:
    modulus = _ball_modulus(r, "materials.steel")
    load = weight(r) / 3
    pressure = float(point_contact(load, SMALL_BALL, np.inf, modulus).peak_pressure)
    strength = 1.6 * r.material("stage", "strength")
    giga = float(load_at_pressure(1e9, SMALL_BALL, np.inf, modulus))
    return r.check(
        "ball on spring passed over: pressure of a 5 mm ball",
        pressure,
        strength,
        "Pa",
        "at least",
        _BALL_SOURCE,
        "p0 above 1.6 Sy: the ball dents the stage",
        f"F = {show(load, 'N')} a ball: {show(pressure, 'Pa')}; 1 GPa at {show(giga, 'N')}",
        "a small ball would do: weigh it again",
        thesis=f"1 GPa is stated without a load: it is reached at {show(giga, 'N')}",
    )


def ball_stiffness(r: Reading, label: str, key: str) -> Check:
    modulus = _ball_modulus(r, key)
    load = weight(r) / 3
    stiffness = 3 * float(point_contact(load, LARGE_BALL, np.inf, modulus).stiffness)
    slide = normal_stiffness(r)
    claimed = r.given("stiffness stated", 30e6, "N/m", "thesis 2.4.3: 30 N/um a ball for steel and ceramic")
    at = float(load_at_stiffness(claimed, LARGE_BALL, np.inf, modulus))
    return r.check(
        f"ball on spring passed over: stiffness of three 50 mm {label} balls",
        stiffness,
        slide,
        "N/m",
        "at most",
        _BALL_SOURCE,
        "3 dF/ddelta of a ball below the stiffness of the sliding pads",
        f"F = {show(load, 'N')} a ball: {show(stiffness / 3, 'N/m')} each; pads {show(slide, 'N/m')}",
        "balls would be stiffer than the pads: weigh them again",
        thesis=f"30 N/um is stated without a load: with a {label} ball it takes {show(at, 'N')}"
        if label != "polymer"
        else "",
    )


def ranking(r: Reading) -> list[Candidate]:
    """The suspensions in the order of the thesis's criteria: stable, goes with the drive, smooth, then stiff."""
    from designcalc.checks.machine import film
    from designcalc.sliding_bearing import averaged_roughness, pad_loads

    load = weight(r) + r("preload.force")
    count = int(r("pads.count"))
    contacts = [film(r, max(float(n), 1e-3)) for n in pad_loads(pads(r), load, (0.0, 0.0))]
    spot = 2 * float(contacts[0].radius)
    slide = float(averaged_roughness(r("bearing.proposed_way_roughness"), 20e-6, spot, spot, count))
    ball = float(point_contact(load / 3, LARGE_BALL, np.inf, _ball_modulus(r, "materials.steel")).stiffness)
    entries = [
        Candidate("sliding pads", sum(float(c.stiffness) for c in contacts), slide, True, True, "way lapped to 20 nm"),
        Candidate("porous air bearing", count * _AIR.stiffness, _AIR.gap / 100, True, False,
                  "1 in thick pads clash with the magnets; smoothness about a hundredth of the gap"),
        Candidate("ball on spring", 3 * ball, 0.13e-6, True, False, "ball grade 5: 0.13 um out of round"),
        Candidate("passive magnets", 0.0, np.inf, False, False, "Earnshaw: unstable in a direction"),
    ]  # fmt: skip
    return sorted(entries, key=lambda c: (not c.stable, not c.fits_drive, c.smoothness, -c.stiffness))
