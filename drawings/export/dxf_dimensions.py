"""DIMENSION entities: their points, their text with `<>` for what is measured, and the style they are written in.

The picture of a dimension (its block) is drawn by this program, so that it is the same in every other, and the text
stands where the layout put it; a program that opens the file measures for itself.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

from drawings.annotations.annotation import AngularDimension, LinearDimension, RadialDimension
from drawings.annotations.font import TEXT_HEIGHT, TEXT_STYLE
from drawings.annotations.primitives import Primitive, Text
from drawings.export.dxf_entities import Place, dxf_text, put
from drawings.sheets.sheet import scale_text
from drawings.views.view import Point2, View


def add_dimension(
    doc: Any,
    d: LinearDimension | RadialDimension | AngularDimension,
    view: View,
    inks: Sequence[Primitive],
    place: Place,
) -> None:
    """A DIMENSION with its picture, in the style of its scale and decimals."""
    block = doc.blocks.new_anonymous_block(type_char="D")
    for ink in inks:
        put(block, ink, place, "DIMENSION")
    text, decimals = measured_text(d)

    def at(point: Point2) -> Any:
        return (*place(view.to_paper(point)), 0.0)

    attributes: dict[str, Any] = {
        "layer": "DIMENSION",
        "geometry": block.name,
        "dimstyle": _style(doc, place.scale, decimals),
        "text": dxf_text(text),
        "attachment_point": 5,
    }
    middles = [words for words in inks if isinstance(words, Text)]
    if middles:
        attributes["text_midpoint"] = (*place(_middle(middles[0])), 0.0)
    if isinstance(d, LinearDimension):
        attributes |= {
            "dimtype": 0 | 32 | 128,
            "defpoint": (*place(_on_line(d, view)), 0.0),
            "defpoint2": at(d.first),
            "defpoint3": at(d.second),
            "angle": d.angle,
        }
    elif isinstance(d, AngularDimension):
        attributes |= {
            "dimtype": 5 | 32 | 128,
            "defpoint": (*place(d.arc_at), 0.0),
            "defpoint2": at(d.first),
            "defpoint3": at(d.second),
            "defpoint4": at(d.vertex),
        }
    else:
        turn = math.radians(d.towards)
        out = (d.radius * math.cos(turn), d.radius * math.sin(turn))
        on = (d.centre[0] + out[0], d.centre[1] + out[1])
        opposite = (d.centre[0] - out[0], d.centre[1] - out[1])
        attributes |= {
            "dimtype": (3 if d.kind == "diameter" else 4) | 32 | 128,
            "defpoint": at(opposite if d.kind == "diameter" else d.centre),
            "defpoint4": at(on),
        }
    entity = doc.modelspace().new_entity("DIMENSION", attributes)
    entity.dxf.actual_measurement = (
        entity.get_measurement() if not isinstance(d, AngularDimension) else math.radians(d.measured)
    )


def measured_text(d: LinearDimension | RadialDimension | AngularDimension) -> tuple[str, int]:
    """A dimension's text with `<>` for the measured number, and the decimals that number has.

    Raises:
        ValueError: the text does not say what was measured.
    """
    for decimals in range(4, -1, -1):
        number = f"{d.measured:.{decimals}f}"
        start = d.text.find(number)
        while start >= 0:
            end = start + len(number)
            if not d.text[start - 1 : start].isdigit() and not d.text[end : end + 1].isdigit():
                return f"{d.text[:start]}<>{d.text[end:]}", decimals
            start = d.text.find(number, start + 1)
    raise ValueError(f"dimension {', '.join(d.names)} says '{d.text}', but measures {d.measured:.4f}")


def _middle(words: Text) -> Point2:
    turn = math.radians(words.angle)
    return (words.at[0] - math.sin(turn) * words.height / 2, words.at[1] + math.cos(turn) * words.height / 2)


def _on_line(d: LinearDimension, view: View) -> Point2:
    """Where the dimension line is met from the second point, as DXF wants it."""
    turn = math.radians(d.angle)
    u = (math.cos(turn), math.sin(turn))
    point = view.to_paper(d.second)
    along = (point[0] - d.line_at[0]) * u[0] + (point[1] - d.line_at[1]) * u[1]
    return (d.line_at[0] + along * u[0], d.line_at[1] + along * u[1])


def _style(doc: Any, scale: float, decimals: int) -> str:
    """Name of the dimension style for a scale and a number of decimals; made when it is not there."""
    name = f"{scale_text(scale).replace(':', '-')} {decimals} decimals"
    if name not in doc.dimstyles:
        style = doc.dimstyles.new(name)
        # All trailing zeros are kept, since decimals are the tolerance class.
        decimals_kept = {"dimdec": decimals, "dimzin": 0, "dimadec": decimals, "dimazin": 0}
        text = {"dimtxt": TEXT_HEIGHT, "dimtxsty": TEXT_STYLE, "dimgap": 1.0, "dimdsep": ord("."), "dimlunit": 2}
        lines = {"dimscale": 1.0 / scale, "dimasz": 3.0, "dimexe": 2.0, "dimexo": 1.0}
        placement = {"dimtad": 1, "dimtih": 0, "dimtoh": 0, "dimtofl": 1, "dimtmove": 2}
        values = {**lines, **text, **placement, **decimals_kept}
        for key, value in values.items():
            style.dxf.set(key, value)
    return name
