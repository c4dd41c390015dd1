"""Calculators of drive, pads, height adjustment, screws and sensor for `stagecad calc`."""

from __future__ import annotations

from typing import Any

from stagecad.parameters.quantities import as_json
from workbench.calculators import Calculator, Option, Values, constant, from_key, from_material
from workbench.options import Run


def _quantities(**named: tuple[object, str]) -> dict[str, Any]:
    """Results as JSON quantities, from (value, SI unit)."""
    return {name: as_json(float(value), unit) for name, (value, unit) in named.items()}  # type: ignore[arg-type]


def _drive(run: Run, v: Values) -> dict[str, Any]:
    from designcalc import friction_drive as drive

    path = drive.tip_ellipse(v["amplitude"], v["phase"], v["piezo_spacing"], v["tip_height"])
    needed = drive.frequency_for(v["speed"], path.along)
    first = drive.resonance(v["piezos"] * drive.piezo_stiffness(v["blocking_force"], v["free_stroke"]), v["tip_mass"])
    return _quantities(
        travel_along=(path.along, "m"),
        travel_normal=(path.normal, "m"),
        frequency_stopping=(needed["stopping"], "Hz"),
        frequency_coasting=(needed["coasting"], "Hz"),
        frequency_apex=(needed["apex"], "Hz"),
        resonance=(first, "Hz"),
        acceleration_limit=(drive.acceleration_limit(v["friction"], v["preload_ratio"]), "m/s^2"),
        preload_ratio_for_1g=(drive.preload_ratio_for(drive.GRAVITY, v["friction"]), ""),
    )


def _pads(run: Run, v: Values) -> dict[str, Any]:
    from designcalc.hertz import contact_modulus
    from designcalc.sliding_bearing import confined_modulus, film_contact

    bodies = contact_modulus(v["pad_modulus"], v["pad_poisson"], v["way_modulus"], v["way_poisson"])
    film = confined_modulus(v["film_modulus"], v["film_poisson"])
    contact = film_contact(v["load"], v["crown_radius"], v["film_thickness"], film, float(bodies))
    return _quantities(
        contact_radius=(contact.radius, "m"),
        peak_pressure=(contact.peak_pressure, "Pa"),
        film_indentation=(contact.indentation, "m"),
        stiffness=(contact.stiffness, "N/m"),
    )


def _wedge(run: Run, v: Values) -> dict[str, Any]:
    from designcalc.height_adjustment import wedge_drive

    wedge = wedge_drive(v["pitch"], v["slope"], v["stroke"])
    return _quantities(
        lift_per_turn=(wedge.lift_per_turn, "m"),
        lift_per_degree=(wedge.lift_per_degree, "m"),
        range=(wedge.range, "m"),
        locking_friction=(wedge.locking_friction, ""),
    )


def _screw(run: Run, v: Values) -> dict[str, Any]:
    from designcalc.fastener import (
        UnifiedThread,
        preload_of_torque,
        strip_area_of_bed,
        strip_area_of_screw,
    )

    thread = UnifiedThread(v["diameter"], v["pitch"])
    force = preload_of_torque(v["torque"], v["diameter"], v["nut_factor"])
    return _quantities(
        preload=(force, "N"),
        stress=(force / thread.stress_area, "Pa"),
        stress_area=(thread.stress_area, "m^2"),
        bed_strip_stress=(force / strip_area_of_bed(thread, v["engagement"]), "Pa"),
        screw_strip_stress=(force / strip_area_of_screw(thread, v["engagement"]), "Pa"),
    )


def _probe(run: Run, v: Values) -> dict[str, Any]:
    from designcalc.sensors import count_size, filtered_noise, velocity_noise

    count = count_size(v["range"] / v["gain"], v["bits"])
    return _quantities(
        noise=(filtered_noise(v["noise"], v["bandwidth"], v["cutoff"]), "m"),
        range=(v["range"] / v["gain"], "m"),
        count=(count, "m"),
        velocity_noise=(velocity_noise(count, v["rate"]), "m/s"),
    )


DRIVE_CALCULATORS: dict[str, Calculator] = {
    "drive": Calculator(
        "Tip ellipse, the frequency a speed needs by three laws, first resonance, acceleration without lift-off.",
        {
            "amplitude": Option("m", "of a piezo, zero to peak", from_key("actuator.stroke_amplitude")),
            "phase": Option("rad", "between the piezos", from_key("actuator.phase")),
            "piezo_spacing": Option("m", "D", from_key("actuator.piezo_spacing")),
            "tip_height": Option("m", "h", from_key("actuator.tip_height")),
            "speed": Option("m/s", "of the stage", from_key("requirements.speed")),
            "tip_mass": Option("kg", "with its share of the stacks", from_key("tip.mass_limit")),
            "piezos": Option("", "under the tip", constant(3.0)),
            "blocking_force": Option("N", "of a piezo", from_key("piezo.blocking_force")),
            "free_stroke": Option("m", "of a piezo", from_key("piezo.stroke")),
            "friction": Option("", "between tip and stage", from_key("drive.friction")),
            "preload_ratio": Option("", "preload over weight", from_key("preload.ratio")),
        },
        _drive,
    ),
    "pads": Calculator(
        "A crowned pad with its thin film on the way: spot, pressure, stiffness.",
        {
            "load": Option("N", "of the pad", constant(10.0)),
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
            "nut_factor": Option("", "0.1 greased to 0.3 dry", constant(0.2)),
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
"""By the name they are called with."""
