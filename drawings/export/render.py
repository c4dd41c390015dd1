"""SVG, PDF and PNG of a sheet, all from its DXF document: what is drawn there is what every format shows."""

from __future__ import annotations

from dataclasses import dataclass

from ezdxf.document import Drawing

from drawings.export.pdf import pdf
from drawings.export.png import png
from drawings.export.strokes import shown
from drawings.export.svg import svg
from drawings.sheets.frame import Paper


@dataclass(frozen=True)
class Renderings:
    """The sheet in the formats that people open."""

    svg: bytes
    pdf: bytes
    png: bytes


def render(doc: Drawing, paper: Paper) -> Renderings:
    """SVG, PDF and PNG of a document's paper space, the same bytes for the same document."""
    seen = shown(doc)
    return Renderings(svg(seen, paper), pdf(seen, paper), png(seen, paper))
