"""Noise alone: Coulomb and viscous friction under imposed motion, with nothing missing; how many are `adequate`?

    python benchmarks/noise_alone.py --jobs 2
    python benchmarks/noise_alone.py --levels-only
    python benchmarks/noise_alone.py --unrelated

45 experiments, 15 for each autocorrelation (0, 0.9, 0.98) of first-order autoregressive noise; in 10 of 15 the noise is
stated. The records are computed here with numpy only. The table gives the verdicts, and the ratios of the estimated
standard deviation of the noise to the true one and to the rms of the noise in these records. That rms has the
relative standard deviation 1 / sqrt(2 n), with n = N (1 - c^2) / (1 + c^2) independent samples for the autocorrelation
c (Bayley and Hammersley, J. R. Stat. Soc. Suppl. 8 (1946) 184): 0.02 to 0.06 at c = 0.98, which is printed.

With `--unrelated` the force does not act on the motion beside it: ten kinds of a logged drive force, each with a motion
of its own. No effect may be named.
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


def write_case(
    folder: Path, random: np.random.Generator, correlation: float, stated: bool
) -> tuple[float, float, float]:
    """Write an experiment; returns the standard deviation of its noise, N, its rms over that, and the rms's spread."""
    rate, seconds = random.choice([200.0, 500.0, 1000.0]), random.uniform(15.0, 40.0)
    std = COULOMB * 10.0 ** random.uniform(-2.3, -1.0)
    folder.mkdir(parents=True)
    text = 'schema = 1\n[rig]\nkind = "velocity-drive"\n[model]\neffects = ["coulomb", "viscous"]\n'
    if stated:
        text += f'[noise]\nfriction_force = "{std:.6g} N"\n'
    motions, noises = [_multisine, _moves, _chirp], []
    for role in ("fit", "validate"):
        time = np.arange(int(rate * seconds)) / rate
        position = 0.5 * STROKE * motions[random.integers(3)](time, random)
        velocity = np.gradient(position, 1.0 / rate)
        # At rest the friction keeps its last direction.
        moving = np.maximum.accumulate(np.where(velocity != 0.0, np.arange(time.size), 0))
        force = COULOMB * np.sign(velocity[moving]) + VISCOUS * velocity
        noises.append(autoregressive(time.size, correlation, random))
        force += std * noises[-1]
        rows = np.column_stack([time, position, velocity, force])
        header = "time [s],position [m],velocity [m/s],friction_force [N]"
        np.savetxt(folder / f"{role}.csv", rows, delimiter=",", header=header, comments="", fmt="%.9g")
        text += f'[[record]]\nfile = "{role}.csv"\nrole = "{role}"\n'
    (folder / "experiment.toml").write_text(text, encoding="utf-8")
    noise = np.concatenate(noises)
    independent = noise.size * (1.0 - correlation**2) / (1.0 + correlation**2)
    return std, float(np.sqrt(np.mean(noise**2))), float(np.sqrt(0.5 / independent))


UNRELATED = {
    "square wave": lambda t, r: np.sign(np.sin(5.2 * t + r.uniform(0.0, 6.28))),
    "sine": lambda t, r: np.sin(4.1 * t + r.uniform(0.0, 6.28)),
    "sine of twice the frequency": lambda t, r: np.sin(2.0 * 1.95 * t + r.uniform(0.0, 6.28)),
    "triangle": lambda t, r: 2.0 / np.pi * np.arcsin(np.sin(3.3 * t + r.uniform(0.0, 6.28))),
    "chirp": lambda t, r: _chirp(t, r),
    "multisine": lambda t, r: _multisine(t, r),
    "steps": lambda t, r: np.repeat(r.uniform(-1.0, 1.0, t.size // 70 + 1), 70)[: t.size],
    "ramp": lambda t, r: r.uniform(0.5, 1.0) * t / t[-1],
    "slow noise": lambda t, r: autoregressive(t.size, 0.98, r),
    "white noise": lambda t, r: autoregressive(t.size, 0.0, r),
}
"""Drive forces, N, over the time of a record."""


def write_unrelated(folder: Path, random: np.random.Generator, kind: str) -> None:
    """Write an experiment whose logged drive force does not act on the motion beside it."""
    folder.mkdir(parents=True)
    text = 'schema = 1\n[rig]\nkind = "force-drive"\n[model]\neffects = ["coulomb", "viscous"]\n'
    text += '[noise]\ndrive_force = "0.01 N"\nposition = "1 um"\n'
    for role in ("fit", "validate"):
        time, phase = np.arange(2000) * 0.01, random.uniform(0.0, 6.28, 2)
        position = STROKE * (0.5 * np.sin(1.95 * time + phase[0]) + 0.3 * np.sin(3.58 * time + phase[1]))
        noisy = position + 1e-6 * random.standard_normal(time.size)
        force = 0.8 * UNRELATED[kind](time, random) + 0.01 * random.standard_normal(time.size)
        header = "time [s],position [m],drive_force [N]"
        rows = np.column_stack([time, noisy, force])
        np.savetxt(folder / f"{role}.csv", rows, delimiter=",", header=header, comments="", fmt="%.9g")
        text += f'[[record]]\nfile = "{role}.csv"\nrole = "{role}"\n'
    (folder / "experiment.toml").write_text(text, encoding="utf-8")


def _judge_unrelated(job: tuple[Path, int, int]) -> tuple[str, str, str]:
    """Kind of the drive, verdict, and the effect named."""
    folder, number, seed = job
    from sysid.diagnose import diagnose

    kind = list(UNRELATED)[number % len(UNRELATED)]
    write_unrelated(folder, np.random.default_rng([seed, number]), kind)
    found = diagnose(folder)
    return kind, found.verdict, found.effect or ""


def _judge(job: tuple[Path, int, int, bool]) -> tuple[float, bool, float, str, float, float]:
    """Autocorrelation, whether the noise is stated, ratio of estimated to true noise, verdict, ratio of estimated noise
    to that of the records, and the spread of the latter."""
    folder, number, seed, levels_only = job
    from sysid.diagnose import diagnose
    from sysid.experiment.experiment import load_experiment
    from sysid.experiment.record import load_records
    from sysid.noise.estimate import estimate_noise

    correlation, stated = CORRELATIONS[number // EACH], number % EACH < STATED
    std, rms, spread = write_case(folder, np.random.default_rng([seed, number]), correlation, stated)
    ratio = estimate_noise(load_records(load_experiment(folder)), "friction_force").value / std
    if levels_only:
        return correlation, stated, ratio, "", ratio / rms, spread
    found = diagnose(folder)
    return correlation, stated, ratio, f"{found.verdict} {found.effect or ''}".strip(), ratio / rms, spread


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--seed", type=int, default=31)
    parser.add_argument("--jobs", type=int, default=1)
    parser.add_argument("--only", type=int, nargs="*", help="numbers of experiments, 0 to 44")
    parser.add_argument("--levels-only", action="store_true", help="estimate the noise; no diagnosis")
    parser.add_argument("--unrelated", type=int, nargs="?", const=10, help="drive forces that do not act (10)")
    a = parser.parse_args()
    if a.unrelated:
        with tempfile.TemporaryDirectory() as scratch, process_pool(a.jobs) as pool:
            found = list(pool.map(_judge_unrelated, [(Path(scratch) / f"{k}", k, a.seed) for k in range(a.unrelated)]))
        for kind, verdict, effect in found:
            print(f"{kind}: {verdict} {effect}".strip())
        print(f"nothing named: {sum(not effect for _, _, effect in found)} of {len(found)}")
        return
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
            line = f"{number:2d} autocorrelation {row[0]:.2f}, {stated}: {row[3]} (level x {row[2]:.2f}; "
            line += f"of the records x {row[4]:.2f}, +-{row[5]:.3f})"
            print(line, file=sys.stderr, flush=True)
    for correlation in CORRELATIONS:
        for stated in (True, False):
            own = [row for row in rows if row[:2] == (correlation, stated)]
            if own:
                level = "estimated level over true level, and over that of the records"
                for column in (2, 4):
                    level += "".join(
                        f" {one:.2f}" for one in np.quantile([row[column] for row in own], [0.0, 0.5, 1.0])
                    )
                good = "" if a.levels_only else f"adequate {sum(row[3] == 'adequate' for row in own)} of {len(own)}; "
                print(f"autocorrelation {correlation:.2f}, noise {'stated' if stated else 'estimated'}: {good}{level}")
    if not a.levels_only:
        print(f"adequate: {sum(row[3] == 'adequate' for row in rows)} of {len(rows)}")


if __name__ == "__main__":
    main()
