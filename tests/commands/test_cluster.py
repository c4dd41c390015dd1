"""Refits, sweeps, tolerances and drawn machines on a dask cluster and on the local cores come out the same, and the
spread of drawn machines is what it must be."""

import csv
import json
import math
import shlex
from functools import partial
from pathlib import Path

import numpy as np
import pytest

from stagecad.parameters.errors import InputError
from stagecad.parameters.load import load_design
from stagecad.processes import parallel_map
from tests.experiments import replace_in

EXAMPLE = Path(__file__).parents[2] / "examples" / "own_effect"


@pytest.mark.slow
def test_refits_on_a_cluster_are_those_of_the_local_cores(command, tmp_path, cluster):
    """With an effect whose file the workers do not have."""
    for name in ("bellows.py", "fit.csv", "validate.csv", "experiment.toml"):
        (tmp_path / name).write_bytes((EXAMPLE / name).read_bytes())
    replace_in(tmp_path / "experiment.toml", '"viscous"]', '"viscous", "bellows"]')
    words = ["compare", tmp_path, "--trust", "--bootstrap", "24", "--out", tmp_path / "out"]
    printed = command(*words, "--json")
    here = json.loads(printed.out)
    assert "Intervals of 24 refits" in printed.err
    assert command.json(*words, "--no-figures", "--scheduler", cluster)["bootstrap"] == here["bootstrap"]
    assert set(here["bootstrap"]["parameters"]) == set(here["parameters"])
    for key, one in here["bootstrap"]["parameters"].items():
        linear = here["parameters"][key]
        assert (one["value"], one["unit"]) == (linear["value"], linear["unit"])
        assert one["std"] == pytest.approx(linear["std"], rel=0.6)
    assert next((tmp_path / "out").glob("*/compare_bootstrap.png")).read_bytes().startswith(b"\x89PNG")


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (["--scheduler", "tcp://127.0.0.1:9"], "--scheduler: only --bootstrap has many independent runs"),
        (["--bootstrap", "3"], "--bootstrap"),
        (["--bootstrap", "20", "--scheduler", "tcp://127.0.0.1:9"], "no cluster answers there"),
    ],
)
def test_a_mistake_ends_in_status_two(command, tmp_path, words, message):
    printed = command("compare", EXAMPLE, "--trust", *words, "--no-figures", "--out", tmp_path, status=2)
    assert message in printed.err.splitlines()[-1]


@pytest.mark.slow
def test_a_sweep_weighs_the_solids_of_every_point_and_a_cluster_does_the_same(command, tmp_path, cluster):
    """Heavier by the plate's added volume less what pockets and holes, which grow with it, take from it."""
    words = ("check", "--out", tmp_path, "--sweep", 'stage.thickness="11 mm":"12 mm":2')
    there = command.json(*words, "--scheduler", cluster, status=1)["sweep"]
    here = command.json(*words, status=1)["sweep"]
    assert there == here
    preload = here["checks"]["preload against the required share of the load"]
    thin, thick = (v / (1 + margin) / 0.1 / 9.80665 for v, margin in zip(preload["value"], preload["margin"]))
    plate = 2700 * 0.230 * 0.270 * 1e-3
    assert 0.93 * plate < thick - thin < 0.999 * plate


STUDIES = {
    "tolerances": ("check --no-solids --tolerance --samples 1000 --set teeth.fitted=false", 1),
    "sweep of the tip": ("simulate tip --sweep actuator.tip_height=18mm:20mm:3 --no-figures", 0),
    "sweep of the stage": ("simulate stage --study steps --sweep drive.friction=0.2:0.3:2 --no-figures", 0),
    "drawn machines": (
        "simulate presliding tip --model lugre --draws 20 --no-figures --format none "
        "--set 'friction.coulomb=1 +- 0.01 N'",
        0,
    ),
}
"""Commands with their exit status."""


@pytest.mark.parametrize("name", [n if n.endswith("tip") else pytest.param(n, marks=pytest.mark.slow) for n in STUDIES])
def test_a_cluster_gives_what_the_local_cores_give(command, tmp_path, cluster, name):
    words, status = STUDIES[name]
    told = [*shlex.split(words), "--out", tmp_path]
    there, here = (command.json(*told, *at, status=status) for at in (["--scheduler", cluster], []))
    assert there == here
    if name == "tolerances":
        assert len(here["tolerance"]["matter_most"]) == len(here["tolerance"]["could_be_loosened"]) == 3
    if name == "drawn machines":
        other = command.json(*told, "--seed", "2")
        one, two = (found["features"]["presliding"]["lugre"]["position_max"] for found in (here, other))
        assert one["std"] != two["std"] and one["value"] == two["value"]


def test_a_mistake_on_a_worker_and_a_missing_cluster_are_said_in_one_line(cluster, command, tmp_path):
    job = partial(load_design, None, rules=False)
    with pytest.raises(InputError, match=r"stage\.lenght"):
        parallel_map(job, [("stage.length=240 mm",), ("stage.lenght=240 mm",)], scheduler=cluster)
    words = ("check", "--no-solids", "--out", tmp_path, "--sweep", "tip.nose_radius=10 mm:30 mm:3")
    printed = command(*words, "--scheduler", "tcp://127.0.0.1:9", status=2)
    assert "--scheduler tcp://127.0.0.1:9" in printed.err.splitlines()[-1]


@pytest.mark.slow
def test_the_tips_ellipse_spreads_as_its_two_lengths_say(command, tmp_path):
    """semi-major = 2 s sin(phase/2) h/D: relative deviations add by squares, of an even spread reach/sqrt 3."""
    document = command.json("simulate", "tip", "--draws", "300", "--no-figures", "--out", tmp_path)
    assert set(document["drawn"]) == {"actuator.piezo_spacing", "actuator.tip_height"}
    reach = {key: one["plus_minus"] / one["value"] for key, one in document["drawn"].items()}
    relative = math.sqrt(sum(part**2 / 3.0 for part in reach.values()))
    found = document["features"]["tip"]["10um"]["pi/1.5"]["semi_major"]
    assert found["std"] / found["value"] == pytest.approx(relative, rel=0.1)
    assert found["follows"]["key"] == "actuator.tip_height"
    assert found["value"] * (1 - sum(reach.values())) < found["low"] < found["high"]
    assert found["high"] < found["value"] * (1 + sum(reach.values()))
    assert document["features"]["tip"]["10um"]["pi/1.5"]["semi_minor"]["std"] < 1e-18


@pytest.mark.slow
def test_the_first_slip_of_each_machine_comes_when_the_spring_reaches_its_own_breakaway(command, tmp_path):
    words = ("stick-slip", "--model", "lugre_causal", "--draws", "12", "--set", "friction.breakaway=1.5 +- 0.1 N")
    document = command.json("simulate", *words, "--out", tmp_path)
    with open(tmp_path / "simulate" / "draws.csv", newline="") as file:
        names, *rows = csv.reader(file)
    table = dict(zip(names, np.array(rows, dtype=float).T))
    slip = table["stick-slip.lugre_causal.first_slip [s]"]
    breakaway = table["friction.breakaway [N]"]
    assert np.ptp(breakaway) > 0.15
    # A spring of 2 N/m pulled at 0.1 m/s; bristles creep before, and 0.02 m/s is passed after.
    assert slip == pytest.approx(breakaway / 0.2, rel=0.01)
    found = document["features"]["stick-slip"]["lugre_causal"]["first_slip"]
    assert found["std"] == pytest.approx(float(np.std(slip, ddof=1)), rel=1e-9)
    assert found["follows"] == {"key": "friction.breakaway", "rank_correlation": pytest.approx(1.0)}
    for picture in ("draws_stick-slip.png", "draws_stick-slip_features.png"):
        assert (tmp_path / "simulate" / picture).read_bytes().startswith(b"\x89PNG")


def test_a_drawn_machine_that_does_not_stand_is_counted_and_named(command, tmp_path):
    words = ("presliding", "--model", "lugre", "--draws", "8", "--no-figures", "--format", "none")
    drawn = ("--set", "friction.breakaway=1.05 +- 0.05 N", "--out", tmp_path, "--json")
    out, err = command("simulate", *words, *drawn)
    refused = json.loads(out)["refused"]
    assert 0 < len(refused) < 8 and all("friction.breakaway" in one["reason"] for one in refused)
    assert f"{len(refused)} of 8 samples are invalid designs" in err
