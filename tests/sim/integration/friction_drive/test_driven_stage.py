"""Midpoint rule with bristles, and event-driven simulation on rigid pads, against laws by hand and explicit steps."""

import math

import numpy as np
import pytest

from sim.integration.friction_drive.event_driven import simulate_event_driven
from sim.integration.friction_drive.inputs import DrivenStage, TipMotion, velocity_independent
from sim.integration.friction_drive.midpoint import NO_BRISTLES, Bristles, simulate_midpoint
from sim.numerics.elasto_plastic import Elements

ONE_NANOMETRE = Elements(np.array([1e-9]), np.ones(1), 2.0)
STAGE = DrivenStage(stiffness=8e6, damping=800.0, mass=3.0, step=5e-4)
PADS = 0.8
FINE = 500


def test_midpoint_without_friction_is_a_driven_oscillator():
    """m x'' = k (tip - x) + c (tip' - x') under a step that is a ramp of one sample: by hand after it."""
    step, k, m, c = 1e-5, 8e6, 3.0, 300.0
    time = np.arange(2000) * step
    tip, forever = np.where(time > 0.0, 1e-7, 0.0), np.full(time.size, math.inf)
    contact, pads = Bristles(forever, NO_BRISTLES), Bristles(0.0 * tip, NO_BRISTLES)
    x = simulate_midpoint(tip, 0.0 * tip, contact, pads, DrivenStage(k, c, m, step), 10)
    w, decay = math.sqrt(k / m), c / (2 * m)
    free = math.sqrt(w * w - decay * decay)
    late = time - 0.5 * step
    # A unit step of position through spring and dashpot: 1 - e^(-d t) (cos - d/w sin), since the dashpot feels it too.
    expected = 1e-7 * (1 - np.exp(-decay * late) * (np.cos(free * late) - decay / free * np.sin(free * late)))
    assert np.abs(x - expected)[5:].max() < 2e-9


def _moved(tip: np.ndarray, contact: np.ndarray, pads: np.ndarray) -> np.ndarray:
    """Motion (n,) of a stage behind a contact that winds up by its spring, on bristles of a nanometre, limits in N."""
    stage = DrivenStage(8e6, 400.0, 3.0, 1e-3)
    return simulate_midpoint(tip, 0.0 * tip, Bristles(contact, NO_BRISTLES), Bristles(pads, ONE_NANOMETRE), stage, 20)


def test_midpoint_slides_as_far_as_the_tip_less_what_the_pads_wind_up():
    tip = np.concatenate([np.linspace(0.0, 5e-6, 500), np.full(500, 5e-6)])
    level = np.full(tip.size, 2.0)
    # Slowly: the contact is wound up by the pads' 2 N.
    assert _moved(tip, np.full(tip.size, math.inf), level)[-1] == pytest.approx(5e-6 - 2.0 / 8e6, rel=2e-3)
    # A contact that holds less than the pads never moves the stage out of its presliding.
    assert abs(_moved(tip, np.full(tip.size, 1.5), level)[-1]) < 1e-9


def test_a_lifted_tip_carries_nothing_along():
    tip = np.linspace(0.0, 5e-6, 1000)
    x = _moved(tip, np.where(np.arange(1000) < 500, math.inf, 0.0), np.full(1000, 1.0))
    assert x[-1] == pytest.approx(x[520], abs=2e-9) and x[499] == pytest.approx(tip[499] - 1.0 / 8e6, rel=5e-3)


def _by_the_law(tip: np.ndarray, limit: np.ndarray, rests_in_slip: bool = False) -> np.ndarray:
    """T = q + c (u' - x'), cut at the limit; q' = k (u' - x'), cut too; rigid pads; semi-implicit Euler steps."""
    h = STAGE.step / FINE
    rows = np.arange(tip.size)
    fine = np.arange((tip.size - 1) * FINE + 1) / FINE
    along, most = np.interp(fine, rows, tip), np.interp(fine, rows, limit)
    x, v, q, out = 0.0, 0.0, 0.0, [0.0]
    for i in range(1, fine.size):
        sliding = (along[i] - along[i - 1]) / h - v
        trial = q + STAGE.stiffness * sliding * h
        force = min(max(trial + STAGE.damping * sliding, -most[i]), most[i])
        slips = force != trial + STAGE.damping * sliding
        q = min(max(q if slips and rests_in_slip else trial, -most[i]), most[i])
        free, lost = v + h * force / STAGE.mass, h * PADS / STAGE.mass
        v = np.sign(free) * max(abs(free) - lost, 0.0)
        x += v * h
        if i % FINE == 0:
            out.append(x)
    return np.array(out)


def test_a_slipping_contact_follows_the_stated_law():
    part = (np.arange(200) % 40) / 40.0
    tip = 4e-6 * np.minimum(part / 0.9, (1.0 - part) / 0.1)
    limit = 6.0 + 2.0 * np.sin(np.arange(tip.size) / 17.0)
    touching = TipMotion(tip, np.ones(tip.size))
    pads = velocity_independent(np.full(tip.size, PADS))
    found = simulate_event_driven(touching, 0.0 * tip, velocity_independent(limit), pads, STAGE)
    expected = _by_the_law(tip, limit)
    travel = np.ptp(expected)
    # The explicit steps are of first order: 2e-3, 5e-4 and 1e-4 with 100, 500 and 2000 to a row.
    assert np.abs(found - expected).max() < 1e-3 * travel
    # A spring that rests while the contact slips would move the stage elsewhere.
    assert np.abs(_by_the_law(tip, limit, rests_in_slip=True) - expected).max() > 5e-3 * travel
