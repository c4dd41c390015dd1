"""Data types of a part's datums, dimensions and requirements on its faces, independent of the solid.

A part declares each dimension next to its feature; the drawings place the declarations, the tolerance analysis adds
them up, the assembly mates the datums. Millimetres and degrees, in part coordinates.
"""

import math
from dataclasses import dataclass
from typing import Literal, get_args

Point = tuple[float, float, float]

Kind = Literal[
    "linear",
    "diameter",
    "radius",
    "angle",
    "depth",
    "chamfer",
    "thread",
    "tap_drill",
    "thread_depth",
    "slope",
    "count",
    "callout",
    "pitch",
    "sag",
    "pitch_circle",
]
"""Kinds of dimension by the measured quantity.

`linear`, `depth`: distance between two points. `diameter`, `radius`: of a round feature. `angle`: in degrees.
`chamfer`: leg of a chamfer, 45 degrees unless the note says otherwise. `thread`: nominal diameter, the note carries
the designation; `tap_drill` and `thread_depth` of the same hole. `slope`: tangent of the angle
between a face and the direction. `count`: number of features of a pattern. `callout`: a
note on a feature. `pitch`: distance of neighbours in a row of equal features, of which
the points give the first and the last and `count` the number of distances. `sag`: height of a spherical crown over the
chord between its two points. `pitch_circle`: diameter of the circle of `count` equally spaced features, or 1 of any.
"""

View = Literal["top", "bottom", "front", "back", "left", "right", "section", "auxiliary", "iso", "any"]
VIEWS = get_args(View)
"""The preferred view of a dimension: `top` looks down z, `front` along +y (x to the right), `right` along -x,
`auxiliary` against a slanting face on which its points are."""


def _require_view(place: str, *views: str) -> None:
    for view in views:
        if view not in VIEWS:
            raise ValueError(f"{place}: no view '{view}'; allowed: {', '.join(VIEWS)}")


@dataclass(frozen=True)
class Datum:
    """A named frame of a part: a face, an axis, or a place."""

    name: str  # as in the part's contract (`top`, `pad_1`)
    origin: Point  # point in part coordinates, mm
    normal: Point  # unit vector, out of the material of a face, along an axis
    x_direction: Point = (1.0, 0.0, 0.0)  # unit vector at right angles to the normal

    def __post_init__(self) -> None:
        for vector in (self.normal, self.x_direction):
            if abs(math.hypot(*vector) - 1.0) > 1e-9:
                raise ValueError(f"datum '{self.name}': {vector} is no unit vector")
        if abs(sum(a * b for a, b in zip(self.normal, self.x_direction))) > 1e-9:
            raise ValueError(f"datum '{self.name}': normal and x direction are not at right angles")


@dataclass(frozen=True)
class Dimension:
    """One dimension of a part, declared with the feature that needs it."""

    name: str  # what is measured, unique within the part (`length`, `pocket depth`)
    kind: Kind  # see `Kind`
    value: float  # mm, or degrees for an angle; for a count or callout the number
    parameter: str  # key of the parameter file the value comes from (`stage.length`)
    # on the part, in part coordinates: two for linear and depth; for round ones a point on the axis next to the face,
    # or on the face
    points: tuple[Point, ...] = ()
    # direction measured along, or the axis of a round feature; from point to point when left out
    direction: Point | None = None
    tolerance: str | None = None  # class `X`, `X.X` or `X.XX`; none for a reference dimension or one a standard covers
    note: str = ""  # callout text that goes with it (`M6x1 - 6H`, `lapped Ra 1 um`)
    count: int = 1  # number of equal features to which it applies
    view: View = "any"  # the preferred one
    feature: str = ""  # name of its feature; the dimensions of one hole are combined in one callout
    between: tuple[str, ...] = ()  # names of the datums or features between which it is measured, if they have names
    # keys of the parameters from which the value is computed, if it is not one parameter; then `parameter` is empty,
    # and `tolerance` is the class of the first of them
    derived_from: tuple[str, ...] = ()
    # lower and upper limit deviation, mm, if they are not those of a general tolerance class
    deviations: tuple[float, float] | None = None
    reference: bool = False  # whether it is given for information only, in brackets, without a tolerance
    table: str = ""  # view whose hole table gives it, in place of a dimension of its own; empty for none
    # whether it is theoretically exact (ISO 1101), in a frame and without a tolerance: a tolerance of position or of
    # angularity applies at it
    exact: bool = False
    major: float = 0.0  # major diameter of the thread of a tapped hole, mm; else 0

    def __post_init__(self) -> None:
        _require_view(f"dimension '{self.name}'", self.view, self.table or self.view)
        if self.kind not in get_args(Kind):
            raise ValueError(f"dimension '{self.name}': no kind '{self.kind}'")
        if not all(isinstance(text, str) for text in (self.name, self.parameter, self.note, self.feature)):
            raise ValueError(f"dimension '{self.name}': name, parameter, note and feature are texts")
        if bool(self.parameter) == bool(self.derived_from):
            raise ValueError(f"dimension '{self.name}': comes from one parameter, or is derived from some")
        if self.kind in ("linear", "depth", "pitch", "sag") and len(self.points) != 2:
            raise ValueError(f"dimension '{self.name}': a {self.kind} dimension needs two points")
        if not math.isfinite(self.value):
            raise ValueError(f"dimension '{self.name}': {self.value} is no value")
        if self.count < 1:
            raise ValueError(f"dimension '{self.name}': applies to {self.count} features")


Characteristic = Literal[
    "flatness",
    "straightness",
    "cylindricity",
    "parallelism",
    "perpendicularity",
    "angularity",
    "position",
    "coaxiality",
    "profile",
]
"""Geometrical characteristics of ISO 1101 in use here; `profile` is that of a surface."""

FORM: tuple[Characteristic, ...] = ("flatness", "straightness", "cylindricity")
"""Characteristics without a datum; `profile` may have one, all others have."""


@dataclass(frozen=True)
class DatumFeature:
    """A face that others are referred to, by its letter (ISO 5459)."""

    letter: str  # one capital letter, unique within the part
    points: tuple[Point, ...]  # one on each face that forms it together, or on the axis of a round face
    normal: Point  # out of the face, or along the axis
    view: View  # view that shows the face as a line
    round: bool = False  # whether it is the axis of a round face
    targets: str = ""  # view that shows the faces from the front, with a datum target on each; empty for none
    median: bool = False  # whether it is the middle plane of two parallel faces

    def __post_init__(self) -> None:
        _require_view(f"datum '{self.letter}'", self.view, self.targets or self.view)
        if len(self.letter) != 1 or not self.letter.isupper():
            raise ValueError(f"datum '{self.letter}': no capital letter")


@dataclass(frozen=True)
class GeometricTolerance:
    """Tolerance of form or orientation of a face (ISO 1101), declared with the face."""

    name: str  # unique within the part
    characteristic: Characteristic  # see `Characteristic`
    value: float  # width of the zone, mm
    parameter: str  # key of the parameter file the value comes from
    points: tuple[Point, ...]  # one on each face; on the axis of a round one
    normal: Point  # out of the face, or along the axis
    view: View  # view that shows the face as a line
    datums: tuple[str, ...] = ()  # letters referred to
    round: bool = False  # whether it holds for a round face, or its axis
    combined: bool = False  # whether all the faces lie in one zone (CZ), rather than each in its own
    feature: str = ""  # name of the holes whose callout has the control frame below it; empty for a frame on a face

    def __post_init__(self) -> None:
        _require_view(f"tolerance '{self.name}'", self.view)
        if self.characteristic not in get_args(Characteristic):
            raise ValueError(f"tolerance '{self.name}': no characteristic '{self.characteristic}'")
        if not (math.isfinite(self.value) and self.value > 0):
            raise ValueError(f"{self.characteristic} '{self.name}': {self.value} is no width of a zone")
        if self.characteristic != "profile" and bool(self.datums) == (self.characteristic in FORM):
            allowed = "no datum" if self.characteristic in FORM else "a datum"
            raise ValueError(f"{self.characteristic} '{self.name}': has {len(self.datums)} datums, but needs {allowed}")


@dataclass(frozen=True)
class SurfaceTexture:
    """How smooth a face must be: its mean roughness Ra (ISO 21920), and how it is made so."""

    name: str
    roughness: float  # Ra, um
    parameter: str  # key of the parameter file the value comes from
    points: tuple[Point, ...]  # one on each such face
    normal: Point
    view: View
    process: str = ""  # how it is finished (`lapped`); empty where the maker may choose
    feature: str = ""  # name of the holes whose callout has it; empty for a mark on the face

    def __post_init__(self) -> None:
        _require_view(f"surface '{self.name}'", self.view)
        if not 0.0 < self.roughness < math.inf:
            raise ValueError(f"surface '{self.name}': {self.roughness} um is no roughness")


FaceRequirement = DatumFeature | GeometricTolerance | SurfaceTexture


def feature_of(requirement: FaceRequirement) -> str:
    """Name of the holes in whose callout a requirement is; empty for one on a face."""
    return "" if isinstance(requirement, DatumFeature) else requirement.feature
