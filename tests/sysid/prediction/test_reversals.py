"""Turns, stops and departures of a body under Coulomb friction in closed form; bristles that bring a mass to rest."""

import numpy as np
import pytest
from scipy.stats import norm

from sim.numerics.elasto_plastic import Elements, springs_of
from sysid.prediction.force_balance import reversals
from sysid.signals import GaussianFilter


def _turning_block(turn: float, push: float, friction: float, n: int = 401) -> np.ndarray:
    """Position at unit steps of a body of unit mass pushed back by `push`, that stops at `turn` and returns."""
    i = np.arange(n, dtype=float)
    before, after = -(push + friction), -(push - friction)
    tau = i - turn
    return np.where(tau < 0, 0.5 * before * tau**2, 0.5 * after * tau**2)


def test_a_turn_or_a_stop_is_found_between_samples() -> None:
    rng = np.random.default_rng(1)
    errors = []
    for turn in np.linspace(195.0, 205.0, 23):
        x = _turning_block(turn, 2e-3, 1e-3) + rng.normal(scale=2e-3, size=401)
        found = reversals.event_times(x, np.full(401, -2e-3), np.array([turn + rng.uniform(-2, 2)]), 12, 5.0)
        errors.append(found[0] - turn)
    # A smoothed velocity would be late by about half a filter width, here several samples.
    assert abs(np.mean(errors)) < 0.3 and np.std(errors) < 1.0
    i = np.arange(201, dtype=float)
    stop = 100.4
    x = np.where(i < stop, -0.5 * 1e-2 * (i - stop) ** 2, 0.0)
    found = reversals.event_times(x, np.zeros(201), np.array([102.0]), 10, 4.0)
    assert abs(found[0] - stop) < 0.1


def test_rests_last_until_the_push_reaches_the_level() -> None:
    applied, one = np.linspace(-2.0, 2.0, 50), np.ones(50)
    resting = reversals.ResolvedMotion(np.zeros(50), one, np.empty(0), np.empty(0))
    friction = reversals.event_resolved_friction(resting, reversals.Forces(applied, one), 1e-8, 1e-6)
    assert np.array_equal(friction, np.clip(applied, -1.0, 1.0))
    forces = reversals.Forces(_force(), np.full(N, LEVEL))
    assert reversals.break_away_times(STOPS, forces, 20.0) == pytest.approx([LEAVE], abs=1e-9)
    assert reversals.break_away_times(STOPS, forces, 2.0) == pytest.approx([LEAVE - 4.0], abs=1.0)
    found = reversals.sticking_onsets(STOPS, _smooth(_velocity()), forces, STEP / MASS, LIGHT, 10.0)
    # What the filter tails still bring of the kink from over three widths away.
    assert found == pytest.approx([STOP], abs=0.01)
    # No farther than asked.
    near = reversals.sticking_onsets(STOPS, _smooth(_velocity()), forces, STEP / MASS, LIGHT, 1.0)
    assert near == pytest.approx([STOP + 1.5])


def test_friction_turns_within_a_sample_and_holds_under_a_weak_drive() -> None:
    n, turn = 60, 30.25
    direction = np.zeros(n)
    direction[:30], direction[31:] = -1.0, 1.0
    direction[30] = -(turn - 29.5) + (30.5 - turn)
    motion = reversals.ResolvedMotion(direction, np.zeros(n), np.array([turn]), np.ones(1))
    friction = reversals.event_resolved_friction(motion, reversals.Forces(np.full(n, 5.0), np.ones(n)), 1e-12, 1e-3)
    assert np.array_equal(friction[:30], -np.ones(30)) and np.array_equal(friction[31:], np.ones(29))
    # Where the drive is strong, the bristle passes at once: the sample's mean is the mean sign of the motion in it.
    assert abs(friction[30] - direction[30]) < 0.1
    direction = np.where(np.arange(n) < 30, -1.0, 1.0)
    applied = np.where(np.arange(n) < 40, 0.3, 2.0)
    motion = reversals.ResolvedMotion(direction, np.zeros(n), np.array([29.5]), np.ones(1))
    friction = reversals.event_resolved_friction(motion, reversals.Forces(applied, np.ones(n)), 1e-9, 1e-3)
    assert np.allclose(friction[31:40], 0.3, atol=1e-6) and np.array_equal(friction[42:], np.ones(18))
    n = 200
    position, velocity, resting = 1e-6 * np.arange(float(n)), np.full(n, 1e-6), np.zeros(n, dtype=bool)
    resting[95:97] = True
    motion, stops = reversals.resolve_events(position, velocity, np.zeros(n), resting, 10, 5.0, 3)
    direction, rest, turns, _ = motion
    assert turns.size == 0
    assert stops.end == pytest.approx([n - 0.5]) and stops.start == pytest.approx([-0.5])
    assert np.all(direction + rest == pytest.approx(1.0))


@pytest.mark.parametrize("side", [1.0, -1.0])
def test_the_end_of_a_record_in_motion_is_no_event(side: float) -> None:
    n, turn = 401, 200.0
    position = side * _turning_block(turn, 2e-3, 1e-3, n)
    velocity, drive, resting = np.gradient(position), np.full(n, -2e-3 * side), np.zeros(n, dtype=bool)
    motion, phases = reversals.resolve_events(position, velocity, drive, resting, 12, 5.0, 3)
    shifted = reversals.shifted_events(motion.direction, motion.stick_fraction, phases, phases.end, phases.break_away)
    assert shifted.reversals == pytest.approx([turn], abs=0.1) and np.array_equal(shifted.reversed_to, [-side])
    # A push below the level, in the direction of the motion: the body slides to the end nevertheless.
    friction = reversals.event_resolved_friction(
        shifted, reversals.Forces(np.full(n, -0.5 * side), np.ones(n)), 1e-9, 1.0
    )
    assert np.array_equal(friction[:199], np.full(199, side))
    assert np.array_equal(shifted.stick_fraction, np.zeros(n))


MASS, LEVEL, STEP = 0.5, 1.2, 1e-3
N, STOP, LEAVE = 400, 160.3, 240.7
ROWS = np.arange(N)
LIGHT = 2.6


def _force() -> np.ndarray:
    """Constant -0.3 N while it slows down, then a ramp that passes the level at LEAVE."""
    return np.where(ROWS < 200, -0.3, -0.3 + (LEVEL + 0.3) * (ROWS - 200.0) / (LEAVE - 200.0))


def _velocity() -> np.ndarray:
    """Exact velocity, m/s: to rest at STOP, and away from LEAVE on, under `_force` less the level."""
    slowing = (LEVEL + 0.3) / MASS * STEP * (STOP - ROWS)
    slope = (LEVEL + 0.3) / (LEAVE - 200.0)
    leaving = 0.5 * slope / MASS * STEP * (ROWS - LEAVE) ** 2
    return np.where(ROWS < STOP, slowing, np.where(ROWS > LEAVE, leaving, 0.0))


def _smooth(signal: np.ndarray, order: int = 0) -> np.ndarray:
    return GaussianFilter(LIGHT * STEP, STEP, N)(signal, order)


STOPS = reversals.SlipPhases(
    np.array([-0.5]), np.array([STOP + 2.5]), np.array([1.0]), np.array([LEAVE - 6.0]), np.array([1.0])
)


def test_the_velocity_gets_back_the_kinks_that_a_filter_rounds_off() -> None:
    velocity, blurred = _velocity(), _smooth(_velocity())
    motion = reversals.SmoothedMotion(blurred * STEP, _smooth(velocity, 1) * STEP**2, _force() / MASS * STEP**2, LIGHT)
    found = reversals.restored_kinks(motion, STOPS) / STEP
    near = np.abs(ROWS - STOP) < 8
    assert np.max(np.abs(blurred - velocity)[near]) > 2e-3 and np.max(np.abs(found - velocity)[near]) < 1e-4
    beside = (ROWS > LEAVE - 8) & (ROWS < LEAVE + 3)
    assert np.max(np.abs(found - velocity)[beside]) < 0.5 * np.max(np.abs(blurred - velocity)[beside])


SWING_STEP, SWUNG, FULL = 1e-3, 2.0, 1.0
STRETCHES, WEIGHTS = np.array([0.4e-6, 1.5e-6, 4e-6]), np.array([0.3, 0.3, 0.4])
SWING_ROWS = 200
PUSH = 1.3 * np.sin(2.0 * np.pi * np.arange(SWING_ROWS) / 160.0)


def finely(stop: float, parts: int) -> np.ndarray:
    """Friction (n,), mean over the step around each row, by velocity Verlet in `parts` of a step."""
    h, springs = SWING_STEP / parts, list(zip(STRETCHES.tolist(), WEIGHTS.tolist(), strict=True))
    z, v = [limit for limit, _ in springs], 0.0
    total, count = np.zeros(SWING_ROWS), np.zeros(SWING_ROWS)
    rows = np.arange(stop, 70.0, 1.0 / parts)
    pushes = np.interp(rows, np.arange(SWING_ROWS), PUSH).tolist()
    force, a = FULL, (pushes[0] - FULL) / SWUNG
    for row, push in zip(rows.tolist(), pushes, strict=True):
        dx = v * h + 0.5 * a * h * h
        z = [min(max(stretch + dx, -limit), limit) for stretch, (limit, _) in zip(z, springs, strict=True)]
        force = FULL * sum(weight * stretch / limit for stretch, (limit, weight) in zip(z, springs, strict=True))
        new = (push - force) / SWUNG
        v, a = v + 0.5 * (a + new) * h, new
        total[int(row + 0.5)] += force
        count[int(row + 0.5)] += 1.0
    # Before the stop the mass slips.
    before = np.maximum(0.0, np.round(parts - count)) * (np.arange(SWING_ROWS) <= stop)
    return (total + before * FULL) / np.maximum(count + before, 1.0)


def test_the_swing_after_a_stop_is_that_of_a_far_finer_integration():
    stop = 10.3
    fine, finer = finely(stop, 200), finely(stop, 400)
    scale = SWING_STEP**2 / SWUNG
    parts = reversals.substeps_of(Elements(STRETCHES, WEIGHTS, FULL), scale)
    out = np.full(SWING_ROWS, FULL)
    slip = reversals.Slip(np.zeros(SWING_ROWS), np.zeros(SWING_ROWS), 1.0)
    springs = springs_of(Elements(STRETCHES, WEIGHTS, FULL))
    onsets, forces = np.array([stop]), reversals.Forces(PUSH, np.full(SWING_ROWS, FULL))
    reversals.write_presliding_friction(out, onsets, np.ones(1), slip, forces, springs, scale, parts)
    rows = slice(9, 60)
    assert np.max(np.abs(fine[rows] - finer[rows])) < 5e-3 and np.ptp(finer[rows]) > 0.5
    assert np.sqrt(np.mean((out[rows] - finer[rows]) ** 2)) < 0.02


def test_contact_too_stiff_for_the_finest_parts_is_left_rigid():
    assert reversals.substeps_of(Elements(1e-12 * STRETCHES, WEIGHTS, FULL), SWING_STEP**2 / SWUNG) == 0
    assert reversals.substeps_of(Elements(STRETCHES, WEIGHTS, FULL), SWING_STEP**2 / SWUNG) <= reversals.MOST_SUBSTEPS


@pytest.mark.parametrize("heading", [1.0, -1.0])
def test_it_ends_where_the_mass_slips_on(heading):
    push = heading * np.linspace(-0.5, 3.0, SWING_ROWS)
    direction = np.where(np.arange(SWING_ROWS) > 120, heading, 0.0)
    out = np.full(SWING_ROWS, 7.0)
    onsets, sides, slip = np.array([20.0]), np.array([-heading]), reversals.Slip(direction, np.zeros(SWING_ROWS), 1.0)
    forces, springs = reversals.Forces(push, np.full(SWING_ROWS, FULL)), springs_of(Elements(STRETCHES, WEIGHTS, FULL))
    reversals.write_presliding_friction(out, onsets, sides, slip, forces, springs, SWING_STEP**2 / SWUNG, 8)
    assert np.all(out[:20] == 7.0) and np.all(out[130:] == 7.0)
    # Held until the push is more than the level, then all of it.
    held = slice(60, 85)
    assert out[held] == pytest.approx(push[held], abs=0.1) and out[118] == pytest.approx(heading * FULL)


@pytest.mark.parametrize("after", [0.0, -1.0])
@pytest.mark.parametrize(("width", "by_means", "sharp"), [(1.0, 0.02, 0.0067), (1.5, 0.008, 0.0016)])
def test_a_filtered_step_of_the_friction_is_that_of_continuous_time(after, width, by_means, sharp) -> None:
    """A body that slides against its level stops, held by a push of 0.3, or turns."""
    n, push = 81, 0.3
    time, ends = np.arange(n, dtype=float), push if after == 0.0 else after
    forces, smooth = reversals.Forces(np.full(n, push), np.ones(n)), GaussianFilter(width, 1.0, n)
    left = []
    for stop in np.linspace(39.5, 40.5, 11):
        part = np.clip(stop - (time - 0.5), 0.0, 1.0)
        friction = part + ends * (1.0 - part)
        exact = ends + (1.0 - ends) * norm.cdf((stop - time) / width)
        means = np.abs(smooth(friction) - exact).max()
        reversals.write_sharp_steps(friction, forces, np.array([stop]), np.ones(1), np.array([after]))
        left.append((means, np.abs(smooth(friction) - exact).max()))
    means, corrected = np.max(left, axis=0) / (1.0 - ends)
    assert means > by_means  # what this is for
    assert corrected < sharp
