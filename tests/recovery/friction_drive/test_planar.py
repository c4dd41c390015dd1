"""A stage that moves in the plane: against the pass along one axis, and on records of a rig in code of its own."""

import math
from pathlib import Path

import numpy as np
import pytest

from sim.integration.friction_drive.event_driven import simulate_event_driven
from sim.integration.friction_drive.inputs import DrivenStage, TipMotion, velocity_independent
from sim.integration.friction_drive.planar import Guide, PlanarTipMotion, simulate_planar
from sysid.estimation.misfit import misfit
from sysid.estimation.reference_fit import fit_stated_model
from sysid.prediction.problem import load_problem
from tests.experiments import write_rig

STIFFNESS, DAMPING, MASS, PADS = 8e6, 400.0, 3.0, 1.5
SPACING, HEIGHT, GAIN, GUIDE, TURN, NOISE = 0.046, 0.02, 1.1e-7, 4e5, 0.04, 2e-9


@pytest.mark.parametrize("slip", [math.inf, 4.0])
def test_in_a_plane_without_a_guide_no_direction_is_special(slip):
    """Along any line the motion is that of one axis."""
    step = 5e-4
    time = np.arange(2000) * step
    teeth = 5e-6 * np.interp(time % 0.1, [0.0, 0.096, 0.1], [0.0, 1.0, 0.0])
    waves = 5e-6 * np.sin(2 * np.pi * 7.0 * time) * np.minimum(time / 0.1, 1.0)
    tip = waves if slip == math.inf else teeth
    one, rest = np.ones(time.size), np.zeros(time.size)
    level, pads = np.full(time.size, slip), np.full(time.size, PADS)
    driven = DrivenStage(STIFFNESS, DAMPING, MASS, step)
    curves = velocity_independent(level), velocity_independent(pads)
    line = simulate_event_driven(TipMotion(tip, one), rest, *curves, driven)
    motion = PlanarTipMotion(0.6 * tip, 0.8 * tip, one)
    along, across = simulate_planar(motion, rest, level, pads, driven, Guide(0.0, 0.0), 4)
    assert np.abs(along - 0.6 * line).max() < 1e-3 * np.ptp(line)
    assert np.abs(across - 0.8 * line).max() < 1e-3 * np.ptp(line)


def _records(folder: Path) -> None:
    """Plain Euler steps; the tip goes where three stacks lean it, teeth pull back across, sensors stand turned."""
    sample, fine = 5e-4, 1e-5
    per, records = round(sample / fine), {}
    for role, seed in (("fit", 3), ("validate", 4)):
        random = np.random.default_rng(seed)
        time = np.arange(2000) * sample
        volts = []
        for _ in range(3):
            waves = sum(
                random.uniform(8.0, 16.0) * np.sin(2 * np.pi * f * time + random.uniform(0, 6)) for f in (2.3, 5.1, 9.7)
            )
            volts.append((waves - waves[0]) * np.minimum(time / 0.1, 1.0))
        ticks = np.arange((time.size - 1) * per + 1) * fine
        one, two, three = (GAIN * np.interp(ticks, time, v) for v in volts)
        tip_x = (-HEIGHT / SPACING * (two - one)).tolist()
        tip_y = (-HEIGHT * (three - 0.5 * (one + two)) / (SPACING * math.sqrt(3.0) / 2.0)).tolist()
        x = y = vx = vy = 0.0
        moved = []
        for k in range(ticks.size):
            before = max(k - 1, 0)
            fx = STIFFNESS * (tip_x[k] - x) + DAMPING * ((tip_x[k] - tip_x[before]) / fine - vx)
            fy = STIFFNESS * (tip_y[k] - y) + DAMPING * ((tip_y[k] - tip_y[before]) / fine - vy) - GUIDE * y
            vx, vy = vx + fx / MASS * fine, vy + fy / MASS * fine
            speed = math.hypot(vx, vy)
            kept = max(speed - PADS / MASS * fine, 0.0) / speed if speed > 0.0 else 0.0
            vx, vy = kept * vx, kept * vy
            x, y = x + vx * fine, y + vy * fine
            if k % per == 0:
                moved.append((math.cos(TURN) * x - math.sin(TURN) * y, math.sin(TURN) * x + math.cos(TURN) * y))
        seen = np.array(moved) + NOISE * random.standard_normal((time.size, 2))
        voltages = {f"voltage_{k} [V]": 75.0 + v for k, v in enumerate(volts, start=1)}
        records[role] = {"time": time, **voltages, "position": seen[:, 0], "position_y": seen[:, 1]}
    known = {"mass": f"{MASS} kg", "piezo_spacing": f"{SPACING} m", "tip_height": f"{HEIGHT} m", "bias_voltage": "75 V"}
    noise = dict.fromkeys(("position", "position_y"), f"{NOISE} m")
    write_rig(folder, "friction-drive", records, ["coulomb"], known=known, noise=noise)


def test_motion_along_and_across_is_predicted_down_to_the_noise(tmp_path):
    _records(tmp_path)
    problem = load_problem(tmp_path)
    values = (base := fit_stated_model(problem)).fitted.model.values
    left = misfit(base.fitted.model, problem.validate_records)
    assert left["position"].over_noise < 1.1 and left["position_y"].over_noise < 1.1
    assert values["rig.turn"] == pytest.approx(TURN, abs=2e-4)
    assert values["rig.gain"] == pytest.approx(GAIN, rel=1e-3)
    # What is known is the mass: inertia tells every force, that of guide and pads too.
    assert values["rig.guide_stiffness"] == pytest.approx(GUIDE, rel=0.03)
    assert values["coulomb.force"] == pytest.approx(PADS, rel=0.03)
