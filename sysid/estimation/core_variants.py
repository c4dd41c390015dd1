"""Which law the bristles of a model's core follow: those with free shares begin where the fitted law ended."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from sim.effects.friction_state import free_maxwell_slip
from sim.library.effect import Effect
from sysid.estimation.base_fit import Fitted, fit_model, ranking_error
from sysid.estimation.starting_points import with_bounds_of
from sysid.prediction.model import Model, Prepared, Scales, with_effect

WORTH_A_SEARCH = 1.2
"""Ranking error, in deviations, up to which the law of a core is good enough."""

SPANS = (10.0, 100.0)
"""Longest stretch over the shortest, where the search begins."""


def core_laws(fitted: Fitted, core: Effect, records: Sequence[Prepared], scales: Scales) -> list[Fitted]:
    """Fits with the bristles of the model's core, Maxwell-slip of a given curve, left free; none where it fits."""
    if ranking_error(fitted.fit.residual) <= WORTH_A_SEARCH:
        return []
    free = next((v for v in core.variants if v.core is not None and v.core.name == "free_maxwell_slip"), None)
    if free is None or core.core is None or core.core.name != "maxwell_slip":
        return []
    starts = [with_effect(fitted.model, free, scales, _as_it_yields(fitted.model, core, free, span)) for span in SPANS]
    return [fit_model(with_bounds_of(start, fitted.model), records) for start in starts]


def _as_it_yields(model: Model, core: Effect, free: Effect, span: float) -> dict[str, float]:
    """Values of the free law with which it yields as the fitted core does."""
    stretch, curvature = (model.values[f"{core.name}.{name}"] for name in ("stretch", "curvature"))
    stretches = free_maxwell_slip.stretches_of(stretch, span)
    shares = free_maxwell_slip.shares_of(stretches, 1.0 - (1.0 - np.minimum(stretches / stretch, 1.0)) ** curvature)
    shares = np.maximum(shares, 1e-3 * np.max(shares))
    shares = shares / shares[free_maxwell_slip.HELD - 1]
    values = {f"{free.name}.share_{k + 1}": float(share) for k, share in enumerate(shares)}
    return {**values, f"{free.name}.stretch": stretch, f"{free.name}.span": span}
