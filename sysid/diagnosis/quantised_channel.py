"""Quantisation of a channel, found from its values: a least significant bit larger than the stated noise."""

from __future__ import annotations

import numpy as np

from sim.effects.catalogue import find
from sysid.diagnosis.trials import CandidateFit
from sysid.estimation.fit import root_mean_huber
from sysid.estimation.misfit import misfit, worst_over_noise
from sysid.estimation.reference_fit import ReferenceFit, fit_stated_model
from sysid.estimation.screening import RefittedEffect
from sysid.prediction.problem import Problem, build_problem

BELOW_THE_NOISE = 0.2
"""Misfit over noise below which the values cannot contain the stated noise: they were rounded."""


def coarse_steps(problem: Problem, base: ReferenceFit, adequate: float) -> CandidateFit | None:
    """Quantisation as a candidate, where the least significant bit of a channel exceeds the noise that the user gave.

    None if no channel is quantised so coarsely, if the misfit of the base model is `adequate`, or if quantisation does
    not reduce it sufficiently. A channel of very few levels may be fitted exactly: a misfit far below the stated noise
    also indicates quantisation.
    """
    if any(name.partition("@")[0] == "sensor_quantisation" for name in problem.experiment.effects):
        return None
    stds = {
        c: noise.quantisation_step / np.sqrt(12.0)
        for c, noise in problem.noise.items()
        if noise.quantisation_step is not None
    }
    coarse = [channel for channel, std in stds.items() if std > problem.noise[channel].value]
    if not coarse:
        return None
    every = len(problem.noise) == len(coarse)
    added = ["sensor_quantisation"] if every else [f"sensor_quantisation@{c}" for c in coarse]
    other = build_problem(problem.experiment, problem.records, [*problem.experiment.effects, *added])
    refit = fit_stated_model(other)
    model = refit.fitted.model
    after_fit, after_validate = misfit(model, other.fit_records), misfit(model, other.validate_records)
    model = base.fitted.model
    before = worst_over_noise(misfit(model, problem.fit_records), misfit(model, problem.validate_records))
    reduced = worst_over_noise(after_fit, after_validate) <= 0.9 * before
    if before >= BELOW_THE_NOISE and (before <= adequate or not reduced):
        return None
    return CandidateFit(
        refit=RefittedEffect(find("sensor_quantisation"), 1.0, refit.fitted),
        error=root_mean_huber(refit.residual),
        gain=0.0,
        significance=99.0,
        fit_gain=0.0,
        residual=refit.residual,
        after_fit=after_fit,
        after_validate=after_validate,
        law=added[-1],
    )
