"""Systematic errors of filtering and channel skew: they widen the intervals of the values that depend on them only."""

from pathlib import Path

import numpy as np
import pytest

from sysid.estimation.covariance import CHANNEL_SKEW, intervals, systematic_errors
from sysid.estimation.reference_fit import fit_stated_model
from sysid.prediction.force_balance.record import ForceBalanceRecord
from sysid.prediction.problem import Problem, load_problem

STEP = 1e-3
TIME = np.arange(4000) * STEP
PITCH, MASS = 2e-3, 1.2
POSITION = 8e-3 * np.sin(2 * np.pi * 0.9 * TIME) + 3e-3 * np.sin(2 * np.pi * 2.3 * TIME)
VELOCITY = 2 * np.pi * (7.2e-3 * np.cos(2 * np.pi * 0.9 * TIME) + 6.9e-3 * np.cos(2 * np.pi * 2.3 * TIME))
ACCELERATION = -((2 * np.pi) ** 2) * (
    6.48e-3 * np.sin(2 * np.pi * 0.9 * TIME) + 15.87e-3 * np.sin(2 * np.pi * 2.3 * TIME)
)


def driven(folder: Path, amplitude: float, effects: str, noise: float = 1e-6) -> Problem:
    """A mass without friction in a field of teeth, driven smoothly; the drive is logged as a line from row to row."""
    rng = np.random.default_rng(2)
    force = MASS * ACCELERATION + 20.0 * VELOCITY + amplitude * np.sin(2 * np.pi * POSITION / PITCH)
    position = POSITION + rng.normal(0, noise, TIME.size)
    rows = "\n".join(f"{a:.3f},{b:.10g},{c:.10g}" for a, b, c in zip(TIME, position, force, strict=True))
    (folder / "log.csv").write_text(f"time [s],position [m],drive_force [N]\n{rows}\n")
    (folder / "experiment.toml").write_text(
        f'schema = 1\n[rig]\nkind = "force-drive"\ninput_hold = "linear"\n[rig.known]\nmass = "{MASS} kg"\n'
        f'[model]\neffects = [{effects}]\n[[record]]\nfile = "log.csv"\nrole = "fit"\n'
        f'[noise]\nposition = "{noise} m"\ndrive_force = "0.01 N"\n'
    )
    return load_problem(folder)


def test_motion_filtered_half_as_much_is_closer_to_the_truth_and_noisier(tmp_path: Path) -> None:
    record = driven(tmp_path, 0.5, '"viscous"').fit_records[0]
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


def test_interval_of_a_short_pitch_includes_the_error_of_the_filter(tmp_path: Path) -> None:
    # The position is noisy enough for a filter that the teeth, at fifty a second and more, begin to feel.
    problem = driven(tmp_path, 0.5, '"viscous", "magnetic_cogging"')
    found = fit_stated_model(problem).fitted
    told = intervals(found, problem.fit_records).by_key
    amplitude = told["magnetic_cogging.amplitude"]
    assert amplitude.value < 0.5  # blunted
    assert amplitude.low < 0.5 < amplitude.high
    blunted = systematic_errors(found, problem.fit_records)[-1]
    assert np.linalg.norm(blunted) > 0.0
    assert told["magnetic_cogging.pitch"].low < PITCH < told["magnetic_cogging.pitch"].high


def test_interval_of_a_lag_includes_the_channel_skew(tmp_path: Path) -> None:
    rng = np.random.default_rng(1)
    friction = 1.5 * np.sign(VELOCITY) + 20.0 * VELOCITY
    lagged = np.empty(TIME.size)
    lagged[0] = friction[0]
    for k in range(1, TIME.size):
        lagged[k] = lagged[k - 1] + (1.0 - np.exp(-STEP / 4e-3)) * (friction[k] - lagged[k - 1])
    lagged += rng.normal(0, 1e-3, TIME.size)
    rows = zip(TIME, POSITION, VELOCITY, lagged, strict=True)
    text = "\n".join(f"{a:.3f},{b:.8g},{c:.8g},{d:.8g}" for a, b, c, d in rows)
    (tmp_path / "log.csv").write_text(f"time [s],position [m],velocity [m/s],friction_force [N]\n{text}\n")
    (tmp_path / "experiment.toml").write_text(
        'schema = 1\n[rig]\nkind = "velocity-drive"\n[model]\neffects = ["coulomb", "viscous", "sensor_lag"]\n'
        '[[record]]\nfile = "log.csv"\nrole = "fit"\n[noise]\nfriction_force = "1 mN"\n'
    )
    problem = load_problem(tmp_path)
    told = intervals(fit_stated_model(problem).fitted, problem.fit_records).by_key
    lag = told["sensor_lag.time_constant"]
    assert lag.std == pytest.approx(CHANNEL_SKEW * STEP, rel=0.3)
    assert told["viscous.coefficient"].std < 1e-3 * told["viscous.coefficient"].value
