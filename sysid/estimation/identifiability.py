"""What records leave open of fitted values, in words: values they do not tell, and values they tell only together.
How far apart two effects point: principal angles between what they add to a model that neither is part of yet.

    A, B: sensitivities of the residual to each effect's own values, the base model's taken out of both
    cos(angle_k) = k-th singular value of Q_A^T Q_B,   Q orthonormal

(Bjorck and Golub, Math. Comp. 27 (1973) 579). Where the angle between what one effect takes and what another could make
is small, the other could stand in its place, to first order.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from sysid.estimation.covariance import Intervals
from sysid.estimation.fit import FittedModel
from sysid.estimation.score_test import orthonormal

STRONG_CORRELATION = 0.9
"""Correlation of two fitted values from which they are said to hang together."""


def identifiability_report(fitted: FittedModel, known: Intervals) -> list[str]:
    """Sentences on what the records do not tell; none where every value stands on its own."""
    words = [f"{public_key(key)} changes nothing in these records." for key in fitted.fit.inactive]
    words += [f"{public_key(key)} ended at its bound; its interval is not told." for key in fitted.fit.at_bound]
    words += [
        "Only a combination is told, not each by itself: "
        + " against ".join(public_key(k) for k in text.split(" against "))
        + "."
        for text in known.unidentified
    ]
    words += [_together(group, known) for group in _groups(known)]
    if not fitted.fit.converged:
        words.append("The fit stopped before its last step was small.")
    return words


def _groups(known: Intervals) -> list[list[int]]:
    """Values that are strongly correlated, each with some other of its group, by their place."""
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


def _together(group: list[int], known: Intervals) -> str:
    names = [public_key(known.keys[k]) for k in group]
    if len(group) == 2:
        r = float(known.correlation[group[0], group[1]])
        return f"{names[0]} and {names[1]} hang together (correlation {r:+.2f})."
    largest = float(np.max(np.abs(known.correlation[np.ix_(group, group)][np.triu_indices(len(group), 1)])))
    return (
        f"{', '.join(names[:-1])} and {names[-1]} hang together (correlations up to {min(largest, 0.999):.3g}): "
        "what one of them takes, the others give."
    )


def correlation_json(known: Intervals) -> dict[str, Any]:
    """Correlations of the fitted values: `keys`, and `matrix` with null for a value the records do not tell."""
    matrix = [[None if not np.isfinite(v) else round(float(v), 4) for v in row] for row in known.correlation]
    return {"keys": [public_key(key) for key in known.keys], "matrix": matrix}


def public_key(key: str) -> str:
    """A parameter's key under the name everyone uses: `stribeck:rational.velocity` -> `stribeck.velocity`."""
    effect, _, name = key.rpartition(".")
    return f"{effect.partition(':')[0]}.{name}" if ":" in effect else key


LEAST_OWN = 1e-4
"""Part of a sensitivity that the base model does not make itself, below which it is no direction of its own."""


def principal_angles(one: np.ndarray, other: np.ndarray) -> np.ndarray:
    """Angles (min(p, q),), rad, rising, between the spans of orthonormal bases (n, p) and (n, q)."""
    cosines = np.linalg.svd(one.T @ other, compute_uv=False)
    # An arc cosine loses half its digits near one: small angles come from their sines.
    small, large = (one, other) if one.shape[1] <= other.shape[1] else (other, one)
    sines = np.linalg.svd(small - large @ (large.T @ small), compute_uv=False)[::-1]
    angles = np.arccos(np.clip(cosines, -1.0, 1.0))
    return np.where(angles < 0.1, np.arcsin(np.clip(sines[: angles.size], 0.0, 1.0)), angles)


def own_directions(fitted: FittedModel, base: FittedModel) -> np.ndarray:
    """Orthonormal basis (n, p) of what a grown model's new values do that no value of the base model does.

    Both fits score the same samples with the same deviations.
    """
    new = np.array([key not in base.fit.keys for key in fitted.fit.keys], dtype=bool)
    columns = fitted.fit.jacobian[:, new]
    norms = np.linalg.norm(columns, axis=0)
    alive = norms > 0.0
    columns = columns[:, alive] / norms[alive]
    basis = orthonormal(base.fit.jacobian)
    free = columns - basis @ (basis.T @ columns)
    return orthonormal(free[:, np.linalg.norm(free, axis=0) > LEAST_OWN])


def substitution_angle(effect: FittedModel, other: FittedModel, base: FittedModel) -> float | None:
    """Angle, rad, between what an effect takes from the residual and what another could make; none where it is nothing.

    Of two effects with unlike numbers of values the one may be able to do all that the other does, and not the other
    way round: this asks whether `other` could stand in for `effect`. What `other` takes itself is among what it could
    make: far from zero a lag does more than its slope there tells.
    """
    basis = orthonormal(base.fit.jacobian)

    def taken(grown: FittedModel) -> np.ndarray | None:
        whole = base.fit.residual - grown.fit.residual
        free = whole - basis @ (basis.T @ whole)
        size = float(np.linalg.norm(free))
        return None if size <= LEAST_OWN * float(np.linalg.norm(whole)) else free / size

    wanted, made = taken(effect), taken(other)
    could = own_directions(other, base)
    if made is not None:
        could = orthonormal(np.column_stack([could, made]))
    if wanted is None or could.shape[1] == 0:
        return None
    return float(principal_angles(wanted[:, None], could)[0])
