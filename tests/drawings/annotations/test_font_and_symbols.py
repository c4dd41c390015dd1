"""Widths and outlines of the font against ezdxf's measurement; texts with symbols."""

import re
from typing import get_args

import pytest
from ezdxf.fonts import fonts

from drawings.annotations.annotation import primitive_box
from drawings.annotations.primitives import (
    TEXT_HEIGHT,
    WIDTH_FACTOR,
    Symbol,
    Text,
    cap_height,
    font_path,
    glyph_advance,
    glyph_outline,
    printed,
    text_width,
)
from drawings.annotations.symbols import symbol_primitives, symbol_text_primitives, symbol_text_width, symbol_width


@pytest.mark.parametrize("text", ["A", "2x 40.00", "Ø16 ±0.01°", "NOTES", "a b  c"])
def test_the_width_of_a_text_is_that_of_its_glyphs(text: str) -> None:
    font = fonts.sideload_ttf(font_path(), 1.0)
    assert text_width(text, 5.0) == pytest.approx(font.text_width_ex(text, 5.0, WIDTH_FACTOR))


def test_outlines_of_letters_and_widths_of_texts_with_symbols() -> None:
    numbers = [float(number) for number in re.findall(r"-?\d+\.?\d*", glyph_outline("L"))]
    assert max(numbers) == cap_height() and min(numbers) == 0.0
    assert glyph_outline(" ") == ""
    assert glyph_advance(" ") > 0
    assert glyph_outline("\U000f0000") == glyph_outline("\U000f0001") != ""
    assert printed("2x ⌀8.0") == "2x Ø8.0"
    text = "4x ⌀6.6 {depth} 12.0"
    plain = text_width("4x ⌀6.6 ") + text_width(" 12.0")
    assert symbol_text_width(text) == pytest.approx(plain + symbol_width("depth") + 0.7 * TEXT_HEIGHT)
    first, *_, last = symbol_text_primitives(text, (10.0, 20.0))
    assert isinstance(first, Text) and isinstance(last, Text)
    assert (first.text, first.at) == ("4x ⌀6.6 ", (10.0, 20.0))
    assert last.at[0] + text_width(last.text) == pytest.approx(10.0 + symbol_text_width(text))


@pytest.mark.parametrize("symbol", get_args(Symbol))
def test_a_symbol_is_within_its_width_and_near_the_height_of_capitals(symbol: Symbol) -> None:
    boxes = [primitive_box(primitive) for primitive in symbol_primitives(symbol, (10.0, 20.0), 5.0)]
    assert min(box[0] for box in boxes) >= 10.0 - 1e-9
    assert max(box[2] for box in boxes) <= 10.0 + symbol_width(symbol, 5.0) + 1e-9
    assert 20.0 - 1.0 - 1e-9 <= min(box[1] for box in boxes) <= max(box[3] for box in boxes) <= 20.0 + 6.0 + 1e-9
