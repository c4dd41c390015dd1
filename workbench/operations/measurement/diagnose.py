"""`diagnose`: which physical effect is missing from the model of an experiment."""

from __future__ import annotations

from collections.abc import Iterator
from functools import cached_property
from pathlib import Path
from typing import Any, Literal

from stagecad.deferred import pd
from sysid import diagnose as identification
from sysid.documents import diagnosis_json
from sysid.estimation.fit import FittedModel
from sysid.prediction.model import Model
from workbench.figures.plot import Plot
from workbench.operations.design import Design
from workbench.operations.measurement import statements
from workbench.operations.measurement.experiment import Experiment, as_experiment, noise_text
from workbench.operations.measurement.fitted import FittedResult, error_frames, p_value, where_frame
from workbench.operations.measurement.tables import detectable_table, parameter_table, ranking_table
from workbench.operations.result import Line, Note, ProgressCallback, Warned, finite, frame, silent

Kind = Literal["overlay", "ranking", "maps", "loops"]


class Diagnosis(FittedResult):
    """Which effect is missing, and how certain that is. Its fitted model has the effect named, where there is one."""

    computed: identification.Diagnosis

    @property
    def verdict(self) -> str:
        """`missing-effect`, `adequate` or `unexplained`."""
        return self.computed.verdict

    @property
    def effect(self) -> str | None:
        """The effect that is missing; none unless the verdict is `missing-effect`."""
        return self.computed.effect

    @property
    def indistinguishable(self) -> tuple[str, ...]:
        """Effects that these records cannot distinguish from the one named."""
        return self.computed.indistinguishable

    @property
    def reason(self) -> str:
        """Of the verdict, in words."""
        return self.computed.reason

    @property
    def fitted(self) -> FittedModel:
        return self.computed.base.fitted if self.computed.best is None else self.computed.best.fitted

    @property
    def ranking(self) -> pd.DataFrame:
        """The effects tried, best first; index `effect`.

        Columns: `law`, the variant that fits best; `rms` on the held-out records (SI), `over_noise`, `reduction` of the
        rms, `p_value`; `aic_change` and `bic_change`, of the information criteria on the records of the fit.
        """
        rows = []
        for row in self.document["ranking"]:
            error = row.get("validate_error") or {}
            numbers = {"rms": error.get("value"), "unit": error.get("unit"), "p_value": p_value(row["p_value"])}
            rows.append({"law": row["effect"], **row, **numbers})
        columns = ["effect", "law", "rms", "unit", "over_noise", "reduction", "p_value", "aic_change", "bic_change"]
        return frame(rows, "effect", columns=columns)

    @property
    def errors(self) -> pd.DataFrame:
        """Errors before and with the effect named; index `model`, `records`, `channel`."""
        named = {} if self.computed.best is None else {f"with {self.effect}": self.document["after"]}
        return error_frames({"before": self.document["before"], **named})

    @property
    def where(self) -> pd.DataFrame:
        """Coordinates that the residual before depends on: share of its variance and p value."""
        return where_frame(self.document["where"])

    def to_dataframe(self) -> pd.DataFrame:
        """The ranking."""
        return self.ranking

    @cached_property
    def document(self) -> dict[str, Any]:
        """The document of `stagecad diagnose --json`."""
        return finite(diagnosis_json(self.computed))

    def plot(self, kind: Kind = "overlay", record: str | None = None, channel: str | None = None) -> Plot:
        """A figure.

        Args:
            kind: `overlay` of measurement and predictions before and with the best effect, `ranking`, `maps` of the
                residual before over each coordinate, or `loops`: force against velocity and position.
            record: name; the one with the largest error when left out.
            channel: name; the force, or the first one measured.
        """
        if kind == "ranking":
            from workbench.figures.identification import ranking_figure

            tried = {row["effect"]: row["over_noise"] for row in self.document["ranking"] if row.get("over_noise")}
            before = max((m.over_noise for m in self.computed.before_validate.values()), default=float("nan"))
            return ranking_figure(tried, self.effect, before)
        return self._figure(kind, self.drawn_models, record, channel)

    @property
    def drawn_models(self) -> dict[str, Model]:
        """The model before, and the one with the effect named or the best one tried."""
        computed = self.computed
        best = computed.best or (computed.trials[0] if computed.trials else None)
        if best is None or self.verdict == "adequate":
            return {"model": computed.base.fitted.model}
        label = f"with {best.public_name}" + ("" if computed.best is not None else " (best tried)")
        return {"before": computed.base.fitted.model, label: best.fitted.model}

    @property
    def title(self) -> str:
        """The verdict in a few words."""
        return statements.verdict_title(self.computed)

    @property
    def statement(self) -> str:
        """The result in words."""
        return statements.diagnosis_statement(self.computed)

    @property
    def ties(self) -> str:
        """The effects that these records cannot distinguish, in words; empty without any."""
        return statements.equivalence_statement(self.computed)

    @property
    def remarks(self) -> list[str]:
        """Effects that could replace each other, values that are not physical, and what to do next, in words."""
        following = statements.next_step_statement(self.computed) if self.computed.best is None else ""
        return [*self.changes, following] if following else self.changes

    @property
    def changes(self) -> list[str]:
        """Effects that could replace each other, and values that are not physical, in words."""
        return [*statements.replacement_statements(self.computed), *statements.unphysical_statements(self.computed)]

    @property
    def candidates(self) -> dict[str, Model]:
        """The model before (`model`), and the model with each effect that was fitted in full, by its name."""
        tried = {trial.public_name: trial.fitted.model for trial in self.computed.trials[: identification.IN_FULL]}
        return {"model": self.computed.base.fitted.model, **tried}

    def lines(self) -> Iterator[Line]:
        """What `stagecad diagnose` prints: tables and sentences."""
        document = self.document
        yield from (Note(f"note: {note}") for note in self.problem.notes)
        yield f"noise: {noise_text(self.problem)}"
        yield ranking_table(document["ranking"], len(self.computed.trials))
        added = f", with {self.effect}" if self.effect else ""
        yield parameter_table(document["parameters"], f"Parameters of the model{added}")
        if document["detectable"] and statements.near_noise(self.computed):
            yield detectable_table(document["detectable"])
        yield from (Warned(line) for line in self.computed.warnings)
        yield statements.decision_line(self.computed)
        following = statements.next_step_statement(self.computed)
        yield from filter(None, [self.ties, following, *self.changes, *document["not_identifiable"]])

    def summary(self) -> list[tuple[str, str]]:
        facts = [("result", self.statement), ("ties", self.ties)]
        return [fact for fact in facts if fact[1]] + [("warning", line) for line in self.computed.warnings]

    def __repr__(self) -> str:
        ties = f", not distinguishable from {', '.join(self.indistinguishable)}" if self.indistinguishable else ""
        named = f": {self.effect}{ties}" if self.effect else ""
        return f"<Diagnosis of '{self.experiment.name}': {self.verdict}{named}>"


def diagnose(
    experiment: Experiment | str | Path,
    all_effects: bool = False,
    design: Design | None = None,
    progress: ProgressCallback = silent,
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
    stated = as_experiment(experiment, design)
    return Diagnosis(stated, identification.diagnose(stated.problem, all_effects, progress=progress))
