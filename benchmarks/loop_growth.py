"""How the time and memory of a diagnosis grow with the samples: two records, the full list of effects, a new process.

    python benchmarks/loop_growth.py [--rows 5000 20000 80000]

Prints processor seconds, seconds on the clock and the largest resident memory at each size, and the exponent of the
processor time in the samples between the smallest size and the largest: one is growth as the samples.
"""

from __future__ import annotations

import argparse
import json
import math
import os
import subprocess
import sys
import tempfile
import time
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
sys.path[:0] = [str(ROOT), str(ROOT / "tests" / "hidden_effect")]

RIGS = {
    "velocity-drive": "stribeck",
    "spring-pull": "viscous",
    "force-drive": "constant_bias",
    "actuator-tip": "piezo_creep",
}


def diagnosed(folder: Path) -> tuple[float, float, float, str]:
    """Processor seconds, seconds, largest resident memory in MB, and what a diagnosis in a new process found."""
    code = (
        "import json, resource, sys; from workbench.cli import run; "
        "status = run(['diagnose', sys.argv[1], '--no-figures', '--out', sys.argv[2], '--json', sys.argv[3]]); "
        "u = resource.getrusage(resource.RUSAGE_SELF); "
        "print('used', status, u.ru_utime + u.ru_stime, u.ru_maxrss)"
    )
    document = folder / "diagnosis.json"
    began = time.perf_counter()
    done = subprocess.run(
        [sys.executable, "-c", code, str(folder), str(folder / "out"), str(document)],
        cwd=ROOT, capture_output=True, text=True, check=False, env={**os.environ, "PYTHONPATH": str(ROOT)},
    )  # fmt: skip
    seconds = time.perf_counter() - began
    used = [line for line in done.stdout.splitlines() if line.startswith("used ")]
    if done.returncode != 0 or not used:
        raise RuntimeError(done.stderr.strip()[-400:])
    _, _, processor, kilobytes = used[-1].split()
    found = json.loads(document.read_text(encoding="utf-8"))
    return float(processor), seconds, float(kilobytes) / 1024.0, found["effect"] or found["verdict"]


def main() -> None:
    import numpy as np
    from generator import Plan, make_case

    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--rows", type=int, nargs="+", default=[5000, 20000, 80000])
    parser.add_argument("--rigs", nargs="+", default=list(RIGS), choices=list(RIGS))
    a = parser.parse_args()
    print(f"{'rig':16s} {'rows':>8s} {'processor':>10s} {'clock':>8s} {'memory':>9s}  found")
    for rig in a.rigs:
        used = []
        for rows in sorted(a.rows):
            case = make_case(Plan(rig, (RIGS[rig],), "strong", idle=True, rows=rows), np.random.default_rng(3))
            with tempfile.TemporaryDirectory() as scratch:
                case.write(Path(scratch))
                processor, seconds, megabytes, found = diagnosed(Path(scratch))
            used.append(processor)
            row = f"{rig:16s} {2 * rows:8d} {processor:8.1f} s {seconds:6.1f} s {megabytes:6.0f} MB  {found}"
            print(row, flush=True)
        if len(used) > 1:
            exponent = math.log(used[-1] / used[0]) / math.log(max(a.rows) / min(a.rows))
            print(f"{rig:16s} processor time grows as samples^{exponent:.2f}")


if __name__ == "__main__":
    main()
