"""Friction state model: turns the friction level into a force, with internal states such as the deflection of bristles.

In a simulation it is a set of elements, each with one state z that depends on the rest of the axis through the velocity
v and the level g alone, so the Jacobian of any model is an arrowhead:

    z_k' = rate(z_k, v, g),    friction = sum over k of force(z_k, v, g)

A law receives the direction of the motion and uses direction * v for the speed |v|: an integrator keeps the direction
within a step, so that the law stays smooth past a reversal.

Along a measured motion it is an operator on the record, with an exact step from row to row.
"""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from sim.numerics.elasto_plastic import Elements, force_along, smooth_element, sticking_fraction

Element = Callable[[int, float, float, float, float, Any], tuple[float, float]]
"""`law(k, z, v, direction, g, p) -> (rate, force)` of element k."""

Slopes = tuple[float, float, float, float, float, float]
"""`(rate_z, rate_v, rate_g, force_z, force_v, force_g)`."""

ElementSlopes = Callable[[int, float, float, float, float, Any], Slopes]
"""`slopes(k, z, v, direction, g, p)` of element k, exact."""

AlongRecord = Callable[[np.ndarray, np.ndarray, np.ndarray, np.ndarray, Any], np.ndarray]
"""`along_record(position, velocity, time, level, p) -> force`, all of shape (n,)."""


@dataclass(frozen=True)
class FrictionStateModel:
    """How the friction level becomes a force."""

    name: str  # of the model
    law: Element  # rate of one element's state and its share of the force, N. Zero level means no force
    slopes: ElementSlopes  # the exact partial derivatives of `law`
    along_record: AlongRecord  # the force along a measured motion, of shape (n,)
    # typical size of a state, to set the absolute tolerance of an integration; a function of `p`
    scale: Callable[[Any], float]
    state: str = "stretch of the bristles, m"  # meaning of the state, with its unit
    elements: Callable[[Any], int] = lambda p: 1  # how many states; a function of `p`
    # energy in the spring of element k, `stored(k, z, g, p)` in J, shaped as z and g; None where no energy function
    # exists
    stored: Callable[[int, Any, Any, Any], Any] | None = None
    # the parallel elasto-plastic elements that the model consists of, if it does; a function of `p`
    springs: Callable[[Any], Elements] | None = None
    # stretch, weight, damping and friction limit of each element, (elements, 4), for a model made by
    # `parallel_elements`; a function of `p`
    table: Callable[[Any], np.ndarray] | None = None
    # friction in steady sliding, N, `sliding(level, speed, p)`; the level itself where left out
    sliding: Callable[[np.ndarray, np.ndarray, Any], np.ndarray] | None = None
    # its `stretch` is below what a record resolves, so that friction at rest balances any force up to the level
    rigid: bool = False
    ages: bool = False  # the contacts age by the slip of its first element, not by the motion of the body
    free_shares: bool = False  # the shares of its elements in the level are parameters


def parallel_elements(
    name: str, elements: Callable[[Any], Elements], damping: Callable[[Any], float] | None = None
) -> FrictionStateModel:
    """A model of parallel elasto-plastic elements, a function of `p`: ideal along a record, yielding smoothly in a
    simulation; `damping`: dashpots in place of springs, N s/m all together."""

    def table(p: Any) -> np.ndarray:
        stretches, weights, force = elements(p)
        viscous = 0.0 if damping is None else damping(p)
        return np.column_stack(
            [stretches, weights, weights * viscous, np.full(weights.size, force if damping is None else 0.0)]
        )

    def terms(k: int, z: float, v: float, direction: float, g: float, p: Any) -> tuple[float, ...]:
        return smooth_element(z, v, direction, g, *table(p)[k].tolist())

    def along(position: np.ndarray, velocity: np.ndarray, time: np.ndarray, level: np.ndarray, p: Any) -> np.ndarray:
        if damping is None:
            return force_along(position, level, elements(p))
        return damping(p) * velocity * sticking_fraction(position, elements(p))

    def stored(k: int, z: Any, g: Any, p: Any) -> Any:
        return 0.5 * elements(p).stiffness[k] * z * z

    return FrictionStateModel(
        name,
        law=lambda *at: terms(*at)[:2],  # pyright: ignore[reportArgumentType]
        slopes=lambda *at: terms(*at)[2:],  # pyright: ignore[reportArgumentType]
        along_record=along,
        scale=lambda p: float(np.min(elements(p).stretches)),
        elements=lambda p: elements(p).stretches.size,
        stored=stored if damping is None else None,
        springs=elements if damping is None else None,
        table=table,
    )
