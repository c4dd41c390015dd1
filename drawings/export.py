"""SVG, PDF and PNG of a sheet, all from its DXF document: what is drawn there is what every format shows.

ezdxf's drawing add-on resolves the paper space once, text as outlines of the lettering font; the three formats are
written from that one recording.
"""

from __future__ import annotations

import io
from dataclasses import dataclass

import numpy as np
from ezdxf.addons.drawing import config, layout, recorder
from ezdxf.addons.drawing.frontend import Frontend
from ezdxf.addons.drawing.properties import RenderContext
from ezdxf.addons.drawing.svg import SVGBackend
from ezdxf.document import Drawing
from ezdxf.math import BoundingBox2d
from ezdxf.npshapes import to_matplotlib_path
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.backends.backend_pdf import FigureCanvasPdf
from matplotlib.collections import PathCollection
from matplotlib.figure import Figure
from matplotlib.path import Path
from PIL import Image

from drawings.frame import PAPERS, Paper

DPI: dict[Paper, float] = {"A4": 200, "A3": 200, "A2": 150, "A1": 110}
"""Resolution of the PNG: some 3500 pixels wide, so that the smallest lettering is read."""
INCH = 25.4
POINTS = 72.0


@dataclass(frozen=True)
class Renderings:
    """The sheet in the formats that people open."""

    svg: bytes
    pdf: bytes
    png: bytes


def render(doc: Drawing, paper: Paper) -> Renderings:
    """SVG, PDF and PNG of a document's paper space; SVG and PDF are the same bytes for the same document."""
    recorded = _recorded(doc)
    # The SVG moves what was recorded to its own coordinates, so it comes last.
    figure = _figure(recorded, paper)
    pdf, png = _pdf(figure), _png(figure, DPI[paper])
    return Renderings(_svg(recorded, paper), pdf, png)


def _recorded(doc: Drawing) -> SVGBackend:
    """Strokes and filled outlines of the paper space, mm."""
    settings = config.Configuration(
        background_policy=config.BackgroundPolicy.WHITE,
        color_policy=config.ColorPolicy.BLACK,
        lineweight_policy=config.LineweightPolicy.ABSOLUTE,
        text_policy=config.TextPolicy.FILLING,
        max_flattening_distance=0.02,
    )
    backend = SVGBackend()
    Frontend(RenderContext(doc), backend, config=settings).draw_layout(doc.paperspace())
    return backend


def _svg(recorded: SVGBackend, paper: Paper) -> bytes:
    width, height = PAPERS[paper]
    page = layout.Page(width, height, layout.Units.mm, margins=layout.Margins.all(0))
    whole = BoundingBox2d([(0.0, 0.0), (width, height)])
    settings = layout.Settings(fit_page=False, scale=1.0)
    return recorded.get_string(page, settings=settings, render_box=whole).encode("utf-8")


def _figure(recorded: SVGBackend, paper: Paper) -> Figure:
    """The recording as a matplotlib figure of the paper's size: one collection for each weight, one for what is filled.

    (The add-on's own matplotlib backend makes an artist of each stroke, and is slow for it.)
    """
    width, height = PAPERS[paper]
    figure = Figure(figsize=(width / INCH, height / INCH), facecolor="white")
    axes = figure.add_axes((0.0, 0.0, 1.0, 1.0), frameon=False)
    axes.set_axis_off()
    axes.set_xlim(0.0, width)
    axes.set_ylim(0.0, height)
    strokes: dict[float, list[Path]] = {}
    fills: list[Path] = []
    for record in recorded.records:
        weight = recorded.properties[record.property_hash].lineweight
        if isinstance(record, recorder.FilledPathsRecord):
            fills.append(to_matplotlib_path([path for path in record.paths if len(path)]))
        elif isinstance(record, recorder.PathRecord):
            strokes.setdefault(weight, []).append(to_matplotlib_path([record.path]))
        elif isinstance(record, recorder.SolidLinesRecord):
            ends = record.lines.np_vertices()
            strokes.setdefault(weight, []).extend(Path(ends[i : i + 2]) for i in range(0, len(ends), 2))
        elif isinstance(record, recorder.PointsRecord):
            points = record.points.np_vertices()
            if len(points) > 2:
                fills.append(Path(points, closed=False))
            else:
                strokes.setdefault(weight, []).append(Path(points))
    for weight, paths in sorted(strokes.items()):
        axes.add_collection(
            PathCollection(
                paths, facecolors="none", edgecolors="black", linewidths=weight * POINTS / INCH, capstyle="round",
                joinstyle="round", antialiaseds=True,
            ),
            autolim=False,
        )  # fmt: skip
    axes.add_collection(PathCollection(fills, facecolors="black", edgecolors="none"), autolim=False)
    return figure


def _pdf(figure: Figure) -> bytes:
    stream = io.BytesIO()
    FigureCanvasPdf(figure).print_pdf(stream, metadata={"CreationDate": None, "Creator": "stagecad"})
    return stream.getvalue()


def _png(figure: Figure, dpi: float) -> bytes:
    """Black on white needs one channel: a quarter of the bytes, and a quarter of the time."""
    figure.set_dpi(dpi)
    canvas = FigureCanvasAgg(figure)
    canvas.draw()
    stream = io.BytesIO()
    Image.fromarray(np.asarray(canvas.buffer_rgba())[..., 0]).save(stream, "png", dpi=(dpi, dpi))
    return stream.getvalue()
