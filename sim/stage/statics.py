"""Static equilibrium of the stage on its pads and tips.

The elastic energy of pads and tips in heave and the two turns is convex, so rest is its minimum, found by Newton's
method with halving. There is no friction force at rest: the stage is set down without shear.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from sim.stage.machine import StageMachine
from stagecad.parameters.errors import InputError


@dataclass(frozen=True)
class Rest:
    """The stage at rest.

    Args:
        position: of the stage's middle along the travel, m.
        apex_heights: of each unloaded apex at mid-stroke over the unloaded drive surface, m, shape (actuators,).
        attitude: heave of the centre of mass (m) and turns about x and y (rad) from the unloaded pads, shape (3,).
        tip_loads: N, shape (actuators,).
        pad_loads: N, shape (pads,).
        pad_height: of the pads below the drive surface, m.
    """

    position: float
    apex_heights: np.ndarray
    attitude: np.ndarray
    tip_loads: np.ndarray
    pad_loads: np.ndarray
    pad_height: float


def contact_depth(machine: StageMachine, load: float) -> float:
    """Approach of tip and drive surface under a load, m: (N/K)^(2/3)."""
    return (load / machine.contact.rate) ** (2.0 / 3.0)


def _tip_load(machine: StageMachine, depth: float) -> tuple[float, float]:
    """Force of tip and contact in series pressed together by `depth`, N, and its slope, N/m."""
    if depth <= 0.0:
        return 0.0, 0.0
    stiffness, rate = 3.0 * machine.tip.stiffness, machine.contact.rate
    # x + (K/k) x^1.5 = depth for the contact's part x: monotone and convex, so Newton from above descends to it.
    x = depth
    for _ in range(60):
        change = (x + rate / stiffness * x**1.5 - depth) / (1.0 + 1.5 * rate / stiffness * math.sqrt(x))
        x -= change
        if abs(change) <= 1e-15 * depth:
            break
    tangent = 1.5 * rate * math.sqrt(x)
    return rate * x**1.5, tangent * stiffness / (tangent + stiffness)


def rest_at(machine: StageMachine, position: float, apex_heights: np.ndarray, pad_height: float = 2e-3) -> Rest:
    """Rest with the tips at given heights over the unloaded drive surface.

    Raises:
        InputError: the load's centre is outside the pads: the stage tips over.
    """
    centre = np.asarray(machine.stage.centre, dtype=float)
    pads = np.asarray(machine.pads.places, dtype=float) - centre[:2]
    tips = np.asarray(machine.actuators, dtype=float) - centre[:2] - [position, 0.0]
    heights = np.asarray(apex_heights, dtype=float)
    pad_rows = np.column_stack([np.ones(len(pads)), pads[:, 1], -pads[:, 0]])
    tip_rows = np.column_stack([np.ones(len(tips)), tips[:, 1], -tips[:, 0]])
    weight, preload = machine.stage.mass * machine.gravity, machine.stage.preload
    load = np.array([-weight - preload, preload * centre[1], -preload * centre[0]])
    rate = machine.pads.contact_rate
    # Turns are scaled by the pads' reach, so that Newton's step has one unit.
    reach = float(np.max(np.abs(pads)))
    scale = np.array([1.0, 1.0 / reach, 1.0 / reach])
    q = np.array([-((-load[0] / len(pads) / rate) ** (2.0 / 3.0)), 0.0, 0.0])

    def forces(q: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
        depth = np.maximum(-pad_rows @ q, 0.0)
        pad_loads, pad_slopes = rate * depth**1.5, 1.5 * rate * np.sqrt(depth)
        found = [_tip_load(machine, d) for d in heights - tip_rows @ q]
        tip_loads, tip_slopes = np.array([f for f, _ in found]), np.array([k for _, k in found])
        unbalance = load + pad_rows.T @ pad_loads + tip_rows.T @ tip_loads
        stiffness = (pad_rows.T * pad_slopes) @ pad_rows + (tip_rows.T * tip_slopes) @ tip_rows
        return unbalance, stiffness, pad_loads, tip_loads, pad_slopes

    tolerance = 1e-12 * -load[0]
    for _ in range(200):
        unbalance, stiffness, pad_loads, tip_loads, _ = forces(q)
        size = float(np.max(np.abs(unbalance * scale)))
        if size <= tolerance:
            return Rest(position, heights, q, tip_loads, pad_loads, pad_height)
        floor = 1e-9 * rate * math.sqrt(1e-6) * np.diag(1.0 / scale**2)
        step = np.linalg.solve(stiffness + floor, unbalance)
        part = 1.0
        while part > 1e-6 and np.max(np.abs(forces(q + part * step)[0] * scale)) >= size:
            part *= 0.5
        q = q + part * step
    raise InputError("stage: no rest: weight and preload act outside the pads, or the tips tip the stage")


def rest_with_load(machine: StageMachine, position: float, load: float, pad_height: float = 2e-3) -> Rest:
    """Rest with each tip carrying `load`, N (0: just touching), which fixes the tips' heights."""
    apart = np.full(len(machine.actuators), -1.0)
    if load == 0.0:
        free = rest_at(machine, position, apart, pad_height)
        return rest_at(machine, position, _surface_at_tips(machine, position, free.attitude), pad_height)
    # The pads' attitude with the tips' forces applied as dead loads.
    lifted = _with_dead_loads(machine, position, load, pad_height)
    pressed = contact_depth(machine, load) + load / (3.0 * machine.tip.stiffness)
    return rest_at(machine, position, _surface_at_tips(machine, position, lifted.attitude) + pressed, pad_height)


def over_drive_surface(machine: StageMachine, position: float, height: float, pad_height: float = 2e-3) -> Rest:
    """Rest with each apex at mid-stroke set to `height` over the drive surface without tips, m (below: negative)."""
    free = rest_at(machine, position, np.full(len(machine.actuators), -1.0), pad_height)
    return rest_at(machine, position, _surface_at_tips(machine, position, free.attitude) + height, pad_height)


def _surface_at_tips(machine: StageMachine, position: float, attitude: np.ndarray) -> np.ndarray:
    centre = np.asarray(machine.stage.centre, dtype=float)
    tips = np.asarray(machine.actuators, dtype=float) - centre[:2] - [position, 0.0]
    return attitude[0] + attitude[1] * tips[:, 1] - attitude[2] * tips[:, 0]


def _with_dead_loads(machine: StageMachine, position: float, load: float, pad_height: float) -> Rest:
    """Rest of the stage with an upward force of `load` at each tip, as if the preload were less and moved."""
    from dataclasses import replace

    centre = np.asarray(machine.stage.centre, dtype=float)
    tips = np.asarray(machine.actuators, dtype=float)
    weight, preload = machine.stage.mass * machine.gravity, machine.stage.preload
    total = weight + preload - load * len(tips)
    if total <= 0.0:
        raise InputError(f"stage: tips that press with {load:g} N each lift the stage off its pads")
    moment = weight * centre[:2] - load * np.sum(tips - [position, 0.0], axis=0)
    # One force `total` at the point where the moments of weight, preload (at the middle) and tips put it.
    stage = replace(
        machine.stage, mass=total / machine.gravity, preload=0.0, centre=np.array([*(moment / total), centre[2]])
    )
    found = rest_at(replace(machine, stage=stage), position, np.full(len(tips), -1.0), pad_height)
    shift = centre[:2] - stage.centre[:2]
    heave = found.attitude[0] + found.attitude[1] * shift[1] - found.attitude[2] * shift[0]
    return replace(found, attitude=np.array([heave, found.attitude[1], found.attitude[2]]))
