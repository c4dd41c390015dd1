"""Do 95 % intervals cover the truth? An independent implementation of the very same laws, the true effect added."""

from __future__ import annotations

import json
import shutil
import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any

from benchmarks.scoring import share

ROOT = Path(__file__).resolve().parents[1]
# Name in the library: name in the generator. Only laws that both write the same way.
PARAMETERS = {
    "coulomb.force": "coulomb",
    "viscous.coefficient": "viscous",
    "stribeck.force": "stribeck",
    "stribeck.velocity": "stribeck_velocity",
    "quadratic_drag.coefficient": "quadratic",
    "constant_bias.force": "bias",
    "cable_spring.stiffness": "spring",
    "magnetic_cogging.amplitude": "cogging",
    "magnetic_cogging.pitch": "cogging_pitch",
    "direction_asymmetry.coulomb": "asymmetry",
}
EFFECTS = (
    "viscous",
    "stribeck",
    "quadratic_drag",
    "constant_bias",
    "cable_spring",
    "magnetic_cogging",
    "direction_asymmetry",
)


def _intervals(folder: Path, effect: str) -> dict[str, Any]:
    """Parameters with their intervals after the effect was added, from the rung it wrote."""
    done = subprocess.run(
        [sys.executable, "-m", "workbench.cli", "add", str(folder), effect, "--json", "--out", str(folder / "out")],
        cwd=ROOT,
        capture_output=True,
        text=True,
        timeout=300,
        check=False,
    )
    if done.returncode != 0:
        raise RuntimeError(done.stderr.strip()[-300:])
    rung = json.loads(max((folder / "ladder").glob("*.json")).read_text(encoding="utf-8"))
    return rung["parameters"]


def _covered(job: tuple[Path, dict[str, Any]]) -> list[tuple[str, bool]] | str:
    folder, entry = job
    try:
        found = _intervals(folder, entry["effect"])
    except Exception as error:
        return f"{folder.name} {entry['effect']}: {error}"
    out = []
    for name, value in found.items():
        truth = entry["truth"].get(PARAMETERS.get(name, ""), None)
        if truth is not None and value.get("low") is not None:
            out.append((name, float(value["low"]) <= truth <= float(value["high"])))
    return out


def coverage_table(count: int, seed: int, folder: Path, jobs: int) -> str:
    """Share of intervals that hold the truth, by parameter and in all, over `count` new experiments."""
    from generator import make_cases

    shutil.rmtree(folder, ignore_errors=True)
    key = make_cases(
        folder,
        seed + 5000,
        count,
        {"single": 1.0},
        hard=0.0,
        levels=("strong", "moderate"),
        effects=EFFECTS,
        jobs=jobs,
        same_form=True,
    )
    with ThreadPoolExecutor(jobs) as pool:
        results = list(pool.map(_covered, [(folder / name, entry) for name, entry in key.items()]))
    hits = [hit for result in results if not isinstance(result, str) for hit in result]
    lines = ["95 % intervals that hold the truth", f"  {'all':42s} {share(hit for _, hit in hits)}"]
    lines += [f"  {name:42s} {share(hit for n, hit in hits if n == name)}" for name in sorted({n for n, _ in hits})]
    return "\n".join(lines + [f"  failed: {result}" for result in results if isinstance(result, str)])
