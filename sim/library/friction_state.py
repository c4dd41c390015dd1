"""What a core is: it turns the friction level into a force, with memory in the stretch of bristles.

In a simulation a core is a set of elements, each with one state z that depends on the rest of the axis through the
velocity v and the level g alone, so the Jacobian of any model is an arrowhead:

    z_k' = rate(z_k, v, g),    friction = sum over k of force(z_k, v, g)

A law is told the direction of the motion and takes direction * v for the speed |v|: an integrator holds the direction
through a step, so that the law stays smooth past a reversal inside it.

Along a measured motion it is an operator on the record, stepped exactly from row to row instead of integrated.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

Element = Callable[[int, float, float, float, float, Any], tuple[float, float]]
"""`law(k, z, v, direction, g, p) -> (rate, force)` of element k."""

ElementSlopes = Callable[[int, float, float, float, float, Any], tuple[float, float, float, float, float, float]]
"""`slopes(k, z, v, direction, g, p) -> (rate_z, rate_v, rate_g, force_z, force_v, force_g)`, exact."""

AlongRecord = Callable[[np.ndarray, np.ndarray, np.ndarray, np.ndarray, Any], np.ndarray]
"""`along_record(position, velocity, time, level, p) -> force`, all of shape (n,)."""


@dataclass(frozen=True)
class FrictionStateModel:
    """How the friction level becomes a force.

    Args:
        name: the core's name.
        law: rate of one element's state and its share of the force, N. Zero level means no force.
        slopes: the exact partial derivatives of `law`.
        along_record: the force along a measured motion, of shape (n,).
        scale: typical size of a state, to set the absolute tolerance of an integration; a function of `p`.
        state: what the state is, with its unit.
        elements: how many states; a function of `p`.
        stored: energy in the spring of element k, `stored(k, z, g, p)` in J, shaped as z and g; None where no energy
            function exists.
        springs: stretches (N,) at which ideal springs side by side slip, m, and the parts (N,) of the level they carry,
            where the core is made of such; a function of `p`.
    """

    name: str
    law: Element
    slopes: ElementSlopes
    along_record: AlongRecord
    scale: Callable[[Any], float]
    state: str = "stretch of the bristles, m"
    elements: Callable[[Any], int] = lambda p: 1
    stored: Callable[[int, Any, Any, Any], Any] | None = None
    springs: Callable[[Any], tuple[np.ndarray, np.ndarray]] | None = None
