"""`suggest`: the next motion that would best separate the competing effects of an experiment."""

from __future__ import annotations

from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any

from sysid.experiment_design.t_optimal_design import Suggestion as Found
from sysid.experiment_design.t_optimal_design import columns_of
from sysid.experiment_design.t_optimal_design import suggest as suggest_motions
from sysid.report import suggestion_json
from workbench.api.measurement.diagnosis import Diagnosis
from workbench.api.measurement.experiment import Experiment, as_experiment
from workbench.api.measurement.fitted import document
from workbench.cli.options import results_in
from workbench.operations.progress import ProgressCallback
from workbench.operations.result import Result

if TYPE_CHECKING:
    import pandas as pd
    from matplotlib.figure import Figure

    from workbench.operations.design import Design


class Suggestion(Result):
    """Motions for the next measurement, best first."""

    def __init__(self, experiment: Experiment, found: Found, files: tuple[str, ...] = ()) -> None:
        self.experiment = experiment
        self.found = found
        self.files = files

    @property
    def diagnosis(self) -> Diagnosis:
        """The diagnosis whose competing effects are compared."""
        return Diagnosis(self.experiment, self.found.diagnosis)

    @property
    def competing(self) -> tuple[str, ...]:
        """The effects compared, best first."""
        return self.found.competing

    @cached_property
    def motions(self) -> dict[str, pd.DataFrame]:
        """The motions as tables with columns `name [unit]`, by name, best first."""
        import pandas as pd

        return {m.motion.name: pd.DataFrame(columns_of(self.found.problem, m.motion)) for m in self.found.motions}

    def to_dataframe(self) -> pd.DataFrame:
        """A row for each motion: seconds, and the distance of the closest two effects in standard deviations."""
        import pandas as pd

        rows = [
            {
                "motion": m.motion.name,
                "seconds": m.motion.seconds,
                "deviations": m.least,
                "deviations_squared_per_second": m.rate,
                "reason": m.motion.reason,
            }
            for m in self.found.motions
        ]
        return pd.DataFrame(rows).set_index("motion")

    def write(self, folder: str | Path) -> Suggestion:
        """Write every motion as a CSV file into a folder; returns the suggestion with its files."""
        from workbench.report.page import motion_files

        return Suggestion(self.experiment, self.found, tuple(motion_files(self.found, Path(folder))))

    def to_json(self) -> list[dict[str, Any]]:
        """The document of `stagecad suggest --json`; `file` is null where the motions were not written."""
        return document(suggestion_json(self.found, self.files or (None,) * len(self.found.motions)))

    def plot(self, motion: str | None = None) -> Figure:
        """A motion over time; the best one when left out.

        Raises:
            InputError: no such motion.
        """
        from workbench.api.figures.results import motion_figure

        return motion_figure(self.motions, motion)

    def write_below(self, out: str | Path) -> Suggestion:
        """Write the motions below the folder `out` as `stagecad suggest` does; returns it with its files."""
        from workbench.report.page import write_motions

        rows = write_motions(results_in(out), self.found)
        return Suggestion(self.experiment, self.found, tuple(row["file"] for row in rows))

    @property
    def statements(self) -> list[str]:
        """The result in words."""
        from workbench.identification.statements import suggestion_statements

        return suggestion_statements(self.found)

    def write_report(self, out: str | Path) -> Path:
        """Write the report of `stagecad suggest` below the folder `out`; returns the file to open."""
        from workbench.report.page import write_suggestion

        return write_suggestion(results_in(out), self.found, self.to_json())

    def summary(self) -> list[tuple[str, str]]:
        return [("result", line) for line in self.statements]

    def __repr__(self) -> str:
        best = self.found.motions[0]
        competing = f" for {', '.join(self.competing)}" if len(self.competing) > 1 else ""
        return f"<Suggestion for '{self.experiment.name}': {best.motion.name}, {best.motion.seconds:.0f} s{competing}>"


def suggest(
    experiment: Experiment | str | Path, design: Design | None = None, progress: ProgressCallback | None = None
) -> Suggestion:
    """Diagnose an experiment, and rank motions by how well they separate the effects that its records do not.

    Args:
        experiment: the experiment, or its folder.
        design: where the folder's file states a value as `"design"`.
        progress: called with the name of a step, its number, and the number of steps.

    Raises:
        InputError: one line on the fault in a file or a record.
    """
    found = as_experiment(experiment, design)
    return Suggestion(found, suggest_motions(found.problem, progress=progress))
