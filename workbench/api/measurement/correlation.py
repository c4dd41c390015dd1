"""Correlations of a residual as a result: tables and a figure."""

from __future__ import annotations

from dataclasses import asdict
from typing import TYPE_CHECKING, Any

from sysid.estimation.residual_correlation import ResidualCorrelation
from workbench.operations.result import Result, finite

if TYPE_CHECKING:
    import pandas as pd
    from matplotlib.figure import Figure


class Correlation(Result):
    """Autocorrelation of the residual of a channel, and its cross-correlation with each input."""

    def __init__(self, found: ResidualCorrelation) -> None:
        self.found = found

    @property
    def is_white(self) -> bool:
        """Whether the residual passes as white noise, at 1 % (Ljung and Box)."""
        return self.found.is_white

    def to_dataframe(self) -> pd.DataFrame:
        """Correlations with their 99 % bounds; index `of` (`residual`, or the name of an input) and `lag`, s."""
        import pandas as pd

        found = self.found
        series = {"residual": (found.lags, found.autocorrelation, found.bound)}
        series |= {name: (found.cross_lags, r, found.cross_bound[name]) for name, r in found.cross.items()}
        tables = {
            name: pd.DataFrame({"correlation": r, "bound": bound}, index=pd.Index(lags, name="lag"))
            for name, (lags, r, bound) in series.items()
        }
        return pd.concat(tables, names=["of"])

    def to_json(self) -> dict[str, Any]:
        """The correlations as plain data; lags are multiples of `step`."""
        return finite(asdict(self.found))

    def plot(self) -> Figure:
        """Each correlation over its lag, with its 99 % bound."""
        from workbench.api.figures.results import correlation_figure

        return correlation_figure(self.found)

    def __repr__(self) -> str:
        outside = self.found.correlated_inputs
        p = "p < 0.001" if self.found.p_value < 0.001 else f"p = {self.found.p_value:.2g}"
        inputs = f", correlated with {', '.join(outside)}" if outside else ""
        white = "white" if self.is_white else "not white"
        return f"<Correlation of the residual of {self.found.channel}: {white} ({p}){inputs}>"
