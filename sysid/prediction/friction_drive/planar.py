"""The stage that follows a tip over a plane: contact and pads hold in the direction in which they are pulled.

    m x'' = T - P v/|v| + push,   |T| <= level   (vectors along and across; pads at rest hold up to P any way)

A guide (teeth, or nothing) pulls back across. Position Verlet at a fixed step: half a step on, the forces there, and
half a step more; friction takes away what speed it can, and no more. Second order between events.
"""

from __future__ import annotations

import numpy as np

from sim.numerics.compilation import compiled
from sysid.prediction.friction_drive.event_driven_simulation import swinging_visibly

LONGEST_PHASE = 0.06
"""rad of the stage's oscillation on its contact in one step: its phase is then off by some 1e-4 of itself."""


def follow_plane(
    along: np.ndarray,
    across: np.ndarray,
    push: np.ndarray,
    load: np.ndarray,
    level: np.ndarray,
    stiffness: float,
    damping: float,
    pads: np.ndarray,
    viscous: float,
    guide: float,
    mass: float,
    step: float,
    finer: int = 1,
) -> tuple[np.ndarray, np.ndarray]:
    """Position (n,) of the stage along and across, from its rest at the first row, m.

    Where rows are so far apart that the stage swings more than five times between two, a heavier one is followed.

    Args:
        along, across: motion of the tip, m, (n,).
        push: other forces along the axis, N, (n,).
        load: of the contact over its mean, (n,); the tip touches where it is above zero.
        level: most that the contact holds while it touches, N, (n,); infinite where it never slips.
        stiffness, damping: of the contact, any way, N/m and N s/m.
        pads: friction of the pads, N, (n,).
        viscous: of the pads, across, N s/m.
        guide: stiffness across, N/m.
        mass: kg.
        step: of the record, s.
        finer: times more steps than a phase of `LONGEST_PHASE` asks for.
    """
    mass, damping = swinging_visibly(stiffness + guide, damping, mass, step)
    parts = finer * max(1, int(np.ceil(np.sqrt((stiffness + guide) / mass) * step / LONGEST_PHASE)))
    return _steps(
        along, across, push, load, level, stiffness, damping, pads, viscous, guide, mass, step, parts
    )  # fmt: skip


@compiled
def _steps(
    along, across, push, load, level, stiffness, damping, pads, viscous, guide, mass, step, parts
):  # fmt: skip
    """Positions of `follow_plane` in so many `parts` of each row."""
    n = along.size
    out_x, out_y = np.zeros(n), np.zeros(n)
    h = step / parts
    x, y, vx, vy = 0.0, 0.0, 0.0, 0.0
    qx, qy = 0.0, 0.0
    for i in range(1, n):
        ux, uy = (along[i] - along[i - 1]) / step, (across[i] - across[i - 1]) / step
        finite = level[i] < np.inf and level[i - 1] < np.inf
        for part in range(parts):
            share = (part + 0.5) / parts
            touches = load[i - 1] + share * (load[i] - load[i - 1]) > 0.0
            most = level[i - 1] + share * (level[i] - level[i - 1]) if finite else np.inf
            pad = pads[i - 1] + share * (pads[i] - pads[i - 1])
            wx, wy = ux - vx, uy - vy
            tx, ty = 0.0, 0.0
            if touches:
                qx += 0.5 * h * stiffness * wx
                qy += 0.5 * h * stiffness * wy
                tx, ty = qx + damping * wx, qy + damping * wy
                size = np.sqrt(tx * tx + ty * ty)
                if size > most:
                    tx, ty = tx * most / size, ty * most / size
            else:
                qx, qy = 0.0, 0.0
            # Halfway through the step: forces there, then friction.
            fx = tx + push[i]
            fy = ty - guide * (y + 0.5 * h * vy) - viscous * vy
            free_x, free_y = vx + h / mass * fx, vy + h / mass * fy
            speed = np.sqrt(free_x * free_x + free_y * free_y)
            lost = h * pad / mass
            kept = (speed - lost) / speed if speed > lost else 0.0
            new_x, new_y = free_x * kept, free_y * kept
            x += 0.5 * h * (vx + new_x)
            y += 0.5 * h * (vy + new_y)
            vx, vy = new_x, new_y
            if touches:
                qx += 0.5 * h * stiffness * (ux - vx)
                qy += 0.5 * h * stiffness * (uy - vy)
                size = np.sqrt(qx * qx + qy * qy)
                if size > most:
                    qx, qy = qx * most / size, qy * most / size
        out_x[i], out_y[i] = x, y
    return out_x, out_y
