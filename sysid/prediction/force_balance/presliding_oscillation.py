"""Friction of a driven mass while bristles bring it to rest and let it go again, from its own balance of momentum.

The position's noise hides how far the bristles give; the force does not need it. From the instant at which the mass
stops, all bristles stretched one way, m x'' = push - friction(x) is followed in small steps, the bristles being ideal
springs side by side that each yield at a stretch of their own (Iwan 1966). The mass swings on them, and slips when all
have yielded.
"""

from __future__ import annotations

import numpy as np

from sim.numerics.compilation import SUMS_IN_ANY_ORDER, compiled

FINEST = 64
"""Most parts of a step in which the mass on its bristles is followed."""

PHASE = 0.35
"""Phase of the fastest swing, in radians, that one part may take."""


def parts_of_a_step(level: float, stretches: np.ndarray, weights: np.ndarray, scale: float) -> int:
    """How many parts of a step the swing on the bristles needs; 0 where even the most are too few.

    Args:
        level: friction level, N.
        stretches, weights: of the bristles, m and parts of the level, (k,).
        scale: step^2 / mass: displacement in m that one N makes of a body in one sample squared.
    """
    phase = float(np.sqrt(max(level, 0.0) * np.sum(weights / np.maximum(stretches, 1e-300)) * scale))
    if phase > FINEST:
        return 0
    return int(min(FINEST, max(3, np.ceil(phase / PHASE))))


@compiled(fastmath=SUMS_IN_ANY_ORDER)
def bristled_friction(
    out: np.ndarray,
    direction: np.ndarray,
    position: np.ndarray,
    times: np.ndarray,
    heading: np.ndarray,
    push: np.ndarray,
    level: np.ndarray,
    stretches: np.ndarray,
    weights: np.ndarray,
    scale: float,
    parts: int,
    seen: float,
) -> None:
    """Write the friction between each stop and the next slip into `out` (n,), which has it as of rigid contact.

    Args:
        out: friction, N, mean over the step around each sample, (n,).
        direction: mean sign of the motion over each step, 0 at rest, (n,).
        position: smoothed, m, (n,).
        times: of the stops, in samples, ascending, (k,).
        heading: direction of the motion that each ends, (k,).
        push: applied force less what is not friction, N, (n,).
        level: friction level, N, (n,).
        stretches, weights: of the bristles, m and parts of the level, (b,).
        scale: step^2 / mass.
        parts: of a step in which the motion is followed.
        seen: displacement, m, by which the position shows that the mass slips whatever the balance says.
    """
    n, bristles = out.size, stretches.size
    z, stiffness = np.empty(bristles), weights / stretches
    for k in range(times.size):
        i = int(np.floor(times[k] + 0.5))
        if i < 1 or i >= n - 1:
            continue
        z[:] = heading[k] * stretches
        ratio = heading[k] * np.sum(weights)
        before = times[k] - (i - 0.5)
        until = int(np.floor(times[k + 1] + 0.5)) if k + 1 < times.size else n - 1
        v, left = 0.0, position[i]
        first = True
        while i < min(until, n - 1):
            share = 1.0 - before if first else 1.0
            pause, total = share / parts, 0.0
            for j in range(parts):
                at = (before if first else 0.0) + (j + 0.5) * pause - 0.5
                now = push[i] + at * (push[i + 1] - push[i] if at > 0.0 else push[i] - push[i - 1])
                force = level[i] * ratio
                v += (now - force) * scale * pause
                moved = v * pause
                ratio = 0.0
                for b in range(bristles):
                    z[b] = min(max(z[b] + moved, -stretches[b]), stretches[b])
                    ratio += stiffness[b] * z[b]
                total += force / parts
            out[i] = share * total + (before * heading[k] * level[i] if first else 0.0)
            first = False
            i += 1
            # Under way: by the balance and by the position, or by the position alone, clearly.
            if abs(direction[i]) > 0.999:
                slips = v * direction[i] > 0.0
                for b in range(bristles):
                    slips &= abs(z[b]) == stretches[b]
                if slips or abs(position[i] - left) > seen:
                    break
