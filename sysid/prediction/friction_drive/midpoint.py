"""The stage that follows a tip through friction: one compiled pass over a record.

The implicit midpoint rule; in each step the balance at its middle

    m x'' + (bristles of the pads) + (friction of rigid pads) - (bristles of the contact) = push

is a piecewise linear function that rises with the displacement, solved exactly by Newton's method within a bracket.
Rigid pads hold wherever their level is enough to stop the stage by the end of the step: no spring stands for them,
which would give way by a part of what the contact does, and slips add that up. Second order in the step.
"""

from __future__ import annotations

import numpy as np

from sim.numerics.compilation import compiled
from sysid.prediction.friction_drive.event_driven_simulation import swinging_visibly

LONGEST_STEP = 5e-5
"""s: the record's step is divided until the stage on its contact, some hundred hertz, is resolved."""
MOST_STEPS = 50
"""Of a row, at the most."""
FINER = 8
"""Parts of a step in which rigid pads hold or let go."""


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
    finer: int = 1,
) -> np.ndarray:
    """Position (n,) of the stage from its rest at the first row, m.

    Args:
        tip: along the axis, m, (n,).
        push: other forces on the stage, N, (n,).
        contact_level: most that the contact holds, N, (n,); infinite where it never slips, 0 where the tip is off.
        contact_reach, contact_weights: stretch (m) and part of the level of each of its bristles; with one bristle or
            none, it is a spring of `contact_stiffness`, N/m, that holds up to the level.
        contact_damping: of the contact, N s/m, shared by its bristles, within what each holds.
        pad_level: most that the pads hold, N, (n,).
        pad_reach, pad_weights: stretch and part of the level of each of their bristles; rigid pads have none.
        mass: kg.
        step: of the record, s.
        finer: times more steps than `LONGEST_STEP` asks for.
    """
    stiffness = contact_stiffness
    if contact_weights.size > 1:
        stiffness = float(np.max(contact_level)) * float(np.sum(contact_weights / contact_reach))
    mass, contact_damping = swinging_visibly(stiffness, contact_damping, mass, step)
    substeps = finer * min(max(1, int(np.ceil(step / LONGEST_STEP))), MOST_STEPS)
    return _steps(
        tip, push, contact_level, contact_reach, contact_weights, contact_stiffness, contact_damping, pad_level,
        pad_reach, pad_weights, mass, step, substeps,
    )  # fmt: skip


@compiled
def _steps(
    tip, push, contact_level, contact_reach, contact_weights, contact_stiffness, contact_damping, pad_level, pad_reach,
    pad_weights, mass, step, substeps,
):  # fmt: skip
    """Positions of `follow` in so many `substeps` of each row."""
    n = tip.size
    out = np.zeros(n)
    springs = max(1, contact_weights.size)
    bristles = pad_weights.size
    held = np.zeros(springs)  # force of each contact bristle, N
    bent = np.zeros(bristles)  # stretch of each pad bristle, m
    per_reach = pad_weights / pad_reach
    slipping = np.zeros(springs)  # the way each contact bristle slips, zero while it sticks
    x, v = 0.0, 0.0
    side = 0.0  # the way the stage slides on rigid pads, zero while they hold
    stiff = np.zeros(springs)
    most = np.zeros(springs)
    for i in range(1, n):
        # Levels go straight from row to row; where one is infinite, or the tip off, the new row's holds at once.
        changes = 0.0 < contact_level[i] < np.inf and 0.0 < contact_level[i - 1] < np.inf
        done, parts, first = 0, substeps, True
        while done < parts:
            h = step / parts
            dtip = (tip[i] - tip[i - 1]) / parts
            lossy = contact_damping / springs / h
            inertia = 2.0 * mass / (h * h)
            part = (done + 0.5) / parts
            pushed = push[i - 1] + part * (push[i] - push[i - 1])
            level = contact_level[i]
            if changes:
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
            # First the displacement that stops the stage: rigid pads may hold it there. Else they hold their level.
            d = 0.5 * h * v
            rigid, after = 0.0, 0.0
            stopping = bristles == 0
            low, high = -1e300, 1e300
            if bristles > 0:
                d = h * v
            for _ in range(60):
                force = inertia * (d - h * v) - pushed + rigid
                slope = inertia
                # Displacements between which every pad bristle does as it does at this one.
                since, until = -1e300, 1e300
                for e in range(bristles):
                    back, ahead = -2.0 * (pad_reach[e] + bent[e]), 2.0 * (pad_reach[e] - bent[e])
                    if d > ahead:
                        force += pad * pad_weights[e]
                        since = max(since, ahead)
                    elif d < back:
                        force -= pad * pad_weights[e]
                        until = min(until, back)
                    else:
                        rate = pad * per_reach[e]
                        force += rate * (bent[e] + 0.5 * d)
                        slope += 0.5 * rate
                        since, until = max(since, back), min(until, ahead)
                for e in range(springs):
                    f = held[e] + (0.5 * stiff[e] + lossy) * (dtip - d)
                    if f > most[e]:
                        force -= most[e]
                        slipping[e] = 1.0
                    elif f < -most[e]:
                        force += most[e]
                        slipping[e] = -1.0
                    else:
                        force -= f
                        slope += 0.5 * stiff[e] + lossy
                        slipping[e] = 0.0
                if stopping:
                    if abs(force) <= pad:
                        break
                    stopping = False
                    after = 1.0 if force < 0.0 else -1.0
                    rigid = after * pad
                    force += rigid
                if force > 0.0:
                    high = min(high, d)
                else:
                    low = max(low, d)
                nearer = d - force / slope
                # The balance is a straight line as long as nothing sticks or slips that did not: its root is the root.
                near = since <= nearer <= until
                for e in range(springs):
                    f = held[e] + (0.5 * stiff[e] + lossy) * (dtip - nearer)
                    near = near and slipping[e] == (1.0 if f > most[e] else (-1.0 if f < -most[e] else 0.0))
                if not near and (nearer <= low or nearer >= high):
                    nearer = 0.5 * (low + high) if low > -1e299 and high < 1e299 else nearer
                near = near or abs(nearer - d) <= 1e-16 + 1e-12 * abs(d)
                d = nearer
                if near:
                    break
            if after != side and first:
                # Pads that hold or let go within a step: what it tells is of the first order only, so it is divided.
                done, parts, first = done * FINER, parts * FINER, False
                continue
            side = after
            for e in range(bristles):
                bent[e] = min(max(bent[e] + d, -pad_reach[e]), pad_reach[e])
            for e in range(springs):
                held[e] = min(max(held[e] + stiff[e] * (dtip - d), -most[e]), most[e])
            v = 2.0 * d / h - v
            x += d
            done += 1
            if not first and done % FINER == 0:
                done, parts, first = done // FINER, substeps, True
        out[i] = x
    return out
