"""Masses and forces of the design: weight, attraction of the magnets, the preload that acts, and their point of
action."""

from dataclasses import dataclass, replace

from designcalc.checks.check import DesignInputs, remembered
from designcalc.drive.magnetic_teeth import MagnetForces, MagnetSection, TeethField, magnet_forces, teeth_field
from stagecad.parameters.mass_properties import BodyMasses, MassProperties, combined

CIRCUITS = 2
"""Magnetic circuits: one pocket with its magnet over each of the two bars."""


@dataclass(frozen=True)
class MagnetCircuit:
    """One magnet with its two irons and its bar."""

    section: MagnetSection  # geometry across the travel
    length: float  # of magnet and irons along the travel, m
    remanence: float  # T
    recoil_permeability: float  # relative

    def forces(self, refinement: float = 1.0, **changes: float) -> MagnetForces:
        """Forces of the circuit, with some lengths of its section changed."""
        section = replace(self.section, **changes)
        return magnet_forces(section, self.length, self.remanence, self.recoil_permeability, refinement)


MAGNETS = "finite elements in the cross-section of magnet, irons and bar, leakage included; virtual work"
"""How the forces of the magnets are found."""


def circuit(r: DesignInputs) -> MagnetCircuit:
    """One of the two magnetic circuits of the design."""
    section = MagnetSection(
        pitch=r("teeth.pitch"),
        tooth_width=r("teeth.width"),
        gap=r("teeth.gap"),
        groove_depth=r("teeth.groove_depth"),
        teeth=int(r("teeth.per_iron")),
        iron_height=r("tooth_iron.height"),
        magnet_thickness=r("magnet.thickness"),
        magnet_height=r("magnet.height"),
        channel_depth=r("tooth_bar.channel_depth"),
    )
    length = min(r("tooth_iron.length"), r("magnet.length"))
    return MagnetCircuit(section, length, r("magnet.remanence"), r("magnet.recoil_permeability"))


@remembered
def magnets(r: DesignInputs) -> MagnetForces:
    """Working point of one circuit of the design, leakage included."""
    return circuit(r).forces()


@remembered
def attraction(r: DesignInputs) -> float:
    """Pull of all magnets of the design on the stage, N; 0 without teeth."""
    return CIRCUITS * magnets(r).attraction if r.design.teeth.fitted else 0.0


@remembered
def tooth_field(r: DesignInputs) -> TeethField:
    """Field of one cell of the teeth, which repeats across the travel."""
    return teeth_field(r("teeth.pitch"), r("teeth.width"), r("teeth.gap"), r("teeth.groove_depth"))


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
        return r.masses.moving.moved((0.0, 0.0, -(r("bearing_way.height") + r("pads.height"))))
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
    return _with_point(bare_stage(r), r("payload.mass"), r("stage.thickness") + r("payload.height"))


@remembered
def moving_body(r: DesignInputs) -> MassProperties:
    """The whole moving body: stage, payload, and ballast."""
    return with_ballast(loaded_stage(r), ballast(r))


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
    x, y = loaded_stage(r).centre_of_mass[:2]
    if isinstance(r.masses, BodyMasses):
        for name, value in zip(("along", "across"), bare_stage(r).centre_of_mass[:2], strict=True):
            r.given(f"centre of mass {name}", value, "m", "measured from the solids")
    share = weight(r) / load(r)
    return share * x, share * y


def tip_load(r: DesignInputs) -> float:
    """Largest mean normal force on the tip, N: weight and preload, when the stage is about to lift off its pads."""
    return r.given("mean tip load at lift-off", load(r), "N", "weight and preload")
