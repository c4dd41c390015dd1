"""Widths and outlines of the font against ezdxf's measurement; texts with symbols."""

import re
from typing import get_args

import pytest
from ezdxf.fonts import fonts

from drawings.annotations import primitives
from drawings.annotations.annotation import primitive_box
from drawings.annotations.symbols import symbol_primitives, symbol_text_primitives, symbol_text_width, symbol_width


@pytest.mark.parametrize("text", ["A", "2x 40.00", "Ø16 ±0.01°", "NOTES", "a b  c"])
def test_the_width_of_a_text_is_that_of_its_glyphs(text: str) -> None:
    font = fonts.sideload_ttf(primitives.font_path(), 1.0)
    assert primitives.text_width(text, 5.0) == pytest.approx(font.text_width_ex(text, 5.0, primitives.WIDTH_FACTOR))


def test_outlines_of_letters_and_widths_of_texts_with_symbols() -> None:
    numbers = [float(number) for number in re.findall(r"-?\d+\.?\d*", primitives.glyph_outline("L"))]
    assert max(numbers) == primitives.cap_height() and min(numbers) == 0.0 and primitives.glyph_outline(" ") == ""
    assert primitives.glyph_advance(" ") > 0
    assert primitives.glyph_outline("\U000f0000") == primitives.glyph_outline("\U000f0001") != ""
    assert primitives.printed("2x ⌀8.0") == "2x Ø8.0"
    text = "4x ⌀6.6 {depth} 12.0"
    plain = primitives.text_width("4x ⌀6.6 ") + primitives.text_width(" 12.0")
    assert symbol_text_width(text) == pytest.approx(plain + symbol_width("depth") + 0.7 * primitives.TEXT_HEIGHT)
    first, *_, last = symbol_text_primitives(text, (10.0, 20.0))
    assert isinstance(first, primitives.Text) and isinstance(last, primitives.Text)
    assert (first.text, first.at) == ("4x ⌀6.6 ", (10.0, 20.0))
    assert last.at[0] + primitives.text_width(last.text) == pytest.approx(10.0 + symbol_text_width(text))


@pytest.mark.parametrize("symbol", get_args(primitives.Symbol))
def test_a_symbol_is_within_its_width_and_near_the_height_of_capitals(symbol: primitives.Symbol) -> None:
    boxes = [primitive_box(primitive) for primitive in symbol_primitives(symbol, (10.0, 20.0), 5.0)]
    assert min(box[0] for box in boxes) >= 10.0 - 1e-9
    assert max(box[2] for box in boxes) <= 10.0 + symbol_width(symbol, 5.0) + 1e-9
    assert 20.0 - 1.0 - 1e-9 <= min(box[1] for box in boxes) <= max(box[3] for box in boxes) <= 20.0 + 6.0 + 1e-9
