"""Follow the loop on real machines, and compare the effects named with what is known of each.

    python benchmarks/real_machines.py --folder FOLDER

FOLDER holds one experiment per machine. The known answer of each machine is in the README of its folder; it is stated
here in names of effects. `known` are the effects that must be named, in any order (`a|b`: either describes what is
known), `also` those that are documented or equivalent and may be named; any other name is false. The loop adds what is
named, and replaces what the program says to replace, until it names nothing. A second count accepts a false first name
where the program states that the records do not distinguish it from a true one (a tie of at most three names).
"""

from __future__ import annotations

import argparse
import json
import shutil
import sys
import tempfile
import time
from concurrent.futures import as_completed
from dataclasses import dataclass
from pathlib import Path
from typing import Any

ROOT = Path(__file__).resolve().parents[1]
sys.path[:0] = [str(ROOT)]

from benchmarks.hidden_effects import run_command  # noqa: E402
from benchmarks.pool import process_pool  # noqa: E402
from benchmarks.scoring import LARGEST_TIE, plain, said, same, worst_over_noise  # noqa: E402

ROUNDS = 5


@dataclass(frozen=True)
class Known:
    """What is known of a machine: effects that must be named, and others that may be."""

    known: tuple[str, ...]
    also: tuple[str, ...] = ()


MACHINES = {
    "emps": Known(("direction_asymmetry",), ("stribeck", "flexible_mode")),
    # An offset and a slope with position are documented: together they are a spring with a rest position.
    "reciprocating_tribometer": Known(("presliding", "constant_bias|cable_spring"), ("run_in", "sensor_drift")),
    "pneumatic_seal": Known(("load_dependent_friction", "direction_asymmetry", "presliding")),
    "dfki_gravity": Known(("gravity_torque",), ("constant_bias",)),
    # An offset and a slope with position, which is what gravity leaves over a limited angle.
    "franka_joint7": Known(("constant_bias|gravity_torque", "presliding"), ("cable_spring",)),
    "piezo_1hz": Known(("piezo_hysteresis",)),
    "hsm150_two_motor": Known(("constant_bias",), ("stribeck",)),
    "laas_cogging_static_quarter": Known(("magnetic_cogging",), ("constant_bias",)),
    "brfd_backlash": Known(("presliding", "backlash", "direction_asymmetry")),
    "oartec_coast_forcedrive": Known(("quadratic_drag",)),
}


@dataclass(frozen=True)
class Followed:
    """The loop on one machine.

    Args:
        machine: folder name.
        rounds: of each diagnosis: verdict and names, error over noise before, best named and free curve with shares.
        right: every known effect was named first, and nothing false.
        with_ties: the same, with the named ties.
        seconds: of all commands.
    """

    machine: str
    rounds: tuple[str, ...]
    right: bool
    with_ties: bool
    seconds: float


def follow(folder: Path) -> Followed:
    """Diagnose a copy of an experiment and add what is named, until nothing is."""
    known = MACHINES[folder.name]
    began, rounds, named = time.perf_counter(), [], []
    with tempfile.TemporaryDirectory() as scratch:
        work = Path(scratch) / folder.name
        shutil.copytree(folder, work)
        place = ["--out", str(Path(scratch) / "out"), "--json"]
        try:
            for _ in range(ROUNDS):
                document = run_command(["diagnose", str(work), "--no-figures", *place])
                verdict, names = said(document)
                rounds.append(f"{verdict} {_details(document)}")
                step = [document["effect"]] if names else _replacement(document)
                if not step:
                    break
                if not names:
                    rounds.append(f"{step[0]} in place of {step[2]}")
                named.append(names or [step[0]])
                run_command(["add", str(work), *step, *place])
        except Exception as error:
            rounds.append(f"failed: {type(error).__name__}: {error}")
    wanted = [name.split("|") for name in known.known]
    allowed = [*(k for group in wanted for k in group), *known.also]

    def right(accepted: int) -> bool:
        """Whether every known effect is among the first names of a round, and one of these is true in every round."""
        first = [names[:accepted] for names in named]
        found = all(any(same(k, name) for k in group for names in first for name in names) for group in wanted)
        return found and all(any(same(name, k) for k in allowed for name in names) for names in first)

    return Followed(folder.name, tuple(rounds), right(1), right(LARGEST_TIE), time.perf_counter() - began)


def _replacement(document: dict[str, Any]) -> list[str]:
    """Arguments of `add` for the first replacement that a diagnosis recommends; empty for none."""
    found = next((swap for swap in document["swaps"] if swap["effect"]), None)
    return [] if found is None else [found["effect"], "--drop", found["instead_of"]]


def _details(document: dict[str, Any]) -> str:
    over = worst_over_noise(document.get("before", {}))
    curve, best = document.get("free_curve"), document.get("best_named")
    parts = [f"at {over:.3g} x the noise" if over is not None else ""]
    if best:
        parts.append(f"best {plain(best['effect'])} {100 * best['share']:.0f} %")
    if curve:
        parts.append(f"curve of {curve['coordinate']} {100 * curve['share']:.0f} %")
    return f"({', '.join(part for part in parts if part)})"


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--folder", type=Path, required=True)
    parser.add_argument("--only", nargs="*")
    parser.add_argument("--jobs", type=int, default=2)
    parser.add_argument("--json", type=Path, help="also write every outcome here")
    a = parser.parse_args()
    names = [name for name in MACHINES if (a.folder / name).is_dir() and (not a.only or name in a.only)]
    rows = []
    with process_pool(a.jobs) as pool:
        for future in as_completed([pool.submit(follow, a.folder / name) for name in names]):
            rows.append(future.result())
            row = rows[-1]
            word = "ok   " if row.right else "tied " if row.with_ties else "WRONG"
            print(f"{word} {row.machine} ({row.seconds:.0f} s)", flush=True)
            for line in row.rounds:
                print(f"      {line}", flush=True)
    tied = sum(row.with_ties for row in rows)
    print(f"{sum(row.right for row in rows)} of {len(rows)} right; {tied} with a tie that contains a true name")
    if a.json:
        a.json.write_text(json.dumps([row.__dict__ for row in rows], indent=1))


if __name__ == "__main__":
    main()
