"""Calculators of drive, pads, height adjustment, screws and sensor for `stagecad calc`."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace
from typing import TYPE_CHECKING, Any

from workbench.calculators.catalogue import (
    Calculator,
    Option,
    Values,
    constant,
    from_key,
    from_material,
    from_model,
    quantities,
)
from workbench.cli.options import Run

if TYPE_CHECKING:
    from designcalc.checks.inputs import DesignInputs


def _drive(run: Run, v: Values) -> dict[str, Any]:
    from designcalc.drive import friction_drive as drive
    from designcalc.drive.piezo_stack import piezo_stiffness
    from designcalc.drive.tip_ellipse import frequency_for, tip_ellipse

    path = tip_ellipse(v["amplitude"], v["phase"], v["piezo_spacing"], v["tip_height"])
    needed = frequency_for(v["speed"], path.along)
    first = drive.resonance(v["piezos"] * piezo_stiffness(v["blocking_force"], v["free_stroke"]), v["tip_mass"])
    return quantities(
        travel_along=(path.along, "m"),
        travel_normal=(path.normal, "m"),
        frequency_stopping=(needed["stopping"], "Hz"),
        frequency_coasting=(needed["coasting"], "Hz"),
        frequency_apex=(needed["apex"], "Hz"),
        resonance=(first, "Hz"),
        acceleration_limit=(
            drive.acceleration_limit(v["friction"], v["preload_ratio"], gravity=v["gravity"]),
            "m/s^2",
        ),
        preload_ratio_for_1g=(drive.preload_ratio_for(drive.GRAVITY, v["friction"], v["gravity"]), ""),
    )


def _rise(r: DesignInputs, given: Values) -> float:
    from designcalc.friction_stage.physics.tip_dynamics import usable_ellipse

    return usable_ellipse(r)[1]


def _side_force(r: DesignInputs, given: Values) -> float:
    from designcalc.friction_stage.physics.loads import tip_load

    return r("drive.friction") * tip_load(r)


def _tilt(r: DesignInputs, given: Values) -> float:
    from designcalc.friction_stage.physics.tip_dynamics import tilt_amplitude

    return tilt_amplitude(r)


def _stack(run: Run, v: Values) -> dict[str, Any]:
    from designcalc.drive.piezo_stack import drive_pull, side_load, stack_current, stack_heat, stack_tension

    swing = stack_tension(v["mass"], v["inertia"], v["frequency"], v["rise"], v["tilt"], v["piezo_spacing"])
    push = drive_pull(v["side_force"], v["tip_height"], v["piezo_spacing"])
    bent = side_load(
        v["side_force"] / v["piezos"], v["length"], v["free_length"], v["area"], v["modulus"], v["clearance"]
    )
    return quantities(
        pull_by_inertia=(swing, "N"),
        pull_by_drive=(push, "N"),
        tension=((swing + push) / v["area"], "Pa"),
        bending=(bent.stress, "Pa"),
        end_deflection=(bent.deflection, "m"),
        heat=(stack_heat(v["capacitance"], v["voltage"], v["frequency"], v["loss_factor"]), "W"),
        peak_current=(stack_current(v["capacitance"], v["voltage"], v["frequency"]), "A"),
    )


def _tip_over(run: Run, v: Values) -> dict[str, Any]:
    from designcalc.checks.inputs import DesignInputs
    from designcalc.drive.friction_drive import acceleration_limit, tip_force_limit
    from designcalc.friction_stage.physics.pads import pad_positions

    places = pad_positions(DesignInputs(run.design.values))
    share = tip_force_limit(places, (0.0, 0.0), (-v["position"], 0.0))
    return quantities(
        share_of_load=(share, ""),
        acceleration=(
            acceleration_limit(v["friction"], v["preload_ratio"], share, v["pad_friction"], v["gravity"]),
            "m/s^2",
        ),
        acceleration_before_lift_off=(
            acceleration_limit(v["friction"], v["preload_ratio"], gravity=v["gravity"]),
            "m/s^2",
        ),
    )


def _of_finger(name: str) -> Callable[[DesignInputs, Values], float]:
    """A number of the design's clamp finger."""

    def default(r: DesignInputs, given: Values) -> float:
        from designcalc.friction_stage.physics.clamp import clamp_finger

        return float(getattr(clamp_finger(r), name))

    return default


def _clamp(run: Run, v: Values) -> dict[str, Any]:
    from designcalc.bearing.fastener import preload_of_torque
    from designcalc.checks.inputs import DesignInputs
    from designcalc.drive.height_adjustment import clamp_shift
    from designcalc.friction_stage.physics.clamp import clamp_finger

    changed = {name: v[name] for name in ("neck", "screw_lever", "press_lever", "modulus", "poisson")}
    finger = replace(clamp_finger(DesignInputs(run.design.values)), **changed)
    force = float(preload_of_torque(v["torque"], v["screw_diameter"], v["nut_factor"]))
    gap = v["play"] / 2 * (1 + math.cos(v["press_angle"]))
    press = finger.press_force(force, gap)
    rim = 2 * press * (1 + math.cos(v["press_angle"]))
    names = ("holder_diameter", "holder_height", "play", "apex_height", "modulus", "poisson")
    shift = clamp_shift(rim, *(v[name] for name in names))
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


def _pads(run: Run, v: Values) -> dict[str, Any]:
    from designcalc.contact.film import confined_modulus, film_contact
    from designcalc.contact.hertz import contact_modulus

    bodies = contact_modulus(v["pad_modulus"], v["pad_poisson"], v["way_modulus"], v["way_poisson"])
    film = confined_modulus(v["film_modulus"], v["film_poisson"])
    contact = film_contact(v["load"], v["crown_radius"], v["film_thickness"], film, float(bodies))
    return quantities(
        contact_radius=(contact.radius, "m"),
        peak_pressure=(contact.peak_pressure, "Pa"),
        film_indentation=(contact.indentation, "m"),
        stiffness=(contact.stiffness, "N/m"),
    )


def _wedge(run: Run, v: Values) -> dict[str, Any]:
    from designcalc.drive.height_adjustment import wedge_drive

    wedge = wedge_drive(v["pitch"], v["slope"], v["stroke"])
    return quantities(
        lift_per_turn=(wedge.lift_per_turn, "m"),
        lift_per_degree=(wedge.lift_per_degree, "m"),
        range=(wedge.range, "m"),
        locking_friction=(wedge.locking_friction, ""),
    )


def _screw(run: Run, v: Values) -> dict[str, Any]:
    from designcalc.bearing.fastener import (
        Thread,
        preload_of_torque,
        strip_area_of_bed,
        strip_area_of_screw,
    )

    thread = Thread(v["diameter"], v["pitch"])
    force = preload_of_torque(v["torque"], v["diameter"], v["nut_factor"])
    return quantities(
        preload=(force, "N"),
        stress=(force / thread.stress_area, "Pa"),
        stress_area=(thread.stress_area, "m^2"),
        bed_strip_stress=(force / strip_area_of_bed(thread, v["engagement"]), "Pa"),
        screw_strip_stress=(force / strip_area_of_screw(thread, v["engagement"]), "Pa"),
    )


def _probe(run: Run, v: Values) -> dict[str, Any]:
    from designcalc.errors.sensors import count_size, filtered_noise, velocity_noise

    count = count_size(v["range"] / v["gain"], v["bits"])
    return quantities(
        noise=(filtered_noise(v["noise"], v["bandwidth"], v["cutoff"]), "m"),
        range=(v["range"] / v["gain"], "m"),
        count=(count, "m"),
        velocity_noise=(velocity_noise(count, v["rate"]), "m/s"),
    )


DRIVE_CALCULATORS: dict[str, Calculator] = {
    "drive": Calculator(
        "Tip ellipse, frequency for a speed by three laws, first resonance, acceleration before lift-off.",
        {
            "amplitude": Option("m", "of a piezo, zero to peak", from_key("actuator.stroke_amplitude")),
            "phase": Option("rad", "between the piezos", from_key("actuator.phase")),
            "piezo_spacing": Option("m", "D", from_key("actuator.piezo_spacing")),
            "tip_height": Option("m", "h", from_key("actuator.tip_height")),
            "speed": Option("m/s", "of the stage", from_key("requirements.speed")),
            "tip_mass": Option("kg", "with its share of the stacks", from_model("tip_dynamics", "mass_on_piezos")),
            "piezos": Option("", "under the tip", constant(3.0)),
            "blocking_force": Option("N", "of a piezo", from_key("piezo.blocking_force")),
            "free_stroke": Option("m", "of a piezo", from_key("piezo.stroke")),
            "friction": Option("", "between tip and stage", from_key("drive.friction")),
            "preload_ratio": Option("", "preload over weight", from_model("loads", "preload_ratio")),
            "gravity": Option("m/s^2", "", from_key("environment.gravity")),
        },
        _drive,
    ),
    "stack": Calculator(
        "Load of one piezo stack by the drive: tension by inertia and drive force, bending, heat, current.",
        {
            "mass": Option("kg", "that swings on the stacks", from_model("tip_dynamics", "mass_on_piezos")),
            "frequency": Option("Hz", "of the drive", from_key("actuator.frequency")),
            "inertia": Option(
                "kg*m^2", "of the same about the stacks' ends", from_model("tip_dynamics", "inertia_on_piezos")
            ),
            "rise": Option("m", "of the tip, peak to peak", _rise),
            "tilt": Option("rad", "amplitude of the tip's rocking", _tilt),
            "side_force": Option("N", "of the tip on the stage", _side_force),
            "tip_height": Option("m", "h", from_key("actuator.tip_height")),
            "piezo_spacing": Option("m", "D", from_key("actuator.piezo_spacing")),
            "piezos": Option("", "that share the side force", constant(3.0)),
            "length": Option("m", "of a stack", from_key("piezo.length")),
            "free_length": Option(
                "m",
                "proud of its bore",
                lambda r, given: r("piezo.length") + r("holder.floor") - r("holder.height"),
            ),
            "area": Option("m^2", "of the ceramic element", from_key("piezo.element_area")),
            "modulus": Option("Pa", "of the ceramic", from_material("piezo", "youngs_modulus")),
            "clearance": Option(
                "m",
                "in its bore, on the radius",
                lambda r, given: (r("holder.bore_diameter") - r("piezo.diameter")) / 2,
            ),
            "capacitance": Option("F", "", from_key("piezo.capacitance")),
            "voltage": Option("V", "peak to peak", from_key("piezo.highest_voltage")),
            "loss_factor": Option("", "tan(delta)", from_key("piezo.loss_factor")),
        },
        _stack,
    ),
    "tip-over": Calculator(
        "Largest load on the tip and largest push with the stage off the middle of its travel, before a pad lifts.",
        {
            "position": Option("m", "of the stage from the middle", lambda r, given: r("stage.travel") / 2),
            "friction": Option("", "between tip and stage", from_key("drive.friction")),
            "pad_friction": Option("", "of the pads", from_key("bearing.dynamic_friction")),
            "preload_ratio": Option("", "preload over weight", from_model("loads", "preload_ratio")),
            "gravity": Option("m/s^2", "", from_key("environment.gravity")),
        },
        _tip_over,
    ),
    "clamp": Calculator(
        "The clamp: play closed, force on the actuator, stress of its neck, shift of the tip.",
        {
            "torque": Option("N*m", "of the clamp screw", from_key("screws.clamp_long.torque")),
            "screw_diameter": Option("m", "", from_key("screws.clamp_long.diameter")),
            "nut_factor": Option("", "", from_key("screws.clamp_long.nut_factor")),
            "neck": Option("m", "thickness of the neck", from_key("base.clamp_neck")),
            "screw_lever": Option("m", "of the screw about the neck", _of_finger("screw_lever")),
            "press_lever": Option("m", "of the force on the actuator about the neck", _of_finger("press_lever")),
            "press_angle": Option(
                "rad", "of that force from the screw's direction", from_model("clamp", "press_angle")
            ),
            "holder_diameter": Option("m", "", from_key("holder.diameter")),
            "holder_height": Option("m", "", from_key("holder.height")),
            "play": Option(
                "m",
                "of the holder in its pocket",
                lambda r, given: r("base.pocket_diameter") - given["holder_diameter"],
            ),
            "apex_height": Option(
                "m",
                "of the tip over the holder's foot",
                lambda r, given: r("holder.floor") + r("piezo.length") + r("actuator.tip_height"),
            ),
            "modulus": Option("Pa", "of base and holder", from_material("base", "youngs_modulus")),
            "poisson": Option("", "of base and holder", from_material("base", "poisson_ratio")),
        },
        _clamp,
    ),
    "pads": Calculator(
        "A crowned pad with its thin film on the way: spot, pressure, stiffness.",
        {
            "load": Option("N", "of the pad", from_model("pads", "heaviest_pad")),
            "crown_radius": Option("m", "of the pad", from_key("pads.crown_radius")),
            "film_thickness": Option("m", "of the PTFE", from_key("bearing.film_thickness")),
            "film_modulus": Option("Pa", "of the PTFE", from_key("materials.ptfe.youngs_modulus")),
            "film_poisson": Option("", "of the PTFE", from_key("materials.ptfe.poisson_ratio")),
            "pad_modulus": Option("Pa", "of the pad", from_material("stage", "youngs_modulus")),
            "pad_poisson": Option("", "of the pad", from_material("stage", "poisson_ratio")),
            "way_modulus": Option("Pa", "of the way", from_material("bearing_way", "youngs_modulus")),
            "way_poisson": Option("", "of the way", from_material("bearing_way", "poisson_ratio")),
        },
        _pads,
    ),
    "wedge": Calculator(
        "Lift of the height pins per turn and degree of the set screw, range, self-locking.",
        {
            "pitch": Option("m", "of the set screw", from_key("set_screw.pitch")),
            "slope": Option("", "rise over run", from_key("height_pin_1.slope")),
            "stroke": Option("m", "of pin 1", from_key("height_pin_1.stroke")),
        },
        _wedge,
    ),
    "screw": Calculator(
        "Preload of a way screw from its torque, and the stresses of thread and shank.",
        {
            "diameter": Option("m", "of the thread", from_key("screws.way.diameter")),
            "pitch": Option("m", "of the thread", from_key("screws.way.pitch")),
            "torque": Option("N*m", "", from_key("screws.way.torque")),
            "nut_factor": Option("", "0.1 greased to 0.3 dry", from_key("screws.way.nut_factor")),
            "engagement": Option(
                "m", "of the thread", lambda r, given: r("screws.way.length") - r("bearing_way.flange_thickness")
            ),
        },
        _screw,
    ),
    "probe": Calculator(
        "Capacitive probe behind filter, gain and converter: noise, range, count.",
        {
            "noise": Option("m", "within the bandwidth", from_key("sensors.probe.resolution")),
            "bandwidth": Option("Hz", "of the probe", from_key("sensors.probe.bandwidth")),
            "cutoff": Option("Hz", "of the filter", from_key("sensors.filtered_probe.filter_frequency")),
            "range": Option("m", "of the probe", from_key("sensors.probe.range")),
            "gain": Option("", "after the filter", from_key("sensors.filtered_probe.gain")),
            "bits": Option("", "of the converter", from_key("sensors.filtered_probe.bits")),
            "rate": Option("Hz", "of sampling, for the velocity", constant(1000.0)),
        },
        _probe,
    ),
}
"""Calculators by their name in `stagecad calc`."""
