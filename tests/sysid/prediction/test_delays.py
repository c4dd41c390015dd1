"""Delays between a logged force and a logged motion: no delay lowers the error of a force unrelated to the motion."""

from dataclasses import replace
from functools import cache
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
import pytest

from sim.effects.catalogue import find, library
from sim.effects.effect import Effect
from sysid.diagnose import diagnose
from sysid.diagnosis.candidate import Reference
from sysid.diagnosis.held_out import HeldOut
from sysid.diagnosis.model_search import ModelSearch
from sysid.estimation.covariance import implausible, rig_values_at_bound
from sysid.estimation.fit import FittedModel, fit_model, root_mean_huber
from sysid.estimation.misfit import misfit
from sysid.estimation.reference_fit import fit_stated_model, reference_fit
from sysid.prediction.model import with_effect
from sysid.prediction.problem import Problem, load_problem
from tests.experiments import replace_in, write_rig

DELAYS = ["drive_lag", "drive_delay", "sensor_lag", "sensor_delay"]
STEP = 0.01
RNG = np.random.default_rng(7)


def _write(folder: Path) -> Path:
    """A square-wave torque beside a motion of two incommensurate sines."""
    records = {}
    for name, phase in (("fit", 0.0), ("validate", 1.3)):
        t = np.arange(0.0, 20.0, STEP)
        angle = 0.8 * np.sin(1.95 * t + phase) + 0.5 * np.sin(3.58 * t + 2.0 * phase)
        angle += 1e-4 * RNG.standard_normal(t.size)
        torque = 0.8 * np.sign(np.sin(5.2 * t + 1.0 + 3.0 * phase)) + 0.01 * RNG.standard_normal(t.size)
        records[name] = {"time": t, "drive_force [N*m]": torque, "position [rad]": angle}
    noise = {"drive_force": "0.01 N*m", "position": "1e-4 rad"}
    return write_rig(folder, "force-drive", records, ["coulomb", "viscous"], noise=noise)


@cache
def unrelated() -> tuple[Problem, FittedModel]:
    """A force unrelated to the motion, and the fit of Coulomb and viscous friction."""
    with TemporaryDirectory() as folder:
        problem = load_problem(_write(Path(folder)))
    return problem, fit_model(problem.start, problem.fit_records)


@pytest.mark.parametrize("effect", DELAYS)
def test_no_delay_explains_a_force_unrelated_to_the_motion(effect: str) -> None:
    problem, base = unrelated()
    key = f"{effect}.{find(effect).parameters[0].name}"
    for late in (0.1, 0.3):
        start = with_effect(base.model, find(effect), problem.scales, {key: late})
        grown = fit_model(start, problem.fit_records, base.weights, near=base)
        # At the longest delay, 0.5 s, the square wave resembles the sign of the velocity by chance.
        unchanged = root_mean_huber(grown.fit.residual) > 0.97 * root_mean_huber(base.fit.residual)
        assert unchanged or f"{key} is at its upper bound" in str(implausible(grown, [effect]))


def test_no_delay_is_named_for_an_unrelated_force_and_long_lags_are_implausible() -> None:
    """Protects the whole search from delays that resemble a force by chance; the test above refuses each by itself."""
    problem, _ = unrelated()
    assert diagnose(problem).effect is None
    start = with_effect(problem.start, find("drive_delay"), problem.scales, {"drive_delay.delay": 0.4})
    unknown = next(u for u in start.unknowns if u.key == "drive_delay.delay")
    assert unknown.high == pytest.approx(50 * STEP)
    fitted = fit_model(start, problem.fit_records, iterations=2)
    fitted.fit.at_bound, fitted.fit.values["drive_delay.delay"] = ("drive_delay.delay",), unknown.high
    assert implausible(fitted, ["drive_delay"]) == "drive_delay.delay is at its upper bound, 0.5 s"
    assert implausible(fitted, ["viscous"]) is None


def test_a_mass_that_an_effect_drives_to_its_bound_is_held_at_that_of_the_model_without_it() -> None:
    problem, _ = unrelated()
    alone = fit_model(problem.start.at({"rig.mass": 0.1}), problem.fit_records, iterations=1)
    base = reference_fit(problem, replace(alone, fit=replace(alone.fit, at_bound=())))
    start = with_effect(base.fitted.model, find("cable_spring"), problem.scales)
    fitted = fit_model(start, problem.fit_records, base.fitted.weights)
    low = next(u for u in start.unknowns if u.key == "rig.mass").low
    fit = replace(fitted.fit, at_bound=("rig.mass",))
    at_bound = replace(fitted, model=fitted.model.at({"rig.mass": low}), fit=fit)
    reference = Reference.of(problem, base)
    assert reference.evaluate(at_bound, [find("cable_spring")]).gain.loss < 0.0
    worse = replace(reference, held_out=HeldOut(10.0 * reference.held_out.residual, reference.held_out.block))
    found = worse.evaluate(at_bound, [find("cable_spring")])
    assert found.implausible is None and found.fitted.model.values["rig.mass"] == base.fitted.model.values["rig.mass"]
    assert "rig.mass" not in found.fitted.fit.keys
    assert rig_values_at_bound(at_bound, base.fitted) == ["rig.mass"]
    assert rig_values_at_bound(at_bound, at_bound) == []


@pytest.mark.parametrize("effect", [e for e in library().values() if e.inverse is not None], ids=lambda e: e.name)
def test_the_inverse_of_a_delay_restores_a_smooth_signal(effect: Effect) -> None:
    row = np.arange(600)
    signal = np.sin(2.0 * np.pi * row / 31.0) + 0.5 * np.cos(2.0 * np.pi * row / 20.0)
    for law in (effect, *effect.variants):
        p = law.values()._replace(**{law.parameters[0].name: 2.3 * STEP})
        restored = law.inverse(law.signal(signal, STEP, p), STEP, p)
        # Linear interpolation loses 1/8 of the second difference of the signal at most, once each way.
        lost = 0.25 * ((2.0 * np.pi / 31.0) ** 2 + 0.5 * (2.0 * np.pi / 20.0) ** 2)
        half_a_row = 0.5 * (2.0 * np.pi / 31.0 + 0.5 * 2.0 * np.pi / 20.0) if "of_steps" in law.name else 0.0
        assert restored[60:-60] == pytest.approx(signal[60:-60], abs=lost + half_a_row)


def test_every_fitted_value_stays_within_the_declared_bounds(tmp_path: Path) -> None:
    _write(tmp_path)
    replace_in(tmp_path / "experiment.toml", '"1e-4 rad"', '"1e-13 rad"')
    problem = load_problem(tmp_path)
    model = with_effect(problem.start, find("bristle_damping"), problem.scales)
    declared = {f"{e.name}.{p.name}": p for e in model.effects for p in e.parameters}
    assert "coulomb.stretch" in {u.key for u in model.unknowns}
    for u in model.unknowns:
        if u.key in declared:
            assert declared[u.key].low <= u.low <= u.start <= u.high <= declared[u.key].high


def test_bristles_do_not_follow_a_force_unrelated_to_the_motion(tmp_path: Path) -> None:
    """A ramp. The measured motion shows bristles as long as the travel: they cannot hold a body against it."""
    records = {}
    for phase, role in ((0.4, "fit"), (2.0, "validate")):
        time, random = np.arange(0.0, 20.0, STEP), np.random.default_rng(3)
        position = 0.015 * np.sin(1.95 * time + phase) + 0.009 * np.sin(3.58 * time + 2.0 * phase)
        position += 1e-6 * random.standard_normal(time.size)
        force = 0.6 * time / time[-1] + 0.01 * random.standard_normal(time.size)
        records[role] = {"time": time, "position": position, "drive_force": force}
    stated = {"drive_force": 0.01, "position": 1e-6}
    problem = load_problem(write_rig(tmp_path, "force-drive", records, ["coulomb", "viscous"], noise=stated))
    search = ModelSearch(problem, fit_stated_model(problem), options=[find("presliding")])
    assert search.converged(search.ranked[0]).held_out.loss > 0.9 * search.reference.held_out.loss


def test_a_lag_of_the_drive_is_found_in_spite_of_the_noise_of_the_acceleration(tmp_path: Path) -> None:
    """A controlled axis at 2 kHz in steps of 25 us. The inverse of the lag would amplify the noise seven times."""
    mass, level, drag, late, step, fine = 4.2, 14.0, 50.0, 4e-3, 5e-4, 20
    records = {}
    for seed, role in enumerate(("fit", "validate")):
        random = np.random.default_rng(seed)
        x = v = force = 0.0
        rows = []
        for row, sensors in enumerate(random.standard_normal((4000, 2))):
            time = row * step
            wanted = 0.02 * np.sin(3.0 * time) + 0.008 * np.sin(19.0 * time + seed)
            speed = 0.06 * np.cos(3.0 * time) + 0.152 * np.cos(19.0 * time + seed)
            measured = x + 5e-8 * sensors[0]
            command = 4e3 * (wanted - measured) + 150.0 * (speed - v)
            rows.append((time, measured, command + 0.09 * sensors[1]))
            for _ in range(fine):
                force += step / fine * (command - force) / late
                push = v + step / fine / mass * (force - drag * v)
                v = np.sign(push) * max(abs(push) - step / fine / mass * level, 0.0)
                x += step / fine * v
        records[role] = dict(zip(("time", "position", "drive_force"), np.transpose(rows), strict=True))
    known, noise = {"mass": f"{mass} kg"}, {"drive_force": "0.09 N", "position": "50 nm"}
    effects = ["coulomb", "viscous", "drive_lag"]
    problem = load_problem(write_rig(tmp_path, "force-drive", records, effects, known=known, noise=noise))
    base = fit_stated_model(problem)
    assert base.fitted.model.values["drive_lag.time_constant"] == pytest.approx(late, rel=0.05)
    assert base.fitted.model.values["coulomb.force"] == pytest.approx(level, rel=0.01)
    assert misfit(base.fitted.model, problem.validate_records)["drive_force"].over_noise < 1.15
