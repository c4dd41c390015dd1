"""Pitches of a periodic effect, from a few to hundreds within the range of the position."""

from pathlib import Path

import numpy as np
import pytest
from scipy.interpolate import CubicSpline

from sim.effects.catalogue import find
from sysid.diagnose import diagnose
from sysid.estimation.fit import fit_model
from sysid.estimation.score_test import pitches, profiled_residual
from sysid.estimation.screening import screen_and_refit
from tests.sysid.slide import POSITION, SIGN, TIME, VELOCITY, slide

RANGE = float(np.ptp(POSITION))
COGGING = Path(__file__).resolve().parents[4] / "shared" / "data" / "laas_cogging_static_quarter"


@pytest.mark.parametrize("waves", [5.3, 35.0, 72.0, 190.0])
@pytest.mark.parametrize("effect", ["magnetic_cogging", "position_dependent_friction"])
def test_a_pitch_is_found_whatever_its_number_in_the_range(tmp_path: Path, effect: str, waves: float) -> None:
    wave = np.sin(2.0 * np.pi * POSITION * waves / RANGE + 0.7)
    force = 1.5 * SIGN + 20.0 * VELOCITY + (0.1 * wave if effect == "magnetic_cogging" else 0.1 * wave * SIGN)
    problem = slide(tmp_path, force, '"coulomb", "viscous"')
    base = fit_model(problem.start, problem.fit_records)
    profiled = profiled_residual(base)

    peaks = pitches(base, find(effect), problem.fit_records, problem.scales, profiled[1])
    found = screen_and_refit(base, find(effect), problem.fit_records, problem.scales, profiled)

    if waves > 10.0:
        # Half the width of a peak, for the highest one.
        assert RANGE / peaks[0] == pytest.approx(waves, abs=0.25)
    assert found is not None and found.predicted_reduction > 0.8
    assert found.fitted.model.values[f"{effect}.pitch"] == pytest.approx(RANGE / waves, rel=1e-3)


@pytest.mark.parametrize("effect", ["magnetic_cogging", "position_dependent_friction"])
def test_the_shortest_pitch_of_the_search_is_found(tmp_path: Path, effect: str) -> None:
    """487 periods in the range, at five rows a period and more."""
    time = np.linspace(0.0, TIME[-1], 10 * TIME.size)
    position = CubicSpline(TIME, POSITION)(time)
    velocity = np.gradient(position, time)
    pitch = np.ptp(position) / 487.0
    wave = 0.1 * np.sin(2.0 * np.pi * position / pitch + 0.7)
    force = (1.5 + (effect != "magnetic_cogging") * wave) * np.sign(velocity) + 20.0 * velocity
    force += (effect == "magnetic_cogging") * wave
    motion = {"time [s]": time, "position [m]": position, "velocity [m/s]": velocity}
    problem = slide(tmp_path, force, '"coulomb", "viscous"', extra=motion)
    base = fit_model(problem.start, problem.fit_records)

    found = screen_and_refit(base, find(effect), problem.fit_records, problem.scales, profiled_residual(base))

    assert found is not None and found.predicted_reduction > 0.8
    assert found.fitted.model.values[f"{effect}.pitch"] == pytest.approx(pitch, rel=1e-4)


@pytest.mark.skipif(not COGGING.is_dir(), reason="the measured record is not at hand")
def test_cogging_of_a_motor_with_72_periods_a_turn_is_first() -> None:
    best = diagnose(COGGING).trials[0]
    assert best.public_name == "magnetic_cogging"
    # 72 a turn, heitor-andrade/laas_anti_cogging; a record of 11 periods.
    assert 2.0 * np.pi / best.fitted.model.values["magnetic_cogging.pitch"] == pytest.approx(72.0, abs=0.3)
