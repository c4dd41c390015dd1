"""Identifiability report: correlations, inactive values, bounds and combinations."""

from typing import Any

import numpy as np

from sysid.estimation.covariance import Intervals
from sysid.estimation.fit import FittedModel
from sysid.estimation.identifiability import correlation_json, identifiability_report, public_key
from sysid.estimation.least_squares import FitResult
from sysid.estimation.misfit import ResidualWeights
from sysid.prediction.model import Model

KEYS = ("coulomb.force", "viscous.coefficient", "stribeck:rational.force", "constant_bias.force")


def fitted(**changes: Any) -> FittedModel:
    values = dict.fromkeys(KEYS, 1.0)
    fit = FitResult(values, 1.0, np.eye(4), np.zeros(4), np.ones(4), KEYS, **changes)
    return FittedModel(Model((), values, ()), fit, ResidualWeights((), ()))


def intervals(*pairs: tuple[int, int, float], unidentified: tuple[str, ...] = ()) -> Intervals:
    matrix = np.eye(4)
    for i, j, r in pairs:
        matrix[i, j] = matrix[j, i] = r
    return Intervals({}, KEYS, matrix, unidentified)


def test_report_is_empty_where_every_value_is_identifiable() -> None:
    assert identifiability_report(fitted(), intervals((0, 1, 0.85))) == []


def test_strongly_correlated_pair_is_reported_with_its_correlation() -> None:
    assert identifiability_report(fitted(), intervals((0, 1, -0.97))) == [
        "coulomb.force and viscous.coefficient are strongly correlated (-0.97)."
    ]


def test_chain_of_correlations_is_one_sentence_with_public_names() -> None:
    words = identifiability_report(fitted(), intervals((0, 1, -0.97), (1, 2, 0.95)))
    assert len(words) == 1
    assert words[0].startswith("coulomb.force, viscous.coefficient and stribeck.force are strongly correlated")
    assert "constant_bias" not in words[0]


def test_inactive_values_bounds_and_combinations_are_reported() -> None:
    words = identifiability_report(
        fitted(inactive=("viscous.coefficient",), at_bound=("coulomb.force",), converged=False),
        intervals(unidentified=("stribeck:rational.force against constant_bias.force",)),
    )
    assert words == [
        "viscous.coefficient has no influence in these records.",
        "coulomb.force is at its bound; it has no interval.",
        "Only a combination is identifiable from these records, not each value alone: "
        "stribeck.force against constant_bias.force.",
        "The fit stopped before it converged: values and intervals are approximate; state known values, or better "
        "start values, in [model.parameters].",
    ]


def test_value_that_is_not_identifiable_has_no_correlation() -> None:
    known = intervals((0, 1, 0.5))
    known.correlation[3, :] = known.correlation[:, 3] = np.nan
    document = correlation_json(known)
    assert document["keys"][2] == "stribeck.force"
    assert document["matrix"][0][1] == 0.5
    assert document["matrix"][3] == [None] * 4


def test_public_keys_keep_channels_and_drop_variants() -> None:
    assert public_key("sensor_lag@position.time_constant") == "sensor_lag@position.time_constant"
    assert public_key("presliding:lugre.stiffness") == "presliding.stiffness"
