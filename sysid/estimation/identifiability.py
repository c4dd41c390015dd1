"""Identifiability of fitted values: report in words, correlations, and principal angles between effects.

The principal angles between the spans of two sets of sensitivities A and B, base model projected out of both, are

    cos(angle_k) = k-th singular value of Q_A^T Q_B,   Q orthonormal

(Bjorck and Golub, Math. Comp. 27 (1973) 579). Where the angle between the change that one effect makes and the span of
another is small, the other could replace it, to first order.
"""

from collections.abc import Collection
from typing import Any

import numpy as np

from sim.effects.effect import Parameter
from sysid.estimation.covariance import Intervals
from sysid.estimation.fit import FittedModel
from sysid.estimation.score_test import orthonormal, project_out

STRONG_CORRELATION = 0.9
"""Absolute correlation from which two fitted values are reported as strongly correlated."""

LEAST_OWN = 1e-4
"""Norm of the part of a sensitivity orthogonal to the base model, relative to the total, below which it is taken as
linearly dependent."""


def identifiability_report(fitted: FittedModel, known: Intervals) -> list[str]:
    """Sentences on values that are not identifiable or strongly correlated."""
    hidden = fitted.model.nuisances
    inactive, at_bound = ([k for k in keys if k not in hidden] for keys in (fitted.fit.inactive, fitted.fit.at_bound))
    words = [f"{public_key(key)} has no influence in these records." for key in inactive]
    words += [f"{public_key(key)} is at its bound; it has no interval." for key in at_bound]
    words += [
        "Only a combination is identifiable from these records, not each value alone: "
        + " against ".join(public_key(k) for k in text.split(" against "))
        + "."
        for text in known.unidentified
        if " against " in text
    ]
    words += [
        f"{public_key(key)} is not identifiable from these records: its interval is wider than a factor of 1000."
        for key in known.unidentified
        if " against " not in key and key not in hidden
    ]
    groups = ([k for k in group if known.keys[k] not in hidden] for group in _groups(known))
    words += [_correlated(group, known) for group in groups if len(group) > 1]
    if not fitted.fit.converged:
        words.append(
            "The fit stopped before it converged: values and intervals are approximate; state known values, or "
            "better start values, in [model.parameters]."
        )
    return words


def _groups(known: Intervals) -> list[list[int]]:
    """Connected groups of strongly correlated values, by their index."""
    strong = np.abs(np.nan_to_num(known.correlation)) > STRONG_CORRELATION
    left = set(range(len(known.keys)))
    groups = []
    while left:
        group, edge = set(), {min(left)}
        while edge:
            group |= edge
            edge = {int(j) for i in edge for j in np.flatnonzero(strong[i])} - group
        left -= group
        if len(group) > 1:
            groups.append(sorted(group))
    return groups


def _correlated(group: list[int], known: Intervals) -> str:
    names = [public_key(known.keys[k]) for k in group]
    if len(group) == 2:
        r = float(known.correlation[group[0], group[1]])
        return f"{names[0]} and {names[1]} are strongly correlated ({r:+.2f})."
    largest = float(np.max(np.abs(known.correlation[np.ix_(group, group)][np.triu_indices(len(group), 1)])))
    return (
        f"{', '.join(names[:-1])} and {names[-1]} are strongly correlated (up to {min(largest, 0.999):.3g}): "
        "a change of one is compensated by the others."
    )


def correlation_json(known: Intervals) -> dict[str, Any]:
    """Correlations of the fitted values: `keys`, and `matrix` with null for a value that is not identifiable."""
    matrix = [[None if not np.isfinite(v) else round(float(v), 4) for v in row] for row in known.correlation]
    return {"keys": [public_key(key) for key in known.keys], "matrix": matrix}


def public_key(key: str) -> str:
    """A parameter key under the public name of its effect: `stribeck:rational.velocity` -> `stribeck.velocity`."""
    effect, _, name = key.rpartition(".")
    return f"{effect.partition(':')[0]}.{name}" if ":" in effect else key


def principal_angles(one: np.ndarray, other: np.ndarray) -> np.ndarray:
    """Angles (min(p, q),), rad, rising, between the spans of orthonormal bases (n, p) and (n, q)."""
    cosines = np.linalg.svd(one.T @ other, compute_uv=False)
    # The arc cosine loses half its digits near one: small angles are taken from their sines.
    small, large = (one, other) if one.shape[1] <= other.shape[1] else (other, one)
    sines = np.linalg.svd(project_out(small, large), compute_uv=False)[::-1]
    angles = np.arccos(np.clip(cosines, -1.0, 1.0))
    return np.where(angles < 0.1, np.arcsin(np.clip(sines[: angles.size], 0.0, 1.0)), angles)


def orthogonal_sensitivities(fitted: FittedModel, base: FittedModel) -> np.ndarray:
    """Orthonormal basis (n, p) of the sensitivities to the added values, orthogonal to those of the base model.

    Both fits score the same samples with the same standard deviations.
    """
    new = np.array([key not in base.fit.keys for key in fitted.fit.keys], dtype=bool)
    columns = fitted.fit.jacobian[:, new]
    norms = np.linalg.norm(columns, axis=0)
    active = norms > 0.0
    free = project_out(columns[:, active] / norms[active], orthonormal(base.fit.jacobian))
    return orthonormal(free[:, np.linalg.norm(free, axis=0) > LEAST_OWN])


def substitution_angle(effect: FittedModel, other: FittedModel, base: FittedModel) -> float | None:
    """Angle, rad, between the change of the residual by one effect and the span of another; none without a change.

    The angle is not symmetric: of two effects with different numbers of values, one may be able to replace the other
    and not the reverse. The span of `other` includes the change that its own fit makes, which at large values (a long
    lag) differs from its sensitivities.
    """
    basis = orthonormal(base.fit.jacobian)

    def change(grown: FittedModel) -> np.ndarray | None:
        whole = base.fit.residual - grown.fit.residual
        free = project_out(whole, basis)
        size = float(np.linalg.norm(free))
        return None if size <= LEAST_OWN * float(np.linalg.norm(whole)) else free / size

    wanted, made = change(effect), change(other)
    span = orthogonal_sensitivities(other, base)
    if made is not None:
        span = orthonormal(np.column_stack([span, made]))
    if wanted is None or span.shape[1] == 0:
        return None
    return float(principal_angles(wanted[:, None], span)[0])


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
