"""Event-driven simulation of a stage on rigid pads, against explicit steps of the law that the documentation states."""

import numpy as np

from sim.integration.driven_stage.event_driven import simulate_event_driven
from sim.integration.driven_stage.inputs import DrivenStage, TipMotion, velocity_independent

STAGE = DrivenStage(stiffness=8e6, damping=800.0, mass=3.0, step=5e-4)
PADS = 0.8
FINE = 500


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


def _sawtooth(rows: int) -> np.ndarray:
    part = (np.arange(rows) % 40) / 40.0
    return 4e-6 * np.minimum(part / 0.9, (1.0 - part) / 0.1)


def test_a_slipping_contact_follows_the_stated_law():
    tip = _sawtooth(200)
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
