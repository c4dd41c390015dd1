"""Time and memory of a ranking and of a diagnosis, and how they grow with the samples, on every kind of rig.

    python benchmarks/loop_growth.py [--rows 5000 20000 80000] [--rigs velocity-drive ...]

Two records of so many rows each, a strong effect hidden in them, the full list of effects, each measurement in a new
process. *Ranking*: every effect of the list scored on top of the fitted model and put in order. *Diagnosis*: the whole
command, from the start of Python to the document on disk: reading, noise, base fit, ranking, refits, pairs, verdict.
Asked of two records of 20 000 rows on two cores: ranking in 3 s, diagnosis in 10 s, below 1 GB, growth no faster than
the samples. Processor seconds are those of all threads; on a machine that does other things, they are what counts.
"""

import argparse
import json
import math
import os
import subprocess
import sys
import tempfile
import time
from dataclasses import dataclass
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
sys.path[:0] = [str(ROOT)]

RIGS = {
    "velocity-drive": "stribeck",
    "spring-pull": "viscous",
    "force-drive": "constant_bias",
    "actuator-tip": "piezo_creep",
}
ASKED_ROWS, ASKED_RANKING, ASKED_DIAGNOSIS, ASKED_MEGABYTES = 20000, 3.0, 10.0, 1000.0

RANK = """
import json, sys
from time import perf_counter, process_time
from sysid.prediction.problem import load_problem
from sysid.estimation.reference_fit import fit_stated_model
from sysid.diagnosis.candidate_screening import screen_all
problem = load_problem(sys.argv[1])
base = fit_stated_model(problem)
clock, processor = perf_counter(), process_time()
screening = screen_all(problem, base)
print("used", process_time() - processor, perf_counter() - clock, len(screening.fits))
"""
DIAGNOSE = """
import resource, sys
from workbench.cli import run
status = run(["diagnose", sys.argv[1], "--no-figures", "--out", sys.argv[2], "--json", sys.argv[3]])
if status:
    sys.exit(status)
u = resource.getrusage(resource.RUSAGE_SELF)
print("used", u.ru_utime + u.ru_stime, u.ru_maxrss / 1024.0)
"""


@dataclass(frozen=True)
class Used:
    """What one experiment cost: processor seconds, seconds on the clock, MB, effects ranked, and what was found."""

    rows: int
    ranking: float
    ranking_clock: float
    effects: int
    diagnosis: float
    diagnosis_clock: float
    megabytes: float
    found: str


def _run(code: str, *arguments: str) -> tuple[list[float], float]:
    began = time.perf_counter()
    done = subprocess.run(
        [sys.executable, "-c", code, *arguments],
        cwd=ROOT, capture_output=True, text=True, check=False, env={**os.environ, "PYTHONPATH": str(ROOT)},
    )  # fmt: skip
    seconds = time.perf_counter() - began
    used = [line.split()[1:] for line in done.stdout.splitlines() if line.startswith("used ")]
    if done.returncode != 0 or not used:
        raise RuntimeError(done.stderr.strip()[-400:])
    return [float(number) for number in used[-1]], seconds


def measured(folder: Path, rows: int) -> Used:
    """The ranking and the diagnosis of one experiment, each in a process of its own."""
    (ranking, ranking_clock, effects), _ = _run(RANK, str(folder))
    document = folder / "diagnosis.json"
    (diagnosis, megabytes), clock = _run(DIAGNOSE, str(folder), str(folder / "out"), str(document))
    found = json.loads(document.read_text(encoding="utf-8"))
    return Used(
        rows, ranking, ranking_clock, int(effects), diagnosis, clock, megabytes, found["effect"] or found["verdict"]
    )


def line(rig: str, used: Used) -> str:
    """One row of the table, with the targets where the number of rows is the one that they apply to."""
    text = (
        f"{rig:16s} {used.rows:8d} {used.effects:8d} {used.ranking:9.1f} {used.ranking_clock:7.1f}"
        f" {used.diagnosis:11.1f} {used.diagnosis_clock:7.1f} {used.megabytes:9.0f}  {used.found}"
    )
    if used.rows != ASKED_ROWS:
        return text
    over = [
        name
        for name, value, most in (
            ("ranking", used.ranking_clock, ASKED_RANKING),
            ("diagnosis", used.diagnosis_clock, ASKED_DIAGNOSIS),
            ("memory", used.megabytes, ASKED_MEGABYTES),
        )
        if value > most
    ]
    return text + (f"  above the target of time or memory: {', '.join(over)}" if over else "  within the targets")


def exponent(used: list[Used], what: str) -> float:
    """Growth of a cost between the fewest rows and the most, as a power of the rows."""
    first, last = used[0], used[-1]
    return math.log(getattr(last, what) / getattr(first, what)) / math.log(last.rows / first.rows)


def main() -> None:
    import numpy as np

    from benchmarks.generators.hidden_effect import Plan, make_case

    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--rows", type=int, nargs="+", default=[5000, 20000, 80000])
    parser.add_argument("--rigs", nargs="+", default=list(RIGS), choices=list(RIGS))
    a = parser.parse_args()
    print(f"{'':16s} {'rows of':>8s} {'effects':>8s} {'ranking':>17s} {'diagnosis':>19s}")
    cost = f"{'cpu s':>9s} {'clock s':>7s} {'cpu s':>11s} {'clock s':>7s}"
    print(f"{'rig':16s} {'each':>8s} {'ranked':>8s} {cost} {'MB':>9s}  found")
    for rig in a.rigs:
        used = []
        for rows in sorted(a.rows):
            case = make_case(Plan(rig, (RIGS[rig],), "strong", idle=True, rows=rows), np.random.default_rng(3))
            with tempfile.TemporaryDirectory() as scratch:
                case.write(Path(scratch))
                used.append(measured(Path(scratch), rows))
            print(line(rig, used[-1]), flush=True)
        if len(used) > 1:
            grows = ", ".join(
                f"{title} as rows^{exponent(used, what):.2f}"
                for title, what in (("ranking", "ranking"), ("diagnosis", "diagnosis"), ("memory", "megabytes"))
            )
            print(f"{rig:16s} grows: {grows} (target: at most 1)", flush=True)


if __name__ == "__main__":
    main()
