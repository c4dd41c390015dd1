"""The stage's simulation model from a design and the mass properties of its moving bodies."""

import dataclasses
import math

import numpy as np

from designcalc.checks.check import DesignInputs
from designcalc.errors.sensors import count_size
from designcalc.friction_stage.physics import loads, tip_dynamics
from designcalc.friction_stage.physics.pads import mean_film, pad_positions
from designcalc.friction_stage.physics.position_loop import BANDS, air_error, suspension
from designcalc.friction_stage.physics.stage_plate import bending_modes
from sim.stage.machine import Bending, Contact, Pads, Piezo, Sensors, Stage, StageMachine, Surroundings, Tip
from sim.stage.slip_elements import parabola, slip_springs
from stagecad.parameters.design import Design
from stagecad.parameters.mass_properties import BodyMasses, MassProperties

BENDING_MODES = 40
"""Natural ones of the plate, up to some 15 kHz; residual modes complete them. Speeds with 40 and with 60 agree within
half a percent (docs/convergence.md)."""

HIGHEST_MODE = 24e3
"""Hz: modes above have their stiffness alone, with the mass that brings them down to it, as the step of the simulation
would have to be shorter. The static deflection remains exact, and an impact of 0.1 ms hardly excites them."""


def bending(r: DesignInputs, count: int, added: float | None = None) -> Bending:
    """The `count` lowest modes of the plate, with a mass `added` in its middle, kg."""
    modes = bending_modes(r, count, added)
    frequency = np.minimum(modes.frequency, HIGHEST_MODE)
    # Of unit modal mass: the deflection phi^2/omega^2 under a static force is kept.
    shapes = modes.shapes * (frequency / modes.frequency)
    return Bending(frequency, r("stage.damping_ratio"), shapes, -0.5 * np.array([r("stage.length"), r("stage.width")]))


def stage_machine(design: Design, masses: BodyMasses) -> StageMachine:
    """The simulated machine; its numbers are those of `designcalc.friction_stage.physics`, as for the checks.

    Without teeth the preload is a dead weight in the middle of the stage, and nothing guides the stage.
    """
    r = DesignInputs(design, masses)
    contact = tip_dynamics.contact_stiffness(r, loads.load(r))
    return StageMachine(
        stage=_stage(r),
        pads=_pads(r),
        tip=_tip(r),
        contact=Contact(
            rate=contact.rate,
            damping=1.5 * r("drive.impact_loss"),
            friction=r("drive.friction"),
            tangential_ratio=contact.tangential_ratio,
        ),
        piezo=Piezo(
            stroke=r("piezo.stroke"),
            highest_voltage=r("piezo.highest_voltage"),
            bias=r("actuator.bias_voltage"),
            hysteresis=r("piezo.hysteresis"),
            creep=r("piezo.creep"),
            capacitance=r("piezo.capacitance"),
            current=r("amplifier.current"),
            slew_rate=r("amplifier.slew_rate"),
            bandwidth=r("amplifier.bandwidth"),
            bits=design.amplifier.bits,
            loss=tip_dynamics.driven_capacitance(r) * r("piezo.loss_factor"),
            tension=r("piezo.strain_limit") * r("piezo.element_area"),
        ),
        sensors=_sensors(design),
        actuators=np.array(design.derived.fitted_places) * 1e-3,
        travel=r("stage.travel"),
        gravity=loads.gravity(r),
        surroundings=_surroundings(r),
    )


def flexible_machine(design: Design, masses: BodyMasses, modes: int = BENDING_MODES) -> StageMachine:
    """The machine of `stage_machine` with the bending modes of its stage and the sway of its tips on bending stacks,
    within the play of their bores and against them; `modes`: number of natural ones."""
    machine, r = stage_machine(design, masses), DesignInputs(design, masses)
    lateral, (play, stop) = tip_dynamics.sway(r), tip_dynamics.sway_limit(r)
    tip = dataclasses.replace(
        machine.tip,
        moment=masses.tip.mass * masses.tip.centre_of_mass[2],
        sway_stiffness=lateral,
        sway_damping=2.0 * r("piezo.damping_ratio") * math.sqrt(lateral * machine.tip.mass),
        sway_play=play,
        sway_stop=stop,
    )
    return dataclasses.replace(machine, stage=dataclasses.replace(machine.stage, bending=bending(r, modes)), tip=tip)


def driven_alone(design: Design, machine: StageMachine) -> StageMachine:
    """The machine on actuator 1 only."""
    return dataclasses.replace(machine, actuators=np.array(design.derived.actuator_places[:1]) * 1e-3)


def driven_by_three(design: Design, machine: StageMachine, masses: BodyMasses) -> StageMachine:
    """The machine on three actuators, without teeth: the required preload is a dead weight, and nothing guides it.

    The weight, a point in the middle, takes part in the bending modes.
    """
    r = DesignInputs(design, masses)
    body = MassProperties(0.0, machine.stage.mass, machine.stage.centre, machine.stage.inertia, np.zeros((2, 3)))
    stage = machine.stage
    if design.teeth.fitted:
        added = r("preload.force") / loads.gravity(r)
        modes = bending(r, BENDING_MODES, added) if len(stage.bending.frequencies) else stage.bending
        stage = dataclasses.replace(_as_stage(loads.with_ballast(body, added)), bending=modes)
    return dataclasses.replace(machine, stage=stage, actuators=np.array(design.derived.actuator_places) * 1e-3)


def _as_stage(body: MassProperties) -> Stage:
    return Stage(mass=body.mass, centre=np.array(body.centre_of_mass), inertia=np.array(body.inertia))


def _stage(r: DesignInputs) -> Stage:
    stage = _as_stage(loads.moving_body(r))
    if not r.design.teeth.fitted:
        return stage
    across = r("teeth.bar_spacing") / 2.0
    return dataclasses.replace(
        stage,
        preload=loads.preload(r),
        guide_stiffness=loads.magnets(r).lateral_stiffness,
        guide_places=np.array([(0.0, across), (0.0, -across)]),
        guide_length=r("tooth_iron.length"),
    )


def _pads(r: DesignInputs) -> Pads:
    """Pads as springs ``F = K delta^1.5`` with the film's stiffness at the mean load."""
    places, whole, mass = pad_positions(r), loads.load(r), loads.moved_mass(r)
    each = whole / len(places)
    stiffness = float(mean_film(r).stiffness)
    # A power law through load and stiffness at the mean load: F = K delta^1.5 has the slope 1.5 F/delta.
    depth = 1.5 * each / stiffness
    critical = 2.0 * math.sqrt(len(places) * stiffness * mass)
    damping = r("bearing.damping_ratio") * critical / len(places)
    rise = float(np.sum(slip_springs(parabola).stiffness))
    shear = rise * r("bearing.static_friction") * whole / r("bearing.presliding_distance")
    return Pads(
        places=places,
        height=r("pads.height"),
        contact_rate=each / depth**1.5,
        damping=damping / each,
        static_friction=r("bearing.static_friction"),
        dynamic_friction=r("bearing.dynamic_friction"),
        stribeck_velocity=r("bearing.stribeck_velocity"),
        presliding=r("bearing.presliding_distance"),
        # Of the stage on the film's shear at rest, as of its bounce: tau = 2 zeta/omega.
        tangential_lag=2.0 * r("bearing.damping_ratio") / math.sqrt(shear / mass),
    )


def _tip(r: DesignInputs) -> Tip:
    places = np.array(r.design.derived.piezo_places) * 1e-3
    stiffness, mass = tip_dynamics.stack_stiffness(r), tip_dynamics.mass_on_piezos(r)
    count, inertia = tip_dynamics.PIEZOS, tip_dynamics.inertia_on_piezos(r)
    damping = 2.0 * r("piezo.damping_ratio") * math.sqrt(count * stiffness * mass) / count
    return Tip(mass, inertia, r("actuator.tip_height"), places, stiffness, damping)


def _surroundings(r: DesignInputs) -> Surroundings:
    """Disturbances of the position loop, those of the dynamic error budget."""
    held = suspension(r)
    return Surroundings(
        floor_velocity=r("environment.floor_velocity"),
        floor_bands=tuple(BANDS),
        held_resonance=held.resonance,
        held_damping=held.damping,
        amplifier_noise=r("amplifier.noise"),
        air_error=air_error(r),
        air_time=r("environment.air_time"),
    )


def _sensors(design: Design) -> Sensors:
    lvdt, probe = design.sensors.lvdt, design.sensors.probe
    filtered, fringe = design.sensors.filtered_probe, design.sensors.interferometer
    return Sensors(
        interferometer_count=fringe.resolution,
        probe_noise=probe.resolution,
        probe_bandwidth=probe.bandwidth,
        filter_frequency=filtered.filter_frequency,
        filtered_range=probe.range / filtered.gain,
        filtered_count=float(count_size(probe.range / filtered.gain, filtered.bits)),
        lvdt_count=float(count_size(lvdt.range, lvdt.bits)),
        lvdt_linearity_error=lvdt.linearity * lvdt.range,
    )
