"""Calculators of the stage's support for `stagecad calc`: wear, smoothness, alternative suspensions."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

from workbench.calculators.catalogue import Calculator, Option, Values, constant, from_key, from_model, quantities
from workbench.cli.options import Run

if TYPE_CHECKING:
    from designcalc.checks.inputs import DesignInputs


def _contact(r: DesignInputs, given: Values) -> float:
    from designcalc.friction_stage.checks.bearing.smoothness import spot

    return spot(r)


def _wear(run: Run, v: Values) -> dict[str, Any]:
    from designcalc.bearing.sliding import crown_wear_depth, crown_wear_distance, friction_heat

    distance = crown_wear_distance(v["depth"], v["crown_radius"], v["wear_rate"], v["load"])
    return quantities(
        distance=(distance, "m"),
        strokes_there_and_back=(distance / (2 * v["travel"]), ""),
        depth_by_running_in=(
            crown_wear_depth(v["run_in_distance"], v["crown_radius"], v["run_in_wear_rate"], v["load"]),
            "m",
        ),
        friction_heat=(friction_heat(v["friction"], v["load"], v["speed"]), "W"),
    )


def _smoothness(run: Run, v: Values) -> dict[str, Any]:
    import numpy as np

    from designcalc.bearing.sliding import averaged_roughness
    from designcalc.bearing.way_profile import Surface, carried_height, synthetic_profiles
    from workbench.calculators.profile_file import read_profile

    if v["profile"] is not None:
        heights, step = read_profile(Path(v["profile"]))
        carried = carried_height(heights, step, v["contact_length"])
        return quantities(
            rms_of_profile=(np.std(heights), "m"), rms=(np.std(carried), "m"), peak_to_valley=(np.ptp(carried), "m")
        )
    surface = Surface(v["roughness"], v["correlation_length"], v["waviness"], v["wavelength"])
    count = int(v["pads"])
    profiles, step = synthetic_profiles(surface, v["travel"], v["contact_length"], count)
    carried = carried_height(profiles, step, v["contact_length"])
    closed = averaged_roughness(v["roughness"], v["correlation_length"], v["contact_length"] / 2, count)
    return quantities(
        rms=(np.std(carried), "m"), peak_to_valley=(np.ptp(carried), "m"), roughness_by_formula=(closed, "m")
    )


def _air_bearing(run: Run, v: Values) -> dict[str, Any]:
    from designcalc.bearing.porous_air import load_of_gap, stiffness_of_gap

    known = (v["known_gap"], v["known_load"], v["diameter"], v["supply"])
    return quantities(
        load=(load_of_gap(v["gap"], *known), "N"),
        stiffness=(stiffness_of_gap(v["gap"], *known), "N/m"),
        roughness_limit=(v["gap"] / 4, "m"),
    )


def _levitation(run: Run, v: Values) -> dict[str, Any]:
    import numpy as np

    from designcalc.drive.suspension import dipole_hessian

    hessian = dipole_hessian((0, 0, v["moment_1"]), (0, 0, v["moment_2"]), (v["x"], v["y"], v["z"]))
    soft, middle, stiff = np.linalg.eigvalsh(hessian)
    return quantities(
        softest=(soft, "N/m"), middle=(middle, "N/m"), stiffest=(stiff, "N/m"), sum=(np.trace(hessian), "N/m")
    )


def _suspensions(run: Run, v: Values) -> dict[str, Any]:
    from designcalc.checks.inputs import DesignInputs
    from designcalc.friction_stage.checks.alternatives import ranking
    from stagecad.parameters.units import as_json

    rows = [
        {
            "suspension": c.name,
            "stiffness": as_json(c.stiffness, "N/m"),
            "smoothness": as_json(c.smoothness, "m"),
            "friction": as_json(c.friction, "N"),
            "repeatability": as_json(c.repeatability, "m"),
            "cost": c.cost,
            "places": c.places,
            "stable": c.stable,
            "fits_drive": c.fits_drive,
        }
        for c in ranking(DesignInputs(run.design.values))
    ]
    return {"table": rows}


BEARING_CALCULATORS: dict[str, Calculator] = {
    "wear": Calculator(
        "Sliding distance that wears a crowned pad out by Archard's law, the share of running in, and friction heat.",
        {
            "load": Option("N", "of the pad", from_model("pads", "heaviest_pad")),
            "crown_radius": Option("m", "of the pad", from_key("pads.crown_radius")),
            "depth": Option("m", "worn in the middle", lambda r, given: r("bearing.film_thickness") / 2),
            "wear_rate": Option("m^2/N", "specific wear of the run-in film", from_key("bearing.wear_rate")),
            "run_in_wear_rate": Option("m^2/N", "of the fresh film", from_key("bearing.run_in_wear_rate")),
            "travel": Option("m", "of a stroke", from_key("stage.travel")),
            "run_in_distance": Option(
                "m", "slid while running in", lambda r, given: 2 * given["travel"] * r("bearing.run_in_cycles")
            ),
            "friction": Option("", "dynamic", from_key("bearing.dynamic_friction")),
            "speed": Option("m/s", "of the stage", from_key("requirements.speed")),
        },
        _wear,
    ),
    "smoothness": Calculator(
        "Height of a stage whose pads slide on a way: generated from roughness and waves, or measured (--profile "
        "FILE.csv with columns `position [m]` and `height [m]`).",
        {
            "roughness": Option("m", "Ra", from_key("bearing.proposed_way_roughness")),
            "correlation_length": Option("m", "of the roughness", from_key("bearing.roughness_correlation")),
            "waviness": Option("m", "amplitude of the waves", from_key("bearing.way_waviness")),
            "wavelength": Option("m", "of the waves", from_key("bearing.waviness_length")),
            "contact_length": Option("m", "diameter of a pad's contact", _contact),
            "pads": Option("", "that share the load, each on a separate track", from_key("pads.count")),
            "travel": Option("m", "ridden over", from_key("stage.travel")),
        },
        _smoothness,
        words={"profile": ()},
    ),
    "air-bearing": Calculator(
        "Load and stiffness of a round porous air bearing over its gap, its feed fixed by one point of a catalogue.",
        {
            "gap": Option("m", "between bearing and way", from_key("candidates.air_bearing.gap")),
            "known_gap": Option("m", "of the catalogue point", from_key("candidates.air_bearing.gap")),
            "known_load": Option("N", "at that gap", from_key("candidates.air_bearing.load")),
            "diameter": Option("m", "of the porous face", from_key("candidates.air_bearing.diameter")),
            "supply": Option("Pa", "above the atmosphere", from_key("candidates.air_bearing.supply")),
        },
        _air_bearing,
    ),
    "levitation": Calculator(
        "Stiffnesses of one upright magnet over another: they add up to zero, so one is unstable (Earnshaw).",
        {
            "moment_1": Option("A*m^2", "upwards", from_key("candidates.magnetic_levitation.moment")),
            "moment_2": Option("A*m^2", "upwards", lambda r, given: -given["moment_1"]),
            "x": Option("m", "from the first to the second", constant(0.0)),
            "y": Option("m", "", constant(0.0)),
            "z": Option("m", "", from_key("candidates.magnetic_levitation.flying_height")),
        },
        _levitation,
    ),
    "suspensions": Calculator(
        "The suspensions that were compared, ranked by stiffness, smoothness, friction, repeatability and cost.",
        {},
        _suspensions,
    ),
}
"""Calculators by their name in `stagecad calc`."""
