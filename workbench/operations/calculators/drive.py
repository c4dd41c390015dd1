"""Calculators of drive, pads, height adjustment, screws and sensor."""

import math
from dataclasses import dataclass, replace
from typing import Annotated, Any

from designcalc.bearing.fastener import Thread, preload_of_torque, strip_area_of_bed, strip_area_of_screw
from designcalc.checks.check import DesignInputs
from designcalc.contact.film import confined_modulus, film_contact
from designcalc.contact.hertz import contact_modulus
from designcalc.drive import friction_drive, height_adjustment, piezo_stack, tip_ellipse
from designcalc.errors.sensors import count_size, filtered_noise, velocity_noise
from designcalc.friction_stage.physics import clamp, pads, tip_dynamics
from workbench.operations.calculators.declaration import quantities


@dataclass(frozen=True)
class Drive:
    """Tip ellipse, frequency for a speed by three laws, first resonance, acceleration before lift-off."""

    amplitude: Annotated[float, "m", "of a piezo, zero to peak", "actuator.stroke_amplitude"]
    phase: Annotated[float, "rad", "between the piezos", "actuator.phase"]
    piezo_spacing: Annotated[float, "m", "D", "actuator.piezo_spacing"]
    tip_height: Annotated[float, "m", "h", "actuator.tip_height"]
    speed: Annotated[float, "m/s", "of the stage", "requirements.speed"]
    tip_mass: Annotated[float, "kg", "with its share of the stacks", "mass.on_piezos"]
    piezos: Annotated[float, "", "under the tip", 3.0]
    blocking_force: Annotated[float, "N", "of a piezo", "piezo.blocking_force"]
    free_stroke: Annotated[float, "m", "of a piezo", "piezo.stroke"]
    friction: Annotated[float, "", "between tip and stage", "drive.friction"]
    preload_ratio: Annotated[float, "", "preload over weight", "load.preload/load.weight"]
    gravity: Annotated[float, "m/s^2", "", "environment.gravity"]

    def results(self, r: DesignInputs) -> dict[str, Any]:
        path = tip_ellipse.tip_ellipse(self.amplitude, self.phase, self.piezo_spacing, self.tip_height)
        needed = tip_ellipse.frequency_for(self.speed, path.along)
        stiffness = self.piezos * piezo_stack.piezo_stiffness(self.blocking_force, self.free_stroke)
        limit = friction_drive.acceleration_limit(self.friction, self.preload_ratio, gravity=self.gravity)
        ratio = friction_drive.preload_ratio_for(friction_drive.GRAVITY, self.friction, self.gravity)
        return quantities(
            travel_along=(path.along, "m"),
            travel_normal=(path.normal, "m"),
            frequency_stopping=(needed["stopping"], "Hz"),
            frequency_coasting=(needed["coasting"], "Hz"),
            frequency_apex=(needed["apex"], "Hz"),
            resonance=(friction_drive.resonance(stiffness, self.tip_mass), "Hz"),
            acceleration_limit=(limit, "m/s^2"),
            preload_ratio_for_1g=(ratio, ""),
        )


@dataclass(frozen=True)
class Stack:
    """Load of one piezo stack by the drive: tension by inertia and drive force, bending, heat, current."""

    mass: Annotated[float, "kg", "that swings on the stacks", "mass.on_piezos"]
    frequency: Annotated[float, "Hz", "of the drive", "actuator.frequency"]
    inertia: Annotated[float, "kg*m^2", "of the same about the stacks' ends", "inertia.on_piezos"]
    rise: Annotated[float, "m", "of the tip, peak to peak", "ellipse.rise"]
    tilt: Annotated[
        float,
        "rad",
        "amplitude of the tip's rocking",
        lambda r, _: tip_dynamics.usable_ellipse(r)[0] / 2 / r("actuator.tip_height"),
    ]
    side_force: Annotated[float, "N", "of the tip on the stage", "drive.friction*load.of_tip"]
    tip_height: Annotated[float, "m", "h", "actuator.tip_height"]
    piezo_spacing: Annotated[float, "m", "D", "actuator.piezo_spacing"]
    piezos: Annotated[float, "", "that share the side force", 3.0]
    length: Annotated[float, "m", "of a stack", "piezo.length"]
    free_length: Annotated[float, "m", "proud of its bore", "piezo.length + holder.floor - holder.height"]
    area: Annotated[float, "m^2", "of the ceramic element", "piezo.element_area"]
    modulus: Annotated[float, "Pa", "of the ceramic", "piezo:youngs_modulus"]
    clearance: Annotated[float, "m", "in its bore, on the radius", "(holder.bore_diameter - piezo.diameter)/2"]
    capacitance: Annotated[float, "F", "", "piezo.capacitance"]
    voltage: Annotated[float, "V", "peak to peak", "piezo.highest_voltage"]
    loss_factor: Annotated[float, "", "tan(delta)", "piezo.loss_factor"]

    def results(self, r: DesignInputs) -> dict[str, Any]:
        swing = piezo_stack.stack_tension(
            self.mass, self.inertia, self.frequency, self.rise, self.tilt, self.piezo_spacing
        )
        push = piezo_stack.drive_pull(self.side_force, self.tip_height, self.piezo_spacing)
        share = self.side_force / self.piezos
        bent = piezo_stack.side_load(share, self.length, self.free_length, self.area, self.modulus, self.clearance)
        return quantities(
            pull_by_inertia=(swing, "N"),
            pull_by_drive=(push, "N"),
            tension=((swing + push) / self.area, "Pa"),
            bending=(bent.stress, "Pa"),
            end_deflection=(bent.deflection, "m"),
            heat=(piezo_stack.stack_heat(self.capacitance, self.voltage, self.frequency, self.loss_factor), "W"),
            peak_current=(piezo_stack.stack_current(self.capacitance, self.voltage, self.frequency), "A"),
        )


@dataclass(frozen=True)
class TipOver:
    """Largest load on the tip and largest push with the stage off the middle of its travel, before a pad lifts."""

    position: Annotated[float, "m", "of the stage from the middle", "stage.travel/2"]
    friction: Annotated[float, "", "between tip and stage", "drive.friction"]
    pad_friction: Annotated[float, "", "of the pads", "bearing.dynamic_friction"]
    preload_ratio: Annotated[float, "", "preload over weight", "load.preload/load.weight"]
    gravity: Annotated[float, "m/s^2", "", "environment.gravity"]

    def results(self, r: DesignInputs) -> dict[str, Any]:
        share = friction_drive.tip_force_limit(pads.pad_positions(r), (0.0, 0.0), (-self.position, 0.0))
        limit = friction_drive.acceleration_limit
        pushed = limit(self.friction, self.preload_ratio, share, self.pad_friction, self.gravity)
        lifted = limit(self.friction, self.preload_ratio, gravity=self.gravity)
        return quantities(
            share_of_load=(share, ""), acceleration=(pushed, "m/s^2"), acceleration_before_lift_off=(lifted, "m/s^2")
        )


@dataclass(frozen=True)
class Clamp:
    """The clamp: play closed, force on the actuator, stress of its neck, shift of the tip."""

    torque: Annotated[float, "N*m", "of the clamp screw", "screws.clamp_long.torque"]
    screw_diameter: Annotated[float, "m", "", "screws.clamp_long.diameter"]
    nut_factor: Annotated[float, "", "", "screws.clamp_long.nut_factor"]
    neck: Annotated[float, "m", "thickness of the neck", "base.clamp_neck"]
    screw_lever: Annotated[float, "m", "of the screw about the neck", lambda r, _: clamp.clamp_finger(r).screw_lever]
    press_lever: Annotated[
        float, "m", "of the force on the actuator about the neck", lambda r, _: clamp.clamp_finger(r).press_lever
    ]
    press_angle: Annotated[float, "rad", "of that force from the screw's direction", "angle.of_finger"]
    holder_diameter: Annotated[float, "m", "", "holder.diameter"]
    holder_height: Annotated[float, "m", "", "holder.height"]
    play: Annotated[float, "m", "of the holder in its pocket", "base.pocket_diameter - option.holder_diameter"]
    apex_height: Annotated[
        float, "m", "of the tip over the holder's foot", "holder.floor + piezo.length + actuator.tip_height"
    ]
    modulus: Annotated[float, "Pa", "of base and holder", "base:youngs_modulus"]
    poisson: Annotated[float, "", "of base and holder", "base:poisson_ratio"]

    def results(self, r: DesignInputs) -> dict[str, Any]:
        changed = {name: getattr(self, name) for name in ("neck", "screw_lever", "press_lever", "modulus", "poisson")}
        finger = replace(clamp.clamp_finger(r), **changed)
        force = float(preload_of_torque(self.torque, self.screw_diameter, self.nut_factor))
        gap = self.play / 2 * (1 + math.cos(self.press_angle))
        press = finger.press_force(force, gap)
        rim = 2 * press * (1 + math.cos(self.press_angle))
        holder = (self.holder_diameter, self.holder_height, self.play, self.apex_height)
        shift = height_adjustment.clamp_shift(rim, *holder, self.modulus, self.poisson)
        return quantities(
            screw_force=(force, "N"),
            gap=(gap, "m"),
            closure=(finger.closure * force, "m"),
            press_force=(press, "N"),
            neck_stress=(finger.stress(force, press), "Pa"),
            neck_stress_without_actuator=(finger.stress(force), "Pa"),
            squeeze=(shift.squeeze, "m"),
            drop=(shift.drop, "m"),
            sideways=(shift.sideways, "m"),
        )


@dataclass(frozen=True)
class Pads:
    """A crowned pad with its thin film on the way: spot, pressure, stiffness."""

    load: Annotated[float, "N", "of the pad", "load.heaviest_pad"]
    crown_radius: Annotated[float, "m", "of the pad", "pads.crown_radius"]
    film_thickness: Annotated[float, "m", "of the PTFE", "bearing.film_thickness"]
    film_modulus: Annotated[float, "Pa", "of the PTFE", "materials.ptfe.youngs_modulus"]
    film_poisson: Annotated[float, "", "of the PTFE", "materials.ptfe.poisson_ratio"]
    pad_modulus: Annotated[float, "Pa", "of the pad", "stage:youngs_modulus"]
    pad_poisson: Annotated[float, "", "of the pad", "stage:poisson_ratio"]
    way_modulus: Annotated[float, "Pa", "of the way", "bearing_way:youngs_modulus"]
    way_poisson: Annotated[float, "", "of the way", "bearing_way:poisson_ratio"]

    def results(self, r: DesignInputs) -> dict[str, Any]:
        bodies = float(contact_modulus(self.pad_modulus, self.pad_poisson, self.way_modulus, self.way_poisson))
        film = confined_modulus(self.film_modulus, self.film_poisson)
        contact = film_contact(self.load, self.crown_radius, self.film_thickness, film, bodies)
        return quantities(
            contact_radius=(contact.radius, "m"),
            peak_pressure=(contact.peak_pressure, "Pa"),
            film_indentation=(contact.indentation, "m"),
            stiffness=(contact.stiffness, "N/m"),
        )


@dataclass(frozen=True)
class Wedge:
    """Lift of the height pins per turn and degree of the set screw, range, self-locking."""

    pitch: Annotated[float, "m", "of the set screw", "set_screw.pitch"]
    slope: Annotated[float, "", "rise over run", "height_pin_1.slope"]
    stroke: Annotated[float, "m", "of pin 1", "height_pin_1.stroke"]

    def results(self, r: DesignInputs) -> dict[str, Any]:
        wedge = height_adjustment.wedge_drive(self.pitch, self.slope, self.stroke)
        return quantities(
            lift_per_turn=(wedge.lift_per_turn, "m"),
            lift_per_degree=(wedge.lift_per_degree, "m"),
            range=(wedge.range, "m"),
            locking_friction=(wedge.locking_friction, ""),
        )


@dataclass(frozen=True)
class Screw:
    """Preload of a way screw from its torque, and the stresses of thread and shank."""

    diameter: Annotated[float, "m", "of the thread", "screws.way.diameter"]
    pitch: Annotated[float, "m", "of the thread", "screws.way.pitch"]
    torque: Annotated[float, "N*m", "", "screws.way.torque"]
    nut_factor: Annotated[float, "", "0.1 greased to 0.3 dry", "screws.way.nut_factor"]
    engagement: Annotated[float, "m", "of the thread", "screws.way.length - bearing_way.flange_thickness"]

    def results(self, r: DesignInputs) -> dict[str, Any]:
        thread = Thread(self.diameter, self.pitch)
        force = preload_of_torque(self.torque, self.diameter, self.nut_factor)
        return quantities(
            preload=(force, "N"),
            stress=(force / thread.stress_area, "Pa"),
            stress_area=(thread.stress_area, "m^2"),
            bed_strip_stress=(force / strip_area_of_bed(thread, self.engagement), "Pa"),
            screw_strip_stress=(force / strip_area_of_screw(thread, self.engagement), "Pa"),
        )


@dataclass(frozen=True)
class Probe:
    """Capacitive probe behind filter, gain and converter: noise, range, count."""

    noise: Annotated[float, "m", "within the bandwidth", "sensors.probe.resolution"]
    bandwidth: Annotated[float, "Hz", "of the probe", "sensors.probe.bandwidth"]
    cutoff: Annotated[float, "Hz", "of the filter", "sensors.filtered_probe.filter_frequency"]
    range: Annotated[float, "m", "of the probe", "sensors.probe.range"]
    gain: Annotated[float, "", "after the filter", "sensors.filtered_probe.gain"]
    bits: Annotated[float, "", "of the converter", "sensors.filtered_probe.bits"]
    rate: Annotated[float, "Hz", "of sampling, for the velocity", 1000.0]

    def results(self, r: DesignInputs) -> dict[str, Any]:
        count = count_size(self.range / self.gain, self.bits)  # pyright: ignore[reportArgumentType]
        return quantities(
            noise=(filtered_noise(self.noise, self.bandwidth, self.cutoff), "m"),
            range=(self.range / self.gain, "m"),
            count=(count, "m"),
            velocity_noise=(velocity_noise(count, self.rate), "m/s"),
        )
