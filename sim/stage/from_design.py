"""The stage's simulation model from a design and the mass properties of its moving bodies."""

from __future__ import annotations

import dataclasses
import math

import numpy as np

from designcalc.errors.sensors import count_size
from designcalc.machine.inputs import DesignInputs
from designcalc.machine.pads import film, pad_positions
from designcalc.machine.teeth import teeth
from designcalc.machine.tip_contact import unit_load_contact
from designcalc.machine.tip_dynamics import PIEZOS, stack_stiffness
from sim.stage.machine import Contact, Pads, Piezo, Sensors, Stage, StageMachine, Tip
from sim.stage.slip_elements import parabola, slip_elements
from stagecad.parameters.design import Design
from stagecad.parameters.mass_properties import BodyMasses, MassProperties, combined


def stage_machine(design: Design, masses: BodyMasses) -> StageMachine:
    """The simulated machine.

    Without teeth the preload is a dead weight in the middle of the stage, and nothing guides the stage.
    """
    r = DesignInputs(design, masses)
    body = _with_payload(design, masses.moving)
    load = body.mass * r("environment.gravity") + (r("preload.force") if design.teeth.fitted else 0.0)
    rate, tangential_ratio = unit_load_contact(r)
    return StageMachine(
        stage=_stage(r, body),
        pads=_pads(r, body.mass, load),
        tip=_tip(r, masses.tip),
        contact=Contact(
            rate=rate,
            damping=1.5 * r("drive.impact_loss"),
            friction=r("drive.friction"),
            tangential_ratio=tangential_ratio,
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
        ),
        sensors=_sensors(design),
        actuators=np.array(design.derived.fitted_places) * 1e-3,
        travel=r("stage.travel"),
        gravity=r("environment.gravity"),
    )


def driven_alone(design: Design, machine: StageMachine) -> StageMachine:
    """The machine on actuator 1 only."""
    return dataclasses.replace(machine, actuators=np.array(design.derived.actuator_places[:1]) * 1e-3)


def driven_by_three(design: Design, machine: StageMachine) -> StageMachine:
    """The machine on three actuators, without teeth: its preload is a dead weight, and nothing guides it."""
    ballast = machine.stage.preload / machine.gravity
    places = np.array(design.derived.actuator_places) * 1e-3
    return dataclasses.replace(machine, stage=_with_ballast(machine.stage, ballast), actuators=places)


def _with_ballast(stage: Stage, mass: float) -> Stage:
    """The stage with a point mass in its middle, at the height of its centre of mass; no preload and no guide."""
    centre = np.asarray(stage.centre, dtype=float)
    total = stage.mass + mass
    at = np.array([0.0, 0.0, centre[2]])
    moved = (stage.mass * centre + mass * at) / total
    inertia = np.array(stage.inertia, dtype=float)
    for weight, place in ((stage.mass, centre), (mass, at)):
        d = place - moved
        inertia = inertia + weight * (d @ d * np.eye(3) - np.outer(d, d))
    return Stage(mass=total, centre=moved, inertia=inertia)


def _with_payload(design: Design, body: MassProperties) -> MassProperties:
    """Stage and payload (a point mass at its height), from the middle of the stage's underside."""
    moved = body.moved((0.0, 0.0, -design.derived.drive_surface_height * 1e-3))
    mass = design.payload.mass
    if mass <= 0.0:
        return moved
    height = (design.stage.thickness + design.payload.height) * 1e-3
    nothing = ((0.0, 0.0, 0.0),) * 3
    point = MassProperties(0.0, mass, (0.0, 0.0, height), nothing, moved.bounding_box)
    return combined([moved, point])


def _stage(r: DesignInputs, body: MassProperties) -> Stage:
    whole = Stage(mass=body.mass, centre=np.array(body.centre_of_mass), inertia=np.array(body.inertia))
    if not r.design.teeth.fitted:
        return _with_ballast(whole, r("preload.force") / r("environment.gravity"))
    across = r("teeth.bar_spacing") / 2.0
    return dataclasses.replace(
        whole,
        preload=r("preload.force"),
        guide_stiffness=float(teeth(r).point.lateral_stiffness),
        guide_places=np.array([(0.0, across), (0.0, -across)]),
        guide_length=r("tooth_iron.length"),
    )


def _pads(r: DesignInputs, mass: float, load: float) -> Pads:
    """Pads as springs ``F = K delta^1.5`` with the film's stiffness at the mean load."""
    places = pad_positions(r)
    each = load / len(places)
    stiffness = float(film(r, each).stiffness)
    # A power law through load and stiffness at the mean load: F = K delta^1.5 has the slope 1.5 F/delta.
    depth = 1.5 * each / stiffness
    critical = 2.0 * math.sqrt(len(places) * stiffness * mass)
    damping = r("bearing.damping_ratio") * critical / len(places)
    shear = slip_elements(parabola)[2] * r("bearing.static_friction") * load / r("bearing.presliding_distance")
    return Pads(
        places=places,
        contact_rate=each / depth**1.5,
        damping=damping / each,
        static_friction=r("bearing.static_friction"),
        dynamic_friction=r("bearing.dynamic_friction"),
        stribeck_velocity=r("bearing.stribeck_velocity"),
        presliding=r("bearing.presliding_distance"),
        # Of the stage on the film's shear at rest, as of its bounce: tau = 2 zeta/omega.
        tangential_lag=2.0 * r("bearing.damping_ratio") / math.sqrt(shear / mass),
    )


def _tip(r: DesignInputs, tip: MassProperties) -> Tip:
    """Mass and inertia of the tip from its solid, with the moving part of each stack as a point mass on its axis."""
    places = np.array(r.design.derived.piezo_places) * 1e-3
    moving = r("piezo.moving_mass")
    stiffness = stack_stiffness(r)
    about_plane = np.array(tip.inertia_about((0.0, 0.0, 0.0)))
    mass = tip.mass + PIEZOS * moving
    inertia = 0.5 * (about_plane[0, 0] + about_plane[1, 1]) + moving * float(np.sum(places[:, 0] ** 2))
    damping = 2.0 * r("piezo.damping_ratio") * math.sqrt(PIEZOS * stiffness * mass) / PIEZOS
    return Tip(mass, inertia, r("actuator.tip_height"), places, stiffness, damping)


def _sensors(design: Design) -> Sensors:
    lvdt, probe = design.sensors.lvdt, design.sensors.probe
    filtered, fringe = design.sensors.filtered_probe, design.sensors.interferometer
    return Sensors(
        interferometer_count=fringe.resolution,
        interferometer_speed=fringe.highest_speed,
        probe_range=probe.range,
        probe_noise=probe.resolution,
        probe_bandwidth=probe.bandwidth,
        filter_frequency=filtered.filter_frequency,
        filtered_range=probe.range / filtered.gain,
        filtered_count=float(count_size(probe.range / filtered.gain, filtered.bits)),
        lvdt_count=float(count_size(lvdt.range, lvdt.bits)),
        lvdt_linearity_error=lvdt.linearity * lvdt.range,
    )
