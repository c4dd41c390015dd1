"""The driven stage against limits that are known without it: closed forms, statics, another integrator."""

import math
from dataclasses import replace

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.optimize import brentq
from stage_machines import GRAVITY, RADIUS, example, ideal_piezos, symmetric

from designcalc.drive.friction_drive import acceleration_limit, tip_force_limit
from sim.stage.drive_setting import (
    Setting,
    ellipse_wave,
    knots_wave,
    run_setting,
    steady,
    step_times,
    two_piezo_ellipse,
)
from sim.stage.simulation import StageSimulation, drive_stage
from sim.stage.statics import over_drive_surface, rest_at, rest_with_load
from sim.stage.studies.travel_map import pushed_over
from stagecad.parameters.errors import InputError
from tests.refusals import refused

STEP = 1e-6
FAR_BELOW = -1e-4
"""m: a tip set so low never touches."""


def held(machine, duration: float) -> np.ndarray:
    return np.full((round(duration / STEP), len(machine.actuators), 3), machine.piezo.bias)


def test_a_stage_at_rest_balances_its_loads_or_is_refused():
    machine = example()
    run = drive_stage(machine, rest_with_load(machine, 0.03, 4.0), held(machine, 0.02), STEP)
    assert np.abs(run.position[:, :2]).max() < 1e-13 and np.abs(run.position[:, 2]).max() < 1e-13
    assert np.ptp(run.attitude[:, 0]) < 1e-13 and run.energy["drive"][-1] == 0.0
    machine = replace(example(), stage=replace(example().stage, centre=np.array([0.003, -0.004, 0.014]), preload=3.0))
    rest = rest_with_load(machine, 0.02, 5.0)
    pads = machine.pads.places
    assert rest.tip_loads[0] == pytest.approx(5.0, rel=1e-9)
    assert np.append(rest.pad_loads, rest.tip_loads).sum() == pytest.approx(3.0 * GRAVITY + 3.0, rel=1e-10)
    weight = 3.0 * GRAVITY * np.array([0.003, -0.004])
    assert rest.pad_loads @ pads + 5.0 * np.array([-0.02, 0.0]) == pytest.approx(weight, abs=1e-9)
    machine = example()
    beyond = replace(machine, stage=replace(machine.stage, centre=np.array([0.05, 0.0, 0.014])))
    refused("outside the pads", rest_at, beyond, 0.0, np.array([FAR_BELOW]))


def test_a_free_tip_follows_the_rigid_body_kinematics():
    """x = -h (d2 - d1)/D, up = (d1 + d2 + d3)/3, y = -h [d3 - (d1 + d2)/2]/(D sqrt(3)/2), slowly and out of touch."""
    machine = ideal_piezos(example())
    volts = held(machine, 0.01) + np.array([20.0, -10.0, 5.0]) * np.linspace(0.0, 1.0, 10_000)[:, None, None]
    run = drive_stage(machine, over_drive_surface(machine, 0.0, FAR_BELOW), volts, STEP)
    first, second, third = np.array([20.0, -10.0, 5.0]) * 17e-6 / 150.0
    asked = [
        -0.02 * (second - first) / 0.046,
        -0.02 * (third - 0.5 * (first + second)) / (1.5 * RADIUS),
        (first + second + third) / 3.0,
    ]
    assert run.apex(0)[-1] == pytest.approx(asked, rel=2e-3)


def test_the_tip_rings_at_its_resonances():
    machine = ideal_piezos(example())
    machine = replace(machine, tip=replace(machine.tip, damping=0.0))
    volts = held(machine, 0.04) + np.array([10.0, -5.0, 5.0])
    run = drive_stage(machine, over_drive_surface(machine, 0.0, FAR_BELOW), volts, STEP, stride=1)
    heave = math.sqrt(3 * 47e6 / 0.032) / (2 * math.pi)
    turn = math.sqrt(47e6 * 0.046**2 / 2 / 1e-5) / (2 * math.pi)
    for axis, expected in ((2, heave), (0, turn), (1, turn)):
        wave = run.apex(0)[:, axis] - run.apex(0)[:, axis].mean()
        crossings = np.flatnonzero((wave[1:] > 0) & (wave[:-1] <= 0))
        found = (crossings.size - 1) / (run.time[crossings[-1]] - run.time[crossings[0]])
        assert found == pytest.approx(expected, rel=2e-3)


def test_a_slow_small_step_is_springs_in_series_against_the_pads():
    machine = ideal_piezos(example())
    load, asked = 8.0, 0.2e-9
    rest, time = rest_with_load(machine, 0.0, load), step_times(60_000, STEP)
    wave = knots_wave(machine, time, np.array([0.0, 0.03, 0.06]), np.array([[0.0, 0, 0], [asked, 0, 0], [asked, 0, 0]]))
    run = drive_stage(machine, rest, wave, STEP)
    contact = 0.8 * 1.5 * 7.3e9 * (load / 7.3e9) ** (1 / 3)
    tilt = 47e6 * 0.046**2 / 2 / 0.02**2
    series = 1 / (1 / contact + 1 / tilt)
    # 1 - (1 - u)^2 over its first knot, u = 0.06: a slope of 1.94 cap/s_full.
    pads = 1.94 * 0.06 * (3.0 * GRAVITY - load) / 0.5e-6
    assert run.position[run.time > 0.05, 0].mean() == pytest.approx(asked * series / (series + pads), rel=0.01)


def test_coasting_stops_after_coulombs_time_and_distance():
    machine = example()
    plain = replace(machine.pads, static_friction=0.05, presliding=0.05e-6, tangential_lag=0.0)
    machine = symmetric(replace(machine, pads=plain))
    pads = replace(machine.pads, presliding=0.05e-6)
    machine = replace(machine, stage=replace(machine.stage, preload=6.0), pads=pads)
    speed = 0.01
    run = drive_stage(machine, over_drive_surface(machine, 0.0, FAR_BELOW), held(machine, 0.03), STEP, velocity=speed)
    slowing = 0.05 * (3.0 * GRAVITY + 6.0) / 3.0
    assert run.position[:, 0].max() == pytest.approx(speed**2 / (2 * slowing), rel=5e-3)
    assert run.time[np.argmax(run.velocity[:, 0] <= 0.0)] == pytest.approx(speed / slowing, rel=5e-3)


def test_another_integrator_agrees_on_heave_against_a_rising_tip():
    """Stage and tip move up and down only: two masses, pads and contact by their laws, by DOP853 at 1e-10."""
    machine = symmetric(ideal_piezos(example()))
    rise, height = 2e-3, 4e-6
    rest, time = rest_with_load(machine, 0.0, 0.0), step_times(8000, STEP)
    knots = np.array([[0, 0, 0.0], [0, 0, height], [0, 0, height]])
    run = drive_stage(machine, rest, knots_wave(machine, time, np.array([0.0, rise, 1.0]), knots), STEP, stride=4)
    pads, contact, tip = machine.pads, machine.contact, machine.tip

    def pressed(rate: float, damping: float, depth: float, speed: float) -> float:
        return max(rate * max(depth, 0.0) ** 1.5 * (1 + damping * speed), 0.0)

    def slopes(t: float, y: np.ndarray) -> list[float]:
        z, v, a, w = y
        pad = 4 * pressed(pads.contact_rate, pads.damping, -z, -v)
        touch = pressed(contact.rate, contact.damping, float(rest.apex_heights[0]) + a - z, w - v)
        free = height * min(t / rise, 1.0)
        push = 3 * (tip.stiffness * (free - a) - tip.damping * w)
        return [v, (pad + touch - 3.0 * GRAVITY) / 3.0, w, (push - touch) / tip.mass]

    start, accuracy = [rest.attitude[0], 0, 0, 0], {"rtol": 1e-10, "atol": 1e-16, "max_step": 1e-5}
    found = solve_ivp(slopes, (0.0, 8e-3), start, "DOP853", run.time, **accuracy)
    assert np.abs(run.attitude[:, 0] - found.y[0]).max() < 2e-4 * np.ptp(found.y[0])
    assert np.abs(run.apex(0)[:, 2] - found.y[2]).max() < 2e-3 * np.ptp(found.y[2])


@pytest.fixture(scope="module")
def driven():
    """Ten milliseconds at 5 kHz, at three steps of time."""
    machine = example()
    ellipse = two_piezo_ellipse(machine, 8.5e-6, math.pi / 2)
    rest = over_drive_surface(machine, 0.0, -0.3 * ellipse.normal)
    runs = {}
    for step in (1e-6, 5e-7, 2.5e-7):
        time = step_times(round(0.01 / step), step)
        wave = ellipse_wave(machine, ellipse, 5000.0, time, np.minimum(time / 2e-3, 1.0))
        runs[step] = drive_stage(machine, rest, wave, step, stride=1)
    return runs


def test_a_driven_stage_keeps_energy_momentum_and_convergence(driven):
    left = []
    for run in driven.values():
        energy = {name: values - values[0] for name, values in run.energy.items()}
        heats = [energy[name] for name in ("pads", "contacts", "damping")]
        balance = energy["kept"] - energy["drive"] + sum(heats)
        left.append(np.abs(balance).max() / energy["drive"][-1])
        for heat in heats:
            assert np.diff(heat).min() > -1e-15
    # A separate program left 1.4e-3, 3.9e-4 and 1.2e-4 of the work of the drive at the same steps, with a larger plate.
    assert np.all(np.array(left) < [1.4e-3, 3.9e-4, 1.2e-4])
    assert [left[0] / left[1], left[1] / left[2]] == pytest.approx([3.6, 3.25], rel=0.03)
    ends = [run.position[-1] for run in driven.values()]
    coarse, fine = np.abs(ends[0] - ends[1]), np.abs(ends[1] - ends[2])
    assert coarse[0] < 5e-3 * ends[2][0] and fine[0] < coarse[0]
    run = driven[1e-6]
    forces = run.tip_force(0) + sum(run.pad_force(k) for k in range(3))
    forces[:, 2] -= 3.0 * GRAVITY
    # Row to row: half a step's acceleration on either side.
    gained = np.diff(run.velocity[:, :3], axis=0)
    assert 3.0 * gained == pytest.approx(0.5e-6 * (forces[1:] + forces[:-1]), abs=1e-12)
    assert np.diff(run.tip_impulse(0), axis=0) == pytest.approx(1e-6 * run.tip_force(0)[1:], abs=1e-15)


def test_a_symmetric_or_reversed_drive_moves_alike():
    machine = symmetric(ideal_piezos(example()))
    ellipse = two_piezo_ellipse(machine, 8.5e-6, math.pi / 2)
    x, y, yaw = run_setting(machine, Setting(ellipse, 5000.0, -0.3 * ellipse.normal), 0.03).position[-1]
    assert x > 1e-4 and abs(y) < 1e-10 * x
    assert abs(yaw) < 1e-9
    ends = []
    for phase in (math.pi / 2, -math.pi / 2):
        ellipse = two_piezo_ellipse(machine, 8.5e-6, phase)
        ends.append(run_setting(machine, Setting(ellipse, 5000.0, -0.3 * ellipse.normal), 0.02).position[-1, 0])
    assert ends[1] == pytest.approx(-ends[0], rel=1e-6)


@pytest.mark.parametrize("position", [0.02, 0.06, -0.1])
def test_the_stage_tips_where_moments_say(position):
    machine = example()
    share = pushed_over(machine, position)
    # By hand for a tip on y = 0: there the triangle of pads reaches from -12.5 to 12.5 mm.
    by_hand = 0.0125 / (0.0125 + abs(position))
    assert tip_force_limit(machine.pads.places, np.zeros(2), np.array([-position, 0.0])) == pytest.approx(by_hand)
    assert share == pytest.approx(by_hand, rel=0.03)


def test_laws_of_speed_and_thrust_at_their_ends():
    machine = example()
    ellipse = two_piezo_ellipse(machine, 8.5e-6, math.pi / 2)
    run = run_setting(machine, Setting(ellipse, 5000.0, -0.3 * ellipse.normal), 0.03)
    gained = run.mean_velocity(0.02, 0.03)[0] - run.mean_velocity(0.01, 0.02)[0]
    limit = float(acceleration_limit(0.3, 0.0, run.mean_tip_load(0.01, 0.03) / machine.load, 0.05))
    assert 0.3 * limit < gained / 0.01 < limit
    # Slow turns stop the stage each time: X f. Quick ones let it coast, between 2 X f and pi X f.
    machine = symmetric(ideal_piezos(example()))
    ellipse = two_piezo_ellipse(machine, 8.5e-6, math.pi / 2)
    slow = steady(machine, Setting(ellipse, 20.0, 0.0), shortest=0.2)
    assert slow.velocity[0] / (2 * ellipse.along * 20.0) == pytest.approx(1.0, abs=0.15)
    quick = steady(machine, Setting(ellipse, 1000.0, -0.3 * ellipse.normal), shortest=0.2)
    assert 1.9 < quick.velocity[0] / (2 * ellipse.along * 1000.0) < math.pi


def test_weak_and_light_tips():
    """Its mean thrust, friction times load, is less than the pads' drag: a stage that moves comes to rest."""
    machine = example()
    ellipse = two_piezo_ellipse(machine, 8.5e-6, math.pi / 2)
    weak = steady(machine, Setting(ellipse, 5000.0, -0.8 * ellipse.normal), shortest=0.2)
    assert 0.3 * weak.tip_load < 0.05 * (machine.load - weak.tip_load)
    assert abs(weak.velocity[0]) < 0.01 * 2 * ellipse.along * 5000.0
    light = replace(machine, tip=replace(machine.tip, mass=1e-3))
    with pytest.raises(InputError, match="too long for a mode"):
        drive_stage(light, over_drive_surface(light, 0.0, FAR_BELOW), held(light, 0.001), STEP)


def test_a_stage_set_back_moves_on_alike():
    machine = symmetric(ideal_piezos(example()))
    ellipse = two_piezo_ellipse(machine, 8.5e-6, math.pi / 2)
    wave = ellipse_wave(machine, ellipse, 5000.0, step_times(4000, STEP))
    runs = []
    for back in (0.0, 1e-3):
        simulation = StageSimulation(machine, over_drive_surface(machine, 0.5 * back, -0.3 * ellipse.normal), STEP, 0.1)
        simulation.advance(wave[:2000])
        simulation.set_back(back)
        simulation.advance(wave[2000:])
        runs.append(simulation.record().position[:, 0])
        # The last row is within a step of the end.
        assert simulation.travel == pytest.approx(runs[-1][-1], abs=2 * STEP * 0.1)
    assert runs[1] == pytest.approx(runs[0], abs=2e-3 * np.ptp(runs[0]))


def test_contact_depth_is_hertz():
    machine = example()
    rest = rest_with_load(machine, 0.0, 10.0)
    free = rest_at(machine, 0.0, np.array([FAR_BELOW]))
    # Stage up by what the pads are relieved of, contact and stacks pressed together.
    relieved = [brentq(lambda d, n=n: 1.2e11 * d**1.5 - n, 0.0, 1e-5) for n in (free.pad_loads[0], rest.pad_loads[0])]
    assert free.pad_loads[0] - rest.pad_loads[0] == pytest.approx(2.5, rel=1e-9)
    depth = (10.0 / 7.3e9) ** (2 / 3) + 10.0 / (3 * 47e6)
    assert rest.apex_heights[0] == pytest.approx(rest.attitude[0] + depth, rel=1e-9)
    assert relieved[0] > relieved[1]
