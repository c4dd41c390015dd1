"""A sheet as SVG, as a page of PDF with selectable text in an embedded font, and the picture of that page."""

import io
from collections.abc import Iterable, Iterator
from typing import Any
from xml.sax.saxutils import quoteattr

from drawings.annotations import primitives
from drawings.export.drawing_model import DrawingModel, bezier_curves, text_matrix, text_origin
from drawings.sheets.frame import Paper
from drawings.views.view import Point2

DPI: dict[Paper, float] = {"A4": 200, "A3": 200, "A2": 150, "A1": 110, "A0": 90}
"""Resolution of pictures: some 3500 pixels wide, so that the smallest texts can be read."""
POINTS = 72.0
"""Units of a PDF page per inch."""
INCH = 25.4


def pdf_bytes(drawing: DrawingModel) -> bytes:
    """The page, written by reportlab; the same bytes for the same sheet."""
    from reportlab import rl_config
    from reportlab.pdfbase import pdfmetrics
    from reportlab.pdfbase.ttfonts import TTFont
    from reportlab.pdfgen.canvas import Canvas

    pdfmetrics.registerFont(TTFont(primitives.FONT, str(primitives.font_path())))
    # Compressed streams as bytes; as text of base 85 they are a quarter longer.
    rl_config.useA85 = 0
    data = io.BytesIO()
    width, height = (side * POINTS / INCH for side in drawing.size)
    # An invariant file has no time and no random identifier.
    canvas = Canvas(data, (width, height), pageCompression=1, invariant=1)
    canvas.setTitle(drawing.name)
    canvas.setAuthor("stagecad")
    canvas.setCreator("stagecad")
    canvas.setSubject("technical drawing")
    canvas.scale(POINTS / INCH, POINTS / INCH)
    canvas.setLineCap(1)
    canvas.setLineJoin(1)
    for (weight, line_type), strokes in drawing.strokes().items():
        canvas.setLineWidth(weight)
        canvas.setDash(primitives.LINE_TYPES[line_type])
        path = canvas.beginPath()
        for stroke in strokes:
            _add(path, stroke)
        canvas.drawPath(path)
    for polygon in drawing.polygons():
        # Each by itself: areas of one path that overlap would cancel out.
        path = canvas.beginPath()
        _add(path, primitives.Stroke(polygon.points))
        canvas.drawPath(path, stroke=0, fill=1)
    texts = canvas.beginText()
    for text in drawing.texts():
        texts.setFont(primitives.FONT, text.height * primitives.em_over_cap_height())
        texts.setTextTransform(*text_matrix(text, primitives.WIDTH_FACTOR, 1.0), *text_origin(text))
        texts.textOut(text.text)
    canvas.drawText(texts)
    canvas.showPage()
    canvas.save()
    return data.getvalue()


def _add(path: Any, stroke: primitives.Stroke | primitives.ArcStroke) -> None:
    """Add a line or an arc to a path of reportlab."""
    if isinstance(stroke, primitives.Stroke):
        path.moveTo(*stroke.points[0])
        for point in stroke.points[1:]:
            path.lineTo(*point)
        return
    start, curves = bezier_curves(stroke.arc)
    path.moveTo(*start)
    for first, second, end in curves:
        path.curveTo(*first, *second, *end)


def png_bytes(pdf: bytes, paper: Paper) -> bytes:
    """The picture of a page in grey, rendered by PDFium; the same bytes for the same page."""
    from pypdfium2 import PdfDocument

    dpi = DPI[paper]
    document = PdfDocument(pdf)
    picture = document[0].render(scale=dpi / POINTS, grayscale=True).to_pil()  # type: ignore[arg-type]
    data = io.BytesIO()
    picture.save(data, "PNG", dpi=(dpi, dpi))
    document.close()
    return data.getvalue()


def svg_bytes(drawing: DrawingModel) -> bytes:
    """The file; the same bytes for the same sheet."""
    return "\n".join(_lines(drawing)).encode("utf-8")


def _lines(drawing: DrawingModel) -> Iterator[str]:
    width, height = drawing.size
    texts = drawing.texts()
    yield f'<svg xmlns="http://www.w3.org/2000/svg" width="{width:g}mm" height="{height:g}mm"'
    yield f' viewBox="0 0 {width:g} {height:g}" stroke-linecap="round" stroke-linejoin="round">'
    yield "<defs>"
    for character in sorted({character for text in texts for character in text.text}):
        if outline := primitives.glyph_outline(character):
            yield f'<path id="{_glyph_id(character)}" d="{outline}"/>'
    yield '</defs>\n<rect width="100%" height="100%" fill="white"/>'
    # The y axis of SVG points downward.
    yield f'<g transform="matrix(1 0 0 -1 0 {height:g})">'
    for (weight, line_type), strokes in drawing.strokes().items():
        dashes = " ".join(f"{length:g}" for length in primitives.LINE_TYPES[line_type])
        dashed = f' stroke-dasharray="{dashes}"' if dashes else ""
        yield f'<g fill="none" stroke="black" stroke-width="{weight:g}"{dashed}>'
        yield from (f'<path d="{_outline(stroke)}"/>' for stroke in strokes)
        yield "</g>"
    yield "<g>"
    yield from (f'<path d="M{_numbers(polygon.points)}z"/>' for polygon in drawing.polygons())
    yield "</g>"
    for text in texts:
        yield from _text(text)
    yield "</g>\n</svg>\n"


def _outline(stroke: primitives.Stroke | primitives.ArcStroke) -> str:
    if isinstance(stroke, primitives.Stroke):
        return f"M{_numbers(stroke.points)}"
    start, curves = bezier_curves(stroke.arc)
    return f"M{_numbers([start])}" + "".join(f"C{_numbers(curve)}" for curve in curves)


def _numbers(points: Iterable[Point2]) -> str:
    return " ".join(f"{x:.3f} {y:.3f}" for x, y in points)


def _text(text: primitives.Text) -> Iterator[str]:
    """A text as a group of references to glyphs, in units of the font."""
    unit = text.height / primitives.cap_height()
    matrix = (*text_matrix(text, primitives.WIDTH_FACTOR * unit, unit), *text_origin(text))
    yield f'<g aria-label={quoteattr(text.text)} transform="matrix({" ".join(f"{v:.6g}" for v in matrix)})">'
    x = 0.0
    for character in text.text:
        if primitives.glyph_outline(character):
            yield f'<use href="#{_glyph_id(character)}" x="{x:g}"/>'
        x += primitives.glyph_advance(character)
    yield "</g>"


def _glyph_id(character: str) -> str:
    return f"u{ord(character):x}"
