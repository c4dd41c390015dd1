"""How long `stagecad parts` and `stagecad --help` take: cold, one parameter changed, nothing changed.

    python benchmarks/parts.py [RUNS]

Each time is of a fresh process with a cache of its own, the best of RUNS (default 3); cold is measured once, with the
program's own files already in the disk cache.
"""

import os
import subprocess
import sys
import tempfile
import time
from pathlib import Path

TARGETS = {"cold": 15.0, "one parameter changed": 3.0, "nothing changed": 0.5, "--help": 0.3}


def seconds(arguments: list[str], cache: Path) -> float:
    """Wall time of one run of the command line."""
    environment = {**os.environ, "STAGECAD_CACHE": str(cache)}
    start = time.perf_counter()
    run = subprocess.run(
        [sys.executable, "-m", "workbench.cli", *arguments],
        env=environment,
        capture_output=True,
        text=True,
        check=False,
    )
    if run.returncode != 0:
        sys.exit(f"stagecad {' '.join(arguments)}: {run.stderr}")
    return time.perf_counter() - start


def main(runs: int) -> None:
    """Measure and print the table."""
    with tempfile.TemporaryDirectory() as folder:
        cache, out = Path(folder) / "cache", Path(folder) / "build"
        subprocess.run([sys.executable, "-c", "import cadquery"], check=True)
        parts = ["parts", "--out", str(out)]
        times = {"cold": seconds(parts, cache)}
        # A thickness that no run before had: the stage and the assembly are made again, the other parts are not.
        times["one parameter changed"] = min(
            seconds([*parts, "--set", f"stage.thickness={12.1 + 0.1 * run:.1f} mm"], cache) for run in range(runs)
        )
        seconds(parts, cache)
        times["nothing changed"] = min(seconds(parts, cache) for _ in range(runs))
        times["--help"] = min(seconds(["--help"], cache) for _ in range(runs))
    print(f"{'stagecad parts':24} {'time [s]':>9} {'target [s]':>11}   ({os.cpu_count()} processors)")
    for name, value in times.items():
        print(f"{name:24} {value:9.2f} {TARGETS[name]:11.2f}   {'' if value < TARGETS[name] else 'missed'}")


if __name__ == "__main__":
    main(int(sys.argv[1]) if len(sys.argv) > 1 else 3)
