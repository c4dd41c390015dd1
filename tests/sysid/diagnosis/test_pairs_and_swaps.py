"""Pairs of missing effects, repeated searches and replacements, on generated records."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from sim.effects.catalogue import find
from sysid.diagnose import diagnose
from sysid.diagnosis.candidate_screening import screen_all
from sysid.diagnosis.pairs import Pair, ReducedModels, add_after_deletion, best_pairs, pairs_on_top
from sysid.diagnosis.swaps import find_swaps
from sysid.diagnosis.ties import tied_beside
from sysid.diagnosis.trials import evaluate_all
from sysid.estimation.fit import root_mean_huber
from sysid.estimation.reference_fit import fit_stated_model
from sysid.experiment.history import read_history
from sysid.ladder import add_effects
from sysid.prediction.problem import load_problem
from sysid.signals.gaussian_filter import GaussianFilter

NOISE = 0.02
ROWS = 4000


def _write(folder: Path, force: object, effects: str = '"coulomb", "viscous"') -> Path:
    """A velocity-drive experiment: two records whose friction force is `force(x, v)` plus white noise."""
    rng = np.random.default_rng(5)
    t = 2e-3 * np.arange(ROWS)
    for name, rates in (("fit", (0.7, 2.3)), ("validate", (0.5, 3.1))):
        x = 8e-3 * np.sin(2 * np.pi * rates[0] * t) + 1e-3 * np.sin(2 * np.pi * rates[1] * t + 0.4)
        v = (
            2
            * np.pi
            * (
                8e-3 * rates[0] * np.cos(2 * np.pi * rates[0] * t)
                + 1e-3 * rates[1] * np.cos(2 * np.pi * rates[1] * t + 0.4)
            )
        )
        y = force(x, v) + NOISE * rng.normal(size=ROWS)  # type: ignore[operator]
        table = np.column_stack([t, x, v, y])
        head = "time [s],position [m],velocity [m/s],friction_force [N]"
        np.savetxt(folder / f"{name}.csv", table, delimiter=",", header=head, comments="", fmt="%.12g")
    (folder / "experiment.toml").write_text(
        'schema = 1\n[rig]\nkind = "velocity-drive"\n'
        f"[model]\neffects = [{effects}]\n"
        '[[record]]\nfile = "fit.csv"\nrole = "fit"\n[[record]]\nfile = "validate.csv"\nrole = "validate"\n'
        f'[noise]\nfriction_force = "{NOISE} N"\n',
        "utf-8",
    )
    return folder


def _uneven(x: np.ndarray, v: np.ndarray) -> np.ndarray:
    # Friction that changes along the way, beside a cable: each alone is a poor explanation.
    return (1.5 + 0.6 * np.sin(2 * np.pi * x / 6e-3 + 0.3)) * np.sign(v) + 4.0 * v + 90.0 * (x + 1e-3)


def _dragged(x: np.ndarray, v: np.ndarray) -> np.ndarray:
    return 1.5 * np.sign(v) + 9.0 * v + 0.3 * np.sin(2 * np.pi * x / 6e-3 + 0.3)


def test_pair_with_an_amplitude_out_of_bounds_is_left_out(tmp_path: Path) -> None:
    """A negative Stribeck force resembles a drag, but is out of bounds; such pairs must not displace valid ones."""
    problem = load_problem(_write(tmp_path, _dragged, '"coulomb"'))
    base = fit_stated_model(problem)
    looks = screen_all(problem, base, ["coulomb"])
    pairs = best_pairs(problem, base, looks)
    assert set(pairs[0].names) == {"viscous", "magnetic_cogging"}
    amplitudes = [(p.model.values, e) for p in pairs for e in p.model.effects if e.name.startswith("stribeck")]
    assert all(values[f"{effect.name}.force"] > 0.0 for values, effect in amplitudes)


def test_two_effects_are_found_in_sequence_and_no_third(tmp_path: Path) -> None:
    rig = _write(tmp_path, _uneven)
    added = []
    for _ in range(2):
        found = diagnose(rig)
        assert found.verdict == "missing-effect"
        assert found.effect is not None
        added.append(found.effect)
        add_effects(rig, [found.effect])
    assert set(added) == {"position_dependent_friction", "cable_spring"}
    after = diagnose(rig)
    assert after.verdict == "adequate"
    assert after.before_validate["friction_force"].over_noise == pytest.approx(1.0, abs=0.1)


def _skewed(x: np.ndarray, v: np.ndarray) -> np.ndarray:
    wave = np.sin(2 * np.pi * x / 6e-3 + 0.3)
    return 1.5 * (1.0 + 0.4 * (wave + 0.2 * wave**2)) * np.sign(v) + 4.0 * v


def test_overtone_is_selected_for_a_wave_that_is_not_a_sine(tmp_path: Path) -> None:
    rig = _write(tmp_path, _skewed)
    found = diagnose(rig)
    assert found.effect == "position_dependent_friction"
    assert found.best is not None
    assert found.best.after_validate["friction_force"].over_noise > 2.0
    step = add_effects(rig, [found.effect])
    assert step.revision.effects[-1] == "position_dependent_friction:overtone"
    assert step.after_validate["friction_force"].over_noise == pytest.approx(1.0, abs=0.1)
    # sin^2 is half of 1 - cos: the crests are a tenth of the wave broader.
    values = step.base.fitted.model.values
    assert abs(values["position_dependent_friction:overtone.second_cosine"]) == pytest.approx(0.1, abs=0.02)


def test_second_screening_with_stored_jacobians_agrees(tmp_path: Path) -> None:
    problem = load_problem(_write(tmp_path, _uneven))
    base = fit_stated_model(problem)
    search = evaluate_all(problem, base, ["coulomb", "viscous"])
    first = next(trial.refit for trial in search.trials if trial.name == "cable_spring")
    kept, anew = (
        pairs_on_top(problem, base, first, jacobians=jacobians)[0] for jacobians in (search.screening.jacobians, None)
    )
    assert set(kept.names) == set(anew.names) == {"cable_spring", "position_dependent_friction"}
    assert kept.error == pytest.approx(anew.error, rel=1e-3)
    assert kept.error == pytest.approx(1.0, abs=0.1)


def test_equivalent_effect_beside_the_same_partner_is_reported(tmp_path: Path) -> None:
    problem = load_problem(_write(tmp_path, _uneven))
    base = fit_stated_model(problem)
    looks = screen_all(problem, base, ["coulomb", "viscous"])
    pair = best_pairs(problem, base, looks)[0]
    assert set(pair.names) == {"position_dependent_friction", "cable_spring"}
    wave = pair.effects[pair.names.index("position_dependent_friction")]
    rng = np.random.default_rng(0)

    def beside_the_wave(name: str, shift: float) -> Pair:
        residual = pair.residual + shift * rng.normal(size=pair.residual.size)
        return Pair((wave, find(name)), pair.fitted, root_mean_huber(residual), residual)

    alike, worse = beside_the_wave("gravity_torque", 1e-3), beside_the_wave("magnetic_cogging", 3.0)
    assert tied_beside(problem, base, pair, [pair, alike, worse], wave.name) == ("gravity_torque",)


def test_shape_without_a_stated_start_is_searched(tmp_path: Path) -> None:
    effects = '"coulomb", "viscous", "position_dependent_friction", "cable_spring"'
    found = diagnose(_write(tmp_path, _uneven, effects))
    assert found.verdict == "adequate"
    assert found.base.fitted.model.values["position_dependent_friction.pitch"] == pytest.approx(6e-3, rel=0.01)
    assert found.base.fitted.model.values["cable_spring.stiffness"] == pytest.approx(90.0, rel=0.02)


def test_bounds_stated_by_the_user_are_kept_in_a_new_search(tmp_path: Path) -> None:
    rig = _write(tmp_path, _uneven, '"coulomb", "viscous", "position_dependent_friction"')
    toml = rig / "experiment.toml"
    held = '[model.parameters]\n"position_dependent_friction.amplitude" = {high = "0.2"}\n[[record]]'
    toml.write_text(toml.read_text("utf-8").replace("[[record]]", held, 1), "utf-8")
    problem = load_problem(rig)
    grown = add_after_deletion(problem, fit_stated_model(problem), [find("cable_spring")])
    assert grown
    for fitted in grown:
        unknowns = {u.key: u for u in fitted.model.unknowns}
        assert unknowns["position_dependent_friction.amplitude"].high == 0.2
        assert fitted.model.values["position_dependent_friction.amplitude"] <= 0.2


def test_wrong_effect_is_replaced_by_the_true_one(tmp_path: Path) -> None:
    rig = _write(tmp_path, lambda x, v: 1.5 * np.sign(v) + 12.0 * v, '"coulomb"')
    add_effects(rig, ["quadratic_drag"])
    problem = load_problem(rig)
    swaps = find_swaps(ReducedModels(problem, fit_stated_model(problem)), ["quadratic_drag"])
    assert [(swap.old, swap.new) for swap in swaps] == [("quadratic_drag", "viscous")]
    assert swaps[0].after < swaps[0].before
    step = add_effects(rig, ["viscous"], drop=["quadratic_drag"])
    assert list(step.revision.effects) == ["coulomb", "viscous"]
    assert [list(rung.effects) for rung in read_history(step.problem.experiment)] == [
        ["coulomb"],
        ["coulomb", "quadratic_drag"],
        ["coulomb", "viscous"],
    ]
    assert diagnose(rig).swaps == ()


def test_unneeded_effect_is_reported(tmp_path: Path) -> None:
    rig = _write(tmp_path, lambda x, v: 1.5 * np.sign(v) + 12.0 * v)
    add_effects(rig, ["quadratic_drag"])
    assert [(swap.old, swap.new) for swap in diagnose(rig).swaps] == [("quadratic_drag", None)]


@pytest.mark.parametrize("width", [2e-3, 7e-3])
def test_smoothing_at_some_samples_agrees_with_full_smoothing(width: float) -> None:
    signal = np.cumsum(np.random.default_rng(1).normal(size=3000))
    smooth = GaussianFilter(width, 1e-3, signal.size)
    index = np.concatenate([np.arange(0, 40), np.arange(40, 2960, 7), np.arange(2960, 3000)])
    assert np.allclose(smooth.at(signal, index), smooth(signal)[index], rtol=0.0, atol=1e-6 * np.ptp(signal))
