"""Ledgers of real machines, compared with what is known of each.

    python benchmarks/real_machines.py --folder FOLDER

FOLDER holds one experiment per machine. The known answer of each machine is in the README of its folder; it is stated
here in names of effects. `known` are the effects that must be established, in any order (`a|b`: either describes what
is known), `also` those that are documented or equivalent and may be; any other established effect is false. Every
established effect is added (`add --all`), and again, until none is.
"""

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
from benchmarks.scoring import LARGEST_TIE, established, plain, same, share_of, worst_over_noise  # noqa: E402

ROUNDS = 3


@dataclass(frozen=True)
class Known:
    """What is known of a machine: effects that must be established, and others that may be."""

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
    "odrive_cogging_map": Known(("magnetic_cogging",), ("constant_bias",)),
    "sts3250_pendulum_drop": Known(("gravity_torque",)),
    # A memory over the distance slid follows each step of the speed: rate-and-state friction.
    "sepiolite_velocity_step": Known(("viscous|stribeck",), ("presliding", "frictional_lag")),
}


@dataclass(frozen=True)
class Followed:
    """The ledgers of one machine.

    Args:
        machine: folder name.
        rounds: of each diagnosis: what is established and possible, and the error over noise before and after.
        missed: known effects that no ledger establishes.
        false: established effects that are not known.
        seconds: of all commands.
    """

    machine: str
    rounds: tuple[str, ...]
    missed: tuple[str, ...]
    false: tuple[str, ...]
    seconds: float


def follow(folder: Path) -> Followed:
    """Diagnose a copy of an experiment and add what is established, until nothing is."""
    known = MACHINES[folder.name]
    began, rounds, told = time.perf_counter(), [], []
    with tempfile.TemporaryDirectory() as scratch:
        work = Path(scratch) / folder.name
        shutil.copytree(folder, work)
        place = ["--out", str(Path(scratch) / "out"), "--json"]
        try:
            for _ in range(ROUNDS):
                document = run_command(["diagnose", str(work), "--no-figures", *place])
                rounds.append(_details(document))
                found = established(document)
                told += [names[:LARGEST_TIE] for names in found]
                if not found:
                    break
                run_command(["add", str(work), "--all", *place])
        except Exception as error:
            rounds.append(f"failed: {type(error).__name__}: {error}")
    allowed = [name for group in (*known.known, *known.also) for name in group.split("|")]
    missed = [g for g in known.known if not any(same(k, n) for k in g.split("|") for names in told for n in names)]
    false = [names[0] for names in told if not any(same(n, k) for n in names for k in allowed)]
    return Followed(folder.name, tuple(rounds), tuple(missed), tuple(false), time.perf_counter() - began)


def _details(document: dict[str, Any]) -> str:
    over, after = worst_over_noise(document["before"]), document["remainder"]["over_noise"]
    found = [" = ".join(names) for names in established(document)] or [document["verdict"]]
    possible = [plain(row["effect"]) for row in document["ledger"] if row["state"] == "possible"]
    parts = [f"{over:.3g} x the noise, {after:.3g} x with them"] if over is not None and after is not None else []
    parts += [f"possible {', '.join(possible)}"] if possible else []
    if curve := share_of(document, "free_curve", "coordinate"):
        parts.append(f"curve of {curve[0]} {100 * curve[1]:.0f} %")
    return f"{', '.join(found)} ({'; '.join(parts)})"


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
            word = "WRONG" if row.false else "part " if row.missed else "ok   "
            rest = [f"missed {', '.join(row.missed)}"] * bool(row.missed) + [f"false {', '.join(row.false)}"] * bool(
                row.false
            )
            print(f"{word} {row.machine} ({row.seconds:.0f} s) {'; '.join(rest)}", flush=True)
            for line in row.rounds:
                print(f"      {line}", flush=True)
    right, false = sum(not (row.missed or row.false) for row in rows), sum(bool(row.false) for row in rows)
    print(f"{right} of {len(rows)} with every known effect and no false one; {false} with a false one")
    if a.json:
        a.json.write_text(json.dumps([row.__dict__ for row in rows], indent=1))


if __name__ == "__main__":
    main()
