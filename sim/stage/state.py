"""Constants and state of the driven stage for the compiled kernel."""

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from sim.stage.machine import Piezo


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
    pad_rate: float
    pad_damping: float
    pad_bristle: float  # tangential stiffness per load, 1/m
    pad_lag: float  # s, of the film's force behind its stretch
    pad_static: float
    pad_dynamic: float
    pad_stribeck: float
    pad_stiffness_shares: np.ndarray  # (elements,)
    pad_cap_shares: np.ndarray  # (elements,)
    bend_rates: np.ndarray  # (modes,) square of the angular frequency, 1/s^2
    bend_damping: np.ndarray  # (modes,) twice damping ratio times angular frequency, 1/s
    bend_preload: np.ndarray  # (modes,) of the preload, N kg^-1/2
    bend_at_pads: np.ndarray  # (pads, modes)
    bend_grid: np.ndarray  # (modes, nodes along y, nodes along x)
    bend_corner: np.ndarray  # (2,) of the grid, from the middle of the stage
    bend_spacing: np.ndarray  # (2,)
    centre: np.ndarray  # (3,) of mass, from the middle of the stage
    guide_at: np.ndarray  # (irons, 3) from the centre of mass
    guide_stiffness: float
    guide_yaw: float  # stiffness against yaw of one iron's length, N m/rad
    centre_start: np.ndarray  # (3,) of the centre of mass, from the middle of the base
    tip_at: np.ndarray  # (actuators, 2) from the middle of the base
    apex_rest: np.ndarray  # (actuators,) height of an unloaded apex at mid-stroke over the unloaded drive surface
    tip_mass: float
    tip_inertia: float
    tip_moment: float  # mass times height of the centre of mass, kg m
    tip_height: float
    sway_stiffness: float  # N/m; zero where the stacks only stretch
    sway_damping: float
    sway_play: float
    sway_stop: float
    piezo_at: np.ndarray  # (3, 2)
    piezo_stiffness: float
    piezo_damping: float
    contact_rate: float
    contact_damping: float
    contact_friction: float
    contact_ratio: float
    contact_stiffness_shares: np.ndarray
    contact_cap_shares: np.ndarray
    amplifier_rate: float  # 1/s
    voltage_rate: float  # V/s
    voltage_high: float
    bias: float
    gain: float
    strength: float
    thresholds: np.ndarray
    weights: np.ndarray
    creep_weights: np.ndarray
    creep_rates: np.ndarray


class State(NamedTuple):
    """State of the stage; every array is written in place."""

    position: np.ndarray  # (6,) x, y, z, turn about x, y, z
    velocity: np.ndarray  # (6,)
    acceleration: np.ndarray  # (6,)
    bend: np.ndarray  # (modes,)
    bend_velocity: np.ndarray
    bend_acceleration: np.ndarray
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
    pad_force: np.ndarray  # (pads, elements, 2) on the stage
    pad_tangent: np.ndarray  # (pads,) tangential stiffness of the step before
    contact_force: np.ndarray  # (actuators, elements, 2) on the stage
    contact_tangent: np.ndarray  # (actuators,)
    totals: np.ndarray  # works: drive, heat of pads, heat of tip contacts, heat of damping
    actuator_totals: np.ndarray  # (actuators, 4): impulses x, y, z on the stage, time in contact
    pad_totals: np.ndarray  # (pads, 2): time lifted, slid distance
    clock: np.ndarray  # (1,) s


PLAYS = 8
CREEP_START = 0.1
CREEP_DECADES = 3.0
LAGS = 13


@dataclass(frozen=True)
class PiezoResponse:
    """Numbers of the operators."""

    gain: float  # stretch per volt of u, m/V
    strength: float  # s
    thresholds: np.ndarray  # r_i, V, shape (8,)
    weights: np.ndarray  # w_i, shape (8,), summing to 1
    creep_weights: np.ndarray  # shape (13,)
    creep_rates: np.ndarray  # 1/s, shape (13,)

    @property
    def small_signal_gain(self) -> float:
        """Stretch per volt of a wave smaller than the least play, m/V."""
        return self.gain * (1.0 - self.strength)


def piezo_response(piezo: Piezo) -> PiezoResponse:
    """The operators that give a stack its catalogue stroke, hysteresis and creep."""
    half = 0.5 * piezo.highest_voltage
    thresholds = half * np.linspace(0.1, 1.0, PLAYS)
    weights = np.full(PLAYS, 1.0 / PLAYS)
    mean = float(weights @ thresholds)
    behind = float(weights @ np.minimum(thresholds, half - thresholds))
    strength = piezo.hysteresis * half / (behind + piezo.hysteresis * mean)
    gain = piezo.stroke / (piezo.highest_voltage - 2.0 * strength * mean)
    times = CREEP_START * 10.0 ** (CREEP_DECADES * np.arange(LAGS) / (LAGS - 1))
    creep = np.full(LAGS, piezo.creep * CREEP_DECADES / (LAGS - 1))
    return PiezoResponse(gain, strength, thresholds, weights, creep, 1.0 / times)
