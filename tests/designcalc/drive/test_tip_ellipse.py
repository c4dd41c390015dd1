"""Ellipse of the tip by direct geometry of the rigid body; frequencies for the thesis's speed."""

import numpy as np
import pytest

from designcalc.drive.tip_ellipse import frequency_for, speed_of, tip_ellipse
from tests.reference.tables import reference

REFERENCE = reference("friction_drive")


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
