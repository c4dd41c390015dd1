"""Drawings, motions, simulations and the nearest design from Python."""

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import stagecad
from stagecad import Diagnosis, Experiment
from tests.refusals import refused
from workbench.operations.measurement.new_experiment import propose
from workbench.operations.optimise import marked_free, need_free, optimize

SAG = "sag of the drive surface over the travel"
THIN = {"stage.thickness": "6.1 mm"}


def test_the_experiments_of_the_thesis() -> None:
    found = stagecad.simulate("presliding", models=["lugre"])
    assert isinstance(found, stagecad.Simulation)
    table = found.tables["presliding_lugre"]
    peak = found.to_dataframe().loc[("lugre", "position_max"), "value"]
    assert table["position [m]"].max() == pytest.approx(peak, rel=1e-3)
    assert found.to_json()["presliding"]["lugre"]["position_max"]["unit"] == "m"
    assert "presliding" in repr(found) and found.plot().axes
    refused("did you mean 'lugre'", stagecad.simulate, "presliding", models=["lugrr"])
    refused("neither an experiment of the thesis nor a folder", stagecad.simulate, "presliging")


def test_the_model_of_an_experiment_on_its_own_motion_and_on_another(slide: Experiment) -> None:
    own = stagecad.simulate(slide, seed=None)
    assert isinstance(own, stagecad.SimulatedRecords) and set(own.records) == {"one", "two"}
    t = np.arange(400) * 0.005
    motion = {"time [s]": t, "position [m]": 0.01 * np.sin(3.0 * t), "velocity [m/s]": 0.03 * np.cos(3.0 * t)}
    other = stagecad.simulate(slide, motion=motion, seed=3)
    (record,) = other.records.values()
    force = record["friction_force [N]"].to_numpy()
    # Coulomb and viscous friction have the sign of the velocity.
    moving = np.abs(motion["velocity [m/s]"]) > 0.01
    assert np.all(np.sign(force[moving]) == np.sign(motion["velocity [m/s]"][moving]))
    again = next(iter(stagecad.simulate(slide, motion=motion, seed=3).records.values()))
    np.testing.assert_array_equal(again, record)
    json.dumps(other.to_json(), allow_nan=False)
    refused("nothing", other.plot, "nothing")


@pytest.mark.slow
def test_suggested_motions_can_be_written_and_measured(slide: Experiment, diagnosis: Diagnosis, tmp_path: Path) -> None:
    steps: list[Any] = []
    found = stagecad.suggest(slide, progress=lambda *step: steps.append(step))
    table = found.to_dataframe()
    assert list(table.index) == list(found.motions) and steps
    # The space-filling motion, for effects that no model has, is always last.
    assert table["deviations_squared_per_second"].iloc[:-1].is_monotonic_decreasing
    assert table.index[-1] == "space-filling"
    written = found.write(tmp_path)
    files = [row["file"] for row in written.to_json()]
    assert [Path(file).is_file() for file in files] == [True] * len(files)
    assert found.competing[0] == diagnosis.effect or diagnosis.effect in found.competing


@pytest.mark.slow
def test_drawings_are_written_and_shown(tmp_path: Path) -> None:
    found = stagecad.drawings(names=["tip"], out=tmp_path)
    assert list(found.sheets) == ["tip"]
    suffixes = [".csv", ".dxf", ".pdf", ".png", ".step", ".svg"]
    assert sorted(Path(file).suffix for file in found.sheets["tip"]) == suffixes
    assert all(Path(file).stat().st_size > 500 for file in found.sheets["tip"])
    assert found.to_dataframe().loc["tip", "paper"] == "A3" and found.plot().axes
    refused("did you mean 'tip'", stagecad.drawings, names=["tipp"], out=tmp_path)


def test_the_design_found_passes_what_was_required() -> None:
    thin = stagecad.load_design(values=THIN, rules=False)
    assert stagecad.checks(thin, solids=False, proposals=False)[SAG].verdict == "fails"
    steps: list[tuple[str, int, int]] = []
    found = optimize(
        thin, {"stage.thickness": "6 mm:30 mm"}, [SAG], only=True, budget=30, progress=lambda *step: steps.append(step)
    )
    assert found.feasible and list(found.changes) == ["stage.thickness"] and found.unverified == []
    better = thin.with_values(found.changes)
    assert stagecad.checks(better, solids=False, proposals=False)[SAG].verdict == "passes"
    # It is near the limit: half of the change is not enough.
    half = 0.5 * (thin.si("stage.thickness") + better.si("stage.thickness"))
    less = thin.with_values({"stage.thickness": f"{1e3 * half} mm"})
    assert stagecad.checks(less, solids=False, proposals=False)[SAG].verdict == "fails"
    table = found.to_dataframe()
    assert table.loc["stage.thickness", "before"] == "6.1 mm" and SAG in table.loc["stage.thickness", "reason"]
    assert max(done for _, done, _ in steps) == found.outcome.evaluations
    assert "1 changes" in repr(found) and found.plot().axes
    json.dumps(found.to_json(), allow_nan=False)


def test_a_fault_names_the_key_and_no_option_of_the_command() -> None:
    design = stagecad.load_design()
    assert marked_free(design)["stage.thickness"] == "10 mm:30 mm"
    for free, message in (
        ({"stage.thicknes": "1 mm:2 mm"}, "did you mean 'stage.thickness'"),
        ({"stage.thickness": "thick"}, r"^stage\.thickness = 'thick': write LOW:HIGH"),
        ({"stage.thickness": "1 kg:2 kg"}, r"^stage\.thickness: '1 kg' has the wrong dimension"),
    ):
        refused(message, need_free, design, free)
    refused(r"^'bendin of the stage': no such check", optimize, design, keep=["bendin of the stage"], solids=False)
    refused(r"^'velocity-drivr' .*; did you mean 'velocity-drive'", propose, ["any.csv"], "velocity-drivr")
