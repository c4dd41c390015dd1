"""Damping of the bristles while they stretch."""

from __future__ import annotations

from typing import Any

import numpy as np

from sim.effect import Axis, Effect, Parameter, Scan


def _force(axis: Axis, p: Any) -> Any:
    from sim.record_kernels import stop

    stretched = stop(np.ascontiguousarray(axis.position), p.stretch)
    return p.damping * axis.velocity * (np.abs(stretched) < 1.0)


EFFECT = Effect(
    name="bristle_damping",
    meaning="the contact resists the rate of its stretch, before it slides (the a1 of LuGre)",
    equation="F = damping * v while a bristle of +-stretch has not slipped; 0 once it slides",
    shows="just after a reversal the force is higher the faster the axis turns round",
    source="Canudas de Wit, Olsson, Astrom, Lischinsky, IEEE Trans. Automatic Control 40 (1995) 419",
    acts_on="friction",
    coordinates=("distance_since_reversal", "velocity"),
    parameters=(
        Parameter("damping", "N*s/m", 10.0, 0.0, 1e9, "force per rate of stretch", "damping dissipates: >= 0"),
        Parameter("stretch", "m", 1e-5, 1e-12, 1e3, "displacement after which it slides", "thesis: 2-5 um in steel",
                  role="shape", scan=Scan("position", 1e-4, 0.1, 6)),
    ),
    force=_force,
)  # fmt: skip
