"""Known quantities that the records contradict: the mass, with the scale of the force, and the stiffness of a spring.

A force F along a measured motion obeys F = m a + f(x, v) for friction and springs of any law without memory. The mass
is estimated with f as hat functions of velocity and position, separately for each direction. Its standard deviation is
that of the sums over blocks of time, since what f lacks is correlated (Liang and Zeger, Biometrika 73 (1986) 13). What
is known is contradicted where the estimate is far from it in standard deviations and in percent, and where the
difference is a notable part of what f leaves unexplained.
"""

from collections.abc import Mapping
from typing import NamedTuple

import numpy as np

from stagecad.parameters.units import format_quantity
from sysid.noise.motion_regression import RIDGE, SHARP, hats_of
from sysid.prediction.force_balance.record import ForceBalanceRecord
from sysid.prediction.problem import Problem
from sysid.signals.masks import filled

BLOCKS = 12
"""Blocks of time of all records together."""
SURE = 6.0
"""Standard deviations of a contradiction: those of `BLOCKS` sums follow Student's t."""
FAR = 0.2
"""Relative difference from which a known quantity is contradicted: a delay or a flexible mode may shift it by less."""
CLEAR = 10.0
"""Power of what a known quantity multiplies over that of its noise, which makes the estimate too small."""
LEAST_ROWS = 500
"""Rows from which an estimate is made."""
NOTABLE = 0.1
"""Share of the variance that f leaves, which the difference must explain."""


def contradicted_known(problem: Problem) -> list[str]:
    """One line for each known quantity that the records of the fit contradict."""
    rig, found = problem.experiment.rig, []
    force = next((record.force_channel for record in problem.fit_records), "")
    # A scale that is not exactly known is fitted.
    sources = [record.sources[force] for record in problem.experiment.records if force in record.sources]
    scaled = any(term.deviation for source in sources for term in source.terms)
    of_mass = [part for record in problem.fit_records if not scaled and (part := _mass_terms(record))]
    of_spring = [part for record in problem.records if (part := _spring_terms(record.channels))]
    for key, parts, blamed in (
        ("mass", of_mass, f"it is wrong, or the scale of '{force}' is"),
        ("pull_stiffness", of_spring, "it, the unit or the scale of 'spring_force' is wrong, or that of a position"),
    ):
        known, quantity = rig.known.get(key), rig.declaration.known.get(key)
        if known is None or quantity is None or (value := _estimate(parts, known.value, known.std or 0.0)) is None:
            continue
        name = "inertia" if key == "mass" and rig.rotary else key
        shown, stated = (
            format_quantity(number, quantity.rotary_unit if rig.rotary else quantity.unit, digits)
            for number, digits in ((value, 3), (known.value, 4))
        )
        found.append(
            f"the records show {shown} for rig.known.{name}, {value / known.value:.3g} times the stated "
            f"{stated}: {blamed}"
        )
    return found


class Terms(NamedTuple):
    """A force (n,), what the known quantity multiplies (n,), functions of the rest (p, n), and the standard deviation
    of the noise of what it multiplies."""

    force: np.ndarray
    factor: np.ndarray
    functions: np.ndarray
    noise: float = 0.0


def _mass_terms(record: object) -> Terms | None:
    if not isinstance(record, ForceBalanceRecord) or record.acceleration is None or record.is_free:
        return None
    rows, axis = record.valid[record.force_channel], record.axis
    if not np.ptp(axis.velocity[rows]) > 0.0:
        return None
    force = record.inputs.get("spring_force", record.measured[record.force_channel])[rows]
    ahead = axis.direction[rows] > 0.0
    place = hats_of(axis.position[rows])
    functions = np.vstack([hats_of(axis.velocity[rows], SHARP), place * ahead, place * ~ahead])
    return Terms(force, record.acceleration[rows], functions, record.acceleration_noise)


def _spring_terms(channels: Mapping[str, np.ndarray]) -> Terms | None:
    if not {"spring_force", "pull_position", "position"} <= channels.keys():
        return None
    force, pull, position = (filled(channels[name])[0] for name in ("spring_force", "pull_position", "position"))
    return Terms(force, pull - position, np.ones((1, force.size)))


def _estimate(parts: list[Terms], known: float, std: float) -> float | None:
    """The known quantity by the records, where they contradict it."""
    factors, errors, noise = [], [], 0.0
    for force, factor, functions, deviation in parts:
        both, inner = np.vstack([factor, force - known * factor]), functions @ functions.T
        # The hat functions of one coordinate add to one: they depend on each other.
        inner += RIDGE * np.trace(inner) * np.eye(inner.shape[0])
        own, rest = both - np.linalg.solve(inner, functions @ both.T).T @ functions
        factors.append(own)
        errors.append(rest)
        noise += deviation**2 * own.size
    if sum(part.size for part in factors) < LEAST_ROWS:
        return None
    factor, error = np.concatenate(factors), np.concatenate(errors)
    power = float(factor @ factor)
    if power <= CLEAR * noise or power == 0.0:
        return None
    away = float(factor @ error) / power
    left = error - away * factor
    sums = np.array([block.sum() for block in np.array_split(factor * left, BLOCKS)])
    deviation = float(np.sqrt(sums @ sums * BLOCKS / (BLOCKS - 1.0))) / power
    contradicted = (
        abs(away) > SURE * np.hypot(deviation, std)
        and abs(away) > FAR * abs(known)
        and away**2 * power > NOTABLE * float(error @ error)
    )
    return known + away if contradicted else None
