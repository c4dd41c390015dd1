"""Results of a design go to other processes: they pickle, and give the same document there."""

import pickle
from pathlib import Path

import numpy as np
import pytest
from scipy.signal import StateSpace, lsim

import stagecad
from workbench.operations.calculate import calculate
from workbench.operations.checks import chains, ranges_of, sweep
from workbench.operations.design import Design
from workbench.operations.result import Result


def _results() -> dict[str, Result]:
    design = stagecad.load_design()
    thicker = design.with_values({"stage.thickness": "14 mm"})
    return {
        "design": thicker,
        "checks": stagecad.checks(design, solids=False, proposals=False),
        "diff": stagecad.diff(design, thicker, solids=False),
        "sweep": sweep(design, ranges_of(design, ["stage.thickness=12mm:14mm:2"]), solids=False),
        "chains": chains(design),
        "calculation": calculate("hertz", design, {"load": "20 N"}),
    }


@pytest.fixture(scope="module")
def results() -> dict[str, Result]:
    return _results()


@pytest.mark.parametrize("name", ["design", "checks", "diff", "sweep", "chains", "calculation"])
def test_a_pickled_result_is_the_same(results: dict[str, Result], name: str) -> None:
    result = results[name]
    other = pickle.loads(pickle.dumps(result))
    assert repr(other) == repr(result) and "<table" in other._repr_html_()
    assert other.to_json() == result.to_json()
    assert len(other.to_dataframe()) == len(result.to_dataframe()) > 0


def test_a_pickled_design_needs_no_file(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    file = tmp_path / "stage.toml"
    file.write_text('extends = "thesis"\n[stage]\nthickness = {value = "14 mm", origin = "assumed: stiffer"}\n')
    monkeypatch.chdir(tmp_path)
    design = Design.chosen(None, ("stage.width=272 mm",))
    assert design.path == Path("stage.toml") and Design.chosen(file).path == file
    data = pickle.dumps(design)
    file.unlink()
    other = pickle.loads(data)
    assert other.si("stage.thickness") == 0.014 and other.si("stage.width") == pytest.approx(0.272)
    assert other.values_with("stage.thickness=13 mm").si("stage.thickness") == 0.013
    assert Design.chosen(None).path is None


def test_covariance_and_samples_have_the_deviations_of_the_parameters(
    comparison: stagecad.Comparison, addition: stagecad.Addition
) -> None:
    # The standard deviation of a sample of n has the relative standard deviation 1 / sqrt(2 n).
    n = 20_000
    for result in (comparison, addition):
        stds, sample = result.parameters["std"], result.sample(n, seed=3)
        assert np.allclose(np.sqrt(np.diag(result.covariance)), stds[list(result.covariance)], 1e-9, equal_nan=True)
        known = stds.notna()
        assert len(sample) == n and np.allclose((sample.std() / stds)[known], 1.0, atol=5.0 / np.sqrt(2.0 * n))
        # Plain friction alone does not determine the drag of this slide.
        assert (sample.loc[:, ~known].std() == 0.0).all() and known.sum() == (1 if result is comparison else len(stds))
        assert sample.equals(result.sample(n, seed=3)) and not sample.equals(result.sample(n, seed=4))


def test_the_function_is_the_step_that_is_exported(comparison: stagecad.Comparison, tmp_path: Path) -> None:
    time = np.linspace(0.0, 2.0, 500)
    position = 3e-3 * np.sin(4.0 * time)
    exported = stagecad.export(comparison.experiment, "python", tmp_path).function()
    assert np.array_equal(comparison.function()(time, position), exported(time, position))


def test_the_linear_part_of_a_driven_mass_has_the_poles_of_the_truth(comparison: stagecad.Comparison) -> None:
    """The truth is the closed form of `scipy.signal`, which shares nothing with the program."""
    mass, drag, stiffness = 2.0, 5.0, 300.0
    truth = StateSpace([[0.0, 1.0], [-stiffness / mass, -drag / mass]], [[0.0], [1.0 / mass]], [[1.0, 0.0]], [[0.0]])
    time = np.arange(0.0, 10.0, 1e-3)
    force = 20.0 * np.sin(9.0 * time) + 10.0 * np.sin(17.0 * time) + 5.0 * np.sign(np.sin(3.0 * time))
    _, position, _ = lsim(truth, force, time, interp=False)
    noise = 1e-6 * np.random.default_rng(1).standard_normal(time.size)
    record = {"time [s]": time, "drive_force [N]": force, "position [m]": position + noise}
    experiment = stagecad.Experiment.from_dataframes(
        {"fit": record}, "force-drive", ["viscous", "cable_spring"], {"position": "1e-6 m"}
    )
    found = stagecad.compare(experiment)
    assert np.allclose(found.to_statespace().A, truth.A, rtol=0.01, atol=0.05)
    assert np.allclose(found.to_statespace().B, truth.B, rtol=0.01)
    with pytest.raises(stagecad.InputError, match="has no mass"):
        comparison.to_statespace()


def test_reprs_are_short(comparison: stagecad.Comparison) -> None:
    for one in (comparison, comparison.fitted, comparison.fitted.model, comparison.problem):
        assert len(repr(one)) < 120
