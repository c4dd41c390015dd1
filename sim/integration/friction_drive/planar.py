"""Simulation of a driven stage in the plane: friction of contact and pads acts along the direction of pull or motion.

    m x'' = T - P v/|v| + push,   |T| <= limit   (vectors along and across; pads at rest hold up to P in any direction)

A guide (teeth, or nothing) pulls back across. Position Verlet at a fixed step: half a step, the forces there, and half
a step; friction reduces the speed, at most to zero. Second order between events.
"""

from typing import NamedTuple

import numpy as np

from sim.integration.friction_drive.inputs import DrivenStage, resolved_stage
from sim.numerics.compilation import compiled, inlined

LONGEST_PHASE = 0.06
"""rad of the oscillation on the contact in one step: its phase is then off by some 1e-4 of itself."""


class PlanarTipMotion(NamedTuple):
    """Motion of the tip along and across, m, and load of the contact over its mean, each (n,); it touches above 0."""

    along: np.ndarray
    across: np.ndarray
    load: np.ndarray


class Guide(NamedTuple):
    """Stiffness, N/m, and viscous damping, N s/m, of the stage across the travel."""

    stiffness: float = 0.0
    damping: float = 0.0


def simulate_planar(
    tip: PlanarTipMotion,
    push: np.ndarray,  # other forces along the axis, N, (n,)
    contact_limit: np.ndarray,  # friction limit of the contact while it touches, N, (n,); infinite where it never slips
    pad_limit: np.ndarray,  # friction of the pads, N, (n,)
    stage: DrivenStage,  # its contact has the same stiffness and damping in any direction
    guide: Guide,
    refinement: int = 1,  # times more steps than `LONGEST_PHASE` requires
) -> tuple[np.ndarray, np.ndarray]:
    """Position (n,) of the stage along and across, from rest at the first row, m."""
    stage = resolved_stage(stage, guide.stiffness)
    frequency = np.sqrt((stage.stiffness + guide.stiffness) / stage.mass)
    parts = refinement * max(1, int(np.ceil(frequency * stage.step / LONGEST_PHASE)))
    return _simulate(tip, push, contact_limit, pad_limit, stage, guide, parts)


@inlined
def _cut(x: float, y: float, limit: float) -> tuple[float, float]:
    """A vector cut at a length."""
    size = np.sqrt(x * x + y * y)
    return (x * limit / size, y * limit / size) if size > limit else (x, y)


@compiled
def _simulate(
    tip: PlanarTipMotion,
    push: np.ndarray,
    contact_limit: np.ndarray,
    pad_limit: np.ndarray,
    stage: DrivenStage,
    guide: Guide,
    parts: int,
) -> tuple[np.ndarray, np.ndarray]:
    """Positions of `simulate_planar` in so many `parts` of each row."""
    n, k, c, mass = push.size, stage.stiffness, stage.damping, stage.mass
    out_x, out_y = np.zeros(n), np.zeros(n)
    h = stage.step / parts
    x, y, vx, vy = 0.0, 0.0, 0.0, 0.0
    qx, qy = 0.0, 0.0
    for i in range(1, n):
        ux, uy = (tip.along[i] - tip.along[i - 1]) / stage.step, (tip.across[i] - tip.across[i - 1]) / stage.step
        finite = contact_limit[i] < np.inf and contact_limit[i - 1] < np.inf
        for part in range(parts):
            share = (part + 0.5) / parts
            touches = tip.load[i - 1] + share * (tip.load[i] - tip.load[i - 1]) > 0.0
            limit = contact_limit[i - 1] + share * (contact_limit[i] - contact_limit[i - 1]) if finite else np.inf
            pad = pad_limit[i - 1] + share * (pad_limit[i] - pad_limit[i - 1])
            wx, wy = ux - vx, uy - vy
            tx, ty = 0.0, 0.0
            if touches:
                qx += 0.5 * h * k * wx
                qy += 0.5 * h * k * wy
                tx, ty = _cut(qx + c * wx, qy + c * wy, limit)
            else:
                qx, qy = 0.0, 0.0
            # Halfway through the step: forces there, then friction.
            fx = tx + push[i]
            fy = ty - guide.stiffness * (y + 0.5 * h * vy) - guide.damping * vy
            free_x, free_y = vx + h / mass * fx, vy + h / mass * fy
            speed = np.sqrt(free_x * free_x + free_y * free_y)
            lost = h * pad / mass
            kept = (speed - lost) / speed if speed > lost else 0.0
            new_x, new_y = free_x * kept, free_y * kept
            x += 0.5 * h * (vx + new_x)
            y += 0.5 * h * (vy + new_y)
            vx, vy = new_x, new_y
            if touches:
                qx, qy = _cut(qx + 0.5 * h * k * (ux - vx), qy + 0.5 * h * k * (uy - vy), limit)
        out_x[i], out_y[i] = x, y
    return out_x, out_y
