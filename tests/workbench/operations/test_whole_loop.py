"""The whole loop from Python: the same documents as the commands, tables of them, and validation of the model."""

import json
import pickle
import re

import numpy as np
import pandas as pd
import pytest

import stagecad
from stagecad import Addition, Comparison, Effect, Experiment, InputError, Parameter, Rig
from tests.refusals import refused
from tests.workbench.operations.slide_log import NOISE, slide_log
from workbench.operations.measurement.tables import correlation_table


def test_residuals_are_measured_less_predicted_in_the_records_units(comparison: Comparison) -> None:
    table = comparison.to_dataframe()
    np.testing.assert_array_equal(table.loc["one", "friction_force"], slide_log(1)["friction_force [N]"])
    rest = table["friction_force"] - table["friction_force_predicted"] - table["friction_force_residual"]
    assert np.nanmax(np.abs(rest)) < 1e-12
    scored = comparison.residuals["friction_force"].dropna()
    rms = comparison.errors.loc[("fit", "friction_force"), "rms"]
    assert np.sqrt(np.mean(scored.loc["one"] ** 2)) == pytest.approx(rms, rel=1e-12)
    assert list(comparison.predictions.columns) == ["friction_force"]
    assert comparison.where.index[0] in ("velocity", "direction", "time", "acceleration", "frequency")


def test_the_diagnosis_names_the_effect_and_information_criteria_rank_it_first(diagnosis, comparison) -> None:
    assert (diagnosis.verdict, diagnosis.effect) == ("missing-effect", "stribeck")
    assert diagnosis.ranking.index[0] == "stribeck"
    assert repr(diagnosis).startswith("<Diagnosis of 'slide': missing-effect: stribeck")
    assert set(diagnosis.errors.index.get_level_values("model")) == {"before", "with stribeck"}
    # With the effect named, what is left is the noise of the generator; a reversal falls between two samples.
    left = diagnosis.residuals.loc["two", "friction_force"].abs().median() / 0.6745
    assert left == pytest.approx(NOISE, rel=0.15)
    assert comparison.to_json()["information"]["parameters"] == 3
    assert comparison.criteria.aic == comparison.to_json()["information"]["aic"]
    changes = diagnosis.ranking["bic_change"].dropna()
    assert changes.idxmin() == "stribeck" and changes.min() < -10.0
    # Models are compared with one effective number of samples: a lower loss is a lower criterion.
    assert (changes[diagnosis.ranking["reduction"] > 0.1] < 0.0).all()


def test_adding_in_memory_leaves_the_experiment_and_grows_a_ladder(slide: Experiment, addition: Addition) -> None:
    assert slide.stated.effects == ("coulomb", "viscous")
    assert addition.experiment.stated.effects[:2] == ("coulomb", "viscous")
    assert len(stagecad.ladder(slide).rungs) == 0
    grown = stagecad.ladder(addition.experiment)
    assert [rung["rung"] for rung in grown.rungs] == [0, 1]
    held = grown.to_dataframe()["over_noise"].xs("held out", level="records")
    assert held.iloc[0] > 10.0 * held.iloc[1]
    assert addition.parameters.loc["coulomb.force", "value"] == pytest.approx(4.0, rel=0.02)


def test_an_addition_to_a_folder_writes_its_rung_and_is_taken_back(slide: Experiment, tmp_path) -> None:
    added = stagecad.add(slide.save(tmp_path / "rig"), "stribeck")
    assert added.experiment.in_files and len(added.experiment.stated.effects) == 3
    assert added.to_json()["file"] == str(tmp_path / "rig" / "ladder" / "001.json")
    assert (tmp_path / "rig" / "ladder" / "001.json").exists()
    found = stagecad.undo(tmp_path / "rig")
    assert found.rung == 0 and found.effects == ("coulomb", "viscous") == found.experiment.stated.effects
    assert found.kept.is_file() and found.kept.parent.name == "undone"
    assert found.to_json() == {"schema": 1, "rung": 0, "effects": ["coulomb", "viscous"], "kept": str(found.kept)}
    assert found.to_dataframe().loc[("fit", "friction_force"), "over_noise"] > 10.0
    refused("nothing to undo", stagecad.undo, found.experiment)
    refused("is in memory", stagecad.undo, slide)


def test_an_effect_declared_in_memory_is_fitted() -> None:
    parameters = (Parameter("stiffness", "N/m", 10.0, 0.0, 1e4, "of the spring", "assumed"),)
    hook = Effect("hook", "from the middle", force=lambda axis, p: p.stiffness * axis.position, parameters=parameters)
    log = slide_log(1, extra=lambda x, v: 60.0 * x)
    effects = ["coulomb", "viscous", "stribeck", hook]
    noise = {"friction_force": f"{NOISE} N"}
    experiment = Experiment.from_dataframes({"a": log}, "velocity-drive", effects, noise=noise)
    assert stagecad.compare(experiment).parameters.loc["hook.stiffness", "value"] == pytest.approx(60.0, rel=0.02)
    refused("effect 'hook' is declared in memory", experiment.save, "unwritten")
    with pytest.raises(InputError, match="a built-in effect has that name"):
        Experiment.from_dataframes({"a": log}, "velocity-drive", [Effect("coulomb", "another")])


def test_nothing_to_add_is_refused(slide: Experiment) -> None:
    refused("at least one effect", stagecad.add, slide)
    refused(r"no effect 'stribek'.*did you mean 'stribeck'", stagecad.add, slide, "stribek")
    with pytest.raises(InputError, match="an Experiment or its folder is required, not int"):
        stagecad.compare(3)  # pyright: ignore[reportArgumentType]


def test_every_result_has_tables_pages_and_can_be_pickled(comparison, diagnosis, addition, slide) -> None:
    results = (comparison, diagnosis, addition, stagecad.ladder(addition.experiment))
    for result in results:
        assert isinstance(result.to_dataframe(), pd.DataFrame) and len(result.to_dataframe())
        assert repr(result).startswith("<") and len(repr(result)) < 200 and "\n" not in repr(result)
        assert "<table" in result._repr_html_()
        json.dumps(result.to_json(), allow_nan=False)
    results = (slide, comparison, comparison.correlation(), diagnosis, addition, stagecad.ladder(addition.experiment))
    for result in (*results, stagecad.simulate(slide, seed=None), comparison.plot()):
        assert repr(pickle.loads(pickle.dumps(result))) == repr(result)
    again = pickle.loads(pickle.dumps(diagnosis))
    assert again.to_json() == diagnosis.to_json()
    pd.testing.assert_frame_equal(again.predictions, diagnosis.predictions)


def test_correlation_and_whiteness_of_a_residual(comparison: Comparison, addition: stagecad.Addition, tmp_path) -> None:
    before = comparison.to_json()["correlation_of_residual"]["friction_force"]
    assert not before["white"] and before["autocorrelation"] > 0.2
    assert before["step"] == {"value": pytest.approx(0.005), "unit": "s"}
    lines = {row[0]: row[1:] for row in correlation_table(comparison.to_json()).rows}
    assert lines["friction force"][0] == "not white"
    assert re.search(r"AIC -?\d+\.\d, BIC -?\d+\.\d with 3 parameters", correlation_table(comparison.to_json()).note)
    page = comparison.write_report(tmp_path).read_text("utf-8")
    assert "Correlation of the residual" in page and "not white" in page and "BIC" in page
    after = stagecad.compare(addition.experiment).to_json()
    assert abs(after["correlation_of_residual"]["friction_force"]["autocorrelation"]) < 0.5 * before["autocorrelation"]
    assert after["information"]["bic"] < comparison.to_json()["information"]["bic"] - 1000.0
    before, after = comparison.correlation(), addition.correlation(part="validate")
    assert not before.is_white and "not white" in repr(before)
    assert before.to_dataframe().loc[("residual", 0.0), "correlation"] == pytest.approx(1.0, abs=1e-12)
    assert abs(after.computed.autocorrelation[1]) < before.computed.autocorrelation[1]
    assert len(before.plot().axes) == 3
    refused("no channel 'force'", comparison.correlation, "force")


def _pulled_mass(rows: int = 500) -> dict[str, np.ndarray]:
    """A mass of 1.5 kg with 6 N*s/m of drag and no other friction under a force of two sines: exact motion."""
    t = np.arange(rows) * 0.002
    force, x = np.zeros(rows), np.zeros(rows)
    for size, w in ((3.0, 7.0), (2.0, 19.0)):
        force += size * np.cos(w * t)
        response = size / (1.5 * (1j * w) ** 2 + 6.0 * 1j * w)
        x += np.real(response * np.exp(1j * w * t))
    return {"time [s]": t, "drive_force [N]": force, "position [m]": x}


def test_k_step_errors_of_a_known_motion() -> None:
    experiment = Experiment.from_dataframes(
        {"a": _pulled_mass()},
        Rig("force-drive", {"mass": "1.5 kg"}, input_hold="linear"),
        ["viscous"],
        noise={"position": "1e-7 m", "drive_force": "0.001 N"},
    )
    found = stagecad.compare(experiment)
    assert found.parameters.loc["viscous.coefficient", "value"] == pytest.approx(6.0, rel=1e-3)
    rms = found.prediction_errors((0.02, 0.1)).xs(("fit", "position"), level=("records", "channel"))["rms"]
    assert list(rms.index) == ["0.02 s", "0.1 s", "free run"]
    # Errors grow with the horizon, and stay far below the motion of 40 mm.
    assert rms["0.02 s"] < rms["0.1 s"] < 1e-4
    table = found.free_run
    difference = table["position"] - table["position_simulated"]
    assert difference.loc["a"].abs().max() < 1e-3
    refused("above zero", found.prediction_errors, (0.0,))
