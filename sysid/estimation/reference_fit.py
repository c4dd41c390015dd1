"""The model of a case at its best fit, with the law of each effect that fits best."""

from __future__ import annotations

from collections.abc import Callable, Collection
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from sim.library.catalogue import find, laws_of
from sysid.estimation.base_fit import Fitted, fit_model, ranking_error
from sysid.estimation.core_variants import core_laws
from sysid.estimation.initial_fit import first_fit
from sysid.estimation.misfit import Weighting, weighted_residual, weighting
from sysid.estimation.starting_points import searched
from sysid.prediction.model import Model, base_name, law_family
from sysid.prediction.observable import shows_on
from sysid.prediction.problem import Case
from sysid.signals.side_by_side import side_by_side


@dataclass(frozen=True)
class BaseFit:
    """The model of a case at its best, and what the comparison with others needs.

    Args:
        fitted: model, fit and weights on the records of the fit.
        weights: deviations and samples of the held-out records.
        residual: of the held-out records, in deviations, (n,).
        laws: effects of the model whose law was chosen among variants, as `stribeck:rational`.
        memo: searches on top of this fit that more than one question needs, by what they are.
    """

    fitted: Fitted
    weights: Weighting
    residual: np.ndarray
    laws: tuple[str, ...] = ()
    memo: dict[str, Any] = field(default_factory=dict, compare=False, repr=False)


def fit_case(case: Case, model: Model | None = None) -> BaseFit:
    """Fit the case's model; an effect named without a variant takes the law of its family that fits best."""
    chosen: tuple[str, ...] = ()
    if model is not None:
        fitted = fit_model(model, case.fit_records)
    else:
        given = [key for key, setting in case.experiment.parameters.items() if setting.start is not None]
        fitted = first_fit(case.start, case.fit_records, case.scales, given)
        fitted, chosen = best_laws(case, fitted)
    weights = weighting(fitted.model, case.validate_records)
    residual = weighted_residual(fitted.model, case.validate_records, weights)
    return BaseFit(fitted, weights, residual, chosen)


def clearly_better(other: Fitted, fitted: Fitted) -> bool:
    """Whether another law of an effect fits so much better that chance and its extra values do not explain it."""
    extra = len(other.model.unknowns) - len(fitted.model.unknowns)
    # Law by law the cost of a wrong curve is far above the noise; chance is not.
    return other.fit.cost < 0.97 * fitted.fit.cost - 4.0 * max(extra, 0)


BETTER_HELD_OUT = 0.67
"""Part of the held-out loss above the noise below which another law of an effect is taken for that alone."""


def holds_better(case: Case, other: Fitted, fitted: Fitted) -> bool:
    """Whether another law of an effect fits clearly better or, fitting no worse, predicts the held-out records so."""
    if clearly_better(other, fitted):
        return True
    weights = weighting(fitted.model, case.validate_records)
    errors = [ranking_error(weighted_residual(m, case.validate_records, weights)) for m in (other.model, fitted.model)]
    above = [error**2 - 1.0 for error in errors]
    return other.fit.cost <= fitted.fit.cost and above[1] > 0.5 and above[0] < BETTER_HELD_OUT * above[1]


def best_laws(
    case: Case,
    fitted: Fitted,
    families: Collection[str] | None = None,
    better: Callable[[Fitted, Fitted], bool] = clearly_better,
) -> tuple[Fitted, tuple[str, ...]]:
    """A fit in which effects have the best law of their family.

    The law of the family's own name is taken unless another is better.

    Args:
        case: whose records are fitted.
        fitted: the model as it stands, with any law of each family.
        families: names of the effects whose law is open; those of `open_laws` where left out.
        better: whether one fit is so much better than another that its law is taken.

    Returns:
        The fit, and the names of the laws that took their family's place.
    """
    chosen: list[str] = []
    for name in open_laws(case) if families is None else families:
        for place in dict.fromkeys(law_family(e.name) for e in fitted.model.effects):
            if name in (place, base_name(place)):
                fitted = _best_law(case, fitted, place, better)
                if "@" in place and "@" not in name:
                    fitted = _best_channel(case, fitted, place, better)
                chosen += [
                    e.name for e in fitted.model.effects if base_name(e.name) == base_name(place) and ":" in e.name
                ]
    return fitted, tuple(dict.fromkeys(chosen))


def _best_law(case: Case, fitted: Fitted, place: str, better: Callable[[Fitted, Fitted], bool]) -> Fitted:
    """A fit in which one effect, named without a variant, has its best law."""
    effect = find(place, case.custom)
    before: list[Fitted] = []
    if place not in {e.name for e in fitted.model.effects}:
        # Another law was chosen while the model still lacked something; its fit may be better than any begun anew.
        before = [fitted]
        fitted = searched(fitted, effect, case.fit_records, case.scales)
    if effect.core is not None:
        trials = core_laws(fitted, effect, case.fit_records, case.scales)
    else:
        shown = [law for law in laws_of(place, case.custom) if shows_on(case, law)]
        given, shared = fitted, (*shown, *fitted.model.effects)
        trials = side_by_side(lambda law: searched(given, law, case.fit_records, case.scales), shown, shared)
    best = min([*trials, *before], key=lambda t: t.fit.cost + 4.0 * len(t.model.unknowns), default=fitted)
    return best if better(best, fitted) else fitted


def _best_channel(case: Case, fitted: Fitted, place: str, better: Callable[[Fitted, Fitted], bool]) -> Fitted:
    """A fit in which a sensor's effect acts on the channel where it does best: which, what was missing may have hid."""
    present = {law_family(e.name) for e in fitted.model.effects}
    channels = [name for name in case.fit_records[0].measured if f"{base_name(place)}@{name}" not in present]
    places = [f"{base_name(place)}@{channel}" for channel in channels]
    laws = [law for other in places for law in (find(other, case.custom), *laws_of(other, case.custom))]
    trials = [searched(fitted, law, case.fit_records, case.scales, place) for law in laws if shows_on(case, law)]
    best = min(trials, key=lambda t: t.fit.cost + 4.0 * len(t.model.unknowns), default=fitted)
    return best if better(best, fitted) else fitted


def open_laws(case: Case) -> tuple[str, ...]:
    """Effects whose law is for the fit to choose: named without a variant, and with no value given by the user."""
    given = {key.rpartition(".")[0] for key in case.experiment.parameters}
    return tuple(
        e.name for e in case.start.effects
        if ":" not in e.name and e.variants and e.name not in given
    )  # fmt: skip
