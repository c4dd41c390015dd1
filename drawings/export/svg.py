"""A sheet as SVG in millimetres: a group for each line style; texts as outlines of their glyphs."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from xml.sax.saxutils import quoteattr

from drawings.annotations.font import WIDTH_FACTOR, cap_height, glyph_advance, glyph_outline
from drawings.annotations.primitives import LINE_TYPES, ArcStroke, Stroke, Text
from drawings.export.drawing_model import DrawingModel, bezier_curves, text_matrix, text_origin
from drawings.views.view import Point2


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
        if outline := glyph_outline(character):
            yield f'<path id="{_glyph_id(character)}" d="{outline}"/>'
    yield '</defs>\n<rect width="100%" height="100%" fill="white"/>'
    # The y axis of SVG points downward.
    yield f'<g transform="matrix(1 0 0 -1 0 {height:g})">'
    for (weight, line_type), strokes in drawing.strokes().items():
        dashes = " ".join(f"{length:g}" for length in LINE_TYPES[line_type])
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


def _outline(stroke: Stroke | ArcStroke) -> str:
    if isinstance(stroke, Stroke):
        return f"M{_numbers(stroke.points)}"
    start, curves = bezier_curves(stroke.arc)
    return f"M{_numbers([start])}" + "".join(f"C{_numbers(curve)}" for curve in curves)


def _numbers(points: Iterable[Point2]) -> str:
    return " ".join(f"{x:.3f} {y:.3f}" for x, y in points)


def _text(text: Text) -> Iterator[str]:
    """A text as a group of references to glyphs, in units of the font."""
    unit = text.height / cap_height()
    matrix = (*text_matrix(text, WIDTH_FACTOR * unit, unit), *text_origin(text))
    yield f'<g aria-label={quoteattr(text.text)} transform="matrix({" ".join(f"{v:.6g}" for v in matrix)})">'
    x = 0.0
    for character in text.text:
        if glyph_outline(character):
            yield f'<use href="#{_glyph_id(character)}" x="{x:g}"/>'
        x += glyph_advance(character)
    yield "</g>"


def _glyph_id(character: str) -> str:
    return f"u{ord(character):x}"
