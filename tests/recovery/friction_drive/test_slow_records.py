"""Rows far apart against the swing of a stage on its contact: followed in bounded work, and still where it rests."""

import numpy as np
import pytest

from sim.integration.driven_stage.event_driven import simulate_event_driven
from sim.integration.driven_stage.inputs import DrivenStage, TipMotion, velocity_independent
from sim.integration.driven_stage.planar import Guide, PlanarTipMotion, simulate_planar

STIFFNESS, DAMPING, MASS = 6e6, 300.0, 2.0


def _followed(step: float, pads: float) -> tuple[np.ndarray, np.ndarray]:
    time = np.arange(400) * step
    tip = 3e-6 * np.sin(2.0 * np.pi * time / (100.0 * step))
    n = tip.size
    held = np.full(n, np.inf)
    return tip, simulate_event_driven(
        TipMotion(tip, np.ones(n)),
        np.zeros(n),
        velocity_independent(held),
        velocity_independent(np.full(n, pads)),
        DrivenStage(STIFFNESS, DAMPING, MASS, step),
    )


@pytest.mark.parametrize("step", [0.05, 0.5, 50.0])
def test_a_stage_that_no_inertia_holds_back_lags_by_its_pads_alone(step):
    """Quasi-static: the contact is stretched by F/k while the pads slide, and the stage rests until it is."""
    pads = 1.2
    tip, stage = _followed(step, pads)
    reach = pads / STIFFNESS
    expected = np.zeros(tip.size)
    for k in range(1, tip.size):
        expected[k] = min(max(expected[k - 1], tip[k] - reach), tip[k] + reach)
    assert np.abs(stage - expected).max() < 2e-3 * np.ptp(tip)
    assert np.ptp(stage) == pytest.approx(np.ptp(tip) - 2.0 * reach, rel=2e-3)


@pytest.mark.parametrize("step", [0.05, 50.0])
def test_so_does_one_that_moves_in_the_plane(step):
    """Along a line that is not an axis: the radial pull of pads at rest is that of one axis."""
    pads = 1.2
    tip, line = _followed(step, pads)
    n = tip.size
    along, across = simulate_planar(
        PlanarTipMotion(0.6 * tip, 0.8 * tip, np.ones(n)),
        np.zeros(n),
        np.full(n, np.inf),
        np.full(n, pads),
        DrivenStage(STIFFNESS, DAMPING, MASS, step),
        Guide(0.0, 0.0),
    )
    assert np.abs(0.6 * along + 0.8 * across - line).max() < 2e-3 * np.ptp(tip)
    assert np.abs(0.8 * along - 0.6 * across).max() < 1e-3 * np.ptp(tip)
