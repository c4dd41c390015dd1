"""The stage that follows a tip where pads and contact only stick or slip: from event to event.

Pads hold up to their level, the contact is a spring and a dashpot that hold up to theirs. Between two events the
stage is an oscillator on the contact, a body under friction, or at rest; each is solved in closed form while the tip,
the levels and the other forces go straight from row to row, and by Runge and Kutta's method of order four, its steps a
fifth of a radian, where friction goes by the speed. What is found depends smoothly on every number.
"""

from __future__ import annotations

import numpy as np

from sysid.prediction.friction_drive.velocity_tables import NO_CURVES, Curves

LONGEST_PHASE = 0.6
"""rad of the stage's oscillation on its contact between two looks for events."""

MOST_PHASE = 30.0
"""rad of that oscillation in a row, at the most: of one still quicker, rows show nothing but that it rests."""


def looks(stiffness: float, mass: float, step: float) -> int:
    """How often in a row events are looked for."""
    return max(1, int(np.ceil(np.sqrt(stiffness / mass) * step / LONGEST_PHASE)))


def swinging_visibly(stiffness: float, damping: float, mass: float, step: float) -> tuple[float, float]:
    """Mass (kg) and dashpot (N s/m) with which a stage on a `stiffness` (N/m) is followed from row to row.

    A slow record would be followed through swings that have long died away when the next row comes. A stage so much
    heavier, damped as much, swings five times a row in their place; what it lags behind is 1 % at the highest frequency
    that rows can show, and falls with the square of it.
    """
    heavier = max(np.sqrt(stiffness / mass) * step / MOST_PHASE, 1.0) ** 2
    return heavier * mass, np.sqrt(heavier) * damping


def follow_exactly(
    tip: np.ndarray,
    push: np.ndarray,
    load: np.ndarray,
    level: np.ndarray,
    stiffness: float,
    damping: float,
    pads: np.ndarray,
    mass: float,
    step: float,
    contact_curves: Curves = NO_CURVES,
    contact_share: np.ndarray | None = None,
    pad_curves: Curves = NO_CURVES,
    pad_share: np.ndarray | None = None,
    seen: np.ndarray | None = None,
    nudging_gain: float = 0.0,
) -> np.ndarray:
    """Position (n,) of the stage from its rest at the first row, m.

    Args:
        tip: along the axis, m, (n,).
        push: other forces on the stage, N, (n,).
        load: of the contact over its mean, (n,); the tip touches where it is above zero.
        level: most that the contact holds while it touches, N, (n,); infinite where it never slips.
        stiffness, damping: of the contact, N/m and N s/m.
        pads: friction of the pads, N, (n,).
        mass: kg.
        step: of the record, s.
        contact_curves, pad_curves: how either friction goes by the speed.
        contact_share, pad_share: by what the extra levels of the curves are multiplied, (n,); one where left out.
        seen: where the stage was seen, m from its rest, (n,).
        nudging_gain: part of the way to `seen` that the stage is brought after every row, its speed along with it as an
            alpha-beta filter does (Kalata, IEEE Trans. AES-20 (1984) 174); zero for a stage that is on its own.
    """
    from sysid.prediction.friction_drive.event_driven import follow_events

    one = np.ones(tip.size)
    mass, damping = swinging_visibly(stiffness, damping, mass, step)
    return follow_events(
        tip, push, load, level, stiffness, damping, pads, mass, step, looks(stiffness, mass, step),
        one if contact_share is None else contact_share, contact_curves.values, contact_curves.top,
        one if pad_share is None else pad_share, pad_curves.values, pad_curves.top,
        one if seen is None else seen, nudging_gain, nudging_gain * nudging_gain / (2.0 - nudging_gain),
    )  # fmt: skip
