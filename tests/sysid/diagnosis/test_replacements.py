"""Effects added earlier that are not needed, or that another effect replaces."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from sysid.diagnose import diagnose
from sysid.diagnosis.model_search import ModelSearch
from sysid.diagnosis.replacements import find_replacements
from sysid.estimation.reference_fit import fit_stated_model
from sysid.experiment.history import read_history
from sysid.ladder import add_effects
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
