"""Simulation of a driven stage with bristles along one axis by the implicit midpoint rule.

In each step the force balance at its middle

    m x'' + (bristles of the pads) + (friction of rigid pads) - (bristles of the contact) = push

is a piecewise linear, increasing function of the displacement, solved exactly by Newton's method within a bracket.
Rigid pads hold the stage wherever their limit suffices to stop it by the end of the step: a spring in their place
would yield by a part of what the contact does, and slips would accumulate that. Second order in the step.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from sim.integration.driven_stage.inputs import DrivenStage, resolved_stage
from sim.numerics.compilation import compiled, inlined

LONGEST_STEP = 5e-5
"""s: the record's step is divided until the stage on its contact, some hundred hertz, is resolved."""
MOST_STEPS = 50
"""Steps in a row, at the most."""
REFINEMENT = 8
"""Parts of a step in which rigid pads stick or break away: there the rule is of first order only."""


class Bristles(NamedTuple):
    """Parallel elasto-plastic springs (Iwan elements) of a contact.

    Args:
        limit: friction limit of all together, N, (n,); infinite where it never slips, 0 where nothing touches.
        stretches: at which each yields, m, (b,).
        weights: part of the limit that each carries, (b,).
    """

    limit: np.ndarray
    stretches: np.ndarray
    weights: np.ndarray


NO_BRISTLES = np.empty(0)


class Step(NamedTuple):
    """One step: length, s, displacement of the tip, m, initial velocity, m/s, push and pad limit, N, and dashpot over
    the length, N/m, per bristle of the contact."""

    length: float
    tip: float
    velocity: float
    mass: float
    push: float
    pad_limit: float
    lossy: float


class Contact(NamedTuple):
    """Force, N, stiffness, N/m, and limit, N, of each bristle of the contact, and its direction of slip, each (b,)."""

    force: np.ndarray
    stiffness: np.ndarray
    limit: np.ndarray
    slip_side: np.ndarray


def simulate_midpoint(
    tip: np.ndarray,
    push: np.ndarray,
    contact: Bristles,
    pads: Bristles,
    stage: DrivenStage,
    refinement: int = 1,
) -> np.ndarray:
    """Position (n,) of the stage from rest at the first row, m.

    Args:
        tip: along the axis, m, (n,).
        push: other forces on the stage, N, (n,).
        contact: with one bristle or none it is the spring of the stage, up to its limit. Its bristles share the
            dashpot, within the limit of each.
        pads: rigid without bristles.
        stage: contact stiffness and damping, mass and sampling time.
        refinement: times more steps than `LONGEST_STEP` requires.
    """
    stiffness = stage.stiffness
    if contact.weights.size > 1:
        stiffness = float(np.max(contact.limit)) * float(np.sum(contact.weights / contact.stretches))
    resolved = resolved_stage(stage._replace(stiffness=stiffness))._replace(stiffness=stage.stiffness)
    substeps = refinement * min(max(1, int(np.ceil(stage.step / LONGEST_STEP))), MOST_STEPS)
    return _simulate(tip, push, contact, pads, resolved, substeps)


@inlined
def _scaled(contact: Contact, bristles: Bristles, stiffness: float, limit: float) -> None:
    """Stiffness, limit and force of the contact's bristles at a friction limit, N, written in place."""
    for e in range(contact.force.size):
        if bristles.weights.size > 1:
            # Elements that yield at an individual stretch keep their stretch when the limit changes.
            cap = limit * bristles.weights[e]
            contact.force[e] = contact.force[e] * cap / contact.limit[e] if contact.limit[e] > 0.0 else 0.0
            contact.stiffness[e], contact.limit[e] = cap / bristles.stretches[e], cap
        else:
            contact.stiffness[e], contact.limit[e] = stiffness if limit > 0.0 else 0.0, limit
        contact.force[e] = min(max(contact.force[e], -contact.limit[e]), contact.limit[e])


@inlined
def _pad_force(pads: Bristles, stretch: np.ndarray, limit: float, d: float) -> tuple[float, float, float, float]:
    """Mean force of the pads' bristles over a displacement d, N, its slope, and the range of d of the same regime."""
    force, slope, since, until = 0.0, 0.0, -1e300, 1e300
    for e in range(stretch.size):
        back, ahead = -2.0 * (pads.stretches[e] + stretch[e]), 2.0 * (pads.stretches[e] - stretch[e])
        if d > ahead:
            force += limit * pads.weights[e]
            since = max(since, ahead)
        elif d < back:
            force -= limit * pads.weights[e]
            until = min(until, back)
        else:
            rate = limit * (pads.weights[e] / pads.stretches[e])
            force += rate * (stretch[e] + 0.5 * d)
            slope += 0.5 * rate
            since, until = max(since, back), min(until, ahead)
    return force, slope, since, until


@inlined
def _contact_force(contact: Contact, step: Step, d: float) -> tuple[float, float]:
    """Mean force of the contact's bristles over a displacement d, N, and its slope; writes which of them slip."""
    force, slope = 0.0, 0.0
    for e in range(contact.force.size):
        rate = 0.5 * contact.stiffness[e] + step.lossy
        f = contact.force[e] + rate * (step.tip - d)
        if f > contact.limit[e]:
            force += contact.limit[e]
            contact.slip_side[e] = 1.0
        elif f < -contact.limit[e]:
            force -= contact.limit[e]
            contact.slip_side[e] = -1.0
        else:
            force += f
            slope += rate
            contact.slip_side[e] = 0.0
    return force, slope


@inlined
def _same_slip(contact: Contact, step: Step, d: float) -> bool:
    """Whether the same bristles of the contact slip at a displacement d."""
    same = True
    for e in range(contact.force.size):
        f = contact.force[e] + (0.5 * contact.stiffness[e] + step.lossy) * (step.tip - d)
        side = 1.0 if f > contact.limit[e] else (-1.0 if f < -contact.limit[e] else 0.0)
        same = same and contact.slip_side[e] == side
    return same


@inlined
def _displacement(step: Step, contact: Contact, pads: Bristles, stretch: np.ndarray) -> tuple[float, float]:
    """Displacement, m, in a step, and the direction in which the stage slides on rigid pads, 0 where they hold it."""
    inertia = 2.0 * step.mass / (step.length * step.length)
    free = step.length * step.velocity
    # First the displacement that stops the stage: rigid pads may hold it there, or else resist with their limit.
    stopping = stretch.size == 0
    d = 0.5 * free if stopping else free
    rigid, side = 0.0, 0.0
    low, high = -1e300, 1e300
    for _ in range(60):
        pad, pad_slope, since, until = _pad_force(pads, stretch, step.pad_limit, d)
        driven, contact_slope = _contact_force(contact, step, d)
        force = inertia * (d - free) - step.push + rigid + pad - driven
        slope = inertia + pad_slope + contact_slope
        if stopping:
            if abs(force) <= step.pad_limit:
                break
            stopping = False
            side = 1.0 if force < 0.0 else -1.0
            rigid = side * step.pad_limit
            force += rigid
        if force > 0.0:
            high = min(high, d)
        else:
            low = max(low, d)
        nearer = d - force / slope
        # The balance is linear as long as the same bristles stick and slip: then its root is exact.
        near = since <= nearer <= until and _same_slip(contact, step, nearer)
        if not near and (nearer <= low or nearer >= high):
            nearer = 0.5 * (low + high) if low > -1e299 and high < 1e299 else nearer
        near = near or abs(nearer - d) <= 1e-16 + 1e-12 * abs(d)
        d = nearer
        if near:
            break
    return d, side


@compiled
def _simulate(
    tip: np.ndarray, push: np.ndarray, contact: Bristles, pads: Bristles, stage: DrivenStage, substeps: int
) -> np.ndarray:
    """Positions (n,) of `simulate_midpoint` in so many `substeps` of each row."""
    out, count = np.zeros(tip.size), max(1, contact.weights.size)
    springs = Contact(np.zeros(count), np.zeros(count), np.zeros(count), np.zeros(count))
    stretch = np.zeros(pads.weights.size)  # stretch of each pad bristle, m
    x, v, side = 0.0, 0.0, 0.0
    for i in range(1, out.size):
        # Limits are linear from row to row; where one is infinite, or the tip off, the new row's applies immediately.
        changes = 0.0 < contact.limit[i] < np.inf and 0.0 < contact.limit[i - 1] < np.inf
        done, parts, coarse = 0, substeps, True
        while done < parts:
            h, part = stage.step / parts, (done + 0.5) / parts
            limit = contact.limit[i]
            if changes:
                limit = contact.limit[i - 1] + part * (limit - contact.limit[i - 1])
            pad_limit = pads.limit[i - 1] + part * (pads.limit[i] - pads.limit[i - 1])
            pushed = push[i - 1] + part * (push[i] - push[i - 1])
            step = Step(h, (tip[i] - tip[i - 1]) / parts, v, stage.mass, pushed, pad_limit, stage.damping / count / h)
            _scaled(springs, contact, stage.stiffness, limit)
            d, after = _displacement(step, springs, pads, stretch)
            if after != side and coarse:
                done, parts, coarse = done * REFINEMENT, parts * REFINEMENT, False
                continue
            side = after
            for e in range(stretch.size):
                stretch[e] = min(max(stretch[e] + d, -pads.stretches[e]), pads.stretches[e])
            for e in range(count):
                force = springs.force[e] + springs.stiffness[e] * (step.tip - d)
                springs.force[e] = min(max(force, -springs.limit[e]), springs.limit[e])
            v = 2.0 * d / h - v
            x += d
            done += 1
            if not coarse and done % REFINEMENT == 0:
                done, parts, coarse = done // REFINEMENT, substeps, True
        out[i] = x
    return out
