"""Record every number that the program produces, and compare two recordings: did a change move any of them?

    python -m benchmarks.snapshot record OUT.json [--practice FOLDER] [--jobs 2] [--only checks,thesis] [--checkout DIR]
    python -m benchmarks.snapshot compare BEFORE.json AFTER.json

Everything goes through the command line, which is stable: `--checkout` records another working copy, whatever modules
it has, with this same script. A recording has a cache of its own and works on copies of the practice records.
`compare` fails on numbers, yes/no values and fixed words (verdicts, units, effects); other texts may be reworded and
are listed for information. Rows of a table are paired by name; those whose name only one recording has, in their order.
"""

import argparse
import json
import math
import os
import re
import shlex
import shutil
import subprocess
import sys
import tempfile
import time
from collections import Counter
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import ezdxf

from benchmarks.scoring import all_found, first_right, hidden_effects, said

# Largest relative difference that is none, of each section; and one in SI units that is rounding about zero.
TOLERANCE = {"checks": 1e-9, "dimensions": 1e-9, "thesis": 1e-6, "practice": 1e-6}
FLOOR = 1e-18
# Of a document: what two runs of the same code do not share, words that count, what names the rows of a table.
LEFT_OUT = {"seconds", "files", "file", "report", "digest"}
FIXED_WORDS = {"verdict", "unit", "effect", "indistinguishable", "paper", "scale", "tolerance", "part_number", "told"}
ROW_NAMES = ("name", "effect", "item", "contribution", "suspension", "coordinate", "detail")
FAILED = "command failed"
CHECKS = """
check; check --set "stage.thickness=14 mm"; check --set "preload.force=6 N" --set "actuator.piezo_spacing=44 mm"
check --tolerance --samples 1000; check --sweep "stage.thickness=8 mm:20 mm:3"
"""
SIMULATIONS = """
simulate; simulate passivity; simulate presliding hysteresis stick-slip --mass design
simulate stick-slip --sweep "friction.mass=1 kg:2 kg:2"; simulate tip presliding hysteresis stick-slip --draws 3
simulate stage --study speed --sweep drive.friction=0.15:0.45:2
"""
CALCULATORS = """
effects; calc budget; calc suspensions; calc hertz; calc rail; calc teeth; calc drive; calc stack; calc tip-over
calc clamp; calc pads; calc wedge; calc screw; calc probe; calc wear; calc smoothness; calc air-bearing; calc bow
calc levitation; calc vibration; calc alignment; calc rail --spacing-ratio 3; calc teeth --magnet design --gap "0.6 mm"
calc hertz --load "20 N" --radius-1 "2.5 mm" --radius-2 inf --length "4 mm"; calc wedge --pitch "0.5 mm"
calc drive --speed "100 mm/s" --tip-mass "30 g"; calc stack --frequency "4 kHz" --side-force "5 N"
calc tip-over --position "80 mm" --friction 0.4; calc clamp --torque "2 N*m"; calc bow --change "3 K"
calc screw --torque "4 N*m"; calc probe --bandwidth "500 Hz" --bits 18; calc wear --load "12 N" --speed "50 mm/s"
calc smoothness --roughness "30 nm" --wavelength "7 mm"; calc air-bearing --gap "6 um"; calc alignment --offset "30 mm"
calc levitation --z "25 mm" --x "3 mm"; calc vibration --mass "20 kg"; calc pads --load "12 N" --crown-radius "1 m"
"""
NUMBER = re.compile(r"\d+(?:\.\d+)?")
# Texts of a sheet that are dimensions: holes, threads, chamfers, roughness, depths, zones of a form tolerance.
CALLOUT = re.compile(r"%%[cdp]|^Ra |\bM\d|UNC|^\d+(\.\d+)?( CZ)? *$")


@dataclass(frozen=True)
class Program:
    """The command line of one checkout, run in folders below `scratch`, `jobs` commands at a time."""

    checkout: Path
    scratch: Path
    jobs: int

    def python(self, *command: str) -> tuple[subprocess.CompletedProcess[str], Path]:
        """Run the interpreter in a new folder, on the modules of the checkout."""
        folder = Path(tempfile.mkdtemp(dir=self.scratch))
        environment = os.environ | {"PYTHONPATH": str(self.checkout), "STAGECAD_CACHE": str(self.scratch / "cache")}
        words = [sys.executable, *command]
        return subprocess.run(words, cwd=folder, env=environment, capture_output=True, text=True, check=False), folder

    def run(self, arguments: list[str]) -> tuple[Any, Path, str]:
        """The document that a command prints, the folder with its files, and what else it says."""
        done, folder = self.python("-m", "workbench.cli", *arguments, "--json", "--out", "out")
        if done.returncode not in ((0, 1) if arguments[0] == "check" else (0,)):
            raise RuntimeError(f"stagecad {' '.join(arguments)}: {done.stderr.strip()[-500:]}")
        return json.loads(done.stdout), folder / "out", done.stderr

    def each(self, tasks: dict[str, Callable[[], Any]]) -> dict[str, Any]:
        """The result of every task, `jobs` at a time, with a line of progress for each."""

        def one(name: str) -> Any:
            start = time.perf_counter()
            try:
                result, words = tasks[name](), ""
            except RuntimeError as error:
                result, words = {FAILED: True}, f"{FAILED}: {error}"
            print(f"  {name}: {time.perf_counter() - start:.1f} s {words}", file=sys.stderr, flush=True)
            return result

        with ThreadPoolExecutor(self.jobs) as pool:
            return dict(zip(tasks, pool.map(one, tasks), strict=True))

    def documents(self, commands: str, *options: str) -> dict[str, Any]:
        """The document of every command of a text, one a line or more with `;` between them."""
        texts = [text.strip() for text in re.split("[;\n]", commands.strip())]
        return self.each({text: lambda text=text: self.run([*shlex.split(text), *options])[0] for text in texts})


def sheet(path: Path) -> dict[str, Any]:
    """Dimensions, callouts and texts of a drawing sheet, each list sorted."""
    document = ezdxf.readfile(path)
    found = [entity for layout in document.layouts for entity in layout]
    texts = sorted(entity.dxf.text for entity in found if entity.dxftype() == "TEXT")
    rows: list[dict[str, Any]] = []
    for entity in (each for each in found if each.dxftype() == "DIMENSION"):
        drawn = document.blocks[entity.dxf.geometry].query("TEXT MTEXT")
        shown = " ".join(each.dxf.text if each.dxftype() == "TEXT" else each.text for each in drawn)
        row = {"measurement": float(entity.get_measurement()), "kind": entity.dimtype, "text": entity.dxf.text}
        row |= {key: entity.override().get(key) for key in ("dimdec", "dimtol", "dimlim", "dimtp", "dimtm")}
        rows.append(row | {"numbers": [float(n) for n in NUMBER.findall(shown)]})
    callouts = [float(n) for text in texts if CALLOUT.search(text) for n in NUMBER.findall(text)]
    return {
        "dimensions": sorted(rows, key=lambda row: (round(row["measurement"], 6), row["kind"], row["numbers"])),
        "callouts": sorted(callouts),
        "texts": texts,
        "entities": ", ".join(f"{n} {kind}" for kind, n in sorted(Counter(each.dxftype() for each in found).items())),
    }


def dimensions(program: Program) -> dict[str, Any]:
    """Every sheet, parts, interference, bill of materials and parameters of the packaged design."""

    def made() -> dict[str, Any]:
        document, folder, words = program.run(["make", "--no-simulations"])
        return {key: value for key, value in document.items() if key != "checks"} | {
            "hits": {name: len(row["hits"]) for name, row in document["drawings"].items()},
            "sheets": {path.stem: sheet(path) for path in sorted(folder.rglob("*.dxf"))},
            "interference": [float(n) for k in words.splitlines() if "interference" in k for n in NUMBER.findall(k)],
            "bill_of_materials": json.loads((folder / "parts" / "bill_of_materials.json").read_text(encoding="utf-8")),
        }

    return program.each({"make": made, "parameters": lambda: program.run(["params"])[0]})


def diagnosis(program: Program, folder: Path, entry: dict[str, Any]) -> dict[str, Any]:
    """The diagnosis of a copy of a record folder, whether it is right; of a pair, what at most three rounds find."""
    work = Path(tempfile.mkdtemp(dir=program.scratch)) / folder.name
    shutil.copytree(folder, work)
    first = document = program.run(["diagnose", str(work), "--no-figures"])[0]
    right, told = first_right(first, entry), []
    if "+" in entry["effect"]:
        while (names := said(document)[1]) and len(told) < 3:
            program.run(["add", str(work), document["effect"]])
            told.append(names)
            document = program.run(["diagnose", str(work), "--no-figures"])[0]
        right = right and all_found(hidden_effects(entry), told)
    return {"diagnosis": first, "told": told, "right": right}


def practice(program: Program, folder: Path) -> dict[str, Any]:
    """The diagnosis of every record folder, and how many are right by the folder's key."""
    key = json.loads((folder / "key.json").read_text(encoding="utf-8"))
    tasks = {name: lambda name=name: diagnosis(program, folder / name, key[name]) for name in sorted(key)}
    results = program.each(tasks)
    right = sum(row.get("right", False) for row in results.values())
    print(f"practice: {right} of {len(results)} right")
    return {"cases": results, "right": right, "of": len(results)}


def record(out: Path, checkout: Path, records: Path | None, jobs: int, only: list[str]) -> None:
    """Run the sections and write the recording."""
    sections: dict[str, Any] = {}
    with tempfile.TemporaryDirectory() as scratch:
        program = Program(checkout.resolve(), Path(scratch).resolve(), jobs)
        found = program.python("-c", "import workbench.cli as cli; print(cli.__file__)")[0].stdout.strip()
        if not found or not Path(found).resolve().is_relative_to(program.checkout):
            sys.exit(f"no program in {program.checkout}: {found or 'nothing'} would run")
        ways: dict[str, Callable[[], Any]] = {
            "checks": lambda: program.documents(CHECKS),
            "dimensions": lambda: dimensions(program),
            "thesis": lambda: program.documents(SIMULATIONS, "--no-figures") | program.documents(CALCULATORS),
            "practice": lambda: practice(program, records.resolve()) if records else {},
        }
        for name in only:
            start = time.perf_counter()
            sections[name] = {"data": ways[name](), "seconds": round(time.perf_counter() - start, 1)}
            print(f"{name}: {sections[name]['seconds']} s", file=sys.stderr, flush=True)
    out.write_text(json.dumps({"schema": 1, "sections": sections}, indent=1), encoding="utf-8")


@dataclass
class Tally:
    """What the comparison of a section has met so far."""

    tolerance: float
    compared: int = 0
    largest: float = 0.0
    different: list[str] = field(default_factory=list)
    texts: Counter[str] = field(default_factory=Counter)

    def value(self, place: str, before: Any, after: Any, scale: float = 0.0) -> None:
        """Compare two values: relative to the larger, or to the largest entry of their array (`scale`)."""
        self.compared += 1
        relative = 0.0 if before == after and isinstance(before, bool) == isinstance(after, bool) else math.inf
        if relative and all(type(value) in (int, float) for value in (before, after)):
            apart = abs(before - after)
            relative = apart / (scale or max(abs(before), abs(after))) if apart >= FLOOR else 0.0
        self.largest = max(self.largest, relative)
        if not relative <= self.tolerance:
            self.different.append(f"{place}: {before!r} -> {after!r} ({relative:.2g})")


def largest(data: Any) -> float:
    """Largest size of the numbers of nested lists, 0 without any."""
    if isinstance(data, list):
        return max(map(largest, data), default=0.0)
    return abs(data) if isinstance(data, int | float) and math.isfinite(data) else 0.0


def by_name(data: Any) -> Any:
    """Rows with names of their own as a dictionary; anything else as it is."""
    if isinstance(data, list) and data and all(isinstance(row, dict) for row in data):
        for names in ([str(row.get(key)) for row in data] for key in ROW_NAMES):
            if len(set(names)) == len(names):
                return dict(zip(names, data, strict=True))
    return data


def walk(place: str, before: Any, after: Any, tally: Tally, fixed: bool = False, scale: float = 0.0) -> None:
    """Compare two documents into `tally`; `fixed`: its words count; `scale`: of the array that they stand in."""
    if all(isinstance(by_name(data), dict) for data in (before, after)):
        before, after = by_name(before), by_name(after)
    if isinstance(before, dict) and isinstance(after, dict):
        before, after = ({k: v for k, v in data.items() if k not in LEFT_OUT} for data in (before, after))
        lost, new = [key for key in before if key not in after], [key for key in after if key not in before]
        renamed = list(zip(lost, new)) if len(lost) == len(new) else []
        tally.texts.update(f"{one!r} -> {other!r}" for one, other in renamed)
        if len(lost) != len(new) or FAILED in (before | after):
            tally.value(f"{place} (entries)", lost, new or FAILED)
        for one, other in [*((key, key) for key in before if key in after), *renamed]:
            walk(f"{place}/{one}", before[one], after[other], tally, one in FIXED_WORDS)
    elif isinstance(before, list) and isinstance(after, list):
        if not fixed and before + after and all(isinstance(v, str) for v in before + after):
            lost, new = (list((Counter(a) - Counter(b)).elements()) for a, b in ((before, after), (after, before)))
            tally.texts.update([f"{lost} -> {new}"] if lost or new else [])
            return
        tally.value(f"{place} (length)", len(before), len(after))
        scale = scale or largest([before, after])
        for k, (one, other) in enumerate(zip(before, after)):
            walk(f"{place}[{k}]", one, other, tally, fixed, scale)
    elif isinstance(before, str) and isinstance(after, str) and not fixed:
        tally.texts.update([f"{before!r} -> {after!r}"] if before != after else [])
    else:
        tally.value(place, before, after, scale)


def compare(before: Path, after: Path) -> bool:
    """Print what differs between two recordings; whether nothing does."""
    one, other = (json.loads(path.read_text(encoding="utf-8"))["sections"] for path in (before, after))
    tallies = {name: Tally(TOLERANCE[name]) for name in one if name in other}
    for name, tally in tallies.items():
        walk(name, one[name]["data"], other[name]["data"], tally)
        print("".join(f"text only, {count} times: {words}\n" for words, count in tally.texts.items()), end="")
    print("".join(f"{line}\n" for tally in tallies.values() for line in tally.different), end="")
    print(f"{'section':12} {'compared':>9} {'different':>10} {'largest relative':>17} {'tolerance':>10} {'texts':>6}")
    for name, t in tallies.items():
        print(f"{name:12} {t.compared:9} {len(t.different):10} {t.largest:17.2g} {t.tolerance:10.0e} {len(t.texts):6}")
    print("".join(f"{name:12} is in one recording only\n" for name in sorted(one.keys() ^ other.keys())), end="")
    if "practice" in tallies:
        print("practice: " + ", then ".join("{right} of {of}".format(**s["practice"]["data"]) for s in (one, other)))
    return bool(tallies) and not any(tally.different for tally in tallies.values())


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    commands = parser.add_subparsers(dest="command", required=True)
    r = commands.add_parser("record", help="run the program and write its numbers to a file")
    r.add_argument("out", type=Path)
    r.add_argument("--practice", type=Path, help="folder of record folders, with key.json to score them")
    r.add_argument("--jobs", type=int, default=2)
    r.add_argument("--only", default=",".join(TOLERANCE), help="sections, comma-separated")
    r.add_argument("--checkout", type=Path, default=Path(__file__).resolve().parents[1], help="the code to run")
    c = commands.add_parser("compare", help="compare two recordings; exit status 1 if a value differs")
    c.add_argument("before", type=Path)
    c.add_argument("after", type=Path)
    a = parser.parse_args()
    if a.command == "compare":
        sys.exit(0 if compare(a.before, a.after) else 1)
    only = [name for name in a.only.split(",") if name != "practice" or a.practice]
    if unknown := set(only) - TOLERANCE.keys():
        parser.error(f"no section {', '.join(sorted(unknown))}: there are {', '.join(TOLERANCE)}")
    record(a.out, a.checkout, a.practice, a.jobs, only)


if __name__ == "__main__":
    main()
