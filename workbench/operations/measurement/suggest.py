"""`suggest`: the next motion that would best separate the competing effects of an experiment."""

from __future__ import annotations

import re
from collections.abc import Iterator
from functools import cached_property
from pathlib import Path
from typing import Any

from stagecad.deferred import pd
from stagecad.parameters.atomic import atomic_write_text
from sysid.documents import suggestion_json
from sysid.experiment_design import t_optimal_design as experiment_design
from workbench.figures.identification import motion_figure
from workbench.figures.plot import Plot
from workbench.operations.design import Design
from workbench.operations.measurement.diagnose import Diagnosis
from workbench.operations.measurement.experiment import Experiment, as_experiment
from workbench.operations.measurement.statements import suggestion_statements
from workbench.operations.measurement.tables import motion_table
from workbench.operations.result import Line, ProgressCallback, Reported, finite, frame, silent


class Suggestion(Reported):
    """Motions for the next measurement, best first."""

    def __init__(
        self, experiment: Experiment, computed: experiment_design.Suggestion, files: tuple[str, ...] = ()
    ) -> None:
        self.experiment = experiment
        self.computed = computed
        self.files = files

    @property
    def diagnosis(self) -> Diagnosis:
        """The diagnosis whose competing effects are compared."""
        return Diagnosis(self.experiment, self.computed.diagnosis)

    @property
    def competing(self) -> tuple[str, ...]:
        """The effects compared, best first."""
        return self.computed.competing

    @cached_property
    def motions(self) -> dict[str, pd.DataFrame]:
        """The motions as tables with columns `name [unit]`, by name, best first."""
        motions = [value.motion for value in self.computed.motions]
        return {m.name: pd.DataFrame(experiment_design.columns_of(self.computed.problem, m)) for m in motions}

    def to_dataframe(self) -> pd.DataFrame:
        """A row for each motion: seconds, and the distance of the closest two effects in standard deviations."""
        columns = ["motion", "seconds", "deviations", "deviations_squared_per_second", "reason"]
        return frame(self.to_json(), "motion", columns=columns)

    def to_json(self) -> list[dict[str, Any]]:
        """The document of `stagecad suggest --json`; `file` is null where the motions were not written."""
        return finite(suggestion_json(self.computed, self.files or (None,) * len(self.computed.motions)))

    def plot(self, motion: str | None = None) -> Plot:
        """A motion over time; the best one when left out.

        Raises:
            InputError: no such motion.
        """
        return motion_figure(self.motions, motion)

    def write(self, folder: str | Path) -> Suggestion:
        """Write every motion as a CSV file into a folder; returns the suggestion with its files."""
        files = []
        for name, table in self.motions.items():
            path = Path(folder) / (re.sub(r"\W+", "_", name) + ".csv")
            atomic_write_text(path, table.to_csv(index=False, float_format="%.9g", lineterminator="\n"))
            files.append(str(path))
        return Suggestion(self.experiment, self.computed, tuple(files))

    def write_below(self, out: str | Path) -> Suggestion:
        """Write the motions below the folder `out` as `stagecad suggest` does; returns it with its files."""
        return self.write(self.experiment.results_in(out) / "suggest")

    @property
    def statements(self) -> list[str]:
        """The result in words."""
        return suggestion_statements(self.computed)

    def lines(self) -> Iterator[Line]:
        """What `stagecad suggest` prints: a table and sentences."""
        yield motion_table(self.to_json())
        yield from self.statements

    def summary(self) -> list[tuple[str, str]]:
        return [("result", line) for line in self.statements]

    def __repr__(self) -> str:
        best = self.computed.motions[0].motion
        competing = f" for {', '.join(self.competing)}" if len(self.competing) > 1 else ""
        return f"<Suggestion for '{self.experiment.name}': {best.name}, {best.seconds:.0f} s{competing}>"


def suggest(
    experiment: Experiment | str | Path, design: Design | None = None, progress: ProgressCallback = silent
) -> Suggestion:
    """Diagnose an experiment, and rank motions by how well they separate the effects that its records do not.

    Args:
        experiment: the experiment, or its folder.
        design: where the folder's file states a value as `"design"`.
        progress: called with the name of a step, its number, and the number of steps.

    Raises:
        InputError: one line on the fault in a file or a record.
    """
    stated = as_experiment(experiment, design)
    return Suggestion(stated, experiment_design.suggest(stated.problem, progress=progress))


def suggest_after(diagnosis: Diagnosis) -> Suggestion:
    """Rank motions by how well they separate the effects of a diagnosis, whose effect named was added since."""
    computed = diagnosis.computed
    motions = experiment_design.motions_for(computed.problem)
    return Suggestion(diagnosis.experiment, experiment_design.rank_motions(computed, motions, computed.effect))
