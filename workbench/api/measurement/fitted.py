"""A fitted model on the records of an experiment: what comparison, diagnosis and addition have in common."""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Any, Literal

from workbench.api.measurement.experiment import Experiment
from workbench.api.measurement.series import (
    PARTS,
    channel_named,
    free_run_table,
    overlay_table,
    part_of,
    prediction_error_table,
)
from workbench.operations.result import Result, finite

if TYPE_CHECKING:
    import pandas as pd

    from sysid.estimation.fit import FittedModel
    from sysid.estimation.information_criteria import InformationCriteria
    from sysid.prediction.model import Model
    from sysid.prediction.problem import Problem
    from workbench.api.measurement.correlation import Correlation

Part = Literal["fit", "validate"]


@dataclass(frozen=True)
class ChangedModel:
    """A fitted model with other values of its parameters, and its errors.

    Args:
        model: with the values.
        over_noise: error over the noise by part (`fit`, `validate`) and channel.
    """

    model: Model
    over_noise: dict[str, dict[str, float]]


class FittedResult(Result):
    """A result with a fitted model: its values, predictions and residuals.

    Attributes:
        experiment: that was compared.
    """

    experiment: Experiment

    def __init__(self, experiment: Experiment, found: Any) -> None:
        self.experiment = experiment
        self.found = found

    @cached_property
    @abstractmethod
    def _document(self) -> dict[str, Any]:
        """The document of the command."""

    def to_json(self) -> dict[str, Any]:
        """The document that the command prints with `--json`."""
        return self._document

    @property
    def fitted(self) -> FittedModel:
        """The fitted model."""
        return self.found.base.fitted

    @property
    def problem(self) -> Problem:
        """The prepared records."""
        return self.found.problem

    @cached_property
    def overlay(self) -> pd.DataFrame:
        """Measured and predicted channels and residuals of all records, SI; index `record`, `time`."""
        return overlay_table(self.problem, self.fitted.model)

    @property
    def predictions(self) -> pd.DataFrame:
        """Predicted channels, SI; index `record`, `time`."""
        return part_of(self.overlay, self.problem, "predicted")

    @property
    def residuals(self) -> pd.DataFrame:
        """Measured less predicted channels, SI, empty where not scored; index `record`, `time`."""
        return part_of(self.overlay, self.problem, "residual")

    @property
    def parameters(self) -> pd.DataFrame:
        """Fitted values, SI, with standard deviation and 95 % interval; index `parameter`."""
        return parameter_frame(self.to_json()["parameters"])

    def with_values(self, values: Mapping[str, float]) -> ChangedModel:
        """The fitted model with other values, SI, by parameter; names that it does not have are left out."""
        from sysid.estimation.misfit import misfit

        fitted = self.fitted.model
        model = fitted.at({key: value for key, value in values.items() if key in fitted.values})
        parts = {"fit": self.problem.fit_records, "validate": self.problem.validate_records}
        errors = {
            part: {name: one.over_noise for name, one in misfit(model, records).items()}
            for part, records in parts.items()
        }
        return ChangedModel(model, errors)

    @property
    def criteria(self) -> InformationCriteria:
        """AIC and BIC on the records of the fit."""
        from sysid.estimation.information_criteria import information_criteria

        return information_criteria(self.fitted)

    def correlation(self, channel: str | None = None, part: Part = "fit", lags: int = 25) -> Correlation:
        """Autocorrelation of the residual, and its cross-correlation with the inputs.

        Args:
            channel: the force, or the first one measured, when left out.
            part: `fit`, or `validate` for the held-out records.
            lags: largest lag, in samples.

        Raises:
            InputError: no such channel.
        """
        from sysid.estimation.residual_correlation import residual_correlation
        from workbench.api.measurement.correlation import Correlation

        name = channel_named(self.problem, channel)
        return Correlation(residual_correlation(self.problem, self.fitted.model, name, part, lags))

    @cached_property
    def free_run(self) -> pd.DataFrame:
        """Records simulated from their inputs alone: `CHANNEL` as logged and `CHANNEL_simulated`, SI.

        Raises:
            InputError: an effect that cannot be integrated in time.
        """
        return free_run_table(self.problem, self.fitted.model)

    def prediction_errors(self, horizons: Sequence[float] = (0.1, 1.0)) -> pd.DataFrame:
        """Errors of k-step predictions: simulations from measured states, evenly spread over the records.

        Args:
            horizons: lengths, s; k is the length over the sampling time. A free run is added.

        Returns:
            rms (SI) and fit percent; index `horizon`, `records`, `channel`. Where the prediction along the inputs is
            the simulation, all horizons are the free run.

        Raises:
            InputError: an effect that cannot be integrated in time.
        """
        return prediction_error_table(self.problem, self.fitted.model, horizons)

    @property
    def warnings(self) -> list[str]:
        """Contradictions in the records, one line each."""
        return list(self.to_json().get("warnings", ()))


def parameter_frame(parameters: Mapping[str, Any]) -> pd.DataFrame:
    """Parameters of a document as a table; without nuisances."""
    import pandas as pd

    columns = ["value", "std", "low", "high", "unit"]
    rows = [{"parameter": key, **q} for key, q in parameters.items() if not q.get("nuisance")]
    return pd.DataFrame(rows, columns=["parameter", *columns]).set_index("parameter")


def error_frame(errors: Mapping[str, Any]) -> pd.DataFrame:
    """Errors of a document by set of records and channel; rms in SI."""
    import pandas as pd

    rows = [
        {
            "records": label,
            "channel": channel,
            "rms": error["rms"]["value"],
            "unit": error["rms"]["unit"],
            "over_noise": error.get("over_noise"),
            "fit_percent": error.get("fit_percent"),
        }
        for part, label in PARTS.items()
        for channel, error in errors.get(part, {}).items()
    ]
    columns = ["records", "channel", "rms", "unit", "over_noise", "fit_percent"]
    return pd.DataFrame(rows, columns=columns).set_index(["records", "channel"])


def document(found: Any) -> Any:
    """A document as the command prints it."""
    return finite(found)
