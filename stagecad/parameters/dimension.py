"""Plain data for what stands beside each solid: its named datums, and its dimension declarations.

A part declares each dimension next to the feature that needs it; the drawings lay the declarations out, the tolerance
analysis adds them up, the assembly mates the datums. No type here knows a solid. Millimetres and degrees, in part
coordinates.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Literal

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
]
"""What a dimension measures.

`linear`, `depth`: distance between two points. `diameter`, `radius`: of a round feature. `angle`: in degrees.
`chamfer`: leg of a chamfer, 45 degrees unless the note says otherwise. `thread`: nominal diameter, the note carries
the designation; `tap_drill` and `thread_depth` of the same hole. `slope`: tangent of the angle
between a face and the direction. `count`: number of features of a pattern. `callout`: a
note on a feature, with the number it speaks of.
"""

View = Literal["top", "bottom", "front", "back", "left", "right", "section", "iso", "any"]
"""The view in which a dimension reads best: `top` looks down z, `front` along +y (x to the right), `right` along -x."""


@dataclass(frozen=True)
class Datum:
    """A named frame of a part: a face, an axis, or a place.

    Args:
        name: as in the part's contract (`top`, `pad_1`).
        origin: point in part coordinates, mm.
        normal: unit vector, out of the material of a face, along an axis.
        x_direction: unit vector at right angles to the normal.
    """

    name: str
    origin: Point
    normal: Point
    x_direction: Point = (1.0, 0.0, 0.0)

    def __post_init__(self) -> None:
        for vector in (self.normal, self.x_direction):
            if abs(math.hypot(*vector) - 1.0) > 1e-9:
                raise ValueError(f"datum '{self.name}': {vector} is no unit vector")
        if abs(sum(a * b for a, b in zip(self.normal, self.x_direction))) > 1e-9:
            raise ValueError(f"datum '{self.name}': normal and x direction are not at right angles")

    @property
    def y_direction(self) -> Point:
        """Third axis of the right-handed frame (x direction, y direction, normal)."""
        (a, b, c), (u, v, w) = self.normal, self.x_direction
        return (b * w - c * v, c * u - a * w, a * v - b * u)


@dataclass(frozen=True)
class Dimension:
    """One dimension of a part, declared beside the feature that needs it.

    Args:
        name: what is measured, unique within the part (`length`, `pocket depth`).
        kind: see `Kind`.
        value: mm, or degrees for an angle; for a count or callout the number it speaks of.
        parameter: key of the parameter file the value comes from (`stage.length`).
        points: where to look on the part, part coordinates: two for linear and depth; for round ones a point on the
            axis beside the face, or on the face.
        direction: direction measured along, or the axis of a round feature; from point to point when left out.
        tolerance: class `X`, `X.X` or `X.XX`; none for a reference dimension or one a standard covers.
        note: callout text that goes with it (`M6x1 - 6H`, `lapped Ra 1 um`).
        count: number of like features it stands for.
        view: where it reads best.
        feature: name of the feature it belongs to; what belongs to one hole is gathered in one callout.
        between: names of the datums or features it stands between, where they have names.
    """

    name: str
    kind: Kind
    value: float
    parameter: str
    points: tuple[Point, ...] = ()
    direction: Point | None = None
    tolerance: str | None = None
    note: str = ""
    count: int = 1
    view: View = "any"
    feature: str = ""
    between: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        if self.kind in ("linear", "depth") and len(self.points) != 2:
            raise ValueError(f"dimension '{self.name}': a {self.kind} dimension stands between two points")
        if not math.isfinite(self.value):
            raise ValueError(f"dimension '{self.name}': {self.value} is no value")
        if self.count < 1:
            raise ValueError(f"dimension '{self.name}': stands for {self.count} features")
