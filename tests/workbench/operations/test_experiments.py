"""Experiments, rig kinds and effect files from Python: the same as from files, and one-line errors."""

import ast
import doctest
import hashlib
import importlib
import json
import pkgutil
import shutil
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pandas as pd
import pytest

import stagecad
import workbench.operations
from sim.effects.custom import load_custom
from stagecad import Experiment, InputError, Model, Record, Rig, RigKind
from sysid.estimation.misfit import misfit
from tests.process_state import python
from tests.reference.tables import cases
from tests.refusals import refused
from tests.sysid.slide import SIGN, VELOCITY
from tests.sysid.slide import slide as write_slide
from tests.workbench.operations.slide_log import slide_log

HEAVY = ("numpy", "pandas", "scipy", "matplotlib", "cadquery", "numba", "pyarrow", "click")
MODULES = [info.name for info in pkgutil.walk_packages(workbench.operations.__path__, "workbench.operations.")]


def test_experiments_in_memory_are_those_of_files_and_show_themselves(slide: Experiment, tmp_path) -> None:
    saved = slide.save(tmp_path / "rig")
    assert saved.in_files and not slide.in_files
    pd.testing.assert_frame_equal(saved.to_dataframe(), slide.to_dataframe())
    assert saved.model == slide.model and saved.rig == slide.rig
    refused("is there already", slide.save, tmp_path / "rig")
    assert repr(slide) == "<Experiment 'slide': velocity-drive, model coulomb, viscous, 2 records of 2000 rows>"
    page = slide._repr_html_()
    assert "held out" in page and "friction_force" in page


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
    listed = Experiment.from_dataframes([log, log], "velocity-drive", ["coulomb"])
    assert [spec.name for spec in listed.stated.records] == ["record_1", "record_2"]
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
        ({"model": None}, r"slide: model: is NoneType"),
        ({"rig": None}, r"slide: rig: is NoneType; a Rig, or the name of its kind"),
        ({"name": None}, r"name: is NoneType; a text is required"),
        ({"noise": "1 mm"}, r"slide: noise: is str; a mapping of texts by channel"),
        ({"records": [5]}, r"record_1: is int; a DataFrame"),
        ({"records": {"a": [1, 2]}}, r"a: is list; a DataFrame"),
        ({"records": {"a": slide_log(1) | {"friction_force [N]": ["x"] * 1000}}}, r"a: column .* holds text, such as"),
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


def test_models_and_experiments_show_themselves_and_hold_out_a_record_by_its_name() -> None:
    own = stagecad.Effect("hook", "spring", force=lambda axis, p: p.k * axis.position)
    model = Model(["coulomb"], {"coulomb.force": "1 N"}) + own + Model(["viscous"])
    assert model.names == ("coulomb", "hook", "viscous") and model.declared == (own,)
    assert repr(model) == "Model(['coulomb', 'hook', 'viscous'], parameters={'coulomb.force': '1 N'})"
    records = {"a": slide_log(1), "b": Record(slide_log(2))}
    found = Experiment.from_dataframes(records, "velocity-drive", ["coulomb"], validate=["b"])
    assert [one.role for one in found.problem.records] == ["fit", "validate"]


EXAMPLE = Path(__file__).parents[3] / "examples" / "own_rig"
COIL = RigKind(
    "force-drive",
    channels={"coil_current": "A"},
    known={"force_constant": "N/A", "flexure_stiffness": {"unit": "N/m", "default": "0 N/m"}},
    balance={"drive_force": "known.force_constant * channel.coil_current - known.flexure_stiffness * channel.position"},
)
KNOWN = {"force_constant": "8 N/A", "flexure_stiffness": "300 N/m", "mass": "0.5 kg"}


def _experiment(kind: RigKind = COIL) -> Experiment:
    """A slide of 0.5 kg on a flexure of 300 N/m with 0.4 N of friction: the current by Newton's law."""
    t = np.arange(1500) * 2e-3
    x, v, a = 0.02 * np.sin(5.0 * t), 0.1 * np.cos(5.0 * t), -0.5 * np.sin(5.0 * t)
    current = (0.5 * a + 300.0 * x + 0.4 * np.tanh(v / 1e-5)) / 8.0
    log = {"time [s]": t, "position [m]": x, "coil_current [A]": current}
    return Experiment.from_dataframes({"one": log}, Rig(kind, KNOWN), ["coulomb"], noise={"position": "1e-7 m"})


def test_an_own_kind_in_memory_is_fitted_saved_and_grown(tmp_path: Path) -> None:
    experiment = _experiment()
    assert stagecad.compare(experiment).parameters.loc["coulomb.force", "value"] == pytest.approx(0.4, rel=0.02)
    assert experiment.rig == Rig(COIL, KNOWN)
    grown = stagecad.add(experiment, "viscous").experiment
    assert grown.rig == experiment.rig and grown.stated.effects == ("coulomb", "viscous")
    saved = experiment.save(tmp_path / "rig")
    assert saved.rig == experiment.rig
    np.testing.assert_array_equal(saved.to_dataframe(), experiment.to_dataframe())


def test_the_object_says_what_the_declaration_file_says() -> None:
    from_file = Experiment.load(EXAMPLE).stated.records[0].balance
    own = _experiment().stated.records[0].balance
    balances = [{key: str(one) for key, one in kind.balance.items()} for kind in (from_file.kind, own.kind)]
    assert balances[0] == balances[1]
    assert list(from_file.kind.own) == list(own.kind.own) and from_file.kind.inputs == own.kind.inputs


@pytest.mark.parametrize(
    ("kind", "message"),
    [
        (RigKind("force-drive"), r"rig\.kind\.balance: is missing"),
        (RigKind("force-driv", COIL.channels, COIL.balance), r"rig\.kind\.base: .*did you mean 'force-drive'"),
        (RigKind("force-drive", {"coil_current": "Amp"}, COIL.balance, COIL.known), r"rig\.kind\.channels.*Amp"),
        (RigKind("force-drive", COIL.channels, COIL.balance), r"there is no 'known\.force_constant'"),
    ],
)
def test_a_fault_of_the_declaration_is_one_line(kind: RigKind, message: str) -> None:
    refused(message, _experiment, kind)


def test_a_rung_keeps_the_hash_of_the_declaration_file(tmp_path: Path) -> None:
    rig = Path(shutil.copytree(EXAMPLE, tmp_path / "rig"))
    stagecad.add(rig, "stribeck")
    digest = hashlib.sha256((rig / "voice_coil.toml").read_bytes()).hexdigest()
    for number in ("000", "001"):
        assert json.loads((rig / "ladder" / f"{number}.json").read_text())["rig"] == {"voice_coil.toml": digest}


def test_the_file_written_is_an_effect_that_can_be_fitted(tmp_path, command):
    file = tmp_path / "leaf_spring.py"
    printed = command("effects", "--write", file, "--json")
    assert json.loads(printed.out)["name"] == "leaf_spring" and 'custom = ["leaf_spring.py"]' in printed.err
    (effect,) = load_custom(file)
    axis: Any = SimpleNamespace(position=np.array([-0.01, 0.0, 0.02]))
    values: Any = SimpleNamespace(strength=2e4)
    np.testing.assert_allclose(effect.force(axis, values), [-0.02, 0.0, 0.16])


@pytest.mark.parametrize(("name", "wrong"), cases("mistakes", "effect_file"))
def test_a_file_that_would_be_no_effect_is_refused(tmp_path, command, name, wrong):
    (tmp_path / "there.py").write_text("kept")
    assert wrong in command.refused("effects", "--write", tmp_path / name)
    assert (tmp_path / "there.py").read_text() == "kept"
    assert [file.name for file in tmp_path.iterdir()] == ["there.py"]


def test_models_of_earlier_rungs_have_the_errors_that_the_ladder_states(tmp_path: Path) -> None:
    force = SIGN * (1.3 + 0.6 * (abs(VELOCITY) < 0.004)) + 20.0 * VELOCITY
    write_slide(tmp_path / "rig", force, "coulomb", held_out=True)
    stagecad.add(tmp_path / "rig", "viscous")
    found = stagecad.compare(tmp_path / "rig")
    assert list(found.earlier) == ["rung 0"]
    stated = stagecad.ladder(tmp_path / "rig").rungs[0]["before"]
    model, problem = found.earlier["rung 0"], found.problem
    for part, records in (("fit", problem.fit_records), ("validate", problem.validate_records)):
        computed = misfit(model, records)["friction_force"]
        assert computed.over_noise == pytest.approx(stated[part]["friction_force"]["over_noise"], rel=1e-6)
    of_present, of_former = found.maps_of(found.fitted.model), found.maps_of(model)
    shares = [{m.coordinate: m.share for m in maps} for maps in (found.computed.maps, of_present, of_former)]
    assert shares[0] == shares[1] != shares[2]


def test_the_public_interface_loads_nothing_heavy_and_its_stub_declares_it() -> None:
    program = f"import sys, stagecad; print([name for name in {HEAVY} if name in sys.modules])"
    assert python("-S", "-c", program).stdout.strip() == "[]"
    stub = Path(stagecad.__file__).with_suffix(".pyi")
    declared = {}
    for node in ast.parse(stub.read_text("utf-8")).body:
        if isinstance(node, ast.ImportFrom):
            declared |= {alias.asname: node.module for alias in node.names}
    assert declared == {name: getattr(stagecad, name).__module__ for name in stagecad.__all__}
    with pytest.raises(AttributeError, match="no attribute 'diagnosis'"):
        _ = stagecad.diagnosis  # pyright: ignore[reportAttributeAccessIssue]
    assert "diagnose" in dir(stagecad)


@pytest.mark.parametrize("name", stagecad.__all__)
def test_a_public_name_is_there(name: str) -> None:
    found = getattr(stagecad, name)
    assert found.__name__ == name and found.__doc__


def test_examples_of_docstrings() -> None:
    tried = {name: doctest.testmod(importlib.import_module(name)) for name in ("stagecad", *MODULES)}
    assert [name for name, found in tried.items() if found.failed] == []
    assert sum(found.attempted for found in tried.values()) >= 6
