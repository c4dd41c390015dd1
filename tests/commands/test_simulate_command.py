"""`stagecad simulate`, its studies of the stage, records of an experiment's model, and `stagecad effects`."""

import csv
import json
import math
import tomllib
from pathlib import Path

import numpy as np
import pytest

from designcalc.checks.run import run_checks
from sim.friction_stage.studies import stage_drive
from sim.stage.studies.positioning import LOOPS, move_to
from stagecad.parameters.load import load_design
from stagecad.solids.assembly.built_machine import body_masses
from tests.experiments import replace_in, write_csv, write_rig
from tests.reference.tables import cases
from workbench.cli import run

ALL_MODELS = {"lugre", "lugre_undamped", "lugre_causal", "lugre_causal_as_run"}
MODELS = ("lugre", "lugre_causal")


@pytest.fixture(scope="module")
def everything(tmp_path_factory):
    folder = tmp_path_factory.mktemp("out")
    target = folder / "found.json"
    thesis = ["tip", "presliding", "hysteresis", "stick-slip", *(word for name in MODELS for word in ("--model", name))]
    assert run(["simulate", *thesis, "--out", str(folder), "--json", str(target)]) == 0
    return folder / "simulate", json.loads(target.read_text())


def test_document_data_and_figures_of_every_experiment_and_model(everything):
    document = everything[1]
    assert set(document) == {"tip", "presliding", "hysteresis", "stick-slip"}
    assert set(document["tip"]) == {"10um", "8.5um"}
    for phases in document["tip"].values():
        assert set(phases) == {"pi/1.5", "pi/2", "pi/4", "pi/8"}
        assert all(set(features) == {"semi_major", "semi_minor", "tilt"} for features in phases.values())
    for name in ("presliding", "hysteresis", "stick-slip"):
        assert set(document[name]) == set(MODELS)
    assert set(document["presliding"]["lugre"]) == {"position_max", "position_min", "position_end"}
    slip = {"first_slip", "period", "jump", "peak_velocity", "peak_force", "peak_spring_force"}
    assert set(document["stick-slip"]["lugre_causal"]) == slip
    cases = {f"w{w}_v0_{v}" for w in (25, 10, 1) for v in ("1.5mm_s", "0")}
    assert set(document["hysteresis"]["lugre"]) == cases
    for case, features in document["hysteresis"]["lugre"].items():
        assert (features["width_at_1mm_s"] is None) == case.endswith("_0") and features["peak_force"]["unit"] == "N"
    folder = everything[0]
    for name in ("tip", "presliding", "hysteresis", *(f"stick-slip_{model}" for model in MODELS)):
        picture = (folder / f"{name}.png").read_bytes()
        assert picture.startswith(b"\x89PNG") and len(picture) > 20_000
    with open(folder / "stick-slip_lugre.csv", newline="") as file:
        rows = list(csv.reader(file))
    assert rows[0][:4] == ["time [s]", "position [m]", "velocity [m/s]", "friction_force [N]"]
    assert len(rows) == 20_002 and float(rows[-1][0]) == 20.0
    spring, pull = rows[0].index("spring_force [N]"), rows[0].index("pull_position [m]")
    for row in rows[1::997]:
        values = [float(cell) for cell in row]
        assert values[spring] == pytest.approx(2.0 * (values[pull] - values[1]), abs=1e-9)
    assert not list(folder.glob("*tmp*"))


def test_the_tip_follows_the_design(command, tmp_path):
    height, spacing = 0.025, 0.050
    changed = ("--set", "actuator.tip_height=25 mm", "--set", "actuator.piezo_spacing=50 mm")
    document = command.json("simulate", "tip", "--no-figures", *changed, "--out", tmp_path)["tip"]
    for stroke, size in (("10um", 10e-6), ("8.5um", 8.5e-6)):
        for phase, lag in (("pi/1.5", math.pi / 1.5), ("pi/8", math.pi / 8)):
            # Sum and difference of two equal sines are in quadrature: the axes lie along x and y.
            along = 2.0 * size * math.sin(lag / 2.0) * height / spacing
            up = size * math.cos(lag / 2.0)
            found = document[stroke][phase]
            assert found["semi_major"]["value"] == pytest.approx(max(along, up), rel=1e-6)
            assert found["semi_minor"]["value"] == pytest.approx(min(along, up), rel=1e-6)
            assert found["tilt"]["value"] == pytest.approx(0.0 if along > up else math.pi / 2, abs=1e-6)


def test_mass_and_friction_may_be_set(command, tmp_path):
    words = ["simulate", "presliding", "--no-figures", "--format", "none", "--out", tmp_path]

    def reached(*more: str) -> float:
        return command.json(*words, "--model", "lugre", *more)["presliding"]["lugre"]["position_max"]["value"]

    first, every = reached(), command.json(*words)["presliding"]
    assert set(every) == ALL_MODELS and every["lugre"]["position_max"]["value"] == first
    # Slowly loaded bristles stretch half as far at twice the stiffness; the overshoot falls by more.
    assert 0.4 * first < reached("--set", "friction.bristle_stiffness=2e5 N/m") < 0.5 * first
    assert reached("--mass", "1000 g") == first != reached("--mass", "1.2 kg")
    assert list((tmp_path / "simulate").iterdir()) == []


def test_parquet_is_the_same_table(command, tmp_path):
    parquet = pytest.importorskip("pyarrow.parquet")
    command.json("simulate", "presliding", "--model", "lugre", "--no-figures", "--format", "both", "--out", tmp_path)
    table = parquet.read_table(tmp_path / "simulate" / "presliding_lugre.parquet")
    with open(tmp_path / "simulate" / "presliding_lugre.csv", newline="") as file:
        rows = list(csv.reader(file))
    assert table.column_names == rows[0]
    assert [float(cell) for cell in rows[500]] == [column[499].as_py() for column in table.columns]


def test_effects_lists_the_library_tells_of_one_and_checks_a_users_file(command, tmp_path):
    from sim.effects.catalogue import library

    listed = command("effects").out
    assert all(name in listed for name in library())
    told = command("effects", "stribeck").out
    for word in ("exp(", "velocity", "thesis Table 3", "stribeck:free_exponent", "0.001 m/s"):
        assert word in told
    document = command.json("effects", "viscous")
    assert document["parameters"][0]["name"] == "viscous.coefficient"
    assert document["parameters"][0]["default"] == {"value": 0.4, "unit": "N*s/m"}
    assert document["parameters"][0]["high"]["value"] is None  # unbounded
    assert [row["name"] for row in command.json("effects")][:3] == ["coulomb", "viscous", "stribeck"]
    path = tmp_path / "mine.py"
    path.write_text("from sim import Effect\neffect = Effect('mine', 'my own', force=lambda a, p: a.velocity**3)\n")
    assert "my own" in command("effects", "mine", "--custom", str(path)).out
    path.write_text("from sim import Effect\neffect = Effect('mine', 'my own', force=lambda a, p: a.speed)\n")
    assert "mine.py: effect 'mine': force" in command("effects", "mine", "--custom", str(path), status=2).err


@pytest.mark.slow
def test_steps_and_coupling_with_data_and_figures(tmp_path, command):
    chosen = ["--study", "steps", "--study", "coupling"]
    document = command.json("simulate", "stage", *chosen, "--out", tmp_path)["stage"]
    assert list(document) == ["steps", "coupling"]
    steps = document["steps"]
    assert steps["count"]["value"] == pytest.approx(2 * 20 / 46 * 17e-6 / 2**16)
    # The stage makes about what springs in series let through of a count, some tenths of a nanometre.
    expected = steps["static_ratio"]["value"] * steps["count"]["value"]
    assert steps["step_1_count"] == {"value": pytest.approx(expected, rel=0.05), "unit": "m"}
    coupling = document["coupling"]
    assert abs(coupling["linear_piezos_across"]["value"]) < 1e-3 * coupling["linear_piezos_travel"]["value"]
    assert coupling["as_designed_across"]["value"] > 10e-6
    folder = tmp_path / "simulate"
    assert {"stage_steps.png", "stage_coupling.png"} <= {path.name for path in folder.iterdir()}
    with open(folder / "stage_steps_10nm.csv", newline="") as file:
        rows = list(csv.DictReader(file))
    assert len(rows) > 1000 and float(rows[-1]["time [s]"]) == pytest.approx(0.26, abs=1e-3)


def test_a_sweep_over_the_tips_height(tmp_path, command):
    asked = ["--sweep", "actuator.tip_height=18mm:20mm:2", "--no-figures"]
    swept = command.json("simulate", "tip", *asked, "--out", tmp_path)["sweep"]
    assert [value["value"] for value in swept["values"]] == pytest.approx([0.018, 0.020])
    # x = -h (d2 - d1)/D: at a phase of pi/1.5 the ellipse lies along x, and its half axis goes with h.
    low, high = (point["tip"]["8.5um"]["pi/1.5"]["semi_major"]["value"] for point in swept["points"])
    assert high / low == pytest.approx(20 / 18, rel=1e-6)
    assert (tmp_path / "simulate" / "sweep.csv").read_text().splitlines()[0].startswith('"actuator.tip_height [m]"')


def test_the_studies_have_a_bending_stage_whose_preload_without_teeth_is_a_weight():
    """Protects what the studies take from the solids: modes of the stage, preload of the teeth, sway of the tip."""
    magnets = _drive().single.machine
    alone = _drive("teeth.fitted=false").single.machine
    # The pull of the magnets, not the preload that is required.
    assert magnets.stage.preload == pytest.approx(78.7, rel=2e-3) and magnets.stage.guide_stiffness > 0.0
    assert (alone.stage.preload, alone.stage.guide_stiffness) == (0.0, 0.0)
    # The irons and magnets are gone, and 3 N of ballast has come.
    assert alone.stage.mass == pytest.approx(magnets.stage.mass + 3.0 / magnets.gravity, abs=0.15)
    drive = _drive()
    for machine in (drive.single.machine, drive.triple.machine):
        assert machine.stage.bending.frequencies.size > 10
        assert machine.tip.sway_stiffness == pytest.approx(0.5e6, rel=0.02)
        assert machine.tip.sway_play == pytest.approx(32e-6, rel=0.02)


def _drive(*overrides):
    design = load_design(None, overrides)
    return stage_drive(design, body_masses(design))


@pytest.mark.slow
def test_a_simulated_move_settles_within_the_time_of_the_check():
    """From the end of the drive until every period is within the coarse resolution, with the filtered probe."""
    design = load_design(None, ())
    masses = body_masses(design)
    move = move_to(stage_drive(design, masses).single, LOOPS["interferometer_and_probe"])
    settled = move.within(design.requirements.resolution_coarse)
    assert move.taken_over is not None and settled is not None
    check = next(c for c in run_checks(design, masses) if c.name == "settling after a move")
    assert check.value is not None and 0.4 * check.value < settled - move.taken_over < check.value < check.limit
    # Half of the time of a move over the travel at full speed.
    assert check.limit == pytest.approx(0.5 * 0.2 / 0.2)


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
            assert run_of[part]["position"]["fit_percent"] > 99.8 and run_of[part]["position"]["rms"]["unit"] == "m"


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
