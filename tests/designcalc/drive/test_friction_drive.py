"""Friction drive and ellipse of the tip: the thesis's numbers, linear programming, rigid-body geometry."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.optimize import linprog

from designcalc.drive import friction_drive as drive
from designcalc.drive.tip_ellipse import frequency_for, speed_of, tip_ellipse
from stagecad.parameters.errors import InputError
from tests.reference.tables import reference

REFERENCE = reference("friction_drive")


@pytest.mark.parametrize("mass, frequency", REFERENCE["resonance"]["rows"])
def test_resonance_of_the_tip(mass, frequency):
    stiffness = REFERENCE["resonance"]["piezos"] * REFERENCE["resonance"]["piezo_stiffness"]
    assert float(drive.resonance(stiffness, mass)) == pytest.approx(frequency, rel=5e-3)


def test_traction_without_lift_off():
    case = REFERENCE["traction"]
    limit = drive.acceleration_limit(case["friction"], case["preload_ratio"]) / drive.GRAVITY
    assert float(limit) == pytest.approx(case["acceleration_in_g"], rel=1e-9)
    needed = drive.preload_ratio_for(drive.GRAVITY, case["friction"])
    assert float(needed) == pytest.approx(case["full_g_preload"], abs=4e-3)
    assert float(drive.acceleration_limit(case["friction"], needed)) == pytest.approx(drive.GRAVITY)


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


def test_tip_over_is_span_over_span_and_travel():
    pads = [(-0.025, 0.115), (0.025, 0.115), (0.0, -0.115)]
    assert drive.tip_force_limit(pads, (0.0, 0.0), (0.1, 0.0)) == pytest.approx(0.0125 / 0.1125)
    assert drive.tip_force_limit(pads, (0.0, 0.0), (0.0, 0.0)) == 1.0
    assert drive.tip_force_limit(pads, (0.1, 0.0), (0.0, 0.0)) == 0.0
    with pytest.raises(InputError, match="one line"):
        drive.tip_force_limit([(0, 0), (1, 1), (2, 2)], (0, 0), (0, 1))


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


def test_frequencies_for_the_speed_of_table_1():
    wanted = REFERENCE["speed"]
    needed = frequency_for(wanted["speed"], REFERENCE["ellipse"]["along"])
    for law in ("stopping", "coasting", "apex"):
        assert float(needed[law]) == pytest.approx(wanted[law], rel=5e-3)
        assert float(speed_of(REFERENCE["ellipse"]["along"], needed[law])[law]) == pytest.approx(wanted["speed"])
