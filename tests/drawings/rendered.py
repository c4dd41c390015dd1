"""Pictures of sheets: our own, and ezdxf's of the DXF document."""

import io
from dataclasses import replace

import numpy as np
import pytest
from PIL import Image
from scipy.ndimage import minimum_filter

from drawings.annotations.primitives import LAYERS, ArcStroke, LineStyle, Primitive, Stroke, font_path
from drawings.export.drawing_model import DrawingModel
from drawings.export.dxf import dxf_document
from drawings.export.pdf import DPI, pdf_bytes, png_bytes

DARK, LIGHT = 110, 200
"""Grey of what is surely drawn, and of what is surely not."""


def picture_of(drawing: DrawingModel) -> np.ndarray:
    return np.asarray(Image.open(io.BytesIO(png_bytes(pdf_bytes(drawing), drawing.paper))))


def continuous(drawing: DrawingModel) -> DrawingModel:
    """A drawing with all lines continuous."""

    def unbroken(primitive: Primitive) -> Primitive:
        if isinstance(primitive, Stroke | ArcStroke):
            return replace(primitive, style=LineStyle((primitive.style or LAYERS[primitive.layer]).weight))
        return primitive

    groups = (replace(group, primitives=tuple(map(unbroken, group.primitives))) for group in drawing.groups)
    return replace(drawing, groups=tuple(groups))


def rendered_by_ezdxf(drawing: DrawingModel) -> np.ndarray:
    """The paper space of the drawing's DXF document as ezdxf's drawing add-on paints it with matplotlib."""
    from ezdxf.addons.drawing import config
    from ezdxf.addons.drawing.frontend import Frontend
    from ezdxf.addons.drawing.matplotlib import MatplotlibBackend
    from ezdxf.addons.drawing.properties import RenderContext
    from ezdxf.fonts import fonts
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    fonts.font_manager.build([str(font_path().parent)])
    document = dxf_document(drawing)
    width, height = drawing.size
    figure = Figure((width / 25.4, height / 25.4), dpi=DPI[drawing.paper])
    axes = figure.add_axes((0.0, 0.0, 1.0, 1.0))
    backend = MatplotlibBackend(axes, adjust_figure=False)
    settings = config.Configuration(
        lineweight_policy=config.LineweightPolicy.ABSOLUTE,
        # Its matplotlib backend takes millimetres for points.
        lineweight_scaling=72 / 25.4,
        text_policy=config.TextPolicy.FILLING,
        color_policy=config.ColorPolicy.BLACK,
        background_policy=config.BackgroundPolicy.WHITE,
    )
    Frontend(RenderContext(document), backend, config=settings).draw_layout(document.paperspace())
    axes.set(xlim=(0.0, width), ylim=(0.0, height), aspect="auto")
    canvas = FigureCanvasAgg(figure)
    canvas.draw()
    return np.asarray(canvas.buffer_rgba())[..., :3].mean(axis=2)


def assert_same_picture(drawing: DrawingModel) -> None:
    """What is drawn in the PNG is drawn in ezdxf's rendering of the DXF, and the other way round."""
    # ezdxf draws line types of viewports that are not 1:1 too long.
    unbroken = continuous(drawing)
    ours, theirs = picture_of(unbroken), rendered_by_ezdxf(unbroken)
    height, width = (min(sides) for sides in zip(ours.shape, theirs.shape, strict=True))
    ours, theirs = ours[:height, :width], theirs[:height, :width]
    assert (ours < DARK).sum() == pytest.approx((theirs < DARK).sum(), rel=0.1)
    for one, other in ((ours, theirs), (theirs, ours)):
        without = (one < DARK) & (minimum_filter(other, 7) > LIGHT)
        assert without.sum() == 0
