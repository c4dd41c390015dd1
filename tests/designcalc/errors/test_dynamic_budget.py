"""Spectra through a loop against the stationary covariance of the same loop in state space, and closed forms."""

import numpy as np
import pytest
from scipy.linalg import solve_continuous_lyapunov

from designcalc.checks.check import DesignInputs
from designcalc.errors import dynamic_budget as db
from designcalc.errors.thermal import floor_motion
from designcalc.friction_stage.physics.loads import load, moved_mass
from designcalc.friction_stage.physics.position_loop import BANDS, dynamic_budgets, position_loop, suspension
from designcalc.friction_stage.physics.tip_dynamics import holding_stiffness
from stagecad.parameters.load import load_design

# Without the delay, which has no finite state space.
LOOP = db.PositionLoop(10.0, 470.0, 0.05, 24.0, 1e9)


def states(corner: float):
    """Mass on spring, integrator u, filtered reading y; A, and the inputs of sensor noise and of a tip that moves."""
    w, z = 2 * np.pi * LOOP.resonance, LOOP.damping
    wc, wf = 2 * np.pi * LOOP.crossover, 2 * np.pi * corner
    # x'' = -w^2 (x - u - d) - 2 z w x',  u' = -wc y,  y' = wf (x + n - y)
    matrix = np.array([[0, 1, 0, 0], [-(w**2), -2 * z * w, w**2, 0], [0, 0, 0, -wc], [wf, 0, 0, -wf]])
    return matrix, np.array([0, 0, 0, wf]), np.array([0, w**2, 0, 0])


@pytest.mark.parametrize("which", ["sensor", "tip"])
def test_rms_of_white_noise_is_that_of_the_lyapunov_equation(which):
    matrix, noise, tip = states(LOOP.filter_corner)
    density = 0.28e-9  # one-sided, m/sqrt(Hz): half of its power is the two-sided intensity
    column = (noise if which == "sensor" else tip)[:, None]
    covariance = solve_continuous_lyapunov(matrix, -(density**2 / 2) * column @ column.T)
    f = db.frequencies(1e-3, 1e6, [(LOOP.resonance, LOOP.damping)], [])
    path = LOOP.sensitivity(f) - 1 if which == "sensor" else LOOP.plant(f) * LOOP.sensitivity(f)
    row = db.Disturbance("noise", "test", density * np.abs(path))
    found = db.DynamicBudget("x", f, (row,))
    assert found.rms(row) == pytest.approx(np.sqrt(covariance[0, 0]), rel=2e-3)
    run = found.cumulative(row)
    assert np.all(np.diff(run) >= 0) and run[0] == 0
    # Parts of the band add as powers.
    low = float(np.interp(30.0, f, run**2))
    assert found.rms(row, 30.0) ** 2 + low == pytest.approx(found.rms(row) ** 2)


@pytest.mark.parametrize("crossover", [1.0, 20.0, 40.0, 60.0, 90.0, 200.0])
@pytest.mark.parametrize("corner", [24.0, 1e5])
def test_stability_is_that_of_the_poles(crossover, corner):
    loop = db.PositionLoop(crossover, 470.0, 0.05, corner, 1e9)
    w, wf = 2 * np.pi * 470.0, 2 * np.pi * corner
    matrix = states(corner)[0]
    matrix[2, 3] = -2 * np.pi * crossover
    assert matrix[1, 0] == -(w**2) and matrix[3, 0] == wf
    assert loop.stable() == bool(np.all(np.linalg.eigvals(matrix).real < 0))


def test_floor_and_disturbances_as_the_closed_forms():
    f = db.frequencies(1e-2, 1e4, [(63.0, 0.02)], [edge for band in BANDS for edge in band])
    density = db.floor_density(f, 25e-6, BANDS) * np.abs(db.base_response(f, 63.0, 0.02))
    row = db.Disturbance("floor", "test", density)
    found = db.DynamicBudget("x", f, (row,)).rms(row)
    assert found == pytest.approx(float(floor_motion(25e-6, 63.0, 0.02)), rel=2e-3)
    # Stiffness of the presliding curve at rest by a small step on it; and a loop that its resonance makes unstable.
    r = DesignInputs(load_design(None, ()))
    held, step = suspension(r), 1e-12
    force = 0.06 * load(r) * (1 - (1 - step / 0.5e-6) ** 2)
    whole = force / step + holding_stiffness(r)
    assert (2 * np.pi * held.resonance) ** 2 * moved_mass(r) == pytest.approx(whole, rel=1e-4)
    assert held.gain == pytest.approx(holding_stiffness(r) / whole, rel=1e-4)
    fast = DesignInputs(load_design(None, ("loop.crossover=100 Hz",)))
    assert not position_loop(fast, "interferometer").stable() and position_loop(r, "interferometer").stable()


def test_densities_have_their_rms_and_the_payload_feels_each():
    f = np.geomspace(1e-7, 1e7, 40001)

    def rms(density):
        row = db.Disturbance("x", "x", density)
        return db.DynamicBudget("x", f, (row,)).rms(row)

    assert rms(db.fluctuation_density(f, 3.0, 600.0)) == pytest.approx(3.0, rel=1e-3)
    assert rms(db.band_density(2.0, 5e3) * np.abs(db.first_order_lag(f, 5e3))) == pytest.approx(2.0, rel=1e-3)
    assert rms(db.count_density(f, 0.6, 5e3)) == pytest.approx(0.6 / np.sqrt(12), rel=1e-3)
    # Each row follows its cause, and no other row does.

    def rows(*overrides):
        r = DesignInputs(load_design(None, overrides, rules=False))
        return {(one.name, row.name): one.rms(row, 0.1) for one in dynamic_budgets(r) for row in one.rows}

    before = rows()
    for override, moved in (
        ("environment.floor_velocity=0.05 mm/s", "floor"),
        ("amplifier.noise=2 mV", "amplifier noise"),
        ("sensors.probe.resolution=50 nm", "sensor noise"),
        ("sensors.interferometer.resolution=1.24 nm", "count of the sensor"),
    ):
        for key, value in rows(override).items():
            doubled = key[1].startswith(moved) and (moved != "count of the sensor" or "interferometer" in key[0])
            assert value == pytest.approx((2 if doubled else 1) * before[key], rel=1e-9), (override, key)
