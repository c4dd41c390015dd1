"""A mass that bristles bring to rest: the friction that is followed in parts of a step, against a far finer one."""

import numpy as np
import pytest

from sim.numerics.elasto_plastic import Elements, springs_of
from sysid.prediction.force_balance.reversals import (
    MOST_SUBSTEPS,
    Forces,
    Onsets,
    Slip,
    substeps_of,
    write_presliding_friction,
)

STEP, MASS, LEVEL = 1e-3, 2.0, 1.0
STRETCHES, WEIGHTS = np.array([0.4e-6, 1.5e-6, 4e-6]), np.array([0.3, 0.3, 0.4])
ROWS = 200
PUSH = 1.3 * np.sin(2.0 * np.pi * np.arange(ROWS) / 160.0)


def finely(stop: float, parts: int) -> np.ndarray:
    """Friction (n,), mean over the step around each row, by velocity Verlet in `parts` of a step."""
    h, springs = STEP / parts, list(zip(STRETCHES.tolist(), WEIGHTS.tolist(), strict=True))
    z, v = [limit for limit, _ in springs], 0.0
    total, count = np.zeros(ROWS), np.zeros(ROWS)
    rows = np.arange(stop, 70.0, 1.0 / parts)
    pushes = np.interp(rows, np.arange(ROWS), PUSH).tolist()
    force, a = LEVEL, (pushes[0] - LEVEL) / MASS
    for row, push in zip(rows.tolist(), pushes, strict=True):
        dx = v * h + 0.5 * a * h * h
        z = [min(max(stretch + dx, -limit), limit) for stretch, (limit, _) in zip(z, springs, strict=True)]
        force = LEVEL * sum(weight * stretch / limit for stretch, (limit, weight) in zip(z, springs, strict=True))
        new = (push - force) / MASS
        v, a = v + 0.5 * (a + new) * h, new
        total[int(row + 0.5)] += force
        count[int(row + 0.5)] += 1.0
    # Before the stop the mass slips.
    before = np.maximum(0.0, np.round(parts - count)) * (np.arange(ROWS) <= stop)
    return (total + before * LEVEL) / np.maximum(count + before, 1.0)


def test_the_swing_after_a_stop_is_that_of_a_far_finer_integration():
    stop = 10.3
    fine, finer = finely(stop, 200), finely(stop, 400)
    scale = STEP**2 / MASS
    parts = substeps_of(Elements(STRETCHES, WEIGHTS, LEVEL), scale)
    out = np.full(ROWS, LEVEL)
    onsets, slip = Onsets(np.array([stop]), np.ones(1)), Slip(np.zeros(ROWS), np.zeros(ROWS), 1.0)
    springs = springs_of(Elements(STRETCHES, WEIGHTS, LEVEL))
    write_presliding_friction(out, onsets, slip, Forces(PUSH, np.full(ROWS, LEVEL)), springs, scale, parts)
    rows = slice(9, 60)
    assert np.max(np.abs(fine[rows] - finer[rows])) < 5e-3
    assert np.ptp(finer[rows]) > 0.5
    assert np.sqrt(np.mean((out[rows] - finer[rows]) ** 2)) < 0.02


def test_contact_too_stiff_for_the_finest_parts_is_left_rigid():
    assert substeps_of(Elements(1e-12 * STRETCHES, WEIGHTS, LEVEL), STEP**2 / MASS) == 0
    assert substeps_of(Elements(STRETCHES, WEIGHTS, LEVEL), STEP**2 / MASS) <= MOST_SUBSTEPS


@pytest.mark.parametrize("heading", [1.0, -1.0])
def test_it_ends_where_the_mass_slips_on(heading):
    push = heading * np.linspace(-0.5, 3.0, ROWS)
    direction = np.where(np.arange(ROWS) > 120, heading, 0.0)
    out = np.full(ROWS, 7.0)
    onsets, slip = Onsets(np.array([20.0]), np.array([-heading])), Slip(direction, np.zeros(ROWS), 1.0)
    forces, springs = Forces(push, np.full(ROWS, LEVEL)), springs_of(Elements(STRETCHES, WEIGHTS, LEVEL))
    write_presliding_friction(out, onsets, slip, forces, springs, STEP**2 / MASS, 8)
    assert np.all(out[:20] == 7.0) and np.all(out[130:] == 7.0)
    # Held until the push is more than the level, then all of it.
    held = slice(60, 85)
    assert out[held] == pytest.approx(push[held], abs=0.1)
    assert out[118] == pytest.approx(heading * LEVEL)
