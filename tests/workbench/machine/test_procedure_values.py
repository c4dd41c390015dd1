"""The numbers handed to the assembly procedure, against formulas written out here and against the checks."""

from __future__ import annotations

import math
from pathlib import Path

import pytest

from designcalc.checks import Weighed, run_checks
from stagecad.parameters.load import load_design
from stagecad.parameters.mass_properties import MassProperties
from stagecad.solids.artefacts.store import Store
from workbench.machine.procedure_values import procedure_values, stored_values


def test_numbers_of_the_thesis_design() -> None:
    design = load_design()
    values = procedure_values(design)
    assert values.way_preload == pytest.approx(15 / (0.2 * 0.375 * 0.0254))
    assert values.bar_preload == pytest.approx(3 / (0.2 * 0.005))
    assert values.clamp_force == pytest.approx(10 / (0.2 * 0.375 * 0.0254))
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
    values = procedure_values(design)
    checks = {check.name: check for check in run_checks(design)}
    assert values.magnet_pull == pytest.approx(checks["attraction of the magnets as preload"].value)
    shift = checks["shift of the tip's height by clamping"].value
    assert values.clamp_squeeze + values.clamp_drop == pytest.approx(shift)
    assert values.run_in_wear == pytest.approx(checks["wear of the PTFE film by running in"].value)


def test_without_teeth_nothing_pulls() -> None:
    assert procedure_values(load_design(overrides=["teeth.fitted=false"])).magnet_pull is None


def test_kept_in_the_cache_until_what_they_were_worked_out_from_changes(tmp_path: Path) -> None:
    store, weighed = Store(tmp_path), estimate()
    weights = (weighed.moving, weighed.tip)
    first = stored_values(store, load_design(), *weights)
    assert first == procedure_values(load_design(), weighed)
    entries = sorted((tmp_path / "entries").iterdir())
    assert stored_values(store, load_design(overrides=["holder.well_diameter=19 mm"]), *weights) == first
    assert sorted((tmp_path / "entries").iterdir()) == entries
    other = stored_values(store, load_design(overrides=["screws.way.torque=16 N*m"]), *weights)
    assert other.way_preload == pytest.approx(16 / 15 * first.way_preload)


def estimate() -> Weighed:
    cube = ((-0.1, -0.1, 0.0), (0.1, 0.1, 0.1))
    still = ((0.01, 0.0, 0.0), (0.0, 0.01, 0.0), (0.0, 0.0, 0.01))
    return Weighed(
        MassProperties(8e-4, 2.0, (0, 0, 0.03), still, cube), MassProperties(1e-5, 0.03, (0, 0, 0), still, cube)
    )
