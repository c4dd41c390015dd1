"""Simulations of drawn machines, against what the spread must be, and the same wherever they are worked out."""

import csv
import json
import math

import numpy as np
import pytest


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


@pytest.mark.slow
def test_a_cluster_gives_what_the_local_cores_give_and_another_seed_something_else(command, tmp_path, cluster):
    words = (
        *("presliding", "tip", "--model", "lugre", "--draws", "20", "--no-figures", "--format", "none"),
        *("--set", "friction.coulomb=1 +- 0.01 N"),
    )
    here = command.json("simulate", *words, "--out", tmp_path)
    assert command.json("simulate", *words, "--scheduler", cluster, "--out", tmp_path) == here
    other = command.json("simulate", *words, "--seed", "2", "--out", tmp_path)
    one, two = (found["features"]["presliding"]["lugre"]["position_max"] for found in (here, other))
    assert one["std"] != two["std"] and one["value"] == two["value"]


def test_a_drawn_machine_that_does_not_stand_is_counted_and_named(command, tmp_path):
    words = ("presliding", "--model", "lugre", "--draws", "8", "--no-figures", "--format", "none")
    drawn = ("--set", "friction.breakaway=1.05 +- 0.05 N", "--out", tmp_path, "--json")
    out, err = command("simulate", *words, *drawn)
    refused = json.loads(out)["refused"]
    assert 0 < len(refused) < 8 and all("friction.breakaway" in one["reason"] for one in refused)
    assert f"{len(refused)} of 8 samples are invalid designs" in err
