"""Misfit: loss, scored samples, weights, blocks of time; systematic errors of filtering and channel skew."""

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from sysid.estimation.covariance import CHANNEL_SKEW, intervals, systematic_errors
from sysid.estimation.fit import fit_model
from sysid.estimation.misfit import (
    LOSS_CORNER,
    ResidualWeights,
    blocks,
    huber_square,
    misfit,
    residual_std,
    residual_weights,
    weighted_residual,
)
from sysid.estimation.reference_fit import fit_stated_model
from sysid.prediction.force_balance.record import ForceBalanceRecord
from sysid.prediction.model import Model, predict
from sysid.prediction.prepared_record import PreparedRecord
from sysid.prediction.problem import Problem, load_problem
from sysid.signals import TRIM_FACTOR, trimmed_rms
from tests.experiments import write_rig
from tests.sysid.slide import NOISE, SIGN, TIME, VELOCITY, slide


def test_huber_loss_is_quadratic_up_to_the_corner_and_linear_beyond() -> None:
    x = np.array([0.0, 1.0, -LOSS_CORNER, LOSS_CORNER + 1.0, -LOSS_CORNER - 2.0, 1e200])
    loss = huber_square(x)
    assert loss[:3] == pytest.approx([0.0, 1.0, LOSS_CORNER**2])
    slope = 2.0 * LOSS_CORNER
    assert loss[3] - loss[2] == pytest.approx(slope)
    assert loss[4] - loss[3] == pytest.approx(slope)
    assert np.isfinite(loss[5])
    # The slope does not jump at the corner.
    near = huber_square(np.array([LOSS_CORNER - 1e-6, LOSS_CORNER, LOSS_CORNER + 1e-6]))
    assert np.diff(near) == pytest.approx([slope * 1e-6] * 2, rel=1e-3)


@pytest.fixture
def problem(tmp_path: Path) -> Problem:
    return slide(tmp_path, 1.5 * SIGN + 20.0 * VELOCITY, "coulomb", "viscous")


def right(problem: Problem) -> dict[str, float]:
    return {**problem.start.values, "coulomb.force": 1.5, "viscous.coefficient": 20.0}


def test_a_true_model_leaves_the_noise_and_gaps_are_not_scored(problem: Problem) -> None:
    found = misfit(problem.start.at(right(problem)), problem.fit_records)["friction_force"]
    assert found.over_noise == pytest.approx(1.0, abs=0.05)
    # A constant of 5 deviations on top.
    other = {**right(problem), "coulomb.force": 1.5 + 5.0 * NOISE}
    wrong = misfit(problem.start.at(other), problem.fit_records)["friction_force"]
    # The best 97 % of a constant are nearly all of it: scaled as noise is, it counts for a little more.
    assert wrong.over_noise == pytest.approx(np.hypot(1.0, 5.0) / TRIM_FACTOR, rel=0.03)
    measured = problem.fit_records[0].measured["friction_force"][problem.fit_records[0].valid["friction_force"]]
    spread = np.sqrt(np.mean((measured - measured.mean()) ** 2))
    assert wrong.fit_percent == pytest.approx(100.0 * (1.0 - wrong.rms / spread), abs=1e-6)
    assert wrong.size == measured.size
    record = problem.fit_records[0]
    assert not record.valid["friction_force"][0]
    spoilt = record.measured["friction_force"].copy()
    spoilt[0] = 1e9
    with_gaps = replace(record, measured={"friction_force": spoilt})
    assert misfit(problem.start, [with_gaps]) == misfit(problem.start, [record])


def test_deviations_and_blocks_of_weighted_residuals(problem: Problem) -> None:
    record = problem.fit_records[0]
    assert isinstance(record, ForceBalanceRecord)
    model = problem.start.at(right(problem))
    predicted = predict(record, model.effects, model.values)
    deviation = residual_std(model, record, "friction_force", predicted)
    turns = np.abs(np.diff(predicted["friction_force"], prepend=predicted["friction_force"][0])) > 1.0
    assert deviation[turns].min() > 20.0 * NOISE
    assert np.median(deviation) == pytest.approx(NOISE, rel=0.1)
    without = residual_std(model, replace(record, timing_uncertainty=0.0), "friction_force", predicted)
    assert without == pytest.approx(NOISE, rel=0.1)
    weights = residual_weights(model, problem.fit_records)
    residual = weighted_residual(model, problem.fit_records, weights)
    assert trimmed_rms(residual) == pytest.approx(1.0, abs=0.05)
    moved = weighted_residual(model, problem.fit_records, weights, {**model.values, "coulomb.force": 1.6})
    pick = weights.samples[0]["friction_force"]
    change = (residual - moved) * weights.std[0]["friction_force"][pick]
    assert np.median(np.abs(change)) == pytest.approx(0.1)
    # The rows before the first reversal are scored too, so that no block is empty.
    record = replace(record, valid={channel: np.ones(record.size, dtype=bool) for channel in record.valid})
    weights = residual_weights(problem.start, [record, record])
    numbers = blocks([record, record], weights, 10)
    half = numbers.size // 2
    assert set(numbers[:half]) == set(range(10))
    assert set(numbers[half:]) == set(range(10, 20))
    assert np.all(np.diff(numbers) >= 0)
    edges = TIME[: record.size][weights.samples[0]["friction_force"]][np.flatnonzero(np.diff(numbers[:half]))]
    assert np.diff(edges) == pytest.approx(0.1 * record.size * record.step, abs=2 * record.step)


STEP = 1e-3
TIMES = np.arange(4000) * STEP
PITCH, MASS = 2e-3, 1.2
POSITION = 8e-3 * np.sin(2 * np.pi * 0.9 * TIMES) + 3e-3 * np.sin(2 * np.pi * 2.3 * TIMES)
SPEED = 2 * np.pi * (7.2e-3 * np.cos(2 * np.pi * 0.9 * TIMES) + 6.9e-3 * np.cos(2 * np.pi * 2.3 * TIMES))
ACCELERATION = -6.48e-3 * np.sin(2 * np.pi * 0.9 * TIMES) - 15.87e-3 * np.sin(2 * np.pi * 2.3 * TIMES)
ACCELERATION *= (2 * np.pi) ** 2


def driven(folder: Path, amplitude: float, *effects: str, noise: float = 1e-6) -> Problem:
    """A mass without friction in a field of teeth, driven smoothly; the drive is logged as a line from row to row."""
    rng = np.random.default_rng(2)
    force = MASS * ACCELERATION + 20.0 * SPEED + amplitude * np.sin(2 * np.pi * POSITION / PITCH)
    position = POSITION + rng.normal(0, noise, TIMES.size)
    log = {"time": TIMES, "position": position, "drive_force": force}
    rig, known = {"kind": "force-drive", "input_hold": "linear"}, {"mass": f"{MASS} kg"}
    stated = {"position": noise, "drive_force": 0.01}
    return load_problem(write_rig(folder, rig, {"log": log}, effects, known=known, noise=stated))


def test_motion_filtered_half_as_much_is_closer_to_the_truth_and_noisier(tmp_path: Path) -> None:
    record = driven(tmp_path, 0.5, "viscous").fit_records[0]
    assert isinstance(record, ForceBalanceRecord)
    assert record.half_width_variant is not None
    finer, rest = record.half_width_variant()
    inside = slice(200, -200)
    residues = [axis.position[inside] - POSITION[: record.size][inside] for axis in (record.axis, finer)]
    jumps = [float(np.std(np.diff(r))) for r in residues]
    assert jumps[1] > 1.2 * jumps[0]
    # What one filter does less, the other does more: the whole is the same.
    assert record.full_filter is not None
    assert rest.width > record.complementary_filter.width
    twice = rest.width**2 - record.complementary_filter.width**2
    assert twice == pytest.approx(0.75 * (0.4 * record.full_filter.width) ** 2, rel=1e-6)


def test_intervals_of_pitches_and_lags_include_errors_of_filter_and_skew(tmp_path: Path) -> None:
    # The position is noisy enough for a filter that the teeth, at fifty a second and more, begin to feel.
    problem = driven(tmp_path, 0.5, "viscous", "magnetic_cogging")
    found = fit_stated_model(problem).fitted
    told = intervals(found, problem.fit_records).by_key
    amplitude = told["magnetic_cogging.amplitude"]
    assert amplitude.value < 0.5  # blunted
    assert amplitude.low < 0.5 < amplitude.high
    blunted = systematic_errors(found, problem.fit_records)[-1]
    assert np.linalg.norm(blunted) > 0.0
    assert told["magnetic_cogging.pitch"].low < PITCH < told["magnetic_cogging.pitch"].high
    rng = np.random.default_rng(1)
    friction = 1.5 * np.sign(SPEED) + 20.0 * SPEED
    lagged = np.empty(TIMES.size)
    lagged[0] = friction[0]
    for k in range(1, TIMES.size):
        lagged[k] = lagged[k - 1] + (1.0 - np.exp(-STEP / 4e-3)) * (friction[k] - lagged[k - 1])
    lagged += rng.normal(0, 1e-3, TIMES.size)
    log = {"time": TIMES, "position": POSITION, "velocity": SPEED, "friction_force": lagged}
    effects, noise = ["coulomb", "viscous", "sensor_lag"], {"friction_force": "1 mN"}
    problem = load_problem(write_rig(tmp_path, "velocity-drive", {"log": log}, effects, noise=noise))
    told = intervals(fit_stated_model(problem).fitted, problem.fit_records).by_key
    lag = told["sensor_lag.time_constant"]
    assert lag.std == pytest.approx(CHANNEL_SKEW * STEP, rel=0.3)
    assert told["viscous.coefficient"].std < 1e-3 * told["viscous.coefficient"].value


def test_deviations_of_a_wrong_model_do_not_decide_alone(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A model without the main force may have next to no noise in some rows: they do not determine its values."""
    problem = slide(tmp_path, 1.5 * SIGN + 8.0 * np.sin(2.0 * np.pi * 0.4 * TIME) ** 2, "coulomb", "viscous")
    rows = np.abs(VELOCITY) < 3e-4

    def degenerate(model: Model, records: Sequence[PreparedRecord]) -> ResidualWeights:
        found = residual_weights(model, records)
        if model is problem.start:
            return found
        std = {channel: values.copy() for channel, values in found.std[0].items()}
        std["friction_force"][rows[: std["friction_force"].size]] *= 1e-6
        return replace(found, std=(std,))

    usual = fit_model(problem.start, problem.fit_records)
    monkeypatch.setattr("sysid.estimation.fit.residual_weights", degenerate)
    fitted = fit_model(problem.start, problem.fit_records)
    assert fitted.fit.exact and fitted.fit.values == pytest.approx(usual.fit.values, rel=0.05, abs=1e-6)
