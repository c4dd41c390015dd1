"""Fitted values written back to the parameter file, and what the design says of a value as a prior of its fit."""

import tomllib
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import stagecad
from designcalc.checks.check import DesignInputs
from sysid.estimation.covariance import intervals
from sysid.estimation.reference_fit import fit_stated_model
from sysid.experiment.known import DesignValue
from sysid.prediction.problem import load_problem
from tests.experiments import write_rig
from tests.reference.tables import cases
from workbench.operations.design import Design
from workbench.operations.measurement.design_values import as_design_values

COULOMB, VISCOUS, STRIBECK, STRIBECK_VELOCITY = 1.3, 8.0, 0.6, 4e-3
NOISE = 0.01
STAGE = """# My own stage.
extends = "thesis"

[friction]
# Measured last year, by hand.
coulomb = {value = "1.2 N", origin = "assumed: a guess"}   # look again
stribeck_velocity = {value = "1 mm/s", origin = "thesis 4.2"}
"""


def slide(folder: Path, *effects: str, **parameters: Any) -> Path:
    t = np.arange(4000) * 1e-3
    v = 0.02 * np.sin(2 * np.pi * t) + 0.01 * np.sin(2 * np.pi * 3.1 * t)
    level = COULOMB + STRIBECK * np.exp(-((v / STRIBECK_VELOCITY) ** 2))
    force = level * np.sign(v) + VISCOUS * v + np.random.default_rng(3).normal(0, NOISE, t.size)
    log = {"time": t, "position": np.cumsum(v) * 1e-3, "velocity": v, "friction_force": force}
    stated = {key.replace("__", "."): value for key, value in parameters.items()}
    noise = {"friction_force": f"{NOISE} N"}
    return write_rig(folder / "slide", "velocity-drive", {"log": log}, effects, noise=noise, parameters=stated)


@pytest.fixture(autouse=True)
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)


@pytest.fixture
def rig(folder: None, tmp_path: Path) -> Path:
    Path("stage.toml").write_text(STAGE)
    return slide(tmp_path, "coulomb", "viscous", "stribeck")


def in_stage_file() -> dict[str, Any]:
    return tomllib.loads(Path("stage.toml").read_text())["friction"]


def test_a_value_goes_back_with_its_deviation_and_the_experiment_as_origin(rig: Path, command) -> None:
    document = command.json("add", rig, "--write-back", "friction.coulomb")
    value, _, rest = in_stage_file()["coulomb"]["value"].partition(" +- ")
    assert abs(float(value) - COULOMB) < 4.0 * float(rest.removesuffix(" N"))
    assert in_stage_file()["coulomb"]["origin"] == "measured: slide"
    written = document["written_back"]["friction.coulomb"]
    fitted = document["parameters"]["coulomb.force"]
    assert (written["value"], written["std"]) == (fitted["value"], fitted["std"])
    assert written["before"] == {"text": "1.2 N", "origin": "assumed: a guess"}
    text = Path("stage.toml").read_text()
    for kept in ("# My own stage.", "# Measured last year, by hand.", "# look again", 'value = "1 mm/s"'):
        assert kept in text


def test_after_an_effect_was_added_the_origin_names_the_rung(rig: Path, command) -> None:
    command("add", rig, "constant_bias", "--write-back", "friction.stribeck_velocity")
    entry = in_stage_file()["stribeck_velocity"]
    assert entry["origin"] == "measured: slide, rung 001" and entry["value"].endswith(" mm/s")
    assert float(entry["value"].partition(" ")[0]) == pytest.approx(1e3 * STRIBECK_VELOCITY, rel=0.05)


def test_a_sum_of_fitted_values_has_the_deviation_of_the_sum(rig: Path, command: Any) -> None:
    written = command.json("add", rig, "--write-back", "friction.breakaway")["written_back"]["friction.breakaway"]
    problem = load_problem(rig)
    found = intervals(fit_stated_model(problem).fitted, problem.fit_records)
    one, two = found.by_key["coulomb.force"], found.by_key["stribeck.force"]
    together = found.correlation[found.keys.index("coulomb.force"), found.keys.index("stribeck.force")]
    assert written["value"] == pytest.approx(one.value + two.value)
    assert written["std"] == pytest.approx(np.sqrt(one.std**2 + two.std**2 + 2.0 * together * one.std * two.std))


def test_without_a_file_of_ones_own_nothing_is_written_nor_added(rig: Path, command: Any) -> None:
    packaged = Path(stagecad.__file__).parent / "friction_stage" / "parameters" / "thesis.toml"
    before = packaged.read_bytes()
    Path("stage.toml").unlink()
    for params in ([], ["--params", str(packaged)]):
        printed = command("add", rig, "constant_bias", "--write-back", "friction.coulomb", *params, status=2)
        assert "the packaged design is not written to" in printed.err
    assert packaged.read_bytes() == before
    assert not (rig / "ladder").exists()


@pytest.mark.parametrize("wanted,said", cases("mistakes", "write_back"))
def test_what_cannot_be_written_is_said_in_one_line_and_the_file_stays(rig, command, wanted, said) -> None:
    assert said in command.refused("add", rig, "--write-back", "friction.coulomb", "--write-back", wanted)
    assert Path("stage.toml").read_text() == STAGE


def test_a_value_at_its_bound_is_not_written_and_stops_the_addition_before_its_rung(tmp_path, command):
    rig = slide(tmp_path, "coulomb", "viscous", viscous__coefficient={"low": "9 N*s/m", "start": "9.5 N*s/m"})
    Path("stage.toml").write_text(STAGE)
    before = {path: path.read_bytes() for path in tmp_path.rglob("*") if path.is_file()}
    for added in ([], ["stribeck"]):
        printed = command("add", rig, *added, "--write-back", "friction.viscous", status=2)
        assert "viscous.coefficient ended at its bound; nothing is written" in printed.err
        assert {path: path.read_bytes() for path in tmp_path.rglob("*") if path.is_file()} == before


def test_links_to_the_parameter_file_and_to_the_experiment_stay_links(rig: Path, command) -> None:
    (rig.parent / "store").mkdir()
    for path in (Path("stage.toml"), rig / "experiment.toml"):
        real = rig.parent / "store" / path.name
        real.write_text(STAGE if path.name == "stage.toml" else path.read_text())
        real.chmod(0o600)
        path.unlink(missing_ok=True)
        path.symlink_to(real)
    command("add", rig, "constant_bias", "--write-back", "friction.coulomb")
    for path, changed in ((Path("stage.toml"), "measured: slide"), (rig / "experiment.toml", "constant_bias")):
        assert path.is_symlink() and changed in path.resolve().read_text() and path.stat().st_mode & 0o777 == 0o600
    # Locks are removed, here and beside the file that the link names.
    assert not list(rig.parent.rglob(".*"))


def fitted_viscous(rig: Path, command: Any) -> dict[str, Any] | None:
    return command.json("compare", rig, "--no-figures")["parameters"].get("viscous.coefficient")


def test_the_designs_deviation_is_a_prior_of_the_fit(tmp_path: Path, command) -> None:
    rig = slide(tmp_path, "coulomb", "viscous", "stribeck", viscous__coefficient="design")
    design = '[friction]\nviscous = {value = "%s", origin = "assumed: a test"}\n'
    Path("stage.toml").write_text('extends = "thesis"\n' + design % "8.5 N*s/m")
    alone = fitted_viscous(rig, command)
    known = alone["std"]
    believed = alone["value"] + 2.0 * known
    Path("stage.toml").write_text('extends = "thesis"\n' + design % f"{believed} +- {known} N*s/m")
    both = fitted_viscous(rig, command)
    # Two measurements that are as good as each other: their mean, and a deviation less by the root of two.
    assert both["value"] == pytest.approx(alone["value"] + known, abs=0.3 * known)
    assert both["std"] == pytest.approx(known / np.sqrt(2.0), rel=0.2)


def test_the_designs_value_can_be_held_and_stays_in_the_file_after_add(tmp_path: Path, command) -> None:
    held = {"start": "design", "fixed": True}
    rig = slide(tmp_path, "coulomb", "viscous", viscous__coefficient=held, coulomb__force="design")
    assert fitted_viscous(rig, command) is None
    command("add", rig, "stribeck")
    settings_now = tomllib.loads((rig / "experiment.toml").read_text())["model"]["parameters"]
    assert settings_now["coulomb.force"] == "design" and settings_now["viscous.coefficient"] == held


def test_what_the_design_does_not_say_is_named(tmp_path: Path, command) -> None:
    error = command("compare", slide(tmp_path, "coulomb", "constant_bias", constant_bias__force="design"), status=2).err
    assert "experiment.toml: model.parameters.constant_bias.force = 'design': the design has no such number" in error


def test_a_designs_mass_is_known_to_a_percent(monkeypatch: pytest.MonkeyPatch) -> None:
    inputs = "workbench.operations.measurement.design_values._inputs"
    monkeypatch.setattr(inputs, lambda design: DesignInputs(design.values))
    told = as_design_values(Design(None, ("payload.mass=0.5 kg",)))("mass")
    mass = 0.23 * 0.27 * 0.012 * 2700 + 0.5
    assert told == DesignValue(pytest.approx(mass), pytest.approx(0.01 * mass))


def test_the_breakaway_force_above_the_coulomb_force_is_the_stribeck_force(tmp_path: Path) -> None:
    path = tmp_path / "stage.toml"
    path.write_text(
        'extends = "thesis"\n[friction]\ncoulomb = {value = "1.1 +- 0.3 N", origin = "assumed: a test"}\n'
        'breakaway = {value = "1.6 +- 0.4 N", origin = "assumed: a test"}\n'
    )
    told = as_design_values(Design(path))
    assert told("stribeck.force").value == pytest.approx(0.5) and told("stribeck.force").std == pytest.approx(0.5)
    assert told("frictional_lag.delay") == DesignValue(pytest.approx(6e-3), None, 3e-3, 9e-3)
