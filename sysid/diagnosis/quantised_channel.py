"""Quantisation is read off the values themselves: a channel whose steps are coarser than its noise."""

from __future__ import annotations

import numpy as np

from sim.effects.catalogue import find
from sysid.diagnosis.trials import CandidateFit
from sysid.estimation.fit import root_mean_huber
from sysid.estimation.misfit import misfit, worst_over_noise
from sysid.estimation.reference_fit import ReferenceFit, fit_stated_model
from sysid.estimation.screening import RefittedEffect
from sysid.prediction.problem import Problem, build_problem

NOISE_IS_GONE = 0.2
"""Error over the noise below which that noise cannot be in the values: they were rounded."""


def coarse_steps(problem: Problem, base: ReferenceFit, enough: float) -> CandidateFit | None:
    """The coarse grid of a channel's values as a trial, where it is coarser than the noise the user gave.

    None where there is none, where the base model's error over noise is `enough` as it is, or where little falls. A
    channel that shows few values may be met exactly, by levels that are a little off: its noise, gone, tells of steps.
    """
    if any(name.partition("@")[0] == "sensor_quantisation" for name in problem.experiment.effects):
        return None
    coarse = [
        channel for channel, noise in problem.noise.items()
        if noise.quantisation_step is not None and noise.quantisation_step / np.sqrt(12.0) > noise.value
    ]  # fmt: skip
    if not coarse:
        return None
    names = [
        *problem.experiment.effects,
        *(
            ["sensor_quantisation"]
            if len(problem.noise) == len(coarse)
            else [f"sensor_quantisation@{c}" for c in coarse]
        ),
    ]
    other = build_problem(problem.experiment, problem.records, names)
    refit = fit_stated_model(other)
    after_fit = misfit(refit.fitted.model, other.fit_records)
    after = misfit(refit.fitted.model, other.validate_records)
    before = worst_over_noise(
        misfit(base.fitted.model, problem.fit_records), misfit(base.fitted.model, problem.validate_records)
    )
    rounded_away = before < NOISE_IS_GONE
    if not rounded_away and (before <= enough or worst_over_noise(after_fit, after) > 0.9 * before):
        return None
    error = root_mean_huber(refit.residual)
    candidate = RefittedEffect(find("sensor_quantisation"), 1.0, refit.fitted)
    return CandidateFit(candidate, error, 0.0, 99.0, 0.0, refit.residual, after_fit, after, law=names[-1])
