"""How long `stagecad make` takes: with an empty cache, with nothing changed, and after each of several changes; then
the processor time of each stage.

    python -m benchmarks.make
    python -m benchmarks.make --beside COMMIT [--runs N]

With `--beside`, the program as it was at a commit of this repository is the peer: both make each change N times
(default 3), in alternation, and the ratio of the median times is printed. The speed of a shared machine may differ by a
factor of two from one minute to the next, so that a time by itself says little.

Times are of fresh processes with a cache of their own. Beside the time of day stands the processor time of all
processes together, which depends less on other work. The stages are run one after the other in one process, with an
empty cache and after the first change; what the stages load and compile is in their times.
"""

import argparse
import io
import os
import shutil
import statistics
import subprocess
import tarfile
import tempfile
import time
from collections import Counter
from pathlib import Path

from benchmarks.drawings import seconds

CHANGES = (
    "stage.thickness=12.5 mm",
    "stage.length=232 mm",
    "actuator.tip_height=20.5 mm",
    "actuator.piezo_spacing=47 mm",
    "bearing.dynamic_friction=0.055",
)
EMPTY, CHANGED, UNCHANGED = 40.0, 10.0, 3.0
"""Targets on two processors, s."""


def stage_seconds(folder: Path, change: str) -> dict[str, tuple[int, float, int, float]]:
    """Number of tasks and their processor time by stage: with an empty cache, and after a change."""
    from stagecad.parameters.load import load_design
    from workbench.operations.design import Design as StatedDesign
    from workbench.report.make import Kind, Making

    counts: list[Counter[Kind]] = []
    times: list[dict[Kind, float]] = []
    for overrides in ((), (change,)):
        design = load_design(overrides=overrides)
        making = Making(folder, design, design, StatedDesign(None, overrides), simulations=True)
        counts.append(Counter())
        times.append(dict.fromkeys(Kind, 0.0))
        for task in making.absent:
            start = time.process_time()
            making.run(task)
            counts[-1][task.kind] += 1
            times[-1][task.kind] += time.process_time() - start
    return {str(kind): (counts[0][kind], times[0][kind], counts[1][kind], times[1][kind]) for kind in Kind}


def beside(commit: str, runs: int) -> None:
    """Print the times of the program and of an earlier one, and their ratio, for an empty cache and each change."""
    here = Path(__file__).resolve().parents[1]
    archive = subprocess.run(["git", "archive", commit], cwd=here, capture_output=True, check=True).stdout
    with tempfile.TemporaryDirectory() as folder:
        peer = Path(folder) / "peer"
        with tarfile.open(fileobj=io.BytesIO(archive)) as files:
            files.extractall(peer, filter="data")
        made, used = {peer: Path(folder) / "cache of peer", here: Path(folder) / "cache"}, Path(folder) / "used"
        make = ["make", "--out", str(Path(folder) / "build")]
        print(f"{'stagecad make':34} {commit[:12] + ' [s]':>16} {'now [s]':>9} {'ratio':>7}")
        empty = {source: seconds(make, cache, source)[0] for source, cache in made.items()}
        print(f"{'empty cache':34} {empty[peer]:16.2f} {empty[here]:9.2f} {empty[here] / empty[peer]:7.2f}", flush=True)
        for change in CHANGES:
            times: dict[Path, list[float]] = {source: [] for source in made}
            for source in [*made] * runs:
                shutil.copytree(made[source], used)
                times[source].append(seconds([*make, "--set", change], used, source)[0])
                shutil.rmtree(used)
            before, now = (statistics.median(times[source]) for source in (peer, here))
            print(f"{change:34} {before:16.2f} {now:9.2f} {now / before:7.2f}", flush=True)


def main() -> None:
    """Measure and print the tables."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--beside", metavar="COMMIT", help="of the program that is the peer")
    parser.add_argument("--runs", type=int, default=3, metavar="N", help="of each change, with --beside")
    options = parser.parse_args()
    if options.beside:
        beside(options.beside, options.runs)
        return
    with tempfile.TemporaryDirectory() as folder:
        cache, make = Path(folder) / "cache", ["make", "--out", str(Path(folder) / "build")]
        # With a cache that is not used again, so that the interpreter's own compiled files are there.
        seconds(["parts", "magnet", "--out", str(Path(folder) / "first")], Path(folder) / "first")
        rows = [("empty cache", seconds(make, cache), EMPTY), ("nothing changed", seconds(make, cache), UNCHANGED)]
        rows += [(change, seconds([*make, "--set", change], cache), CHANGED) for change in CHANGES]
        heads = f"{'time [s]':>9} {'processor [s]':>14} {'target [s]':>11}"
        print(f"{'stagecad make':34} {heads}   ({os.cpu_count()} processors)")
        for name, (value, processor), target in rows:
            missed = "" if value < target else "missed"
            print(f"{name:34} {value:9.2f} {processor:14.2f} {target:11.2f}   {missed}")
        os.environ["STAGECAD_CACHE"] = str(Path(folder) / "stages")
        stages = stage_seconds(Path(folder) / "stages", CHANGES[0])
    print(f"\n{'stage':34} {'tasks':>6} {'processor [s]':>14} {'then tasks':>11} {'processor [s]':>14}")
    for kind, (count, spent, again, spent_again) in stages.items():
        print(f"{kind.rstrip(':'):34} {count:6d} {spent:14.2f} {again:11d} {spent_again:14.2f}")


if __name__ == "__main__":
    main()
