"""A diagnosis names an effect of the user's own that it could not try."""

from dataclasses import replace
from pathlib import Path

import numpy as np

from sim import Effect, Parameter
from sysid.diagnose import diagnose
from tests.sysid.slide import SIGN, slide


def test_an_own_effect_that_is_not_finite_on_the_records_is_named(tmp_path: Path) -> None:
    own = Effect(
        "root",
        "root of the position",
        force=lambda axis, p: p.strength * np.sqrt(-1.0 - axis.position**2),
        parameters=(Parameter("strength", "N/m", 1.0, 0.0, 9.0, "size", "assumed"),),
    )
    problem = slide(tmp_path, 1.5 * SIGN, '"coulomb"')
    with np.errstate(invalid="ignore"):
        found = diagnose(replace(problem, custom=(own,)))
    assert [line for line in found.warnings if "'root' of your own was not tried" in line]
    assert not any("of your own" in line for line in diagnose(problem).warnings)
