"""Calculators of contacts and of the magnetic teeth."""

from dataclasses import dataclass
from math import inf
from typing import Annotated, Any

from designcalc.bearing.bolted_rail import Rail as RailModel
from designcalc.bearing.bolted_rail import joint_stiffness, total_stiffness
from designcalc.checks.check import DesignInputs
from designcalc.contact import hertz
from designcalc.drive.magnetic_teeth import teeth_field
from designcalc.friction_stage.physics.loads import CIRCUITS, circuit
from workbench.operations.calculators.declaration import Known, Word, quantities


@dataclass(frozen=True)
class Hertz:
    """Hertzian contact, elliptic or line; by default the tip's nose on the stage at the load that lifts it."""

    load: Annotated[float, "N", "normal force", "load.of_tip"]
    radius_1: Annotated[float, "m", "of body 1 in one plane", "tip.nose_radius"]
    radius_2: Annotated[float, "m", "of body 2 in that plane; inf is flat, negative hollow", inf]
    radius_1_minor: Annotated[float, "m", "of body 1 in the other plane", "=radius_1"]
    radius_2_minor: Annotated[float, "m", "of body 2 in the other plane", "=radius_2"]
    modulus_1: Annotated[float, "Pa", "Young's modulus of body 1", "tip:youngs_modulus"]
    modulus_2: Annotated[float, "Pa", "Young's modulus of body 2", "stage:youngs_modulus"]
    poisson_1: Annotated[float, "", "Poisson's ratio of body 1", "tip:poisson_ratio"]
    poisson_2: Annotated[float, "", "Poisson's ratio of body 2", "stage:poisson_ratio"]
    strength_1: Annotated[float, "Pa", "yield strength of body 1", "tip:strength"]
    strength_2: Annotated[float, "Pa", "yield strength of body 2", "stage:strength"]
    friction: Annotated[float, "", "coefficient of sliding friction, for the tension at the edge", 0.0]
    length: Annotated[float, "m", "of a line contact; a point contact without it", None]

    def results(self, r: DesignInputs) -> dict[str, Any]:
        modulus = hertz.contact_modulus(self.modulus_1, self.poisson_1, self.modulus_2, self.poisson_2)
        ratios = (self.poisson_1, self.poisson_2)
        if self.length is None:
            radii = (self.radius_1, self.radius_2, modulus, self.radius_1_minor, self.radius_2_minor)
            contact = hertz.point_contact(self.load, *radii)
            # Each body has its own stresses; the result is the larger of the two.
            peak = max([hertz.point_shear_peak(contact, ratio) for ratio in ratios], key=lambda p: float(p.shear))
            major, minor, pressure = contact.semi_axis_major, contact.semi_axis_minor, contact.peak_pressure
            approach, stiffness, secant = contact.approach, contact.stiffness, contact.secant_stiffness
            tension = max(float(hertz.edge_tension(pressure, nu, self.friction)) for nu in ratios)
        else:
            line = hertz.line_contact(self.load, self.length, self.radius_1, self.radius_2, modulus)
            peak = hertz.line_shear_peak(line)
            major, minor, pressure = self.length / 2, line.half_width, line.peak_pressure
            # In two dimensions they depend on how far away the approach is measured.
            approach = stiffness = secant = None
            tension = 0.0  # a line contact without friction has none at its edge
        # A line is an ellipse without end.
        ratio = 1e-4 if self.length is not None else float(minor / major)
        strengths = zip((self.strength_1, self.strength_2), ratios, strict=True)
        first = min(strength / float(hertz.peak_mises(ratio, nu)) for strength, nu in strengths)
        return quantities(
            semi_axis_major=(major, "m"),
            semi_axis_minor=(minor, "m"),
            peak_pressure=(pressure, "Pa"),
            approach=(approach, "m"),
            stiffness=(stiffness, "N/m"),
            peak_shear=(peak.shear, "Pa"),
            peak_shear_depth=(peak.depth, "m"),
            secant_stiffness=(secant, "N/m"),
            first_yield_pressure=(first, "Pa"),
            yield_margin=(1 - float(pressure) / first, ""),
            edge_tension=(tension, "Pa"),
        )


def _bed_poisson(r: DesignInputs, known: Known) -> float:
    of_rail, _ = known["option.poisson"]
    return r.material("base", "poisson_ratio") if of_rail == r.material("bearing_way", "poisson_ratio") else of_rail


@dataclass(frozen=True)
class Rail:
    """Stiffness of the bolted bearing way against the spacing of its bolts."""

    length: Annotated[float, "m", "of the rail", "bearing_way.length"]
    overhang_a: Annotated[float, "m", "from the bolts to the edge it pivots on", "bearing_way.bolt_edge"]
    overhang_b: Annotated[float, "m", "from the bolts to the loaded edge", "bearing_way.width - option.overhang_a"]
    height: Annotated[float, "m", "of the rail", "bearing_way.height"]
    bolt_diameter: Annotated[float, "m", "", "screws.way.diameter"]
    flange_ratio: Annotated[float, "", "t/Db", "bearing_way.flange_thickness/option.bolt_diameter"]
    spacing_ratio: Annotated[float, "", "M: bolt spacing over Db", "bearing_way.bolt_spacing/option.bolt_diameter"]
    rail_modulus: Annotated[float, "Pa", "of rail and flange", "bearing_way:youngs_modulus"]
    bed_modulus: Annotated[float, "Pa", "of thread and bed", "base:youngs_modulus"]
    bolt_modulus: Annotated[float, "Pa", "of the bolts", "screws.way:youngs_modulus"]
    poisson: Annotated[float, "", "of the rail", "bearing_way:poisson_ratio"]
    bed_poisson: Annotated[float, "", "of the bed; that of the rail if another one is given for it", _bed_poisson]
    joint_ratio: Annotated[float, "", "bedded joint over bolt joint", "bearing_way.joint_ratio"]

    def results(self, r: DesignInputs) -> dict[str, Any]:
        values = dict(vars(self))
        flange, spacing = values.pop("flange_ratio"), values.pop("spacing_ratio")
        rail = RailModel(**values)
        rows = [
            {"spacing_ratio": M, "flange_ratio": tau, **quantities(stiffness=(total_stiffness(rail, M, tau), "N/m"))}
            for tau in (1.0, 1.5, 2.0)
            for M in range(2, 11)
        ]
        stiffness = quantities(
            joint_stiffness_per_diameter=(joint_stiffness(rail, flange).joint_per_diameter, "N/m^2"),
            total_stiffness=(total_stiffness(rail, spacing, flange), "N/m"),
        )
        return {**stiffness, "table": rows}


@dataclass(frozen=True)
class Teeth:
    """Lateral and normal stiffness of two toothed irons, for unit potential or with the design's magnet."""

    pitch: Annotated[float, "m", "of the teeth", "teeth.pitch"]
    tooth_width: Annotated[float, "m", "of a tooth", "teeth.width"]
    gap: Annotated[float, "m", "between tooth faces", "teeth.gap"]
    groove_depth: Annotated[float, "m", "of the grooves", "teeth.groove_depth"]
    magnet: Annotated[Word, "design"]

    def results(self, r: DesignInputs) -> dict[str, Any]:
        field = teeth_field(self.pitch, self.tooth_width, self.gap, self.groove_depth)
        if self.magnet is None:
            return quantities(
                lateral_over_normal=(field.lateral_over_normal, ""),
                lateral_stiffness=(field.lateral_stiffness, "N/m^3/A^2"),
                normal_stiffness=(field.normal_stiffness, "N/m^3/A^2"),
                attraction=(field.attraction, "N/m^2/A^2"),
                error=(field.error, ""),
            )
        # The irons keep their number of teeth: another pitch makes them wider.
        point = circuit(r).forces(
            pitch=self.pitch, tooth_width=self.tooth_width, gap=self.gap, groove_depth=self.groove_depth
        )
        return quantities(
            lateral_over_normal=(point.lateral_stiffness / point.normal_stiffness, ""),
            lateral_stiffness=(CIRCUITS * point.lateral_stiffness, "N/m"),
            normal_stiffness=(CIRCUITS * point.normal_stiffness, "N/m"),
            attraction=(CIRCUITS * point.attraction, "N"),
            gap_flux_density=(point.gap_flux_density, "T"),
            tooth_flux_density=(point.tooth_flux_density, "T"),
            leakage=(point.leakage, ""),
            magnetic_potential=(point.potential, "A"),
            error=(field.error, ""),
        )
