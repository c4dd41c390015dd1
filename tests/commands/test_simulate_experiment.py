"""`stagecad simulate EXPERIMENT`: records of the experiment's model that `compare` takes at once."""

import json
import tomllib
from pathlib import Path

import numpy as np
import pytest

from tests.experiments import replace_in, write_csv, write_rig
from tests.reference.tables import cases
from workbench.cli import run

TIME = 1e-3 * np.arange(6000)
PULL = 4e-3 * (np.sin(2.0 * np.pi * 0.6 * TIME) + 0.3 * np.sin(2.0 * np.pi * 2.1 * TIME))
MASS, STIFFNESS, LEVEL = 1.8, 5000.0, 1.4


@pytest.fixture
def rig(tmp_path: Path) -> Path:
    random = np.random.default_rng(2)
    position = 0.9 * PULL + 1e-7 * random.standard_normal(TIME.size)
    force = STIFFNESS * 0.1 * PULL + 0.01 * random.standard_normal(TIME.size)
    columns = {"time": TIME, "pull_position": PULL, "position": position, "spring_force": force}
    known = {"mass": f"{MASS} kg", "pull_stiffness": f"{STIFFNESS} N/m"}
    noise = {"position": 1e-7, "spring_force": 0.01}
    values = {"coulomb.force": f"{LEVEL} N", "viscous.coefficient": {"start": "9 N*s/m", "fixed": True}}
    given = {"known": known, "noise": noise, "parameters": values}
    return write_rig(tmp_path / "rig", "spring-pull", {"logged": columns}, ["coulomb", "viscous"], **given)


def _read(file: Path) -> dict[str, np.ndarray]:
    names = file.read_text().splitlines()[0].replace('"', "").split(",")
    return dict(zip(names, np.genfromtxt(file, delimiter=",", skip_header=1).T, strict=True))


def _simulated(rig: Path, *options: str) -> tuple[dict, Path]:
    target, out = rig.parent / "found.json", rig.parent / "out"
    assert run(["simulate", str(rig), "--out", str(out), "--json", str(target), *options]) == 0
    return json.loads(target.read_text()), out / "simulate" / "rig"


def _euler(pull: np.ndarray, times: int = 200) -> np.ndarray:
    """Position of a mass on a spring with rigid Coulomb and viscous friction, by semi-implicit Euler steps."""
    step = (TIME[1] - TIME[0]) / times
    x = v = 0.0
    out = np.zeros(pull.size)
    for k in range(1, pull.size):
        for part in range(times):
            end = pull[k - 1] + (pull[k] - pull[k - 1]) * (part + 0.5) / times
            free = v + step / MASS * (STIFFNESS * (end - x) - 9.0 * v)
            v = np.sign(free) * max(abs(free) - step / MASS * LEVEL, 0.0)
            x += step * v
        out[k] = x
    return out


def test_the_motion_is_that_of_a_mass_on_a_spring_with_dry_friction(rig: Path) -> None:
    write_csv(rig / "motion.csv", {"time": TIME[:1500], "pull_position [mm]": 1e3 * PULL[:1500]})
    document, folder = _simulated(rig, "--motion", str(rig / "motion.csv"), "--no-noise")
    found = _read(folder / "motion.csv")
    assert np.abs(found["position [m]"] - _euler(PULL[:1500])).max() < 2e-6
    stretch = found["pull_position [m]"] - found["position [m]"]
    assert found["spring_force [N]"] == pytest.approx(STIFFNESS * stretch, abs=1e-8)
    assert document["noise"] == {} and document["records"] == [{"name": "motion", "role": "fit", "rows": 1500}]


def test_noise_is_added_as_stated_and_repeats_with_its_seed(rig: Path) -> None:
    exact = _read(_simulated(rig, "--no-noise")[1] / "logged.csv")
    document, folder = _simulated(rig, "--seed", "4")
    first = _read(folder / "logged.csv")
    assert document["seed"] == 4 and document["noise"]["position"]["value"] == 1e-7
    for name, std in (("position [m]", 1e-7), ("spring_force [N]", 0.01)):
        assert np.std(first[name] - exact[name]) == pytest.approx(std, rel=0.05)
    assert np.array_equal(first["pull_position [m]"], exact["pull_position [m]"])
    again, other = (_read(_simulated(rig, "--seed", seed)[1] / "logged.csv")["position [m]"] for seed in ("4", "5"))
    assert np.array_equal(first["position [m]"], again) and not np.array_equal(first["position [m]"], other)


def test_given_values_are_used_as_they_are_and_others_fitted(rig: Path) -> None:
    document, folder = _simulated(rig)
    found = document["parameters"]
    assert found["coulomb.force"] == {"value": LEVEL, "unit": "N", "from": "given"}
    assert found["rig.mass"] == {"value": MASS, "unit": "kg", "from": "given"}
    written = tomllib.loads((folder / "experiment.toml").read_text())
    assert written["model"]["parameters"]["viscous.coefficient"] == {"start": "9 N*s/m", "fixed": True}
    (rig / "logged.csv").write_text((folder / "logged.csv").read_text())
    replace_in(rig / "experiment.toml", f'"coulomb.force" = "{LEVEL} N"\n', "")
    fitted = _simulated(rig)[0]["parameters"]
    assert fitted["coulomb.force"]["from"] == "fitted"
    assert fitted["coulomb.force"]["value"] == pytest.approx(LEVEL, rel=0.01)
    assert fitted["viscous.coefficient"] == {"value": 9.0, "unit": "N*s/m", "from": "given"}


def test_compare_takes_the_result_and_finds_noise(rig: Path, capsys) -> None:
    _, folder = _simulated(rig)
    target = rig.parent / "compare.json"
    assert run(["compare", str(folder), "--out", str(rig.parent / "out"), "--json", str(target)]) == 0
    shown = "Error of simulation"
    assert shown in next((rig.parent / "out").rglob("report.html")).read_text() and shown in capsys.readouterr().err
    document = json.loads(target.read_text())
    assert document["effects"] == ["coulomb", "viscous"]
    for channel in ("spring_force", "position"):
        assert document["before"]["fit"][channel]["over_noise"] == pytest.approx(1.0, abs=0.1)
    # With its own values a simulation repeats the record but for the noise and what follows from it.
    assert document["parameters"]["coulomb.force"]["value"] == pytest.approx(LEVEL, rel=0.01)
    for run_of in (document["free_run"], document["horizon"]["0.1 s"], document["horizon"]["1 s"]):
        for part in ("fit", "validate"):
            assert run_of[part]["position"]["fit_percent"] > 99.8
            assert run_of[part]["position"]["rms"]["unit"] == "m"


def test_quantisation_of_the_model_rounds_the_channel(rig: Path) -> None:
    step = 2e-6
    columns = _read(rig / "logged.csv")
    columns["position [m]"] = step * np.round(columns["position [m]"] / step)
    write_csv(rig / "logged.csv", columns)
    replace_in(rig / "experiment.toml", '"viscous"]', '"viscous", "sensor_quantisation@position"]')
    counts = _read(_simulated(rig)[1] / "logged.csv")["position [m]"] / step
    assert np.abs(counts - np.round(counts)).max() < 1e-6 and np.ptp(np.round(counts)) > 1000


@pytest.mark.parametrize(("options", "words"), cases("mistakes", "simulate_experiment"))
def test_bad_input_is_one_line(rig: Path, options: list[str], words: str, monkeypatch, command) -> None:
    monkeypatch.chdir(rig.parent)
    write_csv(rig.parent / "wrong.csv", {"time": TIME, "position": PULL})
    assert words in command.refused("simulate", "rig", *options)
    assert not (rig.parent / "build").exists()


def test_a_law_along_a_whole_record_is_refused_on_a_driven_mass(rig: Path, command) -> None:
    replace_in(rig / "experiment.toml", '"viscous"]', '"viscous", "frictional_lag:relaxation"]')
    assert "frictional_lag:relaxation" in command("simulate", rig, "--out", rig.parent / "out", status=2).err
    assert not (rig.parent / "out").exists()


def test_records_are_not_written_over_those_of_the_experiment(tmp_path: Path, rig: Path) -> None:
    place = tmp_path / "simulate" / "rig"
    place.parent.mkdir()
    rig.rename(place)
    before = {path: path.read_bytes() for path in place.iterdir()}
    assert run(["simulate", str(place), "--out", str(tmp_path)]) == 0
    assert {path: path.read_bytes() for path in before} == before
