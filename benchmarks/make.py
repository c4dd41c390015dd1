"""How long `stagecad make` takes: with an empty cache, with nothing changed, and after each of several changes; then
the processor time of each stage.

    python -m benchmarks.make

Times are of fresh processes with a cache of their own. Beside the time of day stands the processor time of all
processes together, which depends less on other work. The stages are run one after the other in one process, with an
empty cache and after the first change; what the stages load and compile is in their times.
"""

from __future__ import annotations

import os
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
    from workbench.machine.design_source import DesignSource
    from workbench.making.pool import absent
    from workbench.making.tasks import KINDS, Making

    counts: list[Counter[str]] = []
    times: list[dict[str, float]] = []
    for overrides in ((), (change,)):
        design = load_design(overrides=overrides)
        making = Making(folder, design, design, DesignSource(None, "", overrides), simulations=True)
        counts.append(Counter())
        times.append(dict.fromkeys(KINDS, 0.0))
        for task in absent(making):
            start = time.process_time()
            making.run(task)
            kind = next(kind for kind in KINDS if task.startswith(kind))
            counts[-1][kind] += 1
            times[-1][kind] += time.process_time() - start
    return {kind: (counts[0][kind], times[0][kind], counts[1][kind], times[1][kind]) for kind in KINDS}


def main() -> None:
    """Measure and print the tables."""
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
