"""Simulations of many designs: over the values of one parameter, and of machines sampled from the uncertain parameters
(deviations and tolerances)."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property, partial
from pathlib import Path
from typing import Any

import numpy as np

from designcalc.checks.run import changed_masses
from designcalc.checks.sweep import Range, read_range
from designcalc.errors.monte_carlo import Distribution, UncertainParameter, strongest_correlation, uncertain_parameters
from sim.experiments.stick_slip import SHOWN
from sim.integration.simulate import SimulationError
from stagecad.parameters.design import Design as Values
from stagecad.parameters.errors import InputError
from stagecad.parameters.mass_properties import Masses
from stagecad.parameters.units import to_si
from stagecad.processes import parallel_map
from workbench.figures import plot as drawing
from workbench.figures import simulation as simulation_figures
from workbench.operations.design import Design
from workbench.operations.result import NUMBER, TEXT, Line, Note, ProgressCallback, Table, counted
from workbench.operations.simulation import simulate
from workbench.operations.simulation.simulate import FeaturePath, Selection
from workbench.operations.simulation.tables import feature_text, write_table

OF_MANY = ("swept", "draws", "scheduler")
"""Options for the simulation of many designs."""
Point = dict[str, Any] | str
"""Features at one value, or why the design or motion is refused."""


@dataclass(frozen=True)
class Sweep:
    """Features of simulations at every value of a range of one parameter."""

    swept: Range
    points: tuple[Point, ...]

    @property
    def unit(self) -> str:
        """SI unit of the parameter."""
        return self.swept.si_unit or "1"

    def to_json(self) -> dict[str, Any]:
        """The document: values, and at each what `simulate` gives there (null where it was refused)."""
        unit = self.swept.unit
        return {
            "key": self.swept.key,
            "values": [{"value": to_si(value, unit), "unit": self.unit} for value in self.swept.values],
            "points": [None if isinstance(point, str) else point for point in self.points],
            "refused": [point if isinstance(point, str) else None for point in self.points],
        }

    @cached_property
    def columns(self) -> dict[str, np.ndarray]:
        """The parameter in SI, and a column for every feature."""
        swept = self.swept
        rows = [{} if isinstance(point, str) else simulate.flat_features(point) for point in self.points]
        columns = {f"{swept.key} [{self.unit}]": np.array([to_si(value, swept.unit) for value in swept.values])}
        for name in dict.fromkeys(name for row in rows for name in row):
            cells = [row.get(name) for row in rows]
            feature_unit = next((cell["unit"] for cell in cells if cell), None)
            if feature_unit is not None:
                values = [cell["value"] if cell else np.nan for cell in cells]
                columns[f"{'.'.join(name)} [{feature_unit}]"] = np.array(values, dtype=float)
        return columns

    def write(self, folder: Path, formats: tuple[str, ...]) -> list[Path]:
        """Write the table into a folder."""
        return write_table(folder / "sweep", self.columns, formats)

    def lines(self) -> Iterator[Line]:
        """What the command prints: the values refused, and how many features there are."""
        swept = self.swept
        for value, point in zip(swept.values, self.points):
            if isinstance(point, str):
                yield Note(f"{swept.key} = {value:g} {swept.unit}: {point}")


def sweep(
    design: Design, swept: Range, selection: Selection, scheduler: str | None, progress: ProgressCallback
) -> Sweep:
    """Features at every value of the range, in parallel on the local cores or on a cluster."""
    whole = isinstance(design.values.value(swept.key), int)
    overrides = [swept.override(int(value) if whole else value) for value in swept.values]
    steps = counted(progress, "sweep", len(overrides))
    points = parallel_map(partial(simulate_point, design, selection), overrides, progress=steps, scheduler=scheduler)
    if all(isinstance(point, str) for point in points):
        raise InputError(f"--sweep {swept.key}: every value is refused: {points[0]}")
    return Sweep(swept, tuple(points))


def simulate_point(design: Design, selection: Selection, override: str) -> Point:
    """Features of every selected experiment with one more override."""
    try:
        return simulate.features_of(simulate.simulate_selection(design.values_with(override), selection))
    except (InputError, SimulationError) as refused:
        return " ".join(str(refused).split())


MOST_LISTED = 8
"""Sampled parameters that are listed."""
POINTS = 201
"""Points of a curve that a sample keeps."""

Curves = dict[FeaturePath, tuple[np.ndarray, np.ndarray]]
"""Abscissa and ordinate, SI, shape (POINTS,), by experiment, model and case."""


@dataclass(frozen=True)
class Sample:
    """Results of one sampled machine: features and curves by their path; or why the design is refused."""

    features: Mapping[FeaturePath, Any]
    curves: Curves
    refused: str = ""


@dataclass(frozen=True)
class Study:
    """All samples of a command."""

    parameters: tuple[UncertainParameter, ...]  # that were sampled
    values: np.ndarray  # (samples, parameters), each in its own unit
    nominal: Sample  # results of the design itself
    samples: tuple[Sample, ...]  # one for each row of `values`
    distributions: Mapping[FeaturePath, Distribution]  # of each feature over the samples
    seed: int  # of the random numbers

    @property
    def refused(self) -> list[tuple[int, str]]:
        """Number and reason of the samples that are no valid designs."""
        return [(k, sample.refused) for k, sample in enumerate(self.samples) if sample.refused]

    def to_json(self) -> dict[str, Any]:
        """The sampled parameters, and each feature's distribution, nested as `simulate` gives features."""
        nested: dict[str, Any] = {}
        for (*path, last), distribution in self.distributions.items():
            inner = nested
            for step in path:
                inner = inner.setdefault(step, {})
            inner[last] = distribution.as_json()
        return {
            "draws": len(self.samples),
            "seed": self.seed,
            "drawn": {parameter.key: parameter.as_json() for parameter in self.parameters},
            "refused": [{"draw": k, "reason": reason} for k, reason in self.refused],
            "features": nested,
        }

    def columns(self) -> dict[str, np.ndarray]:
        """A row for each sample: its parameters, in SI, and every feature."""
        columns = {}
        for parameter, values in zip(self.parameters, self.values.T):
            si = np.array([to_si(value, parameter.unit) for value in values])
            columns[f"{parameter.key} [{parameter.si_unit}]"] = si
        for path, distribution in self.distributions.items():
            columns[f"{'.'.join(path)} [{distribution.unit}]"] = distribution.values
        return columns

    def write(self, folder: Path, formats: tuple[str, ...], figures: bool) -> list[Path]:
        """Write a row for each sample, and the figures, into a folder."""
        written = write_table(folder / "draws", self.columns(), formats)
        if figures:
            written += drawing.save_figures(folder, simulation_figures.study_figures(self))
        return written

    def lines(self) -> Iterator[Line]:
        """What the command prints: the sampled parameters, and each feature's value, deviation and 95 % band."""
        listed = "; ".join(parameter.text for parameter in self.parameters[:MOST_LISTED])
        more = len(self.parameters) - MOST_LISTED
        yield f"sampled: {listed}" + (f"; and {more} more" if more > 0 else "")
        columns = [("", TEXT), *((title, NUMBER) for title in ("design", "deviation", "2.5 %", "97.5 %"))]
        for experiment in dict.fromkeys(path[0] for path in self.distributions):
            distributions = {path[1:]: d for path, d in self.distributions.items() if path[0] == experiment}
            changing = {path: distribution for path, distribution in distributions.items() if distribution.varies}
            rows = [_distribution_cells(path, distribution) for path, distribution in changing.items()]
            if rows:
                yield Table(experiment, (*columns, ("depends most on", TEXT)), tuple(rows), plain=True)
            if len(changing) < len(distributions):
                yield f"{experiment}: {len(distributions) - len(changing)} features do not change"
        if self.refused:
            first = self.refused[0][1]
            yield Note(f"{len(self.refused)} of {len(self.samples)} samples are invalid designs, first: {first}")


def _distribution_cells(path: FeaturePath, distribution: Distribution) -> tuple[str, ...]:
    values = distribution.finite
    cells = [distribution.nominal, values.std(ddof=1), *np.quantile(values, [0.025, 0.975])]
    return (
        "  ".join(name.replace("_", " ") for name in path),
        *(feature_text(None if x is None else {"value": float(x), "unit": distribution.unit}) for x in cells),
        distribution.strongest_text or "-",
    )


def run_monte_carlo(
    design: Design, selection: Selection, count: int, seed: int, scheduler: str | None, progress: ProgressCallback
) -> Study:
    """Simulate machines sampled about the design, in parallel on the local cores or on a cluster.

    The values are sampled here, from the seed, before anything is sent: the result does not depend on the workers.
    """
    from stagecad.solids.assembly.built_machine import packaged_masses

    nominal_values = design.values
    parameters = uncertain_parameters(nominal_values, selection.reads)
    if not parameters:
        raise InputError(
            f"--draws: nothing that {', '.join(selection.names)} read has a tolerance or a '+-'; give one, like "
            '--set "friction.breakaway=1.5 +- 0.1 N"'
        )
    random = np.random.default_rng(seed)
    values = np.column_stack([parameter.sample(random, count) for parameter in parameters])
    if selection.mass == "design" and selection.friction_experiments:
        selection = replace(selection, mass=f"{simulate.moving_mass(nominal_values, 'design')!r} kg")
    # With the masses of the design's own solids, so that no sample builds solids.
    masses = packaged_masses(nominal_values) if "stage" in selection.names else None
    nominal = _simulate(nominal_values, selection, masses)
    steps = counted(progress, "samples", count)
    job = partial(simulate_sample, design, selection, parameters, masses)
    samples = tuple(parallel_map(job, list(values), progress=steps, scheduler=scheduler))
    if all(sample.refused for sample in samples):
        raise InputError(f"--draws: every sample is an invalid design: {samples[0].refused}")
    return Study(parameters, values, nominal, samples, _distributions(parameters, values, nominal, samples), seed)


def simulate_sample(
    base: Design, selection: Selection, parameters: Sequence[UncertainParameter], masses: Masses | None, row: np.ndarray
) -> Sample:
    """Results of the machine about `base` with a row of values of the parameters."""
    overrides = [f"{one.key}={value!r} {one.unit}".rstrip() for one, value in zip(parameters, row.tolist())]
    try:
        # Rules across values apply to the nominal design, not to a machine within its tolerances.
        design = base.values_with(*overrides, rules=False)
        return _simulate(design, selection, changed_masses(design, base.values, masses))
    except (InputError, SimulationError) as refused:
        return Sample({}, {}, " ".join(str(refused).split()))


def _simulate(design: Values, selection: Selection, masses: Masses | None) -> Sample:
    results = simulate.simulate_selection(design, selection, masses)
    curves: Curves = {}
    for name, found in results.items():
        curves |= curves_of(name, found)
    return Sample(simulate.flat_features(simulate.features_of(results)), curves)


def curves_of(name: str, results: Mapping[str, Any]) -> Curves:
    """Curves of an experiment that are shown as bands: position in time, or friction over the last period of a loop."""
    if name == "presliding":
        return {(name, model): _in_time(found.simulation, 4.0) for model, found in results.items()}
    if name == "stick-slip":
        return {(name, model): _in_time(found.simulation, SHOWN) for model, found in results.items()}
    if name == "hysteresis":
        return {
            (name, model, case): _last_period(found)
            for model, cases in results.items()
            for case, found in cases.items()
        }
    return {}


def _in_time(run: Any, end: float) -> tuple[np.ndarray, np.ndarray]:
    time = np.linspace(0.0, end, POINTS)
    return time, np.interp(time, run.time, run.position)


def _last_period(found: Any) -> tuple[np.ndarray, np.ndarray]:
    """Friction over the second of two periods, against the elapsed part of the period."""
    run, period = found.simulation, 2.0 * np.pi / found.frequency
    part = np.linspace(0.0, 1.0, POINTS)
    return part, np.interp((1.0 + part) * period, run.time, run.friction)


def _distributions(
    parameters: Sequence[UncertainParameter], values: np.ndarray, nominal: Sample, samples: Sequence[Sample]
) -> dict[FeaturePath, Distribution]:
    distributions = {}
    for path in dict.fromkeys([*nominal.features, *(path for sample in samples for path in sample.features)]):
        own, cells = nominal.features.get(path), [sample.features.get(path) for sample in samples]
        unit = next((cell["unit"] for cell in (own, *cells) if cell is not None), None)
        if unit is None:
            continue
        column = np.array([np.nan if cell is None else cell["value"] for cell in cells], dtype=float)
        distribution = Distribution(None if own is None else float(own["value"]), column, unit)
        if distribution.varies:
            read = [k for k, parameter in enumerate(parameters) if simulate.reads(path[0], parameter.key)]
            keys = [parameters[k].key for k in read]
            distribution = replace(distribution, strongest=strongest_correlation(keys, values[:, read], column))
        distributions[path] = distribution
    return distributions


def simulate_selected(
    design: Design,
    folder: Path,
    formats: tuple[str, ...],
    names: Sequence[str],
    options: Mapping[str, Any],
    progress: ProgressCallback,
) -> tuple[list[Line], dict[str, Any]]:
    """Simulate what the options of the command select, at the design's own values, over a range of a parameter, or of
    sampled machines; write data and figures; lines and document."""
    stated = {key: value for key, value in options.items() if key not in ("figures", "seed")}
    selection, (swept, draws, scheduler) = simulate.read_selection(names, **stated), map(options.get, OF_MANY)
    summary = ""
    if swept is not None:
        chosen = read_range(swept, design.values)
        found = sweep(design, chosen, selection, scheduler, progress)
        lines, document, files = list(found.lines()), {"sweep": found.to_json()}, found.write(folder, formats)
        summary = f"{len(found.points)} values of {chosen.key}, {len(found.columns) - 1} features each; "
    elif draws is not None:
        selection = selection if names else replace(selection, names=simulate.EXPERIMENTS[:-1])
        study = run_monte_carlo(design, selection, draws, options["seed"], scheduler, progress)
        lines, document = list(study.lines()), study.to_json()
        files = study.write(folder, formats, options["figures"])
    else:
        lines, document, files = selection.remarks(design.values), {}, []
        folder.mkdir(parents=True, exist_ok=True)
        for name in selection.names:
            simulation = simulate.simulate_one(name, design.values, selection, scheduler, progress)
            files += simulation.write(folder, formats, options["figures"])
            lines += simulation.lines()
            document |= simulation.to_json()
    return [*lines, f"{summary}{len(files)} files in {folder}"], document
