"""Along the motion of a state observer the error of a true model with its true values is the noise, for every law."""

from pathlib import Path

import pytest

from benchmarks.true_models import Case, truth_of, write_experiment
from sysid.estimation.fit import fit_model
from sysid.estimation.misfit import misfit
from sysid.estimation.reference_fit import along_observer, fit_with_observer, reference_fit
from sysid.prediction.problem import load_problem


@pytest.mark.parametrize(
    ("rig", "law", "most"),
    [
        ("force-drive, open loop", "lugre", 1.1),
        ("force-drive, open loop", "elasto_plastic", 1.1),
        ("force-drive, closed loop", "presliding", 1.1),
        # The smooth yielding of the elements is corrected, but not between rows.
        ("force-drive, open loop", "presliding", 1.25),
        ("spring-pull", "lugre_undamped", 1.12),
    ],
)
def test_error_of_a_true_model_is_the_noise(tmp_path: Path, rig: str, law: str, most: float) -> None:
    case = Case(rig, law, 50e-9, "stated", 1)
    truth = truth_of(case)
    problem = load_problem(write_experiment(case, truth, tmp_path))
    model = problem.start.at({key: value for key, value in truth.values.items() if key in problem.start.values})
    observed = [along_observer(along_observer(record, model), model) for record in problem.fit_records]
    for channel, found in misfit(model, observed).items():
        assert 0.9 <= found.over_noise <= most, channel


@pytest.mark.parametrize(
    ("rig", "mass"), [("force-drive, open loop", "stated"), ("force-drive, closed loop", "unknown")]
)
def test_shapes_lost_in_the_blur_are_found_along_the_observer(tmp_path: Path, rig: str, mass: str) -> None:
    """With a noise of 0.5 um the Stribeck curve found along the filtered motion is 0.007 N, or a fifth too small."""
    case = Case(rig, "dahl", 500e-9, mass, 281127)
    truth = truth_of(case)
    problem = load_problem(write_experiment(case, truth, tmp_path))
    blurred = {"stribeck.force": 0.007, "stribeck.velocity": 3.3e-3}
    start = {key: value for key, value in (truth.values | blurred).items() if key in problem.start.values}
    base = reference_fit(problem, fit_model(problem.start.at(start), problem.fit_records))
    problem, base = fit_with_observer(problem, base)
    for key in ("stribeck.force", "stribeck.velocity"):
        assert base.fitted.model.values[key] == pytest.approx(truth.values[key], rel=0.03), key
    for records in (problem.fit_records, problem.validate_records):
        assert misfit(base.fitted.model, records)["drive_force"].over_noise < 1.1
