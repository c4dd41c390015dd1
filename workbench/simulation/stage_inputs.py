"""The stage's simulation model, read off the design and its mass properties."""

from __future__ import annotations

import dataclasses
import math

import numpy as np

from designcalc.bearing.sliding import confined_modulus, film_contact
from designcalc.contact.hertz import contact_modulus, point_contact
from designcalc.drive.friction_drive import piezo_stiffness
from designcalc.drive.magnetic_teeth import MagnetCircuit, teeth_field, working_point
from designcalc.errors.sensors import count_size
from sim.stage.machine import Contact, Pads, Piezo, Sensors, Stage, StageMachine, Tip
from sim.stage.slip_elements import parabola, slip_elements
from stagecad.parameters.design import Design
from stagecad.parameters.mass_properties import MassProperties, combined


def stage_machine(design: Design, body: MassProperties, tip: MassProperties) -> StageMachine:
    """The machine as it is simulated.

    Args:
        design: the parameter file.
        body: of stage, irons and magnets, in the assembly's coordinates at mid-travel.
        tip: of the tip, in its own coordinates (the piezos' ends at height zero).

    Without teeth the preload is a dead weight in the middle of the stage, and there is nothing that guides it.
    """
    si = design.si
    sea = design.derived.sea_height * 1e-3
    body_in_all = _with_payload(design, body, sea)
    load = body_in_all.mass * si("environment.gravity") + (si("preload.force") if design.teeth.fitted else 0.0)
    return StageMachine(
        stage=_stage(design, body_in_all),
        pads=_pads(design, body_in_all.mass, load),
        tip=_tip(design, tip),
        contact=_contact(design),
        piezo=Piezo(
            stroke=si("piezo.stroke"),
            highest_voltage=si("piezo.highest_voltage"),
            bias=si("actuator.bias_voltage"),
            hysteresis=si("piezo.hysteresis"),
            creep=si("piezo.creep"),
            capacitance=si("piezo.capacitance"),
            current=si("amplifier.current"),
            slew_rate=si("amplifier.slew_rate"),
            bandwidth=si("amplifier.bandwidth"),
            bits=design.amplifier.bits,
        ),
        sensors=_sensors(design),
        actuators=np.array(design.derived.fitted_places) * 1e-3,
        travel=si("stage.travel"),
        gravity=si("environment.gravity"),
    )


def driven_alone(design: Design, machine: StageMachine) -> StageMachine:
    """The machine on actuator 1 only."""
    return dataclasses.replace(machine, actuators=np.array(design.derived.actuator_places[:1]) * 1e-3)


def driven_by_three(design: Design, machine: StageMachine) -> StageMachine:
    """The machine on three actuators, without teeth: its preload is a dead weight, and nothing guides it."""
    ballast = machine.stage.preload / machine.gravity
    places = np.array(design.derived.actuator_places) * 1e-3
    return dataclasses.replace(machine, stage=_point_added(machine.stage, ballast), actuators=places)


def _point_added(stage: Stage, mass: float) -> Stage:
    centre = np.asarray(stage.centre, dtype=float)
    total = stage.mass + mass
    # The ballast sits in the middle of the stage at its centre's height.
    at = np.array([0.0, 0.0, centre[2]])
    moved = (stage.mass * centre + mass * at) / total
    inertia = np.array(stage.inertia, dtype=float)
    for weight, place in ((stage.mass, centre), (mass, at)):
        d = place - moved
        inertia = inertia + weight * (d @ d * np.eye(3) - np.outer(d, d))
    return Stage(mass=total, centre=moved, inertia=inertia)


def _with_payload(design: Design, body: MassProperties, sea: float) -> MassProperties:
    """Stage and payload (a point mass at its height), about the middle of the stage on the sea."""
    moved = body.moved((0.0, 0.0, -sea))
    mass = design.payload.mass
    if mass <= 0.0:
        return moved
    height = (design.stage.thickness + design.payload.height) * 1e-3
    nothing = ((0.0, 0.0, 0.0),) * 3
    point = MassProperties(0.0, mass, (0.0, 0.0, height), nothing, moved.bounding_box)
    return combined([moved, point])


def _modulus(design: Design, first: str, second: str) -> float:
    """Contact modulus of two parts, Pa."""
    one, two = (design.materials[design.value(f"{part}.material")] for part in (first, second))
    return float(contact_modulus(one.youngs_modulus, one.poisson_ratio, two.youngs_modulus, two.poisson_ratio))


def _stage(design: Design, body: MassProperties) -> Stage:
    si = design.si
    whole = Stage(mass=body.mass, centre=np.array(body.centre_of_mass), inertia=np.array(body.inertia))
    if not design.teeth.fitted:
        return _point_added(whole, si("preload.force") / si("environment.gravity"))
    pitch, width, length = si("teeth.pitch"), si("teeth.width"), si("tooth_iron.length")
    field = teeth_field(pitch, width, si("teeth.gap"), si("teeth.groove_depth"))
    circuit = MagnetCircuit(
        remanence=si("magnet.remanence"),
        thickness=si("magnet.thickness"),
        area=si("magnet.length") * si("magnet.height"),
        recoil_permeability=si("magnet.recoil_permeability"),
        gap_area=length * si("teeth.per_iron") * pitch,
        gaps=2,
    )
    across = si("teeth.bar_spacing") / 2.0
    return dataclasses.replace(
        whole,
        preload=si("preload.force"),
        guide_stiffness=float(working_point(field, circuit, pitch, width).lateral_stiffness),
        guide_places=np.array([(0.0, across), (0.0, -across)]),
        guide_length=length,
    )


def _pads(design: Design, mass: float, load: float) -> Pads:
    si = design.si
    places = np.array(design.derived.pad_places) * 1e-3
    each = load / len(places)
    ptfe = design.materials["ptfe"]
    film = film_contact(
        each,
        si("pads.crown_radius"),
        si("bearing.film_thickness"),
        confined_modulus(ptfe.youngs_modulus, ptfe.poisson_ratio),
        _modulus(design, "stage", "bearing_way"),
    )
    stiffness = float(film.stiffness)
    # A power law through load and stiffness at the mean load: F = K delta^1.5 has the slope 1.5 F/delta.
    depth = 1.5 * each / stiffness
    critical = 2.0 * math.sqrt(len(places) * stiffness * mass)
    damping = si("bearing.damping_ratio") * critical / len(places)
    shear = slip_elements(parabola)[2] * si("bearing.static_friction") * load / si("bearing.presliding_distance")
    return Pads(
        places=places,
        contact_rate=each / depth**1.5,
        damping=damping / each,
        static_friction=si("bearing.static_friction"),
        dynamic_friction=si("bearing.dynamic_friction"),
        stribeck_velocity=si("bearing.stribeck_velocity"),
        presliding=si("bearing.presliding_distance"),
        # Of the stage on the film's shear at rest, as of its bounce: tau = 2 zeta/omega.
        tangential_lag=2.0 * si("bearing.damping_ratio") / math.sqrt(shear / mass),
    )


def _tip(design: Design, tip: MassProperties) -> Tip:
    si = design.si
    places = np.array(design.derived.piezo_places) * 1e-3
    moving = si("piezo.moving_mass")
    stiffness = float(piezo_stiffness(si("piezo.blocking_force"), si("piezo.stroke")))
    about_plane = np.array(tip.inertia_about((0.0, 0.0, 0.0)))
    mass = tip.mass + 3.0 * moving
    inertia = 0.5 * (about_plane[0, 0] + about_plane[1, 1]) + moving * float(np.sum(places[:, 0] ** 2))
    damping = 2.0 * si("piezo.damping_ratio") * math.sqrt(3.0 * stiffness * mass) / 3.0
    return Tip(mass, inertia, si("actuator.tip_height"), places, stiffness, damping)


def _contact(design: Design) -> Contact:
    """Nose of the tip on the sea: Hertz across it, Mindlin along it; of two Poisson's ratios their mean."""
    touch = point_contact(1.0, design.si("tip.nose_radius"), np.inf, _modulus(design, "tip", "stage"))
    nu = 0.5 * sum(design.materials[design.value(f"{part}.material")].poisson_ratio for part in ("tip", "stage"))
    return Contact(
        rate=float(touch.load / touch.approach**1.5),
        damping=1.5 * design.si("drive.impact_loss"),
        friction=design.si("drive.friction"),
        tangential_ratio=2.0 * (1.0 - nu) / (2.0 - nu),
    )


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
