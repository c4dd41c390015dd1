"""The page of effects is what the declarations make of it, and says what a reader needs of each."""

import importlib.util
from pathlib import Path

import pytest

from sim.effects.catalogue import library
from sim.effects.effect import Effect

DOCS = Path(__file__).resolve().parents[2] / "docs"


def test_page_is_up_to_date() -> None:
    spec = importlib.util.spec_from_file_location("make_effects", DOCS / "make_effects.py")
    assert spec is not None and spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    written = (DOCS / "effects.md").read_text(encoding="utf-8")
    assert written == module.page(), "declarations have changed: run 'python docs/make_effects.py'"


@pytest.mark.parametrize("effect", library().values(), ids=lambda effect: effect.name)
def test_each_effect_says_what_it_is_how_it_shows_and_who_says_so(effect: Effect) -> None:
    assert effect.meaning and effect.shows and effect.source
    # A constant force is the same against every coordinate.
    assert effect.coordinates or effect.name == "constant_bias"
    for parameter in effect.parameters:
        assert parameter.meaning and parameter.source
