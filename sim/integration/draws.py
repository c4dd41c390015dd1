"""Many simulations of one model with drawn parameters, spread over the processor's cores."""

from __future__ import annotations

import math
import os
from collections.abc import Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from typing import Any

import numpy as np

from sim.integration.drive import Drive
from sim.integration.simulate import SimulationError, simulate
from sim.library.model import compose
from stagecad.parameters.errors import InputError


@dataclass(frozen=True)
class Draws:
    """Motions of a model under drawn parameters. SI units.

    Args:
        time: s, shape (n,).
        position, velocity: m and m/s, shape (draws, n); NaN throughout for a draw that failed.
        failures: of each draw that failed, its number and the reason.
    """

    time: np.ndarray
    position: np.ndarray
    velocity: np.ndarray
    failures: dict[int, str]


def simulate_draws(
    effects: Sequence[str],
    values: Mapping[str, np.ndarray],
    drive: Drive,
    time: Any,
    *,
    mass: Any = 1.0,
    load: float = math.nan,
    temperature: float = math.nan,
    tolerance: float = 1e-8,
    most_steps: int = 2_000_000,
    workers: int | None = None,
) -> Draws:
    """Simulate a model once for each row of drawn parameter values.

    Compiled integration leaves Python's lock alone, so threads share kernels and memory and still use every core.

    Args:
        effects: names, as for `sim.compose`.
        values: drawn values by `effect.parameter`, SI, each of shape (draws,); the rest keep their defaults.
        drive, time, load, temperature, tolerance, most_steps: as for `sim.simulate`.
        mass: kg, one for all or of shape (draws,).
        workers: threads; by default one for each core this process may use.

    Raises:
        InputError: arrays of different lengths, or as `sim.compose` and `sim.simulate`. A simulation that stops is no
            error: it is named in `failures`.
    """
    sizes = {key: np.asarray(column, dtype=float).shape for key, column in values.items()}
    if not sizes or len(set(sizes.values())) != 1 or len(next(iter(sizes.values()))) != 1:
        raise InputError(f"draws: one array of values for each parameter, all of one length; got shapes {sizes}")
    count = next(iter(sizes.values()))[0]
    masses = np.broadcast_to(np.asarray(mass, dtype=float), (count,))
    t = np.ascontiguousarray(time, dtype=float)
    columns = {key: np.asarray(column, dtype=float) for key, column in values.items()}
    position, velocity = np.full((count, t.size), math.nan), np.full((count, t.size), math.nan)
    failures: dict[int, str] = {}

    def run(k: int) -> None:
        model = compose(effects, {key: float(column[k]) for key, column in columns.items()})
        try:
            found = simulate(
                model, drive, t, mass=float(masses[k]), load=load, temperature=temperature, tolerance=tolerance,
                most_steps=most_steps, forces=False,
            )  # fmt: skip
        except SimulationError as error:
            failures[k] = str(error)
            return
        position[k], velocity[k] = found.position, found.velocity

    if count:
        run(0)  # compiles what is not compiled yet, once
    with ThreadPoolExecutor(workers or _cores()) as pool:
        list(pool.map(run, range(1, count)))
    return Draws(t, position, velocity, dict(sorted(failures.items())))


def _cores() -> int:
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1
