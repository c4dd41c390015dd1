"""Plausibility of fitted values: whether an effect whose parameter ended at a bound still is an explanation."""

from __future__ import annotations

from collections.abc import Collection

from sim.library.effect import Parameter
from sysid.estimation.fit import FittedModel


def implausible(fitted: FittedModel, added: Collection[str], base: FittedModel | None = None) -> str | None:
    """Reason why a fitted model explains nothing although its error is low, in words; None if there is none.

    A value at an end of its range means that the fit wants to leave the range: the effect, or the mass, stands for
    something else. Ends that are a limit of the law itself (`Parameter.natural`) are excepted, and so is zero.

    Args:
        fitted: the model with the effects.
        added: names of the effects in question, with variant and channel.
        base: the model without them; a value of the rig that is at the same bound there is no consequence of them.
    """
    parameters = {f"{e.name}.{p.name}": p for e in fitted.model.effects if e.name in added for p in e.parameters}
    before = () if base is None else base.fit.at_bound
    for unknown in fitted.model.unknowns:
        key = unknown.key
        if key not in fitted.fit.at_bound:
            continue
        upper = fitted.fit.values[key] >= unknown.high
        of_effect = key in parameters and not _natural(parameters[key], upper)
        if of_effect or (key.startswith("rig.") and key not in before):
            end = unknown.high if upper else unknown.low
            unit = parameters[key].unit if of_effect and parameters[key].unit in ("s", "Hz") else ""
            return f"{key} is at its {'upper' if upper else 'lower'} bound, {end:.3g} {unit}".strip()
    return None


def _natural(parameter: Parameter, upper: bool) -> bool:
    if parameter.role == "phase" or parameter.natural in ("both", "high" if upper else "low"):
        return True
    return not upper and parameter.low == 0.0 and parameter.scan is None
