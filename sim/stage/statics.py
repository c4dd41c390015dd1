"""Static equilibrium of the stage on its pads and tips.

The elastic energy of pads, tips and bent stage in heave, roll, pitch and the bending modes is convex, so rest is its
minimum, found by Newton's method with halving. There is no friction force at rest: the stage is set down without shear.
"""

import math
from dataclasses import dataclass

import numpy as np

from sim.stage.machine import StageMachine
from stagecad.parameters.errors import InputError


@dataclass(frozen=True)
class Rest:
    """The stage at rest."""

    position: float  # of the stage's middle along the travel, m
    # of each unloaded apex at mid-stroke over the unloaded drive surface, m, shape (actuators,)
    apex_heights: np.ndarray
    # heave of the centre of mass (m) and turns about x and y (rad) from the unloaded pads, shape (3,)
    attitude: np.ndarray
    tip_loads: np.ndarray  # N, shape (actuators,)
    pad_loads: np.ndarray  # N, shape (pads,)
    bending: np.ndarray  # of the stage in its modes, m kg^1/2, shape (modes,)
    slopes: np.ndarray  # of the drive surface above each tip along x and y, shape (actuators, 2)


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


def rest_at(machine: StageMachine, position: float, apex_heights: np.ndarray, lifted: float = 0.0) -> Rest:
    """Rest with the apexes at given heights over the unloaded drive surface, m, (actuators,), the stage's middle at
    `position`, m; `lifted`: dead load upwards in the place of each tip, N."""
    stage, bending = machine.stage, machine.stage.bending
    centre = np.asarray(stage.centre, dtype=float)
    heights = np.asarray(apex_heights, dtype=float)
    pad_rows, tip_rows = _rows(machine, machine.pads.places), _rows(machine, _tips_on_stage(machine, position))
    weight, preload = stage.mass * machine.gravity, stage.preload
    load = np.zeros(3 + len(bending.frequencies))
    load[:3] = -weight - preload, preload * centre[1], -preload * centre[0]
    if preload:
        load[3:] = -preload * np.mean(bending.at(preload_places(machine))[:, 0], axis=0)
    load += lifted * np.sum(tip_rows, axis=0)
    bent = np.zeros_like(load)
    bent[3:] = (2.0 * math.pi * bending.frequencies) ** 2
    rate = machine.pads.contact_rate
    # Turns are scaled by the pads' reach, so that Newton's step has one unit; modal masses are 1 kg.
    reach = float(np.max(np.abs(pad_rows[:, 1:3])))
    scale = np.array([1.0, 1.0 / reach, 1.0 / reach, *np.full(len(bending.frequencies), math.sqrt(stage.mass))])
    q = np.zeros_like(load)
    q[0] = -((max(-load[0], 1e-9 * weight) / len(pad_rows) / rate) ** (2.0 / 3.0))

    def forces(q: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
        depth = np.maximum(-pad_rows @ q, 0.0)
        pad_loads, pad_slopes = rate * depth**1.5, 1.5 * rate * np.sqrt(depth)
        found = [_tip_load(machine, d) for d in heights - tip_rows @ q]
        tip_loads, tip_slopes = np.array([f for f, _ in found]), np.array([k for _, k in found])
        unbalance = load - bent * q + pad_rows.T @ pad_loads + tip_rows.T @ tip_loads
        stiffness = np.diag(bent) + (pad_rows.T * pad_slopes) @ pad_rows + (tip_rows.T * tip_slopes) @ tip_rows
        return unbalance, stiffness, pad_loads, tip_loads

    tolerance = 1e-12 * (weight + preload)
    for _ in range(200):
        unbalance, stiffness, pad_loads, tip_loads = forces(q)
        size = float(np.max(np.abs(unbalance * scale)))
        if size <= tolerance:
            slopes = np.array([-q[2], q[1]]) + bending.at(_tips_on_stage(machine, position))[:, 1:] @ q[3:]
            return Rest(position, heights, q[:3], tip_loads, pad_loads, q[3:], slopes)
        floor = 1e-9 * rate * math.sqrt(1e-6) * np.diag(1.0 / scale**2)
        step = np.linalg.solve(stiffness + floor, unbalance)
        part = 1.0
        while part > 1e-6 and np.max(np.abs(forces(q + part * step)[0] * scale)) >= size:
            part *= 0.5
        q = q + part * step
    raise InputError("stage: no rest: weight and preload act outside the pads, or the tips tip the stage")


def preload_places(machine: StageMachine) -> np.ndarray:
    """Points at which the magnets pull, (x, y) from the middle of the stage, m, (n, 2)."""
    irons = np.asarray(machine.stage.guide_places, dtype=float).reshape(-1, 2)
    return irons if len(irons) else np.zeros((1, 2))


def _tips_on_stage(machine: StageMachine, position: float) -> np.ndarray:
    """Places of the tips from the middle of the stage, m, (actuators, 2)."""
    return np.asarray(machine.actuators, dtype=float) - [position, 0.0]


def _rows(machine: StageMachine, places: np.ndarray) -> np.ndarray:
    """Height of the stage at places by heave, roll, pitch and bending modes, (places, 3 + modes)."""
    places = np.asarray(places, dtype=float)
    x, y = (places - np.asarray(machine.stage.centre, dtype=float)[:2]).T
    return np.column_stack([np.ones(len(places)), y, -x, machine.stage.bending.at(places)[:, 0]])


def rest_with_load(machine: StageMachine, position: float, load: float) -> Rest:
    """Rest with each tip carrying `load`, N (0: just touching), which fixes the tips' heights."""
    apart = np.full(len(machine.actuators), -1.0)
    if load == 0.0:
        free = rest_at(machine, position, apart)
        return rest_at(machine, position, _surface_at_tips(machine, position, free))
    # The stage with the tips' forces applied as dead loads.
    lifted = rest_at(machine, position, apart, load)
    pressed = contact_depth(machine, load) + load / (3.0 * machine.tip.stiffness)
    return rest_at(machine, position, _surface_at_tips(machine, position, lifted) + pressed)


def over_drive_surface(machine: StageMachine, position: float, height: float) -> Rest:
    """Rest with each apex at mid-stroke set to `height` over the drive surface without tips, m (below: negative)."""
    free = rest_at(machine, position, np.full(len(machine.actuators), -1.0))
    return rest_at(machine, position, _surface_at_tips(machine, position, free) + height)


def _surface_at_tips(machine: StageMachine, position: float, rest: Rest) -> np.ndarray:
    """Height of the drive surface above each tip, from the unloaded one, m, (actuators,)."""
    return _rows(machine, _tips_on_stage(machine, position)) @ np.append(rest.attitude, rest.bending)
