"""The strength that a rest leaves, along a record: closed forms of its rise and of its fading."""

import numpy as np
import pytest

from sim.effects.catalogue import find
from sysid.prediction.force_balance.record import make_axis

STEP = 1e-3
FORCE, CUT_OFF, LENGTH, SPEED = 0.3, 0.02, 4e-5, 2e-3


def _axis(noise: float = 0.0):
    """A slide, a rest of a second, a slide."""
    time = STEP * np.arange(3000)
    velocity = np.where((time >= 1.0) & (time < 2.0), 0.0, SPEED)
    position = np.concatenate([[0.0], np.cumsum(0.5 * (velocity[1:] + velocity[:-1]) * STEP)])
    position = position + noise * np.random.default_rng(1).standard_normal(time.size)
    return make_axis(time, position, velocity, np.zeros(time.size), None, None, 1e-6)


def _level(axis):
    effect = find("dwell_strengthening:fading")
    return effect.level(axis, effect.values(force=FORCE, cut_off=CUT_OFF, memory_length=LENGTH))


def test_strength_rises_with_the_logarithm_of_the_rest_and_fades_with_the_way():
    axis = _axis()
    level = _level(axis)
    resting = (axis.time >= 1.05) & (axis.time < 1.99)
    rise = FORCE * np.log1p(np.maximum(axis.time - 1.0, 0.0) / CUT_OFF)
    assert level[resting] == pytest.approx(rise[resting], rel=0.03)  # a rest begins between two rows
    assert not level[axis.time < 1.0].any()
    sliding = axis.time > 2.005
    gone = axis.position - axis.position[2001]
    assert level[sliding] == pytest.approx((level[2001] * np.exp(-gone / LENGTH))[sliding], rel=1e-6, abs=1e-12)


def test_noise_of_the_position_renews_no_contact_at_rest():
    quiet, noisy = _axis(), _axis(noise=2e-7)
    end = 1990
    for name in ("dwell_strengthening", "dwell_strengthening:kato"):
        effect = find(name)
        p = effect.values(memory_length=1e-5)
        ages = [effect.memory(axis, p).contact_age[end] for axis in (quiet, noisy)]
        assert ages[0] == pytest.approx(0.99, abs=0.01)
        assert ages[1] == pytest.approx(ages[0], rel=0.01)
    assert _level(noisy)[end] == pytest.approx(_level(quiet)[end], rel=0.01)
