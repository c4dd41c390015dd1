"""Plausibility of fitted values: whether an effect whose parameter ended at a bound still is an explanation."""

from __future__ import annotations

from collections.abc import Collection

from sim.effects.effect import Parameter
from sysid.estimation.fit import FittedModel


def rig_values_at_bound(fitted: FittedModel, base: FittedModel) -> list[str]:
    """Keys of the rig's values that are at a bound, and are not in the fit without the effects, `base`."""
    return [key for key in fitted.fit.at_bound if key.startswith("rig.") and key not in base.fit.at_bound]


def implausible(fitted: FittedModel, added: Collection[str]) -> str | None:
    """Reason why a fitted model explains nothing although its error is low, in words; None if there is none.

    A value at an end of its range means that the fit wants to leave the range: the effect stands for something else.
    Ends that are a limit of the law itself (`Parameter.natural`) are excepted, and so is zero.
    """
    parameters = {f"{e.name}.{p.name}": p for e in fitted.model.effects if e.name in added for p in e.parameters}
    for unknown in fitted.model.unknowns:
        key = unknown.key
        if key not in fitted.fit.at_bound:
            continue
        upper = fitted.fit.values[key] >= unknown.high
        if key in parameters and not _natural(parameters[key], upper):
            end = unknown.high if upper else unknown.low
            unit = parameters[key].unit if parameters[key].unit in ("s", "Hz") else ""
            return f"{key} is at its {'upper' if upper else 'lower'} bound, {end:.3g} {unit}".strip()
    return None


def _natural(parameter: Parameter, upper: bool) -> bool:
    if parameter.role == "phase" or parameter.natural in ("both", "high" if upper else "low"):
        return True
    return not upper and parameter.low == 0.0 and parameter.scan is None
