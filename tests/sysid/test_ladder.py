"""Effects added to a model: the error that a diagnosis states, and a warning where the held-out error rises."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from sysid.diagnose import diagnose
from sysid.ladder import add_effects
from tests.sysid.slide import POSITION, SIGN, VELOCITY, slide


def test_the_model_added_has_the_error_that_the_diagnosis_states(tmp_path: Path) -> None:
    force = 1.5 * SIGN + 20.0 * VELOCITY + 0.2 * np.sin(2.0 * np.pi * POSITION / 3e-4)
    problem = slide(tmp_path, force, '"coulomb", "viscous"', held_out=True)
    trial = next(t for t in diagnose(problem).trials if t.public_name == "magnetic_cogging")

    step = add_effects(tmp_path, ["magnetic_cogging"])

    stated, found = (m["friction_force"].over_noise for m in (trial.after_validate, step.after_validate))
    assert found == pytest.approx(stated, rel=0.02)
    assert found < 1.2 and step.warnings == []
    worse = replace(step, after_validate=step.before_validate, before_validate=step.after_validate)
    assert "the held-out error rises from" in worse.warnings[0]
