"""The commands of the loop: the demo from start to end, and its folders."""

import json
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pytest

import workbench
from benchmarks.generators.hidden_effect import Plan, make_case
from benchmarks.generators.make_demo_records import demo_records
from sim.effects.effect import Effect
from sysid.diagnosis import candidate_screening
from sysid.prediction.model import public_name
from sysid.prediction.observable import candidate_effects
from workbench import cli
from workbench.operations.templates import free_folder, fresh_copy

PACKAGED = Path(workbench.__file__).parent / "demo_records"


FEW = {"stribeck", "magnetic_cogging", "cable_spring", "constant_bias", "direction_asymmetry"}
"""Candidates of the quick demonstration: the effects of its records, and rivals of each."""


# Among all candidates as well, as a user runs it: that none of the library is named in the place of the true ones.
@pytest.fixture(scope="module", params=[FEW, pytest.param(None, marks=pytest.mark.slow)], ids=["few", "all"])
def demo(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, dict]:
    out = tmp_path_factory.mktemp("demo")

    def few(*of_problem: Any) -> list[Effect]:
        return [effect for effect in candidate_effects(*of_problem) if public_name(effect.name) in request.param]

    with pytest.MonkeyPatch.context() as patch:
        if request.param is not None:
            patch.setattr(candidate_screening, "candidate_effects", few)
        assert cli.run(["demo", "--out", str(out), "--json", str(out / "demo.json")]) == 0
    return out, json.loads((out / "demo.json").read_text(encoding="utf-8"))


def test_the_demo_finds_both_effects_stops_at_the_noise_and_leaves_one_report(demo: tuple[Path, dict]) -> None:
    """Protects the first command that a user runs, from the packaged records to the report."""
    out, document = demo
    found = [r["diagnose"]["effect"] for r in document["rounds"]]
    assert set(found[:2]) == {"stribeck", "magnetic_cogging"}
    assert document["rounds"][-1]["diagnose"]["verdict"] == "adequate"
    over = [r["before"]["validate"]["friction_force"]["over_noise"] for r in document["ladder"]]
    assert over == sorted(over, reverse=True) and over[0] > 50.0 and over[-1] < 1.1
    page = Path(document["report"]).read_text(encoding="utf-8")
    for words in ("The ladder", "The model as it stands", "stribeck and magnetic_cogging are missing", "adequate"):
        assert words in page
    assert Path(document["figure"]).stat().st_size > 5000
    assert (out / "demo" / "ladder" / "002.json").is_file()


def test_the_demo_begins_anew_each_time(tmp_path: Path) -> None:
    folder = fresh_copy(tmp_path / "demo")
    (folder / "ladder").mkdir()
    (folder / "ladder" / "000.json").write_text("{}", encoding="utf-8")
    (folder / "mine.txt").write_text("kept", encoding="utf-8")
    (folder / "experiment.toml").write_text("changed", encoding="utf-8")
    fresh_copy(folder)
    assert not (folder / "ladder").exists() and (folder / "mine.txt").is_file()
    assert (folder / "experiment.toml").read_bytes() == (PACKAGED / "experiment.toml").read_bytes()


@pytest.mark.parametrize("changed", ["experiment.toml", "fit.csv", "ladder/001.json", "my_effect.py"])
def test_a_folder_of_the_demo_in_which_somebody_worked_is_left_alone(tmp_path: Path, changed: str) -> None:
    folder = fresh_copy(free_folder(tmp_path / "demo"))
    (folder / "report.html").write_text("can be made again")
    assert free_folder(tmp_path / "demo") == folder
    (folder / changed).parent.mkdir(exist_ok=True)
    (folder / changed).write_text("my own work")
    other = fresh_copy(free_folder(tmp_path / "demo"))
    assert free_folder(tmp_path / "demo") == other == tmp_path / "demo_2"
    assert (folder / changed).read_text() == "my own work"


def test_a_folder_or_link_that_the_demo_did_not_make_is_left_alone(tmp_path: Path) -> None:
    (tmp_path / "demo").mkdir()
    assert free_folder(tmp_path / "demo") == tmp_path / "demo_2"
    (tmp_path / "demo").rmdir()
    (tmp_path / "demo").symlink_to(fresh_copy(tmp_path / "rig"))
    assert free_folder(tmp_path / "demo") == tmp_path / "demo_2"


def test_the_packaged_records_are_the_generators(tmp_path: Path) -> None:
    """Protects the packaged records: they are those of the published generator."""
    for name, text in demo_records().items():
        path = tmp_path / name
        path.write_text(text, encoding="utf-8")
        if path.suffix == ".csv":
            made, packaged = pd.read_csv(path), pd.read_csv(PACKAGED / name)
            assert list(made.columns) == list(packaged.columns)
            # Another build of the mathematical functions may turn the last digit.
            np.testing.assert_allclose(made.to_numpy(), packaged.to_numpy(), atol=2e-3)
        else:
            assert text == (PACKAGED / name).read_text(encoding="utf-8")
    assert sum(path.stat().st_size for path in PACKAGED.iterdir()) < 500_000


def test_two_names_for_one_lag_are_said_to_be_one(tmp_path: Path, command) -> None:
    make_case(Plan("actuator-tip", ("drive_lag",), rows=4000), np.random.default_rng(2)).write(tmp_path / "tip")
    said = " ".join(command("suggest", tmp_path / "tip", "--out", tmp_path / "out").out.split())
    assert "no motion of this family separates" in said and "sensor_lag" in said and "drive_lag" in said
