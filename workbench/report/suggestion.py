"""What `suggest` found, for people, scripts and the report."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

from rich.table import Table

from stagecad.parameters.atomic import atomic_write_text
from sysid.experiment_design.t_optimal_design import DesignValue, Suggestion, columns_of
from workbench.options import Run
from workbench.report.page import report_folder
from workbench.report.sections import Section

SETTLED = 5.0
"""Deviations from which two rivals are told apart."""


def sentences(found: Suggestion) -> list[str]:
    """What to do next, in words."""
    lines = []
    if found.revisited:
        lines.append(
            f"Nothing is missing now; {found.revisited}, added last, is weighed against what could stand in its place."
        )
    if len(found.rivals) < 2:
        what = {
            "adequate": "what is left is noise, and nothing is to be separated",
            "unexplained": "no effect of the library explains what is left, so none is to be separated",
        }.get(found.diagnosis.verdict, f"{found.diagnosis.effect} has no rival")
        return [*lines, f"{what}: the space-filling motion looks for what these records never showed."]
    for name in found.inseparable:
        lines.append(
            f"no motion of this family separates {found.rivals[0]} from {name}: on this rig, with these channels, they "
            "are one thing under two names."
        )
    best = found.motions[0]
    for pair in best.pairs:
        if pair.effects[1] in found.inseparable:
            continue
        lines.append(
            f"run {best.motion.name}: separates {pair.effects[1]} from {pair.effects[0]} at {_sigma(pair.deviations)} "
            f"in {best.motion.seconds:.0f} s; these records: {_sigma(pair.records)}"
            + (" (told apart already)" if pair.records >= SETTLED else "")
        )
    return lines


def _sigma(deviations: float) -> str:
    return f"{deviations:.1f} sigma" if deviations < 100.0 else f"{deviations:.0f} sigma"


def suggestion_table(found: Suggestion) -> Table:
    """Motions with what each would separate."""
    table = Table(title="Motions, the one that separates most per second first", title_justify="left")
    for name in ("motion", "seconds", "would separate", "sigma", "these records", "brings out"):
        table.add_column(name, justify="right" if name in ("seconds", "sigma", "these records") else "left")
    for worth in found.motions:
        first = True
        for pair in worth.pairs or (None,):
            table.add_row(
                worth.motion.name if first else "",
                f"{worth.motion.seconds:.1f}" if first else "",
                f"{pair.effects[0]} from {pair.effects[1]}" if pair else "",
                f"{pair.deviations:.1f}" if pair else "",
                f"{pair.records:.1f}" if pair else "",
                worth.motion.reason if first else "",
            )
            first = False
    return table


def write_motions(run: Run, found: Suggestion) -> list[Path]:
    """Every motion as CSV below `run.out`, ready to run."""
    import pandas as pd

    folder = report_folder(run, found.case.experiment.folder.name) / "suggest"
    paths = []
    for worth in found.motions:
        path = folder / (re.sub(r"\W+", "_", worth.motion.name) + ".csv")
        table = pd.DataFrame(columns_of(found.case, worth.motion))
        atomic_write_text(path, table.to_csv(index=False, float_format="%.9g", lineterminator="\n"))
        paths.append(path)
    return paths


def worth_json(worth: DesignValue, path: Path) -> dict[str, Any]:
    """A motion as it stands in the document of `suggest`."""
    return {
        "motion": worth.motion.name,
        "reason": worth.motion.reason,
        "seconds": worth.motion.seconds,
        "separates": [
            {"effects": list(p.effects), "deviations": p.deviations, "these_records": p.records} for p in worth.pairs
        ],
        "deviations": worth.least,
        "deviations_squared_per_second": worth.rate,
        "file": str(path),
    }


def _title(found: Suggestion) -> str:
    if len(found.rivals) < 2:
        return "What to measure next"
    unsettled = [p for p in found.motions[0].pairs if p.effects[1] not in found.inseparable and p.records < SETTLED]
    return f"What to measure next: {found.motions[0].motion.name if unsettled else 'nothing is left to separate'}"


def suggestion_section(found: Suggestion) -> Section:
    """The section of the report."""
    case, best = found.case, found.motions[0]
    return {
        "kind": "suggest",
        "title": _title(found),
        "effects": [e.name for e in case.start.effects],
        "records": {record.name: record.sha256 for record in case.records},
        "state": "good" if found.diagnosis.verdict == "adequate" else "found",
        "number": f"{best.least:.3g} σ" if best.least > 0.0 else "–",
        "headline": " ".join(line[0].upper() + line[1:].rstrip(".") + "." for line in sentences(found)),
        "motions": [
            {
                "motion": w.motion.name,
                "reason": w.motion.reason,
                "seconds": f"{w.motion.seconds:.1f}",
                "separates": [
                    {
                        "names": f"{p.effects[0]} from {p.effects[1]}",
                        "sigma": f"{p.deviations:.1f}",
                        "now": f"{p.records:.1f}",
                    }
                    for p in w.pairs
                ],
            }
            for w in found.motions
        ],
    }
