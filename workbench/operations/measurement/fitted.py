"""A fitted model on the records of an experiment: what comparison, diagnosis and addition have in common."""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import asdict
from functools import cached_property
from typing import TYPE_CHECKING, Any, Literal

import numpy as np

from sim.effects.catalogue import find
from sim.export.languages import Exported
from sim.export.program import ForceFunction, program_of
from stagecad.deferred import pd
from stagecad.parameters.errors import InputError, require, require_known
from sysid.diagnosis.residual_maps import ResidualMap, residual_maps
from sysid.documents import channel_unit, headline_channel, parameter_unit
from sysid.estimation.covariance import intervals, public_key
from sysid.estimation.fit import FittedModel, InformationCriteria, information_criteria
from sysid.estimation.misfit import misfit
from sysid.estimation.residual_correlation import ResidualCorrelation, residual_correlation
from sysid.experiment.ladder import read_history
from sysid.prediction.model import Model, PreparedRecord, predict, with_effect
from sysid.prediction.problem import Problem, averaged
from sysid.prediction.simulation_error import free_runs, simulation_errors
from workbench.figures import identification as figures
from workbench.figures.curves import curve_of, worst_record
from workbench.figures.plot import Plot
from workbench.operations.measurement.experiment import Experiment
from workbench.operations.measurement.tables import PARTS
from workbench.operations.result import Reported, Result, finite, frame

if TYPE_CHECKING:
    from scipy.signal import StateSpace


Part = Literal["fit", "validate"]


class FittedResult(Reported):
    """A result with a fitted model: its values, predictions and residuals; `computed` is the result of `sysid`."""

    def __init__(self, experiment: Experiment, computed: Any) -> None:
        self.experiment = experiment
        self.computed = computed

    @cached_property
    @abstractmethod
    def document(self) -> dict[str, Any]:
        """The document that the command prints with `--json`."""

    def to_json(self) -> dict[str, Any]:
        """The document that the command prints with `--json`."""
        return self.document

    @property
    def fitted(self) -> FittedModel:
        """The fitted model."""
        return self.computed.base.fitted

    @property
    def problem(self) -> Problem:
        """The prepared records."""
        return self.computed.problem

    @cached_property
    def overlay(self) -> pd.DataFrame:
        """Measured and predicted channels and residuals of all records, as compared, SI; index `record`, `time`.

        Columns: `role`, and for each channel `CHANNEL`, `CHANNEL_predicted` and `CHANNEL_residual`, which is empty
        where it is not scored (next to ends and gaps). On a driven mass the channels are filtered as the comparison
        filters them.
        """
        model, tables = self.fitted.model, {}
        logged = {record.name: record.time[0] for record in averaged(self.problem.experiment, self.problem.records)[1]}
        for record in self._prepared:
            predicted = predict(record, model.effects, model.values)
            columns: dict[str, object] = {"role": PARTS["fit" if record.role == "fit" else "validate"]}
            for channel, measured in record.measured.items():
                columns[channel] = measured
                columns[f"{channel}_predicted"] = predicted[channel]
                columns[f"{channel}_residual"] = np.where(record.valid[channel], measured - predicted[channel], np.nan)
            tables[record.name] = pd.DataFrame(columns, index=pd.Index(logged[record.name] + record.time, name="time"))
        table = pd.concat(tables, names=["record"])
        table.attrs["units"] = {channel: channel_unit(self.problem, channel) for channel in self.channels}
        return table

    @property
    def predictions(self) -> pd.DataFrame:
        """Predicted channels, SI; index `record`, `time`."""
        return self._part_of_overlay("predicted")

    @property
    def residuals(self) -> pd.DataFrame:
        """Measured less predicted channels, SI, empty where not scored; index `record`, `time`."""
        return self._part_of_overlay("residual")

    def _part_of_overlay(self, ending: str) -> pd.DataFrame:
        table = pd.DataFrame(self.overlay[[f"{channel}_{ending}" for channel in self.channels]])
        table.columns = pd.Index(self.channels)
        return table

    @property
    def channels(self) -> list[str]:
        """The compared channels of any record."""
        return list(dict.fromkeys(channel for record in self._prepared for channel in record.measured))

    @property
    def _prepared(self) -> list[PreparedRecord]:
        """All prepared records: those of the fit, then the held-out ones."""
        return [*self.problem.fit_records, *self.problem.validate_records]

    @property
    def parameters(self) -> pd.DataFrame:
        """Fitted values, SI, with standard deviation and 95 % interval; index `parameter`."""
        return parameter_frame(self.document["parameters"])

    def with_values(self, values: Mapping[str, float]) -> tuple[Model, dict[str, dict[str, float]]]:
        """The fitted model with other values, SI, by parameter (others are left out), and its error
        over the noise by part (`fit`, `validate`) and channel."""
        fitted = self.fitted.model
        model = fitted.at({key: value for key, value in values.items() if key in fitted.values})
        parts = {"fit": self.problem.fit_records, "validate": self.problem.validate_records}
        errors = {
            part: {name: error.over_noise for name, error in misfit(model, records).items()}
            for part, records in parts.items()
        }
        return model, errors

    @property
    def earlier(self) -> dict[str, Model]:
        """The models of other rungs, with the values fitted then, by `rung NUMBER`."""
        problem, start, found = self.problem, self.problem.start.values, {}
        rungs = read_history(problem.experiment)
        for rung in (one for one in rungs if one.effects != tuple(problem.experiment.effects)):
            model = Model((), {key: value for key, value in start.items() if key.startswith("rig.")}, ())
            # An effect of the user's own may be gone since.
            with suppress(InputError):
                for name in rung.effects:
                    model = with_effect(model, find(name, problem.custom), problem.scales, as_listed=True)
                model = problem.rig.with_nuisances(model, problem.fit_records)
                stored = {key: one["value"] for key, one in rung.document.get("parameters", {}).items()}
                fitted = {key: stored[public_key(key)] for key in model.values if public_key(key) in stored}
                found[f"rung {rung.number}"] = model.at({**{k: start[k] for k in model.values if k in start}, **fitted})
        return found

    def maps_of(self, model: Model) -> list[ResidualMap]:
        """Maps of the residual of a model over each coordinate, weighed as those of the fitted one."""
        return residual_maps(model, self.problem, self.computed.base)

    @cached_property
    def covariance(self) -> pd.DataFrame:
        """Covariance of the fitted values, SI, linear; not a number where the records do not determine a value."""
        computed = intervals(self.fitted, self.problem.fit_records)
        std = np.array([computed.by_key[key].std for key in computed.keys])
        names = pd.Index([public_key(key) for key in computed.keys], name="parameter")
        return pd.DataFrame(np.outer(std, std) * computed.correlation, names, names)

    def sample(self, n: int, seed: int = 1) -> pd.DataFrame:
        """Values of the parameters, SI, (n rows) drawn from the normal distribution of their covariance.

        A value that the records do not determine stays as it is fitted.
        """
        matrix, names = self.covariance.to_numpy(), list(self.covariance)
        fitted = {public_key(key): value for key, value in self.fitted.model.values.items()}
        mean = np.array([fitted[name] for name in names])
        known = np.isfinite(matrix.diagonal())
        values = np.tile(mean, (n, 1))
        random = np.random.default_rng(seed)
        values[:, known] = random.multivariate_normal(mean[known], matrix[np.ix_(known, known)], n, method="eigh")
        return frame(values, columns=names)

    def function(self) -> ForceFunction:
        """The force along a motion, N, by calling it with arrays of time and position: the step that `export` writes.

        Raises:
            InputError: an effect that cannot be exported, by name.
        """
        return ForceFunction(exported_model(self).program.source)

    def to_statespace(self) -> StateSpace:
        """The linear part of a driven mass, from the force on it (N) to its position (m) and velocity (m/s).

            m x'' = F - d x' - k x + sum r m w^2 (y - x),    y'' + 2 D w y' + w^2 y = w^2 x

        Drag d of `viscous`, stiffness k of `cable_spring`, and the modes y of `flexible_mode`, which carry the part r
        of the mass. Dry friction and all other effects are left out.

        Raises:
            InputError: a rig without a mass.
        """
        from scipy.signal import StateSpace

        model = self.fitted.model
        mass = model.values.get("rig.mass", model.values.get("rig.inertia"))
        if not mass:
            raise InputError(f"to_statespace: {self.problem.kind} has no mass")
        modes: list[Any] = []
        for effect in model.effects:
            if effect.is_mode and effect.time_domain is not None:
                given = {p.name: model.values[f"{effect.name}.{p.name}"] for p in effect.parameters}
                modes.append(effect.time_domain(effect.values(**given)))
        own = mass * (1.0 - sum(mode.mass_ratio for mode in modes))
        a = np.zeros((2 + 2 * len(modes), 2 + 2 * len(modes)))
        a[0, 1] = 1.0
        a[1, 0] = -model.values.get("cable_spring.stiffness", 0.0) / own
        a[1, 1] = -model.values.get("viscous.coefficient", 0.0) / own
        for k, mode in zip(range(2, len(a), 2), modes):
            w = 2.0 * np.pi * mode.frequency
            a[k, k + 1] = 1.0
            a[k + 1, [0, k, k + 1]] = w**2, -(w**2), -2.0 * mode.damping * w
            a[1, [0, k]] += np.array([-1.0, 1.0]) * mode.mass_ratio * mass * w**2 / own
        b = np.zeros((len(a), 1))
        b[1] = 1.0 / own
        return StateSpace(a, b, np.eye(2, len(a)), np.zeros((2, 1)))

    @property
    def free_values(self) -> list[dict[str, Any]]:
        """Fitted values, SI, with a range around each: half to one and a half times the value, within its bounds."""
        model, ranges = self.fitted.model, []
        for unknown in model.unknowns:
            value = model.values[unknown.key]
            reach = 0.5 * abs(value) or unknown.size
            low, high = max(value - reach, unknown.low), min(value + reach, unknown.high)
            if high > low and unknown.key not in model.nuisances:
                unit = parameter_unit(self.problem, unknown.key)
                limits = {"value": value, "low": low, "high": high, "unit": unit}
                ranges.append({"key": unknown.key, "name": public_key(unknown.key), **limits})
        return ranges

    @property
    def criteria(self) -> InformationCriteria:
        """AIC and BIC on the records of the fit."""
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
        return Correlation(residual_correlation(self.problem, self.fitted.model, self._channel(channel), part, lags))

    @cached_property
    def free_run(self) -> pd.DataFrame:
        """Records simulated from their inputs alone: `CHANNEL` as logged and `CHANNEL_simulated`, SI.

        Raises:
            InputError: an effect that cannot be integrated in time.
        """
        tables = {}
        for name, (time, run) in free_runs(self.problem, self.fitted.model).items():
            columns = {}
            for channel, (logged, simulated) in run.items():
                columns[channel], columns[f"{channel}_simulated"] = logged, simulated
            tables[name] = pd.DataFrame(columns, index=pd.Index(time, name="time"))
        return pd.concat(tables, names=["record"])

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
        if any(not length > 0.0 for length in horizons):
            raise InputError(f"prediction_errors: horizons {list(horizons)}: lengths above zero are required, in s")
        simulated = simulation_errors(self.problem, self.fitted.model, {f"{length:g} s": length for length in horizons})
        require(not simulated.note, simulated.note)
        rows = [
            (horizon, PARTS[part], channel, error.rms, error.fit_percent)
            for horizon, errors in {**simulated.horizon, "free run": simulated.free_run}.items()
            for part, channels in errors.items()
            for channel, error in channels.items()
        ]
        columns = ["horizon", "records", "channel", "rms", "fit_percent"]
        return pd.DataFrame(rows, columns=columns).set_index(columns[:3])

    @property
    def warnings(self) -> list[str]:
        """Contradictions in the records, one line each."""
        return list(self.document.get("warnings", ()))

    def _figure(self, kind: str, models: Mapping[str, Model], record: str | None, channel: str | None) -> Plot:
        """A figure of one or two models on the records."""
        require_known(kind, ("overlay", "residual", "maps", "loops"), f"plot: no figure '{kind}'")
        if kind == "maps":
            return figures.maps_figure(self.computed.maps, self.problem)
        name = self._channel(channel)
        curve = curve_of(self.problem, self._record(record, name, next(iter(models.values()))), name, models)
        draw = {"overlay": figures.overlay_figure, "residual": figures.residual_figure, "loops": figures.loops_figure}
        return draw[kind](curve)

    def _record(self, name: str | None, channel: str, model: Model) -> PreparedRecord:
        """The record called `name`; without a name the one with the largest error, held out if there is such a one."""
        if name is None:
            return worst_record(self.problem.validate_records or self.problem.fit_records, channel, model)
        records = {record.name: record for record in self._prepared}
        require_known(name, records, f"no record '{name}'")
        return records[name]

    def _channel(self, name: str | None) -> str:
        """The channel called `name`; without a name the one whose error is reported first."""
        if name is None:
            return headline_channel(self.problem)
        require_known(name, self.channels, f"no channel '{name}'")
        return name


class Correlation(Result):
    """Autocorrelation of the residual of a channel, and its cross-correlation with each input."""

    def __init__(self, computed: ResidualCorrelation) -> None:
        self.computed = computed

    @property
    def is_white(self) -> bool:
        """Whether the residual passes as white noise, at 1 % (Ljung and Box)."""
        return self.computed.is_white

    def to_dataframe(self) -> pd.DataFrame:
        """Correlations with their 99 % bounds; index `of` (`residual`, or the name of an input) and `lag`, s."""
        tables = {
            name: pd.DataFrame({"correlation": r, "bound": bound}, index=pd.Index(lags, name="lag"))
            for name, (lags, r, bound) in self.computed.series.items()
        }
        return pd.concat(tables, names=["of"])

    def to_json(self) -> dict[str, Any]:
        """The correlations as plain data; lags are multiples of `step`."""
        return finite(asdict(self.computed))

    def plot(self) -> Plot:
        """Each correlation over its lag, with its 99 % bound."""
        return figures.correlation_figure(self.computed)

    def __repr__(self) -> str:
        outside = self.computed.correlated_inputs
        p = "p < 0.001" if self.computed.p_value < 0.001 else f"p = {self.computed.p_value:.2g}"
        inputs = f", correlated with {', '.join(outside)}" if outside else ""
        white = "white" if self.is_white else "not white"
        return f"<Correlation of the residual of {self.computed.channel}: {white} ({p}){inputs}>"


def parameter_frame(parameters: Mapping[str, Any]) -> pd.DataFrame:
    """Parameters of a document as a table; without nuisances."""
    columns = ["value", "std", "low", "high", "unit"]
    rows = [{"parameter": key, **q} for key, q in parameters.items() if not q.get("nuisance")]
    return frame(rows, "parameter", columns=["parameter", *columns])


def error_frame(errors: Mapping[str, Any]) -> pd.DataFrame:
    """Errors of a document by set of records and channel; rms in SI."""
    rows = [
        (label, channel, error["rms"]["value"], error["rms"]["unit"], error.get("over_noise"), error.get("fit_percent"))
        for part, label in PARTS.items()
        for channel, error in errors.get(part, {}).items()
    ]
    columns = ["records", "channel", "rms", "unit", "over_noise", "fit_percent"]
    return frame(rows, "records", "channel", columns=columns)


def error_frames(errors: Mapping[str, Mapping[str, Any]]) -> pd.DataFrame:
    """Errors of several models, by their names; index `model`, `records`, `channel`."""
    return pd.concat({name: error_frame(table) for name, table in errors.items()}, names=["model"])


def where_frame(where: list[dict[str, Any]]) -> pd.DataFrame:
    """Dependence of a residual as a table; a p value below the resolution of the permutations is that resolution."""
    rows = [{**row, "p_value": p_value(row["p_value"])} for row in where]
    return frame(rows, "coordinate", columns=["coordinate", "share", "p_value"])


def p_value(p: float | Mapping[str, float]) -> float:
    """A p value of a document as a number."""
    return p["below"] if isinstance(p, Mapping) else p


def exported_model(fitted: FittedResult) -> Exported:
    """The fitted model of a comparison or an addition."""
    model, document = fitted.fitted.model, fitted.document["parameters"]
    comments = {}
    for key, entry in document.items():
        low, high = entry.get("low"), entry.get("high")
        interval = "no interval" if low is None or high is None else f"95 %: {low:.6g} .. {high:.6g}"
        comments[key] = f"{entry['unit']}; {interval}"
    program = program_of("friction_model", model.effects, model.values, comments)
    experiment = fitted.problem.experiment
    about = (
        f"Model of {experiment.folder.resolve().name}: {', '.join(effect.name for effect in model.effects)}.",
        *(f"record {record.file}: sha256 {record.sha256[:16]}" for record in fitted.problem.records),
    )
    return Exported(program, float(model.values.get("rig.mass", model.values.get("rig.inertia", 0.0))), about)
