"""Noise as instruments have it, logs as people keep them: coloured, uneven, outliers, gaps, odd rates and units."""

from dataclasses import dataclass

import numpy as np
import pandas as pd
from scipy.signal import lfilter


@dataclass(frozen=True)
class Nuisance:
    """How a case is spoilt. `kind` is plain, outliers or spread; `colour` the correlation of noise over 1 ms."""

    kind: str = "plain"
    colour: float = 0.0
    gaps: bool = False
    other_units: bool = False
    decimate: int = 1
    drop: float = 0.0
    noise_given: bool = True
    few_columns: bool = False
    velocity_only: bool = False
    mass: str = "known"


def draw_nuisance(rng: np.random.Generator, rig: str, kind: str, *, hard: bool) -> Nuisance:
    """Nuisances of a case; a hard one has most of them."""
    given = bool(rng.random() < 0.55)
    if not hard:
        return Nuisance(kind, noise_given=given)
    rate = rng.random() if rig != "force-drive" else 1.0
    return Nuisance(
        kind,
        colour=float(rng.uniform(0.5, 0.93)) if rng.random() < 0.6 else 0.0,
        gaps=bool(rng.random() < 0.45),
        other_units=bool(rng.random() < 0.45),
        decimate=2 if rate < 0.2 else 1,
        drop=float(rng.uniform(0.02, 0.08)) if 0.2 <= rate < 0.4 else 0.0,
        noise_given=given,
        few_columns=bool(rng.random() < 0.25),
        velocity_only=bool(rng.random() < 0.5),
        mass=str(rng.choice(["known", "known", "known", "uncertain", "absent"])),
    )


def noise(rng: np.random.Generator, rows: int, sigma: float, how: Nuisance) -> np.ndarray:
    """Noise of standard deviation `sigma` (outliers come on top of it)."""
    if how.colour > 0.0:
        white = rng.standard_normal(rows + 300)
        e = np.asarray(lfilter([np.sqrt(1.0 - how.colour**2)], [1.0, -how.colour], white))[300:]
    else:
        e = rng.standard_normal(rows)
    if how.kind == "spread":
        t = np.arange(rows) / rows
        size = np.exp(0.6 * np.sin(2 * np.pi * (rng.uniform(0.7, 4.0) * t + rng.random())))
        if rng.random() < 0.4:
            size *= np.where((t > rng.uniform(0.2, 0.5)) & (t < rng.uniform(0.5, 0.8)), 1.8, 1.0)
        e = e * size / np.sqrt(np.mean(size**2))
    e = sigma * e
    if how.kind == "outliers":
        hit = rng.random(rows) < rng.uniform(0.0008, 0.004)
        e[hit] += sigma * rng.choice([-1.0, 1.0], hit.sum()) * rng.uniform(5.0, 20.0, hit.sum())
    return e


def channel_load(rng: np.random.Generator, rows: int) -> np.ndarray:
    """A load between 5 and 15 N that comes and goes."""
    t = np.arange(rows) * 1e-3
    slow, fast = rng.uniform(0.08, 0.25), rng.uniform(0.6, 1.6)
    waves = (3.3, slow), (1.7, fast)
    return np.full(rows, 10.0) + sum(size * np.sin(2 * np.pi * (f * t + rng.random())) for size, f in waves)


def channel_temperature(rng: np.random.Generator, rows: int) -> np.ndarray:
    """A machine that warms up from 21 degC."""
    t = np.arange(rows) * 1e-3
    return 21.0 + rng.uniform(6.0, 16.0) * (1.0 - np.exp(-t / rng.uniform(4.0, 14.0)))


_UNITS = {
    "s": [("ms", 1e3)],
    "m": [("mm", 1e3), ("um", 1e6)],
    "rad": [("deg", 180.0 / np.pi), ("mrad", 1e3)],
    "N": [("mN", 1e3)],
    "N*m": [("mN*m", 1e3)],
    "m/s": [("mm/s", 1e3)],
    "rad/s": [("deg/s", 180.0 / np.pi)],
}


def as_logged(
    rng: np.random.Generator,
    columns: dict[str, tuple[str, np.ndarray]],
    measured: list[str],
    how: Nuisance,
    units: dict[str, tuple[str, float]],
) -> pd.DataFrame:
    """The table as it is written: `columns` maps a name to (SI unit, values); headers read `name [unit]`."""
    rows = columns["time"][1].size
    keep = np.arange(0, rows, how.decimate)
    if how.drop > 0.0:
        keep = keep[(rng.random(keep.size) >= how.drop) | (keep == 0)]
    out: dict[str, np.ndarray] = {}
    for name, (unit, values) in columns.items():
        text, factor = units.get(name, (unit, 1.0))
        column = values[keep] * factor
        if how.gaps and name in measured:
            for _ in range(int(rng.integers(2, 6))):
                start = int(rng.integers(1, column.size - 160))
                column[start : start + int(np.exp(rng.uniform(np.log(2), np.log(140))))] = np.nan
        out[f"{name} [{text}]"] = column
    return pd.DataFrame(out)


def draw_units(rng: np.random.Generator, columns: dict[str, str], how: Nuisance) -> dict[str, tuple[str, float]]:
    """Other units for some of the columns (`name` to SI unit), as `name` to (unit, factor)."""
    if not how.other_units:
        return {}
    chosen: dict[str, tuple[str, float]] = {}
    for name, unit in columns.items():
        choices = _UNITS.get(unit, [])
        if choices and rng.random() < 0.6:
            text, factor = choices[int(rng.integers(len(choices)))]
            chosen[name] = (text, factor)
    return chosen
