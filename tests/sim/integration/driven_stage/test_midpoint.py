"""Midpoint rule with bristles: against a driven oscillator, and against quasi-static motion."""

import math

import numpy as np
import pytest

from sim.integration.driven_stage.inputs import DrivenStage
from sim.integration.driven_stage.midpoint import NO_BRISTLES, Bristles, simulate_midpoint
from sim.numerics.elasto_plastic import Elements

ONE_NANOMETRE = Elements(np.array([1e-9]), np.ones(1), 2.0)


def test_midpoint_without_friction_is_a_driven_oscillator():
    """m x'' = k (tip - x) + c (tip' - x') under a step that is a ramp of one sample: by hand after it."""
    step, k, m, c = 1e-5, 8e6, 3.0, 300.0
    time = np.arange(2000) * step
    tip = np.where(time > 0.0, 1e-7, 0.0)
    forever = np.full(time.size, math.inf)
    x = simulate_midpoint(
        tip, 0.0 * tip, Bristles(forever, NO_BRISTLES), Bristles(0.0 * tip, NO_BRISTLES), DrivenStage(k, c, m, step), 10
    )
    w, decay = math.sqrt(k / m), c / (2 * m)
    free = math.sqrt(w * w - decay * decay)
    late = time - 0.5 * step
    # A unit step of position through spring and dashpot: 1 - e^(-d t) (cos - d/w sin), since the dashpot feels it too.
    expected = 1e-7 * (1 - np.exp(-decay * late) * (np.cos(free * late) - decay / free * np.sin(free * late)))
    assert np.abs(x - expected)[5:].max() < 2e-9


def test_midpoint_slides_as_far_as_the_tip_less_what_the_pads_wind_up():
    step = 1e-3
    tip = np.concatenate([np.linspace(0.0, 5e-6, 500), np.full(500, 5e-6)])
    level = np.full(tip.size, 2.0)
    forever = np.full(tip.size, math.inf)
    x = simulate_midpoint(
        tip,
        0.0 * tip,
        Bristles(forever, NO_BRISTLES),
        Bristles(level, ONE_NANOMETRE),
        DrivenStage(8e6, 400.0, 3.0, step),
        20,
    )
    # Slowly: the contact is wound up by the pads' 2 N.
    assert x[-1] == pytest.approx(5e-6 - 2.0 / 8e6, rel=2e-3)
    weak = np.full(tip.size, 1.5)
    stuck = simulate_midpoint(
        tip,
        0.0 * tip,
        Bristles(weak, NO_BRISTLES),
        Bristles(level, ONE_NANOMETRE),
        DrivenStage(8e6, 400.0, 3.0, step),
        20,
    )
    # A contact that holds less than the pads never moves the stage out of its presliding.
    assert abs(stuck[-1]) < 1e-9


def test_a_lifted_tip_carries_nothing_along():
    step = 1e-3
    tip = np.linspace(0.0, 5e-6, 1000)
    touches = np.where(np.arange(1000) < 500, math.inf, 0.0)
    x = simulate_midpoint(
        tip,
        0.0 * tip,
        Bristles(touches, NO_BRISTLES),
        Bristles(np.full(1000, 1.0), ONE_NANOMETRE),
        DrivenStage(8e6, 400.0, 3.0, step),
        20,
    )
    assert x[-1] == pytest.approx(x[520], abs=2e-9)
    assert x[499] == pytest.approx(tip[499] - 1.0 / 8e6, rel=5e-3)
