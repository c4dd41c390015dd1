"""Calculators of errors for `stagecad calc`: heat, vibration, alignment of the sensor, and the budgets."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from stagecad.parameters.units import as_json
from workbench.calculators.catalogue import Calculator, Option, Values, from_key, from_material, from_model, quantities
from workbench.cli.options import Run

if TYPE_CHECKING:
    pass


def _bow(run: Run, v: Values) -> dict[str, Any]:
    from designcalc.errors.thermal import bow_of_layers, differential_growth

    layers = (v[f"{name}_{k}"] for k in (1, 2) for name in ("thickness", "modulus", "expansion"))
    bow = bow_of_layers(v["length"], *layers)
    growth = differential_growth(v["length"], v["expansion_1"], v["expansion_2"])
    return quantities(bow=(bow * v["change"], "m"), slip=(growth * v["change"], "m"))


def _vibration(run: Run, v: Values) -> dict[str, Any]:
    from designcalc.drive.friction_drive import resonance
    from designcalc.errors.thermal import floor_motion

    first = resonance(v["stiffness"], v["mass"])
    return quantities(resonance=(first, "Hz"), motion=(floor_motion(v["floor_velocity"], first, v["damping"]), "m"))


def _alignment(run: Run, v: Values) -> dict[str, Any]:
    from designcalc.errors.sensors import abbe_error, cosine_error, lag_error

    return quantities(
        abbe_error=(abbe_error(v["offset"], v["angle"]), "m"),
        cosine_error=(cosine_error(v["travel"], v["misalignment"]), "m"),
        lag=(lag_error(v["speed"], v["bandwidth"]), "m"),
    )


def _budget(run: Run, v: Values) -> dict[str, Any]:
    from designcalc.checks.inputs import DesignInputs
    from designcalc.friction_stage.checks.budget import budgets

    found: dict[str, Any] = {}
    for one in budgets(DesignInputs(run.design.values)):
        rows = [(cause.name, float(abs(e[one.axis])), cause.random) for cause, e in one.rows]
        found[one.name] = [
            {"contribution": name, "error": as_json(size, "m"), "adds": "by squares" if random else "in full"}
            for name, size, random in rows
        ]
        found[f"{one.name}_total"] = as_json(float(one.total[one.axis]), "m")
    return found


def _dynamic_budget(run: Run, v: Values) -> dict[str, Any]:
    from designcalc.checks.analysis.report import dynamic_document
    from designcalc.checks.inputs import DesignInputs
    from designcalc.friction_stage.physics.position_loop import dynamic_budgets

    return dynamic_document(dynamic_budgets(DesignInputs(run.design.values)), 1 / run.design.values.loop.observation)


ERROR_CALCULATORS: dict[str, Calculator] = {
    "bow": Calculator(
        "Bow of two layers that cannot slip by a change of temperature, and the slip of two that can.",
        {
            "length": Option("m", "of both", from_key("bearing_way.length")),
            "thickness_1": Option("m", "of the first layer", from_key("bearing_way.height")),
            "modulus_1": Option("Pa", "of the first layer", from_material("bearing_way", "youngs_modulus")),
            "expansion_1": Option("1/K", "of the first layer", from_material("bearing_way", "expansion")),
            "thickness_2": Option("m", "of the second layer", from_key("base.height")),
            "modulus_2": Option("Pa", "of the second layer", from_material("base", "youngs_modulus")),
            "expansion_2": Option("1/K", "of the second layer", from_material("base", "expansion")),
            "change": Option("K", "of temperature", from_key("environment.temperature_change")),
        },
        _bow,
    ),
    "vibration": Calculator(
        "Motion, rms, of a mass on a stiffness against a floor that vibrates in all third octaves of 8 to 80 Hz.",
        {
            "floor_velocity": Option("m/s", "rms in each third octave", from_key("environment.floor_velocity")),
            "damping": Option("", "damping ratio of the mass", from_key("piezo.damping_ratio")),
            "stiffness": Option(
                "N/m", "by default of tip and contact along the travel", from_model("tip_dynamics", "holding_stiffness")
            ),
            "mass": Option("kg", "by default stage and payload", from_model("loads", "moved_mass")),
        },
        _vibration,
    ),
    "alignment": Calculator(
        "Abbe and cosine error of a sensor that is offset and misaligned, and its lag in motion.",
        {
            "offset": Option(
                "m", "line of measurement to payload", lambda r, given: r("stage.thickness") / 2 + r("payload.height")
            ),
            "angle": Option(
                "rad",
                "turn of the stage",
                lambda r, given: 4 * r("bearing.way_straightness") / r("bearing_way.length"),
            ),
            "travel": Option("m", "", from_key("stage.travel")),
            "misalignment": Option("rad", "beam to travel", from_key("sensors.interferometer.misalignment")),
            "speed": Option("m/s", "of the stage", from_key("requirements.speed")),
            "bandwidth": Option("Hz", "of the sensor", from_key("sensors.lvdt.bandwidth")),
        },
        _alignment,
    ),
    "dynamic-budget": Calculator(
        "Dynamic error budgets at the payload: rms of each disturbance through the position loop, the largest first.",
        {},
        _dynamic_budget,
    ),
    "budget": Calculator("Error budgets at the payload, each contribution named, the largest first.", {}, _budget),
}
"""Calculators by their name in `stagecad calc`."""
