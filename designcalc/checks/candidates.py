"""The suspensions the thesis weighed, held against the same needs, and ranked by its own criteria."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from functools import partial

import numpy as np

from designcalc.checks.check import Check
from designcalc.checks.machine import pads, weight
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
    """Air bearing, passive magnets, balls."""
    yield partial(air_load, r)
    yield partial(air_surface, r)
    yield partial(earnshaw, r)
    yield partial(small_ball, r)
    yield partial(ball_stiffness, r, "steel", "materials.steel")
    yield partial(ball_stiffness, r, "ceramic", "materials.alumina")
    yield partial(ball_stiffness, r, "polymer", "materials.ptfe")


def air_load(r: Reading) -> Check:
    load = (weight(r) + r("preload.force")) / r("pads.count")
    return r.check(
        "air bearing: load of a pad",
        load,
        r.given("catalogue load", _AIR.load, "N", _AIR_SOURCE),
        "N",
        "at most",
        _AIR_SOURCE,
        "W (1+p)/n <= 90 N",
        f"{show(load, 'N')}; the pad carries {_AIR.load_ratio:.2f} of supply x area, stiffness x gap/load = "
        f"{_AIR.stiffness_ratio:.2f}",
        "larger pads",
    )


def air_surface(r: Reading) -> Check:
    rough = 4 * r("bearing.way_roughness")
    return r.check(
        "air bearing: roughness of the way",
        rough,
        _AIR.roughness_limit,
        "m",
        "at most",
        "Slocum (1992), chapter 9: peak to valley below a quarter of the gap",
        "4 Ra <= gap/4",
        f"{show(rough, 'm')} against {show(_AIR.roughness_limit, 'm')}",
        f"Ra of {show(_AIR.roughness_limit / 4, 'm')}",
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
        "passive magnetic levitation: softest direction",
        lowest / largest,
        0.0,
        "",
        "at least",
        "Earnshaw: the Laplacian of a magnet's energy is zero outside its sources",
        "min eigenvalue of K over its largest >= 0; K_x + K_y + K_z = 0",
        f"trace over largest {np.trace(total) / largest:.1e}; eigenvalues over largest "
        + ", ".join(f"{v / largest:.3f}" for v in np.linalg.eigvalsh(total)),
        "guide it by contact, or control it: passive magnets alone never hold in all directions",
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
        "ball on spring: pressure of a 5 mm ball",
        pressure,
        strength,
        "Pa",
        "at most",
        _BALL_SOURCE,
        "p0 <= 1.6 Sy (first yield of the stage)",
        f"F = {show(load, 'N')} a ball: {show(pressure, 'Pa')}; 1 GPa at {show(giga, 'N')}",
        "larger balls, or hard inserts in the stage",
        thesis="the load is not stated; 1 GPa is reached at 9.7 N",
    )


def ball_stiffness(r: Reading, label: str, key: str) -> Check:
    modulus = _ball_modulus(r, key)
    load = weight(r) / 3
    stiffness = float(point_contact(load, LARGE_BALL, np.inf, modulus).stiffness)
    wanted = r.given("stiffness claimed", 30e6, "N/m", "thesis 2.4.3: 30 N/um for steel and ceramic")
    at = float(load_at_stiffness(wanted, LARGE_BALL, np.inf, modulus))
    return r.check(
        f"ball on spring: stiffness of a 50 mm {label} ball",
        stiffness,
        wanted,
        "N/m",
        "at least",
        _BALL_SOURCE,
        "dF/ddelta = 2 E* a >= 30 N/um",
        f"F = {show(load, 'N')}: {show(stiffness, 'N/m')}; 30 N/um at {show(at, 'N')}",
        f"a load of {show(at, 'N')} a ball",
        thesis="the load is not stated: 30 N/um is the tangent stiffness at 54 N (steel)" if label == "steel" else "",
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
