"""The judge itself: same seed, same records; its forces balance; it shares no code with the program."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from benchmarks.generators.hidden_effect import Plan, make_case
from benchmarks.generators.hidden_effect.axis import SPRING, AxisTruth, simulate_axis
from benchmarks.generators.hidden_effect.motions import Motion
from benchmarks.generators.several_effects import Machine, draw_law, iwan, make_cases, run
from sysid.diagnose import diagnose

ROWS = 4000
MACHINE = Machine(True, False, 0.1, 0.1, 10.0, 20.0, 5.0, 500.0, 2.0)


@pytest.mark.parametrize("rig", ["velocity-drive", "spring-pull", "force-drive", "actuator-tip"])
def test_the_same_seed_gives_the_same_records(rig: str) -> None:
    plan = Plan(rig, ("sensor_quantisation",), rows=ROWS, hard=True)
    one, two = (make_case(plan, np.random.default_rng(5)) for _ in range(2))
    pd.testing.assert_frame_equal(one.fit, two.fit)
    pd.testing.assert_frame_equal(one.validate, two.validate)
    assert one.toml == two.toml and not one.fit.iloc[:, 1].equals(one.validate.iloc[:, 1])


@pytest.mark.parametrize("rig", ["velocity-drive", "spring-pull", "force-drive", "actuator-tip"])
def test_with_nothing_hidden_the_base_model_leaves_nothing(rig: str) -> None:
    case = make_case(Plan(rig, rows=ROWS), np.random.default_rng(11))
    assert case.key["accept"] == ["adequate"] and case.key["visible"] < 0.1


@pytest.mark.parametrize("level,low,high", [("weak", 1.0, 3.0), ("moderate", 3.0, 10.0), ("strong", 10.0, 60.0)])
def test_a_hidden_effect_is_brought_to_its_level(level: str, low: float, high: float) -> None:
    case = make_case(Plan("velocity-drive", ("cable_spring",), level, rows=ROWS), np.random.default_rng(3))
    assert low <= case.key["visible"] <= high


def test_rigid_friction_holds_the_axis_exactly_and_lets_go_at_its_level() -> None:
    """A mass pulled slowly by a spring: it stands until the spring's force reaches the Coulomb force."""
    rows, speed, stiffness, coulomb = 2000, 1e-3, 2000.0, 2.0
    time = np.arange(rows) * 1e-3
    zero, one = np.zeros(rows), np.ones(rows)
    truth = AxisTruth(mass=1.0, pull_stiffness=stiffness, coulomb=coulomb)
    motion = Motion(speed * time, speed * one, zero, zero)
    around = {"load": 10 * one, "temperature": 21 * one, "factor": one, "extra": zero}
    run = simulate_axis(SPRING, truth, motion, **around, pitches=np.ones(1), phases=np.zeros(1))
    release = coulomb / (stiffness * speed)
    assert np.all(run.position[time < release - 2e-3] == 0.0) and run.position[time > release + 0.2].min() > 0.0
    # With equal static and kinetic friction it follows at v0 (1 - cos w t): never faster than twice v0.
    assert run.velocity.max() == pytest.approx(2 * speed, rel=0.01)


LAWS = {
    "flexible_mode": {"flexible_share": 0.25, "flexible_frequency": 98.0, "flexible_damping": 0.02},
    "presliding": {"presliding": 1e-4},
    "frictional_lag": {"stribeck": 0.5, "stribeck_velocity": 5e-3, "stribeck_delay": 5e-3},
    "backlash": {"backlash": 2e-4},
    "magnetic_cogging": {"cogging": 0.4},
    "quadratic_drag": {"quadratic": 20.0},
}


@pytest.mark.parametrize("name", LAWS)
def test_a_step_of_fifty_microseconds_is_fine_enough(name: str) -> None:
    """Sixteen times finer steps change the record by little of what the effect does to it."""
    from benchmarks.generators.hidden_effect.axis import SPRING, SUBSTEPS, AxisTruth, simulate_axis

    rows = 400
    time = np.arange(rows) * 1e-3
    zero, one = np.zeros(rows), np.ones(rows)
    speed = 0.03 + 0.01 * np.sin(20.0 * time)

    def positions(truth: AxisTruth, substeps: int) -> np.ndarray:
        run = simulate_axis(
            SPRING, truth, Motion(np.cumsum(speed) * 1e-3, speed, zero, zero), load=10 * one, temperature=21 * one,
            factor=one, extra=zero, pitches=np.ones(1), phases=np.zeros(1), substeps=substeps,
        )  # fmt: skip
        return run.position

    plain = AxisTruth(mass=1.9, pull_stiffness=4300.0, coulomb=1.0, viscous=4.0)
    usual, finer = (positions(plain._replace(**LAWS[name]), n) for n in (SUBSTEPS, 16 * SUBSTEPS))
    does = usual - positions(plain, SUBSTEPS)
    assert np.std(usual - finer) < 0.1 * np.std(does)


def test_the_force_of_a_generator_is_what_acts_on_the_mass() -> None:
    m = MACHINE
    m.laws = {"cable_spring": draw_law(np.random.default_rng(1), m, "cable_spring")}
    row = run(3, m, {"cable_spring": 50.0})
    acceleration = np.gradient(row["velocity"], row["time"])
    rest = row["force"] - m.mass * acceleration - m.level * row["side"] - m.drag * row["velocity"]
    rest = rest - 50.0 * m.laws["cable_spring"](row)
    away = np.convolve(np.abs(np.diff(row["side"], prepend=row["side"][0])), np.ones(9), "same") == 0.0
    # Of first order in the time step: half of it times the largest slope of the force.
    assert np.sqrt(np.mean(rest[away] ** 2)) < 2e-3 * m.level


def test_elements_slide_after_twice_their_stretch_from_a_turning_point() -> None:
    path = np.concatenate([np.linspace(0.0, 2e-3, 200), np.linspace(2e-3, -1e-3, 300)])
    force = iwan(path, 1e-3)
    assert force[199] == pytest.approx(1.0) and force[-1] == pytest.approx(-1.0)
    # On the way back each element has turned by its own stretch when the curve passes through zero.
    assert -1e-3 < path[200:][np.argmin(np.abs(force[200:]))] - 2e-3 < -1e-4


@pytest.mark.slow
def test_chain_of_three_is_established_at_once(tmp_path: Path) -> None:
    make_cases(tmp_path, 1, 14, only=8)
    key = json.loads((tmp_path / "key.json").read_text("utf-8"))["case008"]
    assert key["hidden"] == ["viscous", "cable_spring", "load_dependent_friction"]
    found = diagnose(tmp_path / "case008")
    assert {entry.name for entry in found.ledger.established} == set(key["hidden"])
