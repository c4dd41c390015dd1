"""T-optimal design: distance of models, and motions within limits; minimum detectable sizes of effects."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from scipy.optimize import nnls
from scipy.signal import lfilter

from sim.effects.catalogue import find
from sysid.diagnose import diagnose
from sysid.diagnosis.constants import LEAST_GAIN
from sysid.estimation.misfit import residual_weights
from sysid.estimation.reference_fit import fit_stated_model
from sysid.experiment_design.detectability import MinimumDetectableEffect, minimum_detectable_effects, minimum_sizes
from sysid.experiment_design.t_optimal_design import (
    Envelope,
    Motion,
    _distance_after_refit,
    axis_motions,
    columns_of,
    discrimination_distance,
    motion_record,
    motions_for,
    tip_motions,
)
from sysid.prediction.model import Model, predict, with_effect
from sysid.prediction.problem import Problem
from tests.sysid.slide import NOISE, SIGN, STEP, VELOCITY, slide

ENVELOPE = Envelope(-0.01, 0.02, 0.05, 2.0, 2e-6, load=(10.0, 30.0))


@pytest.fixture(scope="module")
def problem(tmp_path_factory: pytest.TempPathFactory) -> Problem:
    return slide(tmp_path_factory.mktemp("rig"), 1.5 * SIGN + 8.0 * VELOCITY, "coulomb")


def model(problem: Problem, **values: float) -> Model:
    """Coulomb friction of 1.5 N with one more effect at the values given (`effect__parameter`)."""
    found = with_effect(problem.start, find(next(iter(values)).partition("__")[0]), problem.scales)
    at = {"coulomb.force": 1.5, **{key.replace("__", "."): value for key, value in values.items()}}
    return found.at({**found.values, **at})


def motion(problem: Problem, name: str) -> Motion:
    return next(m for m in motions_for(problem) if m.name == name)


def apart(problem: Problem, one: Model, other: Model, name: str) -> float:
    record, count = motion_record(problem, motion(problem, name))
    return count * discrimination_distance(one, other, [record], residual_weights(one, [record], thin=False))


def test_distances_of_equivalent_models_are_zero(problem: Problem) -> None:
    one, other = model(problem, viscous__coefficient=8.0), model(problem, viscous__coefficient=2.0)
    assert apart(problem, one, other, "triangle sweeps") < 0.5
    bias, asymmetry = model(problem, constant_bias__force=0.1), model(problem, direction_asymmetry__coulomb=0.06)
    for m in motions_for(problem):
        assert apart(problem, bias, asymmetry, m.name) < 0.1, m.name
    assert apart(problem, bias, model(problem, viscous__coefficient=1.0), "triangle sweeps") > 20.0


def test_drag_laws_need_more_than_one_speed_and_motions_have_units(problem: Problem, tmp_path: Path) -> None:
    linear, square = model(problem, viscous__coefficient=8.0), model(problem, quadratic_drag__coefficient=200.0)
    sweeps, one_speed = (apart(problem, linear, square, n) for n in ("triangle sweeps", "slow full travel"))
    assert sweeps > 20.0 and one_speed < 0.2 * sweeps
    table = columns_of(problem, motion(problem, "multisine"))
    assert list(table) == ["time [s]", "position [m]", "velocity [m/s]"]
    x, v = table["position [m]"], table["velocity [m/s]"]
    assert np.allclose(np.cumsum(v)[-2] * (table["time [s]"][1]), x[-1] - x[0], atol=2e-3 * np.ptp(x))


def test_distance_of_linear_models_is_the_orthogonal_part(problem: Problem) -> None:
    linear, square = model(problem, viscous__coefficient=8.0), model(problem, quadratic_drag__coefficient=200.0)
    m = motion(problem, "triangle sweeps")
    record, _ = motion_record(problem, m)
    # Deviations without the allowance for timing, so that algebra on plain columns applies.
    record = replace(record, timing_uncertainty=0.0)
    ok = record.valid["friction_force"]
    v = np.gradient(m.signals["position"], m.step)
    coulomb = predict(record, problem.start.effects, {**problem.start.values, "coulomb.force": 1.0})["friction_force"]
    truth = [1.5 * coulomb + 8.0 * v, 1.5 * coulomb + 200.0 * v * np.abs(v)]
    rivals = [np.column_stack([coulomb, v * np.abs(v)]), np.column_stack([coulomb, v])]
    left = []
    for y, columns in zip(truth, rivals, strict=True):
        best, *_ = np.linalg.lstsq(columns[ok], y[ok], rcond=None)
        left.append(np.linalg.norm((y - columns @ best)[ok]) / NOISE)
    found = discrimination_distance(linear, square, [record], residual_weights(linear, [record], thin=False))
    assert found == pytest.approx(min(left), rel=0.02)


@pytest.mark.parametrize("name", [m.name for m in axis_motions(replace(ENVELOPE, load=None), 1e-3)])
def test_the_rival_is_refitted_to_its_least_distance(problem: Problem, name: str) -> None:
    """A Stribeck curve against strengthening at rest by Kato's law, refitted here by linear least squares on a grid of
    memory lengths and rates, with an age of its own. Twelve steps from the present values told 34.8 standard deviations
    for a motion at one speed, where a Coulomb force explains all."""
    base = with_effect(problem.start, find("viscous"), problem.scales)
    stribeck, kato = (with_effect(base, find(n), problem.scales) for n in ("stribeck", "dwell_strengthening:kato"))
    values = {"coulomb.force": 2.0, "viscous.coefficient": 20.2}
    truth = stribeck.at({**stribeck.values, **values, "stribeck.force": 0.5, "stribeck.velocity": 2e-3})
    rival = kato.at({**kato.values, **values, "dwell_strengthening:kato.force": 0.95})
    m = motion(problem, name)
    record, count = motion_record(problem, m)
    record = replace(record, timing_uncertainty=0.0)
    weights = residual_weights(truth, [record], thin=False)
    found = count * _distance_after_refit(truth, rival, [record], weights)
    x, ok = m.signals["position"], record.valid["friction_force"]
    v, side = record.axis.velocity, record.axis.direction
    y = predict(record, truth.effects, truth.values)["friction_force"]
    rate = next(u for u in kato.unknowns if u.key.endswith("rate"))
    length = next(u for u in kato.unknowns if u.key.endswith("memory_length"))
    least = np.inf
    for memory in np.geomspace(length.low, length.high, 40):
        age, way = np.zeros(x.size), np.abs(np.diff(x)) / memory
        for i, w in enumerate(way):
            age[i + 1] = age[i] * np.exp(-w) + m.step * (-np.expm1(-w) / w if w > 1e-9 else 1.0)
        for gamma in np.geomspace(rate.low, rate.high, 9):
            columns = np.column_stack([side, v, (1.0 - np.exp(-gamma * age**0.65)) * side])
            least = min(least, nnls(columns[ok], y[ok])[1])
    assert found == pytest.approx(count * least / NOISE, rel=0.2, abs=0.5)


def test_distance_does_not_depend_on_the_sampling_step(problem: Problem) -> None:
    one, other = model(problem, viscous__coefficient=8.0), model(problem, quadratic_drag__coefficient=200.0)
    motions = axis_motions(Envelope(-0.005, 0.005, 0.03, 1.0, 1e-6), 1e-3, most=8000)
    fine = next(m for m in motions if m.name == "multisine")
    coarse = Motion(fine.name, fine.reason, {"position": fine.signals["position"][::3]}, 3 * fine.step)
    found = []
    for m in (fine, coarse):
        record, count = motion_record(problem, m)
        found.append(count * discrimination_distance(one, other, [record], residual_weights(one, [record], thin=False)))
    # Counted by samples, the finer one would seem 1.7 times as telling.
    assert found[0] == pytest.approx(found[1], rel=0.15)


@pytest.mark.parametrize("m", axis_motions(ENVELOPE, 1e-3), ids=lambda m: m.name)
def test_motions_stay_within_the_envelope(m: Motion) -> None:
    x = m.signals["position"]
    assert np.isfinite(x).all() and ENVELOPE.low - 1e-9 <= x.min() and x.max() <= ENVELOPE.high + 1e-9
    assert np.max(np.abs(np.gradient(x, m.step))) <= 1.02 * ENVELOPE.speed and m.seconds <= 45.0
    load = m.signals.get("normal_load")
    assert load is None or (load.min() >= 10.0 - 1e-9 and load.max() <= 30.0 + 1e-9)


def test_last_motion_fills_positions_and_speeds() -> None:
    m = axis_motions(ENVELOPE, 1e-3)[-1]
    x = m.signals["position"]
    v = np.abs(np.gradient(x, m.step))
    places = np.histogram(x, bins=8, range=(ENVELOPE.low, ENVELOPE.high))[0]
    speeds = np.histogram(np.log10(np.maximum(v, 1e-9) / ENVELOPE.speed), bins=4, range=(-2.0, 0.0))[0]
    assert np.count_nonzero(places) >= 7
    assert np.all(speeds > 0)
    assert np.mean(v < 1e-9) > 0.01


@pytest.mark.parametrize("pistons", [2, 3])
def test_voltages_stay_within_the_envelope(pistons: int) -> None:
    for m in tip_motions([0.0] * pistons, [100.0] * pistons, 1e-3):
        assert sorted(m.signals) == [f"voltage_{k + 1}" for k in range(pistons)]
        for u in m.signals.values():
            assert u.min() >= 0.0 and u.max() <= 100.0


def bare(folder: Path, extra: np.ndarray | float = 0.0, noise: float = NOISE) -> Problem:
    """Coulomb friction and something else, the model knowing the first."""
    return slide(folder, 1.5 * SIGN + extra, "coulomb", held_out=True, noise=noise)


def sizes(problem: Problem, *names: str) -> dict[str, MinimumDetectableEffect]:
    effects = [find(n) for n in names]
    fitted = fit_stated_model(problem).fitted
    return {one.effect: one for one in minimum_sizes(fitted, effects, problem.fit_records, problem.scales)}


def test_detectable_sizes_of_effects_with_and_without_amplitude(tmp_path: Path) -> None:
    problem = bare(tmp_path)
    found = sizes(problem, "constant_bias", "viscous")
    sign = SIGN[1:]
    for effect, column in (("constant_bias", np.ones(sign.size)), ("viscous", VELOCITY[1:])):
        free = column - sign * (sign @ column) / (sign @ sign)
        wanted = NOISE * np.sqrt(LEAST_GAIN * sign.size / (free @ free))
        # The deviations allow for the time of a turn within a step, which plain algebra does not.
        assert found[effect].value == pytest.approx(wanted, rel=0.1)
    smallest = sizes(bare(tmp_path / "without"), "sensor_lag")["sensor_lag"].value
    assert smallest is not None and 1e-5 < smallest < 5e-3
    decay = np.exp(-STEP / (3.0 * smallest))
    lagged = np.asarray(lfilter([1.0 - decay], [1.0, -decay], 1.5 * SIGN))
    found = diagnose(bare(tmp_path / "with", lagged - 1.5 * SIGN))
    assert found.effect in ("sensor_lag", "sensor_delay")
    effects = ("cable_spring", "magnetic_cogging", "presliding")
    quiet = sizes(bare(tmp_path / "a"), *effects)
    loud = sizes(bare(tmp_path / "b", noise=10.0 * NOISE), *effects)
    for name, one in quiet.items():
        assert one.value is not None
        other = loud[name].value
        assert other is None or other > 2.0 * one.value, name
    problem = bare(tmp_path, noise=300.0 * NOISE)
    assert sizes(problem, "position_dependent_friction")["position_dependent_friction"].value is None
    found = diagnose(bare(tmp_path, 3.0 * VELOCITY))
    assert found.effect == "viscous"
    told = {one.effect for one in minimum_detectable_effects(found)}
    assert "viscous" not in told and "coulomb" not in told
    assert {"stribeck", "presliding", "constant_bias", "sensor_lag", "sensor_drift"} <= told


@pytest.mark.parametrize("times,verdict", [(1.7, "missing-effect"), (0.4, "adequate")])
def test_diagnosis_finds_effects_above_that_size_and_none_below(tmp_path: Path, times: float, verdict: str) -> None:
    smallest = sizes(bare(tmp_path / "without"), "viscous")["viscous"].value
    assert smallest is not None
    found = diagnose(bare(tmp_path / "with", times * smallest * VELOCITY))
    assert found.verdict == verdict
    # At this size a quadratic drag may be equivalent.
    assert ("viscous" in (found.effect, *found.indistinguishable)) == (verdict == "missing-effect")
