"""Masses and forces of the design: weight, the preload that acts, and their point of action."""

from designcalc.checks.check import DesignInputs, remembered
from designcalc.friction_stage.physics.body import bare_stage, loaded_stage, moving_body
from designcalc.friction_stage.physics.teeth import attraction
from stagecad.parameters.mass_properties import BodyMasses


def gravity(r: DesignInputs) -> float:
    """Acceleration of gravity at the machine, m/s^2."""
    return r("environment.gravity")


def moved_mass(r: DesignInputs) -> float:
    """Mass the drive accelerates: stage, payload, and ballast if there is any, kg."""
    return moving_body(r).mass


@remembered
def weight(r: DesignInputs) -> float:
    """Weight of stage and payload, N: the load of the bearing without preload."""
    return loaded_stage(r).mass * gravity(r)


@remembered
def preload(r: DesignInputs) -> float:
    """Preload that acts, N: the attraction of the magnets; in a machine without teeth the ballast's weight.

    `preload.force` is the required preload; with magnets it is a requirement, not a load.
    """
    if r.design.teeth.fitted:
        return r.given("attraction of the magnets", attraction(r), "N", "field of magnet, irons and bar with leakage")
    return r("preload.force")


@remembered
def load(r: DesignInputs) -> float:
    """Weight and preload, N: the load of all pads when no tip presses."""
    return weight(r) + preload(r)


def preload_ratio(r: DesignInputs) -> float:
    """Preload over weight."""
    return preload(r) / weight(r)


@remembered
def load_centre(r: DesignInputs) -> tuple[float, float]:
    """Point of action (x, y) of weight and preload, from the middle of the stage, m; the preload acts in the middle."""
    body = loaded_stage(r)
    x, y = body.centre_of_mass[:2]
    if isinstance(r.masses, BodyMasses):
        for name, value in zip(("along", "across"), bare_stage(r).centre_of_mass[:2], strict=True):
            r.given(f"centre of mass {name}", value, "m", "measured from the solids")
    share = weight(r) / load(r)
    return share * x, share * y


def tip_load(r: DesignInputs) -> float:
    """Largest mean normal force on the tip, N: weight and preload, when the stage is about to lift off its pads."""
    return r.given("mean tip load at lift-off", load(r), "N", "weight and preload")
