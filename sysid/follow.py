"""The stage that follows a tip through friction: one compiled pass over a record.

Newmark's method with slight damping of what the step does not resolve; in each step the balance

    m x'' + (bristles of the pads) - (bristles of the contact) = push

is a piecewise linear function that rises with the displacement, solved exactly by Newton's method within a bracket.
"""

from __future__ import annotations

import numpy as np

from sim.compilation import compiled


@compiled
def follow(
    tip: np.ndarray,
    push: np.ndarray,
    contact_level: np.ndarray,
    contact_reach: np.ndarray,
    contact_weights: np.ndarray,
    contact_stiffness: float,
    contact_damping: float,
    pad_level: np.ndarray,
    pad_reach: np.ndarray,
    pad_weights: np.ndarray,
    mass: float,
    step: float,
    substeps: int,
) -> np.ndarray:
    """Position (n,) of the stage from its rest at the first row, m.

    Args:
        tip: along the axis, m, (n,).
        push: other forces on the stage, N, (n,).
        contact_level: most that the contact holds, N, (n,); infinite where it never slips, 0 where the tip is off.
        contact_reach, contact_weights: stretch (m) and part of the level of each of its bristles; with one bristle or
            none, it is a spring of `contact_stiffness`, N/m, that holds up to the level.
        contact_damping: of the contact, N s/m, shared by its bristles, within what each holds.
        pad_level, pad_reach, pad_weights: of the pads, as of the contact.
        mass: kg.
        step: of the record, s; substeps: in each.
    """
    n = tip.size
    out = np.zeros(n)
    springs = max(1, contact_weights.size)
    bristles = pad_weights.size
    held = np.zeros(springs)  # force of each contact bristle, N
    bent = np.zeros(bristles)  # of each pad bristle, part of its share of the level
    gamma = 0.6
    beta = 0.25 * (gamma + 0.5) ** 2
    h = step / substeps
    lossy = contact_damping / springs / h
    x, v, a = 0.0, 0.0, 0.0
    stiff = np.zeros(springs)
    most = np.zeros(springs)
    for i in range(1, n):
        dtip = (tip[i] - tip[i - 1]) / substeps
        for s in range(substeps):
            # Levels go straight from row to row; where one is infinite, or the tip off, the new row's holds at once.
            part = (s + 1.0) / substeps
            level = contact_level[i]
            pushed = push[i - 1] + part * (push[i] - push[i - 1])
            if part < 1.0 and 0.0 < level < np.inf and 0.0 < contact_level[i - 1] < np.inf:
                level = contact_level[i - 1] + part * (level - contact_level[i - 1])
            pad = pad_level[i - 1] + part * (pad_level[i] - pad_level[i - 1])
            for e in range(springs):
                if contact_weights.size > 1:
                    # Bristles that yield at stretches of their own keep their stretch when the level changes.
                    cap = level * contact_weights[e]
                    held[e] = held[e] * cap / most[e] if most[e] > 0.0 else 0.0
                    stiff[e], most[e] = cap / contact_reach[e], cap
                else:
                    stiff[e], most[e] = contact_stiffness if level > 0.0 else 0.0, level
                held[e] = min(max(held[e], -most[e]), most[e])
            # Newmark: x'' at the end of the step is (d - known)/(beta h^2) for a displacement d.
            known = h * v + h * h * (0.5 - beta) * a
            inertia = mass / (beta * h * h)
            d = known
            low, high = -1e300, 1e300
            for _ in range(60):
                force = inertia * (d - known) - pushed
                slope = inertia
                for e in range(bristles):
                    cap = pad * pad_weights[e]
                    u = bent[e] + d / pad_reach[e]
                    if u > 1.0:
                        force += cap
                    elif u < -1.0:
                        force -= cap
                    else:
                        force += cap * u
                        slope += cap / pad_reach[e]
                for e in range(springs):
                    f = held[e] + (stiff[e] + lossy) * (dtip - d)
                    if f > most[e]:
                        force -= most[e]
                    elif f < -most[e]:
                        force += most[e]
                    else:
                        force -= f
                        slope += stiff[e] + lossy
                if force > 0.0:
                    high = min(high, d)
                else:
                    low = max(low, d)
                change = force / slope
                nearer = d - change
                if nearer <= low or nearer >= high:
                    nearer = 0.5 * (low + high) if low > -1e299 and high < 1e299 else nearer
                done = abs(nearer - d) <= 1e-16 + 1e-12 * abs(d)
                d = nearer
                if done:
                    break
            for e in range(bristles):
                bent[e] = min(max(bent[e] + d / pad_reach[e], -1.0), 1.0)
            for e in range(springs):
                held[e] = min(max(held[e] + stiff[e] * (dtip - d), -most[e]), most[e])
            after = (d - known) / (beta * h * h)
            v += h * ((1.0 - gamma) * a + gamma * after)
            a = after
            x += d
        out[i] = x
    return out
