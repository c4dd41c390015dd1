"""Effects that leave little where one looks first: at rest, after a rest, at one frequency, within the bristles."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from generator import Plan, make_case

from sysid.diagnose import diagnose


@pytest.mark.parametrize(
    "rig,effect,seed",
    [
        ("spring-pull", "presliding", 2),
        ("force-drive", "dwell_strengthening", 3),
        ("force-drive", "flexible_mode", 4),
        ("velocity-drive", "bristle_damping", 7),
        ("actuator-tip", "flexible_mode", 6),
    ],
)
def test_it_is_named_first(tmp_path: Path, rig: str, effect: str, seed: int) -> None:
    case = make_case(Plan(rig, (effect,), "moderate", rows=10000), np.random.default_rng(seed))
    case.write(tmp_path)
    found = diagnose(tmp_path)
    assert found.verdict == "missing-effect"
    assert effect in (found.effect, *found.indistinguishable)
