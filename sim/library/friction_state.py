"""Friction state model: turns the friction level into a force, with internal states such as the deflection of bristles.

In a simulation it is a set of elements, each with one state z that depends on the rest of the axis through the velocity
v and the level g alone, so the Jacobian of any model is an arrowhead:

    z_k' = rate(z_k, v, g),    friction = sum over k of force(z_k, v, g)

A law receives the direction of the motion and uses direction * v for the speed |v|: an integrator keeps the direction
within a step, so that the law stays smooth past a reversal.

Along a measured motion it is an operator on the record, with an exact step from row to row.
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
        name: of the model.
        law: rate of one element's state and its share of the force, N. Zero level means no force.
        slopes: the exact partial derivatives of `law`.
        along_record: the force along a measured motion, of shape (n,).
        scale: typical size of a state, to set the absolute tolerance of an integration; a function of `p`.
        state: meaning of the state, with its unit.
        elements: how many states; a function of `p`.
        stored: energy in the spring of element k, `stored(k, z, g, p)` in J, shaped as z and g; None where no energy
            function exists.
        springs: stretches (N,) at which parallel ideal springs slip, m, and the parts (N,) of the level they carry,
        where the
            model consists of such; a function of `p`.
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
