"""Effects added earlier that are not needed, or that another effect replaces."""

from pathlib import Path

import numpy as np
import pytest

from sim.effects.catalogue import find
from sysid.diagnose import diagnose
from sysid.diagnosis.model_search import ModelSearch
from sysid.diagnosis.replacements import find_replacements
from sysid.estimation.reference_fit import fit_stated_model
from sysid.experiment.history import read_history
from sysid.ladder import add_effects
from sysid.prediction.observable import is_observable
from sysid.prediction.problem import load_problem
from tests.sysid.axis_with_pitch import write


def _viscous(x: np.ndarray, v: np.ndarray) -> np.ndarray:
    return 1.5 * np.sign(v) + 12.0 * v


def _search(folder: Path) -> ModelSearch:
    problem = load_problem(folder)
    return ModelSearch(problem, fit_stated_model(problem))


@pytest.mark.slow
def test_wrong_effect_is_replaced_by_the_true_one(tmp_path: Path) -> None:
    rig = write(tmp_path, _viscous, '"coulomb"')
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


def test_unneeded_effect_is_reported(tmp_path: Path) -> None:
    rig = write(tmp_path, _viscous)
    add_effects(rig, ["quadratic_drag"])
    assert [(one.old, one.new) for one in diagnose(rig).replacements] == [("quadratic_drag", None)]


def test_needed_effect_is_kept_and_only_removals_are_searched_if_stated(tmp_path: Path) -> None:
    rig = write(tmp_path, _viscous, '"coulomb"')
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
    rig = write(tmp_path, _viscous, '"coulomb", "viscous", "quadratic_drag"')
    if stated:
        toml = rig / "experiment.toml"
        prior = f'[model.parameters]\n"quadratic_drag.coefficient" = {stated}\n[[record]]'
        toml.write_text(toml.read_text("utf-8").replace("[[record]]", prior, 1), "utf-8")
    found = find_replacements(_search(rig), ["quadratic_drag"], others_too=False)
    assert [one.new for one in found] == [None] * removed


def _loaded_cylinder(folder: Path) -> Path:
    """Slow strokes and fast returns at four constant loads: friction grows with a power of the load and is larger along
    the strokes."""
    folder.mkdir()
    records = []
    for seed, load in enumerate((50.0, 150.0, 250.0, 350.0)):
        random = np.random.default_rng(seed)
        time = np.arange(2000) * 0.01
        stroke = np.interp((time / 5.0) % 1.0, [0.0, 0.6, 1.0], [0.0, 1.0, 2.0])
        position = 0.01 * (1.0 - np.cos(np.pi * stroke))
        velocity = np.gradient(position, time)
        level = 12.0 * (load / 350.0) ** 0.65
        force = level * np.tanh(velocity / 5e-4) * (1.0 + 0.35 * np.sign(velocity)) + 30.0 * velocity
        rows = np.column_stack([time, position, velocity, force + 0.05 * random.standard_normal(2000), 0 * time + load])
        header = "time [s],position [m],velocity [m/s],friction_force [N],normal_load [N]"
        np.savetxt(folder / f"{load:g}.csv", rows, delimiter=",", header=header, comments="", fmt="%.9g")
        role = "validate" if load == 150.0 else "fit"
        records.append(f'[[record]]\nfile = "{load:g}.csv"\nrole = "{role}"\n')
    model = '[model]\neffects = ["coulomb", "viscous"]\n'
    text = "\n".join(
        ['schema = 1\n\n[rig]\nkind = "velocity-drive"\n', model, *records, '[noise]\nfriction_force = "0.05 N"\n']
    )
    (folder / "experiment.toml").write_text(text, "utf-8")
    return folder


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
