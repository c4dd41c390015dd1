"""SVG, PDF and PNG of a sheet, all from its DXF document: what is drawn there is what every format shows."""

from __future__ import annotations

from dataclasses import dataclass

from ezdxf.document import Drawing

from drawings.frame import Paper
from drawings.pdf import pdf
from drawings.png import png
from drawings.strokes import shown
from drawings.svg import svg


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
