"""Every effect that may be hidden in a driven stage, through compare, diagnose and add: what is named, what is left.

    python -m benchmarks.friction_drive [--kinds piezo_hysteresis ...] [--seeds 1 2] [--rows 2000] [--jobs 1]
    python -m benchmarks.friction_drive --kept FILE [--kinds ...]     # continues; a table of all results

Records come from a generator with laws and an integrator of its own (`benchmarks/generators/driven_stage`). A
case is right where the name is right, or ties with at most two others, and adding it leaves at most 1.5 times the noise
on the held-out record; where nothing is hidden, if nothing is named; where no library has it, if `unexplained`.
"""

import argparse
import json
import sys
import tempfile
import time
from collections.abc import Iterable
from concurrent.futures import as_completed
from dataclasses import asdict, dataclass
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
sys.path[:0] = [str(ROOT)]

from benchmarks.generators.driven_stage import HIDDEN, write_case  # noqa: E402
from benchmarks.pool import process_pool  # noqa: E402
from benchmarks.scoring import LARGEST_TIE, plain  # noqa: E402

MOST_LEFT = 1.5
"""Times the noise that a right effect, added, may leave."""


@dataclass(frozen=True)
class Row:
    """One case, judged.

    Args:
        kind, motion, seed: of the case.
        verdict: of the diagnosis; `failed` where it, or adding, raised.
        effect: named; empty where none is.
        ties: effects that these records cannot distinguish from it.
        before, after: error over noise on the held-out record, before and after the named effect was added; where
            another than the hidden one was named, `right_after` is what the right one leaves.
        seconds: of processor time: comparing, diagnosing, adding.
    """

    kind: str
    motion: str
    seed: int
    verdict: str
    effect: str
    ties: tuple[str, ...]
    before: float
    after: float | None
    seconds: tuple[float, float, float]
    right_after: float | None = None
    failed: str = ""

    @property
    def named_right(self) -> bool:
        """Whether the verdict is right, whatever error is left."""
        accept = HIDDEN[self.kind].accept
        if not accept:
            return self.verdict == "adequate"
        if self.verdict == "unexplained":
            return "unexplained" in accept
        names = [plain(name) for name in (self.effect, *self.ties) if name]
        return bool(set(names) & set(accept)) and (names[0] in accept or len(names) <= LARGEST_TIE)

    @property
    def right(self) -> bool:
        """Whether the verdict is right, and the error left is small."""
        return self.named_right and (self.after is None or self.after <= MOST_LEFT)


def run_case(kind: str, motion: str, seed: int, rows: int) -> Row:
    """Compare, diagnose, and add what is named to one case."""
    from sysid.add import add_effects
    from sysid.compare import compare
    from sysid.diagnose import diagnose

    seconds = [0.0, 0.0, 0.0]
    verdict, effect, ties, before, after, right_after, failed = "failed", "", (), float("nan"), None, None, ""
    with tempfile.TemporaryDirectory() as scratch:
        folder = Path(scratch)
        write_case(folder, kind, motion, seed, rows)
        try:
            clock = time.process_time()
            before = compare(folder).validate["position"].over_noise
            seconds[0] = time.process_time() - clock
            clock = time.process_time()
            found = diagnose(folder)
            seconds[1] = time.process_time() - clock
            verdict, effect, ties = found.verdict, found.effect or "", found.indistinguishable
            accept = [name for name in HIDDEN[kind].accept if name != "unexplained"]
            if not effect and accept:
                right_after = _left(folder / "right", kind, motion, seed, rows, accept[0])
            if effect:
                if accept and plain(effect) not in accept:
                    right_after = _left(folder / "right", kind, motion, seed, rows, accept[0])
                clock = time.process_time()
                after = add_effects(folder, [effect]).after_validate["position"].over_noise
                seconds[2] = time.process_time() - clock
        except Exception as error:
            verdict, failed = "failed", f"{type(error).__name__}: {error}"
    return Row(
        kind, motion, seed, verdict, effect, ties, before, after, (seconds[0], seconds[1], seconds[2]), right_after,
        failed,
    )  # fmt: skip


def _left(folder: Path, kind: str, motion: str, seed: int, rows: int, effect: str) -> float:
    """Error over noise on the held-out record that the right effect leaves."""
    from sysid.add import add_effects

    write_case(folder, kind, motion, seed, rows)
    return add_effects(folder, [effect]).after_validate["position"].over_noise


def table(rows: Iterable[Row]) -> str:
    """The results as a Markdown table, with a line of counts."""
    ordered = sorted(rows, key=lambda r: (list(HIDDEN).index(r.kind), r.motion, r.seed))
    lines = [
        "| hidden | motion | seed | verdict | named | tied with | before | after | s compare | diagnose | add | |",
        "| --- | --- | ---: | --- | --- | --- | ---: | ---: | ---: | ---: | ---: | --- |",
    ]
    for r in ordered:
        note = "" if r.right else r.failed or ("left" if r.named_right else "WRONG")
        if r.right_after is not None:
            note += f" (right one leaves {r.right_after:.2f})"
        after = "" if r.after is None else f"{r.after:.2f}"
        cells = [
            r.kind, r.motion, str(r.seed), r.verdict, r.effect, ", ".join(r.ties), f"{r.before:.2f}", after,
            *(f"{s:.0f}" for s in r.seconds), note,
        ]  # fmt: skip
        lines.append("| " + " | ".join(cells) + " |")
    right = sum(r.right for r in ordered)
    named = sum(r.named_right for r in ordered)
    lines.append(f"\nright {right} of {len(ordered)}; named rightly {named}")
    return "\n".join(lines)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--kinds", nargs="*", default=list(HIDDEN), help="of hidden effect; all where left out")
    parser.add_argument("--motions", nargs="*", help="those that a kind has among these; the first of each if left out")
    parser.add_argument("--seeds", nargs="*", type=int, default=[1])
    parser.add_argument("--rows", type=int, default=2000)
    parser.add_argument("--jobs", type=int, default=1)
    parser.add_argument("--kept", type=Path, help="a file of results to go on with: what it holds is not run again")
    a = parser.parse_args()
    if unknown := [kind for kind in a.kinds if kind not in HIDDEN]:
        parser.error(f"no such kind: {', '.join(unknown)}; there are {', '.join(HIDDEN)}")
    rows = _read(a.kept)
    done = {(r.kind, r.motion, r.seed) for r in rows}
    tasks = []
    for kind in a.kinds:
        motions = HIDDEN[kind].motions
        chosen = [m for m in motions if m in a.motions] if a.motions else motions[:1]
        tasks += [(kind, m, seed) for m in chosen for seed in a.seeds if (kind, m, seed) not in done]
    with process_pool(a.jobs) as pool:
        waiting = [pool.submit(run_case, *task, a.rows) for task in tasks]
        for count, future in enumerate(as_completed(waiting), 1):
            row = future.result()
            rows.append(row)
            if a.kept is not None:
                with a.kept.open("a", encoding="utf-8") as file:
                    file.write(json.dumps(asdict(row)) + "\n")
            print(f"{count}/{len(tasks)}", table([row]).splitlines()[2], file=sys.stderr, flush=True)
    print(table(rows))


def _read(kept: Path | None) -> list[Row]:
    if kept is None or not kept.exists():
        return []
    found = [json.loads(line) for line in kept.read_text(encoding="utf-8").splitlines()]
    return [Row(**{**row, "ties": tuple(row["ties"]), "seconds": tuple(row["seconds"])}) for row in found]


if __name__ == "__main__":
    main()
