"""Friction drive, the clamp of its actuator, and its piezo stacks with their heat, against closed forms."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.integrate import solve_bvp
from scipy.optimize import linprog

from designcalc.checks.check import DesignInputs
from designcalc.checks.run import run_checks
from designcalc.drive import friction_drive as drive
from designcalc.drive import piezo_stack as stack
from designcalc.drive.thermal_network import ThermalNetwork
from designcalc.drive.tip_ellipse import frequency_for, speed_of, tip_ellipse
from designcalc.friction_stage.physics.clamp import clamp_finger, clamp_gap, grip
from designcalc.friction_stage.physics.heat import growth, network, warmed
from stagecad.parameters.load import load_design
from tests.reference.tables import reference
from tests.refusals import refused

REFERENCE = reference("friction_drive")
CASES = reference("clamp")["case"]
SHORT = tuple(CASES[0]["overrides"])


@pytest.mark.parametrize("mass, frequency", REFERENCE["resonance"]["rows"])
def test_resonance_of_the_tip(mass, frequency):
    stiffness = REFERENCE["resonance"]["piezos"] * REFERENCE["resonance"]["piezo_stiffness"]
    assert float(drive.resonance(stiffness, mass)) == pytest.approx(frequency, rel=5e-3)


def test_traction_tipping_and_frequencies_of_the_thesis():
    case = REFERENCE["traction"]
    limit = drive.acceleration_limit(case["friction"], case["preload_ratio"]) / drive.GRAVITY
    assert float(limit) == pytest.approx(case["acceleration_in_g"], rel=1e-9)
    needed = drive.preload_ratio_for(drive.GRAVITY, case["friction"])
    assert float(needed) == pytest.approx(case["full_g_preload"], abs=4e-3)
    assert float(drive.acceleration_limit(case["friction"], needed)) == pytest.approx(drive.GRAVITY)
    pads = [(-0.025, 0.115), (0.025, 0.115), (0.0, -0.115)]
    assert drive.tip_force_limit(pads, (0.0, 0.0), (0.1, 0.0)) == pytest.approx(0.0125 / 0.1125)
    assert drive.tip_force_limit(pads, (0.0, 0.0), (0.0, 0.0)) == 1.0
    assert drive.tip_force_limit(pads, (0.1, 0.0), (0.0, 0.0)) == 0.0
    wanted = REFERENCE["speed"]
    needed = frequency_for(wanted["speed"], REFERENCE["ellipse"]["along"])
    for law in ("stopping", "coasting", "apex"):
        assert float(needed[law]) == pytest.approx(wanted[law], rel=5e-3)
        assert float(speed_of(REFERENCE["ellipse"]["along"], needed[law])[law]) == pytest.approx(wanted["speed"])


@given(
    st.lists(st.tuples(st.floats(-0.2, 0.2), st.floats(-0.2, 0.2)), min_size=3, max_size=5),
    st.tuples(st.floats(-0.3, 0.3), st.floats(-0.3, 0.3)),
)
def test_tip_over_agrees_with_linear_programming(pads, tip):
    points = np.array(pads)
    centre = points.mean(axis=0)
    area = np.linalg.svd(points - centre, compute_uv=False)
    if area[1] < 1e-2 or np.hypot(*(np.array(tip) - centre)) < 1e-4:
        return
    n = len(pads)
    # reactions r_i >= 0 and the tip's force f balance a unit load at the centre
    balance = np.zeros((3, n + 1))
    balance[0], balance[1:, :n], balance[1:, n] = 1.0, points.T, np.array(tip)
    answer = linprog([0.0] * n + [-1.0], A_eq=balance, b_eq=[1.0, *centre], bounds=[(0, None)] * (n + 1))
    assert drive.tip_force_limit(points, centre, tip) == pytest.approx(answer.x[-1], rel=1e-6, abs=1e-9)


def test_ellipse_is_that_of_the_rigid_tip():
    given_ = REFERENCE["ellipse"]
    ellipse = tip_ellipse(given_["amplitude"], given_["phase"], given_["piezo_spacing"], given_["tip_height"])
    assert float(ellipse.along) == pytest.approx(given_["along"], rel=1e-3)
    # the rigid body itself, not linearised: tip = (D/2, mean stroke) + h times the normal of the piezo line
    t = np.linspace(0, 2 * np.pi, 20001)
    d1 = given_["amplitude"] * np.sin(t)
    d2 = given_["amplitude"] * np.sin(t - given_["phase"])
    D, h = given_["piezo_spacing"], given_["tip_height"]
    length = np.hypot(D, d2 - d1)
    x, y = D / 2 - h * (d2 - d1) / length, (d1 + d2) / 2 + h * D / length
    assert float(ellipse.along) == pytest.approx(np.ptp(x), rel=1e-6)
    assert float(ellipse.normal) == pytest.approx(np.ptp(y), rel=1e-3)


def inputs(*overrides: str) -> DesignInputs:
    return DesignInputs(load_design(None, overrides, rules=False))


@pytest.mark.parametrize("case", CASES, ids=lambda case: case["name"])
def test_model_agrees_with_finite_elements(case):
    """`benchmarks/clamp_finite_elements.py` solves the plan of each case, extruded; 5 kN on the screw, gap of 20 um."""
    finger = clamp_finger(inputs(*case["overrides"]))
    assert finger.closure == pytest.approx(case["closure"], rel=0.2)
    assert finger.give == pytest.approx(case["give"], rel=0.2)
    assert finger.stress(1.0) == pytest.approx(case["free_stress"], rel=0.2)
    # Of the force without a gap: what is left after closing it is a difference.
    assert finger.press_force(5e3, 20e-6) == pytest.approx(case["grip"], abs=0.2 * 5e3 * case["closure"] / case["give"])
    assert finger.stress(5e3, case["grip"]) == pytest.approx(case["grip_stress"], rel=0.2)


@pytest.mark.slow
def test_the_reference_is_what_the_elements_give():
    """A coarser mesh than that of the reference."""
    pytest.importorskip("gmsh")
    pytest.importorskip("skfem")
    from benchmarks.clamp_finite_elements import solve

    found = solve(load_design(None, tuple(CASES[-1]["overrides"]), rules=False), 2.0)
    for key, error in (("closure", 0.05), ("give", 0.05), ("free_stress", 0.1), ("grip_stress", 0.1)):
        assert found[key] == pytest.approx(CASES[-1][key], rel=error), key


def test_the_neck_carries_the_moment_of_the_screw():
    """Statics: its moments over the depth add up to force times lever, wherever the screw is."""
    finger = clamp_finger(inputs())
    z = np.linspace(0, finger.depth, 20001)
    for depth in (0.0, 18e-3, 70e-3):
        moment = finger.hinge_stiffness * finger.turn(z, np.array(depth))
        assert np.trapezoid(moment, z) == pytest.approx(1.0, rel=1e-6)
    # A finger that does not twist turns alike over its depth, and presses with the ratio of the levers.
    stiff = replace(finger, lug_width=1.0, lug_thickness=1.0, press_depth=finger.depth, wedge_angle=2.0)
    levers = stiff.screw_lever * stiff.press_lever
    assert stiff.closure * stiff.hinge_stiffness * stiff.depth == pytest.approx(levers, rel=1e-3)
    assert stiff.press_force(1e3, 0.0) == pytest.approx(1e3 * stiff.screw_lever / stiff.press_lever, rel=1e-3)
    assert stiff.press_force(1e3, 1.0) == 0.0


def test_packaged_and_thick_necked_clamps_grip_or_not():
    """With a play of 25 to 35 um a side the finger of 6 mm moves 25 to 35 um at 5.25 kN, and 42 to 59 um are needed."""
    torque = "screws.clamp_long.torque=10 N*m"
    short = grip(inputs(*SHORT, torque), 20e-6)
    assert 25e-6 < short.closure < 42e-6 < clamp_gap(inputs(*SHORT)) < short.gap < 61e-6
    assert short.press == 0.0 and short.hold == 0.0
    checks = {check.name: check.verdict for check in run_checks(inputs(*SHORT, torque).design, subjects=("clamp",))}
    assert checks["play closed by the clamp"] == "fails"
    assert checks["force with which the clamp holds the actuator"] == "fails"
    held = grip(inputs(), 20e-6)
    assert held.closure > 1.5 * held.gap and held.press > 1e3 and held.stress < held.free_stress
    assert all(check.verdict == "passes" for check in run_checks(inputs().design, subjects=("clamp",)))
    packaged, case = clamp_finger(inputs()), clamp_finger(inputs(*CASES[-1]["overrides"]))
    assert packaged.closure == pytest.approx(case.closure, rel=1e-6)
    assert packaged.stress(1.0) == pytest.approx(case.stress(1.0), rel=1e-6)


def test_bad_clamps_are_refused():
    refused("clamp_slot_1", clamp_finger, inputs("base.clamp_slot_1=45 mm"))
    refused("clamp_neck_angle_1", clamp_finger, inputs("base.clamp_neck_angle_1=30 deg"))
    refused("neck", replace, clamp_finger(inputs()), neck=0.0)
    refused("relief_radius", replace, clamp_finger(inputs()), relief_radius=0.1)


L, A, E = 36e-3, 25e-6, 50e9
TWO = ThermalNetwork(np.array([3.0, 50.0]), np.array([[0.0, 1.5], [1.5, 0.0]]), np.array([0.1, 0.4]))
POWER = np.array([20.0, 0.0])


def beam_moment(force, tilt=None):
    """Largest bending moment of a cantilever: a force across its end, or its end tilted and held sideways."""
    inertia = A**2 / 12

    def slopes(x, y):
        return np.vstack([y[1], y[2] / (E * inertia), y[3], np.zeros_like(x)])

    def ends(foot, end):
        last = [end[2], end[3] + force] if tilt is None else [end[0], end[1] - tilt]
        return np.array([foot[0], foot[1], *last])

    x = np.linspace(0, L, 50)
    found = solve_bvp(slopes, ends, x, np.zeros((4, x.size)), tol=1e-8)
    assert found.success
    return np.abs(found.y[2]).max(), found.y[0, -1]


def test_tension_is_the_largest_pull_while_the_tip_rises_and_rocks():
    """Forces of two stacks by Newton and Euler over a period, their strokes a quarter of a period apart."""
    m, J, f, h, D, A = 0.0319, 7.87e-6, 5e3, 20e-3, 46e-3, 8.5e-6
    t = np.linspace(0, 1 / f, 40001)
    d1, d2 = A * np.sin(2 * np.pi * f * t), A * np.sin(2 * np.pi * f * t - np.pi / 2)

    def acceleration(y):
        return np.gradient(np.gradient(y, t), t)[2:-2]

    lift, turn = m * acceleration((d1 + d2) / 2), J * acceleration((d2 - d1) / D)
    pull = -np.minimum(lift / 2 - turn / D, lift / 2 + turn / D)
    X, Y = 4 * A * h / D * np.sin(np.pi / 4), 2 * A * np.cos(np.pi / 4)
    found = float(stack.stack_tension(m, J, f, Y, X / 2 / h, D))
    assert found == pytest.approx(pull.max(), rel=1e-3)
    # 94.7 N of the rise and 44.1 N of the rocking of the packaged tip, 104.5 N together, worked out separately.
    assert float(stack.stack_tension(m, 0.0, f, Y, X / 2 / h, D)) == pytest.approx(94.7, rel=2e-3)
    assert float(stack.stack_tension(0.0, J, f, Y, X / 2 / h, D)) == pytest.approx(44.1, rel=2e-3)
    assert found == pytest.approx(104.5, rel=2e-3)


def test_drive_force_balances_and_stress_never_falls_with_it():
    assert float(stack.drive_pull(10.0, 20e-3, 46e-3)) * 46e-3 == pytest.approx(10.0 * 20e-3)
    stress = stack.side_load(np.linspace(0.0, 100.0, 300), L, 5.4e-3, A, E, 25e-6).stress
    assert np.all(np.diff(stress) >= 0) and stress[-1] > stress[60]


def test_side_load_is_that_of_a_beam_until_the_bore_holds_it():
    free = stack.side_load(3.3, L, 5.4e-3, A, E, 1e-3)
    moment, end = beam_moment(3.3)
    assert not free.touches and float(free.deflection) == pytest.approx(end, rel=1e-5)
    assert float(free.stress) == pytest.approx(moment * np.sqrt(A) / 2 / (A**2 / 12), rel=1e-5)
    # It touches at 5.39 N, with 9.3 MPa at the foot, by a separate solution of the propped cantilever.
    touching = stack.side_load(5.39, L, 5.4e-3, A, E, 25e-6)
    assert float(touching.touch_force) == pytest.approx(5.39, rel=2e-3)
    assert float(touching.stress) == pytest.approx(9.3e6, rel=5e-3)
    many = stack.side_load(np.array([1.0, 3.3, 10.0]), L, 5.4e-3, A, E, 25e-6)
    np.testing.assert_array_equal(many.touches, [False, False, True])
    assert float(stack.side_load(3.3, L, L, A, E, 0.0).stress) == pytest.approx(float(free.stress))


def test_sway_rocking_and_inertia_of_stacks_and_tip():
    bent = stack.side_load(1.0, L, 5.4e-3, A, E, 1e-3)
    assert float(stack.sway_stiffness(L, A, E)) == pytest.approx(1 / float(bent.deflection))
    assert float(stack.sway_stiffness(L, A, E)) == pytest.approx(0.167e6, rel=5e-3)
    angle, k, D = 1e-6, 47e6, 46e-3
    moment = 2 * k * (D / 2 * angle) * (D / 2)
    assert float(stack.rocking_stiffness(k, D)) * angle == pytest.approx(moment)
    # 4.694e-6 kg m^2 about the piezos' plane at 22.93 g, by integrating the exact solid.
    assert float(stack.tip_inertia(0.022933, 46e-3 / np.sqrt(3), 20e-3)) == pytest.approx(4.694e-6, rel=0.05)


def test_heat_of_a_stack_and_its_balance():
    C, V, f, loss = 1.5e-6, 150.0, 1000.0, 0.05
    t = np.linspace(0, 1 / f, 100001)
    voltage = V / 2 * np.sin(2 * np.pi * f * t)
    delay = np.arctan(loss)
    charge = C / np.cos(delay) * V / 2 * np.sin(2 * np.pi * f * t - delay)
    heat = f * np.trapezoid(voltage * np.gradient(charge, t), t)
    assert float(stack.stack_heat(C, V, f, loss)) == pytest.approx(heat, rel=1e-4)
    assert float(stack.stack_current(C, V, f)) == pytest.approx(np.max(np.gradient(C * voltage, t)), rel=1e-6)
    # Steady: all heat leaves to the surroundings; heated always: the steady state.
    assert TWO.outside @ TWO.steady(POWER) == pytest.approx(20.0)
    assert TWO.cycle(POWER, 8.0, 8.0)[0] == pytest.approx(TWO.steady(POWER))
    one = ThermalNetwork(np.array([3.0]), np.zeros((1, 1)), np.array([0.5]))
    assert one.after(np.zeros(1), np.array([20.0]), 2.0)[0] == pytest.approx(40.0 * -math.expm1(-2.0 / 6.0))
    refused("period", TWO.cycle, POWER, 9.0, 8.0)
    # 57.1 W in two stacks warm one without losses by 9.7 K/s: 25 mm^2 of ceramic, 36 mm long, 3.3 MJ/m^3/K.
    r = DesignInputs(load_design(None, ["heat.capacity=3.27e6 J/m^3/K"]))
    assert 57.1 / 2 / (r("heat.capacity") * 25e-6 * 36e-3) == pytest.approx(9.7, rel=0.01)
    warm = network(r).after(np.zeros(4), np.array([1.5 * 57.1, 0.0, 0.0, 0.0]), 1e-3)
    assert warm[0] == pytest.approx(9.7e-3, rel=0.02)


def test_temperature_and_drift_of_the_duty_cycle() -> None:
    """Twice the rest, nearly half of the mean heat: holder and base are half as warm; a move still warms the stacks."""
    often, seldom = (DesignInputs(load_design(None, [f"heat.period={s} s"])) for s in (10, 20))
    assert warmed(seldom).hottest[3] == pytest.approx(warmed(often).hottest[3] / 2, rel=0.01)
    assert warmed(seldom).hottest[0] > 0.7 * warmed(often).hottest[0]
    # The ceramic shrinks as it warms, and aluminium grows: the tip sinks by most of the stacks' shrinking.
    whole, comes_and_goes = growth(often)
    stacks = often.material("piezo", "expansion") * often("piezo.length") * warmed(often).hottest[0]
    assert stacks < whole < 0.7 * stacks and comes_and_goes == pytest.approx(whole, rel=0.2)
