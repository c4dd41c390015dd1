"""A fitted model on the records of an experiment: what comparison, diagnosis and addition have in common."""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Mapping
from functools import cached_property
from typing import TYPE_CHECKING, Any

from workbench.api.experiment import Experiment
from workbench.api.result import Result, finite_json
from workbench.api.series import PARTS, overlay_table, part_of

if TYPE_CHECKING:
    import pandas as pd

    from sysid.estimation.fit import FittedModel
    from sysid.prediction.problem import Problem


class FittedResult(Result):
    """A result with a fitted model: its values, predictions and residuals.

    Attributes:
        experiment: that was compared.
    """

    experiment: Experiment

    @property
    @abstractmethod
    def fitted(self) -> FittedModel:
        """The fitted model."""

    @property
    @abstractmethod
    def problem(self) -> Problem:
        """The prepared records."""

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
    return finite_json(found)
