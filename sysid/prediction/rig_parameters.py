"""Rig parameters: known ones are fixed, unknown ones are estimated from the records and fitted."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence

import numpy as np

from stagecad.parameters.errors import InputError
from sysid.experiment.experiment import Experiment
from sysid.experiment.record import Record
from sysid.experiment.unknowns import Prior, Unknown
from sysid.noise.estimate import Noise
from sysid.prediction.force_balance.prepare import driven_mass
from sysid.prediction.friction_drive.parameters import friction_drive_parameters
from sysid.signals.gaussian_filter import GaussianFilter, NoiseSpectrum
from sysid.signals.masks import filled
from sysid.signals.resampling import uniform

LEAST_ROWS = 200
"""Scored rows below which a mass is not read off a record."""


def rig_parameters(
    experiment: Experiment, records: Sequence[Record], noise: Mapping[str, Noise]
) -> tuple[dict[str, float], list[Unknown]]:
    """Rig parameters, and those among them that are unknown or uncertain and therefore fitted."""
    known, kind = experiment.rig.known, experiment.rig.kind
    values: dict[str, float] = {}
    unknowns: list[Unknown] = []

    def put(name: str, guess: Callable[[], float], known_as: str | None = None) -> None:
        given = known.get(known_as or name)
        value = given.value if given is not None else guess()
        values[f"rig.{name}"] = value
        if given is None:
            unknowns.append(Unknown(f"rig.{name}", value, 1e-3 * abs(value), 1e3 * abs(value), abs(value)))
        elif given.std:
            reach = 3.0 * given.std
            prior = Prior(value, given.std)
            unknowns.append(Unknown(f"rig.{name}", value, value - reach, value + reach, given.std, prior))

    if kind == "spring-pull":
        put("pull_stiffness", lambda: _guess_stiffness(records))
    if kind in ("spring-pull", "force-drive"):
        put("mass", lambda: _guess_mass(records, kind, values.get("rig.pull_stiffness"), noise))
    if kind == "friction-drive":
        fits = [r for r in records if r.role == "fit"]
        drive, free = friction_drive_parameters(known, fits)
        values.update(drive)
        unknowns.extend(free)
    if kind == "actuator-tip":
        fits = [r for r in records if r.role == "fit"]
        rows = {c: np.concatenate([r.channels[c] for r in fits]) for c in fits[0].channels}
        spread = max(float(np.nanstd(v)) for c, v in rows.items() if c.startswith("voltage"))
        size = max(float(np.nanstd(v)) for c, v in rows.items() if c.startswith("tip"))
        gain = size / max(spread, 1e-300)
        values["rig.gain"] = gain
        unknowns.append(Unknown("rig.gain", gain, 0.0, np.inf, gain))
        for channel in ("tip_x", "tip_y", "tip_z"):
            if channel in rows:
                offset = float(np.nanmean(rows[channel]))
                values[f"rig.offset_{channel}"] = offset
                unknowns.append(Unknown(f"rig.offset_{channel}", offset, -np.inf, np.inf, size))
    return values, unknowns


def _guess_stiffness(records: Sequence[Record]) -> float:
    """Slope of spring force over stretch, where both are measured."""
    for record in records:
        c = record.channels
        if {"pull_position", "position", "spring_force"} <= set(c):
            stretch, force = c["pull_position"] - c["position"], c["spring_force"]
            ok = np.isfinite(stretch) & np.isfinite(force)
            if np.ptp(stretch[ok]) > 0:
                return abs(float(np.polyfit(stretch[ok], force[ok], 1)[0])) or 1.0
    raise InputError(
        f"{records[0].file}: without rig.known.pull_stiffness both 'position' and 'spring_force' must be recorded, "
        "since the stiffness is then read off them"
    )


def _is_driven(record: Record) -> bool:
    """Whether the record is no coast-down or free oscillation, in which the drive force never changes."""
    force = record.channels.get("drive_force")
    return force is None or np.nanmax(force) > np.nanmin(force)


def _guess_mass(records: Sequence[Record], kind: str, stiffness: float | None, noise: Mapping[str, Noise]) -> float:
    """Mass from the force balance: the force regressed on acceleration, direction, velocity and one."""
    best = 1.0
    driven = [r for r in records if r.role == "fit" and _is_driven(r)]
    if not driven:
        raise InputError(
            f"{records[0].file}: column 'drive_force' does not change; without rig.known.mass only the ratio of the "
            "forces to the mass is identifiable: give it, or a record that is driven"
        )
    for record in driven[:1]:
        best = mass = _largest_mass(record, kind, stiffness, noise)
        for _ in range(4):
            balance = driven_mass(record, kind, noise, mass, stiffness)
            y, ok = balance.force, balance.valid[balance.force_channel]
            if ok.sum() < LEAST_ROWS:
                # A filter as wide as this guess requires leaves nothing between the gaps.
                mass *= 0.1
                continue
            assert (
                balance.acceleration is not None and balance.full_filter is not None and balance.direction is not None
            )
            columns = [
                balance.acceleration,
                balance.full_filter(balance.direction),
                balance.axis.velocity,
                np.ones(y.size),
            ]
            solution, *_ = np.linalg.lstsq(np.column_stack([c[ok] for c in columns]), y[ok], rcond=None)
            best = float(solution[0]) if solution[0] > 0 else mass
            if abs(best - mass) < 0.01 * best:
                break
            mass = best
    return best


def _largest_mass(record: Record, kind: str, stiffness: float | None, noise: Mapping[str, Noise]) -> float:
    """Mass that would need all of the force: its size over that of the acceleration, where that exceeds its noise.

    An upper guess: it sets how wide a filter the first estimate of the mass begins with.
    """
    _, step, channels, _ = uniform(record)
    found = _motion_and_force({name: filled(values)[0] for name, values in channels.items()}, kind, stiffness, noise)
    if found is None:
        return 1.0
    position, force, sigma, spectrum = found
    width = step
    while width < position.size * step / 40.0:
        complementary_filter = GaussianFilter(width, step, position.size)
        acceleration = float(np.std(complementary_filter(position, 2)))
        if sigma * complementary_filter.noise_gain(2, spectrum) < 0.2 * acceleration:
            return float(np.std(force)) / acceleration
        width *= 2.0
    return 1.0


def _motion_and_force(
    channels: Mapping[str, np.ndarray], kind: str, stiffness: float | None, noise: Mapping[str, Noise]
) -> tuple[np.ndarray, np.ndarray, float, NoiseSpectrum] | None:
    """Position and force (n,) of a driven mass, with deviation and spectrum of the position's noise.

    For a body pulled by a spring one of the two follows from the other and the stiffness.
    """
    position, pull = channels.get("position"), channels.get("pull_position")
    force = channels.get("drive_force" if kind == "force-drive" else "spring_force")
    if pull is not None and stiffness is not None:
        if position is None and force is not None:
            known = noise["spring_force"]
            return pull - force / stiffness, force, known.value / stiffness, known.spectrum
        if position is not None and force is None:
            force = stiffness * (pull - position)
    return (
        None
        if position is None or force is None
        else (position, force, noise["position"].value, noise["position"].spectrum)
    )
