"""The body that moves: stage with irons and magnets, payload, and the ballast of a machine without magnets."""

from designcalc.checks.check import DesignInputs, remembered
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
