"""Simulations of many machines sampled from the uncertain parameters of a design: deviations and tolerances."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import TYPE_CHECKING, Any

import numpy as np

from designcalc.errors.monte_carlo import (
    Distribution,
    UncertainParameter,
    strongest_correlation,
    uncertain_parameters,
)
from stagecad.parameters.errors import InputError
from stagecad.parameters.units import to_si
from stagecad.processes import parallel_map
from workbench.cli.options import Run
from workbench.operations.design import Design as StatedDesign
from workbench.simulation.experiments import (
    FeaturePath,
    Selection,
    features_of,
    flat_features,
    moving_mass,
    reads,
    simulate_selection,
)

if TYPE_CHECKING:
    from stagecad.parameters.design import Design
    from stagecad.parameters.mass_properties import BodyMasses

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
    """All samples of a command.

    Args:
        parameters: that were sampled.
        values: (samples, parameters), each in its own unit.
        nominal: results of the design itself.
        samples: one for each row of `values`.
        distributions: of each feature over the samples.
    """

    parameters: tuple[UncertainParameter, ...]
    values: np.ndarray
    nominal: Sample
    samples: tuple[Sample, ...]
    distributions: Mapping[FeaturePath, Distribution]

    @property
    def refused(self) -> list[tuple[int, str]]:
        """Number and reason of the samples that are no valid designs."""
        return [(k, sample.refused) for k, sample in enumerate(self.samples) if sample.refused]

    def as_json(self, seed: int) -> dict[str, Any]:
        """The sampled parameters, and each feature's distribution, nested as `simulate` gives features."""
        nested: dict[str, Any] = {}
        for (*path, last), distribution in self.distributions.items():
            inner = nested
            for step in path:
                inner = inner.setdefault(step, {})
            inner[last] = distribution.as_json()
        return {
            "draws": len(self.samples),
            "seed": seed,
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


@dataclass(frozen=True)
class _Common:
    """Data common to all samples, sent to each worker once."""

    source: StatedDesign
    selection: Selection
    parameters: tuple[UncertainParameter, ...]
    base: Design
    masses: BodyMasses | None


def run_monte_carlo(run: Run, selection: Selection, count: int, seed: int, scheduler: str | None) -> Study:
    """Simulate `count` machines sampled about the design, in parallel on the local cores or on a cluster.

    The values are sampled here, from `seed`, before anything is sent: the result does not depend on the workers.

    Raises:
        InputError: no uncertain parameter, the design itself is refused, or every sample is.
    """
    parameters = uncertain_parameters(run.design.values, selection.reads)
    if not parameters:
        raise InputError(
            f"--draws: nothing that {', '.join(selection.names)} read has a tolerance or a '+-'; give one, like "
            '--set "friction.breakaway=1.5 +- 0.1 N"'
        )
    random = np.random.default_rng(seed)
    values = np.column_stack([parameter.sample(random, count) for parameter in parameters])
    common = _common(run, selection, parameters)
    nominal = _simulate(run.design.values, common.selection, common.masses)
    with run.progress() as progress:
        task = progress.add_task("samples", total=count)
        # Several samples per task: one takes less time than its transfer to the worker.
        size = max(1, min(8, count // 16))
        rows = [values[k : k + size] for k in range(0, count, size)]
        found = parallel_map(
            partial(simulate_samples, common),
            rows,
            progress=lambda some: progress.update(task, advance=len(some)),
            scheduler=scheduler,
        )
    samples = tuple(sample for some in found for sample in some)
    if all(sample.refused for sample in samples):
        raise InputError(f"--draws: every sample is an invalid design: {samples[0].refused}")
    return Study(parameters, values, nominal, samples, _distributions(parameters, values, nominal, samples))


def _common(run: Run, selection: Selection, parameters: tuple[UncertainParameter, ...]) -> _Common:
    """Common data of all samples, with the masses of the design's own solids, so that no sample builds solids."""
    from stagecad.friction_stage.assembly.machine import body_masses

    if selection.mass == "design" and selection.friction_experiments:
        selection = replace(selection, mass=f"{moving_mass(run.design.values, 'design')!r} kg")
    masses = body_masses(run.design.values) if "stage" in selection.names else None
    return _Common(run.design, selection, parameters, run.design.values, masses)


def simulate_samples(common: _Common, rows: np.ndarray) -> list[Sample]:
    """Results of the machines with the values of each row, (k, parameters)."""
    from designcalc.checks.analysis.tolerance import scaled_masses
    from sim.integration.simulate import SimulationError

    found = []
    for row in rows:
        overrides = [f"{one.key}={value!r} {one.unit}".rstrip() for one, value in zip(common.parameters, row.tolist())]
        try:
            # Rules across values apply to the nominal design, not to a machine within its tolerances.
            design = common.source.values_with(*overrides, rules=False)
            masses = scaled_masses(design, common.base, common.masses)
            found.append(_simulate(design, common.selection, masses))
        except (InputError, SimulationError) as refused:
            found.append(Sample({}, {}, " ".join(str(refused).split())))
    return found


def _simulate(design: Design, selection: Selection, masses: BodyMasses | None) -> Sample:
    results = simulate_selection(design, selection, masses)
    curves: Curves = {}
    for name, found in results.items():
        curves |= curves_of(name, found)
    return Sample(flat_features(features_of(results)), curves)


def curves_of(name: str, results: Mapping[str, Any]) -> Curves:
    """Curves of an experiment that are shown as bands: position in time, or friction over the last period of a loop."""
    if name == "presliding":
        return {(name, model): _in_time(found.simulation, 4.0) for model, found in results.items()}
    if name == "stick-slip":
        from sim.experiments.stick_slip import SHOWN

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
            read = [k for k, parameter in enumerate(parameters) if reads(path[0], parameter.key)]
            keys = [parameters[k].key for k in read]
            distribution = replace(distribution, strongest=strongest_correlation(keys, values[:, read], column))
        distributions[path] = distribution
    return distributions
