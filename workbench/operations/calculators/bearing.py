"""Calculators of the stage's support: wear, smoothness, alternative suspensions."""

import csv
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any

import numpy as np
from numpy.typing import NDArray

from designcalc.bearing import porous_air, sliding, way_profile
from designcalc.checks.check import DesignInputs
from designcalc.drive.suspension import dipole_hessian
from designcalc.friction_stage.calculated.alternatives import ranking
from designcalc.friction_stage.calculated.pads import spot
from stagecad.parameters.errors import InputError, require, require_known
from stagecad.parameters.input_file import read_input
from stagecad.parameters.units import attributes, parse_quantity
from workbench.operations.calculators.declaration import Word, quantities

COLUMNS = ("position", "height")


def read_profile(path: Path) -> tuple[NDArray[np.float64], float]:
    """Heights, m, and their spacing, m, from columns `position [UNIT]` and `height [UNIT]`, evenly spaced."""
    try:
        rows = [row for row in csv.reader(read_input(path).decode("utf-8").splitlines()) if row]
    except FileNotFoundError:
        raise InputError(f"{path}: no such file") from None
    except UnicodeDecodeError:
        raise InputError(
            f"{path}: is not a text file; a CSV file with columns `position [m]`, `height [m]` is needed"
        ) from None
    require(rows, f"{path}: is empty; columns `position [m]`, `height [m]` are needed")
    scale = {}
    for index, cell in enumerate(rows[0]):
        name, _, unit = cell.strip().partition("[")
        name = name.strip()
        require_known(name, COLUMNS, f"{path}: row 1: no column '{name}' is known")
        scale[name] = index, parse_quantity(f"1 {unit.rstrip(']').strip()}", "m", f"{path}: row 1: {name}")
    missing = [name for name in COLUMNS if name not in scale]
    if missing:
        raise InputError(f"{path}: row 1: column '{missing[0]} [m]' is missing")
    values = {name: np.empty(len(rows) - 1) for name in COLUMNS}
    for number, row in enumerate(rows[1:], start=2):
        for name, (index, size) in scale.items():
            try:
                values[name][number - 2] = float(row[index]) * size
            except (ValueError, IndexError):
                cell = row[index] if index < len(row) else ""
                raise InputError(f"{path}: row {number}: {name} '{cell}' is not a number") from None
    place, heights = values["position"], values["height"]
    if len(place) < 3 or not np.isfinite(heights).all():
        raise InputError(f"{path}: at least three heights are needed, and all of them finite")
    steps = np.diff(place)
    step = float(steps.mean())
    uneven = np.abs(steps - step) > 1e-3 * abs(step)
    if step <= 0 or uneven.any():
        row = int(np.argmax(uneven | (steps <= 0))) + 3
        raise InputError(f"{path}: row {row}: positions must rise by even steps, of {step:.4g} m on the mean")
    return heights, step


@dataclass(frozen=True)
class Wear:
    """Sliding distance that wears a crowned pad out by Archard's law, the share of running in, and friction heat."""

    load: Annotated[float, "N", "of the pad", "load.heaviest_pad"]
    crown_radius: Annotated[float, "m", "of the pad", "pads.crown_radius"]
    depth: Annotated[float, "m", "worn in the middle", "bearing.film_thickness/2"]
    wear_rate: Annotated[float, "m^2/N", "specific wear of the run-in film", "bearing.wear_rate"]
    run_in_wear_rate: Annotated[float, "m^2/N", "of the fresh film", "bearing.run_in_wear_rate"]
    travel: Annotated[float, "m", "of a stroke", "stage.travel"]
    run_in_distance: Annotated[float, "m", "slid while running in", "2*option.travel*bearing.run_in_cycles"]
    friction: Annotated[float, "", "dynamic", "bearing.dynamic_friction"]
    speed: Annotated[float, "m/s", "of the stage", "requirements.speed"]

    def results(self, r: DesignInputs) -> dict[str, Any]:
        distance = sliding.crown_wear_distance(self.depth, self.crown_radius, self.wear_rate, self.load)
        run_in = sliding.crown_wear_depth(self.run_in_distance, self.crown_radius, self.run_in_wear_rate, self.load)
        return quantities(
            distance=(distance, "m"),
            strokes_there_and_back=(distance / (2 * self.travel), ""),
            depth_by_running_in=(run_in, "m"),
            friction_heat=(sliding.friction_heat(self.friction, self.load, self.speed), "W"),
        )


@dataclass(frozen=True)
class Smoothness:
    """Height of a stage whose pads slide on a way: generated from roughness and waves, or measured (--profile FILE.csv
    with columns `position [m]` and `height [m]`)."""

    roughness: Annotated[float, "m", "Ra", "bearing.proposed_way_roughness"]
    correlation_length: Annotated[float, "m", "of the roughness", "bearing.roughness_correlation"]
    waviness: Annotated[float, "m", "amplitude of the waves", "bearing.way_waviness"]
    wavelength: Annotated[float, "m", "of the waves", "bearing.waviness_length"]
    contact_length: Annotated[float, "m", "diameter of a pad's contact", lambda r, _: spot(r)]
    pads: Annotated[float, "", "that share the load, each on a separate track", "pads.count"]
    travel: Annotated[float, "m", "ridden over", "stage.travel"]
    profile: Word

    def results(self, r: DesignInputs) -> dict[str, Any]:
        if self.profile is not None:
            heights, step = read_profile(Path(self.profile))
            carried = way_profile.carried_height(heights, step, self.contact_length)
            measured = quantities(rms_of_profile=(np.std(heights), "m"))
            return measured | quantities(rms=(np.std(carried), "m"), peak_to_valley=(np.ptp(carried), "m"))
        surface = way_profile.Surface(self.roughness, self.correlation_length, self.waviness, self.wavelength)
        count = int(self.pads)
        profiles, step = way_profile.synthetic_profiles(surface, self.travel, self.contact_length, count)
        carried = way_profile.carried_height(profiles, step, self.contact_length)
        closed = sliding.averaged_roughness(self.roughness, self.correlation_length, self.contact_length / 2, count)
        return quantities(
            rms=(np.std(carried), "m"), peak_to_valley=(np.ptp(carried), "m"), roughness_by_formula=(closed, "m")
        )


@dataclass(frozen=True)
class AirBearing:
    """Load and stiffness of a round porous air bearing over its gap, its feed fixed by one point of a catalogue."""

    gap: Annotated[float, "m", "between bearing and way", "candidates.air_bearing.gap"]
    known_gap: Annotated[float, "m", "of the catalogue point", "candidates.air_bearing.gap"]
    known_load: Annotated[float, "N", "at that gap", "candidates.air_bearing.load"]
    diameter: Annotated[float, "m", "of the porous face", "candidates.air_bearing.diameter"]
    supply: Annotated[float, "Pa", "above the atmosphere", "candidates.air_bearing.supply"]

    def results(self, r: DesignInputs) -> dict[str, Any]:
        known = (self.known_gap, self.known_load, self.diameter, self.supply)
        return quantities(
            load=(porous_air.load_of_gap(self.gap, *known), "N"),
            stiffness=(porous_air.stiffness_of_gap(self.gap, *known), "N/m"),
            roughness_limit=(self.gap / 4, "m"),
        )


@dataclass(frozen=True)
class Levitation:
    """Stiffnesses of one upright magnet over another: they add up to zero, so one is unstable (Earnshaw)."""

    moment_1: Annotated[float, "A*m^2", "upwards", "candidates.magnetic_levitation.moment"]
    moment_2: Annotated[float, "A*m^2", "upwards", "-option.moment_1"]
    x: Annotated[float, "m", "from the first to the second", 0.0]
    y: Annotated[float, "m", "", 0.0]
    z: Annotated[float, "m", "", "candidates.magnetic_levitation.flying_height"]

    def results(self, r: DesignInputs) -> dict[str, Any]:
        hessian = dipole_hessian((0, 0, self.moment_1), (0, 0, self.moment_2), (self.x, self.y, self.z))
        soft, middle, stiff = np.linalg.eigvalsh(hessian)
        return quantities(
            softest=(soft, "N/m"), middle=(middle, "N/m"), stiffest=(stiff, "N/m"), sum=(np.trace(hessian), "N/m")
        )


@dataclass(frozen=True)
class Suspensions:
    """The suspensions that were compared, ranked by stiffness, smoothness, friction, repeatability and cost."""

    def results(self, r: DesignInputs) -> dict[str, Any]:
        units = {"stiffness": "N/m", "smoothness": "m", "friction": "N", "repeatability": "m"}
        rows = []
        for suspension in ranking(r):
            numbers = quantities(**{name: (getattr(suspension, name), unit) for name, unit in units.items()})
            others = attributes(suspension, "cost", "places", "stable", "fits_drive")
            rows.append({"suspension": suspension.name, **numbers, **others})
        return {"table": rows}
