"""Coverage of the 95 % intervals, with an independent implementation of the same laws and the true effect added.

    python benchmarks/hidden_effects.py --cases 0 --coverage 300 --jobs 2
    python benchmarks/interval_coverage.py --autocorrelation 0 0.9 0.98 --cases 60

Only laws that the generator has in the form of the library are used; plain records and hard ones (coloured noise, gaps,
other units and rates, rotary axes, a mass that is uncertain or absent) are counted apart. The share of intervals that
contain the true value is printed beside the robust deviation of (value - truth)/std, which is 1 for correct intervals,
less where they are too wide, and more where they are too narrow.

With `--autocorrelation` the records are those of `noise_alone.py`: Coulomb and viscous friction, nothing missing.
"""

import argparse
import contextlib
import io
import json
import shutil
import sys
import tempfile
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from statistics import median
from typing import Any

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))

from benchmarks.pool import process_pool
from benchmarks.scoring import plain, share

# What a parameter of the library is in the generator's own words: `t` its truth, `s` its sensor, `r` the drum's radius,
# which turns a force into a torque (1 on a linear axis).
TRUTHS: dict[str, Callable[[dict[str, float], dict[str, float], float], float]] = {
    "coulomb.force": lambda t, s, r: t["coulomb"] * r,
    "viscous.coefficient": lambda t, s, r: t["viscous"] * r * r,
    "stribeck.force": lambda t, s, r: t["stribeck"] * r,
    "stribeck.velocity": lambda t, s, r: t["stribeck_velocity"] / r,
    "quadratic_drag.coefficient": lambda t, s, r: t["quadratic"] * r**3,
    "constant_bias.force": lambda t, s, r: t["bias"] * r,
    "cable_spring.stiffness": lambda t, s, r: t["spring"] * r * r,
    "magnetic_cogging.amplitude": lambda t, s, r: t["cogging"] * r,
    "magnetic_cogging.pitch": lambda t, s, r: t["cogging_pitch"] / r,
    "gravity_torque.amplitude": lambda t, s, r: t["gravity"] * r,
    "direction_asymmetry.coulomb": lambda t, s, r: t["asymmetry"],
    "direction_asymmetry.viscous": lambda t, s, r: 0.0,
    "backlash.gap": lambda t, s, r: t["backlash"] / r,
    "drive_lag.time_constant": lambda t, s, r: t["drive_lag"],
    "drive_delay.delay": lambda t, s, r: t["drive_delay"],
    "sensor_lag.time_constant": lambda t, s, r: s["lag"],
    "sensor_delay.delay": lambda t, s, r: s["delay"],
    "rig.mass": lambda t, s, r: t["mass"] * r * r,
    "rig.gain": lambda t, s, r: t["gain"] * (1.0 - 0.5 * t["mismatch"]),
    "gain_mismatch.mismatch": lambda t, s, r: (1.0 + 0.5 * t["mismatch"]) / (1.0 - 0.5 * t["mismatch"]) - 1.0,
    "rig.offset_tip_x": lambda t, s, r: t["offset_x"],
    "rig.offset_tip_y": lambda t, s, r: t["offset_y"],
}
EFFECTS = (
    "viscous",
    "stribeck",
    "quadratic_drag",
    "constant_bias",
    "cable_spring",
    "magnetic_cogging",
    "direction_asymmetry",
    "gravity_torque",
    "backlash",
    "drive_lag",
    "drive_delay",
    "gain_mismatch",
    "sensor_lag",
    "sensor_delay",
)


@dataclass(frozen=True)
class Told:
    """One fitted value beside its truth: `off` is (value - truth)/std; `covered` none where no interval was given."""

    case: str
    rig: str
    hard: bool
    effect: str
    key: str
    off: float
    covered: bool | None


def _parameters(folder: Path, effect: str) -> dict[str, Any]:
    """Parameters with their intervals after the effect was added, from the rung it wrote."""
    from workbench.cli import run

    errors = io.StringIO()
    with contextlib.redirect_stdout(io.StringIO()), contextlib.redirect_stderr(errors):
        code = run(["add", str(folder), effect, "--json", "--out", str(folder / "out")])
    if code != 0:
        raise RuntimeError(errors.getvalue().strip()[-300:])
    return json.loads(max((folder / "ladder").glob("*.json")).read_text(encoding="utf-8"))["parameters"]


def _told(job: tuple[Path, dict[str, Any]]) -> list[Told] | str:
    folder, entry = job
    try:
        found = _parameters(folder, entry["effect"])
    except Exception as error:
        return f"{folder.name} {entry['rig']} {entry['effect']}: {error}"
    out = []
    radius = float(entry["truth"]["gravity_radius"]) if entry["rotary"] else 1.0
    for name, value in found.items():
        effect, _, parameter = name.rpartition(".")
        known = TRUTHS.get(f"{plain(effect)}.{parameter}")
        if known is None:
            continue
        truth = known(entry["truth"], entry["sensor"], radius)
        told = value.get("low") is not None and value.get("high") is not None
        out.append(
            Told(
                folder.name, entry["rig"], bool(entry["hard"]), entry["effect"], f"{plain(effect)}.{parameter}",
                (value["value"] - truth) / value["std"] if told else 0.0,
                float(value["low"]) <= truth <= float(value["high"]) if told else None,
            )
        )  # fmt: skip
    return out


def _line(title: str, rows: list[Told]) -> str:
    with_interval = [row for row in rows if row.covered is not None]
    if not with_interval:
        return f"  {title:36s} no interval given"
    spread = 1.4826 * median(abs(row.off) for row in with_interval)
    silent = len(rows) - len(with_interval)
    tail = f", {silent} without an interval" if silent else ""
    return f"  {title:36s} {share(bool(row.covered) for row in with_interval):36s} deviation {spread:.2f}{tail}"


def coverage_table(count: int, seed: int, folder: Path, jobs: int, hard: float = 0.35) -> str:
    """Share of intervals that hold the truth, in all, by rig and by parameter, over `count` new experiments."""
    from benchmarks.generators.hidden_effect import make_cases

    shutil.rmtree(folder, ignore_errors=True)
    key = make_cases(
        folder, seed + 5000, count, {"single": 1.0}, hard=hard, levels=("strong", "moderate"), effects=EFFECTS,
        jobs=jobs, same_form=True,
    )  # fmt: skip
    rows: list[Told] = []
    failed: list[str] = []
    with process_pool(jobs) as pool:
        for k, result in enumerate(pool.map(_told, [(folder / name, entry) for name, entry in key.items()]), 1):
            if isinstance(result, str):
                failed.append(result)
            else:
                rows += result
            print(f"{k}/{count}", file=sys.stderr, flush=True)
    groups: list[tuple[str, list[Told]]] = [("all", rows)]
    groups += [(name, [r for r in rows if r.hard == is_hard]) for name, is_hard in (("plain", False), ("hard", True))]
    groups += [(rig, [r for r in rows if r.rig == rig]) for rig in sorted({r.rig for r in rows})]
    groups += [(name, [r for r in rows if r.key == name]) for name in sorted({r.key for r in rows})]
    lines = [
        "95 % intervals that contain the true value (target: 90 to 98 % of them)",
        *(_line(title, chosen) for title, chosen in groups),
    ]
    lines += ["missed", *(
        f"  {r.case} {r.rig} {r.effect}{' hard' if r.hard else ''}: {r.key} off by {r.off:+.1f} deviations"
        for r in rows if r.covered is False
    )]  # fmt: skip
    return "\n".join(lines + [f"  failed: {text}" for text in failed])


def _noise_alone(job: tuple[Path, float, int]) -> list[Told]:
    """Intervals of the friction values of one record of noise of a given autocorrelation."""
    import numpy as np

    from benchmarks.noise_alone import COULOMB, VISCOUS, write_case
    from sysid.estimation.covariance import intervals
    from sysid.estimation.reference_fit import fit_stated_model
    from sysid.prediction.problem import load_problem

    folder, correlation, number = job
    write_case(folder, np.random.default_rng([4711, number]), correlation, True)
    problem = load_problem(folder)
    known = intervals(fit_stated_model(problem).fitted, problem.fit_records).by_key
    out = []
    for key, truth in (("coulomb.force", COULOMB), ("viscous.coefficient", VISCOUS)):
        found = known[key]
        off, covered = (found.value - truth) / found.std, found.low <= truth <= found.high
        out.append(Told(folder.name, "velocity-drive", False, "none", key, off, covered))
    return out


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--autocorrelation", type=float, nargs="+", default=[0.0, 0.9, 0.98])
    parser.add_argument("--cases", type=int, default=60, help="of each autocorrelation")
    parser.add_argument("--jobs", type=int, default=1)
    a = parser.parse_args()
    with (
        tempfile.TemporaryDirectory() as scratch,
        process_pool(a.jobs) as pool,
    ):
        for correlation in a.autocorrelation:
            jobs = [(Path(scratch) / f"{correlation}_{k}", correlation, k) for k in range(a.cases)]
            rows = [row for told in pool.map(_noise_alone, jobs) for row in told]
            print(_line(f"autocorrelation {correlation}", rows), flush=True)


if __name__ == "__main__":
    main()
