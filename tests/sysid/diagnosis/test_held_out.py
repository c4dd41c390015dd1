"""Held-out loss and gain: size on white and on autocorrelated noise, refit of amplitudes, offsets, independence."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from sim.effects.catalogue import find
from sysid.diagnose import diagnose
from sysid.diagnosis.candidate import Reference
from sysid.diagnosis.held_out import HeldOut, evenness, held_out
from sysid.estimation.misfit import misfit, weighted_residual
from sysid.estimation.reference_fit import fit_stated_model
from sysid.prediction.force_balance.record import INDEPENDENT_WIDTHS, ForceBalanceRecord
from sysid.prediction.model import with_effect
from sysid.prediction.problem import Problem, load_problem
from sysid.signals import GaussianFilter
from tests.experiments import change_column, write_rig
from tests.sysid.autoregression import BLOCK, LENGTH
from tests.sysid.autoregression import noise_of_blocks as _noise
from tests.sysid.slide import NOISE, POSITION, SIGN, TIME, VELOCITY, slide
from tests.sysid.tip import tip_record, write_tip


@pytest.mark.parametrize("correlation", [0.0, 0.9, 0.98])
def test_stationary_noise_of_any_level_is_even(correlation: float) -> None:
    found = [evenness(2.0 * _noise(seed, correlation), BLOCK) for seed in range(50)]
    # A block of 400 samples has 400 (1 - rho^2)/(1 + rho^2) = 8 independent squares at rho = 0.98, of which the median
    # is 0.92 of the mean (Wilson and Hilferty: (1 - 2/(9 k))^3 for k degrees of freedom).
    independent = LENGTH * (1.0 - correlation**2) / (1.0 + correlation**2)
    assert np.mean(found) == pytest.approx((1.0 - 2.0 / (9.0 * independent)) ** 3, abs=0.06)
    assert min(found) > 0.6


def test_noise_with_outliers_is_even_and_noise_with_bursts_is_not() -> None:
    noise, random = _noise(0), np.random.default_rng(1)
    outliers = noise.copy()
    outliers[random.choice(BLOCK.size, 30, replace=False)] = 100.0
    assert HeldOut(outliers, BLOCK).loss > 3.0
    assert evenness(outliers, BLOCK) > 0.9
    assert evenness(np.where(BLOCK % 4 == 0, 4.0, 1.0) * noise, BLOCK) == pytest.approx(
        1.0 / (0.75 + 0.25 * 16), abs=0.03
    )


def test_loss_of_white_noise_is_one_linear_beyond_the_corner_and_infinite_without_a_prediction() -> None:
    rng = np.random.default_rng(0)
    found = HeldOut(rng.normal(size=100_000), np.zeros(100_000, dtype=int))
    # Standard error sqrt(2/n) = 0.0045; beyond the corner of 4 deviations the Huber square loses less than 1e-4.
    assert found.loss == pytest.approx(1.0, abs=0.015)
    block = np.zeros(2, dtype=int)
    assert HeldOut(np.array([3.0, -10.0]), block).loss == pytest.approx((9.0 + 16.0 + 2.0 * 4.0 * 6.0) / 2.0)
    assert HeldOut(np.array([1.0, np.nan]), block).loss == np.inf


def _shifted(folder: Path, rows: int, shift: float) -> Problem:
    """Coulomb friction that is larger by `shift` N in the held-out record; the fit record has `rows` rows."""
    slide(folder, 1.5 * SIGN, "coulomb", held_out=True)
    for name, change, kept in (("fit", 0.0, rows), ("validate", shift, TIME.size)):
        change_column(folder / f"{name}.csv", 3, lambda force, change=change: force + change * SIGN, kept)
    return load_problem(folder)


@pytest.mark.parametrize("rows", [100, 2500])
def test_amplitude_is_estimated_again_with_the_information_of_the_fit(tmp_path: Path, rows: int) -> None:
    """Of a shift s of the level the part s A/(A + B) is left, with A and B the information of both sets of records."""
    shift = NOISE
    problem = _shifted(tmp_path, rows, shift)
    base = fit_stated_model(problem)
    sign = np.sign(VELOCITY[base.weights.samples[0]["friction_force"]])
    plain = weighted_residual(base.fitted.model, problem.validate_records, base.weights)
    assert np.mean(plain * sign) == pytest.approx(shift / NOISE, abs=0.25)
    found = held_out(base.fitted, problem.validate_records, base.weights)
    # The residual that the shift enlarges is not a measure of the noise: the record counts by its own scale.
    scale = 1.4826 * float(np.median(np.abs(plain)))
    of_fit, of_held_out = rows - 1.0, sign.size / scale**2
    left = np.mean(plain * sign) * of_fit / (of_fit + of_held_out)
    assert np.mean(found.residual * sign) == pytest.approx(left, abs=0.1 * shift / NOISE)
    assert found.loss < float(np.mean(plain**2))


def test_a_refit_of_held_out_records_leaves_true_models_and_bounds(tmp_path: Path) -> None:
    problem = _shifted(tmp_path, 2500, 0.0)
    base = fit_stated_model(problem)
    plain = weighted_residual(base.fitted.model, problem.validate_records, base.weights)
    found = held_out(base.fitted, problem.validate_records, base.weights)
    assert found.loss == pytest.approx(float(np.mean(plain**2)), rel=5e-3)
    assert found.loss == pytest.approx(1.0, abs=0.1)
    problem = _shifted(tmp_path, 100, 10.0 * NOISE)
    base = fit_stated_model(problem)
    key = "coulomb.force"
    assert key in base.fitted.fit.keys
    fixed = replace(base.fitted, fit=replace(base.fitted.fit, at_bound=(key,)))
    plain = weighted_residual(base.fitted.model, problem.validate_records, base.weights)
    assert np.array_equal(held_out(fixed, problem.validate_records, base.weights).residual, plain)
    assert _reference(tmp_path, 0.0, 1.02 * GAIN).held_out.loss > 10.0


def _written(folder: Path, mirror: float, later: float, unit: str) -> Problem:
    """One motion with Coulomb friction, drag and a cable that the model lacks: mirrored, later, or in another unit."""
    scale = {"m": 1.0, "mm": 1e3}[unit]
    force = 1.5 * SIGN + 20.0 * VELOCITY + 5.0 * POSITION
    records = {}
    for seed, name in enumerate(("fit", "validate")):
        noise = NOISE * np.random.default_rng(seed).normal(size=TIME.size)
        columns = {"time": TIME + later, f"position [{unit}]": mirror * scale * POSITION}
        columns[f"velocity [{unit}/s]"] = mirror * scale * VELOCITY
        records[name] = columns | {"friction_force": mirror * (force + noise)}
    stated = {"friction_force": NOISE}
    return load_problem(write_rig(folder, "velocity-drive", records, ["coulomb", "viscous"], noise=stated))


@pytest.mark.parametrize("mirror,later,unit", [(-1.0, 0.0, "m"), (1.0, 100.0, "m"), (1.0, 0.0, "mm")])
def test_loss_does_not_depend_on_direction_start_time_or_unit(tmp_path, mirror: float, later: float, unit: str) -> None:
    losses = []
    for name, arguments in (("one", (1.0, 0.0, "m")), ("other", (mirror, later, unit))):
        problem = _written(tmp_path / name, *arguments)
        base = fit_stated_model(problem)
        losses.append(held_out(base.fitted, problem.validate_records, base.weights).loss)
    assert losses[0] > 1.5
    assert losses[1] == pytest.approx(losses[0], rel=1e-6)


def test_refit_does_not_depend_on_the_order_and_scale_of_the_unknowns(tmp_path: Path) -> None:
    problem = _written(tmp_path / "rig", 1.0, 0.0, "m")
    base = fit_stated_model(problem)
    model = base.fitted.model
    turned = replace(model, unknowns=tuple(replace(u, size=7.0 * u.size) for u in reversed(model.unknowns)))
    one, other = (
        held_out(replace(base.fitted, model=m), problem.validate_records, base.weights) for m in (model, turned)
    )
    assert np.allclose(one.residual, other.residual, atol=1e-5)


def _driven(folder: Path) -> Problem:
    """A driven mass of 2 kg with viscous drag, whose position is so noisy that the noise of its acceleration is as
    large as that of the force."""
    random = np.random.default_rng(3)
    time, records = np.arange(0.0, 12.0, 1e-3), {}
    for name, phase in (("fit", 0.0), ("validate", 1.1)):
        waves = [(4e-3, 2.0, phase), (1e-3, 7.0, 2.0 * phase)]
        position = sum(a * np.sin(2.0 * np.pi * f * time + p) for a, f, p in waves)
        # The force is held until the next row.
        held = time + 0.5e-3
        velocity = sum(2.0 * np.pi * f * a * np.cos(2.0 * np.pi * f * held + p) for a, f, p in waves)
        inertia = sum(-((2.0 * np.pi * f) ** 2) * a * np.sin(2.0 * np.pi * f * held + p) for a, f, p in waves)
        force = 2.0 * inertia + 8.0 * velocity + 0.02 * random.normal(size=time.size)
        noisy = position + 2e-6 * random.normal(size=time.size)
        records[name] = {"time": time, "position": noisy, "drive_force": force}
    noise = {"drive_force": "0.02 N", "position": "2 um"}
    return load_problem(write_rig(folder, "force-drive", records, ["viscous"], known={"mass": "2 kg"}, noise=noise))


def test_an_effect_that_attenuates_the_noise_of_the_acceleration_gains_nothing(tmp_path: Path) -> None:
    problem = _driven(tmp_path)
    base = fit_stated_model(problem)
    (record,) = problem.fit_records
    assert isinstance(record, ForceBalanceRecord) and record.full_filter is not None
    # A heavily damped mode within the band: part of the mass does not follow the noise.
    values = {"frequency": 0.03 / record.full_filter.width, "damping": 0.35, "mass_ratio": 0.5}
    mode = find("flexible_mode")
    model = with_effect(base.fitted.model, mode, problem.scales, {f"{mode.name}.{k}": v for k, v in values.items()})
    damped = replace(base.fitted, model=replace(model, unknowns=()))
    attenuated = held_out(damped, problem.validate_records, base.weights)
    corrected = held_out(damped, problem.validate_records, base.weights, base.fitted.model)
    # Noise alone, drawn and taken through the filter and the mode.
    random = np.random.default_rng(0)
    shaken = record.full_filter(2e-6 * random.normal(size=record.size), 2)
    assert mode.signal is not None
    ridden = mode.signal(shaken, record.step, mode.values(**values))
    force = np.std(record.full_filter(0.02 * random.normal(size=record.size)))
    before, after = (np.hypot(force, 2.0 * np.std(a)) for a in (shaken, shaken + 0.5 * (ridden - shaken)))
    assert after < 0.9 * before
    assert corrected.residual == pytest.approx(before / after * attenuated.residual, rel=0.05)
    assert misfit(base.fitted.model, problem.validate_records)["drive_force"].over_noise == pytest.approx(1.0, abs=0.03)
    assert diagnose(problem).verdict == "adequate"


def test_a_curve_of_the_smoothed_acceleration_does_not_explain_its_noise() -> None:
    size, width = 200_000, 3.0
    noise = np.random.default_rng(1).normal(size=size)
    balance = GaussianFilter(width, 1.0, size)(noise, 2)
    coordinate = GaussianFilter(INDEPENDENT_WIDTHS * width, 1.0, size)(balance)
    wide = np.hypot(1.0, INDEPENDENT_WIDTHS)
    expected = (2.0 * wide / (1.0 + wide**2)) ** 2.5
    assert np.corrcoef(balance, coordinate)[0, 1] == pytest.approx(expected, abs=0.01)
    assert 0.5 * expected**2 < 0.012


TIP_NOISE, GAIN = 1e-9, 1e-7


def _reference(folder: Path, offset: float, gain: float = GAIN) -> Reference:
    time, records = np.arange(4000) * 1e-3, {}
    for k, (name, zero, slope) in enumerate((("fit", 0.0, GAIN), ("validate", offset, gain))):
        noise = TIP_NOISE * np.random.default_rng(k).standard_normal((2, time.size))
        drives = 40.0 * np.array([np.sin(7.0 * time + k), np.sin(9.0 * time)])
        records[name] = tip_record(time, drives, slope * drives, zero + noise)
    problem = load_problem(write_tip(folder, records, TIP_NOISE))
    return Reference.of(problem, fit_stated_model(problem))


@pytest.mark.parametrize("offset", [0.0, 100.0 * TIP_NOISE])
def test_another_offset_of_held_out_records_is_no_misfit(tmp_path: Path, offset: float) -> None:
    reference = _reference(tmp_path, offset)
    assert reference.held_out.loss == pytest.approx(1.0, abs=0.05)
    found = misfit(reference.base.fitted.model, reference.problem.validate_records)
    assert [one.over_noise for one in found.values()] == pytest.approx([1.0, 1.0], abs=0.05)
