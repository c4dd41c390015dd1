"""The calculated numbers of the assembly procedure, against formulas written out here and against the checks."""

import math
from types import SimpleNamespace

import pytest

from designcalc.checks.check import DesignInputs
from designcalc.checks.run import run_checks
from designcalc.friction_stage.physics.assembly_values import assembly_values
from stagecad.parameters.load import load_design


def test_numbers_of_the_thesis_design() -> None:
    design = load_design()
    values = SimpleNamespace(**assembly_values(DesignInputs(design)))
    assert values.way_preload == pytest.approx(15 / (0.2 * 0.375 * 0.0254))
    assert values.bar_preload == pytest.approx(3 / (0.2 * 0.005))
    assert values.clamp_force == pytest.approx(6 / (0.2 * 0.375 * 0.0254))
    # 8 threads to the inch, wedge 1:20, stroke 20 mm.
    assert values.lift_per_turn == pytest.approx(0.0254 / 8 / 20)
    assert values.lift_per_degree == pytest.approx(0.0254 / 8 / 20 / 360)
    assert values.adjustment == pytest.approx(0.5e-3)
    # Two strokes of +-8.5 um, a quarter of a turn apart: their mean swings by 8.5 um sqrt(2)/2 either way.
    assert values.ellipse_height == pytest.approx(8.5e-6 * math.sqrt(2), rel=1e-6)
    assert values.run_in_distance == pytest.approx(3000 * 2 * 0.2)
    assert values.run_in_time == pytest.approx(values.run_in_distance / 0.2)
    # Archard: depth grows with the root of the way, so half the film after (t / 2 / depth)^2 of the strokes.
    assert values.film_strokes == pytest.approx(3000 * (1e-6 / values.run_in_wear) ** 2)


def test_the_same_numbers_as_the_checks() -> None:
    design = load_design()
    values = SimpleNamespace(**assembly_values(DesignInputs(design)))
    checks = {check.name: check for check in run_checks(design)}
    assert values.magnet_pull == pytest.approx(checks["attraction of the magnets as preload"].value)
    shift = checks["shift of the tip's height by clamping"].value
    assert values.clamp_squeeze + values.clamp_drop == pytest.approx(shift)
    assert values.run_in_wear == pytest.approx(checks["wear of the PTFE film by running in"].value)


def test_without_teeth_nothing_pulls() -> None:
    assert assembly_values(DesignInputs(load_design(overrides=["teeth.fitted=false"])))["magnet_pull"] is None
