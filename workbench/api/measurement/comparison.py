"""`compare`: the stated model of an experiment, fitted and held against its records."""

from __future__ import annotations

from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

from sysid.compare import Comparison as Found
from sysid.compare import compare as compare_problem
from sysid.report import comparison_json
from workbench.api.measurement.experiment import Experiment, as_experiment
from workbench.api.measurement.fitted import FittedResult, document, error_frame
from workbench.cli.options import results_in

if TYPE_CHECKING:
    import pandas as pd
    from matplotlib.figure import Figure

    from workbench.operations.design import Design

Kind = Literal["overlay", "residual", "maps", "loops"]


class Comparison(FittedResult):
    """The stated model, fitted: errors over the noise, residuals, and on what the residual depends."""

    found: Found

    @property
    def errors(self) -> pd.DataFrame:
        """rms (SI), error over noise and fit percent; index `records`, `channel`."""
        return error_frame(self._document["before"])

    @property
    def where(self) -> pd.DataFrame:
        """Coordinates that the residual depends on: share of its variance and p value; index `coordinate`."""
        return where_frame(self._document["where"])

    def to_dataframe(self) -> pd.DataFrame:
        """Measured and predicted channels and residuals, SI; index `record`, `time`."""
        return self.overlay

    @cached_property
    def _document(self) -> dict[str, Any]:
        return document(comparison_json(self.found))

    def plot(self, kind: Kind = "overlay", record: str | None = None, channel: str | None = None) -> Figure:
        """A figure.

        Args:
            kind: `overlay` of measurement and prediction with the residual, `maps` of the residual over each
                coordinate, or `loops`: force against velocity and position.
            record: name; the one with the largest error when left out.
            channel: name; the force, or the first one measured.
        """
        from workbench.api.figures.results import model_figure

        return model_figure(self.problem, {"model": self.fitted.model}, self.found.maps, kind, record, channel)

    @property
    def statement(self) -> str:
        """The result in words."""
        from workbench.identification.statements import comparison_statement

        return comparison_statement(self.found)

    @property
    def adequate(self) -> bool:
        """Whether the residual is at the noise level."""
        from workbench.identification.statements import is_adequate

        return is_adequate(self.found)

    def write_report(self, out: str | Path) -> Path:
        """Write figures and the report of `stagecad compare` below the folder `out`; returns the file to open."""
        from workbench.report.page import write_comparison

        return write_comparison(results_in(out), self.found, self.to_json())

    def summary(self) -> list[tuple[str, str]]:
        from workbench.identification.statements import noise_text

        facts = [("result", self.statement), ("noise", noise_text(self.problem))]
        return facts + [("warning", line) for line in self.found.warnings]

    def _table(self) -> pd.DataFrame:
        return self.errors

    def __repr__(self) -> str:
        from workbench.identification.statements import held_out_over_noise
        from workbench.identification.tables import over_noise_text

        over = over_noise_text(held_out_over_noise(self.found.fit, self.found.validate))
        effects = ", ".join(effect.name for effect in self.fitted.model.effects) or "no effects"
        return f"<Comparison of '{self.experiment.name}', model {effects}: {over} the noise on held-out records>"


def where_frame(where: list[dict[str, Any]]) -> pd.DataFrame:
    """Dependence of a residual as a table; a p value below the resolution of the permutations is that resolution."""
    import pandas as pd

    rows = [
        {**row, "p_value": row["p_value"]["below"] if isinstance(row["p_value"], dict) else row["p_value"]}
        for row in where
    ]
    return pd.DataFrame(rows, columns=["coordinate", "share", "p_value"]).set_index("coordinate")


def compare(experiment: Experiment | str | Path, design: Design | None = None) -> Comparison:
    """Fit the stated model of an experiment, and compare it with the records.

    Args:
        experiment: the experiment, or its folder.
        design: where the folder's file states a value as `"design"`.

    Raises:
        InputError: one line on the fault in a file or a record.
    """
    found = as_experiment(experiment, design)
    return Comparison(found, compare_problem(found.problem))
