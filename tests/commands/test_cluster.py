"""Refits, sweeps and tolerance studies on a dask cluster and on the local cores come out the same."""

import json
from functools import partial
from pathlib import Path

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
    there = command.json(*words, "--no-figures", "--scheduler", cluster)
    assert there["bootstrap"] == here["bootstrap"]
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


@pytest.mark.slow
def test_tolerances_come_out_the_same_on_a_cluster(command, tmp_path, cluster):
    study = ("--tolerance", "--samples", "1000", "--set", "teeth.fitted=false")
    words = ("check", "--no-solids", "--out", tmp_path, *study)
    there, here = (command.json(*words, *at, status=1)["tolerance"] for at in (["--scheduler", cluster], []))
    assert there == here and len(here["matter_most"]) == len(here["could_be_loosened"]) == 3


def test_a_mistake_on_a_worker_and_a_missing_cluster_are_said_in_one_line(cluster, command, tmp_path):
    job = partial(load_design, None, rules=False)
    with pytest.raises(InputError, match=r"stage\.lenght"):
        parallel_map(job, [("stage.length=240 mm",), ("stage.lenght=240 mm",)], scheduler=cluster)
    words = ("check", "--no-solids", "--out", tmp_path, "--sweep", "tip.nose_radius=10 mm:30 mm:3")
    printed = command(*words, "--scheduler", "tcp://127.0.0.1:9", status=2)
    assert "--scheduler tcp://127.0.0.1:9" in printed.err.splitlines()[-1]
