"""The calculators of `stagecad calc`: inputs, sources of their defaults, results."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from importlib import import_module
from typing import TYPE_CHECKING, Any

from stagecad.parameters.units import as_json
from workbench.cli.options import Run

if TYPE_CHECKING:
    from designcalc.checks.inputs import DesignInputs

Values = dict[str, Any]


@dataclass(frozen=True)
class Option:
    """One option of a calculator: its unit, and where its default comes from."""

    unit: str
    meaning: str
    default: Callable[[DesignInputs, Values], float | None]
    """from the design and the options before it"""


@dataclass(frozen=True)
class Calculator:
    """A calculator's options, and the function from their SI values to its results."""

    meaning: str
    options: dict[str, Option]
    results: Callable[[Run, Values], dict[str, Any]]
    words: dict[str, tuple[str, ...]] = field(default_factory=dict)
    """options that take a word: the words allowed, none for any text"""


def from_key(key: str) -> Callable[[DesignInputs, Values], float]:
    return lambda r, given: r(key)


def from_material(part: str, quantity: str) -> Callable[[DesignInputs, Values], float]:
    return lambda r, given: r.material(part, quantity)


def from_model(module: str, function: str) -> Callable[[DesignInputs, Values], float]:
    """A default computed by a function of `designcalc.friction_stage.physics`, imported when it is needed."""
    return lambda r, given: getattr(import_module(f"designcalc.friction_stage.physics.{module}"), function)(r)


def same_as(name: str) -> Callable[[DesignInputs, Values], float]:
    return lambda r, given: given[name]


def constant(value: float | None) -> Callable[[DesignInputs, Values], float | None]:
    return lambda r, given: value


def quantities(**named: tuple[Any, str]) -> dict[str, Any]:
    """Results as JSON quantities, from (value, SI unit)."""
    return {name: as_json(float(value), unit) for name, (value, unit) in named.items()}


def _ratio(key: str) -> Callable[[DesignInputs, Values], float]:
    return lambda r, given: r(key) / given["bolt_diameter"]


def _hertz(run: Run, v: Values) -> dict[str, Any]:
    from designcalc.contact import hertz, hertz_stress

    modulus = hertz.contact_modulus(v["modulus_1"], v["poisson_1"], v["modulus_2"], v["poisson_2"])
    if v["length"] is None:
        contact = hertz.point_contact(
            v["load"], v["radius_1"], v["radius_2"], modulus, v["radius_1_minor"], v["radius_2_minor"]
        )
        peaks = [hertz_stress.point_shear_peak(contact, v[name]) for name in ("poisson_1", "poisson_2")]
        # Each body has its own stresses; the result is the larger of the two.
        peak = max(peaks, key=lambda p: float(p.shear))
        major, minor, pressure = contact.semi_axis_major, contact.semi_axis_minor, contact.peak_pressure
        approach, stiffness = as_json(float(contact.approach), "m"), as_json(float(contact.stiffness), "N/m")
        secant = as_json(float(contact.secant_stiffness), "N/m")
        ratios = (v["poisson_1"], v["poisson_2"])
        tension = max(float(hertz_stress.edge_tension(pressure, nu, v["friction"])) for nu in ratios)
    else:
        line = hertz.line_contact(v["load"], v["length"], v["radius_1"], v["radius_2"], modulus)
        peak = hertz_stress.line_shear_peak(line)
        major, minor, pressure = v["length"] / 2, line.half_width, line.peak_pressure
        approach = stiffness = secant = None  # in two dimensions they depend on how far away the approach is measured
        tension = 0.0  # a line contact without friction has none at its edge
    # A line is an ellipse without end.
    ratio = 1e-4 if v["length"] is not None else float(minor / major)
    first = min(v[f"strength_{body}"] / float(hertz_stress.peak_mises(ratio, v[f"poisson_{body}"])) for body in (1, 2))
    return {
        "semi_axis_major": as_json(float(major), "m"),
        "semi_axis_minor": as_json(float(minor), "m"),
        "peak_pressure": as_json(float(pressure), "Pa"),
        "approach": approach,
        "stiffness": stiffness,
        "peak_shear": as_json(float(peak.shear), "Pa"),
        "peak_shear_depth": as_json(float(peak.depth), "m"),
        "secant_stiffness": secant,
        "first_yield_pressure": as_json(first, "Pa"),
        "yield_margin": as_json(1 - float(pressure) / first, ""),
        "edge_tension": as_json(tension, "Pa"),
    }


def _bed_poisson(r: DesignInputs, given: Values) -> float:
    own = r.material("bearing_way", "poisson_ratio")
    return r.material("base", "poisson_ratio") if given["poisson"] == own else given["poisson"]


def _rail(run: Run, v: Values) -> dict[str, Any]:
    from designcalc.bearing.bolted_rail import Rail, joint_stiffness, total_stiffness

    names = ("length", "overhang_a", "overhang_b", "height", "bolt_diameter")
    names += ("rail_modulus", "bed_modulus", "bolt_modulus", "poisson", "bed_poisson", "joint_ratio")
    rail = Rail(**{name: v[name] for name in names})
    joint = joint_stiffness(rail, v["flange_ratio"]).joint_per_diameter
    rows = [
        {
            "spacing_ratio": M,
            "flange_ratio": tau,
            "stiffness": as_json(float(total_stiffness(rail, M, tau)), "N/m"),
        }
        for tau in (1.0, 1.5, 2.0)
        for M in range(2, 11)
    ]
    return {
        "joint_stiffness_per_diameter": as_json(float(joint), "N/m^2"),
        "total_stiffness": as_json(float(total_stiffness(rail, v["spacing_ratio"], v["flange_ratio"])), "N/m"),
        "table": rows,
    }


def _teeth(run: Run, v: Values) -> dict[str, Any]:
    from designcalc.checks.inputs import DesignInputs
    from designcalc.drive.magnetic_teeth import teeth_field
    from designcalc.friction_stage.physics.teeth import CIRCUITS, circuit

    field = teeth_field(v["pitch"], v["tooth_width"], v["gap"], v["groove_depth"])
    ratio = as_json(field.lateral_over_normal, "")
    if v["magnet"] is None:
        return {
            "lateral_over_normal": ratio,
            "lateral_stiffness": as_json(field.lateral_stiffness, "N/m^3/A^2"),
            "normal_stiffness": as_json(field.normal_stiffness, "N/m^3/A^2"),
            "attraction": as_json(field.attraction, "N/m^2/A^2"),
            "error": as_json(field.error, ""),
        }
    # The irons keep their number of teeth: another pitch makes them wider.
    point = circuit(DesignInputs(run.design.values)).forces(**{name: v[name] for name in v if name != "magnet"})
    return {
        "lateral_over_normal": as_json(point.lateral_stiffness / point.normal_stiffness, ""),
        "lateral_stiffness": as_json(CIRCUITS * point.lateral_stiffness, "N/m"),
        "normal_stiffness": as_json(CIRCUITS * point.normal_stiffness, "N/m"),
        "attraction": as_json(CIRCUITS * point.attraction, "N"),
        "gap_flux_density": as_json(point.gap_flux_density, "T"),
        "tooth_flux_density": as_json(point.tooth_flux_density, "T"),
        "leakage": as_json(point.leakage, ""),
        "magnetic_potential": as_json(point.potential, "A"),
        "error": as_json(field.error, ""),
    }


CALCULATORS: dict[str, Calculator] = {
    "hertz": Calculator(
        "Hertzian contact, elliptic or line; by default the tip's nose on the stage at the load that lifts it.",
        {
            "load": Option("N", "normal force", from_model("loads", "tip_load")),
            "radius_1": Option("m", "of body 1 in one plane", from_key("tip.nose_radius")),
            "radius_2": Option("m", "of body 2 in that plane; inf is flat, negative hollow", constant(float("inf"))),
            "radius_1_minor": Option("m", "of body 1 in the other plane", same_as("radius_1")),
            "radius_2_minor": Option("m", "of body 2 in the other plane", same_as("radius_2")),
            "modulus_1": Option("Pa", "Young's modulus of body 1", from_material("tip", "youngs_modulus")),
            "modulus_2": Option("Pa", "Young's modulus of body 2", from_material("stage", "youngs_modulus")),
            "poisson_1": Option("", "Poisson's ratio of body 1", from_material("tip", "poisson_ratio")),
            "poisson_2": Option("", "Poisson's ratio of body 2", from_material("stage", "poisson_ratio")),
            "strength_1": Option("Pa", "yield strength of body 1", from_material("tip", "strength")),
            "strength_2": Option("Pa", "yield strength of body 2", from_material("stage", "strength")),
            "friction": Option("", "coefficient of sliding friction, for the tension at the edge", constant(0.0)),
            "length": Option("m", "of a line contact; a point contact without it", constant(None)),
        },
        _hertz,
    ),
    "rail": Calculator(
        "Stiffness of the bolted bearing way against the spacing of its bolts.",
        {
            "length": Option("m", "of the rail", from_key("bearing_way.length")),
            "overhang_a": Option("m", "from the bolts to the edge it pivots on", from_key("bearing_way.bolt_edge")),
            "overhang_b": Option(
                "m", "from the bolts to the loaded edge", lambda r, given: r("bearing_way.width") - given["overhang_a"]
            ),
            "height": Option("m", "of the rail", from_key("bearing_way.height")),
            "bolt_diameter": Option("m", "", from_key("screws.way.diameter")),
            "flange_ratio": Option("", "t/Db", _ratio("bearing_way.flange_thickness")),
            "spacing_ratio": Option("", "M: bolt spacing over Db", _ratio("bearing_way.bolt_spacing")),
            "rail_modulus": Option("Pa", "of rail and flange", from_material("bearing_way", "youngs_modulus")),
            "bed_modulus": Option("Pa", "of thread and bed", from_material("base", "youngs_modulus")),
            "bolt_modulus": Option("Pa", "of the bolts", from_material("screws.way", "youngs_modulus")),
            "poisson": Option("", "of the rail", from_material("bearing_way", "poisson_ratio")),
            "bed_poisson": Option("", "of the bed; that of the rail if another one is given for it", _bed_poisson),
            "joint_ratio": Option("", "bedded joint over bolt joint", from_key("bearing_way.joint_ratio")),
        },
        _rail,
    ),
    "teeth": Calculator(
        "Lateral and normal stiffness of two toothed irons, for unit potential or with the design's magnet.",
        {
            "pitch": Option("m", "of the teeth", from_key("teeth.pitch")),
            "tooth_width": Option("m", "of a tooth", from_key("teeth.width")),
            "gap": Option("m", "between tooth faces", from_key("teeth.gap")),
            "groove_depth": Option("m", "of the grooves", from_key("teeth.groove_depth")),
        },
        _teeth,
        words={"magnet": ("design",)},
    ),
}
