"""A DXF document as text, the bytes that ezdxf itself would write, in a third of the time.

ezdxf asks of each entity whether it has any of some twenty attributes, one by one. The lines, circles, arcs, polylines
and texts of a sheet have few and always the same, so each is written here in one go. Whatever has more than that, and
everything else of the document, ezdxf writes; it also keeps the order.
"""

from __future__ import annotations

import io
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any

from ezdxf.document import Drawing

COMMON = frozenset(("handle", "owner", "layer", "paperspace", "linetype", "lineweight", "ltscale"))
"""Attributes that any entity written here may have."""


def document_text(doc: Drawing) -> str:
    """The document as a DXF file."""
    stream = io.StringIO()
    with _known_written_here(doc):
        doc.write(stream)
    return stream.getvalue()


@contextmanager
def _known_written_here(doc: Drawing) -> Iterator[None]:
    """Put stand-ins that know their text in the place of the entities that can be written here."""
    # Model space and paper spaces are blocks, too.
    spaces: list[Any] = [block.entity_space for block in doc.blocks]
    before = [space.entities for space in spaces]
    try:
        for space in spaces:
            space.entities = [_Written(text) if (text := entity_text(entity)) else entity for entity in space.entities]
        yield
    finally:
        for space, entities in zip(spaces, before, strict=True):
            space.entities = entities


class _Written:
    """Stands for an entity while a document is written."""

    is_alive = True

    def __init__(self, text: str) -> None:
        self._text = text

    def export_dxf(self, tagwriter: Any) -> None:
        tagwriter.write_str(self._text)


def entity_text(entity: Any) -> str | None:
    """An entity as it stands in a DXF file; none of what ezdxf has to write itself."""
    if entity.dxftype() not in _KINDS or entity.xdata or entity.appdata or entity.reactors or entity.has_extension_dict:
        return None
    own, write = _KINDS[entity.dxftype()]
    has = entity.dxf.all_existing_dxf_attribs()
    if not has.keys() <= COMMON | own:
        return None
    body = write(entity, has)
    return body and _head(entity.dxftype(), has) + body


def _head(kind: str, has: dict[str, Any]) -> str:
    """What every entity begins with; what is as by default is left out."""
    text = f"  0\n{kind}\n  5\n{has['handle']}\n330\n{has['owner']}\n100\nAcDbEntity\n"
    if has.get("paperspace"):
        text += f" 67\n{has['paperspace']}\n"
    text += f"  8\n{has['layer']}\n"
    if has.get("linetype", "BYLAYER") != "BYLAYER":
        text += f"  6\n{has['linetype']}\n"
    if has.get("lineweight", -1) != -1:
        text += f"370\n{has['lineweight']}\n"
    if has.get("ltscale", 1.0) != 1.0:
        text += f" 48\n{has['ltscale']}\n"
    return text


def _line(entity: Any, has: dict[str, Any]) -> str:
    return f"100\nAcDbLine\n{_point(10, has['start'])}{_point(11, has['end'])}"


def _circle(entity: Any, has: dict[str, Any]) -> str:
    return f"100\nAcDbCircle\n{_point(10, has['center'])} 40\n{has['radius']}\n"


def _arc(entity: Any, has: dict[str, Any]) -> str:
    return f"{_circle(entity, has)}100\nAcDbArc\n 50\n{has['start_angle']}\n 51\n{has['end_angle']}\n"


def _polyline(entity: Any, has: dict[str, Any]) -> str | None:
    values = entity.lwpoints.values
    if not len(values) or values[:, 2:].any():
        return None
    points = "".join(f" 10\n{x}\n 20\n{y}\n" for x, y, *_ in values.tolist())
    return f"100\nAcDbPolyline\n 90\n{len(values)}\n 70\n{has.get('flags', 0)}\n{points}"


def _text(entity: Any, has: dict[str, Any]) -> str:
    text = f"100\nAcDbText\n{_point(10, has['insert'])} 40\n{has['height']}\n  1\n{has['text']}\n"
    for code, name, usual in _OF_TEXT:
        if has.get(name, usual) != usual:
            text += f" {code}\n{has[name]}\n"
    if "align_point" in has:
        text += _point(11, has["align_point"])
    level = f" 73\n{has['valign']}\n" if has.get("valign") else ""
    return f"{text}100\nAcDbText\n{level}"


_OF_TEXT = ((50, "rotation", 0), (" 7", "style", "Standard"), (41, "width", 1), (72, "halign", 0))
"""Group codes, names and usual values."""


def _point(code: int, point: Any) -> str:
    return f" {code}\n{point.x}\n {code + 10}\n{point.y}\n {code + 20}\n{point.z}\n"


_KINDS: dict[str, tuple[frozenset[str], Callable[[Any, dict[str, Any]], str | None]]] = {
    "LINE": (frozenset(("start", "end")), _line),
    "CIRCLE": (frozenset(("center", "radius")), _circle),
    "ARC": (frozenset(("center", "radius", "start_angle", "end_angle")), _arc),
    "TEXT": (
        frozenset(("insert", "height", "text", "rotation", "style", "width", "halign", "valign", "align_point")),
        _text,
    ),
    "LWPOLYLINE": (frozenset(("flags",)), _polyline),
}
"""Of each kind the attributes it may have besides the common ones, and what writes them."""
