"""How long `stagecad drawings` takes: all sheets cold, one sheet, one parameter changed, nothing changed.

    python -m benchmarks.drawings [RUNS]

Times are of fresh processes with a cache of their own, the best of RUNS (default 2); cold once, from no parts at all,
and once with the parts made but no sheet drawn. The interpreter's own compiled files are there, as they are from the
second run of an installed program on. Beside the time of day stands the processor time of all processes together,
which says more on a busy machine.
"""

from __future__ import annotations

import os
import resource
import subprocess
import sys
import tempfile
import time
from pathlib import Path

TARGETS = {
    "all sheets, cold": 12.0,
    "all sheets, parts made": 12.0,
    "one sheet (tip), part made": 3.0,
    "one parameter changed": 5.0,
    "nothing changed": 0.6,
}

SHEET = 1.5
"""Target of a sheet by itself, s of processor time."""


def seconds(arguments: list[str], cache: Path) -> tuple[float, float]:
    """Time of day and processor time of one run of the command line."""
    environment = {**os.environ, "STAGECAD_CACHE": str(cache), "PYTHONPYCACHEPREFIX": str(cache.parent / "compiled")}
    environment.pop("PYTHONDONTWRITEBYTECODE", None)
    start, before = time.perf_counter(), resource.getrusage(resource.RUSAGE_CHILDREN)
    run = subprocess.run(
        [sys.executable, "-m", "workbench.cli", *arguments],
        env=environment,
        capture_output=True,
        text=True,
        check=False,
    )
    if run.returncode != 0:
        sys.exit(f"stagecad {' '.join(arguments)}: {run.stderr}")
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    return time.perf_counter() - start, after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime


def sheet_seconds(part: str) -> float:
    """Processor time of one sheet of a part, from solid to four files, in a process that has all modules loaded."""
    from drawings.made_sheets import draw_part
    from stagecad.parameters.design import load_design
    from stagecad.solids.cache import Store
    from stagecad.solids.made_part import make_part

    design = load_design()
    with tempfile.TemporaryDirectory() as folder:
        store = Store(Path(folder))
        draw_part(store, "magnet", design)
        make_part(store, part, design)
        start = time.process_time()
        sheets = draw_part(store, part, design)
        return (time.process_time() - start) / len(sheets)


def main(runs: int) -> None:
    """Measure and print the table."""
    with tempfile.TemporaryDirectory() as folder:
        cache, out = Path(folder) / "cache", Path(folder) / "build"
        draw = ["drawings", "--out", str(out)]
        seconds(["drawings", "magnet", "assembly", "procedure", "--out", str(out)], Path(folder) / "first")
        times = {"all sheets, cold": seconds(draw, cache)}
        parts = Path(folder) / "parts"
        seconds(["parts", "--out", str(out)], parts)
        times["all sheets, parts made"] = seconds(draw, parts)
        other = Path(folder) / "other"
        seconds(["parts", "tip", "--out", str(out)], other)
        times["one sheet (tip), part made"] = seconds(["drawings", "tip", "--out", str(out)], other)
        times["one parameter changed"] = min(
            seconds([*draw[:1], "stage", *draw[1:], "--set", f"stage.thickness={12.1 + 0.1 * run:.1f} mm"], cache)
            for run in range(runs)
        )
        times["nothing changed"] = min(seconds(draw, cache) for _ in range(runs))
    heads = f"{'time [s]':>9} {'processor [s]':>14} {'target [s]':>11}"
    print(f"{'stagecad drawings':28} {heads}   ({os.cpu_count()} processors)")
    for name, (value, processor) in times.items():
        missed = "" if value < TARGETS[name] else "missed"
        print(f"{name:28} {value:9.2f} {processor:14.2f} {TARGETS[name]:11.2f}   {missed}")
    for part in ("tip", "holder", "base", "stage"):
        alone = min(sheet_seconds(part) for _ in range(runs))
        missed = "" if alone < SHEET else "missed"
        print(f"{f'a sheet itself ({part})':28} {'':9} {alone:14.2f} {SHEET:11.2f}   {missed}")


if __name__ == "__main__":
    main(int(sys.argv[1]) if len(sys.argv) > 1 else 2)
