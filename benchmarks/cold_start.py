"""Cold start: a fresh process that composes a model and integrates it, with an empty and with a warm cache of kernels.

    python -m benchmarks.cold_start

Elapsed time, and the processor's, which other work on the machine hardly touches.
"""

import os
import shutil
import statistics
import subprocess
import sys
import tempfile
import time

PROGRAM = """
import time
begin = time.perf_counter()
import numpy as np
from sim import drive
from sim.effects.catalogue import compose
from sim.integration.simulate import simulate
pull = drive.pulled_spring([0.0, 20.0], [0.0, 2.0], 2.0)
run = simulate(compose(["lugre_causal", "stribeck", "viscous"]), pull, np.linspace(0.0, 20.0, 20001))
print(time.perf_counter() - begin, run.position[-1])
"""


def timed(environment: dict[str, str]) -> tuple[float, float, float]:
    """Elapsed and processor time of a process, s, and the position it found, m."""
    begin, before = time.perf_counter(), os.times()
    found = subprocess.run([sys.executable, "-c", PROGRAM], env=environment, capture_output=True, text=True, check=True)
    after = os.times()
    spent = after.children_user - before.children_user + after.children_system - before.children_system
    return time.perf_counter() - begin, spent, float(found.stdout.split()[1])


def main() -> None:
    folder = tempfile.mkdtemp()
    try:
        environment = {**os.environ, "STAGECAD_CACHE": folder, "PYTHONPATH": os.getcwd()}
        elapsed, spent, answer = timed(environment)
        warm = [timed(environment)[:2] for _ in range(5)]
        print(f"stick-slip, 20 s, causal model, whole process (position at the end {answer:.6f} m)")
        print("              elapsed   processor")
        print(f"empty cache   {elapsed:6.2f} s   {spent:6.2f} s")
        median, used = statistics.median(w[0] for w in warm), statistics.median(w[1] for w in warm)
        print(f"warm cache    {median:6.2f} s   {used:6.2f} s   (medians of 5)")
    finally:
        shutil.rmtree(folder, ignore_errors=True)


if __name__ == "__main__":
    main()
