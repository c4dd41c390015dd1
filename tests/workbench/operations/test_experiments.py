"""Experiments from data in memory: the same as from files, and one-line errors."""

import numpy as np
import pandas as pd
import pytest

import stagecad
from stagecad import Experiment, InputError, Model, Record, Rig
from tests.workbench.operations.slide_log import slide_log


def test_data_in_memory_and_in_files_give_the_same_records(slide: Experiment, tmp_path) -> None:
    saved = slide.save(tmp_path / "rig")
    assert saved.in_files and not slide.in_files
    pd.testing.assert_frame_equal(saved.to_dataframe(), slide.to_dataframe())
    assert saved.model == slide.model and saved.rig == slide.rig
    with pytest.raises(InputError, match="is there already"):
        slide.save(tmp_path / "rig")


def test_the_time_may_be_the_index() -> None:
    log = slide_log(1)
    plain = Experiment.from_dataframes({"a": log}, "velocity-drive", ["coulomb"]).to_dataframe()
    table = pd.DataFrame(log).set_index("time [s]")
    pd.testing.assert_frame_equal(
        Experiment.from_dataframes({"a": table}, "velocity-drive", ["coulomb"]).to_dataframe(), plain
    )
    stamps = pd.Timestamp("2026-01-05 10:00") + pd.to_timedelta(log["time [s]"], unit="s")
    table = pd.DataFrame(log).drop(columns="time [s]").set_index(pd.DatetimeIndex(stamps))
    found = Experiment.from_dataframes({"a": table}, "velocity-drive", ["coulomb"]).to_dataframe()
    np.testing.assert_allclose(
        found.index.get_level_values("time"), plain.index.get_level_values("time"), atol=1e-9, rtol=0.0
    )


def test_units_signs_names_and_windows_of_a_record() -> None:
    log = slide_log(1)
    data = {
        "t": log["time [s]"],
        "x": log["position [mm]"],
        "velocity": log["velocity [mm/s]"],
        "friction_force": -log["friction_force [N]"],
    }
    record = Record(
        data,
        units={"t": "s", "x": "mm", "velocity": "mm/s", "friction_force": "N"},
        columns={"time": "t", "position": "x"},
        sign={"friction_force": -1},
        window=("1 s", "3 s"),
    )
    found = Experiment.from_dataframes({"a": record}, "velocity-drive", ["coulomb"]).to_dataframe()
    whole = Experiment.from_dataframes({"a": log}, "velocity-drive", ["coulomb"]).to_dataframe()
    time = whole.index.get_level_values("time")
    np.testing.assert_array_equal(found, whole[(time >= 1.0) & (time <= 3.0)])


def test_a_record_of_pulses_has_the_settings_of_a_file() -> None:
    steps = 0.02 + 0.001 * np.arange(50)
    channels = {
        "time": {"column": "dt", "unit": "s", "increments": True},
        "position": {"pulses_per_turn": 4},
        "drive_force": {"value": "0 N*m"},
    }
    record = Record({"dt": steps}, channels=channels)
    found = Experiment.from_dataframes({"a": record}, Rig("force-drive", {"mass": "1 kg*m^2"}), ["coulomb"])
    table = found.to_dataframe()
    np.testing.assert_allclose(table.index.get_level_values("time"), np.cumsum(steps), rtol=1e-12)
    np.testing.assert_allclose(table["position"], 0.5 * np.pi * np.arange(1, 51), rtol=1e-12)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"rig": "velocity-drivr"}, r"no kind of rig; did you mean 'velocity-drive'"),
        ({"rig": Rig("velocity-drive", {"mass": "1.79"})}, r"slide: rig\.known\.mass: .*unit"),
        ({"model": ["coulom"]}, r"slide: model\.effects: .*did you mean 'coulomb'"),
        ({"model": "coulomb"}, r"a Model, or a list of effects, is required"),
        ({"model": Model(["coulomb"], {"coulomb.force": "1 kg"})}, r"coulomb\.force"),
        ({"noise": {"friction_force": "3"}}, r"slide: noise\.friction_force"),
        ({"validate": ["twp"]}, r"validate: no record 'twp'"),
        ({"records": {"a": 3}}, r"a: is int; a DataFrame"),
        ({"records": {"a": {"time": [0, 1], "position": [0.0]}}}, r"a: its columns have the shapes"),
        ({"records": {"a": {"time": [0, 1], "position": [0.0, 1.0]}}}, r"a: .*"),
    ],
)
def test_a_fault_is_one_line_that_names_the_key(change, message) -> None:
    log = {"records": {"a": slide_log(1)}, "rig": "velocity-drive", "model": ["coulomb"], "name": "slide"}
    with pytest.raises(InputError, match=message) as caught:
        _ = Experiment.from_dataframes(**(log | change)).problem
    assert "\n" not in str(caught.value)


def test_a_model_is_put_together_of_effects_and_models() -> None:
    own = stagecad.Effect("hook", "spring", force=lambda axis, p: p.k * axis.position)
    model = Model(["coulomb"], {"coulomb.force": "1 N"}) + own + Model(["viscous"])
    assert model.names == ("coulomb", "hook", "viscous") and model.declared == (own,)
    assert repr(model) == "Model(['coulomb', 'hook', 'viscous'], parameters={'coulomb.force': '1 N'})"


def test_a_short_text_and_a_page_for_notebooks(slide: Experiment) -> None:
    assert repr(slide) == "<Experiment 'slide': velocity-drive, model coulomb, viscous, 2 records of 2000 rows>"
    page = slide._repr_html_()
    assert "held out" in page and "friction_force" in page


def test_a_record_with_settings_is_held_out_by_its_name() -> None:
    records = {"a": slide_log(1), "b": Record(slide_log(2))}
    found = Experiment.from_dataframes(records, "velocity-drive", ["coulomb"], validate=["b"])
    assert [one.role for one in found.problem.records] == ["fit", "validate"]
