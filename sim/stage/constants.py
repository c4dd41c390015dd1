"""A machine as the kernel takes it, and its state at rest."""

import math
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from sim.stage.machine import Piezo, StageMachine
from sim.stage.slip_elements import mindlin, parabola, slip_springs
from sim.stage.state import ELEMENTS, TIP_FREEDOMS, Constants, State, as_numbers
from sim.stage.statics import Rest, contact_depth, preload_places
from stagecad.parameters.errors import InputError

STEP = 1e-6
"""s. The fastest mode of the packaged design, the tip on its piezos and the contact, has some 12 kHz."""
STEPS_A_CYCLE = 40
"""Least number of steps in a period of the fastest mode."""


PLAYS = 8
CREEP_START = 0.1
CREEP_DECADES = 3.0
LAGS = 13


class PiezoResponse(NamedTuple):
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


def quickest_mode(machine: StageMachine) -> float:
    """Frequency that no mode of tip and contact exceeds, Hz, at a contact force of the whole load."""
    tip = machine.tip
    contact = 1.5 * machine.contact.rate * math.sqrt(contact_depth(machine, machine.load))
    heave = (3.0 * tip.stiffness + contact) / tip.mass
    turn = float(max(np.sum(tip.piezo_places**2, axis=0))) * tip.stiffness
    inertia, shear = tip.inertia, machine.contact.tangential_ratio * contact
    slide = 0.0
    if tip.sways:
        # Sway and tilt move together: the tilt alone has the inertia about the centre of mass.
        inertia -= tip.moment**2 / tip.mass
        slide = (tip.sway_stiffness + tip.sway_stop + shear) / (tip.mass - tip.moment**2 / tip.inertia)
    turn = (turn + shear * tip.height**2) / inertia + slide
    pads = 1.5 * machine.pads.contact_rate * math.sqrt((machine.load / machine.pads.contact_rate) ** (2.0 / 3.0))
    bounce = len(machine.pads.places) * pads / machine.stage.mass
    bending = float(np.max(machine.stage.bending.frequencies, initial=0.0))
    return max(math.sqrt(max(heave, turn, bounce)) / (2.0 * math.pi), bending)


def make_constants(machine: StageMachine, rest: Rest, step: float = STEP) -> Constants:
    """Numbers for the kernel, with the tips at the heights of `rest`."""
    quickest = quickest_mode(machine)
    if not 0.0 < step <= 1.0 / (STEPS_A_CYCLE * quickest):
        raise InputError(
            f"stage: a step of {step:g} s is too long for a mode of {quickest:.0f} Hz; at most "
            f"{1.0 / (STEPS_A_CYCLE * quickest):.2g} s"
        )
    stage, pads, tip = machine.stage, machine.pads, machine.tip
    centre = np.asarray(stage.centre, dtype=float)
    pad_springs, contact_springs = slip_springs(parabola), slip_springs(mindlin)
    pad_slope, contact_slope = float(np.sum(pad_springs.stiffness)), float(np.sum(contact_springs.stiffness))
    bending, omega = stage.bending, 2.0 * math.pi * stage.bending.frequencies
    irons = np.atleast_2d(np.asarray(stage.guide_places, dtype=float)).reshape(-1, 2)
    piezo = machine.piezo
    return Constants(
        step=step,
        mass=stage.mass,
        inertia=np.ascontiguousarray(stage.inertia, dtype=float),
        inertia_inverse=np.ascontiguousarray(np.linalg.inv(stage.inertia)),
        weight=stage.mass * machine.gravity,
        preload=stage.preload,
        preload_at=-centre,
        pad_at=_heights(pads.places, -pads.height) - centre,
        pads=as_numbers(pads),
        pad_bristle=pad_slope * pads.static_friction / pads.presliding,
        pad_stiffness_shares=pad_springs.stiffness / pad_slope,
        pad_cap_shares=pad_springs.limit,
        bend_rates=omega**2,
        bend_damping=2.0 * bending.damping * omega,
        bend_preload=stage.preload * np.mean(bending.at(preload_places(machine))[:, 0], axis=0),
        bend_at_pads=np.ascontiguousarray(bending.at(pads.places)[:, 0]),
        bend_grid=np.ascontiguousarray(bending.shapes, dtype=float),
        bend_corner=bending.corner,
        bend_spacing=bending.spacing,
        centre=centre,
        guide_at=_heights(irons, 0.0) - centre,
        guide_stiffness=stage.guide_stiffness,
        guide_yaw=stage.guide_stiffness * stage.guide_length**2 / 12.0,
        centre_start=centre + [rest.position, 0.0, 0.0],
        tip_at=np.ascontiguousarray(machine.actuators, dtype=float),
        apex_rest=np.ascontiguousarray(rest.apex_heights, dtype=float),
        tip=as_numbers(tip if tip.sways else replace(tip, moment=0.0, sway_stiffness=0.0)),
        contact=as_numbers(machine.contact),
        contact_stiffness_shares=contact_springs.stiffness / contact_slope,
        contact_cap_shares=contact_springs.limit,
        amplifier_rate=2.0 * math.pi * piezo.bandwidth,
        voltage_rate=piezo.voltage_rate,
        piezo=as_numbers(piezo),
        response=piezo_response(piezo),
    )


def make_state(machine: StageMachine, rest: Rest) -> State:
    """The machine at rest, its piezos at mid-stroke for long, no tangential force anywhere."""
    actuators, pads, modes = len(machine.actuators), len(machine.pads.places), len(rest.bending)
    shapes: dict[str, int | tuple[int, ...]] = {
        **dict.fromkeys(("position", "velocity", "acceleration"), 6),
        **dict.fromkeys(("bend", "bend_velocity", "bend_speed"), modes),
        **dict.fromkeys(("tip", "tip_velocity", "tip_acceleration"), (actuators, TIP_FREEDOMS)),
        **dict.fromkeys(("voltage", "stretch", "piezo_force"), (actuators, 3)),
        "play": (actuators, 3, PLAYS),
        "creep": (actuators, 3, LAGS),
        "tip_shapes": (actuators, 3, modes),
        "tip_shapes_at": (actuators, 2),
        "pad_force": (pads, 2, ELEMENTS),
        "pad_tangent": pads,
        "pad_stored": pads,
        "contact_force": (actuators, 2, ELEMENTS),
        "contact_tangent": actuators,
        "contact_stored": actuators,
        "totals": 4,
        "actuator_totals": (actuators, 4),
        "pad_totals": (pads, 2),
        "clock": 1,
    }
    state = State(**{name: np.zeros(shape) for name, shape in shapes.items()})
    state.bend[:], state.voltage[:], state.play[:] = rest.bending, machine.piezo.bias, machine.piezo.bias
    state.position[2:5] = rest.attitude
    for k, (load, slopes) in enumerate(zip(rest.tip_loads, rest.slopes, strict=True)):
        # Friction holds the stage on the slope that a tip presses into it.
        springs = slip_springs(mindlin).stiffness
        shares = springs / np.sum(springs)
        depth = contact_depth(machine, load)
        tangent = machine.contact.tangential_ratio * 1.5 * machine.contact.rate * math.sqrt(depth)
        state.contact_force[k] = -load * slopes[:, None] * shares
        state.contact_tangent[k] = tangent
        if load > 0.0:
            state.contact_stored[k] = np.sum(state.contact_force[k] ** 2 / shares) / (2.0 * tangent)
    state.tip[:, 0] = -rest.tip_loads / (3.0 * machine.tip.stiffness)
    state.piezo_force[:] = (rest.tip_loads / 3.0)[:, None]
    return state


def _heights(places: np.ndarray, height: float) -> np.ndarray:
    """Places (n, 2) with a common height, shape (n, 3)."""
    flat = np.asarray(places, dtype=float).reshape(-1, 2)
    return np.column_stack([flat, np.full(len(flat), height)])
