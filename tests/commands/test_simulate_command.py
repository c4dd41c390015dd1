"""`stagecad simulate`, its studies of the stage, and `stagecad effects` as a user runs them."""

import csv
import json
import math

import pytest

from designcalc.checks.run import run_checks
from sim.friction_stage.studies import stage_drive
from sim.stage.studies.positioning import LOOPS, move_to
from stagecad.parameters.load import load_design
from stagecad.solids.assembly.built_machine import body_masses
from workbench.cli import run

ALL_MODELS = {"lugre", "lugre_undamped", "lugre_causal", "lugre_causal_as_run"}
MODELS = ("lugre", "lugre_causal")
OF_STAGE = ["stage", "--study", "steps", "--sweep", "drive.friction=0.2:0.3:2"]
OF_TIP = ["tip", "--sweep", "actuator.tip_height=18mm:20mm:3"]


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
        assert (features["width_at_1mm_s"] is None) == case.endswith("_0")
        assert features["peak_force"]["unit"] == "N"
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
        document = command.json(*words, "--model", "lugre", *more)
        return document["presliding"]["lugre"]["position_max"]["value"]

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
    header = (tmp_path / "simulate" / "sweep.csv").read_text().splitlines()[0]
    assert header.startswith('"actuator.tip_height [m]"')


@pytest.mark.parametrize("asked", [OF_TIP, pytest.param(OF_STAGE, marks=pytest.mark.slow)], ids=["tip", "stage"])
def test_a_sweep_on_a_cluster_gives_what_the_local_cores_give(asked, tmp_path, cluster, command):
    words = ["simulate", *asked, "--no-figures", "--out", tmp_path]
    local, of_cluster = (command.json(*words, *where)["sweep"] for where in ([], ["--scheduler", cluster]))
    assert of_cluster == local


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
