"""Minimum detectable effect size: closed form, and agreement with a diagnosis."""

from pathlib import Path

import numpy as np
import pytest
from scipy.signal import lfilter

from sim.effects.catalogue import find
from sysid.diagnose import diagnose
from sysid.diagnosis.constants import LEAST_GAIN
from sysid.estimation.reference_fit import fit_stated_model
from sysid.experiment_design.detectability import MinimumDetectableEffect, minimum_detectable_effects, minimum_sizes
from sysid.prediction.problem import Problem
from tests.sysid.slide import NOISE, SIGN, STEP, VELOCITY, slide


def bare(folder: Path, extra: np.ndarray | float = 0.0, noise: float = NOISE) -> Problem:
    """Coulomb friction and something else, the model knowing the first."""
    return slide(folder, 1.5 * SIGN + extra, "coulomb", held_out=True, noise=noise)


def sizes(problem: Problem, *names: str) -> dict[str, MinimumDetectableEffect]:
    found = minimum_sizes(
        fit_stated_model(problem).fitted, [find(n) for n in names], problem.fit_records, problem.scales
    )
    return {one.effect: one for one in found}


def test_detectable_size_of_a_linear_effect_agrees_with_the_formula(tmp_path: Path) -> None:
    problem = bare(tmp_path)
    found = sizes(problem, "constant_bias", "viscous")
    sign = SIGN[1:]
    for effect, column in (("constant_bias", np.ones(sign.size)), ("viscous", VELOCITY[1:])):
        free = column - sign * (sign @ column) / (sign @ sign)
        wanted = NOISE * np.sqrt(LEAST_GAIN * sign.size / (free @ free))
        # The deviations allow for the time of a turn within a step, which plain algebra does not.
        assert found[effect].value == pytest.approx(wanted, rel=0.1)


@pytest.mark.parametrize("times,verdict", [(1.7, "missing-effect"), (0.4, "adequate")])
def test_diagnosis_finds_effects_above_that_size_and_none_below(tmp_path: Path, times: float, verdict: str) -> None:
    smallest = sizes(bare(tmp_path / "without"), "viscous")["viscous"].value
    assert smallest is not None
    found = diagnose(bare(tmp_path / "with", times * smallest * VELOCITY))
    assert found.verdict == verdict
    # At this size a quadratic drag may be equivalent.
    assert ("viscous" in (found.effect, *found.indistinguishable)) == (verdict == "missing-effect")


def test_size_of_an_effect_without_amplitude_is_searched(tmp_path: Path) -> None:
    smallest = sizes(bare(tmp_path / "without"), "sensor_lag")["sensor_lag"].value
    assert smallest is not None
    assert 1e-5 < smallest < 5e-3
    decay = np.exp(-STEP / (3.0 * smallest))
    lagged = np.asarray(lfilter([1.0 - decay], [1.0, -decay], 1.5 * SIGN))
    found = diagnose(bare(tmp_path / "with", lagged - 1.5 * SIGN))
    assert found.effect in ("sensor_lag", "sensor_delay")


def test_more_noise_gives_larger_sizes(tmp_path: Path) -> None:
    effects = ("cable_spring", "magnetic_cogging", "presliding")
    quiet = sizes(bare(tmp_path / "a"), *effects)
    loud = sizes(bare(tmp_path / "b", noise=10.0 * NOISE), *effects)
    for name, one in quiet.items():
        assert one.value is not None
        other = loud[name].value
        assert other is None or other > 2.0 * one.value, name


def test_relative_size_beyond_its_bound_is_none(tmp_path: Path) -> None:
    problem = bare(tmp_path, noise=300.0 * NOISE)
    assert sizes(problem, "position_dependent_friction")["position_dependent_friction"].value is None


def test_sizes_are_reported_for_every_effect_but_the_named_one(tmp_path: Path) -> None:
    found = diagnose(bare(tmp_path, 3.0 * VELOCITY))
    assert found.effect == "viscous"
    told = {one.effect for one in minimum_detectable_effects(found)}
    assert "viscous" not in told
    assert "coulomb" not in told
    assert {"stribeck", "presliding", "constant_bias", "sensor_lag", "sensor_drift"} <= told
