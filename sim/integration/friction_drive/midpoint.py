"""Simulation of a driven stage with bristles along one axis by the implicit midpoint rule.

In each step the force balance at its middle

    m x'' + (bristles of the pads) + (friction of rigid pads) - (bristles of the contact) = push

is a piecewise linear, increasing function of the displacement, solved exactly by Newton's method within a bracket.
Rigid pads hold the stage wherever their limit suffices to stop it by the end of the step: a spring in their place
would yield by a part of what the contact does, and slips would accumulate that. Second order in the step.
"""

from typing import NamedTuple

import numpy as np

from sim.integration.friction_drive.inputs import DrivenStage, resolved_stage
from sim.numerics.compilation import compiled, inlined
from sim.numerics.elasto_plastic import Elements, Springs, displace, mean_force, slips_alike, springs_of

LONGEST_STEP = 5e-5
"""s: the record's step is divided until the stage on its contact, some hundred hertz, is resolved."""
MOST_STEPS = 50
"""Steps in a row, at the most."""
REFINEMENT = 8
"""Parts of a step in which rigid pads stick or break away: there the rule is of first order only."""


class Bristles(NamedTuple):
    """Parallel elasto-plastic elements of a contact."""

    limit: np.ndarray  # friction limit of all together, N, (n,); infinite where it never slips, 0 where nothing touches
    elements: Elements  # their stretches and parts of the limit


NO_BRISTLES = Elements(np.empty(0), np.empty(0))


class Inputs(NamedTuple):
    """Position of the tip, m, push, and friction limits of contact and pads, N, each (n,)."""

    tip: np.ndarray
    push: np.ndarray
    contact_limit: np.ndarray
    pads_limit: np.ndarray


class Step(NamedTuple):
    """One step."""

    length: float  # s
    tip: float  # displacement of the tip, m
    velocity: float  # of the stage at the start, m/s
    mass: float  # kg
    push: float  # at the middle, N
    # pad_limit, limit: friction limits of the pads and of the contact at the middle, N
    pad_limit: float
    limit: float
    loss: float  # dashpot over the length, N/m, of each spring of the contact


def simulate_midpoint(
    tip: np.ndarray, push: np.ndarray, contact: Bristles, pads: Bristles, stage: DrivenStage, refinement: int = 1
) -> np.ndarray:
    """Position (n,) of the stage from rest at the first row, m, under a tip along the axis (n,), m, and other forces
    (n,), N, in `refinement` times more steps than `LONGEST_STEP` requires.

    A contact with one bristle or none is the spring of the stage, up to its limit; its bristles share the dashpot,
    within the limit of each. Pads are rigid without bristles.
    """
    one = Elements(np.ones(1), np.ones(1), stage.stiffness)
    springs = springs_of(contact.elements if contact.elements.weights.size > 1 else one)
    resolved = resolved_stage(stage._replace(stiffness=float(np.sum(springs.stiffness))))
    # A multiple of the longest step is not divided once more because of round-off.
    substeps = refinement * min(max(1, int(np.ceil(stage.step / LONGEST_STEP - 1e-6))), MOST_STEPS)
    pad_springs = springs_of(pads.elements)
    return _simulate(Inputs(tip, push, contact.limit, pads.limit), springs, pad_springs, resolved, substeps)


@inlined
def _displacement(step: Step, contact: Springs, pads: Springs) -> tuple[float, float]:
    """Displacement, m, in a step, and the direction in which the stage slides on rigid pads, 0 where they hold it."""
    inertia = 2.0 * step.mass / (step.length * step.length)
    free = step.length * step.velocity
    # First the displacement that stops the stage: rigid pads may hold it there, or else resist with their limit.
    stopping = pads.force.size == 0
    d = 0.5 * free if stopping else free
    rigid, side = 0.0, 0.0
    low, high = -1e300, 1e300
    for _ in range(60):
        pad, pad_slope = mean_force(pads, 0.0, d, step.pad_limit)
        driven, contact_slope = mean_force(contact, step.loss, step.tip - d, step.limit)
        force = inertia * (d - free) - step.push + rigid + pad - driven
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
        before = d
        d -= force / (inertia + pad_slope + contact_slope)
        # The balance is linear as long as the same bristles slip: then this is its exact root.
        alike = slips_alike(pads, 0.0, before, d, step.pad_limit)
        if alike and slips_alike(contact, step.loss, step.tip - before, step.tip - d, step.limit):
            break
        if not low <= d <= high and low > -1e299 and high < 1e299:
            d = 0.5 * (low + high)
        if abs(d - before) <= 1e-16 + 1e-12 * abs(d):
            break
    return d, side


@compiled
def _simulate(inputs: Inputs, springs: Springs, pad_springs: Springs, stage: DrivenStage, substeps: int) -> np.ndarray:
    """Positions (n,) of `simulate_midpoint` in so many `substeps` of each row."""
    tip, push, contact_limit, pads_limit = inputs
    out, dashpot = np.zeros(tip.size), stage.damping / springs.force.size
    x, v, side = 0.0, 0.0, 0.0
    for i in range(1, out.size):
        # Limits are linear from row to row; where one is infinite, or the tip off, the new row's applies immediately.
        changes = 0.0 < contact_limit[i] < np.inf and 0.0 < contact_limit[i - 1] < np.inf
        done, parts, coarse = 0, substeps, True
        while done < parts:
            h, part = stage.step / parts, (done + 0.5) / parts
            limit = contact_limit[i]
            if changes:
                limit = contact_limit[i - 1] + part * (limit - contact_limit[i - 1])
            pad_limit = pads_limit[i - 1] + part * (pads_limit[i] - pads_limit[i - 1])
            pushed = push[i - 1] + part * (push[i] - push[i - 1])
            # What exceeds a limit that has fallen slips at once.
            displace(springs, 0.0, limit)
            displace(pad_springs, 0.0, pad_limit)
            step = Step(h, (tip[i] - tip[i - 1]) / parts, v, stage.mass, pushed, pad_limit, limit, dashpot / h)
            d, after = _displacement(step, springs, pad_springs)
            if after != side and coarse:
                done, parts, coarse = done * REFINEMENT, parts * REFINEMENT, False
                continue
            side = after
            displace(pad_springs, d, pad_limit)
            displace(springs, step.tip - d, limit)
            v = 2.0 * d / h - v
            x += d
            done += 1
            if not coarse and done % REFINEMENT == 0:
                done, parts, coarse = done // REFINEMENT, substeps, True
        out[i] = x
    return out
