"""A late drive, a late or bent force sensor, on an axis that also rests: what holds it is the force as it arrives."""

from pathlib import Path

import numpy as np
import pytest

from benchmarks.generators.hidden_effect import Plan, make_case
from sysid.ladder import add_effects


@pytest.mark.parametrize("effect,parameter,seed", [("drive_lag", "time_constant", 3), ("drive_delay", "delay", 7)])
def test_with_the_lag_or_delay_added_what_is_left_is_noise(
    tmp_path: Path, effect: str, parameter: str, seed: int
) -> None:
    case = make_case(Plan("force-drive", (effect,), "strong", idle=False, rows=8000), np.random.default_rng(seed))
    case.write(tmp_path)

    step = add_effects(tmp_path, [effect])

    assert step.before_validate["drive_force"].over_noise > 5.0
    assert step.after_validate["drive_force"].over_noise < 1.2
    found = step.revision.document["parameters"][f"{effect}.{parameter}"]["value"]
    # The simulator that made the record moves in steps of 0.05 ms.
    assert found == pytest.approx(case.key["truth"][effect], abs=1e-4)


@pytest.mark.parametrize("effect,law", [("sensor_delay", ""), ("sensor_lag", ""), ("sensor_drift", ":power")])
def test_a_pulled_mass_at_rest_says_nothing_of_the_force_sensor(tmp_path: Path, effect: str, law: str) -> None:
    case = make_case(Plan("spring-pull", (effect,), "strong", idle=False, rows=8000), np.random.default_rng(5))
    case.write(tmp_path)

    step = add_effects(tmp_path, [f"{effect}{law}@spring_force"])

    # Over the noise of the sensor alone: the wrong model has a steep Stribeck curve, along which the noise of the
    # motion is a part of its error.
    assert step.before_validate["spring_force"].over_sensor_noise > 5.0
    assert step.after_validate["spring_force"].over_noise < 1.2
