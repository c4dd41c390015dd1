"""The pass with bristles: against the one in closed form, the generator's, and itself in finer steps."""

import numpy as np
import pytest

from benchmarks.generators.driven_stage.truth import HEIGHT, SPACING, Truth, motion
from benchmarks.generators.driven_stage.voltages import MOTIONS
from sim.integration.friction_drive.event_driven import simulate_event_driven
from sim.integration.friction_drive.inputs import DrivenStage, TipMotion, velocity_independent
from sim.integration.friction_drive.midpoint import NO_BRISTLES, Bristles, simulate_midpoint
from sim.numerics.elasto_plastic import Elements

STEP = 5e-4
NOISE = 2e-9
"""m, of a good sensor: what a pass must stay well below."""


def _driven(kind: str, truth: Truth, seed: int = 1, rows: int = 2000) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Rows at rest, the tip's motion, and the stage's by the generator."""
    time = np.arange(rows) * STEP
    first, second = MOTIONS[kind](np.random.default_rng(seed), time)
    rest = np.zeros(rows)
    stage = motion(truth, STEP, first, second, rest, rest + 1.0, rest)
    return rest, -HEIGHT / SPACING * truth.gain * (second - first), stage


def _elements(level: float, presliding: float) -> Elements:
    """Six elements that yield one after another."""
    return Elements(0.15 * 1.6 ** np.arange(6) * presliding, np.ones(6) / 6, level)


def _stage(truth: Truth) -> DrivenStage:
    return DrivenStage(truth.stiffness, truth.damping, truth.mass, STEP)


@pytest.mark.parametrize("kind", ["sawtooth", "there_and_back"])
def test_slips_of_a_bristled_tip_on_rigid_pads_add_up_to_where_the_generator_has_them(kind):
    """Pads that gave way by a nanometre before they slide, an eightieth of the contact, left fifty times the noise."""
    truth = Truth(mass=3.9, stiffness=1.4e7, damping=730.0, pads=1.1, slip=3.5, contact_presliding=6.8e-7)
    rest, tip, stage = _driven(kind, truth)
    slips = Bristles(rest + truth.slip, _elements(truth.slip, truth.contact_presliding))
    followed = simulate_midpoint(tip, rest, slips, Bristles(rest + truth.pads, NO_BRISTLES), _stage(truth))
    assert np.ptp(stage) > 1000 * NOISE and np.std(followed - stage) < 1.0 * NOISE


@pytest.mark.parametrize("slip", [np.inf, 3.5])
@pytest.mark.slow
def test_without_bristles_it_is_the_pass_in_closed_form(slip):
    truth = Truth(pads=1.3, stiffness=8e6, damping=300.0, mass=2.5)
    rest, tip, _ = _driven("sawtooth", truth)
    levels = [rest + slip, rest + truth.pads]
    curves = [velocity_independent(level) for level in levels]
    exact = simulate_event_driven(TipMotion(tip, rest + 1.0), rest, *curves, _stage(truth))
    rigid = [Bristles(level, NO_BRISTLES) for level in levels]
    followed = [simulate_midpoint(tip, rest, *rigid, _stage(truth), finer) for finer in (1, 4)]
    errors = [float(np.std(x - exact)) for x in followed]
    assert errors[0] < 2.0 * NOISE
    # Second order, but for the moments of events.
    assert errors[1] < 0.2 * errors[0]


def test_bristles_of_the_pads_are_the_generator_s():
    truth = Truth(pads=1.3, stiffness=8e6, damping=300.0, mass=2.5, presliding=5e-7)
    rest, tip, stage = _driven("lean", truth)
    pads = Bristles(rest + truth.pads, _elements(truth.pads, truth.presliding))
    followed = simulate_midpoint(tip, rest, Bristles(rest + np.inf, NO_BRISTLES), pads, _stage(truth))
    assert np.std(followed - stage) < 0.2 * NOISE


@pytest.mark.parametrize("step", [0.05, 50.0])
def test_rows_far_apart_show_a_stage_that_lags_by_its_bristles_alone(step):
    """Quasi-static: contact and bristles are two springs, one behind the other, until all bristles slip."""
    stiffness, pads, stretch = 6e6, 1.2, 4e-7
    time = np.arange(400) * step
    tip = 3e-6 * np.sin(2.0 * np.pi * time / (100.0 * step))
    rest = np.zeros(tip.size)
    bristled = Bristles(rest + pads, Elements(np.array([stretch]), np.ones(1), pads))
    driven = DrivenStage(stiffness, 300.0, 2.0, step)
    stage = simulate_midpoint(tip, rest, Bristles(rest + np.inf, NO_BRISTLES), bristled, driven)
    expected, bent = np.zeros(tip.size), 0.0
    both = pads / stiffness + stretch
    for k in range(1, tip.size):
        bent = min(max(bent + tip[k] - tip[k - 1], -both), both)
        expected[k] = tip[k] - bent * pads / stiffness / both
    assert np.abs(stage - expected).max() < 3e-3 * np.ptp(tip)
