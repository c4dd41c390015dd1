"""How long `stagecad drawings` takes: all sheets cold, one sheet, one parameter changed, nothing changed; then each
sheet by itself, and ezdxf's drawing add-on beside the writers of SVG, PDF and PNG.

    python -m benchmarks.drawings [RUNS]

Times are of fresh processes with a cache of their own, the best of RUNS (default 2); cold once, from no parts at all,
and once with the parts made but no sheet drawn. The interpreter's own compiled files are there, as they are from the
second run of an installed program on. Beside the time of day stands the processor time of all processes together,
which says more on a busy machine.
"""

from __future__ import annotations

import math
import os
import resource
import shutil
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from functools import partial
from itertools import pairwise
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


def sheet_seconds(runs: int) -> dict[str, float]:
    """Processor time of each sheet, from solids to its files, in one process that has all modules loaded.

    Of a part, with its STEP AP242 file, shared evenly among its sheets. Of the whole machine, with the pictures it
    shows, one after the other, and with the pictures there.
    """
    from drawings.artefacts.pictures import PICTURES, make_picture
    from drawings.artefacts.sheets import draw_part, draw_whole
    from stagecad.parameters.load import load_design
    from stagecad.solids.artefacts.part import build_part
    from stagecad.solids.artefacts.store import ArtefactStore
    from stagecad.solids.modelling.registry import ASSEMBLY, MADE, part_names
    from workbench.machine.artefacts import procedure_values

    design = load_design()
    times: dict[str, float] = {}

    def note(name: str, task: Callable[[], object]) -> None:
        start = time.process_time()
        made = task()
        count = len(made) if isinstance(made, tuple) else 1
        times[name] = min(times.get(name, math.inf), (time.process_time() - start) / count)

    with tempfile.TemporaryDirectory() as made:
        parts = {name: build_part(ArtefactStore(Path(made)), name, design) for name in part_names(design)}
        procedure_values(ArtefactStore(Path(made)), design)
        # The first round loads what is loaded late, and compiles.
        for number in range(runs + 1):
            with tempfile.TemporaryDirectory() as folder:
                shutil.copytree(made, folder, dirs_exist_ok=True)
                store = ArtefactStore(Path(folder))
                if number == 1:
                    times.clear()
                for part in MADE:
                    note(part, partial(draw_part, store, part, design))
                for whole, pictures in PICTURES.items():
                    if whole == ASSEMBLY:
                        for name in pictures:
                            note(f"picture: {name}", partial(make_picture, store, name, parts, design))
                    note(f"{whole}, its pictures there", partial(draw_whole, store, whole, design, procedure_values))
                    shown = sum(times[f"picture: {name}"] for name in pictures)
                    times[f"{whole}, with its pictures"] = times[f"{whole}, its pictures there"] + shown
    return times


def clocked(runs: int) -> dict[str, float]:
    """Time of day from nothing but the parts to the files of each sheet of the whole machine, on two processors.

    Two processes work as those of the command do, the pictures first, then the sheet.
    In their first round they load what is loaded late; the best of the others counts.
    """
    from drawings.artefacts.pictures import PICTURES
    from drawings.artefacts.workers import run_tasks
    from stagecad.parameters.load import load_design
    from stagecad.solids.artefacts.part import build_part
    from stagecad.solids.artefacts.store import ArtefactStore
    from stagecad.solids.modelling.registry import part_names
    from workbench.machine.artefacts import procedure_values

    times: dict[str, float] = {}
    with tempfile.TemporaryDirectory() as folder:
        design, made = load_design(), Path(folder) / "made"
        for name in part_names(design):
            build_part(ArtefactStore(made), name, design)
        procedure_values(ArtefactStore(made), design)
        for whole, pictures in PICTURES.items():
            names: list[str] = []
            needs: dict[str, list[str]] = {}
            for number in range(runs + 1):
                shutil.copytree(made, Path(folder) / f"{whole} {number}")
                before = names[-1:]
                own = [f"{whole} {number}/{picture}" for picture in pictures]
                last = f"{whole} {number}/"
                needs |= dict.fromkeys(own, before) | {last: own}
                names += [*own, last]
            ends: dict[str, float] = {}
            run_tasks(
                names, partial(one_of, folder), lambda name, ends=ends: ends.update({name: time.perf_counter()}),
                workers=2, needs=needs,
            )  # fmt: skip
            sheets = [ends[f"{whole} {number}/"] for number in range(runs + 1)]
            times[whole] = min(end - begin for begin, end in pairwise(sheets))
    return times


def one_of(folder: str, name: str, late: bool) -> None:
    """A picture of the machine, or its sheet, as `clocked` names it."""
    from drawings.artefacts.pictures import make_picture
    from drawings.artefacts.sheets import draw_whole
    from stagecad.parameters.load import load_design
    from stagecad.solids.artefacts.part import build_part
    from stagecad.solids.artefacts.store import ArtefactStore
    from stagecad.solids.modelling.registry import part_names
    from workbench.machine.artefacts import procedure_values

    place, _, picture = name.partition("/")
    store, design = ArtefactStore(Path(folder) / place), load_design()
    if picture:
        parts = {part: build_part(store, part, design) for part in part_names(design)}
        make_picture(store, picture, parts, design, exact=not late)
    else:
        draw_whole(store, place.split()[0], design, procedure_values, exact=not late)


def rendering_seconds(runs: int) -> tuple[float, float]:
    """Processor time of SVG, PDF and PNG of the stage's sheet, and of ezdxf's SVG from the DXF document."""
    from ezdxf.addons.drawing import layout, svg
    from ezdxf.addons.drawing.frontend import Frontend
    from ezdxf.addons.drawing.properties import RenderContext

    from drawings.artefacts.sheets import describe
    from drawings.export.drawing_model import drawing_model
    from drawings.export.dxf import dxf_document
    from drawings.export.pdf import pdf_bytes, png_bytes
    from drawings.export.svg import svg_bytes
    from drawings.sheets.part import sheets_of
    from stagecad.parameters.load import load_design
    from stagecad.solids.artefacts.part import build_part
    from stagecad.solids.artefacts.store import ArtefactStore

    design = load_design()
    with tempfile.TemporaryDirectory() as folder:
        (sheet,) = sheets_of(describe(build_part(ArtefactStore(Path(folder)), "stage", design), design), design)
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
        if name.startswith("picture"):
            print(f"  {name:30} {alone:14.2f}")
        else:
            print(f"{name:32} {alone:14.2f} {SHEET:11.2f}   {'' if alone < SHEET else 'missed'}")
    print(f"\n{'from parts to files, with pictures':32} {'time [s]':>11} {'target [s]':>11}   (two processes)")
    for name, whole in clocked(runs).items():
        print(f"{name:32} {whole:13.2f} {SHEET:11.2f}   {'' if whole < SHEET else 'missed'}")
    ours, theirs = rendering_seconds(runs)
    print(f"\n{'SVG, PDF and PNG (stage)':34} {ours:12.2f}   ezdxf's drawing add-on, SVG alone: {theirs:.2f}")


if __name__ == "__main__":
    main(int(sys.argv[1]) if len(sys.argv) > 1 else 2)
