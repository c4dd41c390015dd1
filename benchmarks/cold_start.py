"""Cold start: a fresh process that composes a model and integrates it, with an empty and with a warm cache of kernels.

python -m benchmarks.cold_start
"""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
import tempfile
import time

PROGRAM = """
import time
begin = time.perf_counter()
import numpy as np
from sim import drive
from sim.model import compose
from sim.simulation import simulate
pull = drive.pulled_spring([0.0, 20.0], [0.0, 2.0], 2.0)
run = simulate(compose(["lugre_causal", "stribeck", "viscous"]), pull, np.linspace(0.0, 20.0, 20001))
print(time.perf_counter() - begin, run.position[-1])
"""


def timed(environment: dict[str, str]) -> tuple[float, float]:
    begin = time.perf_counter()
    found = subprocess.run([sys.executable, "-c", PROGRAM], env=environment, capture_output=True, text=True, check=True)
    return time.perf_counter() - begin, float(found.stdout.split()[1])


def main() -> None:
    folder = tempfile.mkdtemp()
    try:
        environment = {**os.environ, "STAGECAD_CACHE": folder, "PYTHONPATH": os.getcwd()}
        empty, answer = timed(environment)
        warm = sorted(timed(environment)[0] for _ in range(5))
        print(f"stick-slip, 20 s, causal model, whole process (position at the end {answer:.6f} m)")
        print(f"empty cache   {empty:6.2f} s")
        print(f"warm cache    {warm[2]:6.2f} s   (median of 5; {warm[0]:.2f} to {warm[-1]:.2f})")
    finally:
        shutil.rmtree(folder, ignore_errors=True)


if __name__ == "__main__":
    main()
