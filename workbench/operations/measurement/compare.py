"""`compare`: the stated model of an experiment, fitted and held against its records."""

from __future__ import annotations

from collections.abc import Iterator
from functools import cached_property, partial
from pathlib import Path
from typing import Any, Literal

from stagecad.deferred import pd
from stagecad.processes import parallel_map
from sysid import compare as identification
from sysid.documents import comparison_json, parameter_unit
from sysid.estimation.bootstrap import Bootstrap, bootstrap_of, refit_of, refitted
from sysid.estimation.covariance import public_key
from workbench.figures.identification import bootstrap_figure
from workbench.figures.plot import Plot, save_figures
from workbench.operations.design import Design
from workbench.operations.measurement import tables
from workbench.operations.measurement.experiment import Experiment, as_experiment, noise_text
from workbench.operations.measurement.fitted import FittedResult, error_frame, where_frame
from workbench.operations.measurement.statements import comparison_statement, held_out_over_noise, is_adequate
from workbench.operations.result import Line, Note, ProgressCallback, Table, Warned, counted, finite, silent

Kind = Literal["overlay", "residual", "maps", "loops"]


class Comparison(FittedResult):
    """The stated model, fitted: errors over the noise, residuals, and on what the residual depends."""

    computed: identification.Comparison

    @property
    def errors(self) -> pd.DataFrame:
        """rms (SI), error over noise and fit percent; index `records`, `channel`."""
        return error_frame(self.document["before"])

    @property
    def where(self) -> pd.DataFrame:
        """Coordinates that the residual depends on: share of its variance and p value; index `coordinate`."""
        return where_frame(self.document["where"])

    def to_dataframe(self) -> pd.DataFrame:
        """Measured and predicted channels and residuals, SI; index `record`, `time`."""
        return self.overlay

    @cached_property
    def document(self) -> dict[str, Any]:
        """The document of `stagecad compare --json`."""
        return finite(comparison_json(self.computed))

    def plot(self, kind: Kind = "overlay", record: str | None = None, channel: str | None = None) -> Plot:
        """A figure.

        Args:
            kind: `overlay` of measurement and prediction with the residual, `maps` of the residual over each
                coordinate, or `loops`: force against velocity and position.
            record: name; the one with the largest error when left out.
            channel: name; the force, or the first one measured.
        """
        return self._figure(kind, {"model": self.fitted.model}, record, channel)

    @property
    def statement(self) -> str:
        """The result in words."""
        return comparison_statement(self.computed)

    @property
    def adequate(self) -> bool:
        """Whether the residual is at the noise level."""
        return is_adequate(self.computed)

    def lines(self) -> Iterator[Line]:
        """What `stagecad compare` prints: tables and sentences."""
        document, simulation = self.document, tables.simulation_table(self.document)
        yield from (Note(f"note: {note}") for note in self.problem.notes)
        yield f"noise: {noise_text(self.problem)}"
        effects = ", ".join(document["effects"]) or "no effects"
        yield tables.error_table(f"Model as it stands: {effects}", document["before"])
        same = self.computed.simulation.note or "the prediction is the simulation from the inputs: the same errors"
        yield simulation if simulation.rows else same
        yield tables.parameter_table(document["parameters"])
        yield from document["not_identifiable"]
        correlation = tables.correlation_table(document)
        yield correlation
        yield correlation.note
        if not self.adequate:
            yield tables.dependence_table(document["where"][: tables.MOST_COORDINATES])
        yield from (Warned(line) for line in self.computed.warnings)
        yield self.statement

    def bootstrap(
        self, draws: int, seed: int = 1, scheduler: str | None = None, progress: ProgressCallback = silent
    ) -> Refits:
        """Refit to `draws` sets of records with resampled errors, on the local cores or on a cluster.

        Raises:
            InputError: nothing to fit, too few refits that settled, or no cluster.
        """
        refit, advance = refit_of(self.problem, self.fitted), counted(progress, "refits", draws)
        seeds = [(seed, k) for k in range(draws)]
        settled = parallel_map(partial(refitted, refit), seeds, progress=advance, scheduler=scheduler)
        return Refits(self, bootstrap_of(refit, settled), seed)

    def summary(self) -> list[tuple[str, str]]:
        facts = [("result", self.statement), ("noise", noise_text(self.problem))]
        return facts + [("warning", line) for line in self.computed.warnings]

    def _table(self) -> pd.DataFrame:
        return self.errors

    def __repr__(self) -> str:
        over = tables.over_noise_text(held_out_over_noise(self.computed.fit, self.computed.validate))
        effects = ", ".join(effect.name for effect in self.fitted.model.effects) or "no effects"
        return f"<Comparison of '{self.experiment.name}', model {effects}: {over} the noise on held-out records>"


class Refits:
    """The fitted values of a comparison with the intervals of many refits."""

    def __init__(self, comparison: Comparison, drawn: Bootstrap, seed: int) -> None:
        self.comparison, self.drawn, self.seed = comparison, drawn, seed

    @cached_property
    def document(self) -> dict[str, Any]:
        """The document of `stagecad compare --bootstrap --json`: that of the comparison, with `bootstrap`."""
        drawn, problem = self.drawn, self.comparison.problem
        (low, high), std = drawn.band, drawn.std
        parameters = {
            public_key(key): {
                "value": float(drawn.best[k]),
                "unit": parameter_unit(problem, key),
                "std": float(std[k]),
                "low": float(low[k]),
                "high": float(high[k]),
            }
            for k, key in enumerate(drawn.keys)
        }
        counts = {"draws": drawn.requested, "settled": int(drawn.values.shape[0]), "seed": self.seed}
        return {**self.comparison.document, "bootstrap": {**counts, "parameters": parameters}}

    def table(self) -> Table:
        """The intervals, beside those of the linear covariance."""
        return tables.bootstrap_table(self.document)

    def write_figure(self, out: str | Path) -> Path:
        """Draw the refitted values below the folder `out`."""
        folder = self.comparison.experiment.results_in(out)
        (path,) = save_figures(folder, {"compare_bootstrap": bootstrap_figure(self.drawn, self.document)})
        return path


def compare(experiment: Experiment | str | Path, design: Design | None = None) -> Comparison:
    """Fit the stated model of an experiment, and compare it with the records.

    Args:
        experiment: the experiment, or its folder.
        design: where the folder's file states a value as `"design"`.

    Raises:
        InputError: one line on the fault in a file or a record.
    """
    stated = as_experiment(experiment, design)
    return Comparison(stated, identification.compare(stated.problem))
