"""Compression of a recorded drive: impulse, motion, and the drives that must stay as they are."""

import numpy as np
import pytest

from sim.effects.catalogue import compose
from sim.integration import drive
from sim.integration.drive import SHARE, compressed, force_at
from sim.integration.integrator import Surroundings, plan_of
from sim.integration.simulate import simulate

NO_SURROUNDINGS = Surroundings(np.full((1, 2), np.nan))
TIME = 1e-4 * np.arange(20_001)
MODEL = compose(["lugre", "stribeck", "viscous"])


def logged_pull(jitter: float) -> drive.Drive:
    """A pull of 0.1 m/s with a slow wander, as a noisy encoder logged it at 10 kHz."""
    noise = np.cumsum(np.random.default_rng(3).standard_normal(TIME.size)) * jitter
    return drive.pulled_spring(TIME, 0.1 * TIME + 2e-3 * np.sin(2.0 * TIME) + noise, 2.0)


@pytest.mark.parametrize("tolerance", [1e-4, 1e-6, 1e-8])
@pytest.mark.parametrize("jitter", [0.0, 1e-8, 1e-5])
def test_impulse_is_kept_everywhere_within_the_share_of_the_tolerance(jitter, tolerance):
    given = logged_pull(jitter)
    found = compressed(given, 0.0, TIME[-1], 3.0, tolerance * 1e-3)
    # Midpoints of tenths of a row: both forces are linear there, but for a knot's rounding.
    fine = (np.arange(10 * (TIME.size - 1)) + 0.5) * 1e-5
    off = np.cumsum(force_at(given, fine) - force_at(found, fine)) * 1e-5
    assert np.abs(off).max() <= 1.01 * SHARE * tolerance * 1e-3 * 3.0 + 1e-14
    assert abs(off[-1]) < 1e-13


def test_fewer_pieces_at_a_looser_tolerance_and_none_joined_when_it_is_too_tight():
    given = logged_pull(1e-8)
    pieces = [compressed(given, 0.0, TIME[-1], 1.0, tolerance * 1e-3).knots.size for tolerance in (1e-4, 1e-6, 1e-8)]
    assert pieces[0] < pieces[1] < pieces[2] < TIME.size
    assert pieces[0] < TIME.size / 200
    assert compressed(given, 0.0, TIME[-1], 1.0, 1e-13 * 1e-3) is given


def test_real_corners_stay():
    # Triangles of force, logged at 10 kHz: joined between the corners alone.
    force = np.abs((TIME / 0.25) % 2.0 - 1.0)
    found = compressed(drive.force(TIME, force), 0.0, TIME[-1], 1.0, 1e-9 * 1e-3)
    assert found.knots.size < 200
    corners = np.arange(1, 8) * 0.25
    assert np.abs(found.knots[:, None] - corners).min(axis=0).max() < 1.5e-4


@pytest.mark.parametrize("tolerance", [1e-5, 1e-7])
def test_the_motion_is_that_of_the_record_and_far_cheaper(tolerance):
    given = logged_pull(1e-8)
    exact = simulate(MODEL, given, TIME, tolerance=1e-13, forces=False)
    loose = simulate(MODEL, given, TIME, tolerance=tolerance, forces=False)
    assert exact.steps > TIME.size - 2
    assert loose.steps < exact.steps / 5
    # A line without jitter asks for its own error: the same tolerance is allowed here.
    clean = simulate(MODEL, logged_pull(0.0), TIME, tolerance=tolerance, forces=False)
    sure = simulate(MODEL, logged_pull(0.0), TIME, tolerance=1e-13, forces=False)
    own = np.abs(clean.position - sure.position).max()
    assert np.abs(loose.position - exact.position).max() < 2.0 * own + tolerance * 0.1


def test_the_force_shown_is_that_of_the_record():
    given = logged_pull(1e-6)
    run = simulate(MODEL, given, TIME, tolerance=1e-4)
    assert run.steps < TIME.size
    assert run.drive == pytest.approx(force_at(given, TIME) - 2.0 * run.position, abs=1e-12)


def test_a_drive_with_a_play_is_left_as_it_is():
    given = logged_pull(1e-8)
    with_play = plan_of(compose(["lugre", "backlash"]), given, 1.0, NO_SURROUNDINGS)
    assert with_play.compressed(0.0, TIME[-1], 1e-4).drive is given
    without = plan_of(compose(["lugre"]), given, 1.0, NO_SURROUNDINGS)
    assert without.compressed(0.0, TIME[-1], 1e-4).drive.knots.size < TIME.size / 100
