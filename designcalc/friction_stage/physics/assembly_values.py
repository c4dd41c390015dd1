"""The calculated numbers of the assembly procedure."""

from designcalc.bearing.sliding import crown_wear_depth, crown_wear_distance
from designcalc.checks.check import DesignInputs
from designcalc.friction_stage.physics.clamp import clamping_shift, screw_preload, wedge
from designcalc.friction_stage.physics.pads import heaviest_pad
from designcalc.friction_stage.physics.teeth import attraction
from designcalc.friction_stage.physics.tip_dynamics import usable_ellipse


def assembly_values(r: DesignInputs) -> dict[str, float | None]:
    """Forces (N), lengths (m) and times (s) of the assembly procedure, by the names of its values.

    Screw preloads, pull of the magnets (None without teeth), lift by the set screw, shift by clamping, and running in
    of the pads at full speed with the number of strokes until half of the film is worn.
    """
    drive, shift = wedge(r), clamping_shift(r)
    distance = 2 * r("stage.travel") * r("bearing.run_in_cycles")
    crown, rate, load = r("pads.crown_radius"), r("bearing.run_in_wear_rate"), heaviest_pad(r)
    half_worn = float(crown_wear_distance(r("bearing.film_thickness") / 2, crown, rate, load))
    return {
        "way_preload": screw_preload(r, "way"),
        "bar_preload": screw_preload(r, "bar"),
        "clamp_force": screw_preload(r, "clamp_long"),
        "magnet_pull": attraction(r) if r.design.teeth.fitted else None,
        "lift_per_turn": float(drive.lift_per_turn),
        "lift_per_degree": float(drive.lift_per_degree),
        "adjustment": float(drive.range) / 2,
        "ellipse_height": usable_ellipse(r)[1],
        "clamp_squeeze": float(shift.squeeze),
        "clamp_drop": float(shift.drop),
        "clamp_sideways": float(shift.sideways),
        "run_in_distance": distance,
        "run_in_time": distance / r("requirements.speed"),
        "run_in_wear": float(crown_wear_depth(distance, crown, rate, load)),
        "film_strokes": half_worn / (2 * r("stage.travel")),
    }
