"""Equivalent effects, the order of sensor effects, and several channels one of which no model explains."""

from pathlib import Path

import numpy as np
import pytest

from sim.effects.catalogue import find
from sysid.add import add_effects
from sysid.compare import compare
from sysid.diagnose import diagnose
from sysid.prediction.model import with_effect
from sysid.prediction.problem import build_problem
from tests.sysid.slide import POSITION, SIGN, TIME, VELOCITY, slide
from tests.sysid.tip import GAIN, TIP_NOISE, tip_record, write_tip
from workbench.operations.measurement.statements import diagnosis_statement


def test_orders_of_sensor_effects_and_rivals_of_rigid_friction(tmp_path: Path) -> None:
    problem = slide(tmp_path, 1.5 * SIGN, "coulomb", "sensor_drift")
    grown = with_effect(problem.start, find("sensor_nonlinearity"), problem.scales)
    assert [e.name for e in grown.effects] == ["coulomb", "sensor_nonlinearity", "sensor_drift"]
    force = with_effect(problem.start, find("constant_bias"), problem.scales)
    assert [e.name for e in force.effects] == ["coulomb", "sensor_drift", "constant_bias"]
    listed = build_problem(problem.experiment, problem.records, ["coulomb", "sensor_drift", "sensor_nonlinearity"])
    assert [e.name for e in listed.start.effects] == ["coulomb", "sensor_drift", "sensor_nonlinearity"]
    slide(tmp_path, 1.5 * SIGN + 25.0 * VELOCITY, "viscous", held_out=True)
    found = diagnose(tmp_path)
    assert (found.effect, "presliding" in found.indistinguishable) == ("coulomb", False)
    assert any(trial.public_name == "presliding" for trial in found.trials)


@pytest.mark.slow
def test_nonlinear_and_drifting_sensor_is_found_in_either_order(tmp_path: Path) -> None:
    force = 1.5 * SIGN + 25.0 * VELOCITY
    bent = force + 0.06 * force**2 + 0.05 * force**3
    slide(tmp_path, bent + 0.4 * TIME / TIME[-1], "coulomb", "viscous", held_out=True)
    named = []
    for _ in range(2):
        found = diagnose(tmp_path)
        named.append({found.effect, *found.indistinguishable})
        assert found.effect is not None
        add_effects(tmp_path, [found.effect])
    assert any("sensor_drift" in names for names in named)
    assert any("sensor_nonlinearity" in names for names in named)
    last = diagnose(tmp_path)
    assert last.verdict == "adequate"
    assert max(m.over_noise for m in last.before_validate.values()) < 1.1


# In each run: the cubic spring of tests/recovery/hidden_effect/test_loop.py, also unexplained and located.
@pytest.mark.slow
def test_slightly_nonlinear_spring_is_not_a_linear_one_plus_another_effect(tmp_path: Path) -> None:
    middle = POSITION - POSITION.mean()
    cubic = 0.08 * (middle / np.max(np.abs(middle))) ** 3
    slide(tmp_path, 1.5 * SIGN + 25.0 * VELOCITY + cubic, "coulomb", "viscous", held_out=True)
    found = diagnose(tmp_path)
    assert found.verdict == "unexplained", (found.effect, found.reason)
    assert found.maps[0].coordinate == "position"


def _wave(pitch: float) -> np.ndarray:
    return np.sin(2 * np.pi * POSITION / pitch)


@pytest.mark.slow
def test_waves_of_three_pitches_are_copies_of_one_effect(tmp_path: Path) -> None:
    pitches = (0.67e-3, 1.13e-3, 1.9e-3)
    texture = 0.035 * (_wave(pitches[0]) + _wave(pitches[1])) + 0.08 * _wave(pitches[2])
    found = diagnose(slide(tmp_path / "rig", (1.5 + texture) * SIGN, "coulomb", held_out=True))
    assert (found.verdict, found.effect) == ("missing-effect", "position_dependent_friction")
    established = [entry for entry in found.ledger.entries if entry.state == "established"]
    assert len(established) == 3
    values = established[0].model.fitted.model.values
    fitted = sorted(value for key, value in values.items() if key.endswith(".pitch"))
    assert fitted == pytest.approx(pitches, rel=0.01)
    assert found.unexplained_share < 0.02


JUMP = 100e-9
TIP_TIME = np.arange(3000) * 1e-3


def _play(voltage: np.ndarray, width: float) -> np.ndarray:
    """Output (n,) of a play operator of a half width, V."""
    out, last = np.empty_like(voltage), voltage[0]
    for k, value in enumerate(voltage):
        last = min(max(last, value - width), value + width)
        out[k] = last
    return out


def _experiment(folder: Path, hysteresis: float) -> Path:
    """Two records of a tip on two piezos; its holder jumps in the x direction at random times."""
    records = {}
    for seed, role in enumerate(("fit", "validate")):
        rng = np.random.default_rng(seed)
        phase = rng.uniform(0.0, 6.0, 4)
        waves = np.sin(2 * np.pi * np.outer([3.1, 0.9, 2.3, 1.7], TIP_TIME) + phase[:, None])
        drives = 28.0 * waves[::2] + 18.0 * waves[1::2]
        moved = [GAIN * (u + hysteresis * (_play(u, 8.0) + _play(u, 20.0) - 2.0 * u)) for u in drives]
        jumps = JUMP * np.sign(np.sin(np.cumsum(rng.exponential(0.02, TIP_TIME.size)) * 2.0))
        noise = TIP_NOISE * rng.normal(size=(2, TIP_TIME.size))
        noise[0] += jumps
        records[role] = tip_record(TIP_TIME, drives, moved, noise)
    return write_tip(folder, records)


def test_a_channel_that_nothing_explains_leaves_values_and_effects_to_the_other(tmp_path: Path) -> None:
    found = diagnose(_experiment(tmp_path, 0.03))
    assert [(e.name, e.reason.endswith("on tip y")) for e in found.ledger.established] == [("piezo_hysteresis", True)]
    after = found.ledger.model.after_validate
    assert after["tip_y"].over_noise < min(1.5, 0.25 * found.before_validate["tip_y"].over_noise)
    assert after["tip_x"].over_noise > 10.0
    statement = diagnosis_statement(found)
    assert "the error of tip y on the held-out records falls" in statement
    assert "That of tip x," in statement
    found = compare(_experiment(tmp_path, 0.0))
    fitted = found.base.fitted
    assert fitted.model.values["rig.gain"] == pytest.approx(GAIN, rel=3e-4)
    at = fitted.fit.keys.index("rig.gain")
    curvature = float(fitted.fit.weights @ fitted.fit.jacobian[:, at] ** 2)
    # The amplitude of the voltages is 24 V: of one channel alone 3000 rows of 2 nm give 2 nm / (24 V sqrt(1500)).
    assert curvature**-0.5 == pytest.approx(TIP_NOISE / (24.0 * np.sqrt(1500.0)), rel=0.5)
