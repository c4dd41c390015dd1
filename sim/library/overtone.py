"""The overtone of a wave along the travel: what lapping marks, teeth and magnets leave is seldom a pure sine.

    w = sin a + second_sine sin 2a + second_cosine cos 2a,    a = 2 pi x / pitch + phase,    |w| < 1.6

The laws that have it write it out, since their derivatives are taken from their text (`sim.numerics.derivative`).
"""

from __future__ import annotations

from sim.library.effect import Parameter

SECOND = (
    Parameter(
        "second_sine", "1", 0.0, -0.3, 0.3, "sine part of the second harmonic, over the amplitude", "one wave", "shape"
    ),
    Parameter(
        "second_cosine",
        "1",
        0.0,
        -0.3,
        0.3,
        "cosine part of the second harmonic, over the amplitude",
        "one wave",
        "shape",
    ),
)
"""Parameters of the overtone."""
