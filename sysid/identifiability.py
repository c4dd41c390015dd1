"""What records leave open of fitted values, in words: values they do not tell, and values they tell only together."""

from __future__ import annotations

from typing import Any

import numpy as np

from sysid.base_fit import Fitted
from sysid.intervals import Intervals

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
    names = [public_key(key) for key in known.keys]
    for i in range(len(names)):
        for j in range(i):
            r = float(known.correlation[i, j])
            if abs(r) > STRONG_CORRELATION:
                words.append(f"{names[j]} and {names[i]} hang together (correlation {r:+.2f}).")
    if not fitted.fit.converged:
        words.append("The fit stopped before its last step was small.")
    return words


def correlation_json(known: Intervals) -> dict[str, Any]:
    """Correlations of the fitted values: `keys`, and `matrix` with null for a value the records do not tell."""
    matrix = [[None if not np.isfinite(v) else round(float(v), 4) for v in row] for row in known.correlation]
    return {"keys": [public_key(key) for key in known.keys], "matrix": matrix}


def public_key(key: str) -> str:
    """A parameter's key under the name everyone uses: `stribeck:rational.velocity` -> `stribeck.velocity`."""
    effect, _, name = key.rpartition(".")
    return f"{effect.partition(':')[0]}.{name}" if ":" in effect else key
