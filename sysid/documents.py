"""JSON documents of `compare`, `diagnose`, `add`, `ladder` and `suggest`."""

import math
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from sim.effects.catalogue import find
from sim.effects.effect import rotary_unit
from stagecad.parameters.units import as_json
from sysid.compare import Comparison
from sysid.diagnose import IN_FULL, Diagnosis
from sysid.diagnosis.candidate import Candidate
from sysid.diagnosis.residual_maps import ResidualMap
from sysid.estimation.covariance import (
    Intervals,
    correlation_json,
    identifiability_report,
    intervals,
    public_key,
    substitution_angle,
)
from sysid.estimation.fit import FittedModel, information_criteria, root_mean_huber
from sysid.estimation.misfit import ChannelMisfit, worst_over_noise
from sysid.estimation.residual_correlation import residual_correlation
from sysid.experiment.rigs import CHANNELS
from sysid.experiment_design.detectability import minimum_detectable_effects
from sysid.experiment_design.t_optimal_design import Suggestion
from sysid.prediction.effect_terms import split_channel
from sysid.prediction.problem import Problem
from sysid.prediction.sensors import PREFIX as SCALE
from sysid.prediction.simulation_error import SimulationErrors, SimulationMisfit, simulation_errors

SCHEMA = 1
LEAST_P = 0.001
WORTH_SAYING = 0.1
"""Share of the squared residual from which it is reported that an effect with an unphysical value would remove it."""

RIG_UNITS = {
    "mass": ("kg", "kg*m^2"),
    "pull_stiffness": ("N/m", "N*m/rad"),
    "pull_damping": ("N*s/m", "N*m*s/rad"),
    "gain": ("m/V", "m/V"),
    "contact_stiffness": ("N/m", "N/m"),
    "contact_damping": ("N*s/m", "N*s/m"),
    "press": ("m", "m"),
    "guide_stiffness": ("N/m", "N/m"),
    "turn": ("rad", "rad"),
}


def channel_unit(problem: Problem, channel: str) -> str:
    """SI unit of a channel on this rig's axis."""
    return CHANNELS[channel].si_unit(problem.experiment.rig.rotary)


def parameter_unit(problem: Problem, key: str) -> str:
    """SI unit of a parameter by key on this rig's axis; `1` for a dimensionless one."""
    effect, _, name = key.rpartition(".")
    rotary = problem.experiment.rig.rotary
    if effect == "rig":
        if key.startswith(SCALE):
            return "1"
        if name.startswith("offset_"):
            return channel_unit(problem, name.removeprefix("offset_"))
        return RIG_UNITS[name][1 if rotary else 0]

    unit = find(effect, problem.custom).parameter(name).unit
    if "channel" in unit:
        channel = split_channel(effect)[1] or next(iter(problem.fit_records[0].measured))
        return unit.replace("channel", channel_unit(problem, channel))
    return rotary_unit(unit) if rotary else unit


def p_value_json(p: float) -> Any:
    """A p value, or `{"below": 0.001}` below the resolution of the permutations."""
    return {"below": LEAST_P} if p <= 1.5 * LEAST_P else float(p)


def noise_json(problem: Problem) -> dict[str, Any]:
    """Noise by measured channel, with the source of its estimate."""
    measured = set(problem.fit_records[0].measured)
    return {c: n.to_json() for c, n in problem.noise.items() if c in measured or c == "position"}


def both_json(
    problem: Problem, fit: Mapping[str, ChannelMisfit], validate: Mapping[str, ChannelMisfit]
) -> dict[str, Any]:
    """rms, error over noise and fit percent by channel, on the records of the fit and on the held-out ones."""
    return {
        part: {
            channel: {
                "rms": as_json(m.rms, channel_unit(problem, channel)),
                "over_noise": m.over_noise,
                "fit_percent": m.fit_percent if math.isfinite(m.fit_percent) else None,
            }
            for channel, m in by_channel.items()
        }
        for part, by_channel in (("fit", fit), ("validate", validate))
    }


def simulation_json(problem: Problem, errors: SimulationErrors) -> dict[str, Any]:
    """Errors of a free run, and of simulations over short horizons, by set of records and channel."""

    def of_sets(found: Mapping[str, Mapping[str, SimulationMisfit]]) -> dict[str, Any]:
        return {
            part: {
                channel: {"rms": as_json(m.rms, channel_unit(problem, channel)), "fit_percent": m.fit_percent}
                for channel, m in by_channel.items()
            }
            for part, by_channel in found.items()
        }

    return {
        "free_run": of_sets(errors.free_run),
        "horizon": {name: of_sets(found) for name, found in errors.horizon.items()},
    }


def parameters_json(
    problem: Problem, fitted: FittedModel, found: Intervals | None = None, only: str | None = None
) -> dict[str, Any]:
    """Fitted values with standard deviation and 95 % interval, by key; `only` those of one effect."""
    found = intervals(fitted, problem.fit_records) if found is None else found
    out: dict[str, Any] = {}
    for key, interval in found.by_key.items():
        if only is not None and key.rpartition(".")[0] != only:
            continue
        entry = as_json(interval.value, parameter_unit(problem, key), interval.std, interval.low, interval.high)
        # Values that are not identifiable are null: JSON has no infinite numbers.
        entry.update({name: None for name in ("std", "low", "high") if not np.isfinite(entry[name])})
        if key in fitted.model.nuisances:
            entry["nuisance"] = True
        if interval.at_bound:
            entry["at_bound"] = True
        out[public_key(key)] = entry
    return out


def identifiability_json(fitted: FittedModel, found: Intervals) -> dict[str, Any]:
    """Values that are not identifiable or strongly correlated, in words, and the correlations."""
    return {"not_identifiable": identifiability_report(fitted, found), "correlation": correlation_json(found)}


def where_json(maps: Sequence[ResidualMap]) -> list[dict[str, Any]]:
    """Coordinates on which the residual depends, largest explained share first."""
    return [
        {"coordinate": m.coordinate, "share": m.share, "p_value": p_value_json(m.p_value)}
        for m in maps
        if m.share > 0.0
    ]


def headline_channel(problem: Problem) -> str:
    """The channel whose error is reported where one number is needed: the force, or the first measured channel."""
    record = problem.fit_records[0]
    return getattr(record, "force_channel", "") or next(iter(record.measured))


def worst_channel(problem: Problem, by_channel: Mapping[str, ChannelMisfit]) -> str:
    """The channel with the largest error over noise."""
    return max(by_channel, key=lambda c: by_channel[c].over_noise) if by_channel else headline_channel(problem)


def ranking_json(diagnosis: Diagnosis, most: int = 12) -> list[dict[str, Any]]:
    """Candidate effects, best first: held-out error, its reduction, p value and fitted values of each."""
    problem = diagnosis.problem
    channel = worst_channel(problem, diagnosis.before_validate)
    before = diagnosis.before_validate[channel].rms if channel in diagnosis.before_validate else float("nan")
    rows = []
    for k, trial in enumerate(diagnosis.trials[:most]):
        row: dict[str, Any] = {"effect": trial.public_name}
        in_full = k < IN_FULL
        after = trial.after_validate.get(channel) if in_full else None
        if after is not None:
            row["validate_error"] = as_json(after.rms, channel_unit(problem, channel))
            row["reduction"] = 1.0 - after.rms / before if before > 0 else None
            row["over_noise"] = after.over_noise
        row["p_value"] = p_value_json(trial.gain.p_value)
        row["expected_reduction"] = 1.0 - float(np.sqrt(max(0.0, 1.0 - trial.reductions.predicted)))
        fits = (diagnosis.base.fitted, trial.fitted)
        before_it, with_it = (information_criteria(one, trial.fitted) for one in fits)
        if before_it.samples == with_it.samples:
            row |= {"aic_change": with_it.aic - before_it.aic, "bic_change": with_it.bic - before_it.bic}
        row["loss_reduction"] = 1.0 - trial.error / max(root_mean_huber(diagnosis.base.residual), 1e-300)
        if trial.reductions.blocked >= WORTH_SAYING:
            row["unphysical_reduction"] = 1.0 - float(np.sqrt(1.0 - min(trial.reductions.blocked, 1.0)))
        if trial.implausible is not None:
            row["implausible"] = trial.implausible
        if trial.name != trial.public_name:
            row["law"] = trial.name
        if after is not None:
            row["parameters"] = parameters_json(problem, trial.fitted, only=trial.name)
        angle = angle_to_best(diagnosis, trial)
        if angle is not None:
            row["angle"] = as_json(angle, "rad")
        rows.append(row)
    return rows


def angle_to_best(diagnosis: Diagnosis, trial: Candidate) -> float | None:
    """Angle, rad, between the change of the residual by the named effect and the changes possible with this one."""
    best, base = diagnosis.best, diagnosis.base.fitted
    if best is None or trial is best:
        return None
    one, other = best.fitted, trial.fitted
    if not one.fit.residual.size == other.fit.residual.size == base.fit.residual.size:
        # Quantisation is fitted with other weights, so the residuals are not comparable.
        return None
    return substitution_angle(one, other, base)


def ledger_json(diagnosis: Diagnosis) -> dict[str, Any]:
    """Every effect of the ledger with its state and evidence, and what the established ones leave.

    `share` and `gain` (of the held-out rms) are those of the effect beside all others of the set, `form` is the gain of
    its law over that with a free curve of its coordinates on top, `of_the_rest` the part of what is left without it.
    """
    problem, ledger = diagnosis.problem, diagnosis.ledger
    rows = []
    for entry in ledger.entries:
        row: dict[str, Any] = {"effect": entry.name, "state": entry.state}
        evidence = entry.evidence
        if evidence is not None and entry.below is not None:
            channel = worst_channel(problem, entry.below.after_validate)
            gain = entry.below.after_validate[channel].rms - entry.model.after_validate[channel].rms
            row |= {
                "share": evidence.share,
                "gain": as_json(gain, channel_unit(problem, channel)),
                "p_value": p_value_json(evidence.p_value),
                "form": 1.0 / (1.0 + max(evidence.form, 0.0)),
                "of_the_rest": evidence.own_share,
                "amplitude_held_out": evidence.held.amplitude,
                "deviations": evidence.z,
            }
        row["indistinguishable"] = list(entry.ties)
        row["parameters"] = parameters_json(problem, entry.model.fitted, only=entry.effect.name)
        row["reason"] = entry.reason
        rows.append(row)
    after = ledger.model.after_validate or ledger.model.after_fit
    percent = after[headline_channel(problem)].fit_percent if headline_channel(problem) in after else math.nan
    return {
        "ledger": rows,
        "explained_percent": percent if math.isfinite(percent) else None,
        "remainder": {
            "share": diagnosis.unexplained_share,
            "coordinate": ledger.coordinate or None,
            "over_noise": worst_over_noise({}, after),
        },
    }


def diagnosis_json(diagnosis: Diagnosis) -> dict[str, Any]:
    """The document of `diagnose`."""
    problem, best = diagnosis.problem, diagnosis.best
    after = best or next(iter(diagnosis.trials), None)
    changed = ({}, {}) if after is None else (after.after_fit, after.after_validate)
    fitted = best.fitted if best is not None else diagnosis.base.fitted
    found = intervals(fitted, problem.fit_records)
    curve, named = diagnosis.free_curve, diagnosis.best_named
    return {
        "schema": SCHEMA,
        "form": problem.form,
        "warnings": list(diagnosis.warnings),
        "verdict": diagnosis.verdict,
        "effect": diagnosis.effect,
        "indistinguishable": list(diagnosis.indistinguishable),
        "reason": diagnosis.reason,
        **ledger_json(diagnosis),
        "noise": noise_json(problem),
        "before": both_json(problem, diagnosis.before_fit, diagnosis.before_validate),
        "after": both_json(problem, *changed),
        **simulation_json(problem, simulation_errors(problem, diagnosis.base.fitted.model)),
        "information": vars(information_criteria(diagnosis.base.fitted)),
        "ranking": ranking_json(diagnosis),
        "parameters": parameters_json(problem, fitted, found),
        **identifiability_json(fitted, found),
        "detectable": [
            {
                "effect": one.effect,
                "parameter": public_key(one.key),
                "value": one.value,
                "unit": parameter_unit(problem, one.key),
                "at": {public_key(key): as_json(value, parameter_unit(problem, key)) for key, value in one.at.items()},
            }
            for one in minimum_detectable_effects(diagnosis)
        ],
        "where": where_json(diagnosis.maps),
        "unexplained_share": diagnosis.unexplained_share,
        "free_curve": curve and {name: getattr(curve, name) for name in ("coordinate", "share", "recurs")},
        "best_named": named and {"effect": named[0], "share": named[1]},
        "swaps": [
            {"instead_of": s.old, "effect": s.new, "over_noise": {"before": s.before, "after": s.after}}
            for s in diagnosis.replacements
        ],
        "laws": list(diagnosis.base.laws),
        "notes": list(problem.notes),
        "seconds": diagnosis.seconds,
    }


def comparison_json(comparison: Comparison) -> dict[str, Any]:
    """The document of `compare`."""
    problem, base = comparison.problem, comparison.base
    found = intervals(base.fitted, problem.fit_records)
    return {
        "schema": SCHEMA,
        "form": problem.form,
        "warnings": list(comparison.warnings),
        "effects": [e.name for e in base.fitted.model.effects],
        "noise": noise_json(problem),
        "before": both_json(problem, comparison.fit, comparison.validate),
        **simulation_json(problem, comparison.simulation),
        "parameters": parameters_json(problem, base.fitted, found),
        "information": vars(information_criteria(base.fitted)),
        "correlation_of_residual": residual_correlation_json(problem, base.fitted),
        **identifiability_json(base.fitted, found),
        "at_bound": [public_key(k) for k in base.fitted.fit.at_bound],
        "dead": [public_key(k) for k in base.fitted.fit.inactive],
        "where": where_json(comparison.maps),
        "notes": [*problem.notes, *([comparison.simulation.note] if comparison.simulation.note else [])],
        "seconds": comparison.seconds,
    }


def residual_correlation_json(problem: Problem, fitted: FittedModel) -> dict[str, Any]:
    """For each channel, on the records of the fit: whether the residual is white noise, its autocorrelation at lag one,
    and the inputs that it correlates with: the largest correlation and its lag."""
    out: dict[str, Any] = {}
    for channel in dict.fromkeys(name for record in problem.fit_records for name in record.measured):
        found = residual_correlation(problem, fitted.model, channel)
        correlated = {}
        for name in found.correlated_inputs:
            k = int(np.argmax(np.abs(found.cross[name])))
            lag = as_json(float(found.cross_lags[k]), "s")
            correlated[name] = {"correlation": float(found.cross[name][k]), "lag": lag}
        out[channel] = {
            "white": found.is_white,
            "p_value": p_value_json(found.p_value),
            "autocorrelation": float(found.autocorrelation[1]),
            "step": as_json(found.step, "s"),
            "correlated_with": correlated,
        }
    return out


def suggestion_json(found: Suggestion, files: Sequence[str | None]) -> list[dict[str, Any]]:
    """The document of `suggest`; `files` has the file of each motion, none where it is not written."""
    return [
        {
            "motion": value.motion.name,
            "reason": value.motion.reason,
            "seconds": value.motion.seconds,
            "separates": [
                {"effects": list(p.effects), "deviations": p.deviations, "these_records": p.records}
                for p in value.pairs
            ],
            "deviations": value.least,
            "deviations_squared_per_second": value.rate,
            "file": file,
        }
        for value, file in zip(found.motions, files, strict=True)
    ]
