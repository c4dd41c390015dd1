"""Effects of drive, structure and memory in a simulation, against closed solutions."""

import math

import numpy as np
import pytest

from sim import compose, simulate
from sim.integration import drive
from sim.integration.simulate import SimulationError
from stagecad.parameters.errors import InputError
from tests.refusals import refused

PUSH = drive.force([0.0, 0.1, 0.3, 0.4, 0.8], [0.0, 3.0, 3.0, -3.0, -3.0])
TIME = np.linspace(0.0, 0.8, 401)


def test_a_lagged_and_a_delayed_drive_in_closed_form():
    step = drive.Drive(np.array([0.0, 0.01]), np.array([0.0, 2.0]), np.zeros(2))
    time = np.linspace(0.0, 0.2, 201)
    run = simulate(compose(["drive_lag"], {"drive_lag.time_constant": 0.03}), step, time, tolerance=1e-11)
    late = np.clip(time - 0.01, 0.0, None)
    assert np.abs(run.drive - 2.0 * -np.expm1(-late / 0.03)).max() < 1e-9
    # Unit mass: v' = drive.
    assert np.abs(run.velocity - 2.0 * (late + 0.03 * np.expm1(-late / 0.03))).max() < 1e-9
    late = simulate(compose(["lugre", "drive_delay"], {"drive_delay.delay": 0.05}), PUSH, TIME, tolerance=1e-10)
    now = simulate(compose(["lugre"]), PUSH, TIME, tolerance=1e-10)
    shift = round(0.05 / (TIME[1] - TIME[0]))
    assert np.abs(late.position[shift:] - now.position[:-shift]).max() < 1e-9 and np.all(late.position[:shift] == 0.0)


def test_no_force_passes_through_a_play_until_it_is_crossed():
    gap, stiffness = 1e-3, 500.0
    pull = drive.pulled_spring([0.0, 1.0, 2.0], [0.0, 0.01, 0.0], stiffness)
    time = np.linspace(0.0, 2.0, 2001)
    model = compose(["viscous", "backlash"], {"backlash.gap": gap, "viscous.coefficient": 50.0})
    run, tight = (simulate(model, pull, time, tolerance=tolerance) for tolerance in (1e-10, 1e-12))
    stretch = np.interp(time, [0.0, 1.0, 2.0], [0.0, 0.01, 0.0]) - run.position
    expected = stiffness * (stretch - np.clip(stretch, -gap / 2.0, gap / 2.0))
    assert np.abs(run.drive - expected).max() < 1e-9 * stiffness
    crossing = (np.abs(stretch) < gap / 2.0) & (time > 1.0)
    assert crossing.sum() > 50 and np.all(run.drive[crossing] == 0.0)
    assert np.abs(run.position - tight.position).max() < 1e-9


def test_a_rider_rings_at_the_frequency_of_the_loosened_pair():
    """Free pair of masses m1, m2 on a spring k: w = sqrt(k (1/m1 + 1/m2)); with k = m2 w0^2, w0 sqrt(1 + m2/m1)."""
    ratio, frequency = 0.3, 40.0
    known = {"flexible_mode.frequency": frequency, "flexible_mode.damping": 1e-3, "flexible_mode.mass_ratio": ratio}
    kick = drive.force([0.0, 1e-3, 1.1e-3], [5.0, 5.0, 0.0])
    time = np.linspace(0.0, 0.5, 5001)
    run = simulate(compose(["flexible_mode"], known), kick, time, mass=2.0, tolerance=1e-11)
    free = run.velocity[time > 2e-3] - np.polyval(np.polyfit(time, run.velocity, 1), time[time > 2e-3])
    signs = np.flatnonzero(np.diff(np.sign(free)) != 0)
    found = (signs.size - 1) / 2.0 / (time[signs[-1]] - time[signs[0]])
    assert found == pytest.approx(frequency * math.sqrt(1.0 + ratio / (1.0 - ratio)), rel=5e-3)
    # A slow push moves the whole mass.
    push, ends = drive.force([0.0, 1.0], [0.0, 2.0]), np.linspace(0.0, 1.0, 11)
    slow = simulate(compose(["flexible_mode"], known), push, ends, mass=2.0, tolerance=1e-10)
    assert slow.position[-1] == pytest.approx(2.0 / 6.0 / 2.0, rel=1e-3)


def test_lagging_friction_and_a_bristle_of_its_own():
    delay = 0.02
    values = {"frictional_lag.delay": delay, "stribeck.velocity": 0.02}
    model = compose(["lugre", "stribeck", "frictional_lag"], values)
    motion = drive.sinusoidal_velocity(0.05, 12.0, 0.1)
    time = np.linspace(0.0, 1.0, 1001)
    run = simulate(model, motion, time, tolerance=1e-10)
    speed = np.abs(0.1 + 0.05 * np.sin(12.0 * np.clip(time - delay, 0.0, None)))
    assert np.abs(run.level - (1.0 + 0.5 * np.exp(-((speed / 0.02) ** 2)))).max() < 1e-8
    model = compose(["bristle_damping"], {"bristle_damping.damping": 30.0, "bristle_damping.stretch": 1e-5})
    motion = drive.sinusoidal_velocity(0.0, 0.0, 1e-3)
    time = np.linspace(0.0, 0.1, 1001)
    run = simulate(model, motion, time, tolerance=1e-10)
    stretched = 1e-3 * time / 1e-5
    assert np.all(np.abs(run.friction[stretched < 0.4] / (30.0 * 1e-3) - 1.0) < 1e-3)
    assert np.all(np.abs(run.friction[stretched > 2.0]) < 1e-5)


def test_what_cannot_be_simulated_says_so():
    imposed = drive.sinusoidal_velocity(0.0, 0.0, 0.1)
    with pytest.raises(InputError, match="'drive_lag' acts on a drive, and here the motion itself is imposed"):
        simulate(compose(["lugre", "drive_lag"]), imposed, TIME)
    refused("'backlash' needs a drive that pulls a spring", simulate, compose(["coulomb", "backlash"]), PUSH, TIME)
    heavy = compose(["flexible_mode"], {"flexible_mode.mass_ratio": 1.2})
    refused(r"1\.2 of the mass belongs to added oscillators; must be below 1", simulate, heavy, PUSH, TIME)
    with pytest.raises(SimulationError, match="not finite"):
        simulate(compose(["lugre", "viscous"], {"viscous.coefficient": math.nan}), PUSH, TIME)
    with pytest.raises(SimulationError, match="too many steps"):
        simulate(compose(["lugre", "frictional_lag"], {"frictional_lag.delay": 1e-7}), PUSH, TIME, most_steps=1000)
