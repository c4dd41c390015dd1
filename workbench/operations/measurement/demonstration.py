"""`demo`: compare, diagnose and add on packaged records with hidden effects, until nothing is missing."""

from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from typing import Any

from sysid.diagnosis.candidate_screening import Progress
from workbench.operations.measurement.add import add, ladder
from workbench.operations.measurement.compare import compare
from workbench.operations.measurement.diagnose import Diagnosis, diagnose
from workbench.operations.measurement.suggest import suggest_after
from workbench.operations.measurement.tables import parameter_table
from workbench.operations.result import Line
from workbench.operations.templates import remember

MOST_ROUNDS = 5
"""Effects added at most; the packaged records need fewer."""
Step = Callable[[Progress], Sequence[Line]]
"""One command of the demonstration, which returns its lines."""


class Demonstration:
    """Compare, diagnose and add until nothing is missing; suggest, ladder. `document` has those of all steps."""

    def __init__(self, folder: Path, out: Path) -> None:
        self.folder, self.out = folder, out
        self.found: Diagnosis | None = None  # the last one that named an effect
        self.document: dict[str, Any] = {"schema": 1, "experiment": str(folder)}

    def steps(self) -> Iterator[tuple[str, Step]]:
        """The commands in words, each with what does it."""
        yield f"compare {self.folder}", self._compare
        for _ in range(MOST_ROUNDS):
            yield f"diagnose {self.folder}", self._diagnose
            effect = self.document["rounds"][-1]["diagnose"]["effect"]
            if effect is None:
                break
            yield f"add {self.folder} {effect}", self._add
        if self.found is not None:
            yield f"suggest {self.folder}", self._suggest
        yield f"ladder {self.folder}", self._ladder

    def _compare(self, progress: Progress) -> list[Line]:
        comparison = compare(self.folder)
        comparison.write_report(self.out)
        self.document |= {"compare": comparison.document, "rounds": []}
        return [f"  {comparison.statement}\n"]

    def _diagnose(self, progress: Progress) -> list[Line]:
        diagnosis = diagnose(self.folder, progress=progress)
        diagnosis.write_report(self.out)
        self.document["rounds"].append({"diagnose": diagnosis.document})
        if diagnosis.effect is not None:
            self.found = diagnosis
        tried = f"({len(diagnosis.computed.trials)} effects tried in {diagnosis.computed.seconds:.1f} s)\n"
        return [f"  {line}" for line in (diagnosis.statement, diagnosis.ties, tried) if line]

    def _add(self, progress: Progress) -> list[Line]:
        assert self.found is not None and self.found.effect is not None
        addition = add(self.folder, self.found.effect)
        remember(self.folder)
        added = {name: addition.document[name] for name in ("rung", "effects", "after", "parameters")}
        self.document["rounds"][-1]["add"] = added
        return [parameter_table(added["parameters"], f"Rung {added['rung']:03d}, fitted again"), ""]

    def _suggest(self, progress: Progress) -> list[Line]:
        # The diagnosis that led to the effect added last is reused: the command would repeat it.
        assert self.found is not None
        suggestion = suggest_after(self.found).write_below(self.out)
        suggestion.write_report(self.out)
        self.document["suggest"] = suggestion.to_json()
        return [*(f"  {line}" for line in suggestion.statements), ""]

    def _ladder(self, progress: Progress) -> list[Line]:
        rungs = ladder(self.folder)
        report = rungs.write_report(self.out) if rungs.rungs else self.out / self.folder.name / "report.html"
        figure = str(report.parent / "ladder.png") if rungs.rungs else None
        self.document |= {"ladder": rungs.to_json(), "figure": figure, "report": str(report)}
        return list(rungs.lines()) if rungs.rungs else []
