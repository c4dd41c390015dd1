"""Masses and forces of the design: weight, the preload that acts, and their point of action."""

from designcalc.checks.check import DesignInputs, remembered
from designcalc.friction_stage.physics.teeth import attraction
from stagecad.parameters.mass_properties import BodyMasses, MassProperties, combined

_POINT = ((0.0, 0.0, 0.0),) * 3


def stage_mass(r: DesignInputs) -> float:
    """Mass of the stage with irons and magnets, kg; without solids that of its plain plate, as the input states."""
    if isinstance(r.masses, BodyMasses):
        return r.given("moving body mass", r.masses.moving.mass, "kg", "measured from the solids")
    plate = r("stage.length") * r("stage.width") * r("stage.thickness")
    return r.given(
        "moving body mass",
        plate * r.material("stage", "density"),
        "kg",
        "estimated: the stage as a plain plate, since no solids were built",
    )


def tip_mass(r: DesignInputs) -> float:
    """Mass of one tip, kg; without solids its limit."""
    if isinstance(r.masses, BodyMasses):
        return r.given("tip mass", r.masses.tip.mass, "kg", "measured from the solids")
    return r("tip.mass_limit")


@remembered
def bare_stage(r: DesignInputs) -> MassProperties:
    """Stage with irons and magnets, from the middle of the stage at the height of the drive surface.

    Without solids it is the plain plate.
    """
    mass, thickness = stage_mass(r), r("stage.thickness")
    if isinstance(r.masses, BodyMasses):
        sea = r("bearing_way.height") + r("pads.height")
        return r.masses.moving.moved((0.0, 0.0, -sea))
    length, width = r("stage.length"), r("stage.width")
    inertia = (
        (mass * (width**2 + thickness**2) / 12, 0.0, 0.0),
        (0.0, mass * (length**2 + thickness**2) / 12, 0.0),
        (0.0, 0.0, mass * (length**2 + width**2) / 12),
    )
    corner = (length / 2, width / 2, thickness)
    box = ((-corner[0], -corner[1], 0.0), corner)
    return MassProperties(length * width * thickness, mass, (0.0, 0.0, thickness / 2), inertia, box)


@remembered
def loaded_stage(r: DesignInputs) -> MassProperties:
    """Stage and payload, the payload a point over the middle of the stage."""
    stage = bare_stage(r)
    return _with_point(stage, r("payload.mass"), r("stage.thickness") + r("payload.height"))


@remembered
def moving_body(r: DesignInputs) -> MassProperties:
    """The whole moving body: stage, payload, and ballast."""
    body = loaded_stage(r)
    return with_ballast(body, ballast(r))


def ballast(r: DesignInputs) -> float:
    """Mass that replaces the magnets of a machine without teeth: its weight is the required preload, kg."""
    return 0.0 if r.design.teeth.fitted else r("preload.force") / r("environment.gravity")


def with_ballast(body: MassProperties, mass: float) -> MassProperties:
    """A body with a point mass, kg, over the middle of the stage, at the height of the body's centre of mass."""
    return _with_point(body, mass, body.centre_of_mass[2])


def _with_point(body: MassProperties, mass: float, height: float) -> MassProperties:
    if mass <= 0.0:
        return body
    return combined([body, MassProperties(0.0, mass, (0.0, 0.0, height), _POINT, body.bounding_box)])


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
