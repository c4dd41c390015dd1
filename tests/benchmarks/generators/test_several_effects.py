"""The generator of several effects: its forces balance, and a diagnosis finds three of them at once."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from benchmarks.generators.several_effects import Machine, draw_law, iwan, make_cases, run
from sysid.diagnose import diagnose

MACHINE = Machine(True, False, 0.1, 0.1, 10.0, 20.0, 5.0, 500.0, 2.0)


def test_force_on_the_driven_mass_is_what_acts_on_it() -> None:
    m = MACHINE
    m.laws = {"cable_spring": draw_law(np.random.default_rng(1), m, "cable_spring")}
    row = run(3, m, {"cable_spring": 50.0})
    acceleration = np.gradient(row["velocity"], row["time"])
    rest = row["force"] - m.mass * acceleration - m.level * row["side"] - m.drag * row["velocity"]
    rest = rest - 50.0 * m.laws["cable_spring"](row)
    away = np.convolve(np.abs(np.diff(row["side"], prepend=row["side"][0])), np.ones(9), "same") == 0.0
    # Of first order in the time step: half of it times the largest slope of the force.
    assert np.sqrt(np.mean(rest[away] ** 2)) < 2e-3 * m.level


def test_elements_slide_after_twice_their_stretch_from_a_turning_point() -> None:
    path = np.concatenate([np.linspace(0.0, 2e-3, 200), np.linspace(2e-3, -1e-3, 300)])
    force = iwan(path, 1e-3)
    assert force[199] == pytest.approx(1.0) and force[-1] == pytest.approx(-1.0)
    # On the way back each element has turned by its own stretch when the curve passes through zero.
    assert -1e-3 < path[200:][np.argmin(np.abs(force[200:]))] - 2e-3 < -1e-4


@pytest.mark.slow
def test_chain_of_three_is_established_at_once(tmp_path: Path) -> None:
    make_cases(tmp_path, 1, 14, only=8)
    key = json.loads((tmp_path / "key.json").read_text("utf-8"))["case008"]
    assert key["hidden"] == ["viscous", "cable_spring", "load_dependent_friction"]
    found = diagnose(tmp_path / "case008")
    assert {entry.name for entry in found.ledger.established} == set(key["hidden"])
