"""The channel that a sensor's effect acts on, where another missing effect hid which it is."""

from pathlib import Path

import numpy as np

from benchmarks.generators.hidden_effect import Plan, make_case
from sysid.estimation.misfit import worst_over_noise
from sysid.ladder import add_effects


def test_the_channel_is_put_right_by_the_effect_added_next(tmp_path: Path) -> None:
    plan = Plan("spring-pull", ("sensor_drift", "constant_bias"), "strong", rows=5000)
    make_case(plan, np.random.default_rng(1)).write(tmp_path)
    add_effects(tmp_path, ["sensor_drift"])
    step = add_effects(tmp_path, ["constant_bias"])
    names = [effect.name for effect in step.base.fitted.model.effects]
    assert [name.rpartition("@")[2] for name in names if name.startswith("sensor_drift")] == ["spring_force"]
    assert worst_over_noise(step.after_fit, step.after_validate) < 1.3
