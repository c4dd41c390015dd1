"""How long `stagecad drawings` takes: all sheets cold, one sheet, one parameter changed, nothing changed; then each
sheet by itself, and ezdxf's drawing add-on beside the writers of SVG, PDF and PNG.

    python -m benchmarks.drawings [RUNS]

Times are of fresh processes with a cache of their own, the best of RUNS (default 2); cold once, from no parts at all,
and once with the parts made but no sheet drawn. The interpreter's own compiled files are there, as they are from the
second run of an installed program on. Beside the time of day stands the processor time of all processes together,
which depends less on other work.
"""

import contextlib
import ctypes
import math
import os
import resource
import shutil
import subprocess
import sys
import tempfile
import time
from pathlib import Path

TARGETS = {
    "all sheets, cold": 25.0,
    "all sheets, parts made": 25.0,
    "one sheet (tip), part made": 3.0,
    "one parameter changed": 5.0,
    "nothing changed": 0.6,
}

SHEET = 3.0
"""Target of a sheet by itself, s."""


def seconds(arguments: list[str], cache: Path, source: Path | None = None) -> tuple[float, float]:
    """Time of day and processor time of one run of the command line, of the program in the folder `source`."""
    environment = {**os.environ, "STAGECAD_CACHE": str(cache), "PYTHONPYCACHEPREFIX": str(cache.parent / "compiled")}
    environment.pop("PYTHONDONTWRITEBYTECODE", None)
    if source is not None:
        environment["PYTHONPATH"] = str(source)
    _count_orphans()
    start, before = time.perf_counter(), resource.getrusage(resource.RUSAGE_CHILDREN)
    run = subprocess.run(
        [sys.executable, "-m", "workbench.cli", *arguments],
        env=environment,
        cwd=source,
        capture_output=True,
        text=True,
        check=False,
    )
    if run.returncode != 0:
        sys.exit(f"stagecad {' '.join(arguments)}: {run.stderr}")
    elapsed = time.perf_counter() - start
    with contextlib.suppress(ChildProcessError):
        while True:
            os.waitpid(-1, 0)
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    return elapsed, after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime


PR_SET_CHILD_SUBREAPER = 36
"""Option of prctl(2): processes whose parent has ended become children of this one."""


def _count_orphans() -> None:
    """Count the processor time of the processes that one of a run has forked, and that end after it (Linux)."""
    if sys.platform == "linux":
        ctypes.CDLL(None).prctl(PR_SET_CHILD_SUBREAPER, 1, 0, 0, 0)


def sheet_seconds(runs: int) -> dict[str, float]:
    """Processor time of each sheet, from solids to its files, in one process that has all modules loaded.

    That of a part includes its STEP AP242 file and is divided evenly among its sheets; that of the assembly and of the
    procedure includes their pictures.
    """
    from drawings.draw_sheets import PICTURES, build_sheets
    from stagecad.friction_stage.construction import MADE
    from stagecad.parameters.load import load_design
    from stagecad.solids.artefacts.part import build_part
    from stagecad.solids.artefacts.store import ArtefactStore
    from stagecad.solids.modelling.part import part_names
    from workbench.operations.drawings import procedure_values

    design = load_design()
    times: dict[str, float] = {}
    with tempfile.TemporaryDirectory() as built:
        for name in part_names(design):
            build_part(ArtefactStore(Path(built)), name, design)
        procedure_values(ArtefactStore(Path(built)), design)
        # The first round loads what is loaded late, and compiles.
        for number in range(runs + 1):
            with tempfile.TemporaryDirectory() as folder:
                shutil.copytree(built, folder, dirs_exist_ok=True)
                store = ArtefactStore(Path(folder))
                if number == 1:
                    times.clear()
                for subject in (*MADE, *PICTURES):
                    start = time.process_time()
                    sheets = build_sheets(store, subject, design, procedure_values)
                    seconds = (time.process_time() - start) / len(sheets)
                    times[subject] = min(times.get(subject, math.inf), seconds)
    return times


def rendering_seconds(runs: int) -> tuple[float, float]:
    """Processor time of SVG, PDF and PNG of the stage's sheet, and of ezdxf's SVG from the DXF document."""
    from ezdxf.addons.drawing import layout, svg
    from ezdxf.addons.drawing.frontend import Frontend
    from ezdxf.addons.drawing.properties import RenderContext

    from drawings.draw_sheets import describe
    from drawings.export.drawing_model import drawing_model
    from drawings.export.dxf import dxf_document
    from drawings.export.pdf import pdf_bytes, png_bytes, svg_bytes
    from drawings.sheets.part import part_sheets
    from stagecad.parameters.load import load_design
    from stagecad.solids.artefacts.part import build_part
    from stagecad.solids.artefacts.store import ArtefactStore

    design = load_design()
    with tempfile.TemporaryDirectory() as folder:
        (sheet,) = part_sheets(describe(build_part(ArtefactStore(Path(folder)), "stage", design), design), design)
    drawing = drawing_model(sheet)
    document = dxf_document(drawing)

    def ours() -> None:
        svg_bytes(drawing)
        png_bytes(pdf_bytes(drawing), sheet.paper)

    def theirs() -> None:
        backend = svg.SVGBackend()
        Frontend(RenderContext(document), backend).draw_layout(document.paperspace())
        backend.get_string(layout.Page(594, 420, layout.Units.mm))

    best = []
    for task in (ours, theirs):
        spans = []
        for _ in range(runs + 1):
            start = time.process_time()
            task()
            spans.append(time.process_time() - start)
        best.append(min(spans))
    return best[0], best[1]


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
    print(f"\n{'a sheet itself':32} {'processor [s]':>14} {'target [s]':>11}")
    for name, alone in sheet_seconds(runs).items():
        print(f"{name:32} {alone:14.2f} {SHEET:11.2f}   {'' if alone < SHEET else 'missed'}")
    ours, theirs = rendering_seconds(runs)
    print(f"\n{'SVG, PDF and PNG (stage)':34} {ours:12.2f}   ezdxf's drawing add-on, SVG alone: {theirs:.2f}")


if __name__ == "__main__":
    main(int(sys.argv[1]) if len(sys.argv) > 1 else 2)
