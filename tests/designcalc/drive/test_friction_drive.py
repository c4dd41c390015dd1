"""Friction drive, and the clamp of its actuator, against closed forms."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.optimize import linprog

from designcalc.checks.check import DesignInputs
from designcalc.checks.run import run_checks
from designcalc.drive import friction_drive as drive
from designcalc.drive.tip_ellipse import frequency_for, speed_of, tip_ellipse
from designcalc.friction_stage.physics.clamp import clamp_finger, clamp_gap, grip
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
