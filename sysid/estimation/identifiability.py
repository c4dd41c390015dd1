"""What records leave open of fitted values, in words: values they do not tell, and values they tell only together."""

from __future__ import annotations

from typing import Any

import numpy as np

from sysid.estimation.base_fit import Fitted
from sysid.estimation.covariance import Intervals

STRONG_CORRELATION = 0.9
"""Correlation of two fitted values from which they are said to hang together."""


def open_words(fitted: Fitted, known: Intervals) -> list[str]:
    """Sentences on what the records do not tell; none where every value stands on its own."""
    words = [f"{public_key(key)} changes nothing in these records." for key in fitted.fit.dead]
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
