"""The entities that a sheet is made of, put into its DXF document.

ezdxf checks each attribute of each entity by itself as it is set, which takes longer than all else that is done to
write a sheet. What is put here has the same few attributes every time, so entities are filled at once; a test holds
them against those that ezdxf makes.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from ezdxf.entities.arc import Arc as ArcEntity
from ezdxf.entities.circle import Circle as CircleEntity
from ezdxf.entities.line import Line as LineEntity
from ezdxf.entities.lwpolyline import LWPolyline as PolylineEntity
from ezdxf.entities.text import Text as TextEntity
from ezdxf.math import Vec3

from drawings.annotations.font import TEXT_STYLE, WIDTH_FACTOR
from drawings.annotations.primitives import ArcStroke, Primitive, Stroke, Text
from drawings.views.view import Arc, Point2

WIDE = 70
"""Weight of ink for the frame's layer where it stands in model space, hundredths of a millimetre."""
_ANCHORS = {"left": 0, "middle": 1, "right": 2}
"""How DXF numbers the places a text is put by."""


@dataclass(frozen=True)
class Place:
    """Where paper coordinates are in model space: at (p + shift) / scale."""

    scale: float = 1.0
    shift: Point2 = (0.0, 0.0)

    def __call__(self, point: Point2) -> Point2:
        return ((point[0] + self.shift[0]) / self.scale, (point[1] + self.shift[1]) / self.scale)

    def length(self, value: float) -> float:
        return value / self.scale


ON_PAPER = Place()


def dxf_text(text: str) -> str:
    """Text as every program that reads DXF shows it, whatever its font has."""
    return text.replace("⌀", "%%c").replace("°", "%%d").replace("±", "%%p")


def _add(layout: Any, entity: Any, attributes: dict[str, Any]) -> None:
    """An entity with these attributes, at the end of a layout."""
    doc, record = layout.doc, layout.block_record
    handle = doc.entitydb.next_handle()
    entity.doc = doc
    entity.dxf.__dict__.update(attributes, handle=handle, owner=record.dxf.handle)
    if layout.is_any_paperspace:
        entity.dxf.__dict__["paperspace"] = 1
    doc.entitydb[handle] = entity
    record.entity_space.add(entity)


def add_line(layout: Any, start: Point2, end: Point2, attributes: dict[str, Any]) -> None:
    """A straight line."""
    _add(layout, LineEntity(), {**attributes, "start": Vec3(*start), "end": Vec3(*end)})


def add_polyline(layout: Any, points: list[Point2], attributes: dict[str, Any]) -> None:
    """Straight lines through points."""
    entity = PolylineEntity()
    values = np.zeros((len(points), 5))
    values[:, :2] = points
    entity.lwpoints.values = values
    _add(layout, entity, attributes)


def add_arc(layout: Any, centre: Point2, radius: float, arc: Arc, attributes: dict[str, Any]) -> None:
    """A circle, or the part of it that an arc's angles say."""
    attributes = {**attributes, "center": Vec3(*centre), "radius": radius}
    if arc.end_angle - arc.start_angle > 359.999:
        _add(layout, CircleEntity(), attributes)
    else:
        _add(layout, ArcEntity(), {**attributes, "start_angle": arc.start_angle, "end_angle": arc.end_angle})


def add_words(layout: Any, words: Text, place: Place) -> None:
    """A line of text."""
    at = Vec3(*place(words.at))
    attributes = {
        "layer": "TEXT", "style": TEXT_STYLE, "width": WIDTH_FACTOR, "text": dxf_text(words.text),
        "height": float(place.length(words.height)), "rotation": float(words.angle),
        "insert": at, "align_point": at, "halign": _ANCHORS[words.alignment], "valign": 0,
    }  # fmt: skip
    _add(layout, TextEntity(), attributes)


def add_filled(layout: Any, points: list[Point2], attributes: dict[str, Any]) -> None:
    """A filled polygon."""
    if len(points) <= 4:
        # A SOLID runs through its corners crosswise.
        layout.add_solid([*points[:2], *reversed(points[2:])], dxfattribs=attributes)
    else:
        layout.add_hatch(dxfattribs=attributes).paths.add_polyline_path(points)


def put(layout: Any, ink: Primitive, place: Place, layer: str = "") -> None:
    """Some ink, on a layer or, if none is named, on its own in paper space and on that of dimensions in model space."""
    if isinstance(ink, Text):
        add_words(layout, ink, place)
        return
    attributes: dict[str, Any] = {"layer": layer or (ink.layer if layout.is_any_paperspace else "DIMENSION")}
    if not layout.is_any_paperspace and ink.layer == "FRAME":
        attributes = {"layer": "SECTION", "linetype": "CONTINUOUS", "lineweight": WIDE}
    if isinstance(ink, ArcStroke):
        add_arc(layout, place(ink.arc.centre), place.length(ink.arc.radius), ink.arc, attributes)
    elif isinstance(ink, Stroke):
        points = [place(point) for point in ink.points]
        if len(points) == 2:
            add_line(layout, points[0], points[1], attributes)
        else:
            add_polyline(layout, points, attributes)
    else:
        add_filled(layout, [place(point) for point in ink.points], attributes)
