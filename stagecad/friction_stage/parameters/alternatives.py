"""Tables of the suspensions that were compared and rejected. All numbers in SI but the lengths named as geometry."""

from dataclasses import dataclass

from stagecad.parameters.schema import count, mm, number


@dataclass(frozen=True)
class AirBearing:
    """Porous air bearing, by one point of its catalogue."""

    diameter: float = mm("of the porous face")
    height: float = mm("of the pad")
    gap: float = number("flying height of the catalogue point", "m")
    load: float = number("at that gap", "N")
    stiffness: float = number("at that gap", "N/m")
    supply: float = number("pressure above the atmosphere", "Pa")
    averaging: float = number("error of motion over flying height")
    repeatability: float = number("normal to the motion", "m")
    cost_rank: int = count("place by cost, 1 the cheapest", high=10)


@dataclass(frozen=True)
class BallSpring:
    """Balls on springs."""

    small_diameter: float = mm("the smaller ball")
    large_diameter: float = mm("the larger ball")
    stated_stiffness: float = number("of one large ball, as stated", "N/m")
    stated_pressure: float = number("under one small ball, as stated", "Pa")
    roundness: float = number("deviation from a sphere", "m")
    repeatability: float = number("normal to the motion", "m")
    rolling_friction: float = number("coefficient")
    cost_rank: int = count("place by cost, 1 the cheapest", high=10)


@dataclass(frozen=True)
class MagneticLevitation:
    """Passive levitation by repelling magnets."""

    pitch: float = mm("of the magnets on the base")
    moment: float = number("of a magnet", "A*m^2")
    flying_height: float = mm("of the stage's magnet over those of the base")
    cost_rank: int = count("place by cost, 1 the cheapest", high=10)


@dataclass(frozen=True)
class SlidingPads:
    """The sliding pads themselves, where the ranking needs more than their own tables say."""

    repeatability: float = number("normal to the motion", "m")
    cost_rank: int = count("place by cost, 1 the cheapest", high=10)


@dataclass(frozen=True)
class Candidates:
    """The suspensions that were compared."""

    sliding_pads: SlidingPads
    air_bearing: AirBearing
    ball_spring: BallSpring
    magnetic_levitation: MagneticLevitation
