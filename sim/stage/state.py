"""Constants and state of the driven stage for the compiled kernel, its bending modes among them.

A shape is given at the nodes of a regular grid. Between them it is the product of cubics through four nodes each
(Catmull-Rom), continuous with its slopes; its deflection and both slopes are consistent, so that a tip which slides
under a bent stage does the work that it receives.
"""

from collections import namedtuple
from dataclasses import fields
from typing import Any, NamedTuple

import numpy as np

from sim.numerics.compilation import SUMS_IN_ANY_ORDER, compiled, inlined
from sim.stage.machine import Contact, Pads, Piezo, Tip


def _numbers_of(kind: type) -> Any:
    return namedtuple(f"{kind.__name__}Numbers", [item.name for item in fields(kind)], module=__name__)


PadsNumbers, TipNumbers, ContactNumbers, PiezoNumbers = map(_numbers_of, (Pads, Tip, Contact, Piezo))


def as_numbers(record: Any) -> Any:
    """Numbers of a part of the machine for the kernel: floats, and arrays in C order."""
    values = (np.ascontiguousarray(v, dtype=float) if np.ndim(v) else float(v) for v in vars(record).values())
    return globals()[f"{type(record).__name__}Numbers"](*values)


class Constants(NamedTuple):
    """Numbers of the machine for the kernel, SI; see `constants.py` for what each comes from."""

    step: float
    mass: float
    inertia: np.ndarray  # (3, 3)
    inertia_inverse: np.ndarray  # (3, 3)
    weight: float
    preload: float
    preload_at: np.ndarray  # (3,) from the centre of mass
    pad_at: np.ndarray  # (pads, 3) from the centre of mass
    pads: Any  # `Pads` as numbers
    pad_bristle: float  # tangential stiffness per load, 1/m
    pad_stiffness_shares: np.ndarray  # (elements,)
    pad_cap_shares: np.ndarray  # (elements,)
    bend_rates: np.ndarray  # (modes,) square of the angular frequency, 1/s^2
    bend_damping: np.ndarray  # (modes,) twice damping ratio times angular frequency, 1/s
    bend_preload: np.ndarray  # (modes,) of the preload, N kg^-1/2
    bend_at_pads: np.ndarray  # (pads, modes)
    bend_grid: np.ndarray  # (nodes along y, nodes along x, modes)
    bend_corner: np.ndarray  # (2,) of the grid, from the middle of the stage
    bend_spacing: np.ndarray  # (2,)
    centre: np.ndarray  # (3,) of mass, from the middle of the stage
    guide_at: np.ndarray  # (irons, 3) from the centre of mass
    guide_stiffness: float
    guide_yaw: float  # stiffness against yaw of one iron's length, N m/rad
    centre_start: np.ndarray  # (3,) of the centre of mass, from the middle of the base
    tip_at: np.ndarray  # (actuators, 2) from the middle of the base
    apex_rest: np.ndarray  # (actuators,) height of an unloaded apex at mid-stroke over the unloaded drive surface
    tip: Any  # `Tip` as numbers; moment and sway stiffness are zero where the stacks only stretch
    contact: Any  # `Contact` as numbers
    contact_stiffness_shares: np.ndarray
    contact_cap_shares: np.ndarray
    amplifier_rate: float  # 1/s
    voltage_rate: float  # V/s
    piezo: Any  # `Piezo` as numbers
    response: Any  # `PiezoResponse`


class State(NamedTuple):
    """State of the stage; every array is written in place."""

    position: np.ndarray  # (6,) x, y, z, turn about x, y, z
    velocity: np.ndarray  # (6,)
    acceleration: np.ndarray  # (6,)
    # (modes,): place half-way through the next step, velocity at its start, and that extrapolated to its middle
    bend: np.ndarray
    bend_velocity: np.ndarray
    bend_speed: np.ndarray
    tip: np.ndarray  # (actuators, 5) z, a, b, sway x, sway y
    tip_velocity: np.ndarray
    tip_acceleration: np.ndarray
    voltage: np.ndarray  # (actuators, 3)
    play: np.ndarray  # (actuators, 3, plays)
    creep: np.ndarray  # (actuators, 3, lags)
    tip_shapes: np.ndarray  # (actuators, 3, modes) of the stage above the tip: deflection, slopes along x and y
    tip_shapes_at: np.ndarray  # (actuators, 2) place on the stage at which those hold
    stretch: np.ndarray  # (actuators, 3) free stretch from mid-stroke, m
    piezo_force: np.ndarray  # (actuators, 3)
    pad_force: np.ndarray  # (pads, 2, elements) on the stage
    pad_tangent: np.ndarray  # (pads,) tangential stiffness of the step before
    pad_stored: np.ndarray  # (pads,) energy of its elements, J
    contact_force: np.ndarray  # (actuators, 2, elements) on the stage
    contact_tangent: np.ndarray  # (actuators,)
    contact_stored: np.ndarray  # (actuators,) J
    totals: np.ndarray  # works: drive, heat of pads, heat of tip contacts, heat of damping
    actuator_totals: np.ndarray  # (actuators, 4): impulses x, y, z on the stage, time in contact
    pad_totals: np.ndarray  # (pads, 2): time lifted, slid distance
    clock: np.ndarray  # (1,) s


ELEMENTS, TIP_FREEDOMS = 4, 5
"""Slip elements of a contact, and degrees of freedom of a tip."""


@inlined
def _weights(t: float) -> tuple[float, float, float, float]:
    """Weights of four nodes at a part t of the middle interval."""
    return (
        0.5 * t * (-1.0 + t * (2.0 - t)),
        0.5 * (2.0 + t * t * (3.0 * t - 5.0)),
        0.5 * t * (1.0 + t * (4.0 - 3.0 * t)),
        0.5 * t * t * (t - 1.0),
    )


@inlined
def _slopes(t: float) -> tuple[float, float, float, float]:
    """Derivatives of `_weights`."""
    return (
        0.5 * (-1.0 + t * (4.0 - 3.0 * t)),
        0.5 * t * (9.0 * t - 10.0),
        0.5 * (1.0 + t * (8.0 - 9.0 * t)),
        0.5 * t * (3.0 * t - 2.0),
    )


@compiled
def shapes_at(
    grid: np.ndarray, origin: np.ndarray, spacing: np.ndarray, place: tuple[float, float], out: np.ndarray
) -> None:
    """Write deflection and slopes along x and y of every mode (across, along, modes) at a place (x, y) on the stage, m,
    to `out` (3, modes); beyond the grid its edge holds."""
    rows, columns = grid.shape[0], grid.shape[1]
    u = min(max((place[0] - origin[0]) / spacing[0], 0.0), columns - 1.0)
    v = min(max((place[1] - origin[1]) / spacing[1], 0.0), rows - 1.0)
    i, j = min(int(u), columns - 2), min(int(v), rows - 2)
    along, across = _weights(u - i), _weights(v - j)
    along_slope, across_slope = _slopes(u - i), _slopes(v - j)
    for m in range(grid.shape[2]):
        out[0, m], out[1, m], out[2, m] = 0.0, 0.0, 0.0
    for b in range(4):
        row = min(max(j - 1 + b, 0), rows - 1)
        for a in range(4):
            column = min(max(i - 1 + a, 0), columns - 1)
            value = across[b] * along[a]
            by_x, by_y = across[b] * along_slope[a] / spacing[0], across_slope[b] * along[a] / spacing[1]
            for m in range(grid.shape[2]):
                node = grid[row, column, m]
                out[0, m] += value * node
                out[1, m] += by_x * node
                out[2, m] += by_y * node


@compiled(forceinline=True, _nrt=False, fastmath=SUMS_IN_ANY_ORDER)
def surface(
    c: Constants, s: State, k: int, place: tuple[float, float], refresh: bool
) -> tuple[float, float, float, float, float, float]:
    """Bending of the drive surface above tip `k` at a place (x, y) on the stage: deflection, rate at the middle of the
    step, slopes along x and y; also the offset of the place from where the modes were evaluated."""
    shapes, at = s.tip_shapes[k], s.tip_shapes_at[k]
    if refresh:
        at[0], at[1] = place
        shapes_at(c.bend_grid, c.bend_corner, c.bend_spacing, place, shapes)
    dx, dy = place[0] - at[0], place[1] - at[1]
    lift, rate, slope_x, slope_y = 0.0, 0.0, 0.0, 0.0
    for m in range(c.bend_rates.shape[0]):
        shape = shapes[0, m] + shapes[1, m] * dx + shapes[2, m] * dy
        lift += shape * s.bend[m]
        rate += shape * s.bend_speed[m]
        slope_x += shapes[1, m] * s.bend[m]
        slope_y += shapes[2, m] * s.bend[m]
    return lift, rate, slope_x, slope_y, dx, dy


@compiled(forceinline=True, _nrt=False, fastmath=SUMS_IN_ANY_ORDER)
def advance_modes(c: Constants, s: State, writes: bool, loads: Any) -> None:
    """Advance the bending modes by one step."""
    h, half = c.step, 0.5 * c.step
    # The compiler uses vectors where a loop adds up apart from memory.
    heat, energy = 0.0, 0.0
    for m in range(c.bend_rates.shape[0]):
        speed = s.bend_speed[m]
        loads.bend[m] -= c.bend_rates[m] * s.bend[m] + c.bend_damping[m] * speed
        heat += c.bend_damping[m] * speed * speed
    s.totals[3] += heat * h
    if writes:
        for m in range(c.bend_rates.shape[0]):
            middle = s.bend_velocity[m] + half * loads.bend[m]
            energy += 0.5 * middle * middle + (0.5 * c.bend_rates[m] * s.bend[m] + c.bend_preload[m]) * s.bend[m]
        loads.energy[0] += energy
    for m in range(c.bend_rates.shape[0]):
        s.bend_velocity[m] += h * loads.bend[m]
        s.bend[m] += h * s.bend_velocity[m]
        s.bend_speed[m] = s.bend_velocity[m] + half * loads.bend[m]
