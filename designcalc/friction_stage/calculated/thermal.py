"""Heat and surroundings: magnetism of the base, bow of the way on it, its middle plane, the floor's shake."""

from collections.abc import Callable

from designcalc.checks.check import DesignInputs, Quantities
from designcalc.drive.friction_drive import resonance
from designcalc.errors.thermal import bow_of_layers, floor_motion
from designcalc.friction_stage.physics import loads, pads, tip_dynamics
from stagecad.parameters.design import Design


def other_base(design: Design) -> dict[str, str]:
    """Key and name of the other material that the base may have."""
    key, name = ("invar_36", "Invar 36") if design.value("base.material") == "sus416" else ("sus416", "SUS416")
    return {"other_key": key, "other": name}


def _attracted(r: DesignInputs) -> float:
    name = str(r.design.value("base.material"))
    magnetic = r.design.materials[name].magnetic
    return r.given(f"{name} attracted by a magnet", float(magnetic), "", "materials table: 1 is yes")


def _bow(r: DesignInputs, base: str) -> float:
    """Bow of the way on a base of a material over the change of temperature, m/K."""
    way, bed = pads.rail(r), f"materials.{base}"
    below = r("base.height"), r(f"{bed}.youngs_modulus"), r(f"{bed}.expansion")
    ceramic = r.material("bearing_way", "expansion")
    return float(bow_of_layers(way.length, way.height, way.rail_modulus, ceramic, *below))


def _off_middle(r: DesignInputs) -> float:
    off = max(abs(y) for _, y in r.design.derived.fitted_places[:1]) * 1e-3
    return r.given("actuator 1 from the middle plane", off, "m", "layout of the pockets")


def _followed(stiffness: Callable[[DesignInputs], float], damping: str) -> Callable[[DesignInputs], float]:
    """Motion of the stage against the tip over the floor's velocity, s."""
    return lambda r: float(floor_motion(1.0, float(resonance(stiffness(r), loads.moved_mass(r))), r(damping)))


QUANTITIES: Quantities = {
    "base.attracted": (_attracted, ""),
    "bow.of_way": (lambda r: _bow(r, str(r.design.value("base.material"))), "m/K"),
    "bow.on_other_base": (lambda r: _bow(r, other_base(r.design)["other_key"]), "m/K"),
    "actuator.off_middle": (_off_middle, "m"),
    "follow.along": (_followed(tip_dynamics.holding_stiffness, "piezo.damping_ratio"), "s"),
    "follow.normal": (_followed(lambda r: pads.pads_stiffness(r).normal, "bearing.damping_ratio"), "s"),
}
