"""A misfit that one law of the library explains in part only: the law is named, then the rest stays unexplained."""

from pathlib import Path

import numpy as np
import pytest

from sysid.diagnose import diagnose
from tests.sysid.slide import POSITION, SIGN, slide


def _wave(pitch: float) -> np.ndarray:
    return np.sin(2 * np.pi * POSITION / pitch)


@pytest.mark.slow
def test_the_strongest_of_three_pitches_is_named_and_the_others_stay_unexplained(tmp_path: Path) -> None:
    strongest, others = 0.08 * _wave(1.9e-3), 0.035 * (_wave(1.13e-3) + _wave(0.67e-3))
    force = (1.5 + strongest + others) * SIGN
    first = diagnose(slide(tmp_path / "one", force, '"coulomb"', held_out=True))
    assert (first.verdict, first.effect) == ("missing-effect", "position_dependent_friction")
    # Of the variance of the texture, the waves being nearly uncorrelated.
    rest = np.var(others) / np.var(strongest + others)
    assert 0.2 < rest < 0.4
    assert first.unexplained_share == pytest.approx(rest, abs=0.08)
    second = diagnose(slide(tmp_path / "two", force, '"coulomb", "position_dependent_friction"', held_out=True))
    assert second.verdict == "unexplained"
    assert second.maps[0].coordinate == "position"
