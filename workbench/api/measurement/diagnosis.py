"""`diagnose`: which physical effect is missing from the model of an experiment."""

from __future__ import annotations

from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

from sysid.diagnose import Diagnosis as Found
from sysid.diagnose import diagnose as diagnose_problem
from sysid.estimation.fit import FittedModel
from sysid.report import diagnosis_json
from workbench.api.measurement.comparison import where_frame
from workbench.api.measurement.experiment import Experiment, as_experiment
from workbench.api.measurement.fitted import FittedResult, document, error_frame
from workbench.cli.options import results_in
from workbench.operations.progress import ProgressCallback

if TYPE_CHECKING:
    import pandas as pd
    from matplotlib.figure import Figure

    from sysid.prediction.model import Model
    from workbench.operations.design import Design

Kind = Literal["overlay", "ranking", "maps", "loops"]


class Diagnosis(FittedResult):
    """Which effect is missing, and how certain that is. Its fitted model has the effect named, where there is one."""

    found: Found

    @property
    def verdict(self) -> str:
        """`missing-effect`, `adequate` or `unexplained`."""
        return self.found.verdict

    @property
    def effect(self) -> str | None:
        """The effect that is missing; none unless the verdict is `missing-effect`."""
        return self.found.effect

    @property
    def indistinguishable(self) -> tuple[str, ...]:
        """Effects that these records cannot distinguish from the one named."""
        return self.found.indistinguishable

    @property
    def reason(self) -> str:
        """Of the verdict, in words."""
        return self.found.reason

    @property
    def fitted(self) -> FittedModel:
        return self.found.base.fitted if self.found.best is None else self.found.best.fitted

    @property
    def ranking(self) -> pd.DataFrame:
        """The effects tried, best first; index `effect`.

        Columns: `law`, the variant that fits best; `rms` on the held-out records (SI), `over_noise`, `reduction` of the
        rms, `p_value`; `aic_change` and `bic_change`, of the information criteria on the records of the fit.
        """
        import pandas as pd

        rows = []
        for row in self._document["ranking"]:
            p, error = row["p_value"], row.get("validate_error") or {}
            rows.append(
                {
                    "effect": row["effect"],
                    "law": row.get("law", row["effect"]),
                    "rms": error.get("value"),
                    "unit": error.get("unit"),
                    "over_noise": row.get("over_noise"),
                    "reduction": row.get("reduction"),
                    "p_value": p["below"] if isinstance(p, dict) else p,
                    "aic_change": row.get("aic_change"),
                    "bic_change": row.get("bic_change"),
                }
            )
        columns = ["effect", "law", "rms", "unit", "over_noise", "reduction", "p_value", "aic_change", "bic_change"]
        return pd.DataFrame(rows, columns=columns).set_index("effect")

    @property
    def errors(self) -> pd.DataFrame:
        """Errors before and with the effect named; index `model`, `records`, `channel`."""
        import pandas as pd

        both = {"before": error_frame(self._document["before"])}
        if self.found.best is not None:
            both[f"with {self.effect}"] = error_frame(self._document["after"])
        return pd.concat(both, names=["model"])

    @property
    def where(self) -> pd.DataFrame:
        """Coordinates that the residual before depends on: share of its variance and p value."""
        return where_frame(self._document["where"])

    def to_dataframe(self) -> pd.DataFrame:
        """The ranking."""
        return self.ranking

    @cached_property
    def _document(self) -> dict[str, Any]:
        return document(diagnosis_json(self.found))

    def plot(self, kind: Kind = "overlay", record: str | None = None, channel: str | None = None) -> Figure:
        """A figure.

        Args:
            kind: `overlay` of measurement and predictions before and with the best effect, `ranking`, `maps` of the
                residual before over each coordinate, or `loops`: force against velocity and position.
            record: name; the one with the largest error when left out.
            channel: name; the force, or the first one measured.
        """
        from workbench.api.figures.results import model_figure, ranking_figure

        if kind == "ranking":
            return ranking_figure(self)
        best = self.found.best or (self.found.trials[0] if self.found.trials else None)
        models = {"before": self.found.base.fitted.model}
        if best is not None and self.verdict != "adequate":
            models[f"with {best.public_name}"] = best.fitted.model
        return model_figure(self.problem, models, self.found.maps, kind, record, channel)

    @property
    def statement(self) -> str:
        """The result in words."""
        from workbench.identification.statements import diagnosis_statement

        return diagnosis_statement(self.found)

    @property
    def ties(self) -> str:
        """The effects that these records cannot distinguish, in words; empty without any."""
        from workbench.identification.statements import equivalence_statement

        return equivalence_statement(self.found)

    @property
    def remarks(self) -> list[str]:
        """Effects that could replace each other, values that are not physical, and what to do next, in words."""
        from workbench.identification.statements import (
            next_step_statement,
            replacement_statements,
            unphysical_statements,
        )

        following = next_step_statement(self.found) if self.found.best is None else ""
        remarks = [*replacement_statements(self.found), *unphysical_statements(self.found)]
        return [*remarks, following] if following else remarks

    @property
    def candidates(self) -> dict[str, Model]:
        """The model before (`model`), and the model with each effect that was fitted in full, by its name."""
        tried = {trial.public_name: trial.fitted.model for trial in self.found.trials[: self.found.reported_in_full]}
        return {"model": self.found.base.fitted.model, **tried}

    def write_report(self, out: str | Path) -> Path:
        """Write figures and the report of `stagecad diagnose` below the folder `out`; returns the file to open."""
        from workbench.report.page import write_diagnosis

        return write_diagnosis(results_in(out), self.found, self.to_json())

    def summary(self) -> list[tuple[str, str]]:
        facts = [("result", self.statement), ("ties", self.ties)]
        return [fact for fact in facts if fact[1]] + [("warning", line) for line in self.found.warnings]

    def __repr__(self) -> str:
        ties = f", not distinguishable from {', '.join(self.indistinguishable)}" if self.indistinguishable else ""
        named = f": {self.effect}{ties}" if self.effect else ""
        return f"<Diagnosis of '{self.experiment.name}': {self.verdict}{named}>"


def diagnose(
    experiment: Experiment | str | Path,
    all_effects: bool = False,
    design: Design | None = None,
    progress: ProgressCallback | None = None,
) -> Diagnosis:
    """Find which physical effect is missing from the model of an experiment.

    Args:
        experiment: the experiment, or its folder.
        all_effects: try every effect of the library, not only those of the public names.
        design: where the folder's file states a value as `"design"`.
        progress: called with the name of a step, its number, and the number of steps.

    Raises:
        InputError: one line on the fault in a file or a record.
    """
    found = as_experiment(experiment, design)
    return Diagnosis(found, diagnose_problem(found.problem, all_effects, progress=progress))
