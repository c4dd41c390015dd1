"""Noise alone: Coulomb and viscous friction under imposed motion, with nothing missing; how many are `adequate`?

    python benchmarks/noise_alone.py --jobs 2
    python benchmarks/noise_alone.py --levels-only

45 experiments, 15 for each autocorrelation (0, 0.9, 0.98) of first-order autoregressive noise; in 10 of 15 the noise is
stated. The records are computed here with numpy only. The table gives the verdicts, and the ratio of the estimated
standard deviation of the noise to the true one.
"""

import argparse
import sys
import tempfile
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))

from benchmarks.pool import process_pool

CORRELATIONS = (0.0, 0.9, 0.98)
EACH = 15
STATED = 10
COULOMB, VISCOUS = 3.0, 12.0  # N, N s/m
STROKE = 0.03  # m


def _multisine(time: np.ndarray, random: np.random.Generator) -> np.ndarray:
    waves = [(0.07 * 1.7**k * random.uniform(0.9, 1.1), random.uniform(0.0, 6.28)) for k in range(5)]
    return sum((np.sin(2 * np.pi * f * time + p) / (1 + k) for k, (f, p) in enumerate(waves)), np.zeros(time.size))


def _moves(time: np.ndarray, random: np.random.Generator) -> np.ndarray:
    """Moves with a cosine profile of velocity to random places, some with a rest between them."""
    edges, places = [0.0], [0.0]
    while edges[-1] < time[-1]:
        edges.append(edges[-1] + random.uniform(0.6, 2.5))
        places.append(random.uniform(-1.0, 1.0) if random.uniform() > 0.2 else places[-1])
    k = np.clip(np.searchsorted(edges, time, side="right") - 1, 0, len(edges) - 2)
    start, end = np.array(edges)[k], np.array(edges)[k + 1]
    u = (time - start) / (end - start)
    return np.array(places)[k] + np.diff(places)[k] * (u - np.sin(2 * np.pi * u) / (2 * np.pi))


def _chirp(time: np.ndarray, random: np.random.Generator) -> np.ndarray:
    low, high = random.uniform(0.05, 0.1), random.uniform(0.5, 1.5)
    return np.sin(2 * np.pi * (low * time + 0.5 * (high - low) * time**2 / time[-1]))


def autoregressive(size: int, correlation: float, random: np.random.Generator) -> np.ndarray:
    """Stationary first-order autoregression (size,) of unit standard deviation."""
    out = random.standard_normal(size)
    drive = np.sqrt(1.0 - correlation**2)
    for i in range(1, size):
        out[i] = correlation * out[i - 1] + drive * out[i]
    return out


def write_case(folder: Path, random: np.random.Generator, correlation: float, stated: bool) -> float:
    """Write an experiment; returns the standard deviation of its noise, N."""
    rate, seconds = random.choice([200.0, 500.0, 1000.0]), random.uniform(15.0, 40.0)
    std = COULOMB * 10.0 ** random.uniform(-2.3, -1.0)
    folder.mkdir(parents=True)
    text = 'schema = 1\n[rig]\nkind = "velocity-drive"\n[model]\neffects = ["coulomb", "viscous"]\n'
    if stated:
        text += f'[noise]\nfriction_force = "{std:.6g} N"\n'
    motions = [_multisine, _moves, _chirp]
    for role in ("fit", "validate"):
        time = np.arange(int(rate * seconds)) / rate
        position = 0.5 * STROKE * motions[random.integers(3)](time, random)
        velocity = np.gradient(position, 1.0 / rate)
        # At rest the friction keeps its last direction.
        moving = np.maximum.accumulate(np.where(velocity != 0.0, np.arange(time.size), 0))
        force = COULOMB * np.sign(velocity[moving]) + VISCOUS * velocity
        force += std * autoregressive(time.size, correlation, random)
        rows = np.column_stack([time, position, velocity, force])
        header = "time [s],position [m],velocity [m/s],friction_force [N]"
        np.savetxt(folder / f"{role}.csv", rows, delimiter=",", header=header, comments="", fmt="%.9g")
        text += f'[[record]]\nfile = "{role}.csv"\nrole = "{role}"\n'
    (folder / "experiment.toml").write_text(text, encoding="utf-8")
    return std


def _judge(job: tuple[Path, int, int, bool]) -> tuple[float, bool, float, str]:
    """Autocorrelation, whether the noise is stated, ratio of estimated to true noise, and verdict."""
    folder, number, seed, levels_only = job
    from sysid.diagnose import diagnose
    from sysid.experiment.experiment import load_experiment
    from sysid.experiment.record import load_records
    from sysid.noise.estimate import estimate_noise

    correlation, stated = CORRELATIONS[number // EACH], number % EACH < STATED
    std = write_case(folder, np.random.default_rng([seed, number]), correlation, stated)
    ratio = estimate_noise(load_records(load_experiment(folder)), "friction_force").value / std
    if levels_only:
        return correlation, stated, ratio, ""
    found = diagnose(folder)
    return correlation, stated, ratio, f"{found.verdict} {found.effect or ''}".strip()


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--seed", type=int, default=31)
    parser.add_argument("--jobs", type=int, default=1)
    parser.add_argument("--only", type=int, nargs="*", help="numbers of experiments, 0 to 44")
    parser.add_argument("--levels-only", action="store_true", help="estimate the noise; no diagnosis")
    a = parser.parse_args()
    numbers = a.only if a.only else range(EACH * len(CORRELATIONS))
    with (
        tempfile.TemporaryDirectory() as scratch,
        process_pool(a.jobs) as pool,
    ):
        jobs = [(Path(scratch) / f"case{k:03d}", k, a.seed, a.levels_only) for k in numbers]
        rows = []
        for number, row in zip(numbers, pool.map(_judge, jobs), strict=True):
            rows.append(row)
            stated = "stated" if row[1] else "estimated"
            line = f"{number:2d} autocorrelation {row[0]:.2f}, {stated}: {row[3]} (level x {row[2]:.2f})"
            print(line, file=sys.stderr, flush=True)
    for correlation in CORRELATIONS:
        for stated in (True, False):
            own = [row for row in rows if row[:2] == (correlation, stated)]
            if own:
                low, middle, high = np.quantile([row[2] for row in own], [0.0, 0.5, 1.0])
                level = f"estimated level over true level {low:.2f} {middle:.2f} {high:.2f}"
                good = "" if a.levels_only else f"adequate {sum(row[3] == 'adequate' for row in own)} of {len(own)}; "
                print(f"autocorrelation {correlation:.2f}, noise {'stated' if stated else 'estimated'}: {good}{level}")
    if not a.levels_only:
        print(f"adequate: {sum(row[3] == 'adequate' for row in rows)} of {len(rows)}")


if __name__ == "__main__":
    main()
