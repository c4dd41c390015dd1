"""Search over models: pairs, effects on top of another one, shapes, variants; effects that others replace."""

from pathlib import Path

import numpy as np
import pytest

from sim.effects.catalogue import find
from sysid.add import add_effects
from sysid.diagnose import diagnose
from sysid.diagnosis.candidate_screening import screen_all
from sysid.diagnosis.ledger import find_replacements
from sysid.diagnosis.model_search import SCREENED_ON_TOP, ModelSearch
from sysid.estimation.reference_fit import fit_stated_model, reference_fit
from sysid.experiment.ladder import read_history
from sysid.prediction.observable import is_observable
from sysid.prediction.problem import load_problem
from tests.experiments import write_rig
from tests.sysid.axis_with_pitch import uneven, write
from tests.sysid.slide import SIGN, VELOCITY, slide


def _search(folder: Path, *candidates: str) -> ModelSearch:
    """Of one effect more among the candidates; a second one, or one in place of another, is any effect."""
    problem = load_problem(folder)
    return ModelSearch(problem, fit_stated_model(problem), options=[find(name) for name in candidates])


def _skewed(x: np.ndarray, v: np.ndarray) -> np.ndarray:
    wave = np.sin(2 * np.pi * x / 6e-3 + 0.3)
    return 1.5 * (1.0 + 0.4 * (wave + 0.2 * wave**2)) * np.sign(v) + 4.0 * v


def test_overtone_is_selected_for_a_wave_that_is_not_a_sine(tmp_path: Path) -> None:
    """Protects that the overtone of a wave is selected as the effect is added."""
    rig = write(tmp_path, _skewed)
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


@pytest.mark.slow
def test_second_screening_with_stored_jacobians_agrees(tmp_path: Path) -> None:
    problem = load_problem(write(tmp_path, uneven))
    search = ModelSearch(problem, fit_stated_model(problem))
    first = next(candidate for candidate in search.singles if candidate.name == "cable_spring")
    on_top = search.step(first)[0]
    assert set(on_top.families) == {"cable_spring", "position_dependent_friction"}
    assert on_top.error == pytest.approx(1.0, abs=0.1)
    screening = search.screening
    assert screening.size == search.base.fitted.fit.residual.size
    wave = screening.grids["position_dependent_friction"]
    assert all(point.changes.shape[0] == screening.target.size for point in wave)
    below = reference_fit(search.problem, first.fitted, search.base.weights)
    kept, anew = (
        screen_all(search.problem, below, promising=SCREENED_ON_TOP, known=known).fits[0] for known in (screening, None)
    )
    assert kept.effect.name == anew.effect.name == on_top.added[1].name
    assert kept.error == pytest.approx(anew.error, rel=1e-3)


def test_stated_starts_and_bounds_are_kept_in_a_search(tmp_path: Path) -> None:
    """Protects that a true model is found from its stated starts, and that a search widens no bound that the user
    stated."""
    effects = "coulomb", "viscous", "position_dependent_friction", "cable_spring"
    values = fit_stated_model(load_problem(write(tmp_path, uneven, *effects))).fitted.model.values
    assert values["position_dependent_friction.pitch"] == pytest.approx(6e-3, rel=0.01)
    assert values["cable_spring.stiffness"] == pytest.approx(90.0, rel=0.02)
    rig = write(tmp_path, uneven, "coulomb", "viscous", "position_dependent_friction")
    with (rig / "experiment.toml").open("a") as file:
        file.write('[model.parameters]\n"position_dependent_friction.amplitude" = {high = "0.2"}\n')
    search = _search(rig, "cable_spring")
    candidate = search.converged(search.singles[0])
    unknowns = {u.key: u for u in candidate.fitted.model.unknowns}
    assert unknowns["position_dependent_friction.amplitude"].high == 0.2
    assert candidate.fitted.model.values["position_dependent_friction.amplitude"] <= 0.2


def test_ranked_effects_are_one_per_family_and_do_not_change_the_base_model(tmp_path: Path) -> None:
    problem = slide(tmp_path, 1.5 * SIGN + 5.0 * VELOCITY, "coulomb", held_out=True)
    base = fit_stated_model(problem)
    before = dict(base.fitted.model.values)
    search = ModelSearch(problem, base)
    names = [candidate.public_name for candidate in search.ranked]
    assert names[0] == "viscous"
    assert len(set(names)) == len(names)
    assert [c.held_out.loss for c in search.ranked] == sorted(c.held_out.loss for c in search.ranked)
    below = search.without(search.stated, "coulomb")
    assert below is not None
    assert below.held_out.loss > 100.0
    assert base.fitted.model.values == before


def _viscous(x: np.ndarray, v: np.ndarray) -> np.ndarray:
    return 1.5 * np.sign(v) + 12.0 * v


@pytest.mark.slow
def test_wrong_effect_is_replaced_by_the_true_one(tmp_path: Path) -> None:
    rig = write(tmp_path, _viscous, "coulomb")
    add_effects(rig, ["quadratic_drag"])
    found = find_replacements(_search(rig), ["quadratic_drag"])
    assert [(one.old, one.new) for one in found] == [("quadratic_drag", "viscous")]
    assert found[0].after < found[0].before
    step = add_effects(rig, ["viscous"], drop=["quadratic_drag"])
    assert list(step.revision.effects) == ["coulomb", "viscous"]
    assert [list(revision.effects) for revision in read_history(step.problem.experiment)] == [
        ["coulomb"],
        ["coulomb", "quadratic_drag"],
        ["coulomb", "viscous"],
    ]
    assert diagnose(rig).replacements == ()


def test_unneeded_effects_are_reported_and_needed_ones_kept(tmp_path: Path) -> None:
    """Protects that an effect that the others make superfluous is reported, and none that is needed."""
    rig = write(tmp_path, _viscous)
    add_effects(rig, ["quadratic_drag"])
    assert [(one.old, one.new) for one in diagnose(rig).replacements] == [("quadratic_drag", None)]
    rig = write(tmp_path, _viscous, "coulomb")
    add_effects(rig, ["quadratic_drag"])
    # Wrong, but needed: without a search of replacements it stays.
    assert find_replacements(_search(rig), ["quadratic_drag"], others_too=False) == []
    # The friction state is what all levels act on; it is never removed.
    assert find_replacements(_search(rig), ["coulomb"]) == []
    step = add_effects(rig, ["viscous"], drop=["quadratic_drag"])
    assert step.revision.effects[-1] == "viscous"
    assert find_replacements(_search(rig), ["viscous"]) == []


@pytest.mark.parametrize("stated,removed", [("", 1), ('{start = "0.5 +- 2 N*s^2/m^2"}', 0)])
def test_effect_with_priors_on_all_its_values_is_not_removed(tmp_path: Path, stated: str, removed: int) -> None:
    rig = write(tmp_path, _viscous, "coulomb", "viscous", "quadratic_drag")
    if stated:
        with (rig / "experiment.toml").open("a") as file:
            file.write(f'[model.parameters]\n"quadratic_drag.coefficient" = {stated}\n')
    found = find_replacements(_search(rig), ["quadratic_drag"], others_too=False)
    assert [one.new for one in found] == [None] * removed


def _loaded_cylinder(folder: Path) -> Path:
    """Slow strokes and fast returns at four constant loads: friction grows with a power of the load and is larger along
    the strokes."""
    records = {}
    for seed, load in enumerate((50.0, 150.0, 250.0, 350.0)):
        random = np.random.default_rng(seed)
        time = np.arange(500) * 0.04
        stroke = np.interp((time / 5.0) % 1.0, [0.0, 0.6, 1.0], [0.0, 1.0, 2.0])
        position = 0.01 * (1.0 - np.cos(np.pi * stroke))
        velocity = np.gradient(position, time)
        level = 12.0 * (load / 350.0) ** 0.65
        force = level * np.tanh(velocity / 5e-4) * (1.0 + 0.35 * np.sign(velocity)) + 30.0 * velocity
        force += 0.05 * random.standard_normal(500)
        columns = {"time": time, "position": position, "velocity": velocity, "normal_load": 0.0 * time + load}
        records["validate" if load == 150.0 else f"{load:g}"] = columns | {"friction_force": force}
    return write_rig(folder, "velocity-drive", records, ["coulomb", "viscous"], noise={"friction_force": 0.05})


def test_replacement_is_compared_with_the_variants_selected_again(tmp_path: Path) -> None:
    rig = _loaded_cylinder(tmp_path / "rig")
    add_effects(rig, ["constant_bias"])
    step = add_effects(rig, ["load_dependent_friction"])
    # A bias that does not grow with the load is taken from the strokes, and what is left is nearly a straight line.
    assert "load_dependent_friction" in step.revision.effects
    found = find_replacements(_search(rig), ["constant_bias"])
    assert [(one.old, one.new) for one in found] == [("constant_bias", "direction_asymmetry")]
    step = add_effects(rig, ["direction_asymmetry"], drop=["constant_bias"])
    assert "load_dependent_friction:power" in step.revision.effects


def test_load_that_is_constant_within_each_record_is_observable(tmp_path: Path) -> None:
    problem = load_problem(_loaded_cylinder(tmp_path / "rig"))
    assert is_observable(problem, find("load_dependent_friction"))
    assert not is_observable(problem, find("temperature_dependent_friction"))


def test_variant_beside_another_effect_is_the_one_that_predicts_the_held_out_record(tmp_path: Path) -> None:
    """The fit has seen slow motions, along which each Stribeck curve fits; the held-out one is three times as fast."""
    time, records = np.arange(1500) * 0.01, {}
    for seed, (role, size) in enumerate({"fit": 0.3, "validate": 1.0}.items()):
        waves = 0.7 * np.sin(0.4 * np.pi * time) + 0.3 * np.sin(0.94 * np.pi * time + 1.0)
        position = 0.01 * size * waves
        velocity = np.gradient(position, time)
        friction = np.sign(velocity) * (2.5 + 0.7 / (1.0 + (velocity / 4e-3) ** 2)) + 45.0 * velocity
        force = friction + 45.0 * position + 0.04 * np.random.default_rng(seed).normal(size=time.size)
        records[role] = {"time": time, "position": position, "velocity": velocity, "friction_force": force}
    write_rig(tmp_path, "velocity-drive", records, ["coulomb", "viscous"], noise={"friction_force": 0.04})
    search = _search(tmp_path, "cable_spring")
    found = search.step(search.singles[0])[0]
    assert found.names == ("cable_spring", "stribeck:rational")
    assert found.held_out.loss == pytest.approx(1.0, abs=0.1)
