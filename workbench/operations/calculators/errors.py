"""Calculators of errors: heat, vibration, alignment of the sensor, and the budgets."""

from dataclasses import dataclass
from typing import Annotated, Any

from designcalc.checks.check import DesignInputs
from designcalc.checks.report import dynamic_document
from designcalc.drive.friction_drive import resonance
from designcalc.errors.sensors import abbe_error, cosine_error, lag_error
from designcalc.errors.thermal import bow_of_layers, differential_growth, floor_motion
from designcalc.friction_stage.calculated.budget import budgets
from designcalc.friction_stage.physics.position_loop import dynamic_budgets
from stagecad.parameters.units import as_json
from workbench.operations.calculators.declaration import quantities


@dataclass(frozen=True)
class Bow:
    """Bow of two layers that cannot slip by a change of temperature, and the slip of two that can."""

    length: Annotated[float, "m", "of both", "bearing_way.length"]
    thickness_1: Annotated[float, "m", "of the first layer", "bearing_way.height"]
    modulus_1: Annotated[float, "Pa", "of the first layer", "bearing_way:youngs_modulus"]
    expansion_1: Annotated[float, "1/K", "of the first layer", "bearing_way:expansion"]
    thickness_2: Annotated[float, "m", "of the second layer", "base.height"]
    modulus_2: Annotated[float, "Pa", "of the second layer", "base:youngs_modulus"]
    expansion_2: Annotated[float, "1/K", "of the second layer", "base:expansion"]
    change: Annotated[float, "K", "of temperature", "environment.temperature_change"]

    def results(self, r: DesignInputs) -> dict[str, Any]:
        first = (self.thickness_1, self.modulus_1, self.expansion_1)
        bow = bow_of_layers(self.length, *first, self.thickness_2, self.modulus_2, self.expansion_2)
        growth = differential_growth(self.length, self.expansion_1, self.expansion_2)
        return quantities(bow=(bow * self.change, "m"), slip=(growth * self.change, "m"))


@dataclass(frozen=True)
class Vibration:
    """Motion, rms, of a mass on a stiffness against a floor that vibrates in all third octaves of 8 to 80 Hz."""

    floor_velocity: Annotated[float, "m/s", "rms in each third octave", "environment.floor_velocity"]
    damping: Annotated[float, "", "damping ratio of the mass", "piezo.damping_ratio"]
    stiffness: Annotated[float, "N/m", "by default of tip and contact along the travel", "stiffness.along"]
    mass: Annotated[float, "kg", "by default stage and payload", "load.moved_mass"]

    def results(self, r: DesignInputs) -> dict[str, Any]:
        first = resonance(self.stiffness, self.mass)
        return quantities(resonance=(first, "Hz"), motion=(floor_motion(self.floor_velocity, first, self.damping), "m"))


@dataclass(frozen=True)
class Alignment:
    """Abbe and cosine error of a sensor that is offset and misaligned, and its lag in motion."""

    offset: Annotated[float, "m", "line of measurement to payload", "stage.thickness/2 + payload.height"]
    angle: Annotated[float, "rad", "turn of the stage", "4*bearing.way_straightness/bearing_way.length"]
    travel: Annotated[float, "m", "", "stage.travel"]
    misalignment: Annotated[float, "rad", "beam to travel", "sensors.interferometer.misalignment"]
    speed: Annotated[float, "m/s", "of the stage", "requirements.speed"]
    bandwidth: Annotated[float, "Hz", "of the sensor", "sensors.lvdt.bandwidth"]

    def results(self, r: DesignInputs) -> dict[str, Any]:
        return quantities(
            abbe_error=(abbe_error(self.offset, self.angle), "m"),
            cosine_error=(cosine_error(self.travel, self.misalignment), "m"),
            lag=(lag_error(self.speed, self.bandwidth), "m"),
        )


@dataclass(frozen=True)
class DynamicBudget:
    """Dynamic error budgets at the payload: rms of each disturbance through the position loop, the largest first."""

    def results(self, r: DesignInputs) -> dict[str, Any]:
        return dynamic_document(dynamic_budgets(r), 1 / r("loop.observation"))


@dataclass(frozen=True)
class Budget:
    """Error budgets at the payload, each contribution named, the largest first."""

    def results(self, r: DesignInputs) -> dict[str, Any]:
        document: dict[str, Any] = {}
        for budget in budgets(r):
            document[budget.name] = [
                {
                    "contribution": cause.name,
                    "error": as_json(float(abs(error[budget.axis])), "m"),
                    "adds": "by squares" if cause.random else "in full",
                }
                for cause, error in budget.rows
            ]
            document[f"{budget.name}_total"] = as_json(float(budget.total[budget.axis]), "m")
        return document
