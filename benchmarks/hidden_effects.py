"""Score the loop on experiments with a hidden effect: table by rig, effect and size, with counts and intervals.

    python benchmarks/hidden_effects.py --cases 300 --jobs 2
    python benchmarks/hidden_effects.py --folder FOLDER_OF_CASES
    python benchmarks/hidden_effects.py --kind second --seed 1 --cases 60 --out FOLDER_OF_CASES
    python benchmarks/hidden_effects.py --cases 0 --coverage 40

Cases come from one of three independent simulators (`--kind first`: `benchmarks/generators/hidden_effect`; `second`:
`second_kind`; `several`: `several_effects`, with up to three effects at once) unless a folder with `key.json` is given;
with `--out FOLDER` they are only made.
Every case goes through the command line, so what is scored is what a user gets. Peers see the same records: forward
regression, and pysindy where it is installed (`pip install 'stagecad[peers]'`; `make bench` does), both with a library
of features made by hand (`benchmarks/peers`).
"""

import argparse
import contextlib
import importlib
import importlib.util
import io
import json
import shutil
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from concurrent.futures import as_completed
from dataclasses import asdict, replace
from pathlib import Path
from typing import Any

ROOT = Path(__file__).resolve().parents[1]
sys.path[:0] = [str(ROOT)]

from benchmarks.pool import process_pool  # noqa: E402
from benchmarks.result_table import Names, table  # noqa: E402
from benchmarks.scoring import (  # noqa: E402
    Outcome,
    all_found,
    established,
    first_right,
    hidden_effects,
    kind_of,
    not_hidden,
    plain,
    said,
    share_of,
    size_of,
    worst_over_noise,
)

ROUNDS = 3
TIMEOUT = 300.0
GENERATORS = {
    "first": "benchmarks.generators.hidden_effect",
    "second": "benchmarks.generators.second_kind",
    "several": "benchmarks.generators.several_effects",
}


def run_command(command: list[str]) -> dict[str, Any]:
    """The command's document, by calling the program inside this process."""
    if command[0] == "diagnose" and importlib.util.find_spec("workbench.cli.commands.diagnose") is None:
        from sysid.diagnose import diagnose
        from sysid.documents import diagnosis_json

        return diagnosis_json(diagnose(command[1]))
    from workbench.cli import run

    text, errors = io.StringIO(), io.StringIO()
    with contextlib.redirect_stdout(text), contextlib.redirect_stderr(errors):
        code = run(command)
    if code != 0:
        raise RuntimeError(errors.getvalue().strip()[-300:] or f"exit {code}")
    return json.loads(text.getvalue())


def _as_program(command: list[str]) -> dict[str, Any]:
    """The command's document, by running the program as a user does."""
    done = subprocess.run(
        [sys.executable, "-m", "workbench.cli", *command],
        cwd=ROOT,
        capture_output=True,
        text=True,
        timeout=TIMEOUT,
        check=False,
    )
    if done.returncode != 0:
        raise RuntimeError(done.stderr.strip()[-300:] or f"exit {done.returncode}")
    return json.loads(done.stdout)


def loop(folder: Path, entry: dict[str, Any], *, follow: bool, fresh: bool) -> Outcome:
    """Diagnose one case on a copy of it; where `follow`, add what is named till the loop stops, thrice at most."""
    run: Callable[[list[str]], dict[str, Any]] = _as_program if fresh else run_command
    kind = kind_of(entry)
    out = Outcome(
        case=folder.name,
        kind=kind,
        rig=entry["rig"],
        effect="+".join(hidden_effects(entry)) or entry["effect"],
        size=size_of(entry),
        hard=bool(entry.get("hard")),
        right=False,
        said="",
        accept=tuple(entry["accept"]),
    )
    with tempfile.TemporaryDirectory() as scratch:
        work = Path(scratch) / folder.name
        shutil.copytree(folder, work)
        place = ["--out", str(Path(scratch) / "out"), "--json"]
        start = time.perf_counter()
        try:
            document = run(["diagnose", str(work), "--no-figures", *place])
        except Exception as error:
            return replace(out, failed=f"{type(error).__name__}: {error}", said="failed")
        seconds = time.perf_counter() - start
        verdict, names = said(document)
        where = [row["coordinate"] for row in document.get("where", [])]
        several, listed = kind in ("pair", "chain"), established(document)
        out = replace(
            out,
            right=first_right(document, entry),
            said=verdict,
            tied=max(len(names), 1),
            at_once=all_found(hidden_effects(entry), listed) if several else None,
            established=tuple(names[0] for names in listed),
            false=not_hidden(listed, entry),
            remainder=document.get("remainder", {}).get("over_noise"),
            seconds=seconds,
            best_named=share_of(document, "best_named", "effect"),
            free_curve=share_of(document, "free_curve", "coordinate"),
            started=worst_over_noise(document.get("before", {})),
            where_right=bool(where) and where[0] in entry["where"] if entry.get("where") else None,
        )
        if not follow or kind in ("none", "unexplained"):
            return out
        added: list[str] = []
        told: list[list[str]] = []
        try:
            while names and len(added) < ROUNDS:
                run(["add", str(work), document["effect"], *place])
                added.append(plain(document["effect"]))
                told.append(names)
                document = run(["diagnose", str(work), "--no-figures", *place])
                verdict, names = said(document)
                if kind == "single" and not out.right:
                    break
        except Exception as error:
            failed = f"{type(error).__name__}: {error}"
            return replace(out, failed=failed, added=tuple(added), both=False if several else None)
        return replace(
            out,
            added=tuple(added),
            both=all_found(hidden_effects(entry), told) if several else None,
            held_out=worst_over_noise(document.get("before", {})) if out.right else None,
            stopped=(len(added) == 1) if kind == "single" and out.right else None,
        )


def _shares(outcome: Outcome) -> str:
    found = [one for one in (outcome.best_named, outcome.free_curve) if one]
    return f"({', '.join(f'{name} {100 * share:.0f} %' for name, share in found)})" if found else ""


def peers(folder: Path) -> Names:
    """Effects that each peer names on the same records, first the one that matters most; none of a simulated rig."""
    from benchmarks.peers import forward_regression, sparse_library
    from benchmarks.peers.features import read_problems

    if (problems := read_problems(folder)) is None:
        return {}
    fit, held = problems
    found = {"forward regression": forward_regression.name_missing(fit, held)}
    if sparse_library.available():
        found["pysindy"] = sparse_library.name_missing(fit, held)
    return found


def _job(task: tuple[Path, dict[str, Any], bool, bool, bool]) -> tuple[Outcome, Names]:
    folder, entry, follow, fresh, with_peers = task
    return loop(folder, entry, follow=follow, fresh=fresh), peers(folder) if with_peers else {}


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--cases", type=int, default=300, help="how many to make (without --folder)")
    parser.add_argument("--seed", type=int, default=7)
    parser.add_argument("--kind", choices=list(GENERATORS), default="first", help="the simulator that makes the cases")
    parser.add_argument("--out", type=Path, help="make the cases and key.json in this folder, and judge nothing")
    parser.add_argument("--folder", type=Path, help="a folder of cases with key.json, in place of making them")
    parser.add_argument("--only", nargs="*", help="names of cases, or parts of effect names")
    parser.add_argument("--jobs", type=int, default=2)
    parser.add_argument("--no-follow", action="store_true", help="diagnose only; do not add and diagnose again")
    parser.add_argument("--no-peers", action="store_true")
    parser.add_argument("--fresh", action="store_true", help="a new process for every command, as a user's")
    parser.add_argument("--coverage", type=int, help="cases for the coverage of intervals (a quarter of --cases)")
    parser.add_argument("--json", type=Path, help="also write every outcome here")
    a = parser.parse_args()
    if a.out is not None:
        importlib.import_module(GENERATORS[a.kind]).make_cases(a.out, a.seed, a.cases, jobs=a.jobs)
        return
    with tempfile.TemporaryDirectory() as scratch:
        folder = a.folder
        if folder is None and a.cases > 0:
            make_cases = importlib.import_module(GENERATORS[a.kind]).make_cases
            folder = Path(scratch) / "cases"
            print(f"making {a.cases} cases", file=sys.stderr)
            make_cases(folder, a.seed, a.cases, jobs=a.jobs)
        rows: list[tuple[Outcome, Names]] = []
        if folder is not None:
            key = json.loads((folder / "key.json").read_text(encoding="utf-8"))
            wanted = [
                name
                for name, entry in key.items()
                if not a.only or any(part == name or part in entry["effect"] for part in a.only)
            ]
            tasks = [(folder / name, key[name], not a.no_follow, a.fresh, not a.no_peers) for name in wanted]
            with process_pool(a.jobs) as pool:
                waiting = [pool.submit(_job, task) for task in tasks]
                for done, future in enumerate(as_completed(waiting), 1):
                    rows.append(future.result())
                    o = rows[-1][0]
                    mark = "ok   " if o.right and not o.failed and o.both is not False else "WRONG"
                    print(
                        f"{done}/{len(tasks)} {mark} {o.case} {o.rig} {o.effect} {o.size}{' hard' if o.hard else ''}:"
                        f" {o.said} {_shares(o)} {o.failed}",
                        file=sys.stderr,
                        flush=True,
                    )
            rows.sort(key=lambda row: row[0].case)
            print(table([row[0] for row in rows], [row[1] for row in rows]))
            if a.json:
                a.json.write_text(json.dumps([asdict(row[0]) | {"peers": row[1]} for row in rows], indent=1))
        coverage = a.coverage if a.coverage is not None else a.cases // 4 if a.folder is None else 0
        if coverage:
            from benchmarks.interval_coverage import coverage_table

            print(f"\n{coverage_table(coverage, a.seed, Path(scratch) / 'coverage', a.jobs)}")


if __name__ == "__main__":
    main()
