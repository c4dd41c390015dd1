"""Residuals that no law of the library explains stay unexplained, though one law removes a large part."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from sysid.diagnose import diagnose
from tests.sysid.slide import POSITION, SIGN, slide


def _wave(pitch: float) -> np.ndarray:
    return np.sin(2 * np.pi * POSITION / pitch)


@pytest.mark.xfail(
    strict=True, reason="the wave removes 0.67 of the excess, which is sufficient; then the rest is unexplained"
)
def test_texture_of_several_pitches_is_not_attributed_to_one_wave(tmp_path: Path) -> None:
    texture = 0.08 * _wave(1.9e-3) + 0.035 * (_wave(1.13e-3) + _wave(0.67e-3))
    problem = slide(tmp_path, (1.5 + texture) * SIGN, '"coulomb"', held_out=True)
    found = diagnose(problem)
    assert found.trials[0].public_name == "position_dependent_friction"
    assert found.decision.best_named is not None
    assert found.decision.best_named[1] > 0.5
    assert found.verdict == "unexplained"
    assert found.maps[0].coordinate == "position"
