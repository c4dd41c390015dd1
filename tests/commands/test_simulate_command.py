"""`stagecad simulate` and `stagecad effects` as a user runs them."""

import csv
import json
import math

import pytest

from tests.reference.tables import cases
from workbench.cli import run

ALL_MODELS = {"lugre", "lugre_undamped", "lugre_causal", "lugre_causal_as_run"}
MODELS = ("lugre", "lugre_causal")


def simulated(capsys, tmp_path, *arguments: str) -> dict:
    assert run(["simulate", *arguments, "--out", str(tmp_path), "--json"]) == 0
    return json.loads(capsys.readouterr().out)


@pytest.fixture(scope="module")
def everything(tmp_path_factory):
    folder = tmp_path_factory.mktemp("out")
    target = folder / "found.json"
    thesis = ["tip", "presliding", "hysteresis", "stick-slip", *(word for name in MODELS for word in ("--model", name))]
    assert run(["simulate", *thesis, "--out", str(folder), "--json", str(target)]) == 0
    return folder / "simulate", json.loads(target.read_text())


def test_the_document_has_every_experiment_model_and_feature(everything):
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


def test_data_and_figures_are_written(everything):
    folder = everything[0]
    for name in ("tip", "presliding", "hysteresis", *(f"stick-slip_{model}" for model in MODELS)):
        picture = (folder / f"{name}.png").read_bytes()
        assert picture.startswith(b"\x89PNG")
        assert len(picture) > 20_000
    with open(folder / "stick-slip_lugre.csv", newline="") as file:
        rows = list(csv.reader(file))
    assert rows[0][:4] == ["time [s]", "position [m]", "velocity [m/s]", "friction_force [N]"]
    assert len(rows) == 20_002
    assert float(rows[-1][0]) == 20.0
    spring, pull = rows[0].index("spring_force [N]"), rows[0].index("pull_position [m]")
    for row in rows[1::997]:
        values = [float(cell) for cell in row]
        assert values[spring] == pytest.approx(2.0 * (values[pull] - values[1]), abs=1e-9)
    assert not list(folder.glob("*tmp*"))


def test_the_tip_follows_the_design(capsys, tmp_path):
    height, spacing = 0.025, 0.050
    document = simulated(
        capsys,
        tmp_path,
        "tip",
        "--no-figures",
        *("--set", "actuator.tip_height=25 mm", "--set", "actuator.piezo_spacing=50 mm"),
    )["tip"]
    for stroke, size in (("10um", 10e-6), ("8.5um", 8.5e-6)):
        for phase, lag in (("pi/1.5", math.pi / 1.5), ("pi/8", math.pi / 8)):
            # Sum and difference of two equal sines are in quadrature: the axes lie along x and y.
            along = 2.0 * size * math.sin(lag / 2.0) * height / spacing
            up = size * math.cos(lag / 2.0)
            found = document[stroke][phase]
            assert found["semi_major"]["value"] == pytest.approx(max(along, up), rel=1e-6)
            assert found["semi_minor"]["value"] == pytest.approx(min(along, up), rel=1e-6)
            assert found["tilt"]["value"] == pytest.approx(0.0 if along > up else math.pi / 2, abs=1e-6)


def test_mass_and_friction_may_be_set(capsys, tmp_path):
    options = ["presliding", "--model", "lugre", "--no-figures", "--format", "none"]
    first = simulated(capsys, tmp_path, *options)["presliding"]["lugre"]["position_max"]["value"]
    every = simulated(capsys, tmp_path, "presliding", "--no-figures", "--format", "none")["presliding"]
    assert set(every) == ALL_MODELS and every["lugre"]["position_max"]["value"] == first
    stiffer = simulated(capsys, tmp_path, *options, "--set", "friction.bristle_stiffness=2e5 N/m")
    # Slowly loaded bristles stretch half as far at twice the stiffness; the overshoot falls by more.
    assert 0.4 * first < stiffer["presliding"]["lugre"]["position_max"]["value"] < 0.5 * first
    assert (
        simulated(capsys, tmp_path, *options, "--mass", "1000 g")["presliding"]["lugre"]["position_max"]["value"]
        == first
    )
    heavy = simulated(capsys, tmp_path, *options, "--mass", "1.2 kg")["presliding"]["lugre"]["position_max"]["value"]
    assert heavy != first
    files = sorted(path.name for path in (tmp_path / "simulate").iterdir())
    assert files == []


def test_parquet_is_the_same_table(capsys, tmp_path):
    parquet = pytest.importorskip("pyarrow.parquet")
    simulated(capsys, tmp_path, "presliding", "--model", "lugre", "--no-figures", "--format", "both")
    table = parquet.read_table(tmp_path / "simulate" / "presliding_lugre.parquet")
    with open(tmp_path / "simulate" / "presliding_lugre.csv", newline="") as file:
        rows = list(csv.reader(file))
    assert table.column_names == rows[0]
    assert [float(cell) for cell in rows[500]] == [column[499].as_py() for column in table.columns]


@pytest.mark.parametrize(("arguments", "message"), cases("mistakes", "simulate"))
def test_a_mistake_ends_in_one_line_and_status_two(capsys, tmp_path, arguments, message):
    assert run(["simulate", *arguments, "--out", str(tmp_path)]) == 2
    printed = capsys.readouterr()
    assert message in printed.err
    assert len(printed.err.strip().splitlines()) == 1


def test_effects_lists_the_library_and_tells_of_one(capsys):
    from sim.effects.catalogue import library

    assert run(["effects"]) == 0
    listed = capsys.readouterr().out
    assert all(name in listed for name in library())
    assert run(["effects", "stribeck"]) == 0
    told = capsys.readouterr().out
    for word in ("exp(", "velocity", "thesis Table 3", "stribeck:free_exponent", "0.001 m/s"):
        assert word in told


def test_effects_as_json(capsys):
    assert run(["effects", "viscous", "--json"]) == 0
    document = json.loads(capsys.readouterr().out)
    assert document["parameters"][0]["name"] == "viscous.coefficient"
    assert document["parameters"][0]["default"] == {"value": 0.4, "unit": "N*s/m"}
    assert document["parameters"][0]["high"]["value"] is None  # unbounded
    assert run(["effects", "--json"]) == 0
    assert [row["name"] for row in json.loads(capsys.readouterr().out)][:3] == ["coulomb", "viscous", "stribeck"]


def test_effects_checks_a_users_file(capsys, tmp_path):
    path = tmp_path / "mine.py"
    path.write_text("from sim import Effect\neffect = Effect('mine', 'my own', force=lambda a, p: a.velocity**3)\n")
    assert run(["effects", "mine", "--custom", str(path)]) == 0
    assert "my own" in capsys.readouterr().out
    path.write_text("from sim import Effect\neffect = Effect('mine', 'my own', force=lambda a, p: a.speed)\n")
    assert run(["effects", "mine", "--custom", str(path)]) == 2
    assert "mine.py: effect 'mine': force" in capsys.readouterr().err


def test_an_unknown_effect_names_the_nearest(capsys):
    assert run(["effects", "stribek"]) == 2
    assert "did you mean 'stribeck'" in capsys.readouterr().err
